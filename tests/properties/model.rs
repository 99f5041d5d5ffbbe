//! Random contact problems, and what may be done to them without changing their answer.
//!
//! ```text
//!   ┌────────┐ top held: u·n given      Everything random: cells, places of nodes, materials, loads, gap. Both bodies
//!   │   Ω₁   │→ traction                are held by rollers (u·n given) or clamped, so that every side may be turned.
//!   ├────────┤ gap
//!   │   Ω₂   │→ traction
//!   └────────┘ bottom clamped
//! ```

use fem_core::body::Body;
use fem_core::boundary::BoundaryConditions;
use fem_core::geometry::Vector;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::TriMesh;
use fem_core::mesh::generate::block;
use fem_core::mesh::id::{FacetId, NodeId};
use nndd::Iterate;
use proptest::prelude::*;
use tests::prepare;
use tests::random::Random;
use tests::run::{certify, newton};
use tests::shapes::{moved, turn};

/// A random problem.
#[derive(Clone, Debug)]
pub(crate) struct Model {
    /// Cells along the interface, and up each body.
    pub(crate) cells: [usize; 3],
    /// By how much of a cell nodes are moved, and how.
    pub(crate) shake: f64,
    pub(crate) seed: u64,
    pub(crate) young: [f64; 2],
    pub(crate) poisson: [f64; 2],
    pub(crate) plane_strain: bool,
    /// Displacement of the top along its outward normal.
    pub(crate) top: f64,
    pub(crate) traction: [Vector; 2],
    pub(crate) body_force: [Vector; 2],
    pub(crate) gap: f64,
}

/// Makes random problems.
pub(crate) fn models() -> impl Strategy<Value = Model> {
    let vector = |size: f64| [-size..size, -size..size];
    (
        ([4usize..10, 2usize..5, 2usize..5], 0.0..0.3f64, any::<u64>()),
        ([100.0..10_000.0f64, 100.0..10_000.0], [0.0..0.45f64, 0.0..0.45], any::<bool>()),
        (-0.03..0.005f64, [vector(20.0), vector(20.0)], [vector(5.0), vector(5.0)], 0.0..0.01f64),
    )
        .prop_map(|(mesh, material, data)| Model {
            cells: mesh.0,
            shake: mesh.1,
            seed: mesh.2,
            young: material.0,
            poisson: material.1,
            plane_strain: material.2,
            top: data.0,
            traction: data.1.map(Vector::from),
            body_force: data.2.map(Vector::from),
            gap: data.3,
        })
}

/// A change of a whole problem: motion, units and numbering.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// Mirrored at the y-axis first.
    pub(crate) mirror: bool,
    /// Then turned, radians.
    pub(crate) angle: f64,
    /// Then shifted.
    pub(crate) shift: Vector,
    /// Lengths, Young's moduli and strains are multiplied by these.
    pub(crate) length: f64,
    pub(crate) stiffness: f64,
    pub(crate) strain: f64,
    /// Nodes and cells get other numbers, by this seed.
    pub(crate) renumber: Option<u64>,
}

impl Motion {
    /// Nothing is done.
    pub(crate) const NONE: Self = Self {
        mirror: false,
        angle: 0.0,
        shift: Vector::new(0.0, 0.0),
        length: 1.0,
        stiffness: 1.0,
        strain: 1.0,
        renumber: None,
    };

    fn direction(&self, v: Vector) -> Vector {
        turn(self.angle, if self.mirror { Vector::new(-v[0], v[1]) } else { v })
    }

    fn mesh(&self, mesh: &TriMesh) -> TriMesh {
        let place = |x: &Vector| self.length * self.direction(*x) + self.shift;
        let points: Vec<Vector> = mesh.points().iter().map(place).collect();
        let mut random = Random::new(self.renumber.unwrap_or(0));
        // A permutation of the nodes, then of the cells; without `renumber` the identity.
        let mut order = |n: usize| {
            let mut order: Vec<usize> = (0..n).collect();
            for k in (1..n).rev().filter(|_| self.renumber.is_some()) {
                order.swap(k, (random.unit() * (k + 1) as f64) as usize);
            }
            order
        };
        let (nodes, cells) = (order(points.len()), order(mesh.cells().len()));
        let mut placed = vec![Vector::zeros(); points.len()];
        for (old, &new) in nodes.iter().enumerate() {
            placed[new] = points[old];
        }
        let number = |n: NodeId| NodeId::new(nodes[n]);
        let triangle = |&t: &usize| {
            let [a, b, c] = mesh.cells()[t].map(number);
            // A mirrored triangle runs the other way round.
            let mut corners = if self.mirror { [a, c, b] } else { [a, b, c] };
            corners.rotate_left(if self.renumber.is_some() { t % 3 } else { 0 });
            corners
        };
        let edges = mesh.topology().facets();
        let group = |(name, group): (&String, &Vec<FacetId>)| {
            (name.clone(), group.iter().map(|&e| edges[e].map(number)).collect())
        };
        let groups = mesh.groups().iter().map(group).collect();
        TriMesh::new(placed, cells.iter().map(triangle).collect(), groups).unwrap()
    }
}

