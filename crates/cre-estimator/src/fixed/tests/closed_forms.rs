//! Heated and spinning bodies: an independent program's figures, and closed forms.

use crate::check::check_stress_and_measure;
use crate::columns::relax;
use crate::equilibrated::EquilibratedStress;
use crate::measures::Accuracy;
use crate::relaxation::Relaxation;
use crate::round_off::Noise;
use fem_core::assembly::System;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, FacetSelection, ScalarData};
use fem_core::condensation::CondensedBody;
use fem_core::field;
use fem_core::geometry::Vector;
use fem_core::interface::InterfaceSide;
use fem_core::linear_field::LinearField;
use fem_core::material::{Hypothesis, LinearElastic, Materials};
use fem_core::mesh::generate::{block, cuboid};
use fem_core::mesh::{Mesh, TriMesh};
use fem_core::residual::{self, SplitField};
use fem_core::space::{Solid, Space};
use fem_core::tensor::SymTensor2;
use nalgebra::Vector3;

/// More steps gain nothing on these meshes.
const ALL: usize = 4 * LARGEST;
const LARGEST: usize = 400;

fn elastic(young: f64, poisson: f64, hypothesis: Hypothesis) -> LinearElastic {
    LinearElastic::isotropic(young, poisson, hypothesis).unwrap()
}

fn function(f: impl Fn(Vector) -> f64 + Send + Sync + 'static) -> ScalarData {
    ScalarData::function(f)
}

/// The displacements of a body alone.
pub(super) fn solve<S: Space>(body: &Body<S>) -> Vec<S::Vector> {
    let system = System::assemble(body, &InterfaceSide::default()).unwrap();
    CondensedBody::factorise(system, body.mesh().points()).unwrap().displacement_from_force(&[])
}

/// The stresses after iterative refinement.
fn refined<S: Space>(body: &Body<S>) -> Vec<S::Tensor> {
    let system = System::assemble(body, &InterfaceSide::default()).unwrap();
    let condensed = CondensedBody::factorise(system, body.mesh().points()).unwrap();
    let mut split = SplitField::new(condensed.displacement_from_force(&[]));
    condensed.refine(body, &[], false, &mut split);
    residual::stresses(body, &split)
}

/// The bound after some steps of relaxation. The stress is admissible after each.
pub(super) fn bound<S: crate::Recovery>(body: &Body<S>, displacement: &[S::Vector], steps: usize) -> f64 {
    let stress = refined(body);
    let mut stress = EquilibratedStress::recover(body, stress, body.facet_conditions().to_vec());
    // Steps in single precision begin again from the stress.
    for _ in 0..steps.div_ceil(LARGEST).max(1) {
        relax(body, &mut stress, Relaxation::Steps(steps.min(LARGEST)));
    }
    let squared = stress.distance_squared(body);
    // The pass that checks measures the same.
    let against = [Some(stress.finite_element.as_slice()), None];
    let (checks, cells) = check_stress_and_measure(
        body,
        (displacement, Noise::of(body)),
        &stress,
        Some((against, Accuracy::Double)),
    );
    assert!(checks.is_valid(), "{checks:?}");
    let sum: f64 = cells.distances[0].iter().sum();
    assert!((sum - squared).abs() <= 1e-12 * squared, "{sum} {squared}");
    squared.sqrt()
}

/// `∫ σ : E⁻¹ σ` of some cells.
fn energy<S: Space>(body: &Body<S>, displacement: &[S::Vector], of: impl Fn(usize) -> bool) -> f64 {
    let stresses = field::stresses(body, displacement);
    let cells = (0..stresses.len()).filter(|t| of(*t));
    let own = |t: usize| {
        body.mesh().measure(t) * body.material(t).complementary(stresses[t], stresses[t])
            + body.heat_energy(t)
    };
    cells.map(own).sum()
}

/// Compares the energy, and the bounds of EET, two steps and the best stress, with figures of an independent program.
fn compare(body: &Body, energies: &[f64], [eet, two, best]: [f64; 3]) {
    let u = solve(body);
    for (k, expected) in energies.iter().enumerate() {
        let found = energy(body, &u, |t| body.materials().index(t) == k);
        assert!((found / expected - 1.0).abs() < 1e-10, "energy {k}: {found} {expected}");
    }
    for (steps, expected, tolerance) in [(0, eet, 1e-10), (2, two, 2e-2), (ALL, best, 1e-9)] {
        let found = bound(body, &u, steps);
        assert!((found / expected - 1.0).abs() < tolerance, "{steps} steps: {found} {expected}");
    }
}

