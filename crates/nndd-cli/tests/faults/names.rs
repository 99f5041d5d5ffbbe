//! Names of every kind in everything that is written: JSON, XML, HTML, CSV and TOML hold them, and none commands a terminal.

use super::*;
use serde_json::Value;

/// Names with dangerous characters: U+202E and U+2066 turn the direction of a text, U+007F and U+0085 are controls, U+FFFE is not allowed in XML.
const HOSTILE: [&str; 8] = [
    "a\u{202e}b",
    "a\u{2066}b",
    "a\u{7f}\u{85}b",
    "a\u{fffe}\u{ffff}",
    "a&b<c>\"d\"'e'",
    "\\",
    "\"",
    "a\u{1}\n\t\r b,c;\\u{1b}",
];

/// A case in which every name that may be anything is the given one: of materials, contacts, conditions; and the title.
///
/// * `body`: a name of the first body, which also names files.
fn case(name: &str, body: &str) -> String {
    let [name, body] = [name, body].map(|text| Value::from(text).to_string().replace('\u{7f}', "\\u007f"));
    format!(
        "schema = 1\ntitle = {name}\n[materials.{name}]\nyoung = 6.0\npoisson = 0.4\n\
         [[body]]\nname = {body}\nmaterial = {name}\n\
         generator = {{ kind = \"block\", origin = [-2.0, 0.0], size = [4.0, 2.0], cells = [8, 4] }}\n\
         [[body.displacement]]\non = \"left\"\nux = 0.0\n\
         [[body.traction]]\nname = {name}\non = \"top\"\npressure = 0.1\n\
         [[contact]]\nname = \"table\"\nbodies = [{body}]\nsurfaces = [\"bottom\"]\n\
         obstacle = {{ kind = \"plane\", point = [0.0, 0.0], normal = [0.0, 1.0] }}\n\
         [[contact]]\nname = \"side\"\nbodies = [{body}]\nsurfaces = [\"right\"]\n\
         obstacle = {{ kind = \"plane\", point = [2.0, 0.0], normal = [-1.0, 0.0] }}\n\
         [[step]]\nfactors = {{ {name} = 0.5 }}\n[[step]]\nfactors = {{ {name} = 1.0 }}\n"
    )
}

/// Says whether nothing in a text commands a terminal or turns its direction.
fn harmless(text: &str) -> bool {
    let turns = ['\u{202e}', '\u{2066}', '\u{fffe}', '\u{ffff}'];
    text.chars().all(|c| (!c.is_control() || c == '\n' || c == '\t') && !turns.contains(&c))
}

/// Checks that a text is well-formed XML, and returns the values of its attributes as a reader gets them.
fn attributes(xml: &str) -> Vec<String> {
    let held = |c: char| matches!(c, '\t' | '\n' | '\r' | '\u{20}'..='\u{fffd}' | '\u{10000}'..);
    assert!(xml.chars().all(held), "a character that XML cannot hold");
    let mut values = Vec::new();
    let mut open: Vec<&str> = Vec::new();
    let mut rest = xml;
    while let Some((text, behind)) = rest.split_once('<') {
        read(text);
        let (tag, next) = behind.split_once('>').unwrap();
        rest = next;
        if tag.starts_with('?') {
            continue;
        }
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
            continue;
        }
        let inner = tag.strip_suffix('/').unwrap_or(tag);
        let (name, mut rest) = inner.split_once(' ').unwrap_or((inner, ""));
        if !tag.ends_with('/') {
            open.push(name);
        }
        while !rest.trim().is_empty() {
            let (_, value) = rest.split_once("=\"").unwrap();
            let (value, next) = value.split_once('"').unwrap();
            values.push(read(value));
            rest = next;
        }
    }
    assert!(open.is_empty() && rest.trim().is_empty(), "{open:?} {rest}");
    values
}

/// Replaces the references of XML.
fn read(text: &str) -> String {
    let mut parts = text.split('&');
    let mut out = parts.next().unwrap().replace(['\n', '\t'], " ");
    for part in parts {
        let (name, rest) = part.split_once(';').unwrap_or_else(|| panic!("a lone & in {text:?}"));
        out += match name {
            "amp" => "&",
            "lt" => "<",
            "gt" => ">",
            "quot" => "\"",
            "#9" => "\t",
            "#10" => "\n",
            "#13" => "\r",
            other => panic!("an unknown reference {other}"),
        };
        out += &rest.replace(['\n', '\t'], " ");
    }
    out
}

/// Every line is JSON; the objects.
fn objects(output: &[u8]) -> Vec<Value> {
    let text = std::str::from_utf8(output).unwrap();
    assert!(harmless(text), "{text:?}");
    assert!(!text.is_empty());
    text.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))).collect()
}