impl Model {
    /// Moves the nodes of a block: along the interface alike in both bodies, inside at random, elsewhere along the sides.
    fn shaken(&self, mesh: &TriMesh, body: usize) -> TriMesh {
        let width = 2.0 / self.cells[0] as f64;
        let along = |x: f64| {
            let column = (x / width).round();
            let inside = column > 0.5 && column < self.cells[0] as f64 - 0.5;
            let step = Random::new(self.seed ^ column as u64).signed();
            x + if inside { self.shake * width * step } else { 0.0 }
        };
        let height = 1.0 / self.cells[1 + body] as f64;
        moved(mesh, |x| {
            let row = (x[1] / height).round() as i64;
            let edge = [0.0, 1.0, -1.0].iter().any(|y| (x[1] - y).abs() < 1e-9);
            let mut random = Random::new(self.seed ^ ((row as u64) << 32) ^ (x[0] / width).round() as u64);
            let up = if edge { 0.0 } else { self.shake * height * random.signed() };
            Vector::new(along(x[0]), x[1] + up)
        })
        .unwrap()
    }

    /// Makes the problem after a motion.
    pub(crate) fn problem(&self, motion: &Motion) -> ContactProblem {
        let [columns, upper, lower] = self.cells;
        let hypothesis = if self.plane_strain { Hypothesis::PlaneStrain } else { Hypothesis::PlaneStress };
        let meshes = [
            block([0.0, 0.0], [2.0, 1.0], [columns, upper]).unwrap(),
            block([0.0, -1.0], [2.0, 1.0], [columns, lower]).unwrap(),
        ];
        let stress = motion.stiffness * motion.strain;
        let displacement = motion.strain * motion.length;
        let body = |b: usize| {
            let traction: [f64; 2] = motion.direction(stress * self.traction[b]).into();
            let force = motion.direction(stress / motion.length * self.body_force[b]);
            let conditions =
                BoundaryConditions::new().traction("right", traction.map(Into::into)).body_force(force);
            let conditions = if b == 0 {
                conditions.roller("left", 0.0).roller("top", displacement * self.top)
            } else {
                conditions.fix("bottom")
            };
            let young = motion.stiffness * self.young[b];
            let material = LinearElastic::isotropic(young, self.poisson[b], hypothesis).unwrap();
            Body::new(motion.mesh(&self.shaken(&meshes[b], b)), material, &conditions).unwrap()
        };
        let bodies = [body(0), body(1)];
        let gap = Gap::Given((displacement * self.gap).into());
        let interface = contact_geometry::pair(&bodies[0], &bodies[1], ["bottom", "top"], &gap).unwrap();
        ContactProblem::between(bodies, interface)
    }
}

/// The results that must not depend on how a problem is written down.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answer {
    /// `a(u, u)` of each body.
    pub(crate) energy: [f64; 2],
    pub(crate) contact_force: f64,
    /// The bound without allowance for round-off, and its two parts.
    pub(crate) e_cre: f64,
    pub(crate) eta_dis: f64,
}

/// Solves a problem by the interface Newton method, exactly, and certifies it.
pub(crate) fn answer(problem: &ContactProblem) -> (Answer, Iterate) {
    let prepared = prepare(problem);
    let iterate = newton(&prepared).unwrap();
    // Edge tractions alone: relaxation goes from star to star, in the order of the nodes.
    let e = certify(&prepared, &iterate).unwrap();
    assert!(e.admissibility.is_valid(), "{:?}", e.admissibility);
    let answer = Answer {
        energy: [0, 1].map(|b| e.energy_norm_squared[b]),
        contact_force: iterate.contact_force(),
        e_cre: e.cre.e_cre(),
        eta_dis: e.unchecked().eta_dis,
    };
    (answer, iterate)
}
