//! Energy norms, all without the factor ½: `‖u‖² = a(u, u) = ∫ σ(u) : ε(u)`, and `∫ k u²` of springs.

use crate::body::{Body, FacetSprings};
use crate::element::Element;
use crate::field::strain;
use crate::geometry::{Vector, norm};
use crate::mesh::TriMesh;
use crate::mesh::id::FacetId;
use crate::parallel::each_task;
use crate::quadrature::RADON7;
use crate::space::Space;
use crate::tensor::SymTensor2;

/// Cells summed by one task. Fixed, so that sums do not depend on the number of threads.
const CHUNK: usize = 4096;

/// Sums a quantity over the cells in an order that does not depend on the number of threads.
pub fn sum_over_cells(count: usize, quantity: impl Fn(usize) -> f64 + Sync) -> f64 {
    let of_chunk = |k: usize| (k * CHUNK..count.min((k + 1) * CHUNK)).map(&quantity).sum();
    sum_of_chunks(count.div_ceil(CHUNK), &of_chunk)
}

fn sum_of_chunks(chunks: usize, of_chunk: &(dyn Fn(usize) -> f64 + Sync)) -> f64 {
    each_task(chunks, of_chunk).iter().sum()
}

/// Computes a norm from its square. A negative square is round-off and gives 0; NaN is returned unchanged, so that it
/// stays visible.
pub fn from_squared(squared: f64) -> f64 {
    if squared < 0.0 { 0.0 } else { squared.sqrt() }
}

/// Computes `‖u‖² = a(u, u) + ∫ k u²` of a displacement field, J/m.
pub fn energy_norm_squared<S: Space>(body: &Body<S>, displacement: &[S::Vector]) -> f64 {
    let mesh = body.mesh();
    let cells = sum_over_cells(mesh.cells().len(), |t| {
        let element = Element::<S>::new(mesh.corners(t));
        let strain = strain(body, t, &element, displacement);
        element.measure * S::contracted(body.material(t).stress(strain), strain)
    });
    cells + spring_energy(body, displacement)
}

/// Computes `∫ k u²` of the springs of a body, J/m.
pub fn spring_energy<S: Space>(body: &Body<S>, displacement: &[S::Vector]) -> f64 {
    let mesh = body.mesh();
    let of_facet = |(facet, springs): (FacetId, &FacetSprings<S>)| {
        let nodes = mesh.topology().facets()[facet];
        springs.energy(&S::axes(|k| displacement[nodes[k]]), mesh.facet_measure(facet))
    };
    body.facet_springs().map(of_facet).sum()
}

/// Computes `‖u − v‖²` for the difference of two displacement fields, J/m, springs included.
///
/// # Panics
/// If the fields do not have one entry per node.
pub fn energy_distance_squared<S: Space>(body: &Body<S>, u: &[S::Vector], v: &[S::Vector]) -> f64 {
    let nodes = body.mesh().points().len();
    assert!(
        [u.len(), v.len()] == [nodes; 2],
        "fields of {} and {} entries on {nodes} nodes",
        u.len(),
        v.len()
    );
    let difference: Vec<S::Vector> = u.iter().zip(v).map(|(a, b)| *a - *b).collect();
    energy_norm_squared(body, &difference)
}

/// Computes the exact energy error `‖σ(u_h) − σ‖²` in the complementary norm against a known stress field,
/// J/m, by Radon's rule on four congruent parts of every triangle.
pub fn energy_error_squared(
    body: &Body,
    displacement: &[Vector],
    exact: impl Fn(Vector) -> SymTensor2 + Sync,
) -> f64 {
    let stresses = crate::field::stresses(body, displacement);
    integrate(body.mesh(), |t, x| {
        let d = exact(x).minus(stresses[t]);
        body.material(t).complementary(d, d)
    })
}

/// Computes `∫ |u_h − u|²`, m⁴, against a known displacement field.
pub fn l2_error_squared(
    mesh: &TriMesh,
    displacement: &[Vector],
    exact: impl Fn(Vector) -> Vector + Sync,
) -> f64 {
    sum_over_cells(mesh.cells().len(), |t| {
        let corners = mesh.corners(t);
        let u = mesh.cells()[t].map(|n| displacement[n]);
        let at = |values: [Vector; 3], l: [f64; 3]| l[0] * values[0] + l[1] * values[1] + l[2] * values[2];
        let mean: f64 =
            RADON7.iter().map(|(l, w)| w * norm(at(u, *l) - exact(at(corners, *l))).powi(2)).sum();
        mean * mesh.measure(t)
    })
}

/// Integrates a function of triangle and position over a mesh, each triangle cut in four.
pub fn integrate(mesh: &TriMesh, function: impl Fn(usize, Vector) -> f64 + Sync) -> f64 {
    // Barycentric corners of the four congruent parts.
    const PARTS: [[[f64; 3]; 3]; 4] = {
        const A: [f64; 3] = [1.0, 0.0, 0.0];
        const B: [f64; 3] = [0.0, 1.0, 0.0];
        const C: [f64; 3] = [0.0, 0.0, 1.0];
        const AB: [f64; 3] = [0.5, 0.5, 0.0];
        const BC: [f64; 3] = [0.0, 0.5, 0.5];
        const CA: [f64; 3] = [0.5, 0.0, 0.5];
        [[A, AB, CA], [AB, B, BC], [CA, BC, C], [AB, BC, CA]]
    };
    sum_over_cells(mesh.cells().len(), |t| {
        let p = mesh.corners(t);
        let mut mean = 0.0;
        for part in &PARTS {
            for (m, w) in &RADON7 {
                let mut x = Vector::zeros();
                for (corner, weight) in part.iter().zip(m) {
                    for (l, q) in corner.iter().zip(&p) {
                        x += weight * l * q;
                    }
                }
                mean += 0.25 * w * function(t, x);
            }
        }
        mean * mesh.measure(t)
    })
}

#[cfg(test)]
mod tests {
    use super::from_squared;

    #[test]
    fn a_norm_hides_no_nan() {
        assert_eq!(from_squared(4.0), 2.0);
        assert_eq!(from_squared(-1e-30), 0.0);
        assert!(from_squared(f64::NAN).is_nan());
    }
}
