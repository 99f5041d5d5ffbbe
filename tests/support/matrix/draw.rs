//! A random case file under construction: numbers with units, bodies with materials and meshes, pairs of surfaces.

use crate::mesh_files::{self, Encoding, Format};
use crate::model::{Made, TriMesh, Vector, block};
use crate::random::Random;
use crate::shapes::moved;
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fmt::Write as _;

/// The sides of a block, with their outward normals.
const SIDES: [(&str, [f64; 2]); 4] =
    [("bottom", [0.0, -1.0]), ("top", [0.0, 1.0]), ("left", [-1.0, 0.0]), ("right", [1.0, 0.0])];

/// A body of a case: its name, and the place of its sides' names.
#[derive(Clone, Debug)]
pub(super) struct Member {
    /// Its name.
    pub(super) name: String,
    /// The prefix of the names of its sides.
    prefix: String,
    /// A modulus of its material.
    pub(super) young: f64,
    /// Poisson's ratio, for an isotropic one.
    pub(super) poisson: f64,
}

impl Member {
    /// Names a side.
    pub(super) fn side(&self, side: &str) -> String {
        format!("{}{side}", self.prefix)
    }
}

/// A case file under construction.
pub(super) struct Draw {
    /// The source of all choices.
    pub(super) random: Random,
    /// The features that were switched on.
    pub(super) features: BTreeSet<&'static str>,
    /// Unit of length, unit of stress, typical strain, and the place of the origin.
    pub(super) length: f64,
    /// Unit of stress.
    pub(super) stress: f64,
    /// Typical strain.
    pub(super) strain: f64,
    origin: [f64; 2],
    /// Triangles of each body.
    pub(super) triangles: f64,
    /// True if the meshes match, provided that the layout allows it.
    pub(super) matching: bool,
    /// True if the exact problem is the same on halved cells.
    pub(super) nested: bool,
    /// True for a press fit: gaps are negative.
    pub(super) presses: bool,
    /// Decades of the contrast of the moduli.
    contrast: f64,
    /// True for plane stress.
    pub(super) plane_stress: bool,
    /// True if each body is of one isotropic material.
    pub(super) isotropic: bool,
    head: String,
    bodies: String,
    contacts: String,
    /// Load steps and their conditions.
    pub(super) steps: Vec<String>,
    /// Mesh files with their names.
    pub(super) files: Vec<(String, Vec<u8>)>,
    members: usize,
}

impl Draw {
    /// Draws what all bodies share: units, sizes, materials.
    pub(super) fn new(seed: u64) -> Self {
        let mut random = Random::new(seed);
        let strain = 10f64.powf(-4.0 + 2.0 * random.unit());
        let mut draw = Self {
            features: BTreeSet::new(),
            length: 1.0,
            stress: 1000.0,
            strain,
            origin: [0.0; 2],
            triangles: 0.0,
            matching: false,
            nested: true,
            presses: false,
            contrast: 0.5,
            plane_stress: false,
            isotropic: false,
            head: String::new(),
            bodies: String::new(),
            contacts: String::new(),
            steps: Vec::new(),
            files: Vec::new(),
            members: 0,
            random,
        };
        if draw.on(0.12, "other units") {
            draw.length = 10f64.powf(6.0 * draw.random.signed());
            draw.stress = 10f64.powf(10.0 * draw.random.signed());
        }
        if draw.on(0.06, "far from the origin") {
            let far = draw.length * 10f64.powf(5.0 * draw.random.unit());
            draw.origin = [far * draw.random.signed(), far * draw.random.signed()];
        }
        if draw.on(0.12, "contrast of moduli") {
            draw.contrast = 8.0 * draw.random.unit();
        }
        draw.plane_stress = draw.on(0.2, "plane stress");
        let _ = writeln!(
            draw.head,
            "[model]\nhypothesis = \"plane_{}\"\nthickness = 2.0",
            if draw.plane_stress { "stress" } else { "strain" }
        );
        draw.matching = !draw.on(0.45, "meshes that do not match");
        draw
    }

    /// Switches a feature on with a probability.
    pub(super) fn on(&mut self, probability: f64, feature: &'static str) -> bool {
        let on = self.random.unit() < probability;
        if on {
            self.mark(feature);
        }
        on
    }

    /// Notes a feature.
    pub(super) fn mark(&mut self, feature: &'static str) {
        self.features.insert(feature);
    }

