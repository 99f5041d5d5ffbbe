use super::*;
use crate::check::check_stress;
use crate::estimate_with;
use crate::johnson_mercier::{CellStress, distance_squared};
use crate::relax;
use fem_core::assembly::System;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::condensation::CondensedBody;
use fem_core::field;
use fem_core::geometry::{Vector, cross};
use fem_core::interface::{ContactProblem, ContactState, Gap, InterfaceSide};
use fem_core::material::Materials;
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::TriMesh;
use fem_core::mesh::generate::block;
use fem_core::prepared::PreparedProblem;
use fem_core::tensor::SymTensor2;
use nalgebra::{DMatrix, DVector};

/// Accuracy of the energy that the steps themselves compute with single-precision coefficients.
const SINGLE: f64 = 1e-6;

/// A block of irregular triangles, turned by an angle.
fn mesh(cells: [usize; 2], angle: f64) -> TriMesh {
    let straight = block([0.0, 0.0], [1.5, 1.0], cells).unwrap();
    let (sin, cos) = angle.sin_cos();
    let boundary = |p: Vector| p[0] == 0.0 || p[0] == 1.5 || p[1] == 0.0 || p[1] == 1.0;
    let points = straight.points().iter().enumerate().map(|(i, &p)| {
        let h = if boundary(p) { 0.0 } else { 0.15 / cells[1] as f64 };
        let x = p[0] + h * (7.3 * i as f64).sin();
        let y = p[1] + h * (3.1 * i as f64).cos();
        [cos * x - sin * y, sin * x + cos * y]
    });
    let groups = straight.groups().iter().map(|(name, edges)| {
        (name.clone(), edges.iter().map(|&e| straight.topology().facets()[e]).collect())
    });
    TriMesh::new(points.collect(), straight.cells().to_vec(), groups.collect()).unwrap()
}

fn linear() -> ScalarData {
    ScalarData::function(|x| 2.0 + 3.0 * x[0] - x[1])
}

/// Every kind of support: what it is, the angle the mesh is turned by, and the conditions.
fn cases() -> Vec<(&'static str, f64, BoundaryConditions)> {
    let new = BoundaryConditions::new;
    vec![
        (
            "clamped, loaded, heavy",
            0.0,
            new().fix("bottom").traction("top", [1.0.into(), linear()]).body_force([0.7, -2.0]),
        ),
        (
            "rollers",
            0.0,
            new().roller("left", 0.0).roller("bottom", 0.01).traction("top", [0.0.into(), linear()]),
        ),
        (
            "turned rollers, heavy",
            0.6,
            new()
                .roller("left", 0.0)
                .roller("bottom", 0.01)
                .pressure("right", linear())
                .body_force([0.3, 0.9]),
        ),
        (
            "oblique reactions",
            0.6,
            new()
                .displace("bottom", Some(0.0.into()), None)
                .displace("left", None, Some(0.02.into()))
                .pressure("top", linear()),
        ),
        (
            "held along the tangent",
            0.0,
            new().fix("left").displace("bottom", Some(0.0.into()), None).pressure("top", linear()),
        ),
    ]
}

