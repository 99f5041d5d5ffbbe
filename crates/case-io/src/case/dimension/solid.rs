//! Cases of solids.

mod generator;

use super::{Dimension, GeneratorReader, Keys, Refused, Rows};
use crate::case::fixes::refuse_material;
use crate::case::pair_notes::PairNote;
use crate::case::{Case, CurveCase, RelaxUntil, Units};
use crate::case_file::{MatrixWords, Reader};
use crate::diagnostic::{CaseError, significant};
use crate::expression::COORDINATES;
use crate::report;
use contact_geometry::{Contact, ContactNormal, OverlayChanges, Paired, PairingError};
use fem_core::body::{Body, BodyError, DeclaredSurface, Difference, SurfaceKind};
use fem_core::geometry::shown;
use fem_core::interface::{ContactProblem, Gap};
use fem_core::material::{LinearElastic, MaterialError, Orthotropic};
use fem_core::mesh::id::FacetId;
use fem_core::mesh::{MeshError, TetMesh, generate};
use fem_core::space::{Solid, Space};
use generator::{ball, cuboid, cylinder, tube};
use mesh_io::words::counted;
use mesh_io::{MeshFile, MeshFileError, Region, RegionOptions};
use serde_json::{Value as Json, json};

pub use generator::SolidGenerator;

type Vector = <Solid as Space>::Vector;

/// The nine constants of an orthotropic solid, and its axes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SolidOrthotropic {
    /// Those of the plane of axes 1 and 2, and along axis 3; the angle is zero.
    pub plane: Orthotropic,
    /// G₁₃ and G₂₃, Pa.
    pub shear: [f64; 2],
    /// Vectors along axis 1 and, to the part perpendicular to it, axis 2.
    pub axes: [[f64; 3]; 2],
}

impl Dimension for Solid {
    type Model = ();
    type Generator = SolidGenerator;
    type Orthotropic = SolidOrthotropic;
    type Curve = SurfaceKind;

