//! Random stacks of one to four boxes of tetrahedra in contact: in any direction, floating or held, on planes and under planes and stamps, with
//! materials of very different moduli, nearly incompressible ones, gaps, units, and runs that end early.
//!
//! There are no reference values: the bound is held against the solution on a nested mesh with eight times as many cells.

use crate::random::Random;
use certified_contact::{Bounds, estimate};
use cre_estimator::{Estimate, Relaxation};
use fem_core::body::Body;
use fem_core::boundary::{BoundaryConditions, ScalarData};
use fem_core::interface::{ContactInterface, ContactProblem, Gap, Obstacle, RigidLine};
use fem_core::material::LinearElastic;
use fem_core::mesh::generate::cuboid;
use fem_core::mesh::{Mesh, TetMesh};
use fem_core::norm::energy_distance_squared;
use fem_core::prepared::PreparedProblem;
use fem_core::space::Solid;
use nalgebra::{Rotation3, Vector3};
use nndd::stopping::EtaNndd;
use nndd::{Iterate, Method, NewtonSettings, NnddSettings, solve};
use std::error::Error;
use std::sync::Arc;

/// What is below the lowest box.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Base {
    Fixed,
    Rollers,
    Plane,
}

/// What presses on the highest box.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Top {
    /// A linear pressure, and its slopes along the sides.
    Pressure([f64; 2]),
    /// An imposed displacement along the normal, linear.
    Pushed([f64; 2]),
    /// A plane that moves down.
    Plane,
    /// A plane that moves and tilts under a force beside the middle.
    Stamp([f64; 2]),
}

/// A box of the stack.
#[derive(Clone, Copy, Debug)]
struct Part {
    height: f64,
    cells: usize,
    young: f64,
    poisson: f64,
    /// Of its weight, over the pressure of the load and the height.
    weight: f64,
    /// Rollers on the left and the front side.
    guided: [bool; 2],
    /// The gap below it, and its slopes: linear, so that finer meshes have the same.
    gap: [f64; 3],
}

/// A random stack.
#[derive(Clone, Debug)]
pub struct Stack {
    parts: Vec<Part>,
    /// Width and depth, m, and the cells along them.
    sides: [f64; 2],
    cells: [usize; 2],
    base: Base,
    top: Top,
    /// Pressure of the load, Pa, and the displacement that takes its place, m.
    load: f64,
    push: f64,
    turn: Rotation3<f64>,
    method: Method,
}

impl Stack {
    /// Draws a stack.
    pub fn new(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let r = &mut random;
        let count = r.integer(1, 4);
        let contrast = [0.5, 3.0, 6.0][r.integer(0, 2)];
        let unit = [1e-3, 1.0, 1.0, 1e3][r.integer(0, 3)];
        let part = |r: &mut Random| Part {
            height: unit * (0.3 + r.unit()),
            cells: r.integer(1, 2),
            young: 1e3 * 10f64.powf(contrast * r.unit()),
            poisson: if r.unit() < 0.2 { 0.499 } else { 0.45 * r.unit() },
            weight: if r.unit() < 0.3 { r.unit() } else { 0.0 },
            guided: [r.unit() < 0.3, r.unit() < 0.3],
            gap: match r.integer(0, 2) {
                0 => [unit * 1e-3 * (1.0 + r.unit()), 1e-3 * r.signed(), 1e-3 * r.signed()],
                _ => [0.0; 3],
            },
        };
        let parts = (0..count).map(|_| part(r)).collect();
        let base = [Base::Fixed, Base::Rollers, Base::Plane][r.integer(0, 2)];
        let slopes = [0.7 * r.signed(), 0.7 * r.signed()];
        let top = match r.integer(0, 3) {
            0 => Top::Pressure(slopes),
            1 => Top::Pushed(slopes),
            2 => Top::Plane,
            _ => Top::Stamp(slopes),
        };
        let method = match r.integer(0, 3) {
            0 => Method::default(),
            1 => NewtonSettings::default().into(),
            _ => {
                let mut settings = NnddSettings::default();
                settings.max_iterations = r.integer(1, 12);
                settings.into()
            }
        };
        let sides = [unit * (0.5 + r.unit()), unit * (0.5 + r.unit())];
        let turn = match r.integer(0, 1) {
            0 => Rotation3::identity(),
            _ => Rotation3::from_euler_angles(3.0 * r.signed(), 3.0 * r.signed(), 3.0 * r.signed()),
        };
        let cells = [r.integer(1, 3), r.integer(1, 3)];
        let load = 10f64.powf(r.signed());
        Self { parts, sides, cells, base, top, load, push: unit * 3e-3, turn, method }
    }

