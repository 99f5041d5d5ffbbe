//! Residuals of equilibrium in double-double numbers, and displacements with more digits than one `f64` holds.
//!
//! The residual `R = K u − f` of a computed displacement is a small difference of large forces. It is evaluated cell by cell
//! from *differences* of displacements: the rounded entries of an assembled matrix no longer annihilate the
//! rigid motion of a stiff part, while differences do. Every operation has 32 digits; the result is rounded once.

use crate::body::Body;
use crate::double_double::{DoubleDouble, PreciseVector};
use crate::geometry::Coordinates;
use crate::mesh::id::{FacetId, NodeId};
use crate::parallel::each_task;
use crate::space::{Plane, Space};
use rayon::prelude::*;

/// Cells handled by one task.
const CHUNK: usize = 1024;
/// Chunks whose forces are kept before they are added up.
const GROUP: usize = 16;
/// A correction that leaves more than this fraction of the residual is the last one.
const WORTHWHILE: f64 = 0.7;
/// Maximum number of corrections of one displacement.
const MOST_REFINEMENTS: usize = 40;

/// A nodal displacement field as an unevaluated sum, Cartesian, m: its first part is printed.
///
/// One `f64` per component leaves a stress error of `ε C |u|/h`. In a stiff part on a soft one that is more than the stress
/// itself; the second part holds the missing digits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SplitField<S: Space = Plane> {
    /// The displacement rounded to double precision.
    pub high: Vec<S::Vector>,
    /// The rounding error of `high`.
    pub low: Vec<S::Vector>,
}

impl<S: Space> SplitField<S> {
    /// Creates a field without a second part.
    pub fn new(high: Vec<S::Vector>) -> Self {
        Self { low: vec![S::Vector::ZERO; high.len()], high }
    }

    /// Adds a correction to the field.
    pub fn add(&mut self, correction: &[S::Vector]) {
        for ((high, low), d) in self.high.iter_mut().zip(&mut self.low).zip(correction) {
            for c in 0..S::DIM {
                let sum = DoubleDouble { high: high[c], low: low[c] } + d[c];
                (high[c], low[c]) = (sum.high, sum.low);
            }
        }
    }

    /// Returns the displacement of a node in double-double numbers.
    pub fn at(&self, node: usize) -> PreciseVector<S> {
        S::axes(|c| DoubleDouble { high: self.high[node][c], low: self.low[node][c] })
    }
}

/// Corrects a displacement by the residual of its equilibrium until the residual stops falling: iterative refinement (Higham 2002, chapter 12), with the
/// residual in double-double numbers.
///
/// * `loads`: nodal forces in addition to the body's own, Cartesian, N/m;
/// * `measure`: returns the size of a residual, and what `correct` needs for the displacement that removes it.
///
/// Returns the size that is left.
pub fn refine<S: Space, T>(
    body: &Body<S>,
    loads: &[(NodeId, S::Vector)],
    field: &mut SplitField<S>,
    measure: impl Fn(&[PreciseVector<S>]) -> (f64, T),
    correct: impl Fn(T) -> Vec<S::Vector>,
) -> f64 {
    let mut least = f64::INFINITY;
    let mut last: Vec<S::Vector> = Vec::new();
    for _ in 0..MOST_REFINEMENTS {
        let mut residual = of_field(body, field);
        for &(node, force) in loads {
            for c in 0..S::DIM {
                let entry = &mut residual[node][c];
                *entry = *entry + -force[c];
            }
        }
        let (size, found) = measure(&residual);
        if !(size < least) {
            // The last correction increased the residual.
            let back: Vec<S::Vector> = last.iter().map(|d| -*d).collect();
            field.add(&back);
            break;
        }
        let worthwhile = size < WORTHWHILE * least;
        least = size;
        if size == 0.0 || !worthwhile {
            break;
        }
        last = correct(found);
        field.add(&last);
    }
    least
}