#[test]
fn a_warm_block_on_a_cold_one() {
    // Theory, 4a: one body of two materials.
    let mesh = block([0.0, 0.0], [2.0, 2.0], [18, 18]).unwrap();
    let upper = |t: usize| mesh.corners(t).iter().map(|x| x[1]).sum::<f64>() > 3.0;
    let of_cell = (0..mesh.cells().len()).map(|t| u32::from(!upper(t))).collect();
    let warm = elastic(2000.0, 0.3, Hypothesis::PlaneStrain).with_expansion(1e-5).unwrap();
    let list = vec![warm, elastic(1000.0, 0.3, Hypothesis::PlaneStrain)];
    let left = FacetSelection::group("left").within([[0.0, 0.0], [1.0, 2.0]]);
    let conditions = BoundaryConditions::new()
        .fix("bottom")
        .displace(left, Some(0.0.into()), None)
        .temperature(function(|x| 1000.0 * (1.0 + x[0] - x[1])));
    let body = Body::new(mesh, Materials::by_cell(list, of_cell), &conditions).unwrap();
    compare(&body, &[0.0472540896439, 0.0299604122197], [0.324218124677, 0.1020, 0.0979740774462]);
}

#[test]
fn a_linear_temperature_in_a_free_plate_makes_no_stress() {
    // Theory, 4b: the error is the whole FE stress, and the best bound is exact.
    let mesh = block([0.0, 0.0], [2.0, 1.0], [18, 9]).unwrap();
    let conditions = BoundaryConditions::new()
        .fix(FacetSelection::node("corner", [0.0, 0.0]))
        .displace(FacetSelection::node("end", [2.0, 0.0]), None, Some(0.0.into()))
        .temperature(function(|x| 100.0 * (1.0 + 2.0 * x[0] - x[1])));
    let material = elastic(1000.0, 0.3, Hypothesis::PlaneStress).with_expansion(1e-5).unwrap();
    let body = Body::new(mesh, material, &conditions).unwrap();
    compare(&body, &[3.85057950488e-05], [0.0239893799063, 0.00636, 0.00620530378376]);
}

/// A block with all corners moved by a map.
fn mapped(size: [f64; 2], cells: [usize; 2], map: impl Fn(&Vector) -> Vector) -> TriMesh {
    let mesh = block([0.0, 0.0], size, cells).unwrap();
    let edges = |edges: &Vec<_>| edges.iter().map(|e| mesh.topology().facets()[*e]).collect::<Vec<_>>();
    let groups: Vec<_> = mesh.groups().iter().map(|(name, group)| (name.clone(), edges(group))).collect();
    Mesh::new(mesh.points().iter().map(map).collect(), mesh.cells().to_vec(), groups).unwrap()
}

#[test]
fn a_sheared_block_under_a_linear_body_force() {
    // Theory, 5a.
    let mesh = mapped([2.0, 1.0], [18, 9], |x| Vector::new(x[0] + 0.5 * x[1], x[1]));
    let mut conditions = BoundaryConditions::new().fix("bottom").body_force([0.0, -10.0]);
    let linear = [
        function(|x| 20.0 * (x[0] - 1.0) + 5.0 * (x[1] - 0.5)),
        function(|x| -8.0 * (x[0] - 1.0) + 12.0 * (x[1] - 0.5)),
    ];
    conditions.force_field = Some(linear);
    let body = Body::new(mesh, elastic(1000.0, 0.3, Hypothesis::PlaneStrain), &conditions).unwrap();
    compare(&body, &[0.464871692251], [2.01457578137, 0.347, 0.263727482657]);
}

