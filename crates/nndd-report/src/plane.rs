//! Reports of plane bodies.

use crate::certify;
use crate::corners;
use crate::curves;
use crate::figures::NamedRows;
use crate::figures::{self, Picture};
use crate::memory::{BODY, INTERFACE};
use crate::notes::LOCKING_RATIO;
use crate::solved::Fields;
use crate::space::{DrawnFacets, Pieces, ReportSpace};
use case_io::Case;
use case_io::case::MaterialLaw;
use case_io::report::{
    ContactLine, ContactStretch, ContactSurface, FrictionLine, FrictionSurface, LineResults, Report, Spin,
};
use case_io::table::FrictionRow;
use certified_contact::{FrictionResults, PairResults, Results};
use cre_estimator::FieldCertificate;
use fem_core::geometry::{Vector, norm, perpendicular, shown};
use fem_core::interface::{ContactFacet, ContactInterface, ContactPair, ContactProblem};
use fem_core::material::{Hypothesis, LinearElastic};
use fem_core::mesh::id::NodeId;
use fem_core::space::Plane;
use fem_core::tensor::SymTensor2;
use mesh_io::vtu::VtuCells;
use serde_json::Value;

/// Bytes of the factor per n log₂ n; of mesh and fields per unknown.
const FACTOR: f64 = 56.0;
const FIELDS: f64 = 450.0;

/// Contact nodes that were moved by less than this part of the largest displacement need no note.
const MOVED: f64 = 1e-4;

impl ReportSpace for Plane {
    const INTERFACE: &'static str = "contact line";
    const PRESSURE_INTEGRAL: &'static str = "∫ p ds";
    const MEMORY_POWER: f64 = 1.05;
    const FEWER_NODES: &'static str = "take fewer cells, or refine only where it is needed with [adapt]";
    const FEWER_PAIRS: &'static str = "take fewer edges along the contact line";
    const FINER_MESH: &'static str = "use a finer mesh ([adapt] target_relative_error)";

    fn undeclared(problem: &ContactProblem) -> Vec<Vec<[NodeId; 2]>> {
        curves::undeclared(problem)
    }

    fn notes_on_refinement(
        case: &Case,
        undeclared: &[Vec<[NodeId; 2]>],
        problem: &ContactProblem,
    ) -> Vec<String> {
        curves::refined(case, undeclared, problem).into_iter().collect()
    }

    /// With n unknowns the factor of a nested dissection grows as n log₂ n; the mesh with its topology, the fields
    /// of the estimator and its stars as n; then three dense interface matrices. The two numbers are
    /// fitted to what was measured from 2·10⁵ to 3.3·10⁶ unknowns: within 8 %, rather too much than too little.
    fn memory((nodes, pairs): (u64, usize), _: &[Pieces], _: bool) -> f64 {
        let (n, pairs) = (2.0 * nodes.max(1) as f64, pairs as f64);
        FACTOR * n * n.log2() + FIELDS * n + INTERFACE * pairs * pairs + BODY
    }

    fn locks(case: &Case) -> bool {
        case.model.hypothesis == Hypothesis::PlaneStrain
            && case.materials.iter().any(
                |material| matches!(material.law, MaterialLaw::Isotropic { poisson, .. } if poisson >= LOCKING_RATIO),
            )
    }

    fn notes_on_results(case: &Case, fields: &Fields<'_>) -> Vec<String> {
        let mut notes = corners::of_fields(case, fields);
        notes.extend(short_sides(case, fields));
        notes
    }

    fn notes_on_shapes(case: &Case, fields: &Fields<'_>) -> Vec<String> {
        let mut notes = bent_contact(fields);
        notes.extend(curves::of_solution(case, fields));
        notes
    }

    fn contact_line(pair: &ContactPair, found: Option<&PairResults>) -> Option<ContactLine> {
        let intervals = found.map(|found| found.contact_intervals.clone());
        let width = intervals.as_ref().map(|of| of.iter().fold(0.0, |sum, [from, to]| sum + (to - from)));
        Some(ContactLine { length: pair.interface.measure(), contact_intervals: intervals, width })
    }

