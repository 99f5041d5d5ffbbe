//! Solid bodies of tetrahedra, from the mesh to the displacement, against exact solutions.
// All of this is test code: a failed unwrap is a failed test.
#![allow(clippy::unwrap_used, clippy::panic)]

use fem_core::assembly::{System, external_forces};
use fem_core::body::{Body, BodyError, FreeMotion};
use fem_core::boundary::{BoundaryConditions, FacetSelection, RigidCondition, ScalarData};
use fem_core::condensation::CondensedBody;
use fem_core::directions::Directions;
use fem_core::field;
use fem_core::interface::{InterfaceSide, Retained};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::mesh::id::NodeId;
use fem_core::mesh::{Mesh, TetMesh};
use fem_core::norm;
use fem_core::space::{Solid, Space};
use nalgebra::{Matrix3, Rotation3, Vector3};
use std::sync::Arc;

type Vector = Vector3<f64>;
type Conditions = BoundaryConditions<Solid>;

const SIDES: [&str; 6] = ["left", "right", "front", "back", "bottom", "top"];

fn data(f: impl Fn(Vector) -> f64 + Send + Sync + 'static) -> ScalarData<Solid> {
    ScalarData::Function(Arc::new(f))
}

fn steel() -> LinearElastic<Solid> {
    LinearElastic::isotropic_solid(200.0, 0.3).unwrap()
}

/// A material without any symmetry.
fn full() -> LinearElastic<Solid> {
    let entry = |i: usize, j: usize| {
        let (low, high) = (i.min(j), i.max(j));
        if i == j { 100.0 + 7.0 * i as f64 } else { 3.0 * (low as f64 + 1.0) - 1.7 * high as f64 }
    };
    LinearElastic::from_solid_stiffness(std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j))))
        .unwrap()
}

/// A mesh with the same cells and sides whose nodes are moved.
fn moved(mesh: &TetMesh, to: impl Fn(Vector) -> Vector) -> TetMesh {
    let facets = |ids: &[_]| ids.iter().map(|f| mesh.topology().facets()[*f]).collect();
    let groups = mesh.groups().iter().map(|(name, ids)| (name.clone(), facets(ids))).collect();
    Mesh::new(mesh.points().iter().map(|x| to(*x)).collect(), mesh.cells().to_vec(), groups).unwrap()
}

fn solved(body: &Body<Solid>) -> Vec<Vector> {
    let system = System::assemble(body, &InterfaceSide::default()).unwrap();
    CondensedBody::factorise(system, body.mesh().points()).unwrap().displacement_from_force(&[])
}

fn largest(found: &[Vector], exact: impl Iterator<Item = Vector>) -> f64 {
    found.iter().zip(exact).map(|(u, e)| (u - e).norm()).fold(0.0, f64::max)
}

/// The gradient of a displacement that is not symmetric.
fn gradient() -> Matrix3<f64> {
    1e-3 * Matrix3::new(1.0, 4.0, -3.0, 2.0, -5.0, 7.0, 9.0, -1.0, 3.0)
}

/// The stress of [`gradient`].
fn stress(material: &LinearElastic<Solid>) -> Matrix3<f64> {
    let e = 0.5 * (gradient() + gradient().transpose());
    let strain = [e.m11, e.m22, e.m33, e.m23, e.m13, e.m12].into();
    let s = material.stress(strain);
    Matrix3::new(s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz)
}

#[test]
fn a_linear_displacement_is_reproduced_with_a_full_stiffness() {
    let bulge = |x: Vector| {
        let inner = x[0] * (2.0 - x[0]) * x[1] * (1.0 - x[1]) * x[2] * (1.0 - x[2]);
        x + inner * Vector::new(0.3, -0.5, 0.4)
    };
    let mesh = moved(&cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 3, 3]).unwrap(), bulge);
    let mut conditions = Conditions::default();
    for side in SIDES {
        let component = |c: usize| Some(data(move |x| (gradient() * x)[c]));
        conditions = conditions.components(side, [component(0), component(1), component(2)]);
    }
    let body = Body::new(mesh, full(), &conditions).unwrap();
    let u = solved(&body);
    assert!(largest(&u, body.mesh().points().iter().map(|x| gradient() * x)) < 1e-16);
    let exact = stress(&full());
    for s in field::stresses(&body, &u) {
        for (found, (i, j)) in [(s.xx, (0, 0)), (s.zz, (2, 2)), (s.yz, (1, 2)), (s.xy, (0, 1))] {
            assert!((found - exact[(i, j)]).abs() < 1e-13);
        }
    }
}

