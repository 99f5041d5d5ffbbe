use super::*;
use crate::geometry::Vector;
use crate::material::{Hypothesis, LinearElastic};
use crate::mesh::TriMesh;
use crate::mesh::generate::block;

fn body(conditions: &BoundaryConditions) -> Result<Body, BodyError> {
    let mesh = block([0.0, 0.0], [2.0, 1.0], [4, 2]).unwrap();
    Body::new(mesh, LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap(), conditions)
}

#[test]
fn two_imposed_components_fix_a_corner() {
    let b = body(&BoundaryConditions::new().displace("left", Some(0.5.into()), None).roller("bottom", -0.25))
        .unwrap();
    assert!(b.node_constraints()[0].is_clamped());
    assert_eq!(b.node_constraints()[0].displacement(), Vector::new(0.5, 0.25));
    assert_eq!(b.node_constraints()[1].held.count(), 1);
    assert_eq!(b.node_constraints()[9], NodeConstraint::FREE);
    assert_eq!(b.supports()[0].nodes.len(), 3);
}

#[test]
fn data_that_meet_at_zero_to_round_off_agree() {
    let sine = |size: f64| ScalarData::function(move |x| size * (std::f64::consts::PI * x[0] / 2.0).sin());
    // sin π is 1e-16.
    let held = |top, right: f64| {
        let base = BoundaryConditions::new();
        body(&base.displace("top", None, Some(top)).displace("right", None, Some(right.into())))
    };
    assert!(held(sine(0.01), 0.0).is_ok());
    assert!(matches!(held(sine(0.01), 1e-13), Err(BodyError::Conflict { .. })));
    // A third direction at a corner that two conditions fix.
    let corner = BoundaryConditions::new().displace("left", Some(0.3.into()), Some(sine(1.0))).displace(
        "bottom",
        Some(0.3.into()),
        Some(0.0.into()),
    );
    assert!(body(&corner).is_ok());
}

#[test]
fn linear_tractions_are_exact_and_pressure_pushes() {
    let linear = ScalarData::function(|x| 3.0 * x[0] - 1.0);
    let b = body(&BoundaryConditions::new().pressure("top", 2.0).traction("bottom", [linear, 0.0.into()]))
        .unwrap();
    for &e in b.mesh().group("top").unwrap() {
        assert_eq!(b.facet_condition(e).unwrap().traction, [Vector::new(0.0, -2.0); 2]);
    }
    for &e in b.mesh().group("bottom").unwrap() {
        let nodes = b.mesh().topology().facets()[e];
        for (n, t) in nodes.iter().zip(b.facet_condition(e).unwrap().traction) {
            assert!((t[0] - (3.0 * b.mesh().points()[*n][0] - 1.0)).abs() < 1e-13);
        }
    }
}

#[test]
fn contradictions_are_refused() {
    let base = BoundaryConditions::new;
    let conflict = base().displace("left", Some(0.0.into()), None).displace("bottom", Some(0.1.into()), None);
    assert!(matches!(body(&conflict), Err(BodyError::Conflict { .. })));
    let loaded = base().displace("top", None, Some(0.0.into())).pressure("top", 1.0);
    assert!(matches!(body(&loaded), Err(BodyError::LoadOnSupport { .. })));
    let shear = base().displace("top", None, Some(0.0.into())).traction("top", [1.0.into(), 0.0.into()]);
    assert!(body(&shear).is_ok());
    assert!(matches!(body(&base().fix("botom")), Err(BodyError::UnknownGroup { .. })));
    assert!(matches!(body(&base().pressure("top", f64::NAN)), Err(BodyError::NotFinite { .. })));
    let part = FacetSelection::group("top").within([[5.0, 6.0], [0.0, 2.0]]);
    assert!(matches!(body(&base().fix(part)), Err(BodyError::EmptySelection { .. })));
}

