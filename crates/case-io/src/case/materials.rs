//! `[materials.NAME]`: isotropic, orthotropic, or a plane stiffness.

use crate::case_file::{NodeValue, Reader};
use crate::diagnostic::{Diagnostic, code, significant};
use fem_core::geometry::shown;
use fem_core::material::{Hypothesis, LinearElastic, MaterialError, Orthotropic};
use serde_json::{Value as Json, json};

/// `[materials.NAME]`: a linear elastic material.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Material {
    /// Its name.
    pub name: String,
    /// Its constants.
    pub law: MaterialLaw,
}

/// The constants of a material.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MaterialLaw {
    /// `young`, `poisson`.
    Isotropic {
        /// Young's modulus, Pa.
        young: f64,
        /// Poisson's ratio.
        poisson: f64,
    },
    /// `young_1`, `young_2`, `poisson_12`, `shear`, `angle` and, for plane strain, `young_3`, `poisson_13`, `poisson_23`.
    /// Its angle is in degrees here.
    Orthotropic(Orthotropic),
    /// `stiffness`: the matrix of the plane problem by rows, Pa.
    Stiffness([[f64; 3]; 3]),
}

const ISOTROPIC: [&str; 2] = ["young", "poisson"];
const ORTHOTROPIC: [&str; 8] =
    ["young_1", "young_2", "young_3", "poisson_12", "poisson_13", "poisson_23", "shear", "angle"];
const KINDS: &str = "either `young` and `poisson`, or `young_1`, `young_2`, `poisson_12`, `shear` and `angle`, or `stiffness`";

impl Material {
    /// Makes fem-core's material.
    ///
    /// # Errors
    /// Constants that fem-core refuses; never for materials that were read from a case file.
    pub fn elastic(&self, hypothesis: Hypothesis) -> Result<LinearElastic, MaterialError> {
        match &self.law {
            MaterialLaw::Isotropic { young, poisson } => {
                LinearElastic::isotropic(*young, *poisson, hypothesis)
            }
            MaterialLaw::Orthotropic(constants) => {
                let angle = constants.angle.to_radians();
                LinearElastic::orthotropic(&Orthotropic { angle, ..*constants }, hypothesis)
            }
            MaterialLaw::Stiffness(rows) => LinearElastic::from_stiffness(*rows, hypothesis),
        }
    }

    /// Returns the largest modulus, Pa: a measure of its stiffness.
    pub(crate) fn largest_modulus(&self) -> f64 {
        match &self.law {
            MaterialLaw::Isotropic { young, .. } => *young,
            MaterialLaw::Orthotropic(c) => c.young_1.max(c.young_2),
            MaterialLaw::Stiffness(rows) => rows[0][0].max(rows[1][1]),
        }
    }

    /// Describes the material in a few words: `E 2000  nu 0.3`.
    pub fn summary(&self) -> String {
        match &self.law {
            MaterialLaw::Isotropic { young, poisson } => {
                format!("E {}  nu {}", shown(*young), shown(*poisson))
            }
            MaterialLaw::Orthotropic(c) => {
                format!("E1 {}  E2 {}  at {} degrees", shown(c.young_1), shown(c.young_2), shown(c.angle))
            }
            MaterialLaw::Stiffness(_) => "plane stiffness".to_owned(),
        }
    }

    /// Returns the constants as the case file has them.
    pub(super) fn json(&self) -> Json {
        match &self.law {
            MaterialLaw::Isotropic { young, poisson } => json!({ "young": young, "poisson": poisson }),
            MaterialLaw::Orthotropic(c) => json!({
                "young_1": c.young_1,
                "young_2": c.young_2,
                "young_3": c.young_3,
                "poisson_12": c.poisson_12,
                "poisson_13": c.poisson_13,
                "poisson_23": c.poisson_23,
                "shear": c.shear,
                "angle": c.angle,
            }),
            MaterialLaw::Stiffness(rows) => json!({ "stiffness": rows }),
        }
    }
}

