//! Corners in which the exact stress is infinite, so that the largest value of a mesh grows with every refinement.
//!
//! Near a corner of angle `ω` the stress is like `r^(λ−1)`. It is infinite for `λ < 1` (Williams 1952):
//!
//! | sides of the corner | `λ < 1` for |
//! |---|---|
//! | both free, or both held in both directions | `ω > 180°` |
//! | a roller, and a free side or one held in both directions | `ω > 90°`: half of a corner of `2ω` |
//! | two rollers | `ω > 90°`: `λ = π/ω − 1` |
//! | a free side, and one held in both directions | `sin² ω > 1/(1 + ν)` in plane stress, and all larger angles |
//!
//! Between a roller and a free side at 90° it is infinite like `ln r` if a tangential load ends there: mirrored at the roller, the load jumps.
//!
//! A sharp edge of angle `ω` whose other side is free and that presses without friction on a straight side, both isotropic (Dundurs and Lee
//! 1972): `ω ≥ 90°`, or `tan ω > ω + π c/c'` with the compliances `c` of the edge and `c'` of the side, `(1 − ν²)/E` in plane strain and
//! `1/E` in plane stress, and against a rigid side `ω > 90°`. If the other side is held, any edge on an elastic side. An edge on an edge is
//! not judged; for anisotropic materials the compliance along x is an approximation.

use crate::solved::Fields;
use crate::words::place;
use case_io::Case;
use fem_core::body::Body;
use fem_core::geometry::{Vector, cross, norm};
use fem_core::interface::{ContactProblem, Partner};
use fem_core::material::LinearElastic;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::tensor::SymTensor2;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};

/// The boundary turns by at least this at a corner: the polygon of a curve turns less.
const TURN: f64 = 30.0 / 180.0 * PI;
/// Angles closer to a limit than this are not above it.
const MARGIN: f64 = 1.0 / 180.0 * PI;
/// A reaction along the normal, as the sine of the angle between the two.
const NORMAL: f64 = 1e-6;

/// Why the stress is infinite, in words.
type Cause = &'static str;
const REENTRANT: Cause = "a reentrant corner";
const SUPPORT: Cause = "the end of a support";
const CONTACT: Cause = "a sharp contact edge";
const LOAD: Cause = "the end of a roller, where a tangential load ends,";

/// The support of a boundary edge.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Held {
    Free,
    Roller,
    Clamped,
    /// It may be in contact, or is held along its tangent only: such corners are not judged.
    Other,
}

/// Says whether the largest stress and the largest pressure lie in such a corner, or beside it.
pub(crate) fn of_fields(case: &Case, fields: &Fields<'_>) -> Vec<String> {
    let Some(results) = fields.results.filter(|_| !is_exact(fields)) else { return Vec::new() };
    let (problem, mut notes) = (fields.problem, Vec::new());
    let note = |what: &str, (body, node, cause): (usize, NodeId, Cause)| {
        let mesh = problem.bodies[body].mesh();
        format!(
            "the largest {what} is at {} of body \"{}\" at {}, and grows without limit as the mesh gets finer",
            cause,
            case.bodies[body].name,
            place(mesh.points()[node].as_slice(), mesh.diagonal())
        )
    };
    let stress = infinite_stress(fields);
    notes.extend(stress.map(|found| note("stress", found)));
    let pair =
        results.contacts.iter().enumerate().find(|(_, pair)| pair.max_pressure == results.max_pressure);
    let pressure = pair.and_then(|(k, found)| {
        let pair = &problem.contacts[k];
        let point = found.max_pressure_at?;
        let points = problem.bodies[pair.body].mesh().points();
        let k = pair.interface.pairs().iter().position(|p| points[p.nodes[0]] == point)? as u32;
        let beside = pair.interface.facets().iter().filter(|edge| edge.pairs.contains(&k));
        let near: BTreeSet<u32> = beside.flat_map(|edge| edge.pairs).chain([k]).collect();
        let nodes = near
            .into_iter()
            .flat_map(|k| pair.interface.pairs()[k as usize].nodes.into_iter().zip(pair.partners()));
        nodes.filter_map(|(node, of)| Some((of.body()?, node))).find_map(|(body, node)| {
            let cause = cause(problem, body, node).filter(|cause| *cause == CONTACT)?;
            Some((body, node, cause))
        })
    });
    notes.extend(pressure.map(|found| note("pressure", found)));
    notes
}

