//! Random problems made to break the bound: extreme materials, shapes, meshes, units and places.
//!
//! ```text
//!      supports or loads              Everything random: shape, cells, materials, supports, loads, gap. Data are
//!   ┌─────────┐                       linear on the edges, so that the bound is strict.
//!   │   Ω₁    │→                      Then the whole is turned, shifted and written in other units.
//!   ├── Γ_C ──┤ gap
//!   │   Ω₂    │→
//!   └─────────┘ held
//! ```
//! There are no reference values: an admissible field of a finer mesh ([`crate::witness`]) is what bounds are compared with.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, Gap, Hypothesis, LinearElastic, Made, ScalarData, TriMesh,
    Vector, pair, ring,
};
use crate::random::Random;
use crate::rings::{A, B, C};
use crate::run::paired_in_common;
use crate::shapes::{moved, turn, unstructured};
use fem_core::interface::ContactNormal;
use fem_core::material::{Materials, Orthotropic};

/// What is extreme about a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Moduli up to 1e13 apart, between the bodies and within them.
    Contrast,
    /// Poisson's ratios to 0.49999.
    Incompressible,
    /// Moduli along and across fibres up to 3000 apart.
    Orthotropic,
    /// Lengths and stresses in units of 1e-12 to 1e12.
    Units,
    /// Up to 1e8 body lengths from the origin.
    Far,
    /// Bodies up to 100 times as long as high, or as high as long.
    Thin,
    /// Surfaces whose nodes do not match.
    NonMatching,
    /// Cells up to 10,000 times as long as high.
    Slivers,
    /// Contact on an arc.
    Bent,
    /// Contact on a whole circle.
    Closed,
    /// Rollers oblique to the axes and to the contact line.
    Oblique,
    /// The last mesh of an adaptive run.
    Adaptive,
}

impl Family {
    /// All families.
    pub const ALL: [Self; 12] = [
        Self::Contrast,
        Self::Incompressible,
        Self::Orthotropic,
        Self::Units,
        Self::Far,
        Self::Thin,
        Self::NonMatching,
        Self::Slivers,
        Self::Bent,
        Self::Closed,
        Self::Oblique,
        Self::Adaptive,
    ];

    /// Names the family.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contrast => "stiffness contrast to 1e13",
            Self::Incompressible => "Poisson's ratio to 0.49999",
            Self::Orthotropic => "orthotropic to 3000:1",
            Self::Units => "units of 1e-12 to 1e12",
            Self::Far => "to 1e8 lengths from the origin",
            Self::Thin => "thin to 100:1",
            Self::NonMatching => "meshes that do not match",
            Self::Slivers => "slivers to 1:10,000",
            Self::Bent => "bent lines",
            Self::Closed => "closed lines",
            Self::Oblique => "oblique supports",
            Self::Adaptive => "adaptive",
        }
    }

    /// Makes the member of the family with a number.
    ///
    /// # Errors
    /// A problem that makes no sense, which the program refuses as well.
    pub fn problem(self, number: u64) -> Made<ContactProblem> {
        let mut random = Random::new(self as u64 * 1_000_003 + number * 7919);
        match self {
            Self::Bent => rings(&mut random, false),
            Self::Closed => rings(&mut random, true),
            _ => Blocks::new(self, &mut random).problem(&mut random),
        }
    }
}

/// A random number between two, all factors alike.
fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.unit())
}

/// What is done to the whole problem.
#[derive(Clone, Copy, Debug)]
struct Frame {
    angle: f64,
    shift: Vector,
    length: f64,
    stress: f64,
}

impl Frame {
    fn place(&self, x: Vector) -> Vector {
        self.length * turn(self.angle, x) + self.shift
    }

    fn mesh(&self, mesh: &TriMesh) -> Made<TriMesh> {
        Ok(moved(mesh, |x| self.place(x))?)
    }

    /// A linear displacement `a + b x`, x along the contact line.
    fn linear(&self, a: [f64; 2], b: [f64; 2]) -> [ScalarData; 2] {
        let frame = *self;
        [0, 1].map(|c| {
            ScalarData::function(move |x: Vector| {
                let own = turn(-frame.angle, x - frame.shift);
                turn(frame.angle, [0, 1].map(|k| frame.length * a[k] + b[k] * own[0]))[c]
            })
        })
    }
}