    /// Takes a feature out.
    pub(super) fn unmark(&mut self, feature: &'static str) {
        self.features.remove(feature);
    }

    /// Replaces a text in the model and the materials wherever it is.
    pub(super) fn replace_in_head(&mut self, text: &str, other: &str) {
        self.head = self.head.replace(text, other);
    }

    /// Returns the text of all bodies.
    pub(super) fn bodies(&self) -> &str {
        &self.bodies
    }

    /// Returns the text of all pairs.
    pub(super) fn contacts(&self) -> &str {
        &self.contacts
    }

    /// Replaces the text of all bodies.
    pub(super) fn replace_bodies(&mut self, text: String) {
        self.bodies = text;
    }

    /// Picks one of several features.
    pub(super) fn pick<const N: usize>(&mut self, choices: [&'static str; N]) -> &'static str {
        let choice = choices[self.random.integer(0, N - 1)];
        self.mark(choice);
        choice
    }

    /// Draws a number between two.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.random.unit()
    }

    /// Writes a coordinate.
    pub(super) fn at(&self, axis: usize, x: f64) -> f64 {
        self.origin[axis] + self.length * x
    }

    /// Writes a point.
    pub(super) fn point(&self, [x, y]: [f64; 2]) -> String {
        format!("[{:?}, {:?}]", self.at(0, x), self.at(1, y))
    }

    /// Writes `a + b (x − x₀)`, `a` and `b` in a unit, `x₀` a coordinate.
    pub(super) fn linear(&self, unit: f64, [a, b]: [f64; 2], x: f64) -> String {
        let slope = unit * b / self.length;
        format!("{:?}+({slope:?})*(x-({:?}))", unit * a, self.at(0, x))
    }

    /// Draws numbers of cells along both sides of a block.
    fn cells(&mut self, [width, height]: [f64; 2]) -> [usize; 2] {
        let stretch = 2f64.powf(self.random.signed());
        let count = 0.5 * self.triangles * self.between(0.7, 1.4);
        let columns = if self.matching {
            // The same density along the contact line in all bodies.
            (self.triangles * 0.5).sqrt() * width
        } else {
            (count * width / height).sqrt() * stretch
        };
        let columns = (columns.round() as usize).clamp(2, 60);
        [columns, ((count / columns as f64).round() as usize).clamp(1, 60)]
    }

    /// Draws a material; returns its name, a modulus and Poisson's ratio of an isotropic one.
    fn material(&mut self) -> (String, f64, f64) {
        let name = format!("m{}", self.head.matches("[materials").count());
        let young = self.stress * 10f64.powf(self.contrast * (self.random.unit() - 0.5));
        let kind = if self.isotropic { self.between(0.18, 1.0) } else { self.random.unit() };
        let (text, poisson) = if kind < 0.1 {
            self.mark("orthotropic material");
            let second = young * 10f64.powf(-2.0 * self.random.unit());
            let [angle, shear, nu] =
                [self.between(-90.0, 90.0), self.between(0.2, 0.5), self.between(0.0, 0.4)];
            let mut text = format!(
                "young_1 = {young:?}\nyoung_2 = {second:?}\npoisson_12 = {nu:?}\nshear = {:?}\nangle = {angle:?}",
                shear * second
            );
            if !self.plane_stress {
                let _ = write!(text, "\nyoung_3 = {second:?}\npoisson_13 = {:?}\npoisson_23 = 0.2", 0.5 * nu);
            }
            (text, 0.0)
        } else if kind < 0.18 {
            self.mark("given stiffness");
            let [a, b, c, d] = [1.3, 0.4, 0.9, 0.35].map(|x: f64| young * x * self.between(0.8, 1.2));
            let e = 0.1 * young * self.random.signed();
            (format!("stiffness = [[{a:?}, {b:?}, {e:?}], [{b:?}, {c:?}, 0.0], [{e:?}, 0.0, {d:?}]]"), 0.0)
        } else {
            let poisson = if kind < 0.26 {
                self.mark("nearly incompressible");
                0.5 - 10f64.powf(-1.0 - 3.5 * self.random.unit())
            } else {
                self.between(0.0, 0.45)
            };
            self.mark("isotropic material");
            (format!("young = {young:?}\npoisson = {poisson:?}"), poisson)
        };
        let _ = writeln!(self.head, "[materials.{name}]\n{text}");
        (name, young, poisson)
    }

    /// Adds a body of a generator; `conditions` name a side by `@side`.
    fn body(&mut self, mesh: &str, prefix: &str, conditions: &str) -> Member {
        let name = format!("b{}", self.members);
        self.members += 1;
        let (material, young, poisson) = self.material();
        let conditions = conditions.replace('@', prefix);
        let _ = writeln!(
            self.bodies,
            "[[body]]\nname = \"{name}\"\nmaterial = \"{material}\"\n{mesh}\n{conditions}"
        );
        Member { name, prefix: prefix.into(), young, poisson }
    }

    /// Adds a block, of a generator or of a mesh file.
    ///
    /// # Errors
    /// None.
    pub(super) fn block(&mut self, from: [f64; 2], size: [f64; 2], conditions: &str) -> Made<Member> {
        let cells = self.cells(size);
        let corner = [0, 1].map(|k| self.at(k, from[k]));
        let lengths = size.map(|x| self.length * x);
        let mut more = conditions.to_owned();
        if !self.isotropic && self.on(0.06, "region of another material") {
            let (material, ..) = self.material();
            let middle = [0, 1].map(|k| corner[k] + 0.5 * lengths[k]);
            let far = [0, 1].map(|k| corner[k] + lengths[k]);
            let _ = writeln!(
                more,
                "[[body.region]]\nmaterial = \"{material}\"\nbox = {{ x = [{:?}, {:?}], y = [{:?}, {:?}] }}",
                corner[0], middle[0], corner[1], far[1]
            );
        }
        if self.on(0.15, "mesh file") {
            let name = format!("b{}", self.members);
            let (file, bytes) = self.mesh_file(&name, (corner, lengths), cells)?;
            self.files.push((file.clone(), bytes));
            let mesh = format!("mesh = {{ file = \"{file}\", region = \"{name}\" }}");
            return Ok(self.body(&mesh, &format!("{name}."), &more));
        }
        let mut prefix = "";
        if self.on(0.06, "side by its place") {
            prefix = "at ";
            for (side, [x, y]) in SIDES {
                let _ = writeln!(
                    more,
                    "[[body.side]]\nname = \"at {side}\"\nfacing = [{x:?}, {y:?}]\nwithin = 20.0"
                );
            }
        }
        let mesh = format!(
            "generator = {{ kind = \"block\", origin = {corner:?}, size = {lengths:?}, cells = {cells:?} }}"
        );
        Ok(self.body(&mesh, prefix, &more))
    }

    /// Writes a block whose inner nodes are moved, or whose rows are drawn together.
    fn mesh_file(
        &mut self,
        name: &str,
        (corner, size): ([f64; 2], [f64; 2]),
        cells: [usize; 2],
    ) -> Made<(String, Vec<u8>)> {
        let mesh = block(corner, size, cells)?;
        let thin = self.on(0.2, "slivers");
        let power = 1.0 + if thin { self.between(1.0, 4.0) } else { 0.0 };
        let seed = self.random.integer(0, 1 << 30) as u64;
        let shake = RefCell::new(Random::new(seed));
        let mesh = moved(&mesh, |x| {
            let part = [0, 1].map(|k| (x[k] - corner[k]) / size[k]);
            let inside = part.iter().all(|t| *t > 1e-9 && *t < 1.0 - 1e-9);
            let step = [0, 1]
                .map(|k| if inside { 0.2 * shake.borrow_mut().signed() / cells[k] as f64 } else { 0.0 });
            if thin && part[1] > 1e-9 && part[1] < 1.0 - 1e-9 {
                return Vector::new(x[0], corner[1] + size[1] * part[1].powf(power));
            }
            Vector::new(x[0] + size[0] * step[0], x[1] + size[1] * step[1])
        })?;
        Ok(self.written(name, &mesh))
    }

    /// Writes a mesh in some format.
    fn written(&mut self, name: &str, mesh: &TriMesh) -> (String, Vec<u8>) {
        let formats = [Format::Msh4(Encoding::Text), Format::Msh2(Encoding::Little), Format::Deck];
        let format = formats[self.random.integer(0, 2)];
        (format!("{name}.{}", format.ending()), mesh_files::write(&[(name, mesh)], format))
    }

    /// Adds a body with a mesh of its own, in units of length from the origin, in a mesh file.
    ///
    /// # Errors
    /// None.
    pub(super) fn of_mesh(&mut self, mesh: &TriMesh, conditions: &str) -> Made<Member> {
        self.mark("mesh file");
        let name = format!("b{}", self.members);
        let placed = moved(mesh, |p| Vector::new(self.at(0, p[0]), self.at(1, p[1])))?;
        let (file, bytes) = self.written(&name, &placed);
        self.files.push((file.clone(), bytes));
        let mesh = format!("mesh = {{ file = \"{file}\", region = \"{name}\" }}");
        Ok(self.body(&mesh, &format!("{name}."), conditions))
    }

    /// Adds a disc; its rim is bent.
    pub(super) fn disc(&mut self, centre: [f64; 2], radius: f64, conditions: &str) -> Member {
        let cells = ((self.triangles / 6.0).sqrt().round() as usize).clamp(2, 12);
        let start = self.between(0.0, 360.0);
        let mesh = format!(
            "generator = {{ kind = \"disc\", centre = {}, radius = {:?}, cells = {cells}, start = {start:?} }}",
            self.point(centre),
            self.length * radius
        );
        self.body(&mesh, "", conditions)
    }

    /// Adds a ring about the origin, or a part of one between two angles, degrees.
    pub(super) fn ring(
        &mut self,
        radii: [f64; 2],
        angles: [f64; 2],
        around: usize,
        conditions: &str,
    ) -> Member {
        let across = ((0.5 * self.triangles / around as f64).round() as usize).clamp(1, 12);
        let mesh = format!(
            "generator = {{ kind = \"ring\", centre = {}, radii = {:?}, angles = {angles:?}, cells = [{around}, {across}] }}",
            self.point([0.0; 2]),
            radii.map(|r| self.length * r)
        );
        self.body(&mesh, "", conditions)
    }

    /// Adds a lower half of a disc whose contact zone is at a pole.
    pub(super) fn half_disc(&mut self, pole: [f64; 2], radius: f64, conditions: &str) -> Member {
        let cells = ((0.5 * self.triangles).sqrt().round() as usize).clamp(3, 20);
        let mesh = format!(
            "generator = {{ kind = \"half_disc\", pole = {}, radius = {:?}, facing = \"down\", half_width = {:?}, cells = {cells} }}",
            self.point(pole),
            self.length * radius,
            0.3 * self.length * radius
        );
        self.body(&mesh, "", conditions)
    }

    /// Adds a pair of bodies with further keys.
    pub(super) fn pair(&mut self, bodies: [&Member; 2], surfaces: [&str; 2], more: &str) {
        let names = bodies.map(|b| &b.name);
        let sides = [0, 1].map(|k| bodies[k].side(surfaces[k]));
        let _ = writeln!(self.contacts, "[[contact]]\nbodies = {names:?}\nsurfaces = {sides:?}\n{more}");
    }

    /// Adds a pair of bodies that touch along the same two sides of each, with further keys.
    pub(super) fn pair_on(&mut self, bodies: [&Member; 2], sides: [&str; 2], more: &str) {
        let names = bodies.map(|b| &b.name);
        let lists = bodies.map(|body| sides.map(|side| body.side(side)));
        let _ = writeln!(self.contacts, "[[contact]]\nbodies = {names:?}\nsurfaces = {lists:?}\n{more}");
    }

    /// Adds a pair with an obstacle, and further keys.
    pub(super) fn obstacle(&mut self, body: &Member, surface: &str, obstacle: &str, more: &str) {
        let _ = writeln!(
            self.contacts,
            "[[contact]]\nbodies = [{:?}]\nsurfaces = [{:?}]\nobstacle = {{ {obstacle} }}\n{more}",
            body.name,
            body.side(surface)
        );
    }

    /// Writes a plane through a point.
    pub(super) fn plane(&self, point: [f64; 2], normal: [f64; 2]) -> String {
        format!("kind = \"plane\", point = {}, normal = {normal:?}", self.point(point))
    }

    /// Returns how many bodies there are.
    pub(super) fn count(&self) -> usize {
        self.members
    }

    /// Returns the case file with these settings, dotted keys and their values.
    pub(super) fn text(&self, settings: &[(&str, String)]) -> String {
        let lines: Vec<String> = settings.iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
        let contacts = if self.contacts.is_empty() { "contact = []\n" } else { "" };
        let parts: [&str; 6] =
            [&lines.concat(), contacts, &self.head, &self.bodies, &self.contacts, &self.steps.concat()];
        format!("schema = 1\ntitle = \"A random problem\"\n{}", parts.concat())
    }
}