    /// A linear function over the width and the depth of the stack, with the mean `mean`.
    fn linear(&self, mean: f64, [a, b]: [f64; 2]) -> ScalarData<Solid> {
        let ([width, depth], back) = (self.sides, self.turn.inverse());
        ScalarData::Function(Arc::new(move |x: Vector3<f64>| {
            let x = back * x;
            mean * (1.0 + a * (x[0] / width - 0.5) + b * (x[1] / depth - 0.5))
        }))
    }

    /// The gap below a box, from its value in the middle and its slopes.
    fn gap(&self, [middle, a, b]: [f64; 3]) -> Gap<Solid> {
        if middle == 0.0 {
            return Gap::Given(0.0.into());
        }
        let slope = |slope: f64, side: f64| slope * side / middle;
        Gap::Given(self.linear(middle, [slope(a, self.sides[0]), slope(b, self.sides[1])]))
    }

    /// Turns a mesh.
    fn turned(&self, mesh: &TetMesh) -> Result<TetMesh, Box<dyn Error>> {
        let facets = |ids: &[_]| ids.iter().map(|f| mesh.topology().facets()[*f]).collect();
        let groups = mesh.groups().iter().map(|(name, ids)| (name.clone(), facets(ids))).collect();
        let points = mesh.points().iter().map(|x| self.turn * x).collect();
        Ok(Mesh::new(points, mesh.cells().to_vec(), groups)?)
    }

    fn body(&self, k: usize, finer: usize) -> Result<Body<Solid>, Box<dyn Error>> {
        let part = &self.parts[k];
        let below: f64 = self.parts[..k].iter().map(|part| part.height).sum();
        let size = [self.sides[0], self.sides[1], part.height];
        let cells = [self.cells[0], self.cells[1], part.cells].map(|cells| finer * cells);
        let mut conditions = BoundaryConditions::<Solid>::default();
        let mut guided = part.guided;
        if k == 0 {
            match self.base {
                Base::Fixed => conditions = conditions.fix("bottom"),
                Base::Rollers => {
                    conditions = conditions.roller("bottom", 0.0);
                    guided = [true; 2];
                }
                Base::Plane => {}
            }
        }
        for (side, _) in ["left", "front"].into_iter().zip(guided).filter(|(_, guided)| *guided) {
            conditions = conditions.roller(side, 0.0);
        }
        if k + 1 == self.parts.len() {
            match self.top {
                Top::Pressure(slopes) => {
                    conditions = conditions.pressure("top", self.linear(self.load, slopes));
                }
                Top::Pushed(slopes) => {
                    conditions = conditions.roller("top", self.linear(-self.push, slopes));
                }
                Top::Plane | Top::Stamp(_) => {}
            }
        }
        let down = self.turn * Vector3::new(0.0, 0.0, -part.weight * self.load / part.height);
        let mesh = self.turned(&cuboid([0.0, 0.0, below], size, cells)?)?;
        let material = LinearElastic::isotropic_solid(part.young, part.poisson)?;
        Ok(Body::new(mesh, material, &conditions.body_force(down))?)
    }