    const CURVE_TABLE: &'static str = "surface";
    const CURVES: &'static [(&'static str, SurfaceKind)] = &[
        (SurfaceKind::Plane.word(), SurfaceKind::Plane),
        (SurfaceKind::Cylinder.word(), SurfaceKind::Cylinder),
        (SurfaceKind::Sphere.word(), SurfaceKind::Sphere),
    ];
    const RELAX_UNTIL: RelaxUntil = RelaxUntil { tolerance: 0.015, max_steps: 30 };
    const COORDINATES: &'static [&'static str] = &COORDINATES;
    const CORNER: &'static str = "a corner";
    const EXTENT: &'static str = "area";
    const ALONG: &'static str = "on the faces";
    const CIRCLE: &'static str = "sphere";
    const CYLINDERS: bool = true;

    fn model_json((): &()) -> Json {
        json!({ "hypothesis": HYPOTHESIS })
    }

    fn isotropic(young: f64, poisson: f64, (): &()) -> Result<LinearElastic<Self>, MaterialError> {
        LinearElastic::isotropic_solid(young, poisson)
    }

    fn orthotropic(c: &SolidOrthotropic, (): &()) -> Result<LinearElastic<Self>, MaterialError> {
        LinearElastic::orthotropic_solid(&c.plane, c.shear, c.axes.map(Vector::from))
    }

    fn of_stiffness(rows: &Rows<Self>, (): &()) -> Result<LinearElastic<Self>, MaterialError> {
        LinearElastic::from_solid_stiffness(*rows)
    }

    fn orthotropic_json(c: &SolidOrthotropic) -> Json {
        json!({
            "young_1": c.plane.young_1,
            "young_2": c.plane.young_2,
            "young_3": c.plane.young_3,
            "poisson_12": c.plane.poisson_12,
            "poisson_13": c.plane.poisson_13,
            "poisson_23": c.plane.poisson_23,
            "shear_12": c.plane.shear,
            "shear_13": c.shear[0],
            "shear_23": c.shear[1],
            "axes": c.axes,
        })
    }

    fn moduli(c: &SolidOrthotropic) -> [f64; 3] {
        [c.plane.young_1, c.plane.young_2, c.plane.young_3]
    }

    fn material_words(constants: Option<&SolidOrthotropic>) -> String {
        let Some(c) = constants else { return "stiffness".to_owned() };
        let [a, b, c] = Self::moduli(c).map(shown);
        format!("E1 {a}  E2 {b}  E3 {c}")
    }

    fn generated(generator: &SolidGenerator) -> Result<TetMesh, MeshError> {
        match *generator {
            SolidGenerator::Box { origin, size, cells } => generate::cuboid(origin, size, cells),
            SolidGenerator::Cylinder { origin, radius, length, angles, cells } => {
                generate::tube(origin, [0.0, radius], length, angles, cells)
            }
            SolidGenerator::Tube { origin, radii, length, angles, cells } => {
                generate::tube(origin, radii, length, angles, cells)
            }
            SolidGenerator::Ball { centre, radius, part, facing, growth, cells } => {
                generate::ball(centre, radius, (part, facing), growth, cells)
            }
        }
    }

    fn nodes(generator: &SolidGenerator) -> u64 {
        match generator {
            SolidGenerator::Box { cells, .. }
            | SolidGenerator::Cylinder { cells, .. }
            | SolidGenerator::Tube { cells, .. } => {
                cells.iter().fold(1u64, |product, &n| product.saturating_mul(n as u64 + 1))
            }
            SolidGenerator::Ball { part, cells, .. } => generate::ball_nodes(*part, *cells),
        }
    }

    fn region(
        mesh: &MeshFile,
        names: &[&str],
        options: RegionOptions,
    ) -> Result<Region<Self>, MeshFileError> {
        mesh.solid_regions(names, options)
    }

    fn without_sides(region: &Region<Self>) -> Option<MeshFileError> {
        region.without_sides()
    }

    fn evaluate_given(case: &mut Case<Self>) -> Result<(), CaseError> {
        case.refuse_given()
    }

    fn curved(body: Body<Self>, sides: &[CurveCase<Self>]) -> Result<Body<Self>, BodyError> {
        let of = |given: &CurveCase<Self>| DeclaredSurface { on: given.on.clone(), kind: given.kind };
        body.with_surfaces(&sides.iter().map(of).collect::<Vec<_>>())
    }

    fn pair(bodies: Vec<Body<Self>>, contacts: &[Contact<Self>]) -> Result<Paired<Self>, PairingError> {
        contact_geometry::paired_solids(bodies, contacts)
    }

    fn fits(bodies: [&Body<Self>; 2], sides: [&str; 2], gap: &Gap<Self>, _: ContactNormal<Self>) -> bool {
        contact_geometry::pair_solids(bodies[0], bodies[1], sides, gap).is_ok()
    }

    fn notes(case: &Case<Self>, paired: &Paired<Self>) -> Vec<String> {
        let problem = &paired.problem;
        let mut notes = case.cut_notes(&problem.bodies);
        let overlaid = paired.overlaid.iter().enumerate();
        let overlaid = overlaid.filter_map(|(k, changes)| Some(case.overlay_note(k, changes.as_ref()?)));
        notes.extend(case.joined(overlaid.collect()));
        for (k, pair) in problem.contacts.iter().enumerate() {
            notes.extend(pair.elastic_sides().filter_map(|(side, body)| {
                surface_note(case, problem, (k, side, body)).map(|said| format!("contact {}: {said}", k + 1))
            }));
        }
        notes
    }

    fn stress_notes(_: &Case<Self>) -> Vec<String> {
        Vec::new()
    }

    fn interpolated_gaps(problem: &ContactProblem<Self>) -> Vec<Option<Difference>> {
        problem.interpolated_solid_gaps()
    }

    fn cells_written(count: usize) -> report::CellCount {
        report::CellCount::Tetrahedra(count)
    }

    fn spin_written(spin: Vector) -> report::Spin {
        report::Spin::Solid(spin.into())
    }

    fn thickness((): &()) -> Option<f64> {
        None
    }

    fn extent_unit(units: &Units) -> String {
        units.area()
    }

    fn force_unit(units: &Units) -> String {
        units.force.clone()
    }

    fn moment_unit(units: &Units) -> String {
        units.moment()
    }
}

