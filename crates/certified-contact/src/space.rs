//! What the results of contact are in the plane and in space.

use crate::error::SolveError;
use crate::lines::{self, Stretch};
use crate::pair_forces::PairForces;
use crate::{recovered_pressure, spin};
use contact_geometry::Refinable;
use cre_estimator::Recovery;
use fem_core::interface::{ContactInterface, ContactProblem};
use fem_core::space::{Plane, Solid};

/// The space of a contact problem: [`Plane`] and [`Solid`] are all there are. Arc lengths and declared arcs are ideas of the plane.
pub trait ContactSpace: Recovery + Refinable {
    /// Leaves loads out along rotations that only the error of a polygon resists.
    ///
    /// # Errors
    /// Numbers that are not finite.
    fn without_spin(problem: ContactProblem<Self>) -> Result<ContactProblem<Self>, SolveError<Self>> {
        Ok(problem)
    }

    /// Tells whether a contact line is on a declared arc, along which a body can turn.
    fn is_on_arc(_interface: &ContactInterface<Self>) -> bool {
        false
    }

    /// Finds the intervals of arc length whose nodes have a property, m.
    fn intervals(_interface: &ContactInterface<Self>, _carries: &dyn Fn(usize) -> bool) -> Vec<[f64; 2]> {
        Vec::new()
    }

    /// Adds up the forces of each connected part of a contact line.
    #[doc(hidden)]
    fn stretches(_pair: &PairForces<'_, Self>) -> Vec<Stretch> {
        Vec::new()
    }

    /// Computes the pressure that is recovered over the cells of the coarser side, see [`crate::recovered_pressure`].
    fn recovered_pressure(
        _problem: &ContactProblem<Self>,
        _pair: usize,
        _forces: &[f64],
    ) -> Option<Vec<f64>> {
        None
    }
}

impl ContactSpace for Plane {
    fn without_spin(problem: ContactProblem) -> Result<ContactProblem, SolveError> {
        spin::without_spin(problem)
    }

    fn is_on_arc(interface: &ContactInterface) -> bool {
        interface.centre().is_some()
    }

    fn intervals(interface: &ContactInterface, carries: &dyn Fn(usize) -> bool) -> Vec<[f64; 2]> {
        lines::intervals(interface, carries)
    }

    fn stretches(pair: &PairForces<'_>) -> Vec<Stretch> {
        lines::stretches(pair)
    }

    fn recovered_pressure(problem: &ContactProblem, pair: usize, forces: &[f64]) -> Option<Vec<f64>> {
        recovered_pressure::recovered_pressure(problem, pair, forces)
    }
}

impl ContactSpace for Solid {}