/// Below this relative error the stress of the mesh is exact, so that it is not infinite anywhere.
const EXACT: f64 = 1e-6;

fn is_exact(fields: &Fields<'_>) -> bool {
    fields.estimate.is_some_and(|found| found.unchecked().e_cre <= EXACT * found.energy_norm())
}

/// Tells whether the largest stress grows without limit as the mesh gets finer.
pub(crate) fn has_infinite_stress(fields: &Fields<'_>) -> bool {
    infinite_stress(fields).is_some()
}

/// Finds the corner of the largest stress.
fn infinite_stress(fields: &Fields<'_>) -> Option<(usize, NodeId, Cause)> {
    let peak = fields.results.filter(|_| !is_exact(fields))?.peak_stress?;
    (peak.von_mises > 0.0).then(|| near_point(fields.problem, peak.body, peak.point))?
}

/// Finds a corner with infinite stress at a node of a body, or within two cells of it.
fn near_point(problem: &ContactProblem, body: usize, point: Vector) -> Option<(usize, NodeId, Cause)> {
    let mesh = problem.bodies[body].mesh();
    let node = NodeId::new(mesh.points().iter().position(|p| *p == point)?);
    let mut near = BTreeSet::from([node]);
    for _ in 0..=2 {
        if let Some(found) = near.iter().find_map(|node| Some((body, *node, cause(problem, body, *node)?))) {
            return Some(found);
        }
        let around = near.iter().flat_map(|node| mesh.topology().cells_around(*node));
        near = around.flat_map(|t| mesh.cells()[*t as usize]).collect();
    }
    None
}

/// Judges the corner of a body at a node; `None` inside the body, and if the stress is finite there.
fn cause(problem: &ContactProblem, b: usize, node: NodeId) -> Option<Cause> {
    let body = &problem.bodies[b];
    let (angle, edges) = corner(body, node)?;
    let declared = edges.iter().all(|edge| body.curve_middle(*edge).is_some());
    if angle >= PI + TURN && !declared {
        return Some(REENTRANT);
    }
    if presses(problem, b, node, angle, edges) {
        return Some(CONTACT);
    }
    let held = edges.map(|edge| held(problem, b, edge));
    if let [Held::Roller, Held::Free] | [Held::Free, Held::Roller] = held
        && (angle - FRAC_PI_2).abs() <= MARGIN
        && edges.iter().any(|edge| has_tangential_load(body, *edge, node))
    {
        return Some(LOAD);
    }
    let limit = match held {
        [Held::Free, Held::Clamped] | [Held::Clamped, Held::Free] => clamped_free(material(body, node)?),
        [Held::Roller, Held::Free | Held::Clamped] | [Held::Free | Held::Clamped, Held::Roller] => {
            FRAC_PI_2 + 0.5 * TURN
        }
        // One roller on a side that hardly turns is no corner.
        [Held::Roller, Held::Roller] if angle < PI - TURN => FRAC_PI_2 + 0.5 * TURN,
        _ => return None,
    };
    (angle > limit + MARGIN).then_some(SUPPORT)
}

/// Tells whether the load on a boundary edge has a part along it at one of its nodes.
fn has_tangential_load(body: &Body, edge: FacetId, node: NodeId) -> bool {
    let (mesh, condition) = (body.mesh(), body.facet_condition(edge));
    let end = usize::from(mesh.topology().facets()[edge][1] == node);
    condition.is_some_and(|found| {
        let load = found.traction[end];
        cross(load, mesh.facet_normal(edge)).abs() > NORMAL * norm(load)
    })
}

/// The angle inside the body between the two boundary edges at a node, radians, and these edges.
fn corner(body: &Body, node: NodeId) -> Option<(f64, [FacetId; 2])> {
    let (mesh, topology) = (body.mesh(), body.mesh().topology());
    let (mut angle, mut edges) = (0.0, Vec::new());
    for &t in topology.cells_around(node) {
        let others = mesh.cells()[t as usize].into_iter().filter(|n| *n != node);
        let arms: Vec<Vector> = others.map(|n| mesh.points()[n] - mesh.points()[node]).collect();
        angle += cross(arms[0], arms[1]).abs().atan2(arms[0].dot(&arms[1]));
        let own = topology.cell_facets()[t as usize].into_iter();
        edges.extend(own.filter(|e| topology.is_boundary(*e) && topology.facets()[*e].contains(&node)));
    }
    Some((angle, edges.try_into().ok()?))
}