/// A quarter of a disc, or of a ring, with as many layers as chords; a disc has a fan at its centre.
fn quarter(inner: f64, chords: usize) -> TriMesh {
    let (mut points, mut cells) = (Vec::new(), Vec::new());
    let row = |i: usize| -> Vec<usize> {
        if inner == 0.0 && i == 0 {
            vec![0; chords + 1]
        } else {
            let first = if inner == 0.0 { 1 + (i - 1) * (chords + 1) } else { i * (chords + 1) };
            (first..=first + chords).collect()
        }
    };
    for i in 0..=chords {
        let radius = inner + (1.0 - inner) * i as f64 / chords as f64;
        for j in 0..=chords {
            let angle = std::f64::consts::FRAC_PI_2 * j as f64 / chords as f64;
            // On the axes exactly.
            let (x, y) =
                (if j == chords { 0.0 } else { angle.cos() }, if j == 0 { 0.0 } else { angle.sin() });
            if radius > 0.0 || j == 0 {
                points.push(Vector::new(radius * x, radius * y));
            }
        }
    }
    for i in 0..chords {
        let (near, far) = (row(i), row(i + 1));
        for j in 0..chords {
            cells.push([near[j], far[j], far[j + 1]].map(|n| n as u32));
            if near[j] != near[j + 1] {
                cells.push([near[j], far[j + 1], near[j + 1]].map(|n| n as u32));
            }
        }
    }
    let along = |j: usize| (0..chords).map(|i| [row(i)[j] as u32, row(i + 1)[j] as u32]).collect::<Vec<_>>();
    let groups = vec![("horizontal".to_owned(), along(0)), ("vertical".to_owned(), along(chords))];
    Mesh::new(points, cells, groups).unwrap()
}

/// A disc or a ring that turns with `ρ ω² = 100`.
fn spinning(inner: f64, chords: usize) -> Body {
    let material = elastic(1000.0, 0.3, Hypothesis::PlaneStress).with_density(4.0).unwrap();
    let mut conditions = BoundaryConditions::new().displace("vertical", Some(0.0.into()), None).displace(
        "horizontal",
        None,
        Some(0.0.into()),
    );
    let gradient = [Vector::new(25.0, 0.0), Vector::new(0.0, 25.0)];
    conditions.per_mass = Some(LinearField { point: Vector::zeros(), value: Vector::zeros(), gradient });
    Body::new(quarter(inner, chords), material, &conditions).unwrap()
}

#[test]
fn a_quarter_of_a_spinning_disc() {
    // Theory, 5b.
    compare(&spinning(0.0, 12), &[0.827368135466], [0.0726338056545, 0.04135, 0.0411944131972]);
}

#[test]
fn spinning_discs_and_rings_converge_to_the_closed_forms() {
    // ∫ σ : E⁻¹ σ of a quarter, and the displacement of the rim of a ring with the inner radius a:
    // u(1) = ρω²/(4E) ((1 − ν) + (3 + ν) a²).
    let exact = std::f64::consts::PI / 16.0 * 1e4 * 0.7 / 1000.0 * (3.3 / 4.0 - 1.3 / 6.0);
    for (chords, expected) in [(6, 0.959), (12, 0.9895), (24, 0.9974)] {
        let body = spinning(0.0, chords);
        let u = solve(&body);
        let found = energy(&body, &u, |_| true) / exact;
        assert!((found - expected).abs() < 6e-4, "{chords}: {found}");
    }
    let rim = 100.0 / 4000.0 * (0.7 + 3.3 * 0.0625);
    for (chords, expected) in [(12, 0.990), (24, 0.9973)] {
        let body = spinning(0.25, chords);
        let u = solve(&body);
        let place = body.mesh().points().iter().position(|x| x[0] == 1.0 && x[1] == 0.0).unwrap();
        let found = u[place][0] / rim;
        assert!((found - expected).abs() < 2e-3, "{chords}: {found}");
    }
}

/// The error of the stress in a body of the plane, J/m.
fn error(body: &Body, u: &[Vector], exact: impl Fn(Vector) -> SymTensor2 + Sync) -> f64 {
    let stresses = field::stresses(body, u);
    let of = |t: usize, x: Vector| {
        let corners = body.mesh().corners(t);
        let element = fem_core::element::Triangle::new(corners);
        let heat = body.heat_beyond_mean(t);
        let mut own = stresses[t];
        for k in 0..3 {
            let share =
                1.0 / 3.0 + element.gradients[k].dot(&(x - (corners[0] + corners[1] + corners[2]) / 3.0));
            own = own.minus(heat[k].scaled(share));
        }
        let d = exact(x).minus(own);
        body.material(t).complementary(d, d)
    };
    fem_core::norm::integrate(body.mesh(), of).sqrt()
}

