//! The view of solids that turns.

use super::escape;
use serde_json::Value;
use std::fmt::Write as _;

/// The script of the view that turns.
const VIEWER: &str = include_str!("viewer.js");
/// Its controls, which the style sheet hides until the script runs.
const CONTROLS: &str = include_str!("viewer.html");

/// Writes a view that turns, for browsers with script and WebGL; the others show the picture behind it.
pub(super) fn write(page: &mut String, data: &Value) {
    // No text of the data ends the element.
    let text = data.to_string().replace('<', "\\u003c");
    let note = data["note"].as_str().unwrap_or_default();
    let controls = CONTROLS.replace("{note}", &escape(note));
    let _ = write!(
        page,
        "{controls}<script type=\"application/json\" id=\"skin\">{text}</script>\n<script>{VIEWER}</script>\n"
    );
}