#[test]
fn json_on_the_console_is_json_whatever_the_names() {
    let temp = tempfile::tempdir().unwrap();
    let file = temp.path().join("case.toml");
    for name in HOSTILE {
        // Slashes, quotes and controls cannot name a file.
        let body: String = name.chars().filter(|c| !c.is_control() && !"\\\"<>".contains(*c)).collect();
        let body = format!("{body}&");
        std::fs::write(&file, case(name, &body)).unwrap();
        let run = |args: &[&str]| nndd(temp.path()).args(args).arg("case.toml").output().unwrap();
        let checked = run(&["check", "--format", "json"]);
        assert_eq!(checked.status.code(), Some(0), "{}", said(&checked));
        let found = &objects(&checked.stdout)[0];
        assert_eq!(found["bodies"][0]["name"], body.as_str());
        assert!(harmless(&said(&run(&["check"]))));
        // A failure that tells the name.
        let wrong = case(name, &body).replace("\"right\"", &Value::from(body.as_str()).to_string());
        std::fs::write(temp.path().join("wrong.toml"), wrong).unwrap();
        let failed = nndd(temp.path()).args(["solve", "--format", "json", "wrong.toml"]).output().unwrap();
        assert_eq!(failed.status.code(), Some(3));
        assert_eq!(objects(&failed.stdout)[0]["event"], "failed");
        assert!(harmless(std::str::from_utf8(&failed.stderr).unwrap()));
    }
}

#[test]
fn every_file_holds_any_name() {
    let temp = tempfile::tempdir().unwrap();
    let file = temp.path().join("case.toml");
    // All names at once, and the characters that the name of a body may have.
    let all = HOSTILE.concat();
    let body = "a\u{202e}\u{2066}\u{fffe}&';b,c";
    std::fs::write(&file, case(&all, body)).unwrap();
    let out = temp.path().join("out");
    let output = solve(&file, &out, &["--format", "json"]);
    assert_eq!(output.status.code(), Some(0), "{}", said(&output));
    let events = objects(&output.stdout);
    assert_eq!(events.last().unwrap()["event"], "finished");
    let report: Value = serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap();
    assert_eq!(
        (&report["bodies"][0]["name"], &report["case"]["title"]),
        (&body.into(), &all.as_str().into())
    );
    let mut seen = std::collections::BTreeMap::new();
    for path in files_below(&out) {
        let bytes = std::fs::read(&path).unwrap();
        let kind = path.extension().unwrap().to_string_lossy().into_owned();
        *seen.entry(kind.clone()).or_insert(0) += 1;
        let text = String::from_utf8_lossy(&bytes).into_owned();
        match kind.as_str() {
            "svg" => drop(attributes(&text)),
            "pvd" => {
                // Of what XML cannot hold there is the code.
                let name = body.replace('\u{fffe}', "\\u{fffe}");
                assert!(attributes(&text).contains(&name), "{text}");
            }
            "vtu" => {
                let (head, _) = text.split_once("<AppendedData").unwrap();
                attributes(&format!("{head}</VTKFile>"));
            }
            "json" | "series" => drop(serde_json::from_slice::<Value>(&bytes).unwrap()),
            "html" => {
                assert!(harmless(&text));
                // The settings on the page are a case with the same names.
                let (_, settings) = text.split_once("<h2>Settings</h2>\n<pre>").unwrap();
                let settings = settings.split("</pre>").next().unwrap();
                let lines = settings.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">");
                std::fs::write(temp.path().join("again.toml"), lines.replace("&amp;", "&")).unwrap();
                let again =
                    nndd(temp.path()).args(["check", "--format", "json", "again.toml"]).output().unwrap();
                assert_eq!(again.status.code(), Some(0), "{}", said(&again));
                assert_eq!(objects(&again.stdout)[0]["bodies"][0]["name"], body);
            }
            "csv" => {
                let rows = text.lines().map(|line| line.split(',').count());
                assert!(text.contains('"') || rows.collect::<std::collections::BTreeSet<_>>().len() == 1);
            }
            other => panic!("{other} is not known here"),
        }
    }
    let kinds: Vec<&str> = seen.keys().map(String::as_str).collect();
    assert_eq!(kinds, ["csv", "html", "json", "pvd", "series", "svg", "vtu"], "{seen:?}");
}

#[test]
fn the_mesh_of_any_name_is_json() {
    let temp = tempfile::tempdir().unwrap();
    let mesh = std::fs::read_to_string(cases().join("bad/meshes/sound.msh")).unwrap();
    for name in HOSTILE.into_iter().filter(|name| !name.contains(['"', '\n'])) {
        std::fs::write(temp.path().join("a.msh"), mesh.replace("upper.top", name)).unwrap();
        let output = nndd(temp.path()).args(["mesh", "--format", "json", "a.msh"]).output().unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", said(&output));
        let groups = &objects(&output.stdout)[0]["groups"];
        // Controls are not read into names.
        let name = name.replace(char::is_control, "\u{fffd}");
        assert!(groups.as_array().unwrap().iter().any(|group| group["name"] == name.as_str()), "{groups}");
    }
}