#[test]
fn a_hanging_bar_is_bounded_sharply_straight_and_turned() {
    // ν = 0, clamped at x = 0, b = 3 + 10 x: σ = 3 (2 − x) + 5 (4 − x²).
    for (angle, best) in [(0.0, 1.000_000), (0.35, 1.000_034)] {
        let (sin, cos) = f64::sin_cos(angle);
        let mesh =
            mapped([2.0, 1.0], [18, 9], |x| Vector::new(cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]));
        let along = move |x: Vector| cos * x[0] + sin * x[1];
        let mut conditions = BoundaryConditions::new().fix("left");
        let force = |factor: f64| function(move |x| factor * (3.0 + 10.0 * along(x)));
        conditions.force_field = Some([force(cos), force(sin)]);
        let body = Body::new(mesh, elastic(1000.0, 0.0, Hypothesis::PlaneStrain), &conditions).unwrap();
        let u = solve(&body);
        let exact = |x: Vector| {
            let s = along(x);
            let s = 3.0 * (2.0 - s) + 5.0 * (4.0 - s * s);
            SymTensor2::new(s * cos * cos, s * sin * sin, s * sin * cos)
        };
        let error = error(&body, &u, exact);
        for (steps, expected, tolerance) in [(2, 1.012, 5e-3), (ALL, best, 2e-6)] {
            let found = bound(&body, &u, steps) / error;
            assert!(
                found >= 1.0 - 1e-10 && (found - expected).abs() < tolerance,
                "{angle}, {steps}: {found}"
            );
        }
    }
}

#[test]
fn heat_without_constraint_makes_no_stress_and_between_walls_the_exact_one() {
    let size = 1000.0 * 1e-5 * 100.0;
    for hypothesis in [Hypothesis::PlaneStress, Hypothesis::PlaneStrain] {
        let material = elastic(1000.0, 0.3, hypothesis).with_expansion(1e-5).unwrap();
        let mesh = || block([0.0, 0.0], [2.0, 1.0], [18, 9]).unwrap();
        let free = BoundaryConditions::new()
            .fix(FacetSelection::node("corner", [0.0, 0.0]))
            .displace(FacetSelection::node("end", [2.0, 0.0]), None, Some(0.0.into()))
            .temperature(100.0);
        let body = Body::new(mesh(), material.clone(), &free).unwrap();
        for s in refined(&body) {
            assert!(s.contract(s).sqrt() < 3e-13 * size, "{s:?}");
            // Along z the strain is prevented in plane strain.
            let zz = material.out_of_plane_stress(s, 100.0).unwrap();
            let expected = if hypothesis == Hypothesis::PlaneStrain { -size } else { 0.0 };
            assert!((zz - expected).abs() < 1e-12 * size, "{zz}");
        }
        let walls = BoundaryConditions::new()
            .roller("left", 0.0)
            .roller("right", 0.0)
            .roller("bottom", 0.0)
            .temperature(100.0);
        let body = Body::new(mesh(), material.clone(), &walls).unwrap();
        let u = solve(&body);
        let expected = if hypothesis == Hypothesis::PlaneStrain { -size / 0.7 } else { -size };
        for s in field::stresses(&body, &u) {
            let off = s.minus(SymTensor2::new(expected, 0.0, 0.0));
            assert!(off.contract(off).sqrt() < 1e-12 * size, "{s:?}");
            let zz = material.out_of_plane_stress(s, 100.0).unwrap();
            assert!(hypothesis == Hypothesis::PlaneStress || (zz - expected).abs() < 1e-12 * size, "{zz}");
        }
        assert!(bound(&body, &u, 2) < 1e-12 * size);
    }
}