/// The nodal forces of a cell.
type CellForces<S> = <S as Space>::Corners<PreciseVector<S>>;

/// Computes the product of all numbers up to one.
fn factorial(n: usize) -> DoubleDouble {
    DoubleDouble::from((1..=n).product::<usize>() as f64)
}

/// A cell's geometry without rounding.
struct Cell<S: Space> {
    /// `d! |T| ∇φ_k` of all corners but the first, which has minus their sum; `d` is the number of axes.
    gradients: S::Axes<PreciseVector<S>>,
    /// `d! |T|`: twice the area, or six times the volume.
    determinant: DoubleDouble,
}

impl<S: Space> Cell<S> {
    #[inline(always)]
    fn new(corners: S::Corners<S::Vector>) -> Self {
        let edges = S::axes(|k| S::axes(|c| DoubleDouble::difference(corners[k + 1][c], corners[0][c])));
        let gradients = S::cofactors(&edges);
        let product = |c: usize| edges[0][c] * gradients[0][c];
        let determinant = (1..S::DIM).fold(product(0), |sum, c| sum + product(c));
        Self { gradients, determinant }
    }

    /// Computes `∫ σ ∇φ_k` of a constant stress.
    ///
    /// * `share`: 1/d!.
    #[inline(always)]
    fn forces(&self, stress: S::Components<DoubleDouble>, share: DoubleDouble) -> CellForces<S> {
        let stress = S::components(|k| stress[k] * share);
        let force = |g: PreciseVector<S>| {
            S::axes(|i| {
                let product = |j: usize| stress[S::component(i, j)] * g[j];
                (1..S::DIM).fold(product(0), |sum, j| sum + product(j))
            })
        };
        let others = S::axes(|k| force(self.gradients[k]));
        S::corners(|k| match k {
            0 => S::axes(|i| -(1..S::DIM).fold(others[0][i], |sum, k| sum + others[k][i])),
            k => others[k - 1],
        })
    }
}

/// A displacement with or without its second part.
#[derive(Clone, Copy)]
struct Nodal<'a, S: Space> {
    high: &'a [S::Vector],
    low: Option<&'a [S::Vector]>,
}

impl<S: Space> Nodal<'_, S> {
    #[inline(always)]
    fn at(&self, node: usize) -> PreciseVector<S> {
        let (high, low) = (self.high[node], self.low.map_or(S::Vector::ZERO, |low| low[node]));
        S::axes(|c| DoubleDouble { high: high[c], low: low[c] })
    }
}