    fn contact_surface(_: &ContactPair, _: Option<&PairResults>) -> Option<ContactSurface> {
        None
    }

    fn line_results(found: Option<&Results>) -> Option<LineResults> {
        let stretch = |s: &certified_contact::Stretch| ContactStretch {
            s: s.s,
            pairs: s.pairs,
            length: s.length,
            contact_force: s.contact_force,
            resultant: s.resultant.into(),
            moment: s.moment,
            max_pressure: s.max_pressure,
            max_edge_pressure: s.max_edge_pressure,
            min_opening: s.min_opening,
        };
        Some(LineResults {
            contact_intervals: found.map(|found| found.contact_intervals.clone()),
            contact_stretches: found.map(|found| found.contact_stretches.iter().map(stretch).collect()),
        })
    }

    fn arc_length(interface: &ContactInterface, pair: usize) -> Option<f64> {
        interface.arc_lengths().get(pair).copied()
    }

    /// The stress along z is not known for a given plane stiffness in plane strain.
    fn six_stresses(material: &LinearElastic, stress: SymTensor2, temperature: f64) -> [f64; 6] {
        six(stress, material.out_of_plane_stress(stress, temperature).unwrap_or(0.0))
    }

    /// `ε_zz`: 0 in plane strain, `−ν/E (σ_xx + σ_yy) + α T` in plane stress of an isotropic material; 0, too, if the plane
    /// constants do not say it.
    fn six_strains(
        case: &Case,
        place: usize,
        material: &LinearElastic,
        (stress, temperature): (SymTensor2, f64),
    ) -> [f64; 6] {
        let thermal = material.thermal_strain().scaled(temperature);
        let zz = match (case.model.hypothesis, &case.materials[place].law) {
            (Hypothesis::PlaneStress, MaterialLaw::Isotropic { young, poisson }) => {
                -poisson / young * (stress.xx + stress.yy) + thermal.xx
            }
            _ => 0.0,
        };
        six(material.strain(stress).plus(thermal), zz)
    }

    fn friction_traction(normal: Vector, row: &FrictionRow) -> Vector {
        -row.tangential * perpendicular(normal)
    }

    fn friction_in_space(_: [Vector; 2]) -> Option<[[f64; 3]; 2]> {
        None
    }

    fn friction_written(found: &FrictionResults<Self>) -> Spin {
        Spin::Plane(found.force)
    }

    fn friction_line(found: &FrictionResults<Self>) -> Option<FrictionLine> {
        let (stick_intervals, slip_intervals) = (found.stick_intervals.clone(), found.slip_intervals.clone());
        Some(FrictionLine { stick_intervals, slip_intervals })
    }

    fn friction_surface(_: &FrictionResults<Self>) -> Option<FrictionSurface> {
        None
    }

    fn drawn_facets(fields: &Fields<'_>, pair: usize) -> DrawnFacets<Self> {
        let of = &fields.problem.contacts[pair];
        let mesh = fields.problem.bodies[of.body].mesh();
        let pairs = of.interface.pairs();
        let mut points: Vec<Vector> = pairs.iter().map(|pair| mesh.points()[pair.nodes[0]]).collect();
        let mut clamped_ends = Vec::new();
        let ends = |edge: &ContactFacet| {
            let mut ends = edge.pairs;
            for end in 0..2 {
                if let Some(clamped) = edge.clamped[end] {
                    clamped_ends.push((ends[1 - end] as usize, clamped.opening));
                    ends[end] = points.len() as u32;
                    points.push(mesh.points()[of.interface.corner_pair(edge, end).nodes[0]]);
                }
            }
            ends
        };
        let ends: Vec<[u32; 2]> = of.interface.facets().iter().map(ends).collect();
        let length = |ends: &[u32; 2]| {
            let [a, b] = ends.map(|k| points[k as usize]);
            norm(b - a)
        };
        let measures = ends.iter().map(length).collect();
        DrawnFacets { measures, points, cells: VtuCells::Lines(ends), clamped: clamped_ends }
    }

