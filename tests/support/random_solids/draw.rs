//! Random assemblies of boxes: layouts, supports, loads, materials, cells.

use super::build::{Assembly, Condition, Drive, Linear, Part, Round, Touch};
use super::grid::{Cells, Grid};
use crate::model::Made;
use crate::random::Random;
use fem_core::body::SurfaceKind;
use fem_core::boundary::{CutLoad, SpringDirection};
use fem_core::material::{LinearElastic, Orthotropic};
use fem_core::space::Solid;
use nalgebra::{Matrix6, Rotation3, Vector3};

/// Nodes of the coarse meshes, at most.
const NODES: usize = 150;

/// The family of contact sides that supports hold along themselves.
pub(super) const HELD: &str = "contact side held along itself";

/// The family of bonded bodies.
pub(super) const BONDED: &str = "bonded pair";

/// The source of all choices, and the family that forces some of them.
pub(super) struct Draw {
    pub(super) random: Random,
    /// The source of bent sides: problems without them are drawn as before there were any.
    bends: Random,
    /// The source of supports that hold both bodies of bent sides.
    holds: Random,
    /// The source of friction.
    rubs: Random,
    /// The source of springs, and of heat and forces.
    springs: Random,
    family: &'static str,
    /// Unit of length, m, of stress, Pa, and a typical strain.
    length: f64,
    stress: f64,
    strain: f64,
    /// Decades between the softest and the stiffest body.
    contrast: f64,
    turn: Rotation3<f64>,
    /// Tells if no support holds a body.
    floating: bool,
}

/// Boxes in blocks of a grid, and the size of the blocks.
struct Layout {
    sizes: [Vec<f64>; 3],
    boxes: Vec<Cells>,
}

fn cells(low: [usize; 3], high: [usize; 3]) -> Cells {
    Cells { low, high }
}

impl Draw {
    pub(super) fn new(seed: u64, family: &'static str) -> Self {
        let mut random = Random::new(seed);
        let units = family == "other units" || random.unit() < 0.1;
        let [mut length, mut stress] = [1.0, 1e3];
        if units {
            length = 10f64.powf(3.0 * random.signed());
            stress = 10f64.powf(12.0 * random.unit());
        }
        let contrast = match family == "contrast of moduli" || random.unit() < 0.1 {
            true => 6.0,
            false => [0.3, 1.5][random.integer(0, 1)],
        };
        let r = &mut random;
        // A force moves a plane along the axes of the space, and components of displacements are imposed along them.
        let turned = !family.contains("driven by a force") && family != HELD && r.unit() < 0.4;
        let angles = [0; 3].map(|_| 3.0 * r.signed());
        let turn = match turned {
            true => Rotation3::from_euler_angles(angles[0], angles[1], angles[2]),
            false => Rotation3::identity(),
        };
        let strain = 10f64.powf(-4.0 + 2.0 * r.unit());
        let floating = family.starts_with("floating");
        let (bends, holds, rubs) = (Random::new(seed + 2), Random::new(seed + 3), Random::new(seed + 4));
        let springs = Random::new(seed + 5);
        Self { random, bends, holds, rubs, springs, family, length, stress, strain, contrast, turn, floating }
    }

    /// Decides about a feature: its own family always has it.
    fn on(&mut self, chance: f64, feature: &str) -> bool {
        let drawn = self.random.unit() < chance;
        drawn || self.family == feature
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.random.unit()
    }

    fn count(&mut self, low: usize, high: usize) -> usize {
        self.random.integer(low, high)
    }

    fn sizes(&mut self, blocks: usize) -> Vec<f64> {
        (0..blocks).map(|_| self.length * self.between(0.4, 1.4)).collect()
    }

    fn layout(&mut self) -> Layout {
        let layouts = ["stack", "stack", "boxes on a box", "corner of obstacles", "wall of boxes"];
        let drawn = layouts[self.count(0, layouts.len() - 1)];
        match self.family {
            "one body" => self.boxes([1, 1, 1], vec![cells([0; 3], [1; 3])]),
            "stack" => self.stack(),
            "curved contact held on both sides" => {
                let n = self.count(2, 3);
                self.boxes([1, 1, n], (0..n).map(|k| cells([0, 0, k], [1, 1, k + 1])).collect())
            }
            "boxes on a box" => self.on_a_box(),
            "corner of obstacles" => self.corner(),
            "wall of boxes" => self.wall(),
            _ => match drawn {
                "stack" => self.stack(),
                "boxes on a box" => self.on_a_box(),
                "corner of obstacles" => self.corner(),
                _ => self.wall(),
            },
        }
    }

