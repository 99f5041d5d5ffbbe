//! Cases of the plane.

use super::{Dimension, GeneratorReader, Keys, Refused, Rows};
use crate::case::fixes::refuse_material;
use crate::case::{Case, CurveCase, MaterialLaw, RelaxUntil, Units};
use crate::case_file::{MatrixWords, Reader};
use crate::diagnostic::{CaseError, significant};
use crate::expression::COORDINATES;
use crate::report;
use contact_geometry::common_refinement::common_refinement;
use contact_geometry::{Contact, ContactNormal, Paired, PairingError};
use fem_core::body::{Body, BodyError, CurveKind, CurvedSide, Difference};
use fem_core::geometry::shown;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{Hypothesis, LinearElastic, MaterialError, Orthotropic};
use fem_core::mesh::generate::{self, Facing};
use fem_core::mesh::{MeshError, TriMesh};
use fem_core::space::Plane;
use mesh_io::{MeshFile, MeshFileError, Region, RegionOptions};
use serde::Serialize;
use serde_json::{Value as Json, json};

/// `[model]`: what all bodies of the plane share.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Model {
    /// How the third direction behaves; plane strain by default.
    pub hypothesis: Hypothesis,
    /// Thickness, m, > 0; it only converts results for the reader.
    pub thickness: f64,
}

/// A mesh of the plane that needs no file.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum PlaneGenerator {
    /// `generator = { kind = "block", … }`: a structured rectangle.
    Block {
        /// Lower left corner, m.
        origin: [f64; 2],
        /// Width and height, m.
        size: [f64; 2],
        /// Rectangles in each direction; each is cut in two triangles.
        cells: [usize; 2],
    },
    /// `generator = { kind = "ring", … }`: a ring or a sector of one, see [`fem_core::mesh::generate::ring()`].
    Ring {
        /// Centre, m.
        centre: [f64; 2],
        /// Inner and outer radius, m.
        radii: [f64; 2],
        /// Start and end, degrees.
        angles: [f64; 2],
        /// Cells around and across.
        cells: [usize; 2],
    },
    /// `generator = { kind = "disc", … }`: a full disc, see [`fem_core::mesh::generate::disc()`].
    Disc {
        /// Centre, m.
        centre: [f64; 2],
        /// Radius, m.
        radius: f64,
        /// Cells from the centre to the rim, which has six times as many edges.
        cells: usize,
        /// Direction of the first node of the rim, degrees.
        start: f64,
    },
    /// `generator = { kind = "half_disc", … }`: fine near its pole, see [`fem_core::mesh::generate::half_disc()`].
    HalfDisc {
        /// The middle of the arc, m.
        pole: [f64; 2],
        /// Radius, m.
        radius: f64,
        /// The side of the disc on which its pole lies.
        #[serde(serialize_with = "facing_name")]
        facing: Facing,
        /// Half the width of the side `contact`, m.
        half_width: f64,
        /// Cells from the pole to the end of `contact`.
        cells: usize,
    },
}

impl Default for PlaneGenerator {
    fn default() -> Self {
        Self::Block { origin: [0.0; 2], size: [1.0; 2], cells: [1; 2] }
    }
}

impl Dimension for Plane {
    type Model = Model;
    type Generator = PlaneGenerator;
    type Orthotropic = Orthotropic;
    type Curve = CurveKind;

