//! Data lines: fields between commas, numbers, types of elements.

use crate::mesh_file::{ElementKind, MeshFileError};
use crate::numeral;
use std::borrow::Cow;

/// A fault of a data line; the caller adds its place.
pub(super) struct Fault {
    found: String,
    expected: &'static str,
    help: Option<String>,
}

impl Fault {
    pub(super) fn new(found: String, expected: &'static str) -> Self {
        Self { found, expected, help: None }
    }

    /// Adds what was probably meant.
    fn advised(self, help: Option<String>) -> Self {
        Self { help, ..self }
    }

    /// Puts the words into an error that knows the place.
    pub(super) fn at(self, mut error: MeshFileError) -> MeshFileError {
        error.found = self.found;
        error.help = self.help;
        error.expected(self.expected)
    }
}

/// One data line.
pub(super) struct DataLine<'a> {
    line: &'a [u8],
    continues: bool,
}

impl<'a> DataLine<'a> {
    pub(super) fn new(line: &'a [u8]) -> Self {
        match line.strip_suffix(b",") {
            Some(line) => Self { line, continues: true },
            None => Self { line, continues: false },
        }
    }

    /// Says whether the line ends with a comma: its data continue in the next one.
    pub(super) fn continues(&self) -> bool {
        self.continues
    }

    /// Splits at the commas.
    pub(super) fn fields(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        self.line.split(|b| *b == b',').map(<[u8]>::trim_ascii)
    }

    /// Reads the first number of the line.
    pub(super) fn number(&self) -> Result<u64, Fault> {
        let first = self.fields().next().unwrap_or_default();
        number(first).ok_or_else(|| Fault::new(format!("found {}", shown(first)), "a whole number"))
    }

    /// Appends the whole numbers of the line.
    pub(super) fn numbers(&self, into: &mut Vec<u64>) -> Result<(), Fault> {
        for field in self.fields() {
            match number(field) {
                Some(number) => into.push(number),
                None => return Err(Fault::new(format!("found {}", shown(field)), "a whole number")),
            }
        }
        Ok(())
    }

    /// Reads number and coordinates of a node; missing coordinates are zero.
    pub(super) fn node(&self) -> Result<(u64, [f64; 3]), Fault> {
        let mut fields = self.fields();
        let first = fields.next().unwrap_or_default();
        let Some(number) = number(first) else {
            let semicolons = first.contains(&b';');
            let help =
                semicolons.then(|| "separate numbers by commas, and write decimals with a point".to_owned());
            return Err(Fault::new(format!("found {}", shown(first)), "the number of a node").advised(help));
        };
        self.refuse_decimal_commas(number)?;
        let mut point = [0.0; 3];
        let mut given = 0;
        for (k, field) in fields.enumerate() {
            // Some decks give normals or temperatures behind the coordinates.
            let Some(x) = point.get_mut(k) else { break };
            given = k + 1;
            if field.is_empty() {
                continue;
            }
            *x = real(field).ok_or_else(|| {
                let fault = Fault::new(format!("node {number}: found {}", shown(field)), "a coordinate");
                fault.advised(numeral::advice(&text(field)))
            })?;
        }
        if given < 2 {
            let found = format!("node {number} has {given} coordinates");
            return Err(Fault::new(found, "number, x, y"));
        }
        Ok((number, point))
    }

    /// Refuses a line such as `1, 0,5, 1,5`, which would be read as x = 0, y = 5.
    ///
    /// Two or three decimals with commas are four or six whole numbers. Six are allowed if the last three are a normal
    /// of length 1, or zero: some decks have one behind the coordinates.
    fn refuse_decimal_commas(&self, number: u64) -> Result<(), Fault> {
        let fields: Vec<&[u8]> = self.fields().skip(1).collect();
        let whole = |field: &&[u8]| self::number(field.strip_prefix(b"-").unwrap_or(field));
        let Some(values) = fields.iter().map(whole).collect::<Option<Vec<u64>>>() else { return Ok(()) };
        let meant = match values[..] {
            [_, _, _, _] => true,
            [_, _, _, a, b, c] => a.max(b).max(c) > 1 || a + b + c > 1,
            _ => false,
        };
        if !meant {
            return Ok(());
        }
        let found = format!("node {number} has {} whole numbers for coordinates", values.len());
        let help = format!("decimal comma: write {}.{}", text(fields[0]), text(fields[1]));
        Err(Fault::new(found, "number, x, y and perhaps z, with decimal points").advised(Some(help)))
    }
}

/// Reads a whole number.
pub(super) fn number(field: &[u8]) -> Option<u64> {
    if field.is_empty() || !field.iter().all(u8::is_ascii_digit) {
        return None;
    }
    std::str::from_utf8(field).ok()?.parse().ok()
}

/// Reads a number, also with Fortran's exponent `D`.
pub(super) fn real(field: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(field).ok()?;
    text.parse().ok().or_else(|| text.replace(['d', 'D'], "e").parse().ok())
}

