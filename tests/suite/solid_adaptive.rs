//! Adaptive runs of solids: the meshes of another code, runs that are resumed, declared surfaces.

use certified_contact::{
    AdaptSettings, AdaptiveEnd, AdaptiveSolution, CertifiedSolution, Checkpoint, Observer, Settings, Silent,
    resume_adaptively, solve, solve_adaptively,
};
use contact_geometry::{RefinedSolids, edge_order, halved};
use cre_estimator::Relaxation;
use cre_estimator::marking::doerfler;
use fem_core::interface::ContactProblem;
use fem_core::mesh::bisect::descendants;
use fem_core::space::Solid;
use nndd::NewtonSettings;
use tests::solids::{self, OnSphere};

/// The nodes of half-open blocks after rounds of another code, and `e_CRE` over the energy norm: it agrees to 1 % only, since its marks
/// are made of other digits.
const PRINTED: [(usize, f64); 3] = [(904, 0.343), (1609, 0.274), (2824, 0.2196)];

#[test]
fn half_open_blocks_have_the_meshes_of_another_code() {
    let mut settings = Settings::<Solid>::default().with_method(NewtonSettings::default());
    settings.relaxation = Relaxation::Steps(4);
    let mut problem = solids::half_open(2).unwrap();
    let mut order = edge_order(&problem).unwrap();
    let mut found = Vec::new();
    while problem.nodes() < 2000 || found.is_empty() {
        let solution = solve(problem, &settings, &mut Silent).unwrap();
        found.push((solution.problem.nodes(), solution.relative().unwrap()));
        let estimate = solution.estimate.as_ref().unwrap();
        let marked = doerfler(&estimate.cre.discretisation_by_cell, 0.5);
        let numbers = |of: &Vec<bool>| (0..of.len() as u32).filter(|cell| of[*cell as usize]).collect();
        let mut cells: Vec<Vec<u32>> = marked.iter().map(numbers).collect();
        problem = solution.problem;
        for _ in 0..2 {
            let RefinedSolids { problem: finer, refinements, order: next, .. } =
                halved(&problem, &order, &cells).unwrap();
            let parts = refinements.iter().zip(&cells);
            cells = parts.map(|(of, cells)| descendants(&of.parent_cell, cells)).collect();
            (problem, order) = (finer, next);
        }
    }
    let last = solve(problem, &settings, &mut Silent).unwrap();
    found.push((last.problem.nodes(), last.relative().unwrap()));
    println!("{found:?}");
    for (nodes, relative) in PRINTED {
        let near = |of: &&(usize, f64)| (of.0 as f64 / nodes as f64 - 1.0).abs() < 0.02;
        let of = found.iter().find(near).unwrap_or_else(|| panic!("{nodes}: {found:?}"));
        assert!((of.1 / relative - 1.0).abs() < 0.02, "{relative}: {found:?}");
    }
}

#[derive(Default)]
struct Record(Vec<Checkpoint>);

impl Observer<Solid> for Record {
    fn checkpoint(&mut self, checkpoint: &Checkpoint) {
        self.0.push(checkpoint.clone());
    }
}

type Solution = AdaptiveSolution<CertifiedSolution<Solid>, Solid>;

/// Everything of a solution, to the last bit.
fn bits(a: &Solution) -> Vec<u64> {
    let estimate = a.solution.estimate.as_ref().unwrap();
    let fields = estimate.pair.bodies.iter().flat_map(|b| b.displacement.iter().flatten());
    let meshes = a.solution.problem.bodies.iter().flat_map(|b| b.mesh().points().iter().flatten());
    let all = fields.chain(meshes).chain(&a.solution.last().lambda);
    all.chain(estimate.cre.by_cell.iter().flatten()).map(|x| x.to_bits()).collect()
}

#[test]
fn resumed_runs_of_solids_are_the_same_to_the_last_bit() {
    let sphere = solids::on_each_other(2, OnSphere::Socket).unwrap();
    for (problem, target) in [(solids::half_open(2).unwrap(), 0.4), (sphere, 0.25)] {
        let (settings, mut adapt) = (Settings::default(), AdaptSettings::new(target));
        adapt.max_nodes = 2500;
        let mut record = Record::default();
        let whole = solve_adaptively(problem.clone(), &settings, &adapt, &mut record).unwrap();
        assert!(matches!(whole.end, AdaptiveEnd::TargetMet), "{:?} {:?}", whole.end, whole.history);
        assert!(whole.history.len() > 2 && record.0.len() + 1 == whole.history.len());
        for checkpoint in record.0 {
            let again =
                resume_adaptively(problem.clone(), checkpoint, &settings, &adapt, &mut Silent).unwrap();
            assert_eq!((again.step, &again.history), (whole.step, &whole.history));
            assert_eq!(bits(&again), bits(&whole));
        }
    }
}

/// The largest distance of a contact node from the sphere of [`solids::on_each_other`], of both bodies, and of two partners, m.
fn off_sphere(problem: &ContactProblem<Solid>) -> [f64; 2] {
    let (mut off, mut apart) = (0.0f64, 0.0f64);
    for pair in problem.contacts[0].interface.pairs() {
        let at = [0, 1].map(|b: usize| problem.bodies[b].mesh().points()[pair.nodes[b]]);
        let centre = nalgebra::Vector3::new(0.0, 0.0, -1.0);
        at.iter().for_each(|x| off = off.max(((x - centre).norm() - 2.0).abs()));
        apart = apart.max((at[0] - at[1]).norm());
    }
    [off, apart]
}

#[test]
fn contact_nodes_on_a_declared_sphere_stay_partners_on_it() {
    let problem = solids::on_each_other(2, OnSphere::Socket).unwrap();
    let mut adapt = AdaptSettings::new(0.02);
    (adapt.max_nodes, adapt.max_steps) = (2000, 4);
    let found = solve_adaptively(problem, &Settings::default(), &adapt, &mut Silent).unwrap();
    assert!(found.solution.is_certified() && found.history.len() > 2, "{:?}", found.end);
    let [off, apart] = off_sphere(&found.solution.problem);
    assert!(off < 1e-10 && apart < 1e-10, "{off:e}, {apart:e}");
    // The ball may still spin in its socket: normals are (x − c)/R on all meshes.
    let normals = found.solution.problem.contacts[0].interface.pairs().iter();
    let points = found.solution.problem.bodies[0].mesh().points();
    for pair in normals {
        let normal = (points[pair.nodes[0]] - nalgebra::Vector3::new(0.0, 0.0, -1.0)) / 2.0;
        assert!((pair.normal + normal).norm() < 1e-9);
    }
}