    const CURVE_TABLE: &'static str = "curve";
    const CURVES: &'static [(&'static str, CurveKind)] =
        &[("arc", CurveKind::Arc), ("smooth", CurveKind::Smooth)];
    const RELAX_UNTIL: RelaxUntil = RelaxUntil { tolerance: 0.02, max_steps: 100 };
    const COORDINATES: &'static [&'static str] = &[COORDINATES[0], COORDINATES[1]];
    const CORNER: &'static str = "an end";
    const EXTENT: &'static str = "length";
    const ALONG: &'static str = "along the edges";
    const CIRCLE: &'static str = "circle";
    const CYLINDERS: bool = false;

    fn model_json(model: &Model) -> Json {
        let hypothesis = HYPOTHESES.iter().find(|(_, h)| *h == model.hypothesis).map_or("", |(name, _)| name);
        json!({ "hypothesis": hypothesis, "thickness": model.thickness })
    }

    fn isotropic(young: f64, poisson: f64, model: &Model) -> Result<LinearElastic, MaterialError> {
        LinearElastic::isotropic(young, poisson, model.hypothesis)
    }

    fn orthotropic(constants: &Orthotropic, model: &Model) -> Result<LinearElastic, MaterialError> {
        let angle = constants.angle.to_radians();
        LinearElastic::orthotropic(&Orthotropic { angle, ..*constants }, model.hypothesis)
    }

    fn of_stiffness(rows: &Rows<Self>, model: &Model) -> Result<LinearElastic, MaterialError> {
        LinearElastic::from_stiffness(*rows, model.hypothesis)
    }

    fn orthotropic_json(c: &Orthotropic) -> Json {
        json!({
            "young_1": c.young_1,
            "young_2": c.young_2,
            "young_3": c.young_3,
            "poisson_12": c.poisson_12,
            "poisson_13": c.poisson_13,
            "poisson_23": c.poisson_23,
            "shear": c.shear,
            "angle": c.angle,
        })
    }

    fn moduli(constants: &Orthotropic) -> [f64; 2] {
        [constants.young_1, constants.young_2]
    }

    fn material_words(constants: Option<&Orthotropic>) -> String {
        let Some(c) = constants else { return "plane stiffness".to_owned() };
        format!("E1 {}  E2 {}  at {} degrees", shown(c.young_1), shown(c.young_2), shown(c.angle))
    }

    fn generated(generator: &PlaneGenerator) -> Result<TriMesh, MeshError> {
        match *generator {
            PlaneGenerator::Block { origin, size, cells } => generate::block(origin, size, cells),
            PlaneGenerator::Ring { centre, radii, angles, cells } => {
                generate::ring(centre, radii, angles, cells)
            }
            PlaneGenerator::Disc { centre, radius, cells, start } => {
                generate::disc(centre, radius, cells, start)
            }
            PlaneGenerator::HalfDisc { pole, radius, facing, half_width, cells } => {
                generate::half_disc(pole, radius, facing, half_width, cells)
            }
        }
    }

    fn nodes(generator: &PlaneGenerator) -> u64 {
        match *generator {
            PlaneGenerator::Block { cells, .. } => {
                cells.iter().fold(1u64, |product, &n| product.saturating_mul(n as u64 + 1))
            }
            PlaneGenerator::Ring { angles, cells: [around, across], .. } => {
                let closed = u64::from(angles[1] - angles[0] == 360.0);
                (around as u64 + 1 - closed).saturating_mul(across as u64 + 1)
            }
            PlaneGenerator::Disc { cells, .. } => generate::disc_nodes(cells),
            PlaneGenerator::HalfDisc { radius, half_width, cells, .. } => {
                generate::half_disc_nodes(radius, half_width, cells)
            }
        }
    }

    fn region(mesh: &MeshFile, names: &[&str], options: RegionOptions) -> Result<Region, MeshFileError> {
        mesh.regions(names, options)
    }

    fn without_sides(region: &Region) -> Option<MeshFileError> {
        region.without_sides()
    }

    fn evaluate_given(case: &mut Case) -> Result<(), CaseError> {
        case.evaluate_plane_given()
    }

    fn curved(body: Body, sides: &[CurveCase]) -> Result<Body, BodyError> {
        let of = |given: &CurveCase| CurvedSide { on: given.on.clone(), kind: given.kind };
        body.with_curves(&sides.iter().map(of).collect::<Vec<_>>())
    }

    fn pair(bodies: Vec<Body>, contacts: &[Contact]) -> Result<Paired, PairingError> {
        contact_geometry::paired(bodies, contacts)
    }

    fn fits(bodies: [&Body; 2], sides: [&str; 2], gap: &Gap, normal: ContactNormal) -> bool {
        match contact_geometry::pair_along(bodies[0], bodies[1], sides, gap, normal) {
            Ok(_) => true,
            Err(error) if error.is_mismatch() => {
                let common = common_refinement(bodies.map(Body::clone), sides, normal);
                common.is_ok_and(|common| contact_geometry::pair_refined(&common, sides, gap, normal).is_ok())
            }
            Err(_) => false,
        }
    }

    fn notes(case: &Case, paired: &Paired) -> Vec<String> {
        case.plane_notes(&paired.problem, &paired.refined)
    }

    fn stress_notes(case: &Case) -> Vec<String> {
        let mut notes = Vec::new();
        for material in (0..case.bodies.len()).flat_map(|body| case.materials_of(body)) {
            let unknown = matches!(material.law, MaterialLaw::Stiffness(_))
                && case.model.hypothesis == Hypothesis::PlaneStrain;
            let note = format!(
                "material \"{}\": a plane stiffness in plane strain does not say the stress out of the plane: there is no \
                 von Mises stress, and ParaView files have 0 for it",
                material.name
            );
            if unknown && !notes.contains(&note) {
                notes.push(note);
            }
        }
        notes
    }

    fn interpolated_gaps(problem: &ContactProblem) -> Vec<Option<Difference>> {
        problem.interpolated_gaps()
    }

    fn cells_written(count: usize) -> report::CellCount {
        report::CellCount::Triangles(count)
    }

    fn spin_written(spin: f64) -> report::Spin {
        report::Spin::Plane(spin)
    }

    fn thickness(model: &Model) -> Option<f64> {
        Some(model.thickness)
    }

    fn extent_unit(units: &Units) -> String {
        units.length.clone()
    }

    fn force_unit(units: &Units) -> String {
        units.line_force()
    }

    fn moment_unit(units: &Units) -> String {
        units.force.clone()
    }
}

