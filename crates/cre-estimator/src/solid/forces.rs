//! The force residuals of a solid body, and in the same pass what the bound needs of its tetrahedra.

use super::cell::CellStress;
use super::with_offset;
use crate::equilibrated::EquilibratedStress;
use crate::measures::{Accuracy, Against, CellMeasures, Forces};
use crate::size::{larger, square};
use fem_core::body::Body;
use fem_core::double_double::DoubleDouble;
use fem_core::element::Element;
use fem_core::mesh::id::FacetId;
use fem_core::parallel::each_task;
use fem_core::space::{Solid, Space};
use fem_core::tensor::SymTensor3;
use nalgebra::Vector3;

/// Tetrahedra handled by one task.
const CHUNK: usize = 1024;

/// Stresses of a tetrahedron: four in each of four parts.
const NODES: usize = 16;

/// Tractions times area at the corners of the faces of a tetrahedron, from its stress: faces and corners in the order of [`Space::facet`].
type FaceTractions = [[Vector3<f64>; 3]; 4];

/// Computes the tractions times area on the faces of a tetrahedron.
pub(super) fn face_tractions(
    body: &Body<Solid>,
    t: usize,
    stress: &CellStress,
    of: &EquilibratedStress<Solid>,
) -> FaceTractions {
    let corners = body.mesh().corners(t);
    let fixed = if body.has_varying_force() { of.fixed(body, t) } else { None };
    std::array::from_fn(|k| {
        let [a, b, c] = Solid::facet(k).map(|corner| corners[corner]);
        let normal = (b - a).cross(&(c - a)) / 2.0;
        let fixed = fixed.map_or([Vector3::zeros(); 3], |fixed| fixed.loads[k]);
        [0, 1, 2].map(|corner: usize| Solid::applied(stress[k][corner], normal) + fixed[corner])
    })
}

/// Finds the largest square of a force without balance inside a tetrahedron: `|div τ + b|` times volume in its parts, and jumps between them.
fn inside(corners: &[Vector3<f64>; 4], stress: &CellStress, body_force: Vector3<f64>) -> f64 {
    let middle = corners.iter().sum::<Vector3<f64>>() / 4.0;
    let mut worst = 0.0;
    for (part, stress) in stress.iter().enumerate() {
        let [a, b, c] = Solid::facet(part).map(|corner| corners[corner]);
        let element = Element::<Solid>::new([a, b, c, middle]);
        let mut force = body_force * element.measure;
        for (at, gradient) in stress.iter().zip(&element.gradients) {
            force += Solid::applied(*at, gradient * element.measure);
        }
        worst = larger(worst, square(force));
    }
    for (first, second) in (0..4).flat_map(|s| (s + 1..4).map(move |t| (s, t))) {
        let (own, other) = (Solid::facet(first), Solid::facet(second));
        let mut shared = (0..3).filter_map(|i| Some((i, other.iter().position(|corner| *corner == own[i])?)));
        let (Some(i), Some(j)) = (shared.next(), shared.next()) else { continue };
        let [a, b] = [i, j].map(|(i, _)| corners[own[i]] - middle);
        let normal = a.cross(&b) / 2.0;
        for (i, j) in [i, j, (3, 3)] {
            let jump = |c: usize| {
                let [a, b]: [[f64; 6]; 2] = [stress[first][i].into(), stress[second][j].into()];
                a[c] - b[c]
            };
            let jump = SymTensor3::from(std::array::from_fn::<f64, 6, _>(jump));
            worst = larger(worst, square(Solid::applied(jump, normal)));
        }
    }
    worst
}

