//! The bound against nested meshes, on random heated bodies under random linear forces.

use super::closed_forms::{bound, solve};
use crate::Recovery;
use crate::random::random;
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::geometry::Coordinates;
use fem_core::linear_field::LinearField;
use fem_core::material::{Hypothesis, LinearElastic, Materials};
use fem_core::mesh::Mesh;
use fem_core::mesh::generate::{block, cuboid};
use fem_core::mesh_field::MeshField;
use fem_core::norm::energy_distance_squared;
use fem_core::space::{Plane, Solid, Space};
use std::sync::Arc;

/// Random linear data, with a random size and some zeros.
fn linear<S: Space>(random: &mut impl FnMut() -> f64, size: f64) -> ScalarData<S> {
    let (value, slope) = (size * random(), S::Vector::of(|_| size * random()));
    ScalarData::Function(Arc::new(move |x: S::Vector| value + slope.times(&x)))
}

/// The same problem on two meshes: the bound on the coarse one is not below the distance of the two solutions.
///
/// * `meshes`: the coarse one, and a nested one; `materials`: two of them, with a contrast, expanding, with densities.
fn attack<S: Recovery>(seed: u64, meshes: [Mesh<S>; 2], materials: Vec<LinearElastic<S>>) {
    let mut random = signed(seed);
    let mut conditions = BoundaryConditions::<S>::default();
    conditions =
        if random() > 0.0 { conditions.fix("bottom") } else { conditions.fix("left").roller("bottom", 0.0) };
    if random() > -0.5 {
        conditions = conditions.temperature(linear::<S>(&mut random, 300.0));
    }
    if random() > 0.0 {
        conditions.force_field = Some(S::data(|_| linear::<S>(&mut random, 5.0)));
    }
    if random() > 0.0 {
        let vector = |random: &mut dyn FnMut() -> f64| S::Vector::of(|_| 5.0 * random());
        let (point, value) = (vector(&mut random), vector(&mut random));
        conditions.per_mass = Some(LinearField { point, value, gradient: S::axes(|_| vector(&mut random)) });
    }
    if random() > 0.0 {
        conditions = conditions.pressure("top", 10.0 * random());
    }
    let body = |mesh: &Mesh<S>| {
        // In the middle of the height, before the sides were turned.
        let (sheared, of_cell) =
            (sheared(mesh, seed), (0..mesh.cells().len()).map(|t| upper(mesh, t)).collect());
        Body::new(sheared, Materials::by_cell(materials.clone(), of_cell), &conditions).unwrap()
    };
    let [coarse, fine] = [body(&meshes[0]), body(&meshes[1])];
    let [u, finer] = [solve(&coarse), solve(&fine)];
    let on_fine = MeshField::new(coarse.mesh(), &u).on(fine.mesh());
    let distance = energy_distance_squared(&fine, &on_fine, &finer).sqrt();
    for steps in [0, 2, 6] {
        let bound = bound(&coarse, &u, steps);
        assert!(bound >= distance * (1.0 - 1e-9), "seed {seed}, {steps} steps: {bound} < {distance}");
        assert!(
            steps == 0 || distance == 0.0 || bound < 5.0 * distance,
            "seed {seed}, {steps} steps: {bound} {distance}"
        );
    }
}

/// Numbers from −1 to 1.
fn signed(seed: u64) -> impl FnMut() -> f64 {
    let mut random = random(seed);
    move || 2.0 * random() - 1.0
}

/// Tells the material of a cell: 1 above the middle of a height of 1.
fn upper<S: Space>(mesh: &Mesh<S>, cell: usize) -> u32 {
    let corners = mesh.corners(cell);
    u32::from(corners.into_iter().map(|x| x[S::DIM - 1]).sum::<f64>() > 0.5 * (S::DIM + 1) as f64)
}

/// Random constants of a material: modulus, ratio, expansion, density.
fn constants(seed: u64) -> [[f64; 4]; 2] {
    let mut random = signed(seed ^ 0x5eed);
    let mut one = || {
        let young = 1000.0 * 10f64.powf(random());
        [young, 0.2 + 0.2 * random(), 2e-5 * random(), 1.0 + random()]
    };
    [one(), one()]
}

#[test]
fn bounds_of_heated_and_loaded_bodies_hold() {
    for seed in 0..PLANE {
        let hypothesis = [Hypothesis::PlaneStrain, Hypothesis::PlaneStress][(seed % 2) as usize];
        let material = |[young, poisson, expansion, density]: [f64; 4]| {
            let made = LinearElastic::isotropic(young, poisson, hypothesis).unwrap();
            made.with_expansion(expansion).unwrap().with_density(density).unwrap()
        };
        let meshes = [1, 4].map(|n| block([0.0; 2], [2.0, 1.0], [6 * n, 4 * n]).unwrap());
        attack::<Plane>(seed, meshes, constants(seed).map(material).into());
    }
}

#[test]
fn bounds_of_heated_and_loaded_solids_hold() {
    for seed in 0..SOLID {
        let material = |[young, poisson, expansion, density]: [f64; 4]| {
            let made = LinearElastic::isotropic_solid(young, poisson).unwrap();
            made.with_expansion(expansion).unwrap().with_density(density).unwrap()
        };
        let meshes = [1, 2].map(|n| cuboid([0.0; 3], [2.0, 1.0, 1.0], [4 * n, 2 * n, 2 * n]).unwrap());
        attack::<Solid>(seed, meshes, constants(seed).map(material).into());
    }
}

/// Problems of each kind.
const PLANE: u64 = 60;
const SOLID: u64 = 6;

/// Maps a mesh by a random linear map, so that no side is along an axis.
fn sheared<S: Space>(mesh: &Mesh<S>, seed: u64) -> Mesh<S> {
    let mut random = signed(seed ^ 0xface);
    let map = S::axes(|j| S::AXES[j] + S::Vector::of(|_| 0.25 * random()));
    let moved = |x: &S::Vector| (1..S::DIM).fold(map[0] * x[0], |sum, j| sum + map[j] * x[j]);
    let groups = mesh.groups().iter().map(|(name, facets)| {
        (name.clone(), facets.iter().map(|f| mesh.topology().facets()[*f]).collect::<Vec<_>>())
    });
    let groups: Vec<_> = groups.collect();
    Mesh::new(mesh.points().iter().map(moved).collect(), mesh.cells().to_vec(), groups).unwrap()
}