fn solve(mesh: TriMesh, conditions: &BoundaryConditions) -> (Body, EquilibratedStress) {
    let material = LinearElastic::isotropic(50.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let body = Body::new(mesh, material, conditions).unwrap();
    let system = System::assemble(&body, &InterfaceSide::default()).unwrap();
    let u = CondensedBody::factorise(system, body.mesh().points()).unwrap().displacement_from_force(&[]);
    let stress =
        EquilibratedStress::recover(&body, field::stresses(&body, &u), body.facet_conditions().to_vec());
    (body, stress)
}

fn energy(body: &Body, stress: &EquilibratedStress) -> f64 {
    (0..stress.finite_element.len())
        .map(|t| stress.cell_distance_squared(body, t, stress.finite_element[t]))
        .sum()
}

#[test]
fn every_step_is_in_equilibrium_and_lowers_the_energy() {
    for (name, angle, conditions) in cases() {
        let (body, eet) = solve(mesh([9, 6], angle), &conditions);
        let mut last = energy(&body, &eet);
        for steps in 0..12 {
            let mut stress = eet.clone();
            let report = relax(&body, &mut stress, Relaxation::Steps(steps));
            assert_eq!((report.steps, report.energy_history.len()), (steps, steps + 1));
            let found = energy(&body, &stress);
            assert!(found <= last, "{name}: {found} after {last}");
            assert!((report.energy_history[steps] / found - 1.0).abs() < SINGLE, "{name}");
            last = found;
            let residuals = check_stress(&body, &stress);
            assert!(residuals.is_valid(), "{name}: {residuals:?}");
        }
        assert!(last < 0.5 * energy(&body, &eet), "{name}: the relaxation gained too little");
    }
}

#[test]
fn the_difference_to_the_finite_element_stress_stays_orthogonal_to_its_strains() {
    let (body, mut stress) = solve(mesh([9, 6], 0.0), &cases()[0].2);
    relax(&body, &mut stress, Relaxation::Steps(3));
    // The strain of a displacement that vanishes on the clamped side.
    let nodes = body.mesh().points();
    let v: Vec<Vector> = nodes.iter().map(|p| Vector::new(p[1] * p[0].sin(), p[1] * (2.0 + p[0]))).collect();
    let virtual_stress = field::stresses(&body, &v);
    let with = |factor: f64| -> f64 {
        (0..virtual_stress.len())
            .map(|t| {
                let shifted = stress.finite_element[t].plus(virtual_stress[t].scaled(factor));
                stress.cell_distance_squared(&body, t, shifted)
            })
            .sum()
    };
    // ‖τ − σ̂ ∓ σ(v)‖² differ by four times the product.
    assert!((with(1.0) - with(-1.0)).abs() < 1e-12 * with(1.0));
}

/// The least energy over all edge moments in equilibrium, by dense algebra without Airy functions.
fn best(body: &Body, eet: &EquilibratedStress) -> f64 {
    let mesh = body.mesh();
    let topology = mesh.topology();
    let unknowns = 4 * topology.facets().len();
    let mut rows: Vec<DVector<f64>> = Vec::new();
    for t in 0..mesh.cells().len() {
        let mut balance = [DVector::zeros(unknowns), DVector::zeros(unknowns), DVector::zeros(unknowns)];
        for edge in topology.cell_facets()[t] {
            let edge = edge.index();
            let sign = if topology.facet_cells()[edge][0] as usize == t { 1.0 } else { -1.0 };
            for end in 0..2 {
                let x = mesh.points()[topology.facets()[edge][end]];
                for (c, unit) in [Vector::x(), Vector::y()].into_iter().enumerate() {
                    let unknown = 4 * edge + 2 * end + c;
                    balance[c][unknown] = sign;
                    balance[2][unknown] = sign * cross(x, unit);
                }
            }
        }
        rows.extend(balance);
    }
    for (&edge, condition) in topology.boundary_facets().iter().zip(&eet.conditions) {
        for (direction, end) in condition.reaction.complement().basis().iter().flat_map(|d| [(d, 0), (d, 1)])
        {
            let mut row = DVector::zeros(unknowns);
            row[4 * edge.index() + 2 * end] = direction[0];
            row[4 * edge.index() + 2 * end + 1] = direction[1];
            rows.push(row);
        }
    }
    // The null space of the conditions: eigenvectors of CᵀC without an eigenvalue.
    let conditions = DMatrix::from_columns(&rows);
    let eigen = (&conditions * conditions.transpose()).symmetric_eigen();
    let null: Vec<usize> = (0..unknowns).filter(|&k| eigen.eigenvalues[k].abs() < 1e-11).collect();
    let cells = mesh.cells().len();
    let difference = |a: &CellStress, b: &CellStress| -> CellStress {
        std::array::from_fn(|k| std::array::from_fn(|m| a[k][m].minus(b[k][m])))
    };
    let corrections: Vec<Vec<CellStress>> = null
        .iter()
        .map(|&k| {
            let mut moved = eet.clone();
            for (i, value) in eigen.eigenvectors.column(k).iter().enumerate() {
                moved.facet_moments[i / 4][i % 4 / 2][i % 2] += value;
            }
            (0..cells).map(|t| difference(&moved.cell(body, t), &eet.cell(body, t))).collect()
        })
        .collect();
    let start: Vec<CellStress> = (0..cells)
        .map(|t| eet.cell(body, t).map(|part| part.map(|s| s.minus(eet.finite_element[t]))))
        .collect();
    let norm = |a: &[CellStress]| -> f64 {
        (0..cells)
            .map(|t| distance_squared(&a[t], SymTensor2::default(), mesh.measure(t), body.material(t)))
            .sum()
    };
    let product = |a: &[CellStress], b: &[CellStress]| -> f64 {
        let sum: Vec<CellStress> = a
            .iter()
            .zip(b)
            .map(|(a, b)| std::array::from_fn(|k| std::array::from_fn(|m| a[k][m].plus(b[k][m]))))
            .collect();
        0.5 * (norm(&sum) - norm(a) - norm(b))
    };
    let n = null.len();
    let gram = DMatrix::from_fn(n, n, |i, j| product(&corrections[i], &corrections[j]));
    let gradient = DVector::from_fn(n, |i, _| product(&corrections[i], &start));
    norm(&start) - gradient.dot(&gram.cholesky().unwrap().solve(&gradient))
}

#[test]
fn the_fixed_point_is_the_best_of_all_edge_moments_in_equilibrium() {
    for (name, angle, conditions) in cases() {
        for cells in [[1, 1], [3, 2]] {
            let (body, mut stress) = solve(mesh(cells, angle), &conditions);
            let best = best(&body, &stress);
            let report = relax(&body, &mut stress, Relaxation::Steps(500));
            assert!(report.stationary, "{name}");
            let found = energy(&body, &stress);
            assert!((found / best - 1.0).abs() < 1e-9, "{name} {cells:?}: {found} against {best}");
            assert!(check_stress(&body, &stress).is_valid());
        }
    }
}

#[test]
fn stars_keep_the_resultant_between_two_supports() {
    // Clamped at both ends, free between: three functions, affine on each free side, belong to no star. They are columns.
    let conditions = BoundaryConditions::new().fix("left").fix("right").pressure("top", linear());
    let (body, eet) = solve(mesh([3, 2], 0.0), &conditions);
    let best = best(&body, &eet);
    let (mut by_stars, mut stress) = (eet.clone(), eet);
    StarRelaxation::new(&body, body.facet_conditions()).relax(&mut by_stars, Relaxation::Steps(500));
    relax(&body, &mut stress, Relaxation::Steps(500));
    let found = [&by_stars, &stress].map(|stress| energy(&body, stress));
    assert!(best < found[0] && found[0] < 1.1 * best, "{found:?} against {best}");
    assert!((found[1] / best - 1.0).abs() < 1e-12, "{found:?} against {best}");
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let (body, eet) = solve(mesh([60, 40], 0.6), &cases()[2].2);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut stress = eet.clone();
        let report = pool.install(|| relax(&body, &mut stress, Relaxation::Steps(4)));
        (stress.facet_moments, report)
    };
    let one = run(1);
    for threads in [2, 7] {
        assert!(run(threads) == one, "{threads} threads");
    }
}