/// Finds what holds a boundary edge.
fn held(problem: &ContactProblem, b: usize, edge: FacetId) -> Held {
    let body = &problem.bodies[b];
    if touches(problem, b, edge) {
        return Held::Other;
    }
    match body.facet_condition(edge).map(|condition| condition.reaction) {
        Some(held) if held.is_none() => Held::Free,
        Some(held) if held.is_all() => Held::Clamped,
        Some(held) if held.contains(body.mesh().facet_normal(edge), NORMAL) => Held::Roller,
        _ => Held::Other,
    }
}

/// Tells whether an edge belongs to a contact line.
pub(crate) fn touches(problem: &ContactProblem, b: usize, edge: FacetId) -> bool {
    let mut sides = problem.sides_of(Partner::Body(b));
    sides.any(|(k, side)| {
        problem.contacts[k].interface.facets().iter().any(|contact| contact.facets[side] == edge)
    })
}

/// Tells whether a contact line ends at a sharp edge of a body that presses on a straight side of its partner.
fn presses(problem: &ContactProblem, b: usize, node: NodeId, angle: f64, edges: [FacetId; 2]) -> bool {
    let touching = edges.map(|edge| touches(problem, b, edge));
    if angle > PI - TURN || touching[0] == touching[1] {
        return false;
    }
    problem.sides_of(Partner::Body(b)).any(|(k, side)| {
        let pair = &problem.contacts[k];
        let Some(found) = pair.interface.pairs().iter().find(|pair| pair.nodes[side] == node) else {
            return false;
        };
        let Some(other) = pair.partners()[1 - side].body().map(|other| &problem.bodies[other]) else {
            return angle > FRAC_PI_2 + MARGIN;
        };
        let opposite = found.nodes[1 - side];
        let straight = corner(other, opposite).is_some_and(|(angle, _)| (angle - PI).abs() < TURN);
        let compliance = |body: &Body, node| Some(uniaxial(material(body, node)?)[0]);
        let ratio = compliance(&problem.bodies[b], node).zip(compliance(other, opposite)).map(|(c, d)| c / d);
        let is_held = |edge: &FacetId| matches!(held(problem, b, *edge), Held::Roller | Held::Clamped);
        straight
            && (edges.iter().any(is_held)
                || angle >= FRAC_PI_2 - MARGIN
                || ratio.is_some_and(|ratio| angle.tan() > angle + PI * ratio))
    })
}

/// The material of a cell at a node.
fn material(body: &Body, node: NodeId) -> Option<&LinearElastic> {
    Some(body.material(*body.mesh().topology().cells_around(node).first()? as usize))
}

/// The strains `[ε_xx, ε_yy]` under `σ_xx = 1`, 1/Pa.
fn uniaxial(material: &LinearElastic) -> [f64; 2] {
    let strain = material.strain(SymTensor2::new(1.0, 0.0, 0.0));
    [strain.xx, strain.yy]
}

