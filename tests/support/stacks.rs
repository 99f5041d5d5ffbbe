//! Stacks of layers pressed together, and slender ones: linear triangles hold the solution, so that nothing but round-off
//! and the iteration is left of the error, and double-double arithmetic measures it.
//!
//! ```text
//!    u = (0, −d)
//!   ┌─────────┐
//!   ├─────────┤ layers of the first body, each with its own modulus, up to 1e13 apart
//!   ├─────────┤
//!   ├── Γ_C ──┤
//!   ├─────────┤ layers of the second body
//!   └─────────┘ clamped            free sides with ν = 0, or ν ≠ 0 between rollers
//! ```
//! Exact: the pressure is `p = d / Σ h/M` with the confined modulus `M`, the displacement linear in each layer. Heights come
//! from the nodes, `M` from the entry of the material's stiffness: both as the program sees them.

use crate::model::{
    Body, BoundaryConditions, ContactProblem, Gap, LinearElastic, Made, ScalarData, TriMesh, Vector, block,
    isotropic, pair,
};
use crate::precise::{Precise, energy, minus, precise, rounded};
use crate::random::Random;
use crate::shapes::moved;
use certified_contact::{Imposed, Settings, Silent, solve};
use cre_estimator::Relaxation;
use fem_core::material::Materials;
use nndd::NewtonSettings;
use qd::Quad;

/// A layer of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Young's modulus.
    pub young: f64,
    /// Height.
    pub height: f64,
    /// Rows of cells.
    pub rows: usize,
}

/// Two stacks of layers.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    /// Layers of each body from the contact line outwards.
    pub layers: [Vec<Layer>; 2],
    /// Width.
    pub width: f64,
    /// Cells along the width.
    pub columns: usize,
    /// Poisson's ratio of all layers; the sides are free if it is zero, on rollers if not.
    pub poisson: f64,
    /// Displacement of the far side of the first body towards the other one.
    pub push: f64,
    /// True if the stack lies on its side.
    pub lying: bool,
    /// By how much of a cell inner nodes are moved, and how.
    pub shake: (f64, u64),
}

impl Stack {
    /// A random stack of layers whose moduli differ by up to a factor.
    pub fn layered(contrast: f64, random: &mut Random) -> Self {
        let unit = 10f64.powf(6.0 * random.signed());
        let length = 10f64.powf(3.0 * random.signed());
        let mut layers = [3, 2].map(|count: usize| -> Vec<Layer> {
            let layer = |_| Layer {
                young: unit * contrast.powf(random.unit()),
                height: length * (0.5 + random.unit()),
                rows: 1 + (random.unit() * 16.0) as usize,
            };
            (0..count).map(layer).collect()
        });
        // The softest and the stiffest are there, anywhere.
        let soft = (random.unit() * 5.0) as usize;
        let stiff = (soft + 1 + (random.unit() * 4.0) as usize) % 5;
        for (place, young) in [(soft, unit), (stiff, unit * contrast)] {
            layers[place / 3][place % 3].young = young;
        }
        Self {
            layers,
            width: length * (1.0 + 2.0 * random.unit()),
            columns: 2 + (random.unit() * 24.0) as usize,
            poisson: if random.unit() < 0.5 { 0.0 } else { 0.45 * random.unit() },
            push: length * 10f64.powf(-4.0 + 3.0 * random.unit()),
            lying: random.unit() < 0.5,
            shake: (if random.unit() < 0.5 { 0.0 } else { 0.15 }, (random.unit() * 1e9) as u64),
        }
    }

    /// A random pair of columns of one material, `ratio` times as long as wide.
    pub fn slender(ratio: f64, random: &mut Random) -> Self {
        let width = 10f64.powf(3.0 * random.signed());
        let young = 10f64.powf(6.0 * random.signed());
        let columns = 1 + (random.unit() * 4.0) as usize;
        let flat = 1.0 + 3.0 * random.unit();
        let mut layer = || {
            let height = ratio * width * (0.5 + 0.5 * random.unit());
            let rows = (height / width * columns as f64 / flat).ceil() as usize;
            vec![Layer { young, height, rows }]
        };
        let layers = [layer(), layer()];
        Self {
            layers,
            width,
            columns,
            poisson: 0.0,
            push: width * ratio * 10f64.powf(-4.0 + 2.0 * random.unit()),
            lying: random.unit() < 0.5,
            shake: (if random.unit() < 0.5 { 0.0 } else { 0.15 }, (random.unit() * 1e9) as u64),
        }
    }

    /// Distances of a body's layer boundaries from the contact line, from 0.
    fn boundaries(&self, b: usize) -> Vec<f64> {
        let mut found = vec![0.0];
        for layer in &self.layers[b] {
            found.push(found[found.len() - 1] + layer.height);
        }
        found
    }

