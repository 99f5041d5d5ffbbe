//! Random rollers between two plates, coarse polygons that only contact holds, from case files.
//!
//! ```text
//!   ▒┌──────────┐ random pressure, linear along the top
//!   ▒└──────────┘
//!        ⬡        8 to 24 edges, turned at random; its contact normals are its own or vertical
//!    ┌──────────┐
//!    └──────────┘
//!      clamped
//! ```
//! There are no reference values: [`crate::distance::outcome`] holds the bound against a finer mesh of the same polygon.

use crate::mesh_files::{Encoding, Format, write};
use crate::model::{ContactProblem, Made, NodeId, TriMesh, Vector};
use crate::random::Random;
use case_io::Case;
use fem_core::mesh::MeshError;
use std::f64::consts::TAU;

/// Meshes a regular polygon with `edges` edges by rings of as many nodes; its side is named `rim`.
///
/// * `start`: the direction of its first corner, radians.
///
/// # Errors
/// None for three edges or more.
pub fn polygon(centre: Vector, radius: f64, edges: usize, start: f64) -> Result<TriMesh, MeshError> {
    let rings = (edges / 6).max(2);
    let mut points = vec![centre];
    for k in 1..=rings {
        let r = radius * k as f64 / rings as f64;
        for j in 0..edges {
            let angle = start + TAU * j as f64 / edges as f64;
            points.push(centre + r * Vector::new(angle.cos(), angle.sin()));
        }
    }
    let node = |k: usize, j: usize| NodeId::new(1 + (k - 1) * edges + j % edges);
    let mut triangles = Vec::new();
    for j in 0..edges {
        triangles.push([NodeId::new(0), node(1, j), node(1, j + 1)]);
        for k in 1..rings {
            triangles.push([node(k, j), node(k + 1, j), node(k + 1, j + 1)]);
            triangles.push([node(k, j), node(k + 1, j + 1), node(k, j + 1)]);
        }
    }
    let rim = (0..edges).map(|j| [node(rings, j), node(rings, j + 1)]).collect();
    TriMesh::new(points, triangles, vec![("rim".to_owned(), rim)])
}

/// A random roller of radius 1 about (0, 1).
#[derive(Clone, Debug)]
pub struct Roller {
    /// Edges of the polygon.
    pub edges: usize,
    /// True if the contact normals are vertical.
    pub vertical: bool,
    /// The case file.
    pub text: String,
    mesh: TriMesh,
}

impl Roller {
    /// Makes the roller with a number; `vertical`: its contact normals.
    ///
    /// # Errors
    /// None.
    pub fn new(number: u64, vertical: bool) -> Made<Self> {
        let mut random = Random::new(7000 + number);
        let edges = 8 + (17.0 * random.unit()) as usize;
        let mesh = polygon(Vector::new(0.0, 1.0), 1.0, edges, TAU * random.unit())?;
        let contrast = 10f64.powf(2.0 * random.signed());
        let mean = 10f64.powf(-1.0 + 2.0 * random.unit());
        let slope = mean * random.signed();
        let width = 0.5 + 1.5 * random.unit();
        let height = 0.5 + random.unit();
        let [below, above] = [0, 1].map(|_| 4 + (17.0 * random.unit()) as usize);
        let across = 2 + (4.0 * random.unit()) as usize;
        let plate = |name: &str, y: f64, cells: usize| {
            format!(
                "[[body]]\nname = \"{name}\"\nmaterial = \"plate\"\ngenerator = {{ kind = \"block\", origin = [{:?}, {y:?}], \
                 size = [{:?}, {height:?}], cells = [{cells}, {across}] }}\n",
                -width,
                2.0 * width
            )
        };
        let normal = |y: f64| if vertical { format!("normal = [0.0, {y:?}]\n") } else { String::new() };
        let pair = |plate: &str, side: &str, y: f64| {
            format!(
                "[[contact]]\nbodies = [\"roller\", \"{plate}\"]\nsurfaces = [\"roller.rim\", \"{side}\"]\ngap = \"geometric\"\n{}",
                normal(y)
            )
        };
        let text = format!(
            "schema = 1\n[materials.plate]\nyoung = 1000.0\npoisson = 0.3\n[materials.roller]\nyoung = {:?}\npoisson = 0.3\n\
             {}[[body.displacement]]\non = \"bottom\"\nfixed = true\n\
             [[body]]\nname = \"roller\"\nmaterial = \"roller\"\nmesh = {{ file = \"roller.msh\", region = \"roller\" }}\n\
             {}[[body.displacement]]\non = \"left\"\nux = 0.0\n\
             [[body.traction]]\non = \"top\"\npressure = \"{mean:?} + ({:?})*x\"\n{}{}",
            1000.0 * contrast,
            plate("base", -height, below),
            plate("top", 2.0, above),
            slope / width,
            pair("base", "top", -1.0),
            pair("top", "bottom", 1.0)
        );
        Ok(Self { edges, vertical, text, mesh })
    }

    /// Makes its problem.
    ///
    /// # Errors
    /// A case that is refused.
    pub fn problem(&self) -> Made<ContactProblem> {
        let folder = tempfile::tempdir()?;
        let file = write(&[("roller", &self.mesh)], Format::Msh2(Encoding::Text));
        std::fs::write(folder.path().join("roller.msh"), file)?;
        let mut case = Case::parse(&self.text, "roller.toml", &[])?;
        case.read_mesh_files(folder.path())?;
        Ok(case.build()?.0)
    }
}
