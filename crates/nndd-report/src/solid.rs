//! Reports of solids.

use crate::adapt;
use crate::failure::Failure;
use crate::figures::Picture;
use crate::host::Host;
use crate::memory::{BODY, INTERFACE};
use crate::notes::LOCKING_RATIO;
use crate::once;
use crate::resume::RunDirectory;
use crate::run_observer::RunObserver;
use crate::solved::{Fields, Solved};
use crate::space::{DrawnFacets, NamedRows, ReportSpace};
use crate::stopwatch::Stopwatch;
use case_io::Case;
use case_io::case::{Factors, MaterialLaw};
use case_io::report::{ContactLine, ContactSurface, LineResults, Report, SurfaceArea, SurfacePatch};
use certified_contact::{PairResults, PatchResults, Results, SolveError};
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

type Vector = <Solid as Space>::Vector;

/// Bytes of the factor per n^(4/3); of mesh, fields and stars per unknown. Fitted to eight solves of two pressed blocks with 90 to 77,274
/// nodes: within 10 % from 8,450 nodes on, and 30 % too little at 2,754.
const FACTOR: f64 = 190.0;
const FIELDS: f64 = 8300.0;

impl ReportSpace for Solid {
    const INTERFACE: &'static str = "contact surface";
    const PRESSURE_INTEGRAL: &'static str = "∫ p dA";
    const MEMORY_POWER: f64 = 4.0 / 3.0;
    const FEWER_NODES: &'static str = "take fewer cells, or refine only where it is needed with [adapt]";
    const FEWER_PAIRS: &'static str = "take fewer faces on the contact surface";
    const FINER_MESH: &'static str = "use a finer mesh ([adapt] target_relative_error)";

    fn solve(
        case: &Case<Self>,
        problem: ContactProblem<Self>,
        place: &mut RunDirectory,
        around: (&mut Stopwatch, &mut dyn Host),
    ) -> Result<Solved<Self>, Failure> {
        if let Some(adapt) = &case.adapt {
            let follower = RunObserver::new(case, around.0, around.1, place.presence());
            return adapt::solve((case, adapt), problem, follower, place, adapt::certified);
        }
        let answer = |problem, follower: &mut RunObserver<'_>| once::certified(case, problem, follower);
        once::solve(case, problem, place.presence(), around, answer)
    }

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

    /// Cases of solids have no load steps: the reader refuses them.
    fn with_factors(
        _: &Case<Self>,
        problem: &ContactProblem<Self>,
        _: &Factors,
    ) -> Result<ContactProblem<Self>, SolveError<Self>> {
        Ok(problem.clone())
    }

    /// With n unknowns the factor of a nested dissection grows as n^(4/3).
    fn memory(nodes: u64, pairs: usize) -> f64 {
        let (n, pairs) = (3.0 * nodes.max(1) as f64, pairs as f64);
        FACTOR * n * n.cbrt() + FIELDS * n + INTERFACE * pairs * pairs + BODY
    }

    fn locks(case: &Case<Self>) -> bool {
        let poisson = |law: &MaterialLaw<Self>| match law {
            MaterialLaw::Isotropic { poisson, .. } => *poisson,
            _ => 0.0,
        };
        case.materials.iter().any(|material| poisson(&material.law) >= LOCKING_RATIO)
    }

    fn largest_strain(strain: SymTensor3) -> f64 {
        strain.largest_principal()
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

    fn six_stresses(_: &LinearElastic<Self>, stress: SymTensor3) -> [f64; 6] {
        six(stress)
    }

    fn six_strains(_: &Case<Self>, _: usize, material: &LinearElastic<Self>, stress: SymTensor3) -> [f64; 6] {
        six(material.strain(stress))
    }

    /// Contact of solids has no friction so far.
    fn friction_traction(_: Vector, _: f64) -> Vector {
        Vector::zeros()
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

    fn pictures(_: &Case<Self>, _: &Fields<'_, Self>, _: &NamedRows<'_>, _: &Report) -> Vec<Picture> {
        Vec::new()
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
