//! Linear elasticity alone: rates, exact solutions, and equilibrated stresses of single bodies.

use cre_estimator::EquilibratedStress;
use fem_core::assembly::external_forces;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::field;
use fem_core::geometry::{Vector, norm};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use fem_core::norm::{energy_error_squared, energy_norm_squared, l2_error_squared, sum_over_cells};
use fem_core::tensor::SymTensor2;
use std::f64::consts::PI;
use tests::run::{cell_imbalance, rate, solve_alone, stress_error_squared};
use tests::shapes::{turn, turned};
use tests::{cook, corner, smooth};

/// Recovers an equilibrated stress, checks the equilibrium of every triangle, and returns it with `‖τ − σ_h‖²`.
fn recover(body: &Body, u: &[Vector]) -> (EquilibratedStress, f64) {
    let stress =
        EquilibratedStress::recover(body, field::stresses(body, u), body.facet_conditions().to_vec());
    let [force, moment] = cell_imbalance(body, &stress);
    assert!(force < 1e-10 && moment < 1e-10, "{force:e} {moment:e}");
    let distance = sum_over_cells(stress.finite_element.len(), |t| {
        stress.cell_distance_squared(body, t, stress.finite_element[t])
    });
    (stress, distance)
}

fn divergence_by_differences(stress: impl Fn(Vector) -> SymTensor2, x: Vector) -> Vector {
    let h = 1e-5;
    let d = |c: usize| {
        let (mut a, mut b) = (x, x);
        a[c] += h;
        b[c] -= h;
        stress(a).minus(stress(b)).scaled(0.5 / h)
    };
    let (dx, dy) = (d(0), d(1));
    Vector::new(dx.xx + dy.xy, dx.xy + dy.yy)
}

fn strain_by_differences(displacement: impl Fn(Vector) -> Vector, x: Vector) -> SymTensor2 {
    let h = 1e-5;
    let d = |c: usize| {
        let (mut a, mut b) = (x, x);
        a[c] += h;
        b[c] -= h;
        (displacement(a) - displacement(b)).map(|v| 0.5 * v / h)
    };
    let (dx, dy) = (d(0), d(1));
    SymTensor2::new(dx[0], dy[1], 0.5 * (dx[1] + dy[0]))
}

#[test]
fn the_exact_fields_satisfy_the_equations() {
    let points = [[0.3, 0.4], [0.9, 0.1], [0.2, 0.8]].map(Vector::from);
    let near = |a: SymTensor2, b: SymTensor2| {
        let d = a.minus(b);
        assert!(d.contract(d).sqrt() < 1e-7 * (1.0 + b.contract(b).sqrt()), "{a:?} {b:?}");
    };
    for hypothesis in [Hypothesis::PlaneStrain, Hypothesis::PlaneStress] {
        let material = LinearElastic::isotropic(smooth::MATERIAL.0, smooth::MATERIAL.1, hypothesis).unwrap();
        let exact = smooth::Smooth::new(hypothesis);
        for x in points {
            near(material.stress(strain_by_differences(|x| exact.displacement(x), x)), exact.stress(x));
            let residual = divergence_by_differences(|x| exact.stress(x), x) + smooth::BODY_FORCE;
            assert!(norm(residual) < 1e-7, "{residual:?}");
        }
    }
    let (e, nu) = corner::MATERIAL;
    let material = LinearElastic::isotropic(e, nu, Hypothesis::PlaneStrain).unwrap();
    let exact = corner::exact();
    for x in points {
        near(material.stress(strain_by_differences(|x| exact.displacement(x), x)), exact.stress(x));
        assert!(norm(divergence_by_differences(|x| exact.stress(x), x)) < 1e-7);
    }
    assert!(((1.5 * PI * corner::EXPONENT).sin() - corner::EXPONENT).abs() < 1e-14);
    for side in [-1.0, 1.0] {
        for r in [0.1, 0.7] {
            let (sin, cos) = (0.75 * PI).sin_cos();
            let x = Vector::new(r * cos, side * r * sin);
            let traction = exact.stress(x).apply(Vector::new(-sin, side * cos));
            assert!(norm(traction) < 1e-13, "{traction:?}");
        }
    }
    let materials = [(1.0, 0.2), (20.0, 0.4)];
    for (b, exact) in tests::signorini::exact(materials, 0.7).into_iter().enumerate() {
        let (e, nu) = materials[b];
        let material = LinearElastic::isotropic(e, nu, Hypothesis::PlaneStrain).unwrap();
        for x in points {
            let x = if b == 0 { x } else { Vector::new(x[0] - 0.6, -x[1]) };
            near(material.stress(strain_by_differences(|x| exact.displacement(x), x)), exact.stress(x));
            assert!(norm(divergence_by_differences(|x| exact.stress(x), x)) < 1e-7);
        }
    }
}

#[test]
fn a_smooth_field_converges_with_rates_one_and_two() {
    for hypothesis in [Hypothesis::PlaneStrain, Hypothesis::PlaneStress] {
        let exact = smooth::Smooth::new(hypothesis);
        let errors = [4, 8, 16, 32].map(|n| {
            let body = smooth::body(hypothesis, n).unwrap();
            let u = solve_alone(&body);
            let energy = energy_error_squared(&body, &u, |x| exact.stress(x)).sqrt();
            let l2 = l2_error_squared(body.mesh(), &u, |x| exact.displacement(x)).sqrt();
            let (stress, distance) = recover(&body, &u);
            let stress = stress_error_squared(&body, &stress, |x| exact.stress(x)).sqrt();
            let identity = (distance / (energy * energy + stress * stress) - 1.0).abs();
            assert!(distance.sqrt() >= energy);
            [energy, l2, stress, identity]
        });
        for pair in errors.windows(2).skip(1) {
            let rates = [0, 1, 2, 3].map(|i| rate(pair[0][i], pair[1][i]));
            assert!((rates[0] - 1.0).abs() < 0.02, "energy: {rates:?}");
            assert!((rates[1] - 2.0).abs() < 0.05, "L²: {rates:?}");
            assert!((rates[2] - 1.0).abs() < 0.05, "equilibrated stress: {rates:?}");
        }
        // Prager and Synge: ‖τ−σ_h‖² = ‖u−u_h‖² + ‖σ−τ‖² but for the interpolated data.
        assert!(errors[3][3] < 1e-4, "{errors:?}");
    }
}

