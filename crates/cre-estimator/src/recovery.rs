//! The recovery of stresses in exact equilibrium, in any space.

use crate::equilibrated::{EquilibratedStress, FacetMoments};
use crate::measures::{Accuracy, Against, CellMeasures, Forces, Shape};
use crate::relaxation::{Relaxation, RelaxationReport};
use fem_core::body::{Body, FacetCondition};
use fem_core::interface::{ContactFacet, ContactInterface, ContactPair};
use fem_core::material::LinearElastic;
use fem_core::mesh::Mesh;
use fem_core::space::Space;

/// The memory of the coefficients of the relaxation of a body.
pub enum StarMemory<T> {
    /// In memory, that of other stars if they are given.
    Stored(Option<T>),
    /// Those of solids are computed again in each sweep: about a fifth of their memory, and several times the time of a sweep. The result is the same.
    Recomputed,
}

impl<T> StarMemory<T> {
    /// * `used`: stars whose memory is used again, or released.
    pub(crate) fn new(recomputes: bool, used: Option<T>) -> Self {
        if recomputes { Self::Recomputed } else { Self::Stored(used) }
    }

    pub(crate) fn map<U>(self, of: impl FnOnce(T) -> U) -> StarMemory<U> {
        match self {
            Self::Stored(used) => StarMemory::Stored(used.map(of)),
            Self::Recomputed => StarMemory::Recomputed,
        }
    }
}

/// The recovery of stresses in exact equilibrium: all that differs by idea between the plane and solid bodies.
pub trait Recovery: Space {
    /// Tells whether the pressures that balance a floating body are found by facet on bent facets, and not by node. In the plane they are not: loads that
    /// only the error of normals resists would take pressures much farther from the forces (a bearing of rollers, 100 % of the energy norm on
    /// 230,000 nodes instead of 8 % on 41,000).
    const BALANCED_BY_FACET: bool;

    /// What relaxes several stresses of one body.
    type Stars<'a>: Send;

    /// Computes facet moments in equilibrium with an FE stress that is in FE equilibrium with the conditions.
    ///
    /// * `stress`: of each cell, Pa; `conditions`: of each boundary facet, in the order of
    ///   [`fem_core::mesh::topology::Topology::boundary_facets`].
    fn facet_moments(
        body: &Body<Self>,
        stress: &[Self::Tensor],
        conditions: &[FacetCondition<Self>],
    ) -> FacetMoments<Self>;