    /// A plane at a height, whose normal is up or down.
    fn plane(&self, height: f64, up: f64) -> Obstacle<Solid> {
        let at = Vector3::new(0.3 * self.sides[0], -self.sides[1], height);
        let normal = self.turn * Vector3::new(0.0, 0.0, up);
        Obstacle::fixed(RigidLine::Plane { point: self.turn * at, normal })
    }

    /// Makes the problem.
    ///
    /// * `finer`: by how much finer the mesh is along each axis.
    pub fn problem(&self, finer: usize) -> Result<ContactProblem<Solid>, Box<dyn Error>> {
        let bodies = (0..self.parts.len()).map(|k| self.body(k, finer)).collect::<Result<Vec<_>, _>>()?;
        let last = bodies.len() - 1;
        let mut problem = ContactProblem::new(bodies.clone());
        for k in 1..bodies.len() {
            let gap = self.gap(self.parts[k].gap);
            let interface = ContactInterface::pair_flat(&bodies[k], &bodies[k - 1], ["bottom", "top"], &gap)?;
            problem = problem.contact([k, k - 1], interface);
        }
        if self.base == Base::Plane {
            let plane = self.plane(0.0, 1.0);
            let gap = self.gap(self.parts[0].gap);
            let interface = ContactInterface::against_plane(&bodies[0], "bottom", &plane, Some(&gap))?;
            problem = problem.obstacle(0, interface, plane);
        }
        let height: f64 = self.parts.iter().map(|part| part.height).sum();
        let above = match self.top {
            Top::Plane => self.plane(height, -1.0).moved(self.turn * Vector3::new(0.0, 0.0, -self.push)),
            // Its motion is given along the axes of the space.
            Top::Stamp([a, b]) if self.turn == Rotation3::identity() => {
                let force = Vector3::new(0.0, 0.0, -self.load * self.sides[0] * self.sides[1]);
                let at = [self.sides[0] * (0.5 + 0.3 * a), self.sides[1] * (0.5 + 0.3 * b), height];
                let motion = [Some(0.0), Some(0.0), None, None, None, Some(0.0)];
                self.plane(height, -1.0).stamp(motion, (force, Vector3::zeros()), at)
            }
            Top::Stamp(_) => self.plane(height, -1.0).moved(self.turn * Vector3::new(0.0, 0.0, -self.push)),
            Top::Pressure(_) | Top::Pushed(_) => return Ok(problem),
        };
        let interface = ContactInterface::against_plane(&bodies[last], "top", &above, None)?;
        Ok(problem.obstacle(last, interface, above))
    }

    /// Interpolates a displacement of a box on a mesh with twice as many cells along each axis.
    fn prolonged(&self, k: usize, coarse: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let [nx, ny, nz] = [self.cells[0], self.cells[1], self.parts[k].cells];
        let at = |[i, j, k]: [usize; 3]| coarse[i + (nx + 1) * (j + (ny + 1) * k)];
        let mut fine = Vec::new();
        for (k, j) in (0..=2 * nz).flat_map(|k| (0..=2 * ny).map(move |j| (k, j))) {
            for i in 0..=2 * nx {
                // Half way along an edge of the coarse mesh, or of its diagonals.
                fine.push((at([i / 2, j / 2, k / 2]) + at([i, j, k].map(|c| c.div_ceil(2)))) / 2.0);
            }
        }
        fine
    }
}

/// How a stack was judged.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// It is not held, or the iteration has no solution.
    Refused(String),
    /// A check of one of the two estimates fails.
    Without(&'static str),
    /// The bound over the distance to the finer solution, and what is not true.
    Judged {
        /// `e_CRE` over the distance, if that is more than rounding.
        effectivity: Option<f64>,
        /// Promises that do not hold, in words.
        violations: Vec<String>,
    },
}

/// An iterate with its estimate and bounds.
struct Found {
    estimate: Estimate<Solid>,
    bounds: Bounds,
}