#[test]
fn a_bar_is_pulled() {
    let conditions = Conditions::default()
        .roller("left", 0.0)
        .roller("front", 0.0)
        .roller("bottom", 0.0)
        .traction("right", [3.0.into(), 0.0.into(), 0.0.into()]);
    let body =
        Body::new(cuboid([0.0; 3], [4.0, 1.0, 1.0], [12, 5, 4]).unwrap(), steel(), &conditions).unwrap();
    let u = solved(&body);
    let exact = |x: &Vector| 3.0 / 200.0 * Vector::new(x[0], -0.3 * x[1], -0.3 * x[2]);
    assert!(largest(&u, body.mesh().points().iter().map(exact)) < 1e-12 * 0.06);
    // ∫ σ²/E over a volume of 4.
    assert!((norm::energy_norm_squared(&body, &u) - 9.0 / 200.0 * 4.0).abs() < 1e-13);
}

/// The sides of a slanted block, each with two of its edges: none is perpendicular to another.
#[test]
fn rollers_on_slanted_planes_hold_a_block_in_uniform_stress() {
    let shape = Rotation3::from_euler_angles(0.4, -0.7, 1.1).matrix()
        * Matrix3::new(1.0, 0.2, 0.3, 0.0, 0.9, -0.2, 0.0, 0.0, 1.2);
    for shape in [*Rotation3::from_euler_angles(0.4, -0.7, 1.1).matrix(), shape] {
        let mesh = moved(&cuboid([0.0; 3], [1.0; 3], [3, 3, 3]).unwrap(), |x| shape * x);
        let normal = |side: &str| mesh.facet_normal(mesh.group(side).unwrap()[0]);
        let sigma = stress(&full());
        let mut conditions = Conditions::default();
        // On rollers only the normal component is imposed; the shear stress there is a traction, perpendicular to it.
        for side in SIDES {
            let n = normal(side);
            let traction = sigma * n;
            if ["left", "front", "bottom"].contains(&side) {
                conditions = conditions.roller(side, data(move |x| (gradient() * x).dot(&n)));
                let shear = traction - traction.dot(&n) * n;
                conditions = conditions.traction(side, [shear[0].into(), shear[1].into(), shear[2].into()]);
            } else {
                conditions =
                    conditions.traction(side, [traction[0].into(), traction[1].into(), traction[2].into()]);
            }
        }
        let body = Body::new(mesh, full(), &conditions).unwrap();
        assert_eq!(body.roller_turn(), 0.0);
        let u = solved(&body);
        let difference = largest(&u, body.mesh().points().iter().map(|x| gradient() * x));
        assert!(difference < 1e-15, "{difference:e}");
        // A node between two rollers is held in a plane, the corner of all three in space.
        let counts = body.node_constraints().iter().map(|constraint| constraint.held.count());
        let counts = counts.fold([0; 4], |mut all, count| {
            all[count] += 1;
            all
        });
        assert_eq!(counts, [27, 27, 9, 1]);
    }
}

#[test]
fn pressure_and_weight_are_carried_by_the_support() {
    let conditions = Conditions::default()
        .fix("bottom")
        .pressure("top", data(|x| 1.0 + x[0]))
        .body_force([0.3, 0.0, -2.0]);
    let body =
        Body::new(cuboid([0.0; 3], [2.0, 1.0, 0.5], [4, 2, 3]).unwrap(), steel(), &conditions).unwrap();
    // ∫ (1 + x) over the top is 4; the moment of the pressure about the y-axis is −∫ x (1 + x).
    let forces = external_forces(&body);
    let sum: Vector = forces.iter().sum();
    assert!((sum - Vector::new(0.3, 0.0, -2.0 - 4.0)).norm() < 1e-14);
    let moment: Vector = forces.iter().zip(body.mesh().points()).map(|(f, x)| x.cross(f)).sum();
    assert!((moment[1] - (0.3 * 0.25 + 2.0 + 2.0 + 8.0 / 3.0)).abs() < 1e-13, "{moment}");
    let u = solved(&body);
    let residual = field::nodal_residual(&body, &u);
    let bottom: Vector =
        residual.iter().zip(body.mesh().points()).filter(|(_, x)| x[2] == 0.0).map(|(r, _)| r).sum();
    assert!((bottom + sum).norm() < 1e-12);
    let rest = residual.iter().zip(body.mesh().points()).filter(|(_, x)| x[2] > 0.0);
    assert!(rest.map(|(r, _)| r.norm()).fold(0.0, f64::max) < 1e-13);
}

