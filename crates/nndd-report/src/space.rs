//! What reports of the plane and of solids have of their own. All else is written once.

use crate::figures::{NamedRows, Picture};
use crate::solved::Fields;
use case_io::Case;
use case_io::case::Dimension;
use case_io::report::{
    ContactLine, ContactSurface, FrictionLine, FrictionSurface, LineResults, Report, Spin,
};
use case_io::table::{ContactRow, FrictionRow};
use certified_contact::{ContactSpace, FrictionResults, PairResults, Results};
use cre_estimator::FieldCertificate;
use fem_core::interface::{ContactInterface, ContactPair, ContactProblem};
use fem_core::material::LinearElastic;
use fem_core::mesh::id::NodeId;
use mesh_io::vtu::VtuCells;
use serde_json::Value;

/// The facets of a contact interface as they are drawn.
#[derive(Clone, Debug)]
pub struct DrawnFacets<S: ContactSpace> {
    /// Positions: those of the pairs, then those of clamped ends.
    pub(crate) points: Vec<S::Vector>,
    /// The facets by the numbers of their points.
    pub(crate) cells: VtuCells,
    /// The measure of each facet as it is drawn, m or m².
    pub(crate) measures: Vec<f64>,
    /// Of each clamped node a pair of the facets around, whose values it has, and its opening, m.
    pub(crate) clamped: Vec<(usize, f64)>,
}

/// Subdomains of the same size.
pub struct Pieces {
    /// How many.
    pub count: f64,
    /// The nodes of each.
    pub nodes: f64,
    /// Its nodes that others have as well.
    pub shared: f64,
}

/// The space of a report: [`fem_core::space::Plane`] and [`fem_core::space::Solid`] are all there are.
pub trait ReportSpace: ContactSpace + Dimension {
    /// The word for what two bodies share.
    const INTERFACE: &'static str;
    /// The words for the integral of the pressure.
    const PRESSURE_INTEGRAL: &'static str;

    /// Lists the edges of each body on a first mesh that seem to approximate a curve and are not declared; none of solids.
    fn undeclared(_problem: &ContactProblem<Self>) -> Vec<Vec<[NodeId; 2]>> {
        Vec::new()
    }

    /// Says what an adaptive run made of sides.
    ///
    /// * `undeclared`: of [`Self::undeclared`] on the first meshes; `problem`: on the last ones.
    fn notes_on_refinement(
        _case: &Case<Self>,
        _undeclared: &[Vec<[NodeId; 2]>],
        _problem: &ContactProblem<Self>,
    ) -> Vec<String> {
        Vec::new()
    }

    /// Estimates the memory of a body in a solve, bytes.
    ///
    /// * `counts`: its nodes and contact nodes; `subdomains`: of a body that is cut; `recomputes`: whether coefficients of the estimator are computed again.
    fn memory(counts: (u64, usize), subdomains: &[Pieces], recomputes: bool) -> f64;
    /// The need grows as this power of the number of nodes.
    const MEMORY_POWER: f64;
    /// What makes a problem with too many nodes smaller.
    const FEWER_NODES: &'static str;
    /// What makes a contact interface with too many nodes smaller.
    const FEWER_PAIRS: &'static str;

    /// What helps against that.
    const FINER_MESH: &'static str;
    /// Tells whether linear displacements of a case lock near incompressibility.
    fn locks(case: &Case<Self>) -> bool;
    /// Says what else limits the use of a solution: corners with infinite stress, contact that ends where a side ends.
    fn notes_on_results(case: &Case<Self>, fields: &Fields<'_, Self>) -> Vec<String>;
    /// Says what the meshes make of curved and bent sides.
    fn notes_on_shapes(case: &Case<Self>, fields: &Fields<'_, Self>) -> Vec<String>;

    /// Summarises what contact lines have alone.
    fn contact_line(pair: &ContactPair<Self>, found: Option<&PairResults<Self>>) -> Option<ContactLine>;
    /// Summarises what contact surfaces have alone.
    fn contact_surface(pair: &ContactPair<Self>, found: Option<&PairResults<Self>>)
    -> Option<ContactSurface>;
    /// Summarises the results of all contact lines.
    fn line_results(found: Option<&Results<Self>>) -> Option<LineResults>;
    /// Returns the arc length at a pair, m; `None` on a surface.
    fn arc_length(interface: &ContactInterface<Self>, pair: usize) -> Option<f64>;

    /// Returns a stress in VTK's order xx, yy, zz, xy, yz, xz, Pa; in the plane 0 for zz if the material does not say it.
    ///
    /// * `temperature`: its change, K.
    fn six_stresses(material: &LinearElastic<Self>, stress: Self::Tensor, temperature: f64) -> [f64; 6];
    /// Returns the strain of a stress and a change of temperature in the same order.
    ///
    /// * `place`: of the material in the case.
    fn six_strains(
        case: &Case<Self>,
        place: usize,
        material: &LinearElastic<Self>,
        state: (Self::Tensor, f64),
    ) -> [f64; 6];
    /// Returns the traction of friction on the first body, Pa.
    fn friction_traction(normal: Self::Vector, row: &FrictionRow) -> Self::Vector;
    /// Returns vectors of friction as the table of a contact surface has them; `None` on a line.
    fn friction_in_space(vectors: [Self::Vector; 2]) -> Option<[[f64; 3]; 2]>;
    /// Writes the force of friction on the second body.
    fn friction_written(found: &FrictionResults<Self>) -> Spin;
    /// Summarises where a contact line sticks and slips.
    fn friction_line(found: &FrictionResults<Self>) -> Option<FrictionLine>;
    /// Summarises how much of a contact surface sticks and slips.
    fn friction_surface(found: &FrictionResults<Self>) -> Option<FrictionSurface>;
    /// Lists the facets of a contact interface.
    fn drawn_facets(fields: &Fields<'_, Self>, pair: usize) -> DrawnFacets<Self>;

    /// Draws the error of a field that another program computed; `None` of solids, whose page has a table.
    ///
    /// * `densities`: of the squared error in the cells of each body.
    fn error_map(
        case: &Case<Self>,
        problem: &ContactProblem<Self>,
        found: &FieldCertificate<Self>,
        densities: &[Vec<f64>],
    ) -> Option<Picture>;

    /// Draws the figures of a solve.
    ///
    /// * `contact`: the rows of contact.csv, and what [`Self::view_of_step`] made of each load step.
    fn pictures(
        case: &Case<Self>,
        fields: &Fields<'_, Self>,
        contact: (&NamedRows<'_>, &[Value]),
        report: &Report,
    ) -> Vec<Picture>;

    /// Makes the data of a load step for the view that turns; `None` in the plane, which has none.
    ///
    /// * `rows`: of contact.csv, of each pair; `step`: its number, from 1, and the number of all.
    fn view_of_step(
        _case: &Case<Self>,
        _fields: &Fields<'_, Self>,
        _rows: &[Vec<ContactRow>],
        _step: (usize, usize),
    ) -> Option<Value> {
        None
    }
}