/// Two blocks of width 2.
struct Blocks {
    family: Family,
    frame: Frame,
    cells: [[usize; 2]; 2],
    size: [[f64; 2]; 2],
    materials: [Vec<LinearElastic>; 2],
    strain: f64,
}

impl Blocks {
    fn new(family: Family, random: &mut Random) -> Self {
        let columns = random.integer(3, 9);
        let matching = family != Family::NonMatching;
        let mut cells = [0, 1].map(|_| [columns, random.integer(2, 6)]);
        if !matching {
            cells[1][0] = random.integer(3, 12);
        }
        let mut size = [0, 1].map(|_| [2.0, between(random, 0.5, 2.0)]);
        if family == Family::Thin {
            let b = random.integer(0, 1);
            let ratio = between(random, 10.0, 100.0);
            if random.unit() < 0.5 {
                size[b][1] = 2.0 / ratio;
            } else {
                size[b][1] = 2.0 * ratio;
                cells[b] = [columns.min(3), random.integer(8, 40)];
                cells[1 - b][0] = cells[b][0];
            }
        }
        let mut frame = Frame { angle: 0.0, shift: Vector::zeros(), length: 1.0, stress: 1.0 };
        match family {
            Family::Units => {
                frame.length = between(random, 1e-12, 1e12);
                frame.stress = between(random, 1e-12, 1e12);
            }
            Family::Far => {
                let distance = between(random, 1.0, 1e8);
                frame.shift = [0, 1].map(|_| distance * random.signed()).into();
            }
            Family::Oblique => frame.angle = 3.2 * random.signed(),
            _ => {}
        }
        let materials = [0, 1].map(|_| materials(family, frame.stress, random));
        let strain = between(random, 1e-5, 1e-2);
        Self { family, frame, cells, size, materials, strain }
    }

    fn mesh(&self, b: usize, random: &mut Random) -> Made<TriMesh> {
        let [width, height] = self.size[b];
        let low = if b == 0 { 0.0 } else { -height };
        let mesh = unstructured([0.0, low], [width, height], self.cells[b], 0.14, random)?;
        if self.family != Family::Slivers {
            return Ok(mesh);
        }
        // Rows drawn together towards a height, by up to the ratio that is left of a row.
        let at = height * random.unit();
        let power = (1.0 + 9.0 * random.unit()).min(4.0 / (self.cells[b][1] as f64).log10());
        Ok(moved(&mesh, |x| {
            let d = (x[1] - low - at) / height;
            let reach = if d > 0.0 { 1.0 - at / height } else { at / height };
            Vector::new(x[0], low + at + height * d.signum() * reach * (d.abs() / reach).powf(power))
        })?)
    }

    fn body(&self, b: usize, random: &mut Random) -> Made<Body> {
        let mesh = self.mesh(b, random)?;
        let materials = &self.materials[b];
        let of_triangle =
            mesh.triangles().iter().map(|_| (random.unit() * materials.len() as f64) as u32).collect();
        let frame = self.frame;
        let [_, height] = self.size[b];
        let softest = materials.iter().map(|m| m.stiffness()[(2, 2)]).fold(f64::INFINITY, f64::min);
        let load = softest * self.strain;
        let mut vector = |size: f64| turn(frame.angle, [0, 1].map(|_| size * random.signed()));
        let [right, weight] = [vector(load), vector(load / (frame.length * (1.0 + height)))];
        let far = if b == 0 { "top" } else { "bottom" };
        let towards = if b == 0 { -1.0 } else { 0.3 } * self.strain * height;
        let mut conditions = BoundaryConditions::new();
        if random.unit() < 0.5 {
            let tilt = 0.4 * self.strain * random.signed();
            let [x, y] = frame.linear([0.3 * towards * random.signed(), towards], [0.0, tilt]);
            conditions = conditions.displace(far, Some(x), Some(y));
        } else {
            // Out of the body, which is away from the contact line.
            conditions = conditions.roller(far, -towards.abs() * frame.length).roller("left", 0.0);
        }
        if random.unit() < 0.6 {
            conditions = conditions.traction("right", <[f64; 2]>::from(right).map(Into::into));
        }
        if random.unit() < 0.5 {
            conditions = conditions.body_force(weight);
        }
        let materials = Materials::by_triangle(materials.clone(), of_triangle);
        Ok(Body::new(frame.mesh(&mesh)?, materials, &conditions)?)
    }