    /// Distance of a row of nodes from the contact line, and whether it is a boundary of layers.
    fn row(&self, b: usize, row: usize) -> (f64, bool) {
        let boundaries = self.boundaries(b);
        let mut first = 0;
        for (k, layer) in self.layers[b].iter().enumerate() {
            if row <= first + layer.rows {
                let part = row - first;
                if part == 0 || part == layer.rows {
                    return (boundaries[k + part / layer.rows], true);
                }
                let step = (boundaries[k + 1] - boundaries[k]) * (part as f64 / layer.rows as f64);
                return (boundaries[k] + step, false);
            }
            first += layer.rows;
        }
        (boundaries[boundaries.len() - 1], true)
    }

    /// Places a point given by its distance from the contact line.
    fn place(&self, b: usize, x: f64, distance: f64) -> Vector {
        let y = if b == 0 { distance } else { -distance };
        if self.lying { Vector::new(-y, x) } else { Vector::new(x, y) }
    }

    /// Distance of a point from the contact line.
    fn distance(&self, x: Vector) -> f64 {
        if self.lying { x[0].abs() } else { x[1].abs() }
    }

    fn mesh(&self, b: usize) -> Made<(TriMesh, Vec<u32>)> {
        let rows: usize = self.layers[b].iter().map(|l| l.rows).sum();
        let (nx, ny) = (self.columns, rows);
        let low = if b == 0 { 0.0 } else { -(ny as f64) };
        let squares = block([0.0, low], [nx as f64, ny as f64], [nx, ny])?;
        let (shake, seed) = self.shake;
        let shift = |x: Vector| {
            let (column, row) = (x[0].round() as usize, x[1].abs().round() as usize);
            let (distance, boundary) = self.row(b, row);
            let mut random = Random::new(seed ^ ((row as u64) << 32) ^ ((b as u64) << 48) ^ column as u64);
            let mut random = || if shake == 0.0 { 0.0 } else { shake * random.signed() };
            let inside = column > 0 && column < nx;
            let across = if inside && row > 0 { random() } else { 0.0 };
            let along = if boundary || !inside {
                0.0
            } else {
                let next = if row < ny { self.row(b, row + 1).0 } else { distance };
                let last = if row > 0 { self.row(b, row - 1).0 } else { distance };
                random() * (next - distance).min(distance - last)
            };
            let x =
                if column == nx { self.width } else { self.width * ((column as f64 + across) / nx as f64) };
            self.place(b, x, distance + along)
        };
        let mesh = moved(&squares, shift)?;
        let mut first = 0;
        let ends: Vec<usize> = (self.layers[b].iter())
            .map(|l| {
                first += l.rows;
                first
            })
            .collect();
        let layer = |t: usize| {
            let c = squares.corners(t);
            let row = (c[0][1] + c[1][1] + c[2][1]).abs() / 3.0;
            ends.iter().filter(|&&end| row > end as f64).count() as u32
        };
        let of_triangle = (0..squares.cells().len()).map(layer).collect();
        Ok((mesh, of_triangle))
    }

    fn material(&self, layer: &Layer) -> Made<LinearElastic> {
        isotropic(layer.young, self.poisson)
    }

    /// Makes the problem.
    ///
    /// # Errors
    /// None, for sensible numbers.
    pub fn problem(&self) -> Made<ContactProblem> {
        let body = |b: usize| -> Made<Body> {
            let (mesh, of_triangle) = self.mesh(b)?;
            let materials: Result<Vec<_>, _> = self.layers[b].iter().map(|l| self.material(l)).collect();
            let far = if b == 0 { "top" } else { "bottom" };
            let push: [ScalarData; 2] = match (b, self.lying) {
                (1, _) => [0.0.into(), 0.0.into()],
                (_, false) => [0.0.into(), (-self.push).into()],
                (_, true) => [self.push.into(), 0.0.into()],
            };
            let [x, y] = push.map(Some);
            let mut conditions = BoundaryConditions::new().displace(far, x, y);
            if self.poisson != 0.0 {
                conditions = conditions.roller("left", 0.0).roller("right", 0.0);
            }
            Ok(Body::new(mesh, Materials::by_cell(materials?, of_triangle), &conditions)?)
        };
        let bodies = [body(0)?, body(1)?];
        let surfaces = ["bottom", "top"];
        pair(bodies, surfaces, &Gap::Given(0.0.into()))
    }

    /// Computes what is exact.
    ///
    /// # Errors
    /// None, for sensible numbers.
    pub fn exact(&self) -> Made<Exact> {
        let mut compliance = Quad::ZERO;
        let mut layers = [vec![], vec![]];
        for b in 0..2 {
            let boundaries = self.boundaries(b);
            for (k, layer) in self.layers[b].iter().enumerate() {
                let modulus = self.material(layer)?.stiffness()[(0, 0)];
                let [low, high] = [k, k + 1].map(|k| Quad::from_f64(boundaries[k]));
                let flexibility = Quad::ONE / Quad::from_f64(modulus);
                compliance += (high - low) * flexibility;
                layers[b].push([low, high, flexibility]);
            }
        }
        let (push, width) = (Quad::from_f64(self.push), Quad::from_f64(self.width));
        let pressure = push / compliance;
        let energy = push * pressure * width;
        Ok(Exact {
            stack: self.clone(),
            layers,
            pressure,
            energy_norm: energy.sqrt(),
            potential_energy: energy * Quad::from_f64(0.5),
            contact_force: pressure * width,
        })
    }
}