#[test]
fn a_free_body_has_six_motions_and_is_solved_with_springs() {
    let pulled = Conditions::default()
        .traction("right", [3.0.into(), 0.0.into(), 0.0.into()])
        .traction("left", [(-3.0).into(), 0.0.into(), 0.0.into()]);
    let body = Body::new(cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 3, 2]).unwrap(), steel(), &pulled).unwrap();
    assert!(matches!(body.free_motion(), Some(FreeMotion::Everything { .. })));
    let motions = body.rigid_motions();
    assert_eq!(motions.len(), 6);
    let free = Body::new(body.mesh().clone(), steel(), &Conditions::default()).unwrap();
    for motion in &motions {
        let u = motion.displacements(&free);
        let force = field::nodal_residual(&free, &u).iter().map(|r| r.norm()).fold(0.0, f64::max);
        assert!(force < 1e-12, "{motion:?} {force:e}");
    }
    let dofs = fem_core::dof::DofMap::new(&body, &InterfaceSide::default());
    let system = System::stabilised(&body, dofs).unwrap();
    let u = CondensedBody::factorise(system, body.mesh().points()).unwrap().displacement_from_force(&[]);
    for s in field::stresses(&body, &u) {
        assert!((s.xx - 3.0).abs() < 1e-12 && s.yy.abs() + s.zz.abs() + s.xy.abs() < 1e-12);
    }
}

#[test]
fn motions_that_supports_leave_free_are_named() {
    let motion = |conditions: Conditions| {
        let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [2, 2, 2]).unwrap();
        let body = Body::new(mesh, steel(), &conditions).unwrap();
        (body.free_motion(), body.rigid_motions().len())
    };
    let rollers =
        |sides: &[&str]| sides.iter().fold(Conditions::default(), |all, side| all.roller(*side, 0.0));
    assert_eq!(motion(rollers(&["left", "front", "bottom"])), (None, 0));
    assert_eq!(motion(rollers(&["left"])).1, 3);
    let (found, count) = motion(rollers(&["left", "front"]));
    assert_eq!(
        (found.unwrap().to_string().replace("-1", "1"), count),
        ("can translate along (0, 0, 1)".into(), 1)
    );
    // Held along one edge of the bottom by the rollers of two nodes: the box turns about it.
    let node =
        |x: f64| FacetSelection { node: Some(Vector::new(x, 0.0, 0.0)), ..FacetSelection::from("pin") };
    let hinge = Conditions::default().fix(node(0.0)).fix(node(2.0));
    let (found, count) = motion(hinge);
    let Some(FreeMotion::Rotation { centre, axis: Some(axis), .. }) = found else { panic!("{found:?}") };
    assert!(count == 1 && (axis[0].abs() - 1.0).abs() < 1e-12, "{axis}");
    assert!(centre[1].abs() < 1e-12 && centre[2].abs() < 1e-12, "{centre}");
}

#[test]
fn a_rigid_side_carries_six_resultants() {
    let (force, moment) = (Vector::new(0.7, -0.4, 1.1), Vector::new(0.2, 0.5, -0.3));
    let mesh = || cuboid([0.0; 3], [1.0, 1.0, 2.0], [3, 3, 5]).unwrap();
    let loaded = RigidCondition { edges: "top".into(), force, moment, ..Default::default() };
    let body = Body::new(mesh(), steel(), &Conditions::default().fix("bottom").rigid(loaded)).unwrap();
    let [side] = body.rigid_sides() else { panic!() };
    assert_eq!((side.motions.len(), side.ends.len()), (6, 12));
    let u = solved(&body);
    let (motion, difference) = side.motion_of(body.mesh().points(), &u);
    assert!(difference < 1e-15, "{difference:e}");
    // The loads do work on the motion: twice the energy.
    let work = force.dot(&motion.translation) + moment.dot(&motion.spin);
    assert!((norm::energy_norm_squared(&body, &u) / work - 1.0).abs() < 1e-12);
    // The same motion, imposed, needs the same resultants.
    let about = side.about;
    let given = Solid::motion(motion.translation, motion.spin).map(Some);
    let imposed = RigidCondition { edges: "top".into(), motion: given, ..Default::default() };
    let body = Body::new(mesh(), steel(), &Conditions::default().fix("bottom").rigid(imposed)).unwrap();
    let again = solved(&body);
    assert!(largest(&again, u.into_iter()) < 1e-15);
    let residual = field::nodal_residual(&body, &again);
    let (mut sum, mut turning) = (Vector::zeros(), Vector::zeros());
    for (r, x) in residual.iter().zip(body.mesh().points()).filter(|(_, x)| x[2] == 2.0) {
        sum += r;
        turning += (x - about).cross(r);
    }
    assert!((sum - force).norm() < 1e-13 && (turning - moment).norm() < 1e-13, "{sum} {turning}");
}

