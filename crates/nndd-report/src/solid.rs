//! Reports of solids.

use crate::figures::NamedRows;
use crate::figures::{self, Picture};
use crate::memory::{BODY, INTERFACE};
use crate::notes::LOCKING_RATIO;
use crate::solved::Fields;
use crate::space::{DrawnFacets, Pieces, ReportSpace};
use case_io::Case;
use case_io::case::MaterialLaw;
use case_io::report::{
    ContactLine, ContactSurface, FrictionLine, FrictionSurface, LineResults, Report, Spin, SurfaceArea,
    SurfacePatch,
};
use case_io::table::{ContactRow, FrictionRow};
use certified_contact::{FrictionResults, PairResults, PatchResults, Results};
use cre_estimator::FieldCertificate;
use fem_core::body::Body;
use fem_core::geometry::{Coordinates, Point};
use fem_core::interface::{
    ContactFacet, ContactInterface, ContactPair, ContactPatch, ContactProblem, RigidLine,
};
use fem_core::material::LinearElastic;
use fem_core::mesh::id::{FacetId, NodeId};
use fem_core::space::{Solid, Space};
use fem_core::tensor::SymTensor3;
use mesh_io::vtu::VtuCells;
use mesh_io::words::{counted, listed};
use serde_json::Value;

type Vector = <Solid as Space>::Vector;

/// Bytes of the factor per n^(4/3); of mesh and fields per unknown; of the coefficients of the estimator per unknown. Fitted to eleven solves of two pressed
/// blocks with 90 to 141,570 nodes: within 10 % from 8,450 nodes on, and 30 % too little at 2,754.
const FACTOR: f64 = 190.0;
const FIELDS: f64 = 1300.0;
const COEFFICIENTS: f64 = 7000.0;

/// Of subdomains: bytes of a factor without the part of its shared unknowns, per n^(4/3); of the coarse space per subdomain; of mesh and fields per unknown.
/// Fitted to solves of these blocks with 61,250 to 465,794 nodes.
const SUBDOMAIN_FACTOR: f64 = 78.0;
const COARSE: f64 = 400e3;
const SUBDOMAIN_FIELDS: f64 = 3050.0;

impl ReportSpace for Solid {
    const INTERFACE: &'static str = "contact surface";
    const PRESSURE_INTEGRAL: &'static str = "∫ p dA";
    const MEMORY_POWER: f64 = 4.0 / 3.0;
    const FEWER_NODES: &'static str = "take fewer cells, or refine only where it is needed with [adapt]";
    const FEWER_PAIRS: &'static str = "take fewer faces on the contact surface";
    const FINER_MESH: &'static str = "use a finer mesh ([adapt] target_relative_error)";

    fn notes_on_refinement(
        case: &Case<Self>,
        _: &[Vec<[NodeId; 2]>],
        problem: &ContactProblem<Self>,
    ) -> Vec<String> {
        let bodies = case.bodies.iter().zip(&problem.bodies);
        let round =
            |body: &Body<Self>| body.surfaces().values().any(|line| !matches!(line, RigidLine::Plane { .. }));
        let curved: Vec<&str> =
            bodies.filter(|(_, body)| round(body)).map(|(given, _)| given.name.as_str()).collect();
        let mut notes = Vec::new();
        if !curved.is_empty() {
            notes.push(format!(
                "curved sides ({}): the bound is for the flat faces of the last mesh; the difference to the declared surfaces is outside it",
                listed(&curved)
            ));
        }
        for (given, body) in case.bodies.iter().zip(&problem.bodies) {
            let off = off_surfaces(body);
            let Some(first) = off.first() else { continue };
            notes.push(format!(
                "body \"{}\": {} of a declared surface stayed off it, such as at {}, since a cell would have turned over or lost most of its \
                 volume; use smaller cells at this side",
                given.name,
                counted(off.len(), "new node"),
                Point::from(body.mesh().points()[*first])
            ));
        }
        notes
    }

    /// With n unknowns the factor of a nested dissection grows as n^(4/3). That of a subdomain has half a square of its shared unknowns.
    fn memory((nodes, pairs): (u64, usize), subdomains: &[Pieces], recomputes: bool) -> f64 {
        let (n, pairs) = (3.0 * nodes.max(1) as f64, pairs as f64);
        let coefficients = if recomputes { 0.0 } else { COEFFICIENTS * n };
        let other = if subdomains.is_empty() {
            FACTOR * n * n.cbrt() + FIELDS * n + INTERFACE * pairs * pairs
        } else {
            let of = |of: &Pieces| {
                let (n, shared) = (3.0 * of.nodes, 3.0 * of.shared);
                let factor =
                    SUBDOMAIN_FACTOR * n * n.cbrt() + 0.5 * size_of::<f64>() as f64 * shared * shared;
                of.count * (factor + COARSE)
            };
            SUBDOMAIN_FIELDS * n + subdomains.iter().map(of).sum::<f64>()
        };
        other + coefficients + BODY
    }

    fn locks(case: &Case<Self>) -> bool {
        let poisson = |law: &MaterialLaw<Self>| match law {
            MaterialLaw::Isotropic { poisson, .. } => *poisson,
            _ => 0.0,
        };
        case.materials.iter().any(|material| poisson(&material.law) >= LOCKING_RATIO)
    }

    fn notes_on_results(_: &Case<Self>, _: &Fields<'_, Self>) -> Vec<String> {
        Vec::new()
    }

    fn notes_on_shapes(_: &Case<Self>, _: &Fields<'_, Self>) -> Vec<String> {
        Vec::new()
    }

