//! Residuals of equilibrium in double-double numbers, and displacements with more digits than one `f64` holds.
//!
//! The residual `R = K u − f` of a computed displacement is a small difference of large forces. It is evaluated cell by cell
//! from *differences* of displacements: the rounded entries of an assembled matrix no longer annihilate the
//! rigid motion of a stiff part, while differences do. Every operation has 32 digits; the result is rounded once.

use crate::body::Body;
use crate::double_double::{DoubleDouble, PreciseVector};
use crate::geometry::Vector;
use crate::parallel::each_task;
use crate::tensor::SymTensor2;
use rayon::prelude::*;

/// Triangles handled by one task.
const CHUNK: usize = 1024;
/// Chunks whose forces are kept before they are added up.
const GROUP: usize = 16;

/// A nodal displacement field as an unevaluated sum, Cartesian, m: its first part is printed.
///
/// One `f64` per component leaves a stress error of `ε C |u|/h`. In a stiff part on a soft one that is more than the stress
/// itself; the second part holds the missing digits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SplitField {
    /// The displacement rounded to double precision.
    pub high: Vec<Vector>,
    /// The rounding error of `high`.
    pub low: Vec<Vector>,
}

impl SplitField {
    /// Creates a field without a second part.
    pub fn new(high: Vec<Vector>) -> Self {
        Self { low: vec![Vector::zeros(); high.len()], high }
    }

    /// Adds a correction to the field.
    pub fn add(&mut self, correction: &[Vector]) {
        for ((high, low), d) in self.high.iter_mut().zip(&mut self.low).zip(correction) {
            for c in 0..2 {
                let sum = DoubleDouble { high: high[c], low: low[c] } + d[c];
                (high[c], low[c]) = (sum.high, sum.low);
            }
        }
    }

    /// Returns the displacement of a node in double-double numbers.
    pub fn at(&self, node: usize) -> PreciseVector {
        [0, 1].map(|c| DoubleDouble { high: self.high[node][c], low: self.low[node][c] })
    }
}

/// The three nodal forces of a triangle.
type CellForces = [PreciseVector; 3];

/// A triangle's geometry without rounding.
struct Cell {
    /// `2A ∇φ_k` of the second and the third corner; the first has minus their sum.
    gradients: [PreciseVector; 2],
    /// `2A`.
    double_area: DoubleDouble,
}

impl Cell {
    #[inline(always)]
    fn new(corners: [Vector; 3]) -> Self {
        let difference = |a: Vector, b: Vector| [0, 1].map(|c| DoubleDouble::difference(a[c], b[c]));
        let (a, b) = (difference(corners[1], corners[0]), difference(corners[2], corners[0]));
        let double_area = a[0] * b[1] - a[1] * b[0];
        Self { gradients: [[b[1], -b[0]], [-a[1], a[0]]], double_area }
    }

    /// Computes `∫ σ ∇φ_k` of a constant stress `(xx, yy, xy)`.
    #[inline(always)]
    fn forces(&self, [xx, yy, xy]: [DoubleDouble; 3]) -> CellForces {
        let half = |x: DoubleDouble| DoubleDouble { high: 0.5 * x.high, low: 0.5 * x.low };
        let [one, two] = self.gradients.map(|g| [half(xx * g[0] + xy * g[1]), half(xy * g[0] + yy * g[1])]);
        [[-(one[0] + two[0]), -(one[1] + two[1])], one, two]
    }
}

/// A displacement with or without its second part.
#[derive(Clone, Copy)]
struct Nodal<'a> {
    high: &'a [Vector],
    low: Option<&'a [Vector]>,
}

impl Nodal<'_> {
    #[inline(always)]
    fn at(&self, node: usize) -> PreciseVector {
        let (high, low) = (self.high[node], self.low.map_or(Vector::zeros(), |low| low[node]));
        [0, 1].map(|c| DoubleDouble { high: high[c], low: low[c] })
    }
}