#[test]
fn a_node_may_retain_one_to_three_directions() {
    // The nodes of the top near the left side are on rollers, too, on two edges of it and on none.
    let away = [0.25, f64::INFINITY];
    let conditions = Conditions::default()
        .fix(FacetSelection::from("bottom").within([away, away, [f64::NEG_INFINITY, f64::INFINITY]]))
        .roller("left", 0.01)
        .roller("front", -0.02)
        .body_force([0.1, 0.2, -0.3]);
    let body = Body::new(cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 3, 3]).unwrap(), full(), &conditions).unwrap();
    let mesh = body.mesh();
    let mut top: Vec<NodeId> =
        mesh.group("top").unwrap().iter().flat_map(|f| mesh.topology().facets()[*f]).collect();
    top.sort_unstable();
    top.dedup();
    let along = |direction: Vector, nodes: &[NodeId]| -> Vec<Retained<Solid>> {
        nodes.iter().map(|node| Retained { node: *node, direction }).collect()
    };
    let side = InterfaceSide::default()
        .with_block(along(Vector::z(), &top))
        .with_block(along(Vector::new(0.0, 1.5, 2.0), &top[1..9]))
        .with_block(along(Vector::new(0.6, 0.0, -0.8), &top[..4]))
        .with_block(along(Vector::new(0.48, 0.6, 0.64), &top[12..15]));
    let system = System::assemble(&body, &side).unwrap();
    let condensed = CondensedBody::factorise(system, mesh.points()).unwrap();
    let forces: Vec<Vec<f64>> = (0..side.blocks())
        .map(|block| side.block(block).map(|k| 0.1 * (1.0 + k as f64).sin()).collect())
        .collect();
    let u = condensed.displacement_from_force(&condensed.dofs().interface_forces(&forces));
    let on_nodes: Vec<(NodeId, Vector)> = side
        .retained()
        .iter()
        .zip(forces.iter().flatten())
        .map(|(r, f)| (r.node, *f * r.direction))
        .collect();
    let difference = largest(&u, condensed.displacement_from_nodal_forces(&on_nodes).into_iter());
    assert!(difference < 1e-15, "{difference:e}");
    // S v = r + g̃, and v gives the traces of all directions.
    let mut loads = condensed.dofs().interface_forces(&forces);
    loads.iter_mut().zip(condensed.interface().condensed_load()).for_each(|(r, g)| *r += g);
    let mut v = vec![0.0; loads.len()];
    condensed.interface().trace_from_force(&loads, &mut v);
    let traces = condensed.dofs().traces(&v);
    for (retained, trace) in side.retained().iter().zip(traces.iter().flatten()) {
        assert!((u[retained.node].dot(&retained.direction) - trace).abs() < 1e-14);
    }
    for (constraint, u) in body.node_constraints().iter().zip(&u) {
        assert!(constraint.violation(*u) < 1e-16);
    }
}

#[test]
fn faults_of_conditions_are_in_the_words_of_solids() {
    let fault = |conditions: &Conditions| {
        let mesh = cuboid([0.0; 3], [1.0; 3], [2, 2, 2]).unwrap();
        Body::new(mesh, steel(), conditions).unwrap_err()
    };
    let unknown = fault(&Conditions::default().fix("lid"));
    assert!(unknown.to_string().contains("there is no face group \"lid\""), "{unknown}");
    let loaded = fault(&Conditions::default().roller("top", 0.0).pressure("top", 1.0));
    assert!(matches!(loaded, BodyError::LoadOnSupport { .. }), "{loaded}");
    let twice = fault(&Conditions::default().roller("top", 0.0).roller("top", 0.1));
    assert!(matches!(twice, BodyError::Conflict { values: [0.0, 0.1], .. }), "{twice}");
    let bad = fault(&Conditions::default().pressure("top", data(|x| 1.0 / (x[0] - x[0]))));
    assert!(matches!(bad, BodyError::NotFinite { .. }), "{bad}");
}

#[test]
fn a_box_leaves_its_rollers_by_parts_of_a_group() {
    // The facets of a part, by a box in all three coordinates.
    let all = [f64::NEG_INFINITY, f64::INFINITY];
    let part = FacetSelection::from("bottom").within([[0.0, 1.0], all, all]);
    let conditions = Conditions::default().roller(part, 0.0);
    let body =
        Body::new(cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2]).unwrap(), steel(), &conditions).unwrap();
    for (x, constraint) in body.mesh().points().iter().zip(body.node_constraints()) {
        let expected =
            if x[2] == 0.0 && x[0] <= 1.0 { Directions::along(-Vector::z()) } else { Directions::NONE };
        assert_eq!(constraint.held, expected);
    }
}