    /// Lowers `‖τ − σ̂‖` in place; loads and given tractions stay the same to the last digit.
    ///
    /// * `stars`: of the body, made if they are missing and worth keeping; `memory`: of their coefficients.
    fn relax_with<'a>(
        body: &'a Body<Self>,
        stress: &mut EquilibratedStress<Self>,
        relaxation: Relaxation,
        stars: &mut Option<Self::Stars<'a>>,
        memory: StarMemory<Self::Stars<'_>>,
    ) -> RelaxationReport;

    /// Computes von Mises' equivalent stress, Pa; `None` if a component out of the plane is unknown.
    ///
    /// * `temperature`: its change, K.
    fn von_mises(material: &LinearElastic<Self>, stress: Self::Tensor, temperature: f64) -> Option<f64>;

    /// Computes the principal stresses, Pa, ascending; in the plane those in the plane.
    fn principal(stress: Self::Tensor) -> Self::Axes<f64>;

    /// Counts the holes of a body, in space those that go through, from the closed parts of its boundary.
    ///
    /// * `counts`: nodes and facets of the boundary; `parts`: its connected parts; `pieces`: of the body.
    #[doc(hidden)]
    fn holes(counts: [usize; 2], parts: usize, pieces: usize) -> usize;

    /// Counts the bytes of the relaxation of a body.
    ///
    /// * `stored`: whether all coefficients are stored, see [`StarMemory`].
    fn bytes_of_relaxation(mesh: &Mesh<Self>, stored: bool) -> usize;

    /// Computes `‖τ − σ̂‖²` over the cells of a body, J/m in the plane, J in space. It does not depend on the number of threads.
    fn distance_squared(body: &Body<Self>, stress: &EquilibratedStress<Self>) -> f64;

    /// Computes the distance² to a stress that is constant in a cell, in the complementary norm.
    fn cell_distance_squared(
        body: &Body<Self>,
        stress: &EquilibratedStress<Self>,
        cell: usize,
        constant: Self::Tensor,
    ) -> f64;

    /// Finds the force residuals of a body, and measures its cells if `measured` says against what and how accurately.
    #[doc(hidden)]
    fn measured(
        body: &Body<Self>,
        stress: &EquilibratedStress<Self>,
        measured: Option<(Against<'_, Self>, Accuracy)>,
    ) -> (Forces, CellMeasures<Self>);

    /// Computes the moments `∫ F φ_j` of the tractions on facet `k` of a cell, from the stress itself, in the order of [`Space::facet`].
    #[doc(hidden)]
    fn facet_forces(
        body: &Body<Self>,
        stress: &EquilibratedStress<Self>,
        cell: usize,
        k: usize,
    ) -> Self::Axes<Self::Vector>;

    /// Measures what determines the rounding errors in a cell.
    #[doc(hidden)]
    fn shape(corners: &Self::Corners<Self::Vector>, measure: f64) -> Shape;

    /// Integrates the rotation of a linear displacement over a cell, times the measure.
    #[doc(hidden)]
    fn twist(corners: &Self::Corners<Self::Vector>, displacement: &Self::Corners<Self::Vector>)
    -> Self::Spin;

    /// Computes the middle Bernstein coefficients of the opening on every contact facet, m, one per edge of it, facet after facet: they count on bent
    /// facets only.
    #[doc(hidden)]
    fn middle_openings(interface: &ContactInterface<Self>, displacement: [&[Self::Vector]; 2]) -> Vec<f64>;

    /// Computes `∫ p o` on a contact facet.
    ///
    /// * `opening`: at its corners, `middle`: on its edges, m.
    #[doc(hidden)]
    fn contact_work(
        facet: &ContactFacet<Self>,
        pressure: &Self::Axes<f64>,
        opening: &Self::Axes<f64>,
        middle: &[f64],
    ) -> f64;

    /// Computes by how much a bent facet penetrates between its corners, m; not positive if its opening is nowhere negative.
    ///
    /// * `opening`: at its corners, `middle`: on its edges, m.
    #[doc(hidden)]
    fn depth(opening: &Self::Axes<f64>, middle: &[f64]) -> f64;

    /// Computes the mean of `s|w| − q·w` on a contact facet, J/m², in space a bound of it.
    ///
    /// * `limit`, `friction`, `jump`: at its corners, Pa and m, the limit over the length of the normal, see [`crate::friction::FacetFriction`].
    #[doc(hidden)]
    fn mean_sliding(
        pair: &ContactPair<Self>,
        facet: &ContactFacet<Self>,
        limit: &Self::Axes<f64>,
        friction: &Self::Axes<Self::Vector>,
        jump: &Self::Axes<Self::Vector>,
    ) -> f64;
}

impl<S: Recovery> EquilibratedStress<S> {
    /// Recovers an equilibrated stress from an FE stress that is in FE equilibrium with the conditions; of a body on springs these are
    /// [`crate::released`].
    pub fn recover(
        body: &Body<S>,
        finite_element: Vec<S::Tensor>,
        conditions: Vec<FacetCondition<S>>,
    ) -> Self {
        let facet_moments = S::facet_moments(body, &finite_element, &conditions);
        Self { facet_moments, conditions, finite_element }
    }

    /// Computes the distance² `‖τ − σ̂‖²` to the FE stress over the whole body, in the complementary norm, J/m in the plane, J in space, and that
    /// of the tractions on springs. It does not depend on the number of threads.
    pub fn distance_squared(&self, body: &Body<S>) -> f64 {
        S::distance_squared(body, self) + self.spring_energy(body)
    }
}