    fn error_map(
        case: &Case,
        problem: &ContactProblem,
        found: &FieldCertificate,
        densities: &[Vec<f64>],
    ) -> Option<Picture> {
        Some(certify::map(case, problem, found, densities))
    }

    fn pictures(
        case: &Case,
        fields: &Fields<'_>,
        (contact, _): (&NamedRows<'_>, &[Value]),
        report: &Report,
    ) -> Vec<Picture> {
        figures::of_solve(case, fields, contact, report)
    }
}

/// A tensor in VTK's order.
fn six(t: SymTensor2, zz: f64) -> [f64; 6] {
    [t.xx, t.yy, zz, t.xy, 0.0, 0.0]
}

/// Cosine of the largest turn of a smooth outline, 30 degrees.
const SMOOTH: f64 = 0.866;

/// Names the contact lines with the largest pressure at an end at which the bodies continue smoothly: nothing ends contact there but the side.
fn short_sides(case: &Case, fields: &Fields<'_>) -> Vec<String> {
    let problem = fields.problem;
    let mut rest = fields.last.contact.normal_reaction.as_slice();
    let mut notes = Vec::new();
    for (pair, named) in problem.contacts.iter().zip(&case.contacts) {
        let nodes = pair.interface.pairs();
        let (forces, others) = rest.split_at(nodes.len().min(rest.len()));
        rest = others;
        let pressure = nodes.iter().zip(forces).map(|(node, force)| force / node.weight);
        let Some((k, largest)) = pressure.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
        let mut edges = pair.interface.facets().iter().filter(|edge| edge.pairs.contains(&(k as u32)));
        let (Some(edge), None) = (edges.next(), edges.next()) else { continue };
        let smooth = |(side, b): (usize, usize)| {
            let mesh = problem.bodies[b].mesh();
            let beyond = mesh.topology().boundary_beyond(edge.facets[side], nodes[k].nodes[side]);
            let beyond = beyond.filter(|e| !corners::touches(problem, b, *e));
            beyond.is_some_and(|e| mesh.facet_normal(e).dot(&mesh.facet_normal(edge.facets[side])) >= SMOOTH)
        };
        if largest > 0.0 && edge.clamped == [None; 2] && pair.elastic_sides().all(smooth) {
            let at = problem.bodies[pair.body].mesh().points()[nodes[k].nodes[0]];
            notes.push(format!(
                "contact \"{}\": the pressure is largest at an end of the contact line, at ({}, {}), and the bodies continue smoothly there: is \
                 a contact side too short? Add the sides beyond it to `surfaces`, with gap = \"geometric\"",
                named.name,
                shown(at[0]),
                shown(at[1])
            ));
        }
    }
    notes
}

/// Says what the bound, or the residual, of a bent contact line is one of, and by how much its nodes were moved.
fn bent_contact(solution: &Fields<'_>) -> Vec<String> {
    let Some(estimate) = solution.estimate else { return Vec::new() };
    if !solution.problem.contacts.iter().any(|pair| pair.interface.has_bent_facets()) {
        return Vec::new();
    }
    let mut notes = vec![format!(
        "the contact line bends: {} is for the meshed polygons with normals averaged at their nodes, not for a curved line",
        solution.what()
    )];
    let largest = estimate.pair.contacts.iter().map(|contact| contact.lift.largest()).fold(0.0, f64::max);
    let displacements = estimate.pair.bodies.iter().flat_map(|body| &body.displacement);
    if largest > MOVED * displacements.map(|u| norm(*u)).fold(0.0, f64::max) {
        notes.push(format!(
            "the contact nodes of one body were moved by at most {largest:.1e}, so that bent edges do not penetrate between them"
        ));
    }
    notes
}
