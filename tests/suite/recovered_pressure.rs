//! The pressure of meshes that do not match, against Westergaard's closed form of a wavy surface.

use certified_contact::{CertifiedSolution, Settings, Silent, recovered_pressure, solve};
use contact_geometry::ContactNormal;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::interface::Gap;
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::generate::block;
use std::f64::consts::PI;
use tests::run::paired_in_common;

/// The load over the one that closes the gap.
const LOAD: f64 = 0.15;
/// Further loads.
const LOADS: [f64; 3] = [LOAD, 0.3, 0.5];
const DEPTH: f64 = 0.01;

fn solved(cells: [usize; 2], load: f64) -> CertifiedSolution {
    let steel = LinearElastic::isotropic(1000.0, 0.3, Hypothesis::PlaneStrain).unwrap();
    let part = |y: f64, cells, far: BoundaryConditions| {
        let sides = far.displace("left", Some(0.0.into()), None).displace("right", Some(0.0.into()), None);
        Body::new(block([-0.5, y], [1.0, 1.0], [cells, 24]).unwrap(), steel.clone(), &sides).unwrap()
    };
    let upper = part(0.0, cells[0], BoundaryConditions::new().pressure("top", load * closing()));
    let lower = part(-1.0, cells[1], BoundaryConditions::new().displace("bottom", None, Some(0.0.into())));
    let gap = Gap::Given(ScalarData::function(|x| DEPTH * (1.0 - (2.0 * PI * x[0]).cos())));
    let (problem, _) =
        paired_in_common([upper, lower], ["bottom", "top"], &gap, ContactNormal::Averaged).unwrap();
    solve(problem, &Settings::default(), &mut Silent).unwrap()
}

/// The pressure that closes the gap, `π E* Δ/λ`.
fn closing() -> f64 {
    PI * 1000.0 / (2.0 * 0.91) * DEPTH
}

fn exact(x: f64, load: f64) -> f64 {
    let left = load - (PI * x).sin().powi(2);
    2.0 * closing() * (PI * x).cos() * left.max(0.0).sqrt()
}

/// Places along the contact line, lengths of the nodes, pressures and recovered pressures.
struct Found {
    places: Vec<f64>,
    lengths: Vec<f64>,
    nodal: Vec<f64>,
    recovered: Vec<f64>,
    load: f64,
}

impl Found {
    fn new(cells: [usize; 2], load: f64) -> Self {
        let found = solved(cells, load);
        let pairs = found.problem.contacts[0].interface.pairs();
        let forces = &found.last().contact.normal_reaction;
        let points = found.problem.bodies[0].mesh().points();
        let lengths: Vec<f64> = pairs.iter().map(|pair| pair.weight).collect();
        let nodal: Vec<f64> = lengths.iter().zip(forces).map(|(length, p)| p / length).collect();
        let recovered = recovered_pressure(&found.problem, 0, forces).unwrap_or_else(|| nodal.clone());
        // No force is lost, and no pressure is negative.
        let sum: f64 = lengths.iter().zip(&recovered).map(|(length, p)| length * p).sum();
        assert!((sum / forces.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{sum}");
        assert!(recovered.iter().all(|p| *p > -1e-12 * closing()), "{recovered:?}");
        Self {
            places: pairs.iter().map(|pair| points[pair.nodes[0]][0]).collect(),
            lengths,
            nodal,
            recovered,
            load,
        }
    }

    /// Half of the width of the contact.
    fn half(&self) -> f64 {
        self.load.sqrt().asin() / PI
    }

    /// The largest deviation over the peak at nodes that count, without the ends of the contact: the slope of the exact one is infinite there.
    fn largest(&self, p: &[f64], counts: impl Fn(f64) -> bool) -> f64 {
        let nodes = self.places.iter().zip(p).filter(|(x, _)| x.abs() < 0.8 * self.half() && counts(**x));
        nodes.map(|(x, p)| (p - exact(*x, self.load)).abs() / exact(0.0, self.load)).fold(0.0, f64::max)
    }

    /// The root of the mean square deviation over the peak, with the ends of the contact and the open nodes beyond them.
    fn mean(&self, p: &[f64]) -> f64 {
        let square = |k: usize| {
            self.lengths[k] * (p[k] - exact(self.places[k], self.load)).powi(2) / (2.0 * self.half())
        };
        (0..p.len()).map(square).sum::<f64>().sqrt() / exact(0.0, self.load)
    }
}

#[test]
fn the_recovered_pressure_of_meshes_that_do_not_match_does_not_oscillate() {
    let same = Found::new([24, 24], LOAD);
    assert_eq!(same.nodal, same.recovered);
    let matching = same.largest(&same.nodal, |_| true);
    let of_24 = |x: f64| (24.0 * x - (24.0 * x).round()).abs() < 1e-9;
    for cells in [[24, 25], [25, 24], [24, 31], [31, 24]] {
        let found = Found::new(cells, LOAD);
        let nodal = found.largest(&found.nodal, |_| true);
        let [recovered, of_24] =
            [found.largest(&found.recovered, |_| true), found.largest(&found.recovered, of_24)];
        println!(
            "{cells:?} cells: nodal {nodal:.4}, recovered {recovered:.4}, {of_24:.4} at nodes of 24, matching {matching:.4}"
        );
        assert!(recovered < 0.5 * nodal && of_24 < 0.04, "{recovered} {of_24} {nodal}");
    }
}

/// Single pairs differ: where contact ends between nodes decides, on matching meshes too.
#[test]
fn the_recovered_pressure_deviates_on_average_as_on_matching_meshes_of_the_finer_side() {
    let pairs = [
        [24, 31],
        [31, 24],
        [24, 25],
        [20, 27],
        [16, 21],
        [24, 29],
        [41, 30],
        [24, 37],
        [33, 50],
        [12, 31],
        [25, 16],
        [18, 23],
        [20, 21],
        [30, 31],
        [33, 40],
    ];
    for load in LOADS {
        let mut sums = [0.0; 3];
        for cells in pairs {
            let found = Found::new(cells, load);
            let finer = Found::new([cells[0].max(cells[1]); 2], load);
            let row = [found.mean(&found.nodal), found.mean(&found.recovered), finer.mean(&finer.nodal)];
            println!(
                "{load}, {cells:?} cells: nodal {:.4}, recovered {:.4}, matching {:.4}",
                row[0], row[1], row[2]
            );
            sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += value / pairs.len() as f64);
        }
        let [nodal, recovered, matching] = sums;
        println!("{load}: nodal {nodal:.4}, recovered {recovered:.4}, matching {matching:.4}");
        assert!(recovered <= matching && recovered < 0.55 * nodal, "{load}: {recovered} {matching} {nodal}");
    }
}