/// Finds the force residuals of a body, and measures its tetrahedra if `measured` says against what and how accurately.
pub(super) fn forces(
    body: &Body<Solid>,
    stress: &EquilibratedStress<Solid>,
    measured: Option<(Against<'_, Solid>, Accuracy)>,
) -> (Forces, CellMeasures<Solid>) {
    let mesh = body.mesh();
    let cells = mesh.cells().len();
    for given in measured.iter().flat_map(|(against, _)| against).flatten() {
        assert!(given.len() == cells, "a stress of {} tetrahedra on {cells}", given.len());
    }
    let chunks = each_task(cells.div_ceil(CHUNK), |k| {
        let (mut worst, mut tractions) = (Forces::default(), Vec::with_capacity(CHUNK));
        let mut measures = CellMeasures::<Solid>::default();
        for t in k * CHUNK..cells.min((k + 1) * CHUNK) {
            let (corners, found, load) = (mesh.corners(t), stress.cell(body, t), body.force(t).mean);
            worst.equilibrium = larger(worst.equilibrium, inside(&corners, &found, load));
            worst.scale = larger(worst.scale, square(load * mesh.measure(t)));
            tractions.push(face_tractions(body, t, &found, stress));
            if let Some((against, accuracy)) = measured {
                measure((body, stress), t, &found, (against, accuracy), &mut measures);
            }
        }
        (worst, tractions, measures)
    });
    let (mut worst, mut all) = (Forces::default(), CellMeasures::default());
    if let Some((against, accuracy)) = measured {
        all.reserve(cells, against, accuracy);
    }
    let mut tractions = Vec::with_capacity(cells);
    for (found, of_chunk, measures) in chunks {
        worst = worst.max(found);
        tractions.extend(of_chunk);
        for (all, part) in all.distances.iter_mut().zip(measures.distances) {
            all.extend(part);
        }
        all.mean.extend(measures.mean);
        all.exact_mean.extend(measures.exact_mean);
    }
    let faces = mesh.topology().facets().len();
    let of_faces = each_task(faces.div_ceil(CHUNK), |k| {
        let mut worst = Forces::default();
        (k * CHUNK..faces.min((k + 1) * CHUNK))
            .for_each(|face| of_face(body, stress, &tractions, FacetId::new(face), &mut worst));
        worst
    });
    (of_faces.into_iter().fold(worst, Forces::max), all)
}

/// Measures a tetrahedron.
fn measure(
    (body, of): (&Body<Solid>, &EquilibratedStress<Solid>),
    t: usize,
    stress: &CellStress,
    (against, accuracy): (Against<'_, Solid>, Accuracy),
    measures: &mut CellMeasures<Solid>,
) {
    for (distances, given) in measures.distances.iter_mut().zip(against) {
        if let Some(given) = given {
            distances.push(of.distance_in_cell(body, t, stress, given[t]));
        }
    }
    let fixed = of.fixed(body, t);
    let stress = &fixed.map_or(*stress, |fixed| with_offset(stress, &fixed));
    let numbers = |at: &SymTensor3| <[f64; 6]>::from(*at);
    let sum = |c: usize| stress.as_flattened().iter().map(|at| numbers(at)[c]).sum::<f64>();
    measures.mean.push(std::array::from_fn::<f64, 6, _>(|c| sum(c) / NODES as f64).into());
    if accuracy == Accuracy::Refined {
        let exact = |c: usize| {
            let sum = stress.as_flattened().iter().fold(DoubleDouble::ZERO, |sum, at| sum + numbers(at)[c]);
            sum / DoubleDouble::from(NODES as f64)
        };
        measures.exact_mean.push(std::array::from_fn(exact));
    }
}

/// Compares the forces on a face from both sides, or with the given ones, and raises `worst` to their differences.
fn of_face(
    body: &Body<Solid>,
    stress: &EquilibratedStress<Solid>,
    tractions: &[FaceTractions],
    face: FacetId,
    worst: &mut Forces,
) {
    let mesh = body.mesh();
    let topology = mesh.topology();
    let nodes = topology.facets()[face];
    // At the nodes of the face, in its own order.
    let from = |t: u32| {
        let (t, k) = (t as usize, topology.facet_in(t as usize, face));
        let corners = Solid::facet(k).map(|corner| mesh.cells()[t][corner]);
        nodes.map(|node| {
            let place = corners.iter().position(|corner| *corner == node).unwrap_or(0);
            tractions[t][k][place]
        })
    };
    let [first, second] = topology.facet_cells()[face];
    let own = from(first);
    if topology.is_boundary(face) {
        let condition = &stress.conditions[topology.boundary_place(face)];
        worst.compare_given::<Solid>(&own, condition, mesh.facet_measure(face));
    } else {
        worst.compare::<Solid>(&own, &from(second));
    }
}
