//! Two blocks from Rust: the paper's problem, with the paper's settings and with this crate's defaults.
//!
//! ```text
//!        u_y = −0.02                 Ω₁ = (0,2)×(1,2), E₁ = 2000, carries λ
//!      ┌─────────────┐               Ω₂ = (0,2)×(0,1), E₂ = 1000
//! u_x=0│     Ω₁      │→ (0, 30)      ν = 0.3, plane strain
//!      ├─────────────┤ Γ_C
//!      │     Ω₂      │ clamped
//!      └─────────────┘
//! ```
#![allow(clippy::print_stdout)]

use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::prepared::PreparedProblem;
use fem_core::{mesh::generate::block, norm};
use nndd::stopping::EtaNndd;
use nndd::{NnddSettings, NnddSolution};
use std::error::Error;

/// The problem with its factorised bodies.
struct Blocks(PreparedProblem);

impl Blocks {
    fn new(cells: [usize; 2]) -> Result<Self, Box<dyn Error>> {
        let material = |young| LinearElastic::isotropic(young, 0.3, Hypothesis::PlaneStrain);
        let pressed = BoundaryConditions::new()
            .displace("left", Some(0.0.into()), None)
            .displace("top", None, Some((-0.02).into()))
            .traction("right", [0.0.into(), 30.0.into()]);
        let upper = Body::new(block([0.0, 1.0], [2.0, 1.0], cells)?, material(2000.0)?, &pressed)?;
        let clamped = BoundaryConditions::new().fix("bottom");
        let lower = Body::new(block([0.0, 0.0], [2.0, 1.0], cells)?, material(1000.0)?, &clamped)?;
        let interface = contact_geometry::pair(&upper, &lower, ["bottom", "top"], &Gap::Given(0.0.into()))?;
        Ok(Self(PreparedProblem::new(ContactProblem::between([upper, lower], interface))?))
    }

    /// Iterates until η_NNDD has fallen by `tolerance`.
    fn solve(&self, settings: &NnddSettings, tolerance: f64) -> Result<NnddSolution, Box<dyn Error>> {
        let start = vec![0.0; self.0.node_pairs()];
        let mut stop = EtaNndd::new(tolerance);
        Ok(nndd::solve(&self.0.system(), start, settings, &mut stop)?)
    }

    /// Energies `a(u, u)` of the last iteration's displacements: λ gives those of Ω₁, the contact trace those of Ω₂.
    fn energies(&self, solution: &NnddSolution) -> [f64; 2] {
        let displacements = self.0.displacements(&solution.last.fields(&self.0.system()));
        [0, 1].map(|b| norm::energy_norm_squared(&self.0.problem().bodies[b], &displacements[b]))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let blocks = Blocks::new([18, 9])?;
    for (name, settings) in [("paper", NnddSettings::paper(0.4)), ("default", NnddSettings::default())] {
        let solution = blocks.solve(&settings, 1e-8)?;
        println!("{name}: theta {:.3}\n  it    precision     eta_nndd  contact        force", solution.theta);
        for row in &solution.history {
            let (it, pairs, force) = (row.iteration, row.contact_nodes, row.contact_force);
            println!("{it:4}  {:.5e}  {:.5e}  {pairs:7}  {force:11.6}", row.precision, row.eta_nndd);
        }
        let [first, second] = blocks.energies(&solution);
        println!("  energies {first:.9} {second:.9}\n");
    }
    Ok(())
}

#[test]
fn both_settings_reach_the_answer_of_an_independent_code() {
    // Values of a prototype in another language: η_NNDD of the first iterations, converged energies and contact force.
    let eta = [1.2270569444, 0.17789282682, 0.048336668644];
    let blocks = Blocks::new([18, 9]).unwrap();
    let paper = blocks.solve(&NnddSettings::paper(0.4), 1e-8).unwrap();
    for (row, eta) in paper.history.iter().zip(eta) {
        assert!((row.eta_nndd / eta - 1.0).abs() < 1e-8, "{row:?}");
    }
    let ours = blocks.solve(&NnddSettings::default(), 1e-8).unwrap();
    assert!(ours.history.len() < paper.history.len());
    for solution in [paper, ours] {
        assert!((solution.last.contact_force() - 26.2501595729).abs() < 1e-6);
        let [first, second] = blocks.energies(&solution);
        assert!((first - 0.751282805581).abs() < 1e-7 && (second - 0.332986279609).abs() < 1e-7);
    }
}
