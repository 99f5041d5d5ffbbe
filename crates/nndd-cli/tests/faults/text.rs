//! Case files whose bytes are odd.

use super::*;

fn paper() -> String {
    std::fs::read_to_string(cases().join("paper.toml")).unwrap()
}

#[test]
fn byte_order_mark_and_crlf_are_accepted() {
    let temp = tempfile::tempdir().unwrap();
    let case = temp.path().join("dos.toml");
    std::fs::write(&case, format!("\u{FEFF}{}", paper().replace('\n', "\r\n"))).unwrap();
    let out = temp.path().join("out");
    let output = solve(&case, &out, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let plain = temp.path().join("plain");
    assert_eq!(solve(&cases().join("paper.toml"), &plain, &[]).status.code(), Some(0));
    assert_eq!(numbers(&out), numbers(&plain));
}

#[test]
fn a_byte_that_is_no_text_has_a_place() {
    let temp = tempfile::tempdir().unwrap();
    let case = temp.path().join("latin.toml");
    std::fs::write(&case, b"schema = 1\ntitle = \"M\xFCller\"\n").unwrap();
    let output = solve(&case, &temp.path().join("out"), &[]);
    assert_eq!(output.status.code(), Some(3));
    let text = said(&output);
    assert!(text.contains("latin.toml:2:11") && text.contains("0xFC") && text.contains("UTF-8"), "{text}");
}

#[test]
fn ten_megabytes_of_an_expression_are_refused() {
    let temp = tempfile::tempdir().unwrap();
    let case = temp.path().join("long.toml");
    let long = format!("\"0{}\"", "+0".repeat(5_000_000));
    let text = paper().replace("vector = [0.0, 30.0]", &format!("vector = [0.0, {long}]"));
    assert!(text.len() > 10_000_000);
    std::fs::write(&case, text).unwrap();
    let output = solve(&case, &temp.path().join("out"), &[]);
    assert_eq!(output.status.code(), Some(3));
    let text = said(&output);
    assert!(
        text.contains("long.toml:") && text.contains("at most 1000"),
        "{}",
        &text[..text.len().min(2000)]
    );
    assert!(text.len() < 10_000, "{} bytes are shown", text.len());
    // Nor does a long name or a long word flood the console.
    let long = "ä".repeat(1_000_000);
    for (from, to) in
        [("theta", &long), ("\"nndd\"", &format!("\"{long}\"")), ("\"left\"", &format!("\"{long}\""))]
    {
        assert!(paper().contains(from));
        std::fs::write(&case, paper().replacen(from, to, 1)).unwrap();
        let output = solve(&case, &temp.path().join("out"), &[]);
        assert_eq!(output.status.code(), Some(3));
        let text = said(&output);
        assert!(
            text.contains("long.toml:") && text.len() < 100_000,
            "{from}: {} bytes are shown",
            text.len()
        );
    }
}

#[test]
fn an_empty_file_is_said_to_be_empty() {
    let temp = tempfile::tempdir().unwrap();
    let case = temp.path().join("empty.toml");
    std::fs::write(&case, "").unwrap();
    let output = solve(&case, &temp.path().join("out"), &[]);
    assert_eq!(output.status.code(), Some(3));
    assert!(said(&output).contains("the case file is empty"));
}

#[test]
fn names_of_groups_may_be_anything() {
    // A group of curves and one of surfaces share a name with blanks, quotes and umlauts, among 10 000 others.
    let temp = tempfile::tempdir().unwrap();
    let mesh = std::fs::read_to_string(cases().join("bad/meshes/sound.msh")).unwrap();
    let name = "die 'obere' Größe 上";
    let mut names = format!("10003\n1 1 \"{name}\"\n1 2 \"upper.top\"\n2 1 \"{name}\"\n");
    names.extend((0..10_000).map(|k| format!("1 {} \"group {k}\"\n", k + 10)));
    let sound = "3\n1 1 \"upper.bottom\"\n1 2 \"upper.top\"\n2 1 \"upper\"\n";
    assert!(mesh.contains(sound));
    std::fs::write(temp.path().join("sound.msh"), mesh.replace(sound, &names)).unwrap();
    let case = std::fs::read_to_string(cases().join("bad/mesh_unknown_side.toml")).unwrap();
    let case = case.replace("meshes/sound.msh", "sound.msh").replace("upper.topp", "upper.top");
    let case =
        case.replace("upper.bottom", name).replace("region = \"upper\"", &format!("region = \"{name}\""));
    std::fs::write(
        temp.path().join("names.toml"),
        case.replace("\"steel\"", "\"Stahl: S 235 ä\"")
            .replace("[materials.steel]", "[materials.\"Stahl: S 235 ä\"]"),
    )
    .unwrap();
    let output = solve(&temp.path().join("names.toml"), &temp.path().join("out"), &[]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
}

#[test]
fn names_of_bodies_name_files() {
    let temp = tempfile::tempdir().unwrap();
    let case = temp.path().join("names.toml");
    std::fs::write(&case, paper().replace("\"upper\"", "\"obere Größe 上\"")).unwrap();
    let out = temp.path().join("out");
    let output = solve(&case, &out, &[]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    assert_eq!(report(&out).bodies[0].name, "obere Größe 上");
    assert!(whole_files(&out) > 8);
    // One that leads elsewhere is refused at its place.
    std::fs::write(&case, paper().replace("\"upper\"", "\"../upper\"")).unwrap();
    let output = solve(&case, &temp.path().join("other"), &[]);
    assert_eq!(output.status.code(), Some(3));
    assert!(said(&output).contains("cannot name a file"));
}

#[test]
fn two_bodies_do_not_write_the_same_file() {
    let temp = tempfile::tempdir().unwrap();
    let case = temp.path().join("names.toml");
    for [a, b] in [["part 2#", "part 2+"], ["a b", "A_B"], ["Größe 1", "größe_1"]] {
        let text =
            paper().replace("\"upper\"", &format!("\"{a}\"")).replace("\"lower\"", &format!("\"{b}\""));
        std::fs::write(&case, text).unwrap();
        let output = solve(&case, &temp.path().join("out"), &[]);
        let text = said(&output);
        assert_eq!(output.status.code(), Some(3), "{a}, {b}: {text}");
        assert!(text.contains(a) && text.contains(b) && text.contains("the same file"), "{text}");
    }
}

#[test]
fn no_text_of_a_file_commands_the_terminal() {
    let temp = tempfile::tempdir().unwrap();
    let case = temp.path().join("coloured.toml");
    let titled = |title: &str| {
        let lines = paper()
            .lines()
            .map(|line| if line.starts_with("title") { title } else { line }.to_owned() + "\n")
            .collect::<String>();
        std::fs::write(&case, lines).unwrap();
        said(&solve(&case, &temp.path().join("out"), &["--force"]))
    };
    // As an escape it is TOML, as a raw byte it is not.
    for title in ["title = \"\\u001b[31mred\"", "title = \"\u{1b}[31mred\""] {
        let text = titled(title);
        assert!(text.contains("[31mred") && !text.contains('\u{1b}'), "{text:?}");
    }
    // Nor does a title make a line of its own, on the console or the page.
    let text = titled("title = \"a\\nconverged: b\\u0000\\u202e\"");
    assert!(text.contains("  a\\nconverged: b\\u{0}\\u{202e}\n"), "{text:?}");
    let page = std::fs::read_to_string(temp.path().join("out/report.html")).unwrap();
    assert!(page.contains("<h1>a\\nconverged: b\\u{0}\\u{202e}</h1>"));
    let figure = std::fs::read_to_string(temp.path().join("out/figures/convergence.svg")).unwrap();
    for text in [page, figure] {
        assert!(text.chars().all(|c| !c.is_control() || c == '\n') && !text.contains('\u{202e}'));
    }
}