#[test]
fn two_strips_bend_as_timoshenko_says() {
    // Δα ΔT 6 (1+m)²/(h (3 (1+m)² + (1+mn)(m² + 1/(mn)))) with m = 1, n = 2, h = 2.
    let exact = 1e-5 * 100.0 * 24.0 / (2.0 * (12.0 + 3.0 * 1.5));
    let mut ratios = Vec::new();
    for n in [1, 2] {
        let mesh = block([0.0, 0.0], [10.0, 2.0], [40 * n, 8 * n]).unwrap();
        let upper = |t: usize| mesh.corners(t).iter().map(|x| x[1]).sum::<f64>() > 3.0;
        let of_cell = (0..mesh.cells().len()).map(|t| u32::from(!upper(t))).collect();
        let strip = |young, expansion| {
            elastic(young, 0.3, Hypothesis::PlaneStress).with_expansion(expansion).unwrap()
        };
        let conditions = BoundaryConditions::new()
            .roller("left", 0.0)
            .displace(FacetSelection::node("corner", [0.0, 0.0]), None, Some(0.0.into()))
            .temperature(100.0);
        let list = vec![strip(2000.0, 1e-5), strip(1000.0, 2e-5)];
        let body = Body::new(mesh.clone(), Materials::by_cell(list, of_cell), &conditions).unwrap();
        let u = solve(&body);
        let at = |x: f64| u[body.mesh().points().iter().position(|p| *p == Vector::new(x, 1.0)).unwrap()][1];
        ratios.push((2.0 * (at(5.0) - at(0.0)) / 25.0).abs() / exact);
    }
    // Four times closer on the finer mesh.
    let off = [0, 1].map(|k: usize| 1.0 - ratios[k]);
    assert!(off[0] < 0.06 && (off[0] / off[1] - 4.0).abs() < 0.3, "{ratios:?}");
}

#[test]
fn a_cubic_temperature_is_bounded_with_its_data_error() {
    // ν = 0 between four walls: σ_xx = −E α mean(T), σ_yy = −E α T.
    let mesh = block([0.0, 0.0], [2.0, 1.0], [18, 9]).unwrap();
    let conditions = BoundaryConditions::new()
        .roller("left", 0.0)
        .roller("right", 0.0)
        .roller("bottom", 0.0)
        .roller("top", 0.0)
        .temperature(function(|x| 100.0 * x[0].powi(3)));
    let material = elastic(1000.0, 0.0, Hypothesis::PlaneStress).with_expansion(1e-5).unwrap();
    let body = Body::new(mesh, material, &conditions).unwrap();
    let u = solve(&body);
    let [inside] = body.interpolated_inside()[..] else { unreachable!("one datum is not linear") };
    let data = inside.energy.unwrap();
    // ‖ε₀ − ε₀'‖² = 2 E α² ∫ (T − T')², with T − T' = ½ T'' s (s − h) to leading order.
    let h = 2.0 / 18.0;
    let squared =
        (0..18).map(|k| (600.0 * (f64::from(k) + 0.5) * h).powi(2) * h.powi(5) / 120.0).sum::<f64>();
    let leading = (2.0 * 1000.0 * 1e-10 * squared).sqrt();
    assert!((data / leading - 1.0).abs() < 0.01, "{data} {leading}");
    let exact = |x: Vector| SymTensor2::new(-1e-2 * 200.0, -1e-2 * 100.0 * x[0].powi(3), 0.0);
    // Against the true temperature: the stress of the displacements has the true initial strain.
    let stresses = field::stresses(&body, &u);
    let own = |t: usize, x: Vector| {
        let mean = body.cell_temperature(t);
        let s = stresses[t];
        let shift = 1e-2 * (mean - 100.0 * x[0].powi(3));
        let d = exact(x).minus(s.plus(SymTensor2::new(shift, shift, 0.0)));
        body.material(t).complementary(d, d)
    };
    let error = fem_core::norm::integrate(body.mesh(), own).sqrt();
    let found = bound(&body, &u, ALL);
    assert!(found + data >= error && data < 0.07 * error, "{found} {data} {error}");
}

#[test]
fn far_from_the_origin_forces_stay_in_equilibrium() {
    let far = Vector::new(1e3, -2e3);
    let body = |shift: Vector| {
        let mut conditions = BoundaryConditions::new().fix("left");
        let force = |c: usize| function(move |x| 3.0 + 10.0 * (x - shift)[c] - 4.0 * (x - shift)[1 - c]);
        conditions.force_field = Some([force(0), force(1)]);
        let mesh = mapped([2.0, 1.0], [8, 4], |x| x + shift);
        Body::new(mesh, elastic(1000.0, 0.3, Hypothesis::PlaneStrain), &conditions).unwrap()
    };
    let [near, far] = [Vector::zeros(), far].map(|shift| {
        let body = body(shift);
        bound(&body, &solve(&body), 2)
    });
    assert!((near / far - 1.0).abs() < 1e-8, "{near} {far}");
}