const HYPOTHESES: &[(&str, Hypothesis)] =
    &[("plane_strain", Hypothesis::PlaneStrain), ("plane_stress", Hypothesis::PlaneStress)];

impl Keys for Plane {
    const GENERATORS: &'static [(&'static str, GeneratorReader<Self>)] =
        &[("block", block), ("ring", ring), ("disc", disc), ("half_disc", half_disc)];
    const MESH: [&'static str; 2] = [
        "`generator = { kind = \"block\", … }` or `mesh = { file = \"name.msh\", region = \"name\" }`",
        "write `generator = { kind = \"block\", size = [2.0, 1.0], cells = [18, 9] }` to begin with",
    ];
    const CONSTANTS: &'static [&'static str] =
        &["young_1", "young_2", "young_3", "poisson_12", "poisson_13", "poisson_23", "shear", "angle"];
    const MATERIALS: &'static str = "either `young` and `poisson`, or `young_1`, `young_2`, `poisson_12`, `shear` and `angle`, or `stiffness`";
    const STIFFNESS: MatrixWords = MatrixWords {
        size: 3,
        expected: "three rows of three numbers, `[[a, b, c], [b, d, e], [c, e, f]]`",
        rows: of_rows,
        entries: of_entries,
    };
    const DIRECTION: &'static str = "normal";
    const REFUSED: &'static [Refused] = &[
        Refused {
            key: "body.surface",
            word: None,
            why: "the sides of plane bodies are lines",
            expected: "[[body.curve]], which declares a curved line",
            fix: "write [[body.curve]] with `kind = \"arc\"` or `kind = \"smooth\"`",
        },
        solid_obstacle("sphere", "spheres touch solid bodies, and this case is plane"),
        solid_obstacle("cylinder", "cylinders touch solid bodies, and this case is plane"),
    ];

    fn model(reader: Option<&mut Reader<'_>>) -> Model {
        let mut model = Model { hypothesis: Hypothesis::PlaneStrain, thickness: 1.0 };
        let Some(r) = reader else { return model };
        model.hypothesis = r.choice_or("hypothesis", HYPOTHESES, not_plane).unwrap_or(model.hypothesis);
        let thickness = r.number_where("thickness", |thickness| thickness > 0.0, "a number > 0");
        model.thickness = thickness.unwrap_or(model.thickness);
        model
    }

    fn constants(r: &mut Reader<'_>, model: &Model) -> Option<Orthotropic> {
        constants(r, model)
    }

    fn spin(r: &mut Reader<'_>, key: &'static str) -> Option<f64> {
        r.number(key)
    }
}

