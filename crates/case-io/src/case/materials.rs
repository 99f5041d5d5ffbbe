//! `[materials.NAME]`: isotropic, orthotropic, or a stiffness.

use super::dimension::{Dimension, Keys, Rows};
use super::fixes::refuse_material;
use crate::case_file::{NodeValue, Reader};
use crate::diagnostic::{Diagnostic, code};
use fem_core::geometry::shown;
use fem_core::material::{LinearElastic, MaterialError};
use fem_core::space::Plane;
use serde_json::{Value as Json, json};

/// `[materials.NAME]`: a linear elastic material.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Material<S: Dimension = Plane> {
    /// Its name.
    pub name: String,
    /// Its constants.
    pub law: MaterialLaw<S>,
    /// `expansion`: strain per unit of temperature; 0 by default.
    pub expansion: f64,
    /// `density`, if it is given, kg/m³.
    pub density: Option<f64>,
    /// `limit`: the equivalent stress that it may bear, Pa, with which results are compared.
    pub limit: Option<f64>,
}

/// The constants of a material.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MaterialLaw<S: Dimension = Plane> {
    /// `young`, `poisson`.
    Isotropic {
        /// Young's modulus, Pa.
        young: f64,
        /// Poisson's ratio.
        poisson: f64,
    },
    /// `young_1`, `young_2`, `poisson_12`, `shear`, `angle` and, for plane strain, `young_3`, `poisson_13`, `poisson_23`; in space all
    /// nine and `axes`. An angle is in degrees here.
    Orthotropic(S::Orthotropic),
    /// `stiffness`: the matrix of the plane problem or of space by rows, Pa.
    Stiffness(Rows<S>),
}

const ISOTROPIC: [&str; 2] = ["young", "poisson"];

impl<S: Dimension> Material<S> {
    /// Makes fem-core's material.
    ///
    /// # Errors
    /// Constants that fem-core refuses; never for materials that were read from a case file.
    pub(crate) fn elastic(&self, model: &S::Model) -> Result<LinearElastic<S>, MaterialError> {
        let elastic = match &self.law {
            MaterialLaw::Isotropic { young, poisson } => S::isotropic(*young, *poisson, model),
            MaterialLaw::Orthotropic(constants) => S::orthotropic(constants, model),
            MaterialLaw::Stiffness(rows) => S::of_stiffness(rows, model),
        }?;
        let elastic = if self.expansion == 0.0 { elastic } else { elastic.with_expansion(self.expansion)? };
        elastic.with_density(self.density.unwrap_or_default())
    }

    /// Returns the largest modulus, Pa: a measure of its stiffness.
    pub(crate) fn largest_modulus(&self) -> f64 {
        match &self.law {
            MaterialLaw::Isotropic { young, .. } => *young,
            MaterialLaw::Orthotropic(c) => S::moduli(c).into_iter().fold(f64::NEG_INFINITY, f64::max),
            MaterialLaw::Stiffness(rows) => (0..S::DIM).map(|k| rows[k][k]).fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Describes the material in a few words: `E 2000  nu 0.3`.
    pub fn summary(&self) -> String {
        match &self.law {
            MaterialLaw::Isotropic { young, poisson } => {
                format!("E {}  nu {}", shown(*young), shown(*poisson))
            }
            MaterialLaw::Orthotropic(c) => S::material_words(Some(c)),
            MaterialLaw::Stiffness(_) => S::material_words(None),
        }
    }

    /// Returns the constants as the case file has them.
    pub(super) fn json(&self) -> Json {
        let mut json = match &self.law {
            MaterialLaw::Isotropic { young, poisson } => json!({ "young": young, "poisson": poisson }),
            MaterialLaw::Orthotropic(c) => S::orthotropic_json(c),
            MaterialLaw::Stiffness(rows) => {
                let rows: Vec<Json> = rows.into_iter().map(|row| json!(row.as_ref())).collect();
                json!({ "stiffness": rows })
            }
        };
        if self.expansion != 0.0 {
            json["expansion"] = json!(self.expansion);
        }
        if let Some(density) = self.density {
            json["density"] = json!(density);
        }
        if let Some(limit) = self.limit {
            json["limit"] = json!(limit);
        }
        json
    }
}

/// Reads `[materials]`.
pub(super) fn materials<S: Keys>(reader: Reader<'_>, model: &S::Model) -> Vec<Material<S>> {
    let mut materials = Vec::new();
    for entry in reader.entries() {
        let path = reader.path_of(&entry.key);
        let (mut expansion, mut density, mut limit) = (None, None, None);
        let law = match &entry.node.value {
            NodeValue::Table(table) => {
                let mut r = Reader::new(reader.findings(), table, path, &entry.node.at);
                let law = law::<S>(&mut r, model);
                (expansion, density) = (r.number("expansion"), r.number("density"));
                limit = r.number_where("limit", |limit| limit > 0.0, "a stress > 0");
                if let Some(law) = &law {
                    let (law, name) = (law.clone(), entry.key.clone());
                    let made =
                        Material { name, law, expansion: expansion.unwrap_or_default(), density, limit };
                    // The constants of the law were checked when they were read.
                    use MaterialError::{Density, Expansion, ExpansionOfStiffness};
                    if let Err(error @ (Expansion { .. } | ExpansionOfStiffness | Density { .. })) =
                        made.elastic(model)
                    {
                        refuse_material(&r, &error);
                    }
                }
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
        let expansion = expansion.unwrap_or_default();
        materials.push(Material { name: entry.key.clone(), law, expansion, density, limit });
    }
    materials
}

fn law<S: Keys>(r: &mut Reader<'_>, model: &S::Model) -> Option<MaterialLaw<S>> {
    let first = |r: &Reader<'_>, keys: &[&'static str]| keys.iter().copied().find(|k| r.has(k));
    let given = [first(r, &ISOTROPIC), first(r, S::CONSTANTS), first(r, &["stiffness"])];
    for key in ISOTROPIC.iter().chain(S::CONSTANTS).chain(&["stiffness"]) {
        // Known, whichever of them is read, so that a misspelt one gets the nearest.
        r.node(key);
    }
    let kinds: Vec<&str> = given.into_iter().flatten().collect();
    if let [one, other, ..] = kinds[..] {
        let message = format!("`{one}` and `{other}` are constants of different kinds of material");
        r.refuse(other, message, S::MATERIALS, &format!("take `{other}` out"));
        return None;
    }
    match given {
        [_, Some(_), _] => S::constants(r, model).map(MaterialLaw::Orthotropic),
        [_, _, Some(_)] => {
            let found = r.matrix("stiffness", &S::STIFFNESS)?;
            let rows = S::components(|i| S::components(|j| found[i][j]));
            check(r, S::of_stiffness(&rows, model));
            Some(MaterialLaw::Stiffness(rows))
        }
        _ => isotropic(r, model),
    }
}

fn isotropic<S: Keys>(r: &mut Reader<'_>, model: &S::Model) -> Option<MaterialLaw<S>> {
    r.require(&ISOTROPIC);
    let (young, poisson) = (r.number("young"), r.number("poisson"));
    // One at a time with a harmless partner, so that both faults are found.
    if let Some(young) = young {
        check(r, S::isotropic(young, 0.0, model));
    }
    if let Some(poisson) = poisson {
        check(r, S::isotropic(1.0, poisson, model));
    }
    Some(MaterialLaw::Isotropic { young: young?, poisson: poisson? })
}

fn check<S: Dimension>(r: &Reader<'_>, result: Result<LinearElastic<S>, MaterialError>) {
    if let Err(error) = result {
        refuse_material(r, &error);
    }
}