#[test]
fn a_corner_converges_with_the_rate_of_its_singularity() {
    let exact = corner::exact();
    let errors = [4, 8, 16, 32].map(|n| {
        let body = corner::body(n).unwrap();
        let u = solve_alone(&body);
        let energy = energy_error_squared(&body, &u, |x| exact.stress(x)).sqrt();
        let (_, distance) = recover(&body, &u);
        assert!(distance.sqrt() >= energy);
        energy
    });
    for pair in errors.windows(2) {
        let found = rate(pair[0], pair[1]);
        assert!((found - corner::EXPONENT).abs() < 0.02, "{found}");
    }
}

#[test]
fn cooks_membrane_reaches_the_known_tip_displacement() {
    let tips = [16, 32, 64, 128].map(|n| {
        let body = cook::body(n).unwrap();
        let u = solve_alone(&body);
        if n <= 32 {
            recover(&body, &u);
        }
        // Clapeyron: the loads' work is the energy.
        let work: f64 = external_forces(&body).iter().zip(&u).map(|(f, u)| f.dot(u)).sum();
        assert!((energy_norm_squared(&body, &u) / work - 1.0).abs() < 1e-9);
        let tip = (n / 2) * (n + 1) + n;
        assert!(norm(body.mesh().points()[tip] - Vector::new(48.0, 52.0)) < 1e-12);
        u[tip][1]
    });
    assert!(tips.windows(2).all(|t| t[0] < t[1]), "{tips:?}");
    // Aitken's extrapolation of the last three.
    let [a, b] = [tips[2] - tips[1], tips[3] - tips[2]];
    let limit = tips[3] + b * b / (a - b);
    assert!((limit - cook::TIP).abs() < 0.01, "{tips:?}: {limit}");
}

#[test]
fn turned_rollers_loads_and_weights_give_the_turned_solution() {
    let run = |angle: f64| {
        let traction = <[f64; 2]>::from(turn(angle, [0.4, -0.3])).map(ScalarData::from);
        let conditions = BoundaryConditions::new()
            .roller("left", 0.01)
            .roller("bottom", ScalarData::function(move |x| 0.005 * turn(-angle, x)[0]))
            .pressure("top", 0.8)
            .traction("right", traction)
            .body_force(turn(angle, [0.5, -2.0]));
        let mesh = turned(&block([-0.5, 0.2], [2.0, 1.0], [12, 7]).unwrap(), angle).unwrap();
        let material = LinearElastic::isotropic(100.0, 0.3, Hypothesis::PlaneStrain).unwrap();
        let body = Body::new(mesh, material, &conditions).unwrap();
        let u = solve_alone(&body);
        let (_, distance) = recover(&body, &u);
        (u, distance)
    };
    let (level, distance) = run(0.0);
    let size = level.iter().fold(0.0f64, |m, u| m.max(norm(*u)));
    for angle in [0.3, PI / 2.0, 2.2, -3.0] {
        let (oblique, turned_distance) = run(angle);
        for (u, v) in oblique.iter().zip(&level) {
            assert!(norm(*u - turn(angle, *v)) < 1e-12 * size, "{angle}: {u:?} against {v:?}");
        }
        assert!((turned_distance / distance - 1.0).abs() < 1e-10, "{angle}");
    }
}

#[test]
fn a_block_between_plates_under_its_weight_is_exact_at_the_nodes() {
    // With ν = 0 and rollers at the sides the problem is one-dimensional: u_y = −(ρg/2E) y (1 − y).
    let (young, weight) = (40.0, 9.81);
    let material = LinearElastic::isotropic(young, 0.0, Hypothesis::PlaneStrain).unwrap();
    let conditions = BoundaryConditions::new()
        .roller("left", 0.0)
        .roller("right", 0.0)
        .roller("bottom", 0.0)
        .roller("top", 0.0)
        .body_force([0.0, -weight]);
    let body = Body::new(block([0.0, 0.0], [2.0, 1.0], [9, 11]).unwrap(), material, &conditions).unwrap();
    let u = solve_alone(&body);
    for (x, u) in body.mesh().points().iter().zip(&u) {
        let exact = -weight / (2.0 * young) * x[1] * (1.0 - x[1]);
        assert!(norm(*u - Vector::new(0.0, exact)) < 1e-14, "{x:?}: {u:?} against {exact}");
    }
    // The data are piecewise linear, so Prager and Synge's identity holds to round-off.
    let (stress, distance) = recover(&body, &u);
    let error = energy_error_squared(&body, &u, |x| SymTensor2::new(0.0, -weight * (0.5 - x[1]), 0.0));
    let tau = stress_error_squared(&body, &stress, |x| SymTensor2::new(0.0, -weight * (0.5 - x[1]), 0.0));
    assert!((distance / (error + tau) - 1.0).abs() < 1e-10, "{distance} {error} {tau}");
}