/// The source of the stress of a triangle. Not a closure: it is compiled together with the loop that has fused
/// products.
#[derive(Clone, Copy)]
enum Source<'a> {
    Displacement(Nodal<'a>),
    Means(&'a [[DoubleDouble; 3]]),
}

/// Computes the stress of a displacement in a triangle, `(xx, yy, xy)`.
#[inline(always)]
fn stress(body: &Body, cell: &Cell, t: usize, field: Nodal<'_>) -> [DoubleDouble; 3] {
    let corners = body.mesh().cells()[t].map(|n| field.at(n.index()));
    let difference = |k: usize| [0, 1].map(|c| corners[k][c] - corners[0][c]);
    let (d1, d2) = (difference(1), difference(2));
    let [g1, g2] = cell.gradients;
    // 2A (ε_xx, ε_yy, γ_xy)
    let xx = d1[0] * g1[0] + d2[0] * g2[0];
    let yy = d1[1] * g1[1] + d2[1] * g2[1];
    let shear = d1[0] * g1[1] + d2[0] * g2[1] + (d1[1] * g1[0] + d2[1] * g2[0]);
    let d = body.material(t).stiffness();
    [0, 1, 2].map(|i| (xx * d[(i, 0)] + yy * d[(i, 1)] + shear * d[(i, 2)]) / cell.double_area)
}

/// Computes the stress of a displacement field in every triangle, Pa: rounded once.
pub fn stresses(body: &Body, field: &SplitField) -> Vec<SymTensor2> {
    let mesh = body.mesh();
    (0..mesh.cells().len())
        .into_par_iter()
        .with_min_len(CHUNK)
        .map(|t| {
            let nodal = Nodal { high: &field.high, low: Some(&field.low) };
            let [xx, yy, xy] = stress(body, &Cell::new(mesh.corners(t)), t, nodal);
            SymTensor2::new(xx.rounded(), yy.rounded(), xy.rounded())
        })
        .collect()
}

/// Computes `K u − f` at every node, Cartesian, N/m: the reaction of a support, the contact force on the interface, and zero
/// elsewhere if the field is in FE equilibrium.
pub fn of_field(body: &Body, field: &SplitField) -> Vec<PreciseVector> {
    residual(body, Source::Displacement(Nodal { high: &field.high, low: Some(&field.low) }))
}

/// [`of_field`] of a displacement in double precision.
pub fn of_displacement(body: &Body, displacement: &[Vector]) -> Vec<PreciseVector> {
    residual(body, Source::Displacement(Nodal { high: displacement, low: None }))
}

/// Computes `∫ σ : ε(φ) − f(φ)` at every node, Cartesian, N/m, of a stress given by its mean in every triangle.
///
/// * `means`: components xx, yy, xy of the mean of each triangle, Pa.
pub fn of_stress(body: &Body, means: &[[DoubleDouble; 3]]) -> Vec<PreciseVector> {
    residual(body, Source::Means(means))
}

/// Gathers the forces of constant stresses and subtracts the loads.
fn residual(body: &Body, source: Source<'_>) -> Vec<PreciseVector> {
    let triangles = body.mesh().cells();
    let mut residual: Vec<PreciseVector> = external_forces(body).into_iter().map(|f| f.map(|x| -x)).collect();
    let chunks = triangles.len().div_ceil(CHUNK);
    for group in (0..chunks).step_by(GROUP) {
        let forces: Vec<Vec<CellForces>> = each_task(GROUP.min(chunks - group), |k| {
            let first = (group + k) * CHUNK;
            let triangles = first..triangles.len().min(first + CHUNK);
            pulp::Arch::new().dispatch(ChunkForces { body, triangles, source })
        });
        let first = group * CHUNK;
        for (corners, forces) in triangles[first..].iter().zip(forces.iter().flatten()) {
            for (&n, f) in corners.iter().zip(forces) {
                for c in 0..2 {
                    residual[n][c] += f[c];
                }
            }
        }
    }
    residual
}

/// The forces of some triangles, compiled for the widest instructions: error-free products need fused ones.
struct ChunkForces<'a> {
    body: &'a Body,
    triangles: std::ops::Range<usize>,
    source: Source<'a>,
}

impl pulp::NullaryFnOnce for ChunkForces<'_> {
    type Output = Vec<CellForces>;

    #[inline(always)]
    fn call(self) -> Vec<CellForces> {
        let Self { body, triangles, source } = self;
        let mut found = Vec::with_capacity(triangles.len());
        for t in triangles {
            let cell = Cell::new(body.mesh().corners(t));
            let stress = match source {
                Source::Displacement(field) => stress(body, &cell, t, field),
                Source::Means(means) => means[t],
            };
            found.push(cell.forces(stress));
        }
        found
    }
}