    fn boxes(&mut self, blocks: [usize; 3], boxes: Vec<Cells>) -> Layout {
        Layout { sizes: blocks.map(|n| self.sizes(n)), boxes }
    }

    fn stack(&mut self) -> Layout {
        let n = self.count(1, 4);
        self.boxes([1, 1, n], (0..n).map(|k| cells([0, 0, k], [1, 1, k + 1])).collect())
    }

    /// Two to four boxes side by side on one, beside each other or apart.
    fn on_a_box(&mut self) -> Layout {
        let (nx, ny) = [(2, 1), (3, 1), (4, 1), (2, 2), (3, 2)][self.count(0, 4)];
        let mut boxes = vec![cells([0, 0, 0], [nx, ny, 1])];
        for (i, j) in (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))) {
            let height = self.count(1, 2);
            if boxes.len() < 5 && self.random.unit() < 0.8 {
                boxes.push(cells([i, j, 1], [i + 1, j + 1, 1 + height]));
            }
        }
        self.boxes([nx, ny, 3], boxes)
    }

    fn corner(&mut self) -> Layout {
        let one = cells([0; 3], [1; 3]);
        let second = [[1, 0, 0], [0, 1, 0], [0, 0, 1]][self.count(0, 2)];
        let moved = cells(second, second.map(|k| k + 1));
        match self.count(0, 2) {
            0 => self.boxes([1, 1, 1], vec![one]),
            1 => self.boxes(second.map(|k| k + 1), vec![one, moved]),
            // A long one above both, or beside them.
            _ => {
                let third = [second[1], second[2], second[0]];
                let high = [0, 1, 2].map(|k| 1 + second[k] + third[k]);
                let long = cells(third, high);
                self.boxes(high, vec![one, moved, long])
            }
        }
    }

    /// Boxes in staggered layers.
    fn wall(&mut self) -> Layout {
        let mut boxes = vec![cells([0, 0, 0], [1, 1, 1]), cells([1, 0, 0], [3, 1, 1])];
        boxes.push(cells([0, 0, 1], [2, 1, 2]));
        if self.random.unit() < 0.6 {
            boxes.push(cells([2, 0, 1], [3, 1, 2]));
            if self.random.unit() < 0.5 {
                boxes.push(cells([0, 0, 2], [3, 1, 3]));
            }
        }
        self.boxes([3, 1, 3], boxes)
    }

    /// Draws an assembly.
    ///
    /// # Errors
    /// Materials that cannot be made: a fault of the generator.
    pub(super) fn assembly(&mut self) -> Made<Assembly> {
        let layout = self.layout();
        let (grid, boxes) = self.grid(layout)?;
        let mut parts = Vec::new();
        for of in &boxes {
            parts.push(self.part(*of, &grid)?);
        }
        let mut assembly =
            Assembly { grid, parts, touches: Vec::new(), turn: self.turn, friction_on_obstacles: None };
        self.touches(&mut assembly);
        self.bend(&mut assembly, &boxes)?;
        self.conditions(&mut assembly);
        self.hold(&mut assembly);
        self.rub(&mut assembly);
        self.spring(&mut assembly);
        self.warm(&mut assembly)?;
        self.tighten(&mut assembly);
        self.hold_along(&mut assembly);
        self.bond(&mut assembly);
        Ok(assembly)
    }

    /// Cuts the blocks into cells, and moves nodes.
    fn grid(&mut self, layout: Layout) -> Made<(Grid, Vec<Cells>)> {
        let most = if layout.boxes.len() == 1 { 4 } else { 2 };
        // The planes of the blocks by their places among all planes.
        let mut cuts: [Vec<usize>; 3] = Default::default();
        let mut boxes = Vec::new();
        for attempt in 0.. {
            let most = if attempt > 6 { 1 } else { most };
            for a in 0..3 {
                cuts[a] = vec![0];
                for _ in &layout.sizes[a] {
                    let last = cuts[a][cuts[a].len() - 1];
                    cuts[a].push(last + self.count(1, most));
                }
            }
            let place = |of: [usize; 3]| [0, 1, 2].map(|a: usize| cuts[a][of[a]]);
            boxes = layout.boxes.iter().map(|of| cells(place(of.low), place(of.high))).collect();
            if boxes.iter().map(Cells::nodes).sum::<usize>() <= NODES || most == 1 {
                break;
            }
        }
        let mut planes: [Vec<f64>; 3] = [vec![0.0], vec![0.0], vec![0.0]];
        for a in 0..3 {
            for (block, size) in layout.sizes[a].iter().enumerate() {
                let (n, start) = (cuts[a][block + 1] - cuts[a][block], planes[a][planes[a].len() - 1]);
                planes[a].extend((1..=n).map(|k| start + size * k as f64 / n as f64));
            }
        }
        let mut grid = Grid::new(planes, &boxes, &mut self.random);
        let slivers = self.on(0.08, "slivers");
        let thin = self.random.unit() < 0.5;
        let target = self.between(2.0, 6.0);
        if slivers && !thin {
            grid.part = bisected(target, |part| grid.with_moves(part).smallest_angle(&boxes))?;
        }
        if slivers && grid.smallest_angle(&boxes)? > 1.2 * target {
            // One layer of cells is thin.
            grid.part = 0.0;
            let axis = self.count(0, 2);
            let layer = self.count(1, grid.planes[axis].len() - 1);
            let thinner = |part: f64| -> Grid {
                let mut thin = grid.clone();
                let by = part * (thin.planes[axis][layer] - thin.planes[axis][layer - 1]);
                thin.planes[axis][layer..].iter_mut().for_each(|x| *x -= by);
                thin
            };
            let part = bisected(target, |part| thinner(0.999 * part).smallest_angle(&boxes))?;
            grid = thinner(0.999 * part);
        } else if !slivers && self.random.unit() < 0.5 {
            grid.part = 0.25;
        }
        Ok((grid, boxes))
    }

    fn part(&mut self, of: Cells, grid: &Grid) -> Made<Part> {
        let young = self.stress * 10f64.powf(self.contrast * self.random.unit());
        let mut materials = vec![self.material(young)?];
        let mut divided = None;
        let axis = self.count(0, 2);
        if self.on(0.1, "two materials in a body") && of.counts()[axis] > 1 {
            let other = young * 10f64.powf(2.0 * self.random.signed());
            materials.push(self.material(other)?);
            divided = Some((axis, self.count(of.low[axis] + 1, of.high[axis] - 1)));
        }
        let mut weight = Vector3::zeros();
        if self.random.unit() < 0.3 {
            weight[2] = -self.pressure() * self.random.unit() / grid.sizes(&of)[2];
        }
        if self.family == "corner of obstacles" && self.random.unit() < 0.5 {
            weight = Vector3::from_fn(|_, _| -self.pressure() * self.random.unit() / self.length);
        }
        Ok(Part {
            cells: of,
            materials,
            divided,
            sides: [Condition::Free; 6],
            weight,
            inside: None,
            cut: None,
        })
    }

    fn pressure(&self) -> f64 {
        self.stress * self.strain
    }

    fn material(&mut self, young: f64) -> Made<LinearElastic<Solid>> {
        if self.on(0.08, "orthotropic material") {
            let [e, f, g, h, k] = [0; 5].map(|_| young * 10f64.powf(self.random.signed()));
            let mut constants =
                Orthotropic::in_plane([e, f], 0.3 * self.random.unit(), g, 3.0 * self.random.unit());
            constants.young_3 = h;
            // Small ratios keep it positive definite at any moduli.
            for ratio in [&mut constants.poisson_12, &mut constants.poisson_13, &mut constants.poisson_23] {
                *ratio = 0.1 * self.random.unit();
            }
            let mut vector = || Vector3::from_fn(|_, _| self.random.signed());
            let plane = [vector(), vector()];
            return Ok(LinearElastic::orthotropic_solid(&constants, [k, 0.5 * (k + g)], plane)?);
        }
        if self.on(0.06, "given stiffness") {
            let random = Matrix6::from_fn(|_, _| self.random.signed());
            let square = random * random.transpose() + Matrix6::identity() * self.between(0.05, 1.0);
            return Ok(LinearElastic::from_solid_stiffness(
                [0, 1, 2, 3, 4, 5]
                    .map(|i| [0, 1, 2, 3, 4, 5].map(|j| 0.5 * young * (square[(i, j)] + square[(j, i)]))),
            )?);
        }
        let poisson = match self.on(0.08, "nearly incompressible") {
            true => 0.5 - 10f64.powf(self.between(-4.0, -2.0)),
            false => 0.45 * self.random.unit(),
        };
        Ok(LinearElastic::isotropic_solid(young, poisson)?)
    }

    /// A linear function over a side; its slopes are parts of its mean.
    fn linear(&mut self, grid: &Grid, side: &Cells, mean: f64, slope: f64) -> Linear {
        let (about, sizes) = (grid.middle(side), grid.sizes(side));
        let along = |a: usize| sizes[a] > 0.0;
        let slope =
            Vector3::from_fn(
                |a, _| {
                    if along(a) { mean * slope * self.random.signed() / sizes[a] } else { 0.0 }
                },
            );
        Linear { middle: mean, slope, about }
    }

    fn gap(&mut self, grid: &Grid, side: &Cells) -> Linear {
        match self.on(0.15, "gap") && self.random.unit() < 0.8 {
            true => {
                let size = self.length * self.strain * self.between(0.1, 2.0);
                self.linear(grid, side, size, 0.9)
            }
            // A slope of more than the mean opens one end.
            false if self.family.starts_with("interference") => {
                let size = -self.length * self.strain * self.between(0.1, 1.0);
                self.linear(grid, side, size, 1.5)
            }
            false => Linear::constant(0.0),
        }
    }

    /// Finds the common faces.
    fn touches(&mut self, assembly: &mut Assembly) {
        let count = assembly.parts.len();
        for (a, b, axis) in
            (0..count).flat_map(|a| (0..count).flat_map(move |b| (0..3).map(move |axis| (a, b, axis))))
        {
            let [first, second] = [a, b].map(|k| assembly.parts[k].cells);
            if a == b || first.high[axis] != second.low[axis] {
                continue;
            }
            if let Some(faces) = first.side(axis + 3).common(&second.side(axis), axis) {
                let gap = self.gap(&assembly.grid, &faces);
                assembly.touches.push(Touch {
                    bodies: [a, b],
                    axis,
                    faces,
                    gap,
                    declared: None,
                    friction: None,
                    bond: None,
                    held: [[None; 3]; 2],
                });
            }
        }
    }

    /// Bends common sides: smoothly or with kinks. Sides beside round obstacles stay as they are: these are placed at the nodes before.
    fn bend(&mut self, assembly: &mut Assembly, boxes: &[Cells]) -> Made<()> {
        let random = &mut self.bends;
        let drawn = random.unit() < 0.15 || self.family.contains("curve");
        if !drawn || self.family.contains("round") || self.family == HELD {
            return Ok(());
        }
        for touch in &mut assembly.touches {
            let grid = &assembly.grid;
            let (axis, sizes) = (touch.axis, grid.sizes(&touch.faces));
            let (form, size) = (random.unit(), 0.3 * random.signed());
            let about = [0; 3].map(|_| random.unit());
            // On a sphere or a cylinder along the first axis across the normal.
            let kind = match form {
                form if form < 0.5 => None,
                form if form < 0.75 => Some(SurfaceKind::Cylinder),
                _ => Some(SurfaceKind::Sphere),
            };
            let kind = kind.filter(|_| grid.is_whole((axis, &touch.faces), boxes));
            let radius = sizes.norm() * (1.0 + 1.0 / size.abs());
            let skipped = kind.filter(|kind| *kind == SurfaceKind::Cylinder).map(|_| (axis + 1) % 3);
            let height = |at: [usize; 3]| {
                let arm = |a: usize| {
                    let low = grid.planes[a][touch.faces.low[a]];
                    if a == axis || Some(a) == skipped {
                        0.0
                    } else {
                        grid.point(at)[a] - low - about[a] * sizes[a]
                    }
                };
                let squared: f64 = (0..3).map(|a| arm(a).powi(2)).sum();
                if kind.is_some() {
                    return size.signum() * (radius - (radius * radius - squared).sqrt());
                }
                size * grid.spacing(at, axis)
                    * if form < 0.2 { random.signed() } else { squared / sizes.norm_squared() }
            };
            if let Some(grid) = grid.bent((axis, &touch.faces), boxes, height)? {
                assembly.grid = grid;
                touch.declared = kind;
            }
        }
        Ok(())
    }

    /// Lets supports hold both bodies of bent sides at a side that they share: alike, or a little apart.
    fn hold(&mut self, assembly: &mut Assembly) {
        let family = self.family == "curved contact held on both sides";
        let drawn = self.holds.unit() < 0.2 && self.family == "curved contact";
        if !(family || drawn) {
            return;
        }
        // Few supports beside each other agree at their common edge.
        let alone = self.holds.unit() < 0.7;
        let pressure = self.pressure();
        for touch in assembly.touches.clone() {
            let [first, second] = touch.bodies;
            let flush = |side: &usize| {
                let place = |b: usize| assembly.parts[b].cells.side(*side).low[side % 3];
                side % 3 != touch.axis
                    && place(first) == place(second)
                    && touch.bodies.iter().all(|b| assembly.is_free(*b, *side))
            };
            let sides: Vec<usize> = (0..6).filter(flush).collect();
            if sides.is_empty() {
                continue;
            }
            let side = sides[self.holds.integer(0, sides.len() - 1)];
            let size = self.length * self.strain;
            let (kind, apart) = (self.holds.unit(), self.holds.unit());
            let values = [0; 3].map(|_| size * self.holds.signed());
            for (k, b) in touch.bodies.into_iter().enumerate() {
                for other in &mut assembly.parts[b].sides {
                    let loaded =
                        matches!(other, Condition::Free | Condition::Pressure(_) | Condition::Traction(_));
                    if alone && !loaded {
                        *other = Condition::Pressure(Linear::constant(pressure * self.holds.unit()));
                    }
                }
                let mut values = values;
                if k == 1 && kind > 0.8 {
                    values[touch.axis] += size * apart;
                }
                assembly.parts[b].sides[side] = match kind < 0.5 {
                    true => Condition::Fixed,
                    false => Condition::Imposed(values.map(Linear::constant)),
                };
            }
        }
    }

    /// Bonds bodies that touch each other.
    fn bond(&mut self, assembly: &mut Assembly) {
        if self.family != BONDED {
            return;
        }
        // Bonded bodies have one body force.
        let weight = assembly.parts[0].weight;
        assembly.parts.iter_mut().for_each(|part| part.weight = weight);
        let random = &mut self.springs;
        let moved = if random.unit() < 0.5 { 0.0 } else { self.length * self.strain };
        // Around a circle of bonds the offsets add up to zero.
        let moves: Vec<Vector3<f64>> =
            assembly.parts.iter().map(|_| Vector3::from_fn(|_, _| moved * random.signed())).collect();
        for touch in &mut assembly.touches {
            let [first, second] = touch.bodies;
            if random.unit() < 0.7 {
                touch.bond = Some(moves[second] - moves[first]);
            }
        }
    }

    /// Lets supports hold contact sides along themselves.
    fn hold_along(&mut self, assembly: &mut Assembly) {
        if self.family != HELD {
            return;
        }
        let random = &mut self.springs;
        for touch in &mut assembly.touches {
            let about = assembly.grid.middle(&touch.faces);
            for (held, axis) in touch.held.iter_mut().flat_map(|held| held.iter_mut().zip(0..)) {
                if axis == touch.axis || random.unit() < 0.5 {
                    continue;
                }
                let amount = if random.unit() < 0.8 { 0.0 } else { self.strain };
                let slope = Vector3::from_fn(|_, _| amount * random.signed());
                *held = Some(Linear { middle: amount * self.length * random.signed(), slope, about });
            }
        }
    }

    /// Puts held and free sides on springs.
    fn spring(&mut self, assembly: &mut Assembly) {
        if self.family != "springs" {
            return;
        }
        let (unit, moved) = (self.stress / self.length, self.length * self.strain);
        let random = &mut self.springs;
        for side in assembly.parts.iter_mut().flat_map(|part| &mut part.sides) {
            let chance = random.unit();
            let along = match side {
                Condition::Fixed | Condition::Imposed(_) if chance < 0.9 => SpringDirection::All,
                Condition::Roller(_) if chance < 0.4 => SpringDirection::Normal,
                Condition::Roller(_) if chance < 0.6 => SpringDirection::All,
                Condition::Free if chance < 0.15 => {
                    SpringDirection::Vector(Vector3::from_fn(|_, _| random.signed()) + Vector3::x() * 2.0)
                }
                _ => continue,
            };
            let stiffness = unit * 10f64.powf(3.0 * random.signed());
            let about = Vector3::zeros();
            let relaxed = random.unit() < 0.6;
            let rest = [0; 3].map(|_| match relaxed {
                true => Linear::constant(0.0),
                false => {
                    let slope = Vector3::from_fn(|_, _| self.strain * random.signed());
                    Linear { middle: moved * random.signed(), slope, about }
                }
            });
            *side = Condition::Springs(stiffness, along, rest);
        }
    }

    /// Changes the temperature of bodies, and puts linear forces into them.
    fn warm(&mut self, assembly: &mut Assembly) -> Made<()> {
        if self.family != "heat and forces" {
            return Ok(());
        }
        const EXPANSION: f64 = 1.5e-5;
        let about = assembly.grid.middle(&assembly.parts[0].cells);
        for part in &mut assembly.parts {
            let mut linear = |amount: f64| {
                let slope = Vector3::from_fn(|_, _| amount / self.length * self.springs.signed());
                Linear { middle: amount * self.springs.signed(), slope, about }
            };
            let temperature = linear(self.strain / EXPANSION);
            part.inside =
                Some((temperature, [0; 3].map(|_| linear(self.stress * self.strain / self.length))));
            for material in &mut part.materials {
                *material = material.clone().with_expansion(EXPANSION)?;
            }
        }
        Ok(())
    }

    /// Cuts a body between two layers of its cells.
    fn tighten(&mut self, assembly: &mut Assembly) {
        if self.family != "cuts" {
            return;
        }
        // Nodes stay on the planes of the grid.
        assembly.grid = assembly.grid.with_moves(0.0);
        let random = &mut self.springs;
        let layers = |part: &Part, axis: usize| part.cells.counts()[axis] >= 2;
        let places = |(b, part): (usize, &Part)| {
            (0..3).filter(|axis| layers(part, *axis)).map(|axis| (b, axis)).collect::<Vec<_>>()
        };
        let places: Vec<(usize, usize)> = assembly.parts.iter().enumerate().flat_map(places).collect();
        if places.is_empty() {
            return;
        }
        let (b, axis) = places[random.integer(0, places.len() - 1)];
        let part = &mut assembly.parts[b];
        let across = part.sides.iter_mut().enumerate().filter(|(side, _)| side % 3 != axis);
        for (_, condition) in across {
            // What holds a side along the axis ends the cut.
            match condition {
                Condition::Fixed | Condition::Imposed(_) => {
                    *condition = Condition::Roller(Linear::constant(0.0))
                }
                Condition::Rigid(..) | Condition::Round(..) => *condition = Condition::Free,
                _ => {}
            }
        }
        let plane = random.integer(part.cells.low[axis] + 1, part.cells.high[axis] - 1);
        let sizes = assembly.grid.sizes(&part.cells);
        let area = sizes.iter().product::<f64>() / sizes[axis];
        let load = match random.unit() < 0.5 {
            true => CutLoad::Shortening(self.strain * sizes[axis] * random.signed()),
            false => CutLoad::Force(self.strain * self.stress * area * (random.unit() - 0.2)),
        };
        part.cut = Some((axis, plane, load));
    }

    /// Gives sides that touch each other or obstacles a limit of friction.
    fn rub(&mut self, assembly: &mut Assembly) {
        if !self.family.contains("friction") {
            return;
        }
        let pressure = self.pressure();
        let random = &mut self.rubs;
        let mut limit = |about: Vector3<f64>, sizes: Vector3<f64>| {
            let middle = match random.unit() < 0.05 {
                true => 0.0,
                false => pressure * 10f64.powf(-1.5 + 2.2 * random.unit()),
            };
            // It stays positive on the side.
            let slope =
                sizes.map(|size| if size > 0.0 { 0.6 * middle * random.signed() / size } else { 0.0 });
            (random.unit() < 0.8).then_some(Linear { middle, slope, about })
        };
        for k in 0..assembly.touches.len() {
            let faces = assembly.touches[k].faces;
            assembly.touches[k].friction = limit(assembly.grid.middle(&faces), assembly.grid.sizes(&faces));
        }
        assembly.friction_on_obstacles = limit(Vector3::zeros(), Vector3::zeros());
    }

    fn plane(&mut self, grid: &Grid, (number, side): (usize, &Cells), by: f64) -> Condition {
        if self.family.contains("round obstacle") && self.random.unit() < 0.8 {
            return self.round(grid, (number, side), Drive::Moved(by));
        }
        Condition::Plane(self.gap(grid, side), Drive::Moved(by))
    }

    /// A sphere or a cylinder that touches a side: with little distances from it and a given gap, or with its own distances.
    fn round(&mut self, grid: &Grid, (number, side): (usize, &Cells), drive: Drive) -> Condition {
        let (normal, sizes) = (number % 3, grid.sizes(side));
        let out = if number < 3 { -1.0 } else { 1.0 };
        let diagonal = sizes.norm();
        let mut centre = grid.middle(side);
        let across: Vec<usize> = (0..3).filter(|a| *a != normal).collect();
        // Sometimes above a corner, with faces that are symmetric to nothing.
        for a in &across {
            centre[*a] += sizes[*a] * [0.0, 0.3 * self.random.signed(), 0.5][self.count(0, 2)];
        }
        let axis = match self.count(0, 2) {
            0 => None,
            1 => Some(Vector3::ith(across[self.count(0, 1)], 1.0)),
            _ => Some(Vector3::from_fn(|a, _| if a == normal { 0.0 } else { 0.1 + self.random.unit() })),
        };
        let inside = self.random.unit() < 0.4;
        // Bodies deform by little: their faces have to be near to touch.
        let flat = self.random.unit() < 0.5;
        let far = if flat { self.between(20.0, 200.0) } else { self.between(1.0, 3.0) } * diagonal;
        centre[normal] += if inside { -out * far } else { out * far };
        // The distance of the corner that is farthest from it, or of the tangent plane.
        let corner = |k: usize| {
            let place = |a: usize| [side.low[a], side.high[a]][k >> a & 1];
            let arm = Vector3::from_fn(|a, _| grid.planes[a][place(a)]) - centre;
            axis.map_or(arm, |axis| arm - axis * (arm.dot(&axis) / axis.norm_squared())).norm()
        };
        let radius = if inside { (0..8).map(corner).fold(0.0, f64::max) } else { far };
        let gap = match flat && self.random.unit() < 0.5 {
            true => Some(self.gap(grid, side)),
            false => None,
        };
        Condition::Round(Round { centre, axis, radius, inside, gap }, drive)
    }

    /// Draws supports at the smallest coordinates, and loads on the others.
    fn conditions(&mut self, assembly: &mut Assembly) {
        let grid = assembly.grid.clone();
        let in_corner = self.family == "corner of obstacles" || self.random.unit() < 0.15;
        let mut loaded = false;
        for b in 0..assembly.parts.len() {
            let of = assembly.parts[b].cells;
            let mut pushed = [false; 3];
            for side in [2, 0, 1] {
                let flat = of.side(side);
                if of.low[side] > 0 || !assembly.is_free(b, side) {
                    continue;
                }
                let condition = self.ground(&grid, side, &flat, in_corner);
                pushed[side] = !matches!(condition, Condition::Free);
                if matches!(condition, Condition::Fixed | Condition::Imposed(_) | Condition::Rigid(..)) {
                    pushed = [true; 3];
                }
                assembly.parts[b].sides[side] = condition;
            }
            for side in [5, 3, 4] {
                let flat = of.side(side);
                if !assembly.is_free(b, side) {
                    continue;
                }
                let rubs = self.family.contains("friction");
                let may = side == 5 && (self.random.unit() < 0.85 || !loaded)
                    || side < 5
                        && (pushed[side - 3] || rubs && self.random.unit() < 0.3)
                        && self.random.unit() < if in_corner { 0.8 } else { 0.3 };
                if may {
                    loaded = true;
                    assembly.parts[b].sides[side] = self.load(
                        &grid,
                        side,
                        &flat,
                        pushed == [true; 3] || self.family.contains("friction"),
                    );
                }
            }
        }
    }

    /// The condition of a side at the smallest coordinate.
    fn ground(&mut self, grid: &Grid, side: usize, flat: &Cells, in_corner: bool) -> Condition {
        let size = self.length * self.strain;
        let by = if self.random.unit() < 0.2 { size * self.random.unit() } else { 0.0 };
        if self.floating || in_corner && self.random.unit() < 0.8 {
            return match side == 2 || self.random.unit() < 0.7 {
                true => self.plane(grid, (side, flat), by),
                false => Condition::Free,
            };
        }
        let choice = self.random.unit();
        match side {
            2 if choice < 0.4 => Condition::Fixed,
            2 if choice < 0.5 => {
                let value = size * self.random.signed();
                Condition::Imposed([0; 3].map(|_| self.linear(grid, flat, value, 0.5)))
            }
            2 if choice < 0.55 => Condition::Rigid([Some(0.0); 6], Vector3::zeros(), Vector3::zeros()),
            2 if choice < 0.75 => Condition::Roller(Linear::constant(0.0)),
            2 => self.plane(grid, (side, flat), by),
            _ if choice < 0.35 => Condition::Free,
            _ if choice < 0.85 => Condition::Roller(Linear::constant(0.0)),
            _ => self.plane(grid, (side, flat), by),
        }
    }

    /// The load on a side.
    ///
    /// * `held`: true if loads in any direction are carried.
    fn load(&mut self, grid: &Grid, side: usize, flat: &Cells, held: bool) -> Condition {
        let (pressure, push) = (self.pressure(), self.length * self.strain);
        let area: f64 = grid.sizes(flat).iter().filter(|s| **s > 0.0).product();
        let straight = self.turn == Rotation3::identity();
        let inwards = |amount: f64| Vector3::ith(side % 3, -amount);
        let round = self.family == "round obstacle driven by a force";
        if side == 5 && straight && (round || self.on(0.1, "plane driven by a force")) {
            let offset = Vector3::from_fn(|a, _| 0.25 * self.random.signed() * grid.sizes(flat)[a]);
            let drive = Drive::Force(pressure * area, grid.middle(flat) + offset);
            if round {
                return self.round(grid, (side, flat), drive);
            }
            return Condition::Plane(self.gap(grid, flat), drive);
        }
        if side == 5 && self.on(0.08, "rigid side") {
            if self.random.unit() < 0.3 {
                let tilt = push / self.length * self.random.signed();
                let mut motion = [Some(0.0); 6];
                motion[2] = Some(-push);
                if straight {
                    motion[3] = Some(0.3 * tilt);
                    motion[5] = None;
                }
                return Condition::Rigid(motion, Vector3::zeros(), Vector3::zeros());
            }
            let tilt = 0.2 * pressure * area * self.length;
            let moment = Vector3::new(tilt * self.random.signed(), tilt * self.random.signed(), 0.0);
            return Condition::Rigid([None; 6], inwards(pressure * area), moment);
        }
        let choice = self.random.unit();
        match () {
            () if held && choice < 0.3 => {
                let mut values = [0; 3].map(|_| pressure * self.random.signed());
                if self.family.contains("friction") {
                    // It presses more than it pushes, or friction would seldom hold.
                    values = values.map(|value| 0.25 * value);
                    values[side % 3] = -pressure * (0.5 + 0.5 * self.random.unit());
                }
                Condition::Traction(values.map(|value| self.linear(grid, flat, value, 0.7)))
            }
            () if choice < 0.6 => Condition::Pressure(self.linear(grid, flat, pressure, 1.2)),
            () if choice < 0.8 => Condition::Roller(self.linear(grid, flat, -push, 0.9)),
            () => self.plane(grid, (side, flat), push),
        }
    }
}

/// Finds the part in `[0, 1]` with an angle, which falls.
fn bisected(target: f64, angle: impl Fn(f64) -> Made<f64>) -> Made<f64> {
    let (mut low, mut high) = (0.0, 1.0);
    if angle(high)? >= target {
        return Ok(high);
    }
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        *(if angle(middle)? >= target { &mut low } else { &mut high }) = middle;
    }
    Ok(low)
}
