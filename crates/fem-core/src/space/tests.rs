use super::*;
use crate::geometry::Vector;
use crate::tensor::{SymTensor2, SymTensor3};
use nalgebra::Vector3;

#[test]
fn contraction_counts_the_shears_twice() {
    let t = SymTensor2::new(1.0, 2.0, 3.0);
    assert_eq!(Plane::contracted(t, t), t.contract(t));
    let t = SymTensor3::from([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(Solid::contracted(t, t), 1.0 + 4.0 + 9.0 + 2.0 * (16.0 + 25.0 + 36.0));
}

#[test]
fn components_are_in_the_rows_and_columns_of_their_names() {
    let t = SymTensor3::from([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let [x, y, z] = Solid::AXES;
    assert_eq!(Solid::applied(t, x).as_slice(), [t.xx, t.xy, t.xz]);
    assert_eq!(Solid::applied(t, y).as_slice(), [t.xy, t.yy, t.yz]);
    assert_eq!(Solid::applied(t, z).as_slice(), [t.xz, t.yz, t.zz]);
    let (t, n) = (SymTensor2::new(1.0, 2.0, 3.0), Vector::new(0.3, -0.7));
    assert_eq!(Plane::applied(t, n), t.apply(n));
}

#[test]
fn the_work_of_a_force_is_its_moment() {
    let (force, arm) = (Vector3::new(0.3, -0.7, 0.2), Vector3::new(1.0, 2.0, -0.5));
    let expected = Solid::motion(force, Solid::moment(arm, force) * 0.5);
    let difference = Solid::work(force, arm, 0.5).into_iter().zip(expected).map(|(a, b)| (a - b).abs());
    assert!(difference.fold(0.0, f64::max) < 1e-15);
}

#[test]
fn a_part_of_a_boundary_is_flat_or_not() {
    let line = [[0.0, 0.0], [0.3, 0.4], [0.6, 0.8]].map(Vector::from);
    let flat = Plane::flat_normal(&[[line[1], line[2]], [line[0], line[1]]], 1e-5).unwrap();
    assert!((flat - Vector::new(0.8, -0.6)).norm() < 1e-15);
    assert_eq!(Plane::flat_normal(&[[line[0], line[1]], [line[1], Vector::x()]], 1e-5), None);
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.0, 1.0, 0.5], [0.0, 1.0, 0.0]].map(Vector3::from);
    let facets = [[square[0], square[1], square[2]], [square[0], square[2], square[3]]];
    let normal = Solid::flat_normal(&facets, 1e-5).unwrap();
    assert!((normal - Vector3::new(-0.5, 0.0, 1.0).normalize()).norm() < 1e-15);
    let bent = [facets[0], [square[0], square[2], square[3] + 0.01 * Vector3::z()]];
    assert_eq!(Solid::flat_normal(&bent, 1e-5), None);
}