/// A fan of three edges that turn by 20 and 80 degrees, all on a roller.
#[test]
fn rollers_hold_the_mean_normal_where_a_side_is_smooth_and_fix_its_corners() {
    let angles = [0.0f64, 20.0, 100.0];
    let mut points = vec![Vector::zeros()];
    for a in angles {
        let (sine, cosine) = a.to_radians().sin_cos();
        points.push(points[points.len() - 1] + Vector::new(cosine, sine));
    }
    let centre = points.len() as u32;
    points.push(Vector::new(0.5, 2.0));
    let triangles = (0..3).map(|k| [k, k + 1, centre]).collect();
    let groups = vec![("side".to_string(), (0..3).map(|k| [k, k + 1]).collect())];
    let mesh = TriMesh::new(points, triangles, groups).unwrap();
    let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let body = Body::new(mesh, steel, &BoundaryConditions::new().roller("side", 0.5)).unwrap();
    let mean = 10.0f64.to_radians();
    let held: Vec<(Vector, f64)> = body.node_constraints()[1].components().collect();
    let [(direction, value)] = held[..] else { panic!("{held:?}") };
    assert!((direction[0] - mean.sin()).abs() < 1e-15 && (direction[1] + mean.cos()).abs() < 1e-15);
    assert_eq!(value, 0.5);
    assert!(body.node_constraints()[2].is_clamped());
    let [direction] = body.node_constraints()[0].held.basis() else { panic!("one direction") };
    assert_eq!(direction[1], -1.0);
    // The bound does not hold if the fixed direction is not the edge's own.
    assert!((body.roller_turn() - mean.sin()).abs() < 1e-15);
}

/// Two edges that turn by 20 degrees, on a roller; next to it a wall of two edges at a right angle.
#[test]
fn a_bent_roller_whose_nodes_are_fixed_besides_still_shows() {
    let (sine, cosine) = 20.0f64.to_radians().sin_cos();
    let points = vec![[0.0, 0.0], [1.0, 0.0], [1.0 + cosine, sine], [0.5, 2.0]];
    let groups = vec![
        ("side".to_string(), vec![[0, 1], [1, 2]]),
        ("first".to_string(), vec![[0, 1]]),
        ("second".to_string(), vec![[1, 2]]),
    ];
    let mesh = TriMesh::new(points, vec![[0, 1, 3], [1, 2, 3]], groups).unwrap();
    let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let turn = |conditions: BoundaryConditions| {
        Body::new(mesh.clone(), steel.clone(), &conditions).unwrap().roller_turn()
    };
    let roller = |value: f64| BoundaryConditions::new().roller("side", value);
    let half = 10.0f64.to_radians().sin();
    assert!((turn(roller(0.5).displace("first", Some(0.0.into()), None)) - half).abs() < 1e-15);
    // If it is fixed, the middle node agrees with the normals of both edges.
    assert_eq!(turn(roller(0.0).displace("side", Some(0.0.into()), None)), 0.0);
    // Two rollers, each along a straight side: the corner between them agrees with both.
    assert_eq!(turn(BoundaryConditions::new().roller("first", 0.5).roller("second", 0.2)), 0.0);
}

#[test]
fn a_part_selects_edges_by_both_ends() {
    let part = FacetSelection::group("top").within([[0.0, 1.1], [f64::NEG_INFINITY, f64::INFINITY]]);
    let b = body(&BoundaryConditions::new().fix(part)).unwrap();
    assert_eq!(b.supports()[0].nodes.len(), 3);
}

/// A block at 27 degrees whose coordinates have seven digits, on a roller.
#[test]
fn a_slanted_roller_has_one_direction_though_its_coordinates_are_rounded() {
    let (sine, cosine) = 27.0f64.to_radians().sin_cos();
    let rounded = |x: f64| (x * 1e6).round() / 1e6;
    let at = |x: f64, y: f64| Vector::new(rounded(cosine * x - sine * y), rounded(sine * x + cosine * y));
    let mut points: Vec<Vector> = (0..=20).map(|i| at(0.1 * f64::from(i), 0.0)).collect();
    let above = points.len() as u32;
    points.extend((0..=20).map(|i| at(0.1 * f64::from(i), 0.3)));
    let cells = |i: u32| [[i, i + 1, above + i + 1], [i, above + i + 1, above + i]];
    let groups = vec![("side".to_owned(), (0..20).map(|i| [i, i + 1]).collect())];
    let mesh = TriMesh::new(points, (0..20).flat_map(cells).collect(), groups).unwrap();
    let steel = LinearElastic::isotropic(1.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let body = Body::new(mesh, steel, &BoundaryConditions::new().roller("side", 0.0)).unwrap();
    assert_eq!(body.roller_turn(), 0.0);
    let side = &body.node_constraints()[..21];
    assert!(side.iter().all(|node| node.held.count() == 1 && node.held == side[0].held));
}