/// Refuses an obstacle of solids.
const fn solid_obstacle(word: &'static str, why: &'static str) -> Refused {
    let (expected, fix) = ("\"plane\" or \"circle\"", "write `kind = \"circle\"`, or make all bodies solid");
    Refused { key: "obstacle.kind", word: Some(word), why, expected, fix }
}

/// Tells what to do about a hypothesis that is not plane.
fn not_plane(word: &str) -> &'static str {
    let word = word.to_lowercase();
    let of_space = ["axi", "axy", "rotation", "revolution", "3d", "3-d", "three", "solid", "shell"];
    if of_space.iter().any(|part| word.contains(part)) {
        "only plane problems are solved, in plane strain or plane stress"
    } else {
        "write \"plane_strain\" for a long body, \"plane_stress\" for a thin sheet"
    }
}

pub(super) const FACINGS: &[(&str, Facing)] = &[("down", Facing::Down), ("up", Facing::Up)];

/// Writes the word of a direction.
pub(super) fn facing_name<S: serde::Serializer>(facing: &Facing, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(FACINGS.iter().find(|(_, f)| f == facing).map_or("", |(name, _)| name))
}

fn ring(mut r: Reader<'_>) -> Option<PlaneGenerator> {
    r.require(&["radii", "cells"]);
    let centre = r.pair("centre").unwrap_or_default();
    let radii = r.pair("radii");
    let angles = r.pair("angles").unwrap_or([0.0, 360.0]);
    let cells = r.counts::<Plane>("cells");
    r.finish();
    Some(PlaneGenerator::Ring { centre, radii: radii?, angles, cells: cells? })
}

fn disc(mut r: Reader<'_>) -> Option<PlaneGenerator> {
    r.require(&["radius", "cells"]);
    let centre = r.pair("centre").unwrap_or_default();
    let radius = r.number_where("radius", |radius| radius > 0.0, "a number > 0");
    let cells = r.count("cells", 1);
    let start = r.number("start").unwrap_or(0.0);
    r.finish();
    Some(PlaneGenerator::Disc { centre, radius: radius?, cells: cells?, start })
}

/// Half the width of the contact side of a half disc over its radius, at most.
const WIDEST: f64 = 0.3;

fn half_disc(mut r: Reader<'_>) -> Option<PlaneGenerator> {
    r.require(&["radius", "facing", "half_width", "cells"]);
    let pole = r.pair("pole").unwrap_or_default();
    let radius = r.number_where("radius", |radius| radius > 0.0, "a number > 0");
    let largest = WIDEST * radius.filter(|radius| *radius > 0.0).unwrap_or(f64::INFINITY);
    let half_width = r.number_where(
        "half_width",
        |width| width > 0.0 && width <= largest,
        "a number > 0, at most 0.3 times `radius`",
    );
    let facing = r.choice("facing", FACINGS);
    let cells = r.count("cells", 1);
    r.finish();
    Some(PlaneGenerator::HalfDisc {
        pole,
        radius: radius?,
        facing: facing?,
        half_width: half_width?,
        cells: cells?,
    })
}

fn block(mut r: Reader<'_>) -> Option<PlaneGenerator> {
    r.require(&["kind", "size", "cells"]);
    let origin = r.pair("origin").unwrap_or_default();
    let size = r.pair("size");
    if size.is_some_and(|s| s.iter().any(|&v| v <= 0.0)) {
        r.refuse(
            "size",
            "a block needs a width and a height",
            "two numbers > 0",
            "write it as in `size = [2.0, 1.0]`",
        );
    }
    let cells = r.counts::<Plane>("cells");
    r.finish();
    Some(PlaneGenerator::Block { origin, size: size?, cells: cells? })
}