/// The source of the stress of a cell. Not a closure: it is compiled together with the loop that has fused
/// products.
#[derive(Clone, Copy)]
enum Source<'a, S: Space> {
    Displacement(Nodal<'a, S>),
    Means(&'a [S::Components<DoubleDouble>]),
}

/// Computes the stress of a displacement in a cell.
#[inline(always)]
fn stress<S: Space>(
    body: &Body<S>,
    cell: &Cell<S>,
    t: usize,
    field: Nodal<'_, S>,
) -> S::Components<DoubleDouble> {
    let nodes = &body.mesh().cells()[t];
    let first = field.at(nodes[0].index());
    let differences = S::axes(|k| {
        let other = field.at(nodes[k + 1].index());
        S::axes(|c| other[c] - first[c])
    });
    let sum = |i: usize, j: usize| {
        let product = |k: usize| differences[k][i] * cell.gradients[k][j];
        (1..S::DIM).fold(product(0), |sum, k| sum + product(k))
    };
    // d! |T| (ε − ε₀), with engineering shears.
    let mut strain = S::components(|_| DoubleDouble::ZERO);
    for i in 0..S::DIM {
        strain[i] = sum(i, i);
        for j in 0..i {
            strain[S::component(j, i)] = sum(j, i) + sum(i, j);
        }
    }
    if body.has_initial_strain() {
        let initial: S::Components<f64> = body.initial_strain(t).into();
        for k in 0..S::COMPONENTS {
            let engineering = if k < S::DIM { initial[k] } else { 2.0 * initial[k] };
            strain[k] += -(cell.determinant * engineering);
        }
    }
    let d = body.material(t).stiffness();
    S::components(|i| {
        let product = |j: usize| strain[j] * d[(i, j)];
        (1..S::COMPONENTS).fold(product(0), |sum, j| sum + product(j)) / cell.determinant
    })
}

/// Computes the stress of a displacement field in every cell, Pa: rounded once.
pub fn stresses<S: Space>(body: &Body<S>, field: &SplitField<S>) -> Vec<S::Tensor> {
    let mesh = body.mesh();
    (0..mesh.cells().len())
        .into_par_iter()
        .with_min_len(CHUNK)
        .map(|t| {
            let nodal = Nodal { high: &field.high, low: Some(&field.low) };
            let stress = stress(body, &Cell::<S>::new(mesh.corners(t)), t, nodal);
            S::components(|k| stress[k].rounded()).into()
        })
        .collect()
}

/// Computes `K u − f` at every node, Cartesian, N/m: the reaction of a support, the contact force on the interface, and zero
/// elsewhere if the field is in FE equilibrium.
pub fn of_field<S: Space>(body: &Body<S>, field: &SplitField<S>) -> Vec<PreciseVector<S>> {
    of_nodal(body, Nodal { high: &field.high, low: Some(&field.low) })
}

/// [`of_field`] of a displacement in double precision.
pub fn of_displacement<S: Space>(body: &Body<S>, displacement: &[S::Vector]) -> Vec<PreciseVector<S>> {
    of_nodal(body, Nodal { high: displacement, low: None })
}

/// Computes the residual of a displacement, springs included.
fn of_nodal<S: Space>(body: &Body<S>, field: Nodal<'_, S>) -> Vec<PreciseVector<S>> {
    let mut residual = residual(body, Source::Displacement(field));
    for (facet, springs) in body.facet_springs() {
        let nodes = body.mesh().topology().facets()[facet];
        // K (u − u₀) at the corners
        let traction: S::Axes<PreciseVector<S>> = S::axes(|k| {
            let moved = field.at(nodes[k].index());
            let stretch: PreciseVector<S> = S::axes(|c| moved[c] + springs.stretch[k][c]);
            S::axes(|c| {
                let product = |j: usize| stretch[j] * springs.stiffness[c][j];
                (1..S::DIM).fold(product(0), |sum, j| sum + product(j))
            })
        });
        let share = facet_measure(body, facet) / factorial(S::DIM + 1);
        for k in 0..S::DIM {
            for c in 0..S::DIM {
                let others = (0..S::DIM).filter(|j| *j != k);
                let sum = others.fold(traction[k][c] + traction[k][c], |sum, j| sum + traction[j][c]);
                residual[nodes[k]][c] += share * sum;
            }
        }
    }
    residual
}

/// Computes the measure of a facet times the factorial of its dimension.
fn facet_measure<S: Space>(body: &Body<S>, facet: FacetId) -> DoubleDouble {
    let corners = body.mesh().facet_corners(facet);
    let difference = |k: usize, c: usize| DoubleDouble::difference(corners[k][c], corners[0][c]);
    let edges =
        S::axes(|k| S::axes(|c| if k + 1 < S::DIM { difference(k + 1, c) } else { DoubleDouble::ZERO }));
    // The last vector is no edge, and its cofactors are the normal.
    let normal = S::cofactors(&edges)[S::DIM - 1];
    (1..S::DIM).fold(normal[0] * normal[0], |sum, c| sum + normal[c] * normal[c]).sqrt()
}

/// Computes `∫ σ : ε(φ) − f(φ)` at every node, Cartesian, N/m, of a stress given by its mean in every cell: without springs.
///
/// * `means`: components of the mean of each cell, Pa.
pub fn of_stress<S: Space>(body: &Body<S>, means: &[S::Components<DoubleDouble>]) -> Vec<PreciseVector<S>> {
    residual(body, Source::Means(means))
}

/// Gathers the forces of constant stresses and subtracts the loads.
fn residual<S: Space>(body: &Body<S>, source: Source<'_, S>) -> Vec<PreciseVector<S>> {
    let cells = body.mesh().cells();
    let mut residual: Vec<PreciseVector<S>> =
        external_forces(body).into_iter().map(|f| S::axes(|c| -f[c])).collect();
    let chunks = cells.len().div_ceil(CHUNK);
    for group in (0..chunks).step_by(GROUP) {
        let forces: Vec<Vec<CellForces<S>>> = each_task(GROUP.min(chunks - group), |k| {
            let first = (group + k) * CHUNK;
            let cells = first..cells.len().min(first + CHUNK);
            pulp::Arch::new().dispatch(ChunkForces { body, cells, source })
        });
        let first = group * CHUNK;
        for (nodes, forces) in cells[first..].iter().zip(forces.iter().flatten()) {
            for k in 0..=S::DIM {
                for c in 0..S::DIM {
                    residual[nodes[k]][c] += forces[k][c];
                }
            }
        }
    }
    residual
}

/// The forces of some cells, compiled for the widest instructions: error-free products need fused ones.
struct ChunkForces<'a, S: Space> {
    body: &'a Body<S>,
    cells: std::ops::Range<usize>,
    source: Source<'a, S>,
}