impl Case<Solid> {
    /// Says what an overlay changed.
    fn overlay_note(&self, contact: usize, changes: &OverlayChanges) -> PairNote {
        let of = |b: usize, name: &str| {
            let mut parts = Vec::new();
            if changes.added[b] > 0 {
                parts.push(format!("{} inserted", counted(changes.added[b], "node")));
            }
            if changes.snapped[b] > 0 {
                let farthest = significant(changes.largest_move);
                parts.push(format!(
                    "{} snapped (moved along the surface by at most {farthest})",
                    changes.snapped[b]
                ));
            }
            if changes.free[b] > 0.0 {
                parts.push(format!("an area of {} faces nothing and is free", significant(changes.free[b])));
            }
            (!parts.is_empty()).then(|| format!("{name} {}", parts.join(", ")))
        };
        let note = |names: [&str; 2]| {
            let parts: Vec<String> = (0..2).filter_map(|b| of(b, names[b])).collect();
            let thin = match changes.lowest < FLAT_TRIANGLE {
                true => {
                    "; such flat triangles make the bound worse, not false: draw bodies that touch as one mesh (in Gmsh by BooleanFragments) \
                         with `duplicate_interface = true`"
                }
                false => "",
            };
            let lowest = significant(changes.lowest);
            match [changes.added, changes.snapped] {
                [[0, 0], [0, 0]] => format!("the contact surfaces do not end together: {}", parts.join("; ")),
                _ => format!(
                    "the contact surfaces do not match and were laid over each other: {}; the flattest triangle of the overlay has {lowest} of the \
                     height of the faces there{thin}",
                    parts.join("; ")
                ),
            }
        };
        let shared = note(["first body", "second body"]);
        let names: Vec<String> =
            self.contacts[contact].bodies.iter().map(|b| format!("\"{}\"", self.bodies[*b].name)).collect();
        let alone = match &names[..] {
            [first, second] => note([first, second]),
            _ => shared.clone(),
        };
        PairNote { contact, alone, shared }
    }
}

/// An overlay with a triangle below this part of the height of the faces there gets a remark.
const FLAT_TRIANGLE: f64 = 0.02;

/// Says what the surface of a pair is on the mesh: round and not declared, or declared and with faces off it.
///
/// * `place`: the number of the pair, the side and its body.
fn surface_note(
    case: &Case<Solid>,
    problem: &ContactProblem<Solid>,
    (pair, side, b): (usize, usize, usize),
) -> Option<String> {
    let (interface, body) = (&problem.contacts[pair].interface, &problem.bodies[b]);
    let faces: Vec<_> = interface.facets().iter().map(|facet| facet.facets[side]).collect();
    let name = &case.bodies[b].name;
    let declared = body.surface(*faces.first()?);
    if let Some(line) = declared {
        let off = |face: &FacetId| line.distance(body.mesh().facet_middle(*face)).0.abs();
        let most = faces.iter().map(off).fold(0.0, f64::max);
        let kind = SurfaceKind::of(line);
        let gapped = matches!(interface.gap(), Gap::Geometric) && kind != SurfaceKind::Plane;
        return gapped.then(|| {
            format!(
                "the faces of \"{name}\" are up to {} off the declared {}: gaps are exact at the nodes, and linear between them",
                significant(most),
                kind.word()
            )
        });
    }
    // Only normals of faces are in doubt.
    let is_bent = interface.has_bent_facets() && problem.obstacle_of(&problem.contacts[pair]).is_none();
    let corners = if is_bent && side == 0 { body.outward_faces(&faces) } else { return None };
    let round = [SurfaceKind::Cylinder, SurfaceKind::Sphere];
    let kind = round.into_iter().find(|kind| kind.through(&corners).is_some())?.word();
    Some(format!(
        "the nodes of \"{name}\" lie on a {kind} that is not declared: the normals are means of the faces' normals, whose error may hold a rotation \
         that nothing resists; write [[body.surface]] with `kind = \"{kind}\"`"
    ))
}

/// The word for solids.
const HYPOTHESIS: &str = "solid";

/// Refuses a key that a case of the plane has, and solids do not have yet.
const fn later(key: &'static str, why: &'static str, fix: &'static str) -> Refused {
    Refused { key, word: None, why, expected: "a case of solids without it", fix }
}

/// Refuses a generator of the plane.
const fn plane_word(word: &'static str) -> Refused {
    Refused {
        key: "generator.kind",
        word: Some(word),
        why: "it makes a plane body, and this case is one of solids: a case has bodies of one kind",
        expected: "\"box\", \"cylinder\", \"tube\" or \"ball\"",
        fix: "write `kind = \"box\"`, or make all bodies plane",
    }
}

const TAKE_OUT: &str = "take it out";

