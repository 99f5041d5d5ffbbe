//! The fields that colour the bodies, each with its scale and its largest value.

use super::{DIGITS, Model, shown};
use crate::figures::{Picture, error_density};
use crate::nodal;
use crate::plot::{Quantity, Scale};
use crate::render::{SkinFace, Vector};
use crate::words::with_digits;
use fem_core::geometry::norm;

/// A field of all bodies.
pub(super) enum Field {
    /// One value for each cell of each body.
    Cells(Vec<Vec<f64>>),
    /// One value for each node of each body, for each of its materials.
    Nodes(Vec<Vec<Vec<f64>>>),
}

/// A field as it is drawn.
pub(super) struct Coloured {
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    pub(super) quantity: Quantity,
    pub(super) field: Field,
    pub(super) scale: Scale,
    /// What is to be seen, with the largest value.
    pub(super) said: String,
    /// The place of the largest value, if bodies are cut open there, m.
    pub(super) through: Option<Vector>,
}

impl Model<'_> {
    /// Makes the samples of a scale from the faces: values at the corners, each with a third of the area.
    fn on_skin(&self, field: &Field) -> Vec<Vec<[f64; 2]>> {
        let of_body = |b: usize| {
            let mesh = self.solution.problem.bodies[b].mesh();
            let of_face = |face: &SkinFace| {
                let area = mesh.facet_measure(face.facet) / 3.0;
                self.values(field, b, face.cell, face.nodes).map(|value| [value, area])
            };
            self.skins[b].faces.iter().flat_map(of_face).collect()
        };
        (0..self.skins.len()).map(of_body).collect()
    }

    /// Finds the recovered von Mises stress; `None` without it.
    pub(super) fn von_mises(&self) -> Option<Coloured> {
        let results = self.solution.results.filter(|_| self.estimate.is_some())?;
        let bodies = self.solution.problem.bodies.iter().zip(&results.recovered);
        let values = bodies.map(|(body, stress)| nodal::von_mises_by_material(body, stress));
        let field = Field::Nodes(values.collect::<Option<_>>()?);
        let peak = results.peak_stress?;
        let found = Some((peak.von_mises, None)).filter(|(value, _)| value.is_finite());
        Some(Coloured {
            name: "von_mises",
            title: "Von Mises stress",
            quantity: Quantity::VonMises,
            scale: Scale::new(Quantity::VonMises, &self.on_skin(&field), found, false),
            said: format!(
                "Bodies coloured by the recovered von Mises stress. The largest is {} in {} at {}.",
                with_digits(peak.von_mises, DIGITS),
                self.names[peak.body],
                shown(peak.point)
            ),
            field,
            through: Some(peak.point),
        })
    }

    /// Writes the principal stresses at the largest recovered von Mises stress, ascending.
    fn principal(&self) -> Option<[String; 3]> {
        let results = self.solution.results?;
        let of_body = results.recovered.get(results.peak_stress?.body)?.values().map(|(_, _, stress)| stress);
        let stress = of_body.max_by(|a, b| a.von_mises().total_cmp(&b.von_mises()))?;
        Some(stress.principal().map(|value| with_digits(value, DIGITS)))
    }

    /// Finds the size of the displacement.
    pub(super) fn displacement(&self) -> Option<Coloured> {
        let estimate = self.estimate?;
        let of_body = |b: usize| {
            let values: Vec<f64> = estimate.pair.bodies[b].displacement.iter().map(|u| norm(*u)).collect();
            vec![values; self.solution.problem.bodies[b].materials().list().len()]
        };
        let values: Vec<Vec<Vec<f64>>> = (0..self.skins.len()).map(of_body).collect();
        let sizes = |b: usize| values[b].first().into_iter().flatten().copied().enumerate();
        let all = (0..values.len()).flat_map(|b| sizes(b).map(move |(node, value)| (value, b, node)));
        let (largest, body, node) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let field = Field::Nodes(values);
        let found = Some((largest, None)).filter(|(value, _)| value.is_finite());
        Some(Coloured {
            name: "displacement",
            title: "Displacement",
            quantity: Quantity::Displacement,
            scale: Scale::new(Quantity::Displacement, &self.on_skin(&field), found, false),
            said: format!(
                "Deformed bodies coloured by the size of the displacement. The largest is {} in {} at {}.",
                with_digits(largest, DIGITS),
                self.names[body],
                shown(self.solution.problem.bodies[body].mesh().points()[node])
            ),
            field,
            through: None,
        })
    }

    /// Finds the density of the error, or of the residual.
    pub(super) fn density(&self) -> Option<Coloured> {
        self.estimate?;
        let bodies = &self.solution.problem.bodies;
        let densities: Vec<Vec<f64>> = (0..bodies.len()).map(|b| error_density(self.solution, b)).collect();
        let samples = |b: usize| {
            let values = densities[b].iter().enumerate();
            values.map(|(cell, value)| [*value, bodies[b].mesh().measure(cell)]).collect()
        };
        let samples: Vec<Vec<[f64; 2]>> = (0..bodies.len()).map(samples).collect();
        let of_body = |b: usize| densities[b].iter().enumerate().map(move |(cell, value)| (*value, b, cell));
        let all = (0..bodies.len()).flat_map(of_body).filter(|(value, ..)| value.is_finite());
        let (largest, body, cell) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let middle = bodies[body].mesh().corners(cell).iter().sum::<Vector>() / 4.0;
        Some(Coloured {
            name: "deformed",
            title: if self.solution.is_residual() { "Density of the residual" } else { "Error density" },
            quantity: Quantity::ErrorDensity,
            scale: Scale::new(Quantity::ErrorDensity, &samples, Some((largest, None)), false),
            said: format!(
                "Bodies coloured by the {} of each cell over its volume. The largest is {} in {} at {}.",
                self.squared(),
                with_digits(largest, DIGITS),
                self.names[body],
                shown(middle)
            ),
            field: Field::Cells(densities),
            through: Some(middle),
        })
    }

    fn squared(&self) -> &'static str {
        if self.solution.is_residual() { "squared residual" } else { "certified squared error" }
    }

    /// Draws the fields: displacement, von Mises stress, density of the error.
    pub(super) fn picture_of(&self, quantity: Quantity) -> Option<Picture> {
        match quantity {
            Quantity::Displacement => Some(
                self.coloured(&self.displacement()?, "The size of the displacement from the bodies at rest."),
            ),
            Quantity::VonMises => {
                let caption =
                    "The recovered stress: a smooth picture of the stress in equilibrium, for each material.";
                let principal = self.principal().map_or_else(String::new, |[low, middle, high]| {
                    format!(" Principal stresses at the largest value: {high}, {middle}, {low}.")
                });
                Some(self.coloured(&self.von_mises()?, &format!("{caption}{principal}")))
            }
            _ => {
                let what = self.squared();
                let caption = format!(
                    "The {what} of each cell over its volume. Large values show which cells to refine."
                );
                Some(self.coloured(&self.density()?, &caption))
            }
        }
    }
}