#[test]
fn nothing_is_done_where_there_is_nothing_to_gain() {
    let rest = BoundaryConditions::new().fix("bottom");
    let uniform = BoundaryConditions::new().roller("left", 0.0).roller("bottom", 0.0).pressure("top", 3.0);
    for conditions in [rest, uniform] {
        let (body, mut stress) = solve(mesh([5, 4], 0.0), &conditions);
        let before = stress.facet_moments.clone();
        let report = relax(&body, &mut stress, Relaxation::Tolerance { tolerance: 0.02, max_steps: 10 });
        assert!(report.stationary && report.steps == 0, "{report:?}");
        assert_eq!(stress.facet_moments, before);
    }
}

#[test]
fn prepared_stars_relax_any_stress_of_the_same_supports() {
    let (body, eet) = solve(mesh([9, 6], 0.6), &cases()[3].2);
    let prepared = StarRelaxation::new(&body, &eet.conditions);
    let (mut one, mut other) = (eet.clone(), eet.clone());
    assert_eq!(
        prepared.relax(&mut one, Relaxation::Steps(3)),
        relax(&body, &mut other, Relaxation::Steps(3))
    );
    assert_eq!(one.facet_moments, other.facet_moments);
    // A second relaxation continues from the result of the first.
    let again = prepared.relax(&mut one, Relaxation::Steps(1));
    assert!(again.energy_history[1] < energy(&body, &other));
    assert!(check_stress(&body, &one).is_valid());
}