/// Computes the nodal forces of tractions and body force, Cartesian, N/m; see [`crate::assembly::external_forces`].
fn external_forces(body: &Body) -> Vec<PreciseVector> {
    let mesh = body.mesh();
    let mut forces = vec![[DoubleDouble::ZERO; 2]; mesh.points().len()];
    for (condition, &edge) in body.facet_conditions().iter().zip(mesh.topology().boundary_facets()) {
        let [a, b] = condition.traction;
        if a == Vector::zeros() && b == Vector::zeros() {
            continue;
        }
        let ends = mesh.facet_corners(edge);
        let [x, y] = [0, 1].map(|c| DoubleDouble::difference(ends[1][c], ends[0][c]));
        let sixth = (x * x + y * y).sqrt() / DoubleDouble::from(6.0);
        let nodes = mesh.topology().facets()[edge];
        for (node, near, far) in [(nodes[0], a, b), (nodes[1], b, a)] {
            for c in 0..2 {
                forces[node][c] += sixth * (DoubleDouble::sum(near[c], near[c]) + far[c]);
            }
        }
    }
    for (node, force) in body.rigid_forces() {
        for c in 0..2 {
            forces[node][c] += DoubleDouble::from(force[c]);
        }
    }
    let b = body.body_force();
    if b != Vector::zeros() {
        for (t, corners) in mesh.cells().iter().enumerate() {
            let share = Cell::new(mesh.corners(t)).double_area / DoubleDouble::from(6.0);
            for &n in corners {
                for c in 0..2 {
                    forces[n][c] += share * b[c];
                }
            }
        }
    }
    forces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::BoundaryConditions;
    use crate::field;
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::generate::block;

    fn body() -> Body {
        let material = LinearElastic::isotropic(1e9, 0.3, Hypothesis::PlaneStrain).unwrap();
        let conditions = BoundaryConditions::new().fix("bottom").pressure("top", 3.0).body_force([0.2, -1.5]);
        Body::new(block([0.3, 0.1], [2.0, 1.0], [7, 5]).unwrap(), material, &conditions).unwrap()
    }

    fn difference(a: &[PreciseVector], b: &[Vector]) -> f64 {
        let pairs = a.iter().zip(b).flat_map(|(a, b)| [a[0] + -b[0], a[1] + -b[1]]);
        pairs.map(|d| d.rounded().abs()).fold(0.0, f64::max)
    }

    #[test]
    fn residuals_agree_with_double_precision() {
        let body = body();
        let u: Vec<Vector> =
            body.mesh().points().iter().map(|x| Vector::new(x[0] * x[1], x[0] - x[1] * x[1])).collect();
        let expected = field::nodal_residual(&body, &u);
        let scale = expected.iter().flatten().fold(0.0f64, |m, r| m.max(r.abs()));
        assert!(difference(&of_displacement(&body, &u), &expected) < 1e-14 * scale);
        let stresses = stresses(&body, &SplitField::new(u));
        let means: Vec<_> = stresses.iter().map(|s| [s.xx, s.yy, s.xy].map(DoubleDouble::from)).collect();
        assert!(difference(&of_stress(&body, &means), &expected) < 1e-14 * scale);
    }

    #[test]
    fn a_rigid_motion_has_no_residual_to_thirty_digits() {
        let material = LinearElastic::isotropic(1e13, 0.3, Hypothesis::PlaneStrain).unwrap();
        let mesh = block([1e3, -7e2], [2.0, 1.0], [7, 5]).unwrap();
        let body = Body::new(mesh, material, &BoundaryConditions::new()).unwrap();
        // A rotation and a translation whose coefficients are exact in a split field.
        let mut field = SplitField::new(
            body.mesh().points().iter().map(|x| Vector::new(-0.5 * x[1], 0.5 * x[0])).collect(),
        );
        field.add(&vec![Vector::new(1e-3, 1e5); body.mesh().points().len()]);
        let largest = of_field(&body, &field).iter().flatten().fold(0.0f64, |m, r| m.max(r.rounded().abs()));
        assert!(largest < 1e13 * 1e5 * 1e-30, "{largest:e}");
    }
}