impl Keys for Solid {
    const GENERATORS: &'static [(&'static str, GeneratorReader<Self>)] =
        &[("box", cuboid), ("cylinder", cylinder), ("tube", tube), ("ball", ball)];
    const MESH: [&'static str; 2] = [
        "`generator = { kind = \"box\", … }` or `mesh = { file = \"name.msh\", region = \"name\" }`",
        "write `generator = { kind = \"box\", size = [2.0, 1.0, 1.0], cells = [8, 4, 4] }` to begin with",
    ];
    const CONSTANTS: &'static [&'static str] = &[
        "young_1",
        "young_2",
        "young_3",
        "poisson_12",
        "poisson_13",
        "poisson_23",
        "shear_12",
        "shear_13",
        "shear_23",
        "axes",
    ];
    const MATERIALS: &'static str = "either `young` and `poisson`, or `young_1..3`, `poisson_12`, `poisson_13`, `poisson_23`, `shear_12`, `shear_13`, `shear_23` \
         and `axes`, or `stiffness`";
    const STIFFNESS: MatrixWords = MatrixWords {
        size: 6,
        expected: "six rows of six numbers, for xx, yy, zz, yz, xz and xy",
        rows: |count| match count {
            36 => "put the numbers of each row into brackets",
            3 => "give six rows; a plane stiffness does not say what happens along z",
            _ => "give six rows, for xx, yy, zz, yz, xz and xy",
        },
        entries: |_| "give six numbers in each row, for xx, yy, zz, yz, xz and xy",
    };
    const DIRECTION: &'static str = "direction";
    const REFUSED: &'static [Refused] = &[
        Refused {
            key: "body.curve",
            word: None,
            why: "the sides of solids are surfaces",
            expected: "[[body.surface]], which declares a curved surface",
            fix: "write [[body.surface]] with `kind = \"plane\"`, `\"cylinder\"` or `\"sphere\"`",
        },
        later(
            "side.circle",
            "a circle belongs to the plane",
            "write `sphere = { centre = […], radius = … }`",
        ),
        plane_word("block"),
        plane_word("ring"),
        plane_word("disc"),
        plane_word("half_disc"),
        Refused {
            key: "obstacle.kind",
            word: Some("circle"),
            why: "circles touch plane bodies, and this case is one of solids",
            expected: "\"plane\", \"sphere\" or \"cylinder\"",
            fix: "write `kind = \"sphere\"`",
        },
        later("contact.normal", "surfaces of solids have their own normals", TAKE_OUT),
    ];

    fn model(reader: Option<&mut Reader<'_>>) {
        let Some(r) = reader else { return };
        for key in ["hypothesis", "thickness"] {
            let Some(node) = r.node(key) else { continue };
            if node.word() != Some(HYPOTHESIS) || key == "thickness" {
                let message =
                    format!("`{}` belongs to the plane, and this case has solid bodies", r.path_of(key));
                r.refuse(
                    key,
                    message,
                    "`hypothesis = \"solid\"` alone",
                    "take it out: bodies of volumes make a case of solids",
                );
            }
        }
    }

    fn constants(r: &mut Reader<'_>, (): &()) -> Option<SolidOrthotropic> {
        r.require(Self::CONSTANTS);
        let [young_1, young_2, young_3] = ["young_1", "young_2", "young_3"].map(|key| r.number(key));
        let [poisson_12, poisson_13, poisson_23] =
            ["poisson_12", "poisson_13", "poisson_23"].map(|key| r.number(key));
        let [shear_12, shear_13, shear_23] = ["shear_12", "shear_13", "shear_23"].map(|key| r.number(key));
        let axes = r.two_vectors::<Self>("axes");
        let constants = SolidOrthotropic {
            plane: Orthotropic {
                young_1: young_1?,
                young_2: young_2?,
                young_3: young_3?,
                poisson_12: poisson_12?,
                poisson_13: poisson_13?,
                poisson_23: poisson_23?,
                shear: shear_12?,
                angle: 0.0,
            },
            shear: [shear_13?, shear_23?],
            axes: axes?,
        };
        Self::orthotropic(&constants, &()).err().iter().for_each(|error| refuse_material(r, error));
        Some(constants)
    }

    fn spin(r: &mut Reader<'_>, key: &'static str) -> Option<Vector> {
        r.axes::<Self>(key).map(Vector::from)
    }
}
