//! The canonical problems of solids as case files, `cases/solid`: what is read and built has the figures of an independent code.

use case_io::case::AnyCase;
use fem_core::assembly::{System, external_forces};
use fem_core::condensation::CondensedBody;
use fem_core::interface::{ContactProblem, InterfaceSide};
use fem_core::norm::energy_norm_squared;
use fem_core::prepared::PreparedProblem;
use fem_core::space::Solid;
use nndd::stopping::EtaNndd;
use nndd::{NewtonSettings, solve};
use std::path::Path;

/// Builds a case with `n` cells per unit of length, `across` of them along x.
fn build(name: &str, n: usize, across: usize) -> ContactProblem<Solid> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("cases/solid").join(name);
    let bytes = std::fs::read(path).unwrap();
    let solid = |overrides: &[(String, String)]| match AnyCase::parse_bytes(&bytes, name, overrides).unwrap()
    {
        AnyCase::Solid(case) => case,
        AnyCase::Plane(_) => panic!("{name} is a case of the plane"),
    };
    let cells = |body| (format!("body.{body}.generator.cells"), format!("[{across}, {n}, {n}]"));
    let overrides: Vec<_> = (0..solid(&[]).bodies.len()).map(cells).collect();
    let (problem, notes) = solid(&overrides).build().unwrap();
    assert_eq!(notes, Vec::<String>::new());
    problem
}

/// The numbers of a solution.
struct Found {
    /// `½ a(u, u) − f·u`, J.
    potential: f64,
    /// `a(u, u)` of each body, J.
    energies: Vec<f64>,
    /// The sum of the contact forces of each pair, N.
    forces: Vec<f64>,
    /// The number of pairs of nodes with a force, of each pair.
    closed: Vec<usize>,
}

fn solved(problem: ContactProblem<Solid>) -> Found {
    let prepared = PreparedProblem::new(problem).unwrap();
    let start = vec![0.0; prepared.rows()];
    let last =
        solve(&prepared.system(), start, NewtonSettings::default(), &mut EtaNndd::new(1e-12)).unwrap().last;
    let fields = prepared.displacements(&last.fields(&prepared.system()));
    let problem = prepared.problem();
    let of_bodies = || problem.bodies.iter().zip(&fields);
    let energies: Vec<f64> = of_bodies().map(|(body, u)| energy_norm_squared(body, u)).collect();
    let work = of_bodies().flat_map(|(body, u)| external_forces(body).into_iter().zip(u));
    let work: f64 = work.map(|(f, u)| f.dot(u)).sum();
    let of_pairs = || problem.blocks().map(|pairs| &last.contact.normal_reaction[pairs]);
    Found {
        potential: 0.5 * energies.iter().sum::<f64>() - work,
        energies,
        forces: of_pairs().map(|forces| forces.iter().sum()).collect(),
        closed: of_pairs().map(|forces| forces.iter().filter(|force| **force > 0.0).count()).collect(),
    }
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found / expected - 1.0).abs() < tolerance, "{found:.13} is not {expected}");
}

/// Solves a body without contact and returns its energy.
fn energy(name: &str, n: usize) -> f64 {
    let problem = build(name, n, n);
    let [body] = &problem.bodies[..] else { panic!() };
    let system = System::assemble(body, &InterfaceSide::default()).unwrap();
    let condensed = CondensedBody::factorise(system, body.mesh().points()).unwrap();
    energy_norm_squared(body, &condensed.displacement_from_force(&[]))
}

#[test]
fn a_body_alone_has_the_energies_of_another_code() {
    // Its tractions are exact moments; these are integrated by a rule.
    for (n, known) in [(3, 3.667_533_807), (6, 3.704_162_294), (12, 3.716_781_437)] {
        assert_near(energy("gradient.toml", n).sqrt(), known, 1e-7);
    }
    for (n, known) in [(2, 0.420_279_269_763), (4, 0.465_995_189_677)] {
        assert_near(energy("weight.toml", n), known, 1e-11);
    }
}

#[test]
fn a_circular_contact_zone_has_the_forces_of_another_code() {
    // The loads are integrated by another rule.
    for (n, closed, force) in
        [(3, 4, 0.021_362_717_833_6), (6, 15, 0.019_576_732_261_9), (12, 50, 0.019_029_604_701_3)]
    {
        let found = solved(build("hertz.toml", n, n));
        assert_eq!(found.closed, [closed]);
        assert_near(found.forces[0], force, 1e-6);
    }
}

#[test]
fn half_open_blocks_have_the_forces_of_another_code() {
    let known = [
        (2, 12, 13.311_005_296_1, 0.193_219_090_71),
        (4, 30, 11.792_162_388_6, 0.162_120_223_154),
        (8, 90, 11.035_494_692_9, 0.144_298_330_688),
    ];
    for (n, closed, force, potential) in known {
        let found = solved(build("half_open.toml", n, 2 * n));
        assert_eq!(found.closed, [closed]);
        assert_near(found.forces[0], force, 1e-11);
        assert_near(found.potential, potential, 1e-10);
        if n == 2 {
            assert_near(found.energies[0], 0.224_504_065_268, 1e-11);
            assert_near(found.energies[1], 0.121_497_965_157, 1e-11);
        }
    }
}

#[test]
fn a_stack_with_a_floating_block_has_the_energies_of_another_code() {
    let known = [
        (
            2,
            [9, 12],
            [9.634_283_783_6, 29.634_283_784],
            [0.074_421_493_018, 0.193_603_542_67, 0.784_219_535_5],
        ),
        (
            4,
            [25, 31],
            [9.926_364_927_9, 29.926_364_928],
            [0.092_085_768_779, 0.235_503_475_13, 0.925_670_422_3],
        ),
    ];
    for (n, closed, forces, energies) in known {
        let found = solved(build("stack.toml", n, 2 * n));
        assert_eq!(found.closed, closed);
        found.forces.iter().zip(forces).for_each(|(found, known)| assert_near(*found, known, 1e-10));
        found.energies.iter().zip(energies).for_each(|(found, known)| assert_near(*found, known, 1e-9));
    }
}

#[test]
fn a_cube_in_a_corner_of_planes_has_the_energy_of_another_code() {
    for (n, closed, energy) in [(2, [7, 8, 9], 0.353_742_920_42), (4, [20, 21, 25], 0.383_216_646_65)] {
        let found = solved(build("corner.toml", n, n));
        assert_eq!(found.closed, closed);
        found
            .forces
            .iter()
            .zip([7.0, 7.0, 20.0])
            .for_each(|(found, known)| assert_near(*found, known, 1e-11));
        assert_near(found.energies[0], energy, 1e-10);
    }
}