impl<S: Space> pulp::NullaryFnOnce for ChunkForces<'_, S> {
    type Output = Vec<CellForces<S>>;

    #[inline(always)]
    fn call(self) -> Vec<CellForces<S>> {
        let Self { body, cells, source } = self;
        let share = DoubleDouble::from(1.0) / factorial(S::DIM);
        let mut found = Vec::with_capacity(cells.len());
        for t in cells {
            let cell = Cell::<S>::new(body.mesh().corners(t));
            let stress = match source {
                Source::Displacement(field) => stress(body, &cell, t, field),
                Source::Means(means) => means[t],
            };
            found.push(cell.forces(stress, share));
        }
        found
    }
}

/// Computes the nodal forces of tractions and body force, Cartesian, N/m in the plane, N in space; see [`crate::assembly::external_forces`].
fn external_forces<S: Space>(body: &Body<S>) -> Vec<PreciseVector<S>> {
    let mesh = body.mesh();
    let zero = S::axes(|_| DoubleDouble::ZERO);
    let mut forces = vec![zero; mesh.points().len()];
    let parts = factorial(S::DIM + 1);
    for (condition, &facet) in body.facet_conditions().iter().zip(mesh.topology().boundary_facets()) {
        let traction = condition.traction;
        if traction == S::ZEROS {
            continue;
        }
        let share = facet_measure(body, facet) / parts;
        let nodes = mesh.topology().facets()[facet];
        for k in 0..S::DIM {
            for c in 0..S::DIM {
                let own = DoubleDouble::sum(traction[k][c], traction[k][c]);
                let others = (0..S::DIM).filter(|j| *j != k);
                forces[nodes[k]][c] += share * others.fold(own, |sum, j| sum + traction[j][c]);
            }
        }
    }
    for (node, force) in body.rigid_forces() {
        for c in 0..S::DIM {
            forces[node][c] += DoubleDouble::from(force[c]);
        }
    }
    if body.has_force() {
        for (t, nodes) in mesh.cells().iter().enumerate() {
            let share = Cell::<S>::new(mesh.corners(t)).determinant / parts;
            let (mean, beyond) = (body.force(t).mean, body.nodal_forces_beyond_mean(t));
            for k in 0..=S::DIM {
                for c in 0..S::DIM {
                    forces[nodes[k]][c] += share * mean[c];
                    forces[nodes[k]][c] += DoubleDouble::from(beyond[k][c]);
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
    use crate::geometry::Vector;
    use crate::material::{Hypothesis, LinearElastic};
    use crate::mesh::generate::{block, cuboid};
    use crate::space::Solid;
    use nalgebra::Vector3;

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
        let stresses = stresses(&body, &SplitField::<Plane>::new(u));
        let means: Vec<_> = stresses.iter().map(|s| [s.xx, s.yy, s.xy].map(DoubleDouble::from)).collect();
        assert!(difference(&of_stress(&body, &means), &expected) < 1e-14 * scale);
    }

    #[test]
    fn a_rigid_motion_has_no_residual_to_thirty_digits() {
        let material = LinearElastic::isotropic(1e13, 0.3, Hypothesis::PlaneStrain).unwrap();
        let mesh = block([1e3, -7e2], [2.0, 1.0], [7, 5]).unwrap();
        let body = Body::new(mesh, material, &BoundaryConditions::new()).unwrap();
        // A rotation and a translation whose coefficients are exact in a split field.
        let mut field = SplitField::<Plane>::new(
            body.mesh().points().iter().map(|x| Vector::new(-0.5 * x[1], 0.5 * x[0])).collect(),
        );
        field.add(&vec![Vector::new(1e-3, 1e5); body.mesh().points().len()]);
        let largest = of_field(&body, &field).iter().flatten().fold(0.0f64, |m, r| m.max(r.rounded().abs()));
        assert!(largest < 1e13 * 1e5 * 1e-30, "{largest:e}");
    }

    #[test]
    fn residuals_of_solids_agree_with_double_precision() {
        let material = LinearElastic::isotropic_solid(1e9, 0.3).unwrap();
        let mut conditions = BoundaryConditions::<Solid>::default().fix("bottom").pressure("top", 3.0);
        conditions.body_force = [0.2, -1.5, 0.7].into();
        let mesh = cuboid([0.3, 0.1, -0.2], [2.0, 1.0, 0.5], [5, 3, 2]).unwrap();
        let body = Body::new(mesh, material, &conditions).unwrap();
        let at = |x: &Vector3<f64>| Vector3::new(x[0] * x[1], x[0] - x[2] * x[2], x[1] * x[2]);
        let u: Vec<_> = body.mesh().points().iter().map(at).collect();
        let expected = field::nodal_residual(&body, &u);
        let scale = expected.iter().flatten().fold(0.0f64, |m, r| m.max(r.abs()));
        let difference = |found: &[PreciseVector<Solid>]| {
            let pairs = found.iter().flatten().zip(expected.iter().flatten());
            pairs.map(|(a, b)| (*a + -b).rounded().abs()).fold(0.0, f64::max)
        };
        assert!(difference(&of_displacement(&body, &u)) < 1e-14 * scale);
        let field = SplitField::<Solid>::new(u);
        let means = stresses(&body, &field).into_iter().map(|s| <[f64; 6]>::from(s).map(DoubleDouble::from));
        assert!(difference(&of_stress(&body, &means.collect::<Vec<_>>())) < 1e-14 * scale);
        // A rotation and a translation whose coefficients are exact in a split field.
        let free =
            Body::new(body.mesh().clone(), body.material(0).clone(), &BoundaryConditions::default()).unwrap();
        let of = |motion: fn(&Vector3<f64>) -> Vector3<f64>| -> Vec<_> {
            free.mesh().points().iter().map(motion).collect()
        };
        let mut field = SplitField::<Solid>::new(of(|x| Vector3::new(-0.5 * x[1], 0.5 * x[0], 0.0)));
        field.add(&of(|x| Vector3::new(0.0, -0.25 * x[2], 0.25 * x[1])));
        field.add(&of(|_| Vector3::new(1e-3, 1e5, 7.0)));
        let largest = of_field(&free, &field).iter().flatten().fold(0.0f64, |m, r| m.max(r.rounded().abs()));
        assert!(largest < 1e9 * 1e5 * 1e-30, "{largest:e}");
    }
}
