//! Face tractions in equilibrium with an FE stress: around each vertex a weighted graph Laplacian.
//!
//! For vertex `i` the moments `b_Γ = ∫_Γ F_Γ φ_i` on the faces of its star satisfy, for every tetrahedron `E` of the star,
//! ```math
//! ∑_{Γ ∋ i} ± b_Γ = q_E = ∫_E σ̂ ∇φ_i − ∫_E b φ_i
//! ```
//! The chosen moments are closest to the average FE traction, `∑ |b − b̄|²/|Γ|` least: with the incidence `D` of tetrahedra and faces,
//! the areas `W` and, on a face with a condition, the projection `P` on its directions of reaction,
//! ```math
//! (D W P Dᵀ) λ = q − D b̄,   b = b̄ + W P Dᵀ λ
//! ```
//! Moments of the tetrahedra are in equilibrium if the forces at their four corners are.

use crate::atomic_slots::AtomicSlots;
use crate::equilibrated::FacetMoments;
use crate::springs::relaxes;
use fem_core::body::{Body, FacetCondition};
use fem_core::directions::Directions;
use fem_core::element::Element;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::parallel::for_each_task;
use fem_core::space::{Solid, Space};
use fem_core::tensor::SymTensor3;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Vertices handled by one task.
const CHUNK: usize = 64;

/// A pivot below this fraction of its diagonal entry is round-off: the row depends on others.
const DEPENDENT: f64 = 1e-10;

/// Computes face moments in equilibrium with the FE stress `stress`, one tensor per tetrahedron, Pa.
///
/// * `conditions`: the condition on each boundary face, in the order of [`fem_core::mesh::topology::Topology::boundary_facets`].
///
/// `stress` must satisfy the FE equilibrium in every direction whose traction is given; otherwise the residual stays in the tetrahedra.
pub(crate) fn facet_moments(
    body: &Body<Solid>,
    stress: &[SymTensor3],
    conditions: &[FacetCondition<Solid>],
) -> FacetMoments<Solid> {
    let mesh = body.mesh();
    let (nodes, faces) = (mesh.points().len(), mesh.topology().facets().len());
    let recovery = Recovery { body, stress, conditions };
    // Each number is written from one vertex.
    let found = AtomicSlots::zeros(9 * faces);
    for_each_task(nodes.div_ceil(CHUNK), &|k| {
        for node in k * CHUNK..nodes.min((k + 1) * CHUNK) {
            recovery.vertex(NodeId::new(node), &found);
        }
    });
    let at = |slot: usize| Vector3::from_fn(|axis, _| found.get(slot + axis));
    (0..faces).map(|f| [0, 3, 6].map(|corner| at(9 * f + corner))).collect()
}

struct Recovery<'a> {
    body: &'a Body<Solid>,
    stress: &'a [SymTensor3],
    conditions: &'a [FacetCondition<Solid>],
}

/// A face of a star, with the moment about the vertex that acts on its first tetrahedron.
struct StarFace {
    face: FacetId,
    /// The corner at the vertex.
    corner: usize,
    /// The tetrahedra, by their place in the star; the second one of an inner face.
    cells: (usize, Option<usize>),
    /// The directions in which the moment is not given.
    free: Directions<Solid>,
    /// `b̄` in these directions, the given moment in others, N.
    moment: Vector3<f64>,
    /// |Γ|, m².
    area: f64,
    /// The inverse of the weight over |Γ| in the directions of reaction, if there are springs.
    springs: Option<Matrix3<f64>>,
}

impl Recovery<'_> {
    /// Finds the moments about a vertex.
    fn vertex(&self, node: NodeId, found: &AtomicSlots) {
        let cells = self.body.mesh().topology().cells_around(node);
        let mut faces = self.faces(node, cells);
        let mut defect: Vec<Vector3<f64>> =
            cells.iter().map(|cell| self.force(*cell as usize, node)).collect();
        for face in &faces {
            defect[face.cells.0] -= face.moment;
            if let Some(second) = face.cells.1 {
                defect[second] += face.moment;
            }
        }
        balance(&mut faces, &defect);
        for face in &faces {
            for (axis, value) in face.moment.iter().enumerate() {
                found.set(9 * face.face.index() + 3 * face.corner + axis, *value);
            }
        }
    }

    /// The inverse of `(1 + E/(k h))`, `h² = |Γ|`, along springs, and 1 in other directions of reaction.
    fn spring_weights(&self, face: FacetId, condition: &FacetCondition<Solid>) -> Matrix3<f64> {
        let mesh = self.body.mesh();
        let cell = mesh.topology().facet_cells()[face][0] as usize;
        let factor = self.body.material(cell).axial_modulus() / mesh.facet_measure(face).sqrt();
        let mut weight = Matrix3::identity();
        for (mut row, compliance) in weight.row_iter_mut().zip(&condition.springs.compliance) {
            row += compliance.transpose() * factor;
        }
        let onto = Matrix3::from_columns(&Solid::AXES.map(|axis| condition.reaction.project(axis)));
        onto * weight.try_inverse().unwrap_or_default() * onto
    }

    /// `q_E`, N.
    fn force(&self, cell: usize, node: NodeId) -> Vector3<f64> {
        let mesh = self.body.mesh();
        let element = Element::<Solid>::new(mesh.corners(cell));
        let k = mesh.cells()[cell].iter().position(|n| *n == node).unwrap_or(0);
        let internal = Solid::applied(self.stress[cell], element.gradients[k] * element.measure);
        internal - self.body.nodal_forces_inside(cell)[k]
    }

    /// The faces around a vertex in ascending order, with their average FE tractions and given moments.
    fn faces(&self, node: NodeId, cells: &[u32]) -> Vec<StarFace> {
        let mesh = self.body.mesh();
        let topology = mesh.topology();
        let around = |cell: &u32| {
            let corners = mesh.cells()[*cell as usize];
            let opposite = move |k: usize| !Solid::facet(k).iter().any(|corner| corners[*corner] == node);
            let facets = topology.cell_facets()[*cell as usize];
            (0..4).filter(move |k| !opposite(*k)).map(move |k| facets[k])
        };
        let mut list: Vec<FacetId> = cells.iter().flat_map(around).collect();
        list.sort_unstable();
        list.dedup();
        let place = |cell: u32| cells.iter().position(|other| *other == cell);
        let face = |face: FacetId| {
            let [first, second] = topology.facet_cells()[face];
            let area = mesh.facet_measure(face);
            let corner = topology.facets()[face].iter().position(|n| *n == node).unwrap_or(0);
            let normal = mesh.facet_normal(face) * (area / 3.0);
            let own = Solid::applied(self.stress[first as usize], normal);
            let mut springs = None;
            let (free, moment) = if topology.is_boundary(face) {
                let condition = &self.conditions[topology.boundary_place(face)];
                let traction = condition.expected_traction();
                let sum: Vector3<f64> = traction.iter().sum();
                let given = (sum + traction[corner]) * (area / 12.0);
                let held = if relaxes(condition) {
                    springs = Some(self.spring_weights(face, condition));
                    let across = condition.springs.directions.complement();
                    condition.reaction.project(across.project(own - given))
                } else {
                    condition.reaction.project(own - given)
                };
                (condition.reaction, held + given)
            } else {
                (Directions::ALL, 0.5 * (own + Solid::applied(self.stress[second as usize], normal)))
            };
            let cells = (place(first).unwrap_or(0), place(second));
            StarFace { face, corner, cells, free, moment, area, springs }
        };
        list.into_iter().map(face).collect()
    }
}