/// The angle above which the stress between a free side and a clamped one is infinite: `sin² ω = (κ + 1)/4 = 1/(1 + ν)`, with the
/// Poisson's ratio `ν` of the plane problem.
fn clamped_free(material: &LinearElastic) -> f64 {
    let [along, across] = uniaxial(material);
    let poisson = (-across / along).max(0.0);
    (1.0 / (1.0 + poisson)).sqrt().asin()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem_core::boundary::{BoundaryConditions, FacetSelection};
    use fem_core::material::Hypothesis;
    use fem_core::mesh::TriMesh;
    use fem_core::mesh::generate::block;

    fn elastic(poisson: f64) -> LinearElastic {
        LinearElastic::isotropic(1.0, poisson, Hypothesis::PlaneStrain).unwrap()
    }

    fn square(poisson: f64, conditions: BoundaryConditions) -> ContactProblem {
        let mesh = block([0.0, 0.0], [2.0, 1.0], [12, 6]).unwrap();
        ContactProblem::new(vec![Body::new(mesh, elastic(poisson), &conditions).unwrap()])
    }

    fn at(problem: &ContactProblem, point: [f64; 2]) -> Option<Cause> {
        let points = problem.bodies[0].mesh().points();
        let node = points.iter().position(|p| *p == Vector::from(point)).unwrap();
        cause(problem, 0, NodeId::new(node))
    }

    #[test]
    fn supports_end_in_infinite_stress_by_williams_angles() {
        let fixed = square(0.3, BoundaryConditions::new().fix("bottom"));
        assert_eq!(at(&fixed, [0.0, 0.0]), Some(SUPPORT));
        assert_eq!(at(&fixed, [0.0, 1.0]), None);
        assert_eq!(at(&fixed, [1.0, 0.0]), None);
        assert!(near_point(&fixed, 0, Vector::new(1.0, 1.0)).is_none());
        // Without lateral contraction a clamped side is no obstacle to it.
        assert_eq!(at(&square(0.0, BoundaryConditions::new().fix("bottom")), [0.0, 0.0]), None);
        // A roller is a mirror: a corner of 90 degrees is a straight side, and its end within a side a crack.
        let half = FacetSelection::group("top").within([[0.0, 1.0], [1.0, 1.0]]);
        let rollers = square(0.3, BoundaryConditions::new().roller("left", 0.0).roller(half, 0.0));
        assert_eq!(at(&rollers, [0.0, 0.0]), None);
        let trapezoid = TriMesh::new(
            vec![[0.0, 0.0], [2.0, 0.0], [3.0, 1.7], [0.0, 1.7]],
            vec![[0u32, 1, 2], [0, 2, 3]],
            vec![("bottom".to_owned(), vec![[0u32, 1]]), ("right".to_owned(), vec![[1, 2]])],
        );
        // Two rollers at 120 degrees: λ = ½.
        let both = BoundaryConditions::new().roller("bottom", 0.0).roller("right", 0.0);
        let body = Body::new(trapezoid.unwrap(), elastic(0.3), &both).unwrap();
        assert_eq!(at(&ContactProblem::new(vec![body]), [2.0, 0.0]), Some(SUPPORT));
        assert_eq!(at(&rollers, [1.0, 1.0]), Some(SUPPORT));
        // A tangential load that ends at the mirror jumps there; a normal one does not.
        let loaded = |vector: [f64; 2]| {
            let loads = vector.map(|component| component.into());
            at(
                &square(0.3, BoundaryConditions::new().roller("left", 0.0).traction("bottom", loads)),
                [0.0, 0.0],
            )
        };
        assert_eq!((loaded([1.0, 0.0]), loaded([0.0, 1.0])), (Some(LOAD), None));
        let degrees =
            |hypothesis| clamped_free(&LinearElastic::isotropic(7.0, 0.3, hypothesis).unwrap()).to_degrees();
        assert!((degrees(Hypothesis::PlaneStress) - 61.29).abs() < 0.01);
        assert!((degrees(Hypothesis::PlaneStrain) - 56.79).abs() < 0.01);
    }

    #[test]
    fn only_corners_into_the_body_are_reentrant() {
        // Three squares of an L.
        let points = [[0., 0.], [1., 0.], [2., 0.], [0., 1.], [1., 1.], [2., 1.], [0., 2.], [1., 2.]];
        let triangles = vec![[0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4], [3, 4, 7], [3, 7, 6]];
        let mesh = TriMesh::new(points.to_vec(), triangles, vec![]).unwrap();
        let body = Body::new(mesh, elastic(0.3), &BoundaryConditions::new()).unwrap();
        let problem = ContactProblem::new(vec![body]);
        let reentrant = |point: &[f64; 2]| at(&problem, *point) == Some(REENTRANT);
        assert_eq!(points.iter().filter(|p| reentrant(p)).collect::<Vec<_>>(), [&[1.0, 1.0]]);
        // Beside the corner it is found as well.
        let near = near_point(&problem, 0, Vector::new(1.0, 2.0)).unwrap();
        assert_eq!((problem.bodies[0].mesh().points()[near.1], near.2), (Vector::new(1.0, 1.0), REENTRANT));
    }
}