#[test]
#[should_panic(expected = "directions")]
fn prepared_stars_refuse_other_supports() {
    let (body, eet) = solve(mesh([3, 2], 0.0), &cases()[0].2);
    let mut stress = eet.clone();
    let prepared = StarRelaxation::new(&body, &eet.conditions);
    for condition in &mut stress.conditions {
        condition.reaction = Directions::NONE;
    }
    prepared.relax(&mut stress, Relaxation::Steps(1));
}

#[test]
fn the_tolerance_stops_when_little_is_left_to_gain() {
    let (body, eet) = solve(mesh([9, 6], 0.0), &cases()[0].2);
    let mut stress = eet.clone();
    let report = relax(&body, &mut stress, Relaxation::Tolerance { tolerance: 0.01, max_steps: 50 });
    let history = &report.energy_history;
    assert!(report.steps >= 2 && report.steps < 50 && report.steps + 1 == history.len());
    let ends = |steps: usize| crate::relaxation::left_to_gain(&history[..=steps]) <= 0.01;
    assert!(ends(report.steps) && !(1..report.steps).any(ends), "{history:?}");
    let mut same = eet.clone();
    relax(&body, &mut same, Relaxation::Steps(report.steps));
    assert_eq!(same.facet_moments, stress.facet_moments);
    let mut best = eet;
    let best = relax(&body, &mut best, Relaxation::Steps(500)).energy_history.last().copied().unwrap();
    assert!((history.last().unwrap() / best).sqrt() < 1.01, "{history:?} {best}");
}

/// Two blocks, the upper one pressed down on the lower one by an imposed common trace.
fn two_blocks(press: f64) -> (PreparedProblem, Vec<f64>) {
    let material = |e| LinearElastic::isotropic(e, 0.3, Hypothesis::PlaneStrain).unwrap();
    let upper = BoundaryConditions::new().fix("top");
    let lower = BoundaryConditions::new().fix("bottom");
    let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], [8, 5]).unwrap(), material(2000.0), &upper).unwrap();
    let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], [8, 4]).unwrap(), material(1000.0), &lower).unwrap();
    let interface =
        contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into())).unwrap();
    let trace = vec![press; interface.pairs().len()];
    (PreparedProblem::new(ContactProblem::between([upper, lower], interface)).unwrap(), trace)
}