/// Reads orthotropic constants; of a Poisson's ratio that is too large it says the largest.
fn constants(r: &mut Reader<'_>, model: &Model) -> Option<Orthotropic> {
    let hypothesis = model.hypothesis;
    r.require(&["young_1", "young_2", "poisson_12", "shear"]);
    let (young_1, young_2) = (r.number("young_1"), r.number("young_2"));
    let (poisson_12, shear) = (r.number("poisson_12"), r.number("shear"));
    let angle = r.number("angle").unwrap_or(0.0);
    let third = [r.number("young_3"), r.number("poisson_13"), r.number("poisson_23")];
    let (young, poisson_12, shear) = ([young_1?, young_2?], poisson_12?, shear?);
    let with = |poisson_12: f64| {
        let mut constants = Orthotropic::in_plane(young, poisson_12, shear, angle);
        constants.young_3 = third[0].unwrap_or(constants.young_3);
        constants.poisson_13 = third[1].unwrap_or(constants.poisson_13);
        constants.poisson_23 = third[2].unwrap_or(constants.poisson_23);
        constants
    };
    let made = |poisson_12: f64| LinearElastic::orthotropic(&with(poisson_12), hypothesis);
    let made_of_it = made(poisson_12);
    let of_poisson_12 = match &made_of_it {
        Err(MaterialError::PoissonPair { name, .. }) => *name == "poisson_12" || !r.has(name),
        Err(MaterialError::PoissonTriple { .. }) => true,
        _ => false,
    };
    match largest_ratio(poisson_12, |ratio| made(ratio).is_ok()).filter(|_| of_poisson_12) {
        Some(largest) => {
            let follow = match third {
                _ if hypothesis == Hypothesis::PlaneStress => "",
                [_, None, None] => " (and so are `poisson_13` and `poisson_23`, which are not given)",
                [_, None, _] => " (and so is `poisson_13`, which is not given)",
                [_, _, None] => " (and so is `poisson_23`, which is not given)",
                _ => "",
            };
            r.refuse(
                "poisson_12",
                format!(
                    "`{}` is {}{follow}: the strain energy would not be positive",
                    r.path_of("poisson_12"),
                    shown(poisson_12)
                ),
                &format!("at most {largest} in magnitude, with the other constants"),
                "lower it: poisson_12 is the strain along 2 for a stress along 1, and belongs to young_1",
            );
        }
        None => made_of_it.err().iter().for_each(|error| refuse_material(r, error)),
    }
    Some(with(poisson_12))
}

/// Finds the largest ratio, by its magnitude and in three digits, with which a material can be made; `None` if there is
/// none, whatever the ratio. Those possible lie between two limits, as the compliance is linear in the ratio.
fn largest_ratio(found: f64, is_possible: impl Fn(f64) -> bool) -> Option<String> {
    let (mut possible, mut impossible) = (0.0, found);
    if !is_possible(possible) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (possible + impossible);
        *(if is_possible(middle) { &mut possible } else { &mut impossible }) = middle;
    }
    // So much less that rounding to three digits stays below.
    Some(significant(0.995 * possible.abs()))
}

/// Returns the fix for a stiffness with this many rows.
fn of_rows(count: usize) -> &'static str {
    match count {
        2 => "give three rows; the last holds the shear modulus: `[0, 0, G]` if shear does not couple",
        6 => "give three rows, for xx, yy and xy of the plane problem",
        9 => "put the numbers of each row into brackets",
        _ => "give three rows, for xx, yy and xy",
    }
}

/// Returns the fix for a row of a stiffness with this many entries.
fn of_entries(count: usize) -> &'static str {
    match count {
        2 => "give three numbers in each row; the last couples with shear, 0 if it does not",
        6 => "give the three of xx, yy and xy; decimals have a point, not a comma",
        _ => "give three numbers in each row, for xx, yy and xy",
    }
}
