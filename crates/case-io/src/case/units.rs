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

/// Lengths in metres, and forces in newtons, whose names are known.
const LENGTHS: [(&str, f64); 8] = [
    ("m", 1.0),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("um", 1e-6),
    ("µm", 1e-6),
    ("km", 1e3),
    ("in", 0.0254),
    ("ft", 0.3048),
];
const FORCES: [(&str, f64); 8] = [
    ("N", 1.0),
    ("mN", 1e-3),
    ("kN", 1e3),
    ("MN", 1e6),
    ("GN", 1e9),
    ("lbf", 4.448),
    ("kip", 4448.0),
    ("kgf", 9.807),
];

/// Moduli of solids, Pa: diamond has 1.1e12, and the softest gels a few.
const SOLIDS: [f64; 2] = [1.0, 2e12];
/// Moduli that are usual for what is computed, Pa.
const USUAL: [f64; 2] = [1e6, 2e12];
/// Stresses that a modulus may be written in by mistake, Pa.
const WRITTEN: [(&str, f64); 4] = [("Pa", 1.0), ("MPa", 1e6), ("GPa", 1e9), ("psi", 6895.0)];

impl Units {
    /// Says what is wrong with a modulus that no solid has in these units, with the likely mistake; `None` if a solid may have it, or the names of the
    /// units are not known.
    pub(super) fn impossible_modulus(&self, modulus: f64) -> Option<String> {
        let known =
            |all: &[(&str, f64)], name: &str| all.iter().find(|(of, _)| *of == name).map(|(_, size)| *size);
        let (length, force) = (known(&LENGTHS, &self.length)?, known(&FORCES, &self.force)?);
        let unit = force / (length * length);
        let within = |value: f64, [least, most]: [f64; 2]| value >= least && value <= most;
        if within(modulus * unit, SOLIDS) {
            return None;
        }
        let mistake = WRITTEN.iter().find(|(_, size)| within(modulus * size, USUAL));
        let likely = mistake.map_or_else(
            || "the units of length and force may be others".to_owned(),
            |(name, size)| format!("if it is in {name}, write {:e}", modulus * size / unit),
        );
        Some(format!(
            "a modulus of {modulus:e} is {:.1e} Pa in the units of this case, {} of {} and {}, and no solid has that; {likely}",
            modulus * unit,
            self.stress(),
            self.force,
            self.length
        ))
    }

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
