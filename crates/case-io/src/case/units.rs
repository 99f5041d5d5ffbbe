//! `[units]`: what the lengths and forces of a case are measured in. They label results and change no number.

use super::Dimension;
use crate::case_file::Reader;
use crate::diagnostic::excerpt;
use serde::Serialize;

/// The longest name of a unit.
const LONGEST: usize = 8;

/// Stresses that have a name of their own: length, force, force over length squared.
const STRESSES: [(&str, &str, &str); 8] = [
    ("m", "N", "Pa"),
    ("m", "kN", "kPa"),
    ("m", "MN", "MPa"),
    ("m", "GN", "GPa"),
    ("mm", "N", "MPa"),
    ("mm", "kN", "GPa"),
    ("in", "lbf", "psi"),
    ("in", "kip", "ksi"),
];

/// `[units]`: names of the units of length and force; all others follow.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Units {
    /// Of lengths, such as `mm`.
    pub length: String,
    /// Of forces, such as `N`.
    pub force: String,
}

impl Units {
    /// Names the unit of stresses, force over length squared: `MPa` of N and mm.
    pub fn stress(&self) -> String {
        let Self { length, force } = self;
        let known = STRESSES.iter().find(|(l, f, _)| l == length && f == force);
        known.map_or_else(|| format!("{force}/{length}²"), |(.., name)| (*name).to_owned())
    }

    /// Names the unit of areas: `mm²`.
    pub fn area(&self) -> String {
        format!("{}²", self.length)
    }

    /// Names the unit of forces per unit thickness: `N/mm`. Energies per unit thickness are forces.
    pub fn line_force(&self) -> String {
        format!("{}/{}", self.force, self.length)
    }

    /// Names the unit of energy norms, the root of an energy: `√N` per unit thickness, `√(N·mm)`.
    pub fn energy_norm<S: Dimension>(&self) -> String {
        let energy = S::moment_unit(self);
        if energy.chars().all(char::is_alphanumeric) {
            format!("√{energy}")
        } else {
            format!("√({energy})")
        }
    }

    /// Names the unit of moments: `N·mm`.
    pub fn moment(&self) -> String {
        format!("{}·{}", self.force, self.length)
    }
}

/// Reads `[units]`.
pub(super) fn units(reader: Option<Reader<'_>>) -> Option<Units> {
    let mut r = reader?;
    r.require(&["length", "force"]);
    let [length, force] = [("length", "\"mm\""), ("force", "\"N\"")].map(|(key, example)| {
        let name = r.string(key)?;
        let plain = |c: char| !c.is_control() && !c.is_whitespace() && !"\"'\\<>&".contains(c);
        if name.is_empty() || name.chars().count() > LONGEST || !name.chars().all(plain) {
            let message = format!("`units.{key}` is {}", excerpt(&name));
            let expected = format!("the name of a unit, at most {LONGEST} letters without blanks");
            r.refuse(key, message, &expected, &format!("write `{key} = {example}`"));
            return None;
        }
        Some(name)
    });
    r.finish();
    Some(Units { length: length?, force: force? })
}