/// Reads `[materials]`.
pub(super) fn materials(reader: Reader<'_>, hypothesis: Hypothesis) -> Vec<Material> {
    let mut materials = Vec::new();
    for entry in reader.entries() {
        let path = reader.path_of(&entry.key);
        let law = match &entry.node.value {
            NodeValue::Table(table) => {
                let mut r = Reader::new(reader.findings(), table, path, &entry.node.at);
                let law = law(&mut r, hypothesis);
                r.finish();
                law
            }
            other => {
                let message = format!("`{path}` is {}", other.type_name());
                let diagnostic = Diagnostic::new(code::TYPE, Some(entry.node.at.place()), message);
                let diagnostic = diagnostic.expected("a table with `young` and `poisson`");
                reader.findings().push(diagnostic.fix(format!("write a table `[{path}]`")));
                None
            }
        };
        // The name is there, so bodies may refer to it, even if the constants are wrong.
        let law = law.unwrap_or(MaterialLaw::Isotropic { young: 1.0, poisson: 0.0 });
        materials.push(Material { name: entry.key.clone(), law });
    }
    materials
}

fn law(r: &mut Reader<'_>, hypothesis: Hypothesis) -> Option<MaterialLaw> {
    let first = |r: &Reader<'_>, keys: &[&'static str]| keys.iter().copied().find(|k| r.has(k));
    let given = [first(r, &ISOTROPIC), first(r, &ORTHOTROPIC), first(r, &["stiffness"])];
    for key in ISOTROPIC.into_iter().chain(ORTHOTROPIC).chain(["stiffness"]) {
        // Known, whichever of them is read, so that a misspelt one gets the nearest.
        r.node(key);
    }
    let kinds: Vec<&str> = given.into_iter().flatten().collect();
    if let [one, other, ..] = kinds[..] {
        let message = format!("`{one}` and `{other}` are constants of different kinds of material");
        r.refuse(other, message, KINDS, &format!("take `{other}` out"));
        return None;
    }
    match given {
        [_, Some(_), _] => orthotropic(r, hypothesis),
        [_, _, Some(_)] => {
            let rows = r.matrix("stiffness")?;
            check(r, LinearElastic::from_stiffness(rows, hypothesis));
            Some(MaterialLaw::Stiffness(rows))
        }
        _ => isotropic(r, hypothesis),
    }
}

fn isotropic(r: &mut Reader<'_>, hypothesis: Hypothesis) -> Option<MaterialLaw> {
    r.require(&ISOTROPIC);
    let (young, poisson) = (r.number("young"), r.number("poisson"));
    // One at a time with a harmless partner, so that both faults are found.
    if let Some(young) = young {
        check(r, LinearElastic::isotropic(young, 0.0, hypothesis));
    }
    if let Some(poisson) = poisson {
        check(r, LinearElastic::isotropic(1.0, poisson, hypothesis));
    }
    Some(MaterialLaw::Isotropic { young: young?, poisson: poisson? })
}

fn orthotropic(r: &mut Reader<'_>, hypothesis: Hypothesis) -> Option<MaterialLaw> {
    r.require(&["young_1", "young_2", "poisson_12", "shear"]);
    let (young_1, young_2) = (r.number("young_1"), r.number("young_2"));
    let (poisson_12, shear) = (r.number("poisson_12"), r.number("shear"));
    let angle = r.number("angle").unwrap_or(0.0);
    let third = [r.number("young_3"), r.number("poisson_13"), r.number("poisson_23")];
    let (young, poisson_12, shear) = ([young_1?, young_2?], poisson_12?, shear?);
    let with = |poisson_12: f64| {
        let mut constants = Orthotropic::in_plane(young, poisson_12, shear, angle);
        constants.young_3 = third[0].unwrap_or(constants.young_3);
        constants.poisson_13 = third[1].unwrap_or(constants.poisson_13);
        constants.poisson_23 = third[2].unwrap_or(constants.poisson_23);
        constants
    };
    let made = |poisson_12: f64| LinearElastic::orthotropic(&with(poisson_12), hypothesis);
    let made_of_it = made(poisson_12);
    let of_poisson_12 = match &made_of_it {
        Err(MaterialError::PoissonPair { name, .. }) => *name == "poisson_12" || !r.has(name),
        Err(MaterialError::PoissonTriple { .. }) => true,
        _ => false,
    };
    match largest_ratio(poisson_12, |ratio| made(ratio).is_ok()).filter(|_| of_poisson_12) {
        Some(largest) => {
            let follow = match third {
                _ if hypothesis == Hypothesis::PlaneStress => "",
                [_, None, None] => " (and so are `poisson_13` and `poisson_23`, which are not given)",
                [_, None, _] => " (and so is `poisson_13`, which is not given)",
                [_, _, None] => " (and so is `poisson_23`, which is not given)",
                _ => "",
            };
            r.refuse(
                "poisson_12",
                format!(
                    "`{}` is {}{follow}: the strain energy would not be positive",
                    r.path_of("poisson_12"),
                    shown(poisson_12)
                ),
                &format!("at most {largest} in magnitude, with the other constants"),
                "lower it: poisson_12 is the strain along 2 for a stress along 1, and belongs to young_1",
            );
        }
        None => check(r, made_of_it),
    }
    Some(MaterialLaw::Orthotropic(with(poisson_12)))
}

