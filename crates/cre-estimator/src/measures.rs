//! Results of one pass over the cells of a body: force residuals, distances, means, shapes.

use crate::size::{larger, square};
use fem_core::body::FacetCondition;
use fem_core::double_double::DoubleDouble;
use fem_core::space::{Plane, Space};

/// Accuracy of an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// Neumann problems by the factor alone, residuals in double precision.
    Double,
    /// Neumann problems with iterative refinement, residuals in double-double numbers.
    Refined,
}

/// The stresses to which the distances of a stress are measured.
pub(crate) type Against<'a, S = Plane> = [Option<&'a [<S as Space>::Tensor]>; 2];

/// The results of a pass over the cells of a body.
#[derive(Clone, Debug, Default)]
pub struct CellMeasures<S: Space = Plane> {
    /// `‖τ − σ‖²` for the stresses of [`Against`], J/m; empty for one that is not given.
    pub(crate) distances: [Vec<f64>; 2],
    /// Mean of τ, Pa.
    pub(crate) mean: Vec<S::Tensor>,
    /// The same without rounding; empty in double precision.
    pub(crate) exact_mean: Vec<S::Components<DoubleDouble>>,
}

impl<S: Space> CellMeasures<S> {
    /// Reserves memory for this many cells.
    pub(crate) fn reserve(&mut self, cells: usize, against: Against<'_, S>, accuracy: Accuracy) {
        for (distances, _) in self.distances.iter_mut().zip(against).filter(|(_, given)| given.is_some()) {
            distances.reserve_exact(cells);
        }
        self.mean.reserve_exact(cells);
        if accuracy == Accuracy::Refined {
            self.exact_mean.reserve_exact(cells);
        }
    }
}

/// Squares of the force residuals of one body and of the scale they are compared with, N²/m²; one square root at the
/// end.
#[derive(Clone, Copy, Debug, Default)]
pub struct Forces {
    pub(crate) equilibrium: f64,
    pub(crate) jump: f64,
    pub(crate) boundary: f64,
    pub(crate) scale: f64,
}

impl Forces {
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            equilibrium: larger(self.equilibrium, other.equilibrium),
            jump: larger(self.jump, other.jump),
            boundary: larger(self.boundary, other.boundary),
            scale: larger(self.scale, other.scale),
        }
    }

    /// Compares the forces on a facet inside the body from both sides.
    #[inline(always)]
    pub(crate) fn compare<S: Space>(&mut self, own: &S::Axes<S::Vector>, other: &S::Axes<S::Vector>) {
        self.raise_scale::<S>(own);
        for (a, b) in own.as_ref().iter().zip(other.as_ref()) {
            self.jump = larger(self.jump, square(*a + *b));
        }
    }

    /// Compares the forces on a facet of the boundary with the given ones. Along springs any force is admissible: the bound measures it.
    ///
    /// * `measure`: of the facet, m or m².
    #[inline(always)]
    pub(crate) fn compare_given<S: Space>(
        &mut self,
        own: &S::Axes<S::Vector>,
        condition: &FacetCondition<S>,
        measure: f64,
    ) {
        self.raise_scale::<S>(own);
        let given_in = condition.carried().complement();
        for (force, traction) in own.as_ref().iter().zip(condition.expected_traction()) {
            let given = traction * measure;
            self.scale = larger(self.scale, square(given));
            let difference = given_in.components(*force - given);
            self.boundary = larger(self.boundary, square(difference));
        }
    }

    #[inline(always)]
    fn raise_scale<S: Space>(&mut self, own: &S::Axes<S::Vector>) {
        self.scale = own.as_ref().iter().fold(self.scale, |most, force| larger(most, square(*force)));
    }
}

/// The quantities of a cell that determine its rounding errors.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// The measure of all its facets.
    pub(crate) boundary: f64,
    /// The measure of its largest facet.
    pub(crate) largest: f64,
    /// 1 in a cell of half a square or a sixth of a cube, in proportion to length over height in a flat one; not less than 1.
    pub(crate) flatness: f64,
}