#[test]
fn solids_between_walls_and_free_ones() {
    let material = LinearElastic::isotropic_solid(1000.0, 0.3).unwrap().with_expansion(1e-5).unwrap();
    let mesh = || cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2]).unwrap();
    // 4b in space: a linear temperature in a free body.
    let warm = ScalarData::Function(std::sync::Arc::new(|x: Vector3<f64>| 100.0 * (1.0 + 2.0 * x[0] - x[1])));
    let free = BoundaryConditions::<Solid>::default()
        .fix(FacetSelection::node("a", [0.0, 0.0, 0.0]))
        .components(FacetSelection::node("b", [2.0, 0.0, 0.0]), [None, Some(0.0.into()), Some(0.0.into())])
        .components(FacetSelection::node("c", [0.0, 1.0, 0.0]), [None, None, Some(0.0.into())]);
    let body = Body::new(mesh(), material.clone(), &free.clone().temperature(warm)).unwrap();
    let u = solve(&body);
    let error = energy(&body, &u, |_| true).sqrt();
    let [eet, best] = [0, 60].map(|steps| bound(&body, &u, steps));
    assert!(best >= error * (1.0 - 1e-9) && best < 1.001 * error && eet > best, "{error} {best} {eet}");
    let size = 1000.0 * 1e-5 * 100.0;
    let body = Body::new(mesh(), material.clone(), &free.temperature(100.0)).unwrap();
    for s in refined(&body) {
        assert!(Solid::contracted(s, s).sqrt() < 3e-13 * size, "{s:?}");
    }
    let walls = ["left", "right", "bottom", "front"];
    let walls = walls.iter().fold(BoundaryConditions::<Solid>::default(), |c, side| c.roller(*side, 0.0));
    let body = Body::new(mesh(), material, &walls.temperature(100.0)).unwrap();
    let u = solve(&body);
    for s in field::stresses(&body, &u) {
        assert!((s.xx + size).abs() + s.yy.abs() + s.zz.abs() + s.xy.abs() < 1e-11 * size, "{s:?}");
    }
    assert!(bound(&body, &u, 2) < 1e-11 * size);
}

#[test]
fn a_hanging_bar_of_tetrahedra_is_bounded() {
    // The bar of the plane, turned in space.
    for angles in [[0.0; 3], [0.3, 0.5, 0.7]] {
        let turn = nalgebra::Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2]).unwrap();
        let faces = |faces: &Vec<_>| faces.iter().map(|f| mesh.topology().facets()[*f]).collect::<Vec<_>>();
        let groups: Vec<_> = mesh.groups().iter().map(|(name, group)| (name.clone(), faces(group))).collect();
        let points = mesh.points().iter().map(|x| turn * x).collect();
        let mesh: Mesh<Solid> = Mesh::new(points, mesh.cells().to_vec(), groups).unwrap();
        let axis = turn * Vector3::x();
        let mut conditions = BoundaryConditions::<Solid>::default().fix("left");
        let force = |c: usize| {
            ScalarData::Function(std::sync::Arc::new(move |x: Vector3<f64>| {
                axis[c] * (3.0 + 10.0 * axis.dot(&x))
            }))
        };
        conditions.force_field = Some([force(0), force(1), force(2)]);
        let material = LinearElastic::isotropic_solid(1000.0, 0.0).unwrap();
        let body = Body::new(mesh, material, &conditions).unwrap();
        let u = solve(&body);
        // ∫ σ²/E of the exact stress, and by orthogonality the error.
        let exact = (0..2000).map(|k| {
            let s = (f64::from(k) + 0.5) / 1000.0;
            (3.0 * (2.0 - s) + 5.0 * (4.0 - s * s)).powi(2) / 1000.0 / 1000.0
        });
        let error = (exact.sum::<f64>() - energy(&body, &u, |_| true)).sqrt();
        let [eet, best] = [0, 30].map(|steps| bound(&body, &u, steps));
        assert!(best > error * (1.0 - 1e-5) && best < 1.05 * error && eet > best, "{error} {best} {eet}");
    }
}
