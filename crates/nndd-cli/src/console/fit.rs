//! Lines no wider than the terminal.

/// The column at which a broken line continues.
const INDENT: usize = 13;

/// Breaks lines that are too wide at blanks; what has no blank stays whole.
pub(super) fn fit(text: &str, width: Option<usize>) -> String {
    let Some(width) = width else { return text.to_owned() };
    let mut fitted = String::with_capacity(text.len());
    for line in text.lines() {
        let mut rest = line.to_owned();
        while let Some(place) = break_place(&rest, width) {
            fitted += rest[..place].trim_end();
            fitted.push('\n');
            let indent = if width >= 3 * INDENT { INDENT } else { 4 };
            rest = " ".repeat(indent) + rest[place..].trim_start();
        }
        fitted += &rest;
        fitted.push('\n');
    }
    fitted
}

/// The last blank at which a line that is too wide can be broken, behind its indentation; the first one beyond the width
/// if a word is too long.
fn break_place(line: &str, width: usize) -> Option<usize> {
    if line.chars().count() <= width {
        return None;
    }
    let indent = line.len() - line.trim_start().len();
    let end = line.char_indices().nth(width).map_or(line.len(), |(place, _)| place);
    let blanks = line.match_indices(' ').map(|(place, _)| place).filter(|place| *place > indent);
    let (within, beyond): (Vec<usize>, Vec<usize>) = blanks.partition(|place| *place <= end);
    // Between two groups of words rather than within one.
    let between = |place: &&usize| line[..**place].ends_with([';', ' ']) && 2 * **place > end;
    within.iter().rfind(between).or(within.last()).or(beyond.first()).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_at_blanks() {
        let text = "nndd 0.1.0   case.toml\n  solver     nndd theta 0.4, weights half, acceleration none, lambda on first, path\n";
        assert_eq!(fit(text, None), text);
        assert_eq!(fit(text, Some(200)), text);
        for width in [20, 30, 40, 60, 80] {
            let fitted = fit(text, Some(width));
            assert!(fitted.lines().all(|line| line.chars().count() <= width), "{width}\n{fitted}");
            let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
            assert_eq!(words(&fitted), words(text));
        }
        // A word wider than the terminal stays whole.
        assert_eq!(fit("  a veryverylongword b", Some(10)), "  a\n    veryverylongword\n    b\n");
    }
}
