//! What the results of contact are in the plane and in space.

use crate::error::SolveError;
use crate::lines::{self, Stretch};
use crate::means::{line, surface};
use crate::pair_forces::PairForces;
use crate::spin;
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

    /// Replaces the pressures of a pair by those recovered over the cells of the coarser side, see [`crate::recovered_pressure`].
    ///
    /// * `own`: of each side, the pairs of nodes whose node no common refinement put in.
    #[doc(hidden)]
    fn recover_over_cells(
        problem: &ContactProblem<Self>,
        pair: usize,
        own: &[Vec<bool>; 2],
        forces: &[f64],
        pressure: &mut [f64],
    );
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

    fn recover_over_cells(
        problem: &ContactProblem,
        pair: usize,
        own: &[Vec<bool>; 2],
        forces: &[f64],
        pressure: &mut [f64],
    ) {
        line::recover(&problem.contacts[pair].interface, own, forces, pressure);
    }
}

impl ContactSpace for Solid {
    fn recover_over_cells(
        problem: &ContactProblem<Solid>,
        pair: usize,
        own: &[Vec<bool>; 2],
        forces: &[f64],
        pressure: &mut [f64],
    ) {
        surface::recover((problem, &problem.contacts[pair]), own, forces, pressure);
    }
}