    fn contact_line(_: &ContactPair<Self>, _: Option<&PairResults<Self>>) -> Option<ContactLine> {
        None
    }

    fn contact_surface(
        pair: &ContactPair<Self>,
        found: Option<&PairResults<Self>>,
    ) -> Option<ContactSurface> {
        let patches = |found: &PairResults<Self>| {
            let patches = found.area.patches.iter().zip(&found.patches);
            let summary = |(patch, forces): (&ContactPatch, &PatchResults<Self>)| SurfacePatch {
                area: patch.area,
                centre: forces.centre.entries().to_vec(),
                force: forces.resultant.entries().to_vec(),
            };
            patches.map(summary).collect()
        };
        Some(ContactSurface {
            area: SurfaceArea {
                certain: found.map(|found| found.area.inner),
                possible: found.map(|found| found.area.outer),
                total: pair.interface.measure(),
            },
            patches: found.map(patches),
        })
    }

    fn line_results(_: Option<&Results<Self>>) -> Option<LineResults> {
        None
    }

    fn arc_length(_: &ContactInterface<Self>, _: usize) -> Option<f64> {
        None
    }

    fn six_stresses(_: &LinearElastic<Self>, stress: SymTensor3, _: f64) -> [f64; 6] {
        six(stress)
    }

    fn six_strains(
        _: &Case<Self>,
        _: usize,
        material: &LinearElastic<Self>,
        (stress, temperature): (SymTensor3, f64),
    ) -> [f64; 6] {
        six(material.strain(stress).plus(material.thermal_strain().scaled(temperature)))
    }

    fn friction_traction(_: Vector, row: &FrictionRow) -> Vector {
        row.in_space.map_or(Vector::zeros(), |[traction, _]| Vector::from(traction) * -1.0)
    }

    fn friction_in_space(vectors: [Vector; 2]) -> Option<[[f64; 3]; 2]> {
        Some(vectors.map(<[f64; 3]>::from))
    }

    fn friction_written(found: &FrictionResults<Self>) -> Spin {
        Spin::Solid(found.resultant.into())
    }

    fn friction_line(_: &FrictionResults<Self>) -> Option<FrictionLine> {
        None
    }

    fn friction_surface(found: &FrictionResults<Self>) -> Option<FrictionSurface> {
        let [stick_area, slip_area] = found.measures;
        Some(FrictionSurface { stick_area, slip_area })
    }

    fn drawn_facets(fields: &Fields<'_, Self>, pair: usize) -> DrawnFacets<Self> {
        let of = &fields.problem.contacts[pair];
        let nodes = fields.problem.bodies[of.body].mesh().points();
        let interface = &of.interface;
        let removed = interface.clamped().iter().map(|clamped| &clamped.pair);
        let points = interface.pairs().iter().chain(removed).map(|pair| nodes[pair.nodes[0]]).collect();
        let mut clamped = vec![(0, 0.0); interface.clamped().len()];
        let corners = |face: &ContactFacet<Self>| {
            [0, 1, 2].map(|corner: usize| match face.clamped[corner] {
                None => face.pairs[corner],
                Some(of) => {
                    let pair = interface.sources(face, corner).first().map_or(0, |k| *k as usize);
                    clamped[of.number as usize] = (pair, of.opening);
                    (interface.pairs().len() + of.number as usize) as u32
                }
            })
        };
        let cells = VtuCells::Triangles(interface.facets().iter().map(corners).collect());
        let measures = interface.facets().iter().map(|face| face.measure).collect();
        DrawnFacets { points, cells, measures, clamped }
    }

    fn error_map(
        _: &Case<Self>,
        _: &ContactProblem<Self>,
        _: &FieldCertificate<Self>,
        _: &[Vec<f64>],
    ) -> Option<Picture> {
        None
    }

    fn pictures(
        case: &Case<Self>,
        fields: &Fields<'_, Self>,
        contact: (&NamedRows<'_>, &[Value]),
        report: &Report,
    ) -> Vec<Picture> {
        figures::solid::of_solve(case, fields, contact, report)
    }

    fn view_of_step(
        case: &Case<Self>,
        fields: &Fields<'_, Self>,
        rows: &[Vec<ContactRow>],
        step: (usize, usize),
    ) -> Option<Value> {
        let rows: Vec<&[ContactRow]> = rows.iter().map(Vec::as_slice).collect();
        figures::solid::of_step(case, fields, &rows, step)
    }
}

/// Nodes of a mesh file are off their surface by at most this fraction of its size.
const ON_SURFACE: f64 = 1e-6;

/// Lists the nodes that are not on their declared surface.
fn off_surfaces(body: &Body<Solid>) -> Vec<NodeId> {
    let (mesh, limit) = (body.mesh(), ON_SURFACE * body.mesh().diagonal());
    let is_off = |line: &RigidLine<Solid>, node: &NodeId| line.distance(mesh.points()[*node]).0.abs() > limit;
    let of_face = |(face, line): (&FacetId, &RigidLine<Solid>)| {
        mesh.topology().facets()[*face].into_iter().filter(|node| is_off(line, node)).collect::<Vec<_>>()
    };
    let mut off: Vec<NodeId> = body.surfaces().iter().flat_map(of_face).collect();
    off.sort_unstable();
    off.dedup();
    off
}

/// A tensor in VTK's order.
fn six(t: SymTensor3) -> [f64; 6] {
    [t.xx, t.yy, t.zz, t.xy, t.yz, t.xz]
}