/// Adds `W P Dᵀ λ` to the moments, so that the defects of the tetrahedra vanish.
fn balance(faces: &mut [StarFace], defect: &[Vector3<f64>]) {
    // The three components are independent if every face holds all or none of them.
    let whole = |face: &StarFace| face.springs.is_none() && (face.free.is_none() || face.free.is_all());
    let apart = faces.iter().all(whole);
    let (size, blocks) = if apart { (defect.len(), 1) } else { (3 * defect.len(), 3) };
    let mut matrix = DMatrix::zeros(size, size);
    for face in faces.iter().filter(|face| !face.free.is_none()) {
        let projection = |i: usize, j: usize| -> f64 {
            match &face.springs {
                Some(weight) => weight[(i, j)],
                None if apart => 1.0,
                None => face.free.basis().iter().map(|d| d[i] * d[j]).sum(),
            }
        };
        for (i, j) in (0..blocks).flat_map(|i| (0..blocks).map(move |j| (i, j))) {
            let entry = face.area * projection(i, j);
            let at = |cell: usize, axis: usize| blocks * cell + axis;
            let first = face.cells.0;
            matrix[(at(first, i), at(first, j))] += entry;
            if let Some(second) = face.cells.1 {
                matrix[(at(second, i), at(second, j))] += entry;
                matrix[(at(first, i), at(second, j))] -= entry;
                matrix[(at(second, i), at(first, j))] -= entry;
            }
        }
    }
    let mut columns = if apart {
        DMatrix::from_fn(size, 3, |cell, axis| defect[cell][axis])
    } else {
        DMatrix::from_fn(size, 1, |k, _| defect[k / 3][k % 3])
    };
    solve_semi_definite(&mut matrix, &mut columns);
    let lambda = |cell: usize| {
        Vector3::from_fn(|axis, _| if apart { columns[(cell, axis)] } else { columns[(3 * cell + axis, 0)] })
    };
    for face in faces {
        let difference = lambda(face.cells.0) - face.cells.1.map_or(Vector3::zeros(), lambda);
        let along = match &face.springs {
            Some(weight) => weight * difference,
            None => face.free.project(difference),
        };
        face.moment += along * face.area;
    }
}

/// Solves a consistent system with a positive semi-definite matrix: unknowns that depend on others are zero. Overwrites both.
fn solve_semi_definite(matrix: &mut DMatrix<f64>, columns: &mut DMatrix<f64>) {
    let n = matrix.nrows();
    let floor: Vec<f64> = (0..n).map(|j| DEPENDENT * matrix[(j, j)]).collect();
    // L Lᵀ in the lower triangle; a row without a pivot is left out.
    for j in 0..n {
        let pivot = matrix[(j, j)];
        let root = if pivot > floor[j] { pivot.sqrt() } else { 0.0 };
        let factor = if root > 0.0 { 1.0 / root } else { 0.0 };
        matrix[(j, j)] = root;
        for i in j + 1..n {
            matrix[(i, j)] *= factor;
        }
        for k in j + 1..n {
            let left = matrix[(k, j)];
            if left != 0.0 {
                for i in k..n {
                    let change = left * matrix[(i, j)];
                    matrix[(i, k)] -= change;
                }
            }
        }
    }
    let quotient = |value: f64, root: f64| if root > 0.0 { value / root } else { 0.0 };
    for mut x in columns.column_iter_mut() {
        for j in 0..n {
            x[j] = quotient(x[j], matrix[(j, j)]);
            for i in j + 1..n {
                x[i] -= matrix[(i, j)] * x[j];
            }
        }
        for j in (0..n).rev() {
            let sum: f64 = (j + 1..n).map(|i| matrix[(i, j)] * x[i]).sum();
            x[j] = quotient(x[j] - sum, matrix[(j, j)]);
        }
    }
}