/// Finds the largest ratio, by its magnitude and in three digits, with which a material can be made; `None` if there is
/// none, whatever the ratio. Those possible lie between two limits, as the compliance is linear in the ratio.
fn largest_ratio(found: f64, is_possible: impl Fn(f64) -> bool) -> Option<String> {
    let (mut possible, mut impossible) = (0.0, found);
    if !is_possible(possible) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (possible + impossible);
        *(if is_possible(middle) { &mut possible } else { &mut impossible }) = middle;
    }
    // So much less that rounding to three digits stays below.
    Some(significant(0.995 * possible.abs()))
}

fn check(r: &Reader<'_>, result: Result<LinearElastic, MaterialError>) {
    if let Err(error) = result {
        let (expected, fix) = cure(&error);
        r.refuse(key_of(&error), error.to_string(), expected, fix);
    }
}

/// Returns what constants of a material have to be, and a fix.
pub(super) fn cure(error: &MaterialError) -> (&'static str, &'static str) {
    match error {
        MaterialError::Young { .. } | MaterialError::Modulus { .. } => {
            ("a finite number > 0, well within the range of numbers", "check the units; steel has 210e9 Pa")
        }
        MaterialError::Poisson { .. } => {
            ("a number > -1 and < 0.5", "write 0.49 or less for a nearly incompressible material")
        }
        MaterialError::PoissonPair { name: "poisson_13" | "poisson_23", .. } => (
            "Poisson's ratios for which the strain energy is positive",
            "lower it: poisson_ij is the strain along j for a stress along i, and belongs to young_i",
        ),
        MaterialError::PoissonPair { .. } | MaterialError::PoissonTriple { .. } => (
            "Poisson's ratios for which the strain energy is positive",
            "lower it: poisson_12 is the strain along 2 for a stress along 1, and belongs to young_1",
        ),
        MaterialError::NotFinite { .. } => ("a finite number", "write the number itself"),
        MaterialError::Axes => ("two vectors that span a plane", "write the vectors along axes 1 and 2"),
        MaterialError::NotSymmetric { .. } => {
            ("a symmetric matrix", "write the entry above the diagonal and its mirror image alike")
        }
        MaterialError::NearlySingular { .. } => (
            "eigenvalues that differ by a factor of at most 1e12",
            "check the units of all rows; the last holds the shear modulus, in the same unit as the others",
        ),
        MaterialError::NotPositiveDefinite { .. } => {
            ("a matrix whose strain energy is positive", "check the signs, and that no diagonal entry is 0")
        }
    }
}

/// Returns the key that an error is about.
pub(super) fn key_of(error: &MaterialError) -> &'static str {
    match error {
        MaterialError::Young { .. } => "young",
        MaterialError::Poisson { .. } => "poisson",
        MaterialError::Modulus { name, .. } | MaterialError::PoissonPair { name, .. } => name,
        MaterialError::PoissonTriple { .. } => "poisson_12",
        MaterialError::NotFinite { name: "angle", .. } => "angle",
        MaterialError::Axes => "axes",
        MaterialError::NotFinite { .. }
        | MaterialError::NotSymmetric { .. }
        | MaterialError::NearlySingular { .. }
        | MaterialError::NotPositiveDefinite { .. } => "stiffness",
    }
}