    fn problem(&self, random: &mut Random) -> Made<ContactProblem> {
        let bodies = [self.body(0, random)?, self.body(1, random)?];
        let open = self.strain * self.frame.length * random.unit();
        let gap = match random.integer(0, 2) {
            0 => 0.0.into(),
            1 => open.into(),
            _ => {
                let frame = self.frame;
                ScalarData::function(move |x: Vector| {
                    let own = turn(-frame.angle, x - frame.shift);
                    open * (0.5 * own[0] / frame.length).clamp(0.0, 1.0)
                })
            }
        };
        let (gap, surfaces) = (Gap::Given(gap), ["bottom", "top"]);
        if self.family == Family::NonMatching {
            return Ok(paired_in_common(bodies, surfaces, &gap, ContactNormal::Averaged)?.0);
        }
        pair(bodies, surfaces, &gap)
    }
}

/// The materials of a body.
fn materials(family: Family, stress: f64, random: &mut Random) -> Vec<LinearElastic> {
    let hypothesis = if random.unit() < 0.8 { Hypothesis::PlaneStrain } else { Hypothesis::PlaneStress };
    let one = |random: &mut Random| {
        let spread = if family == Family::Contrast { 1e13 } else { 10.0 };
        let young = stress * between(random, 1.0, spread);
        let poisson = match family {
            Family::Incompressible => 0.5 - between(random, 1e-5, 0.1),
            _ => 0.45 * random.unit(),
        };
        if family == Family::Orthotropic {
            let young = [young * between(random, 1.0, 3000.0), young];
            let shear = young[1] * between(random, 0.1, 1.0);
            let constants = Orthotropic::in_plane(young, 0.3, shear, 3.2 * random.signed());
            return LinearElastic::orthotropic(&constants, hypothesis);
        }
        LinearElastic::isotropic(young, poisson, hypothesis)
    };
    let count = if random.unit() < 0.5 { 1 } else { 2 };
    (0..count).filter_map(|_| one(random).ok()).collect()
}

/// Rings or sectors of rings, the outer one pushed.
fn rings(random: &mut Random, closed: bool) -> Made<ContactProblem> {
    let angles = if closed {
        [0.0, 360.0]
    } else {
        let middle = 90.0 + 30.0 * random.signed();
        let half = 15.0 + 50.0 * random.unit();
        [middle - half, middle + half]
    };
    let around = if closed { random.integer(12, 24) } else { random.integer(4, 12) };
    let family = if random.unit() < 0.3 { Family::Incompressible } else { Family::Bent };
    let strain = between(random, 1e-4, 1e-2);
    let [a, b, e, f] = [0; 4].map(|_| strain * random.signed());
    let push = if closed { strain } else { strain * (0.5 + random.unit()) };
    let mut body = |radii: [f64; 2], outer: bool| -> Made<Body> {
        let mesh = ring([0.0, 0.0], radii, angles, [around, random.integer(2, 4)])?;
        let conditions = if outer {
            // Drawn together if closed, else moved towards the other one; and sideways.
            let inwards = move |x: Vector, c: usize| match (closed, c) {
                (true, _) => -push * x[c],
                (false, 0) => 0.0,
                (false, _) => -push,
            };
            let u = ScalarData::function(move |x: Vector| inwards(x, 0) + 0.3 * a + 0.2 * e * x[1]);
            let v = ScalarData::function(move |x: Vector| inwards(x, 1) + 0.3 * b + 0.2 * f * x[0]);
            BoundaryConditions::new().displace("outer", Some(u), Some(v))
        } else {
            BoundaryConditions::new().fix("inner")
        };
        let materials = materials(family, 1.0, random);
        let of_triangle =
            mesh.triangles().iter().map(|_| (random.unit() * materials.len() as f64) as u32).collect();
        Ok(Body::new(mesh, Materials::by_triangle(materials, of_triangle), &conditions)?)
    };
    let bodies = [body([A, B], false)?, body([B, C], true)?];
    let surfaces = ["outer", "inner"];
    pair(bodies, surfaces, &Gap::Given(0.0.into()))
}