#[test]
fn every_stage_of_an_estimate_is_admissible_and_splits_exactly() {
    let (problem, trace) = two_blocks(0.01);
    let displacement = [0, 1].map(|b| problem.bodies()[b].whole().unwrap().displacement_from_trace(&trace));
    let mut force = vec![0.0; trace.len()];
    problem.bodies()[1].whole().unwrap().interface().reaction(&trace, &mut force);
    assert!(force.iter().all(|f| *f > 0.0));
    let opening = vec![0.0; trace.len()];
    let state = ContactState::between([&displacement[0], &displacement[1]], &force, &opening);
    let mut last = (f64::INFINITY, f64::INFINITY);
    for steps in 0..6 {
        let e = estimate_with(&problem, &state, Relaxation::Steps(steps)).unwrap();
        assert!(e.admissibility.is_valid(), "{:?}", e.admissibility);
        assert!(e.cre.split_defect() < 1e-12, "{}", e.cre.split_defect());
        let relaxed: f64 = e.pair.bodies.iter().map(|b| b.relaxation.energy_history[steps]).sum();
        assert!((relaxed / e.cre.discretisation_squared - 1.0).abs() < SINGLE);
        let bound = e.certificate().unwrap();
        assert!(bound.e_cre < last.0 && bound.eta_dis < last.1);
        last = (bound.e_cre, bound.eta_dis);
    }
}

#[test]
fn a_zero_state_has_a_zero_certificate_at_every_stage() {
    let (problem, trace) = two_blocks(0.0);
    let displacement = [0, 1].map(|b| problem.bodies()[b].whole().unwrap().displacement_from_trace(&trace));
    let state = ContactState::between([&displacement[0], &displacement[1]], &trace, &trace);
    for relaxation in [Relaxation::Steps(3), Relaxation::Tolerance { tolerance: 0.02, max_steps: 9 }] {
        let e = estimate_with(&problem, &state, relaxation).unwrap();
        let bound = e.certificate().unwrap();
        assert_eq!((bound.e_cre, bound.eta_dis, bound.eta_nndd), (0.0, 0.0, 0.0));
    }
}

#[test]
fn equal_stars_share_coefficients_that_are_right_for_all_of_them() {
    let clamped = BoundaryConditions::new().fix("bottom");
    let structured = block([0.1, 0.2], [3.0, 1.0], [60, 20]).unwrap();
    // Two materials, so that stars of the same shape differ.
    let stiff = LinearElastic::isotropic(50.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let soft = LinearElastic::isotropic(10.0, 0.2, Hypothesis::PlaneStrain).unwrap();
    let stiff_cells = structured.cells().len() / 2;
    let of_triangle = (0..structured.cells().len()).map(|t| u32::from(t >= stiff_cells)).collect();
    let materials = Materials::by_cell(vec![stiff, soft], of_triangle);
    for (mesh, share) in [(structured, true), (mesh([60, 20], 0.3), false)] {
        let triangles: Vec<u32> = (0..mesh.cells().len() as u32).collect();
        let body = Body::new(mesh, materials.clone(), &clamped).unwrap();
        let stars = StarRelaxation::new(&body, body.facet_conditions());
        let spokes = 2 * body.mesh().topology().facets().len();
        let stored = stars.stored_couplings();
        assert!(if share { stored < spokes / 2 } else { stored >= spokes }, "{stored} of {spokes}");
        // A x of the answer of the preconditioner, and the forms of all triangles.
        let space = &stars.space;
        let [r, x, y] = std::array::from_fn(|_| AtomicSlots::zeros(space.len()));
        r.update(|i, _| (1.7 * i as f64).sin());
        stars.stars.precondition(&r, &x, &y);
        let mut forms = Vec::new();
        triangle_energy::forms(space, &triangles, 1.0, &mut forms);
        let mut product = vec![0.0; space.len()];
        for (t, form) in forms.iter().enumerate() {
            let (nodes, edges) = (body.mesh().cells()[t], body.mesh().topology().cell_facets()[t]);
            let place = |k: usize| {
                if k < 9 { 3 * nodes[k / 3].index() + k % 3 } else { space.edge_unknown(edges[k - 9]) }
            };
            for i in 0..UNKNOWNS {
                for j in 0..UNKNOWNS {
                    product[place(i)] += form[crate::inverse::packed(i, j)] * x.get(place(j));
                }
            }
        }
        let largest = product.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
        for (i, product) in product.iter().enumerate() {
            let found = stars.stars.unit() * y.get(i);
            assert!((found - product).abs() < SINGLE * largest, "{i}: {found} {product}");
        }
    }
}