/// Returns a field as text.
pub(super) fn text(field: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(field.trim_ascii())
}

/// Quotes a field in a message.
pub(super) fn shown(field: &[u8]) -> String {
    let text = String::from_utf8_lossy(&field[..field.len().min(40)]);
    format!("`{}`", text.escape_debug())
}

/// Lists numbers for a message.
pub(super) fn listed(numbers: &[u64]) -> String {
    let mut words: Vec<String> = numbers.iter().take(5).map(u64::to_string).collect();
    if numbers.len() > words.len() {
        words.push("…".to_owned());
    }
    if words.is_empty() { "no numbers".to_owned() } else { words.join(", ") }
}

/// Splits a line at the commas that are not in quotes.
pub(super) fn split_quoted(line: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut start, mut quoted) = (0, false);
    for (k, byte) in line.bytes().enumerate() {
        match byte {
            b'"' => quoted = !quoted,
            b',' if !quoted => {
                parts.push(&line[start..k]);
                start = k + 1;
            }
            _ => {}
        }
    }
    parts.push(&line[start..]);
    parts
}

/// Takes blanks and quotes away.
pub(super) fn unquoted(text: &str) -> &str {
    let text = text.trim();
    text.strip_prefix('"').and_then(|t| t.strip_suffix('"')).unwrap_or(text)
}

/// Says whether elements of a type have two faces that fill the plane beside their edges.
pub(super) fn is_shell(name: &str) -> bool {
    ["S", "US", "M3D"].iter().any(|family| name.starts_with(family))
}

/// Says whether elements of a type, in upper case, are springs, dashpots, masses, couplings or networks: part of a model, not of its mesh.
pub(super) fn is_no_cell(name: &str) -> bool {
    let families = ["SPRING", "DASHPOT", "MASS", "ROTARYI", "GAP", "DCOUP", "CONN"];
    name == "D" || families.iter().any(|family| name.starts_with(family))
}

/// Says what to do about elements of a type that is not read.
pub(super) fn advice(name: &str) -> &'static str {
    let begins = |families: &[&str]| families.iter().any(|family| name.starts_with(family));
    if begins(&["CAX", "CGAX", "MAX", "SAX", "ACAX", "DCAX", "COHAX"]) {
        "these are axisymmetric elements: if a plane problem is meant, write CPE in place of CAX"
    } else if begins(&["C3D", "COH3D", "SC"]) {
        "write C3D in front of the number of nodes, as in C3D8, if the elements are those of a solid"
    } else {
        "write a plane type with as many nodes in its place, or take these elements out of the deck"
    }
}

/// Finds the kind of an element type such as `CPS4R`, in upper case: a family, the number of nodes, and letters for
/// the formulation, which does not matter here.
pub(super) fn kind(name: &str) -> Option<ElementKind> {
    let lines = [
        ("T2D2", ElementKind::Edge2),
        ("T3D2", ElementKind::Edge2),
        ("B21", ElementKind::Edge2),
        ("B31", ElementKind::Edge2),
        ("T2D3", ElementKind::Edge3),
        ("T3D3", ElementKind::Edge3),
        ("B22", ElementKind::Edge3),
        ("B32", ElementKind::Edge3),
    ];
    // Beams may have letters for the formulation (`B31H`).
    let bare = if name.starts_with('B') { name.trim_end_matches(char::is_alphabetic) } else { name };
    if let Some((_, kind)) = lines.iter().find(|(line, _)| *line == bare) {
        return Some(*kind);
    }
    // Elements of heat conduction, acoustics and fluids have the same nodes.
    let volumes = ["C3D", "DC3D", "AC3D", "F3D"];
    let (volume, rest) = match volumes.iter().find_map(|family| name.strip_prefix(family)) {
        Some(rest) => (true, rest),
        None => {
            (false, ["CPS", "CPE", "M3D", "US", "S"].iter().find_map(|family| name.strip_prefix(family))?)
        }
    };
    // Letters behind the number of nodes tell the formulation.
    let digits = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    let (nodes, letters) = rest.split_at(digits);
    if !letters.chars().all(|c| c.is_ascii_alphabetic()) {
        return None;
    }
    if volume {
        return Some(match nodes {
            "4" => ElementKind::Tetra4,
            "5" => ElementKind::Pyramid5,
            "6" => ElementKind::Prism6,
            "8" => ElementKind::Hexa8,
            "10" => ElementKind::Tetra10,
            "13" => ElementKind::Pyramid13,
            "15" => ElementKind::Prism15,
            "20" => ElementKind::Hexa20,
            "27" => ElementKind::Hexa27,
            _ => return None,
        });
    }
    Some(match nodes {
        "3" => ElementKind::Triangle3,
        "4" => ElementKind::Quad4,
        "6" => ElementKind::Triangle6,
        "8" => ElementKind::Quad8,
        "9" => ElementKind::Quad9,
        _ => return None,
    })
}