fn found(
    problem: &PreparedProblem<Solid>,
    iterate: &Iterate,
    relaxation: Relaxation,
) -> Result<Found, String> {
    let estimate = estimate(problem, iterate, relaxation).map_err(|e| e.to_string())?;
    let bounds = Bounds::new(problem, iterate, &estimate);
    Ok(Found { estimate, bounds })
}

fn meet(a: [f64; 2], b: [f64; 2]) -> bool {
    a[0] <= b[1] && b[0] <= a[1]
}

/// Solves a stack on two nested meshes, the coarse one with its own method, and holds the promises of the coarse one against the fine solution.
///
/// # Errors
/// A problem that cannot be made: a fault of the generator.
pub fn judge(stack: &Stack) -> Result<Verdict, Box<dyn Error>> {
    let solved = |finer: usize, method: Method, relaxation| -> Result<Result<_, String>, Box<dyn Error>> {
        let problem = PreparedProblem::new(stack.problem(finer)?)?;
        let start = vec![0.0; problem.rows()];
        let solution = match solve(&problem.system(), start, method, &mut EtaNndd::new(1e-12)) {
            Ok(solution) => solution,
            Err(error) => return Ok(Err(error.to_string())),
        };
        Ok(found(&problem, &solution.last, relaxation).map(|found| (problem, found)))
    };
    let coarse = match solved(1, stack.method.clone(), Relaxation::default())? {
        Ok((_, found)) => found,
        Err(reason) => return Ok(Verdict::Refused(reason)),
    };
    let (problem, fine) = match solved(2, NewtonSettings::default().into(), Relaxation::Steps(2))? {
        Ok(found) => found,
        Err(reason) => return Ok(Verdict::Refused(reason)),
    };
    if let Some(reason) = coarse.estimate.reason().or(fine.estimate.reason()) {
        return Ok(Verdict::Without(reason));
    }
    let squared = |k: usize| {
        let field = stack.prolonged(k, &coarse.estimate.pair.bodies[k].displacement);
        let finer = &fine.estimate.pair.bodies[k].displacement;
        energy_distance_squared(&problem.problem().bodies[k], &field, finer)
    };
    let distance = (0..stack.parts.len()).map(squared).sum::<f64>().max(0.0).sqrt();
    let (bound, rounding) = (coarse.estimate.unchecked().e_cre, fine.estimate.round_off);
    // The fine solution has an iteration error as well.
    let inexact = fine.estimate.unchecked().eta_nndd;
    let mut violations = Vec::new();
    if !(distance <= bound + rounding + inexact) {
        violations.push(format!("the distance {distance:e} is above e_CRE = {bound:e}"));
    }
    // Of squares that are not rounding themselves.
    let exact = bound > 10.0 * coarse.estimate.round_off;
    if exact && coarse.estimate.cre.split_defect() > 1e-10 {
        violations.push(format!(
            "the split is off by {:e}, e_CRE = {bound:e}, round-off {:e}, norm {:e}",
            coarse.estimate.cre.split_defect(),
            coarse.estimate.round_off,
            coarse.estimate.energy_norm()
        ));
    }
    let [a, b] = [&coarse.bounds, &fine.bounds];
    let mut intervals =
        vec![("energy norm", a.energy_norm, b.energy_norm), ("J", a.potential_energy, b.potential_energy)];
    if let (Ok(a), Ok(b)) = (a.contact_force, b.contact_force) {
        intervals.push(("contact force", a, b));
    }
    for (of, a, b) in intervals.into_iter().filter(|(_, a, b)| !meet(*a, *b)) {
        violations.push(format!("the intervals {a:?} and {b:?} of {of} do not meet"));
    }
    let above = distance > 10.0 * (coarse.estimate.round_off + rounding + inexact);
    Ok(Verdict::Judged { effectivity: above.then(|| bound / distance), violations })
}