/// The exact solution of a stack.
#[derive(Clone, Debug)]
pub struct Exact {
    stack: Stack,
    /// Distances of both boundaries from the contact line and `1/M` of each layer.
    layers: [Vec<[Quad; 3]>; 2],
    pressure: Quad,
    /// `√a(u, u)` of both bodies.
    pub energy_norm: Quad,
    /// `½ a(u, u)`: no loads act.
    pub potential_energy: Quad,
    /// `∫ p ds`.
    pub contact_force: Quad,
}

impl Exact {
    /// Computes the displacement of body `b` at a point.
    pub fn displacement(&self, b: usize, x: Vector) -> Precise {
        let distance = Quad::from_f64(self.stack.distance(x));
        // From the held side: what the layers between it and the point lose in height.
        let mut shortening = Quad::ZERO;
        for [low, high, flexibility] in &self.layers[b] {
            let from = if distance.0 > low.0 { distance } else { *low };
            if from.0 < high.0 {
                shortening += (*high - from) * *flexibility;
            }
        }
        let towards = self.pressure * shortening;
        let along = if b == 0 { towards - Quad::from_f64(self.stack.push) } else { -towards };
        let zero = Quad::ZERO;
        if self.stack.lying { [-along, zero] } else { [zero, along] }
    }

    /// Computes `‖u − v‖²` of body `b`.
    ///
    /// * `v`: one per node.
    pub fn error_squared(&self, b: usize, body: &Body, v: &[Vector]) -> Quad {
        let nodes = body.mesh().points().iter().zip(v);
        let difference: Vec<Precise> =
            nodes.map(|(x, v)| minus(self.displacement(b, *x), precise(*v))).collect();
        energy(body, &difference)
    }
}

/// The values of a stack's certificate, and the true ones.
#[derive(Clone, Debug)]
pub struct Measured {
    /// `‖u − v‖` of the displacements that the program shows.
    pub error: f64,
    /// `√a(u, u)`.
    pub norm: f64,
    /// The bound.
    pub e_cre: f64,
    /// The bound of the iteration's error, here the whole error.
    pub eta_nndd: f64,
    /// The intervals of energy norm, potential energy and contact force, with the exact values.
    pub intervals: [([f64; 2], Quad); 3],
}

impl Measured {
    /// Solves a stack and measures its certificate; `None` without a certificate.
    ///
    /// # Errors
    /// A stack that makes no problem.
    pub fn new(stack: &Stack, settings: &Settings) -> Made<Option<Self>> {
        let exact = stack.exact()?;
        let Ok(found) = solve(stack.problem()?, settings, &mut Silent) else { return Ok(None) };
        let (Some(estimate), Some(bounds), true) = (&found.estimate, found.bounds, found.is_certified())
        else {
            return Ok(None);
        };
        let squared = |b: usize| {
            exact.error_squared(b, &found.problem.bodies[b], &estimate.pair.bodies[b].displacement)
        };
        let force = bounds.contact_force?;
        Ok(Some(Self {
            error: rounded((squared(0) + squared(1)).sqrt()),
            norm: rounded(exact.energy_norm),
            e_cre: estimate.unchecked().e_cre,
            eta_nndd: found.last().eta_nndd,
            intervals: [
                (bounds.energy_norm, exact.energy_norm),
                (bounds.potential_energy, exact.potential_energy),
                (force, exact.contact_force),
            ],
        }))
    }

    /// Tells what is violated: `e_CRE`, `η_NNDD`, the three intervals. NaN counts as a violation.
    pub fn violations(&self) -> [bool; 5] {
        let outside = |([low, high], exact): ([f64; 2], Quad)| {
            !(Quad::from_f64(low) <= exact && exact <= Quad::from_f64(high))
        };
        let [norm, energy, force] = self.intervals.map(outside);
        [!(self.e_cre >= self.error), !(self.eta_nndd >= self.error), norm, energy, force]
    }
}

/// Makes random settings: who carries λ, the method, and how far stresses are relaxed.
pub fn random_settings(random: &mut Random) -> Settings {
    let mut settings = Settings::default();
    settings.imposed = [Imposed::Auto, Imposed::First, Imposed::Second][(random.unit() * 3.0) as usize];
    settings.relaxation =
        [Relaxation::NONE, Relaxation::Steps(2), Relaxation::default()][(random.unit() * 3.0) as usize];
    if random.unit() < 0.25 {
        settings.method = NewtonSettings::default().into();
    }
    settings
}
