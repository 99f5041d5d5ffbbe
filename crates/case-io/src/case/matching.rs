//! The problem of a case: its bodies as they are if their contact surfaces match, refined to match if they do not.

use super::{Case, cures};
use crate::diagnostic::{CaseError, Diagnostic, code, significant};
use fem_core::body::Body;
use fem_core::geometry::{norm, shown};
use fem_core::interface::common_refinement::{Changes, CommonRefinementError, common_refinement};
use fem_core::interface::{ContactInterface, ContactPair, ContactProblem, GapChange};
use mesh_io::words::counted;

/// Surfaces whose edges are farther from a smooth curve, in their lengths, are bent.
const BENT: f64 = 1e-6;
/// Surfaces closer than this part of the gap are drawn touching.
const TOUCHING: f64 = 1e-6;
/// Corners of the contact line from this angle on, in degrees, get a note.
const CORNER: f64 = 30.0;

impl Case {
    /// Makes the contact problem, bodies in the file's order. A corner of the contact line gets a note. Contact surfaces that do not match node by node get a common
    /// refinement, and the case a note that says what that changed.
    ///
    /// # Errors
    /// See [`Case::build_bodies`] and [`Case::build_interface`]; surfaces without a common refinement.
    pub fn build_problem(&mut self) -> Result<ContactProblem, CaseError> {
        let problem = self.build_matching()?;
        self.note_corner(&problem);
        self.note_gap_change(&problem);
        for pair in &problem.contacts {
            self.check_lambda(pair.bodies.map(|b| &problem.bodies[b]), &pair.interface)?;
        }
        Ok(problem)
    }

    /// Says how the normal is chosen at a corner of the contact line.
    fn note_corner(&mut self, problem: &ContactProblem) {
        if self.contact.normal.is_some() {
            return;
        }
        let corner = |pair: &ContactPair| pair.interface.sharpest_corner(&problem.bodies[pair.bodies[0]]);
        for (point, degrees) in problem.contacts.iter().filter_map(corner).filter(|c| c.1 > CORNER) {
            self.add_note(format!(
                "the contact line turns by {degrees:.1} degrees at ({}, {}): the contact normal there is the mean of its two \
                 edges' normals, weighted by their lengths; finer edges round the corner off, `contact.normal` gives one \
                 direction, and more than 60 degrees are refused",
                shown(point[0]),
                shown(point[1])
            ));
        }
    }

    /// Says by how much the gap of the case moves the surfaces against those that are drawn.
    fn note_gap_change(&mut self, problem: &ContactProblem) {
        for change in problem.contacts.iter().filter_map(|pair| pair.interface.gap_change()) {
            self.note_one_gap_change(change);
        }
    }

    fn note_one_gap_change(&mut self, change: GapChange) {
        let [x, y] = change.point.map(significant).into();
        let drawn = match change.drawn {
            d if d.abs() < TOUCHING * change.used => "touching".to_owned(),
            d if d > 0.0 => format!("apart by {}", significant(d)),
            d => format!("overlapping by {}", significant(-d)),
        };
        let moved = significant((change.used - change.drawn).abs());
        self.add_note(match self.is_given("contact.gap") && !self.contact.geometric {
            true => format!(
                "contact.gap overrides the meshes and moves the surfaces by at most {moved}: at ({x}, {y}) they are drawn \
                 {drawn}, and the gap is {}",
                significant(change.used)
            ),
            false => format!(
                "the surfaces are drawn {drawn} at ({x}, {y}), the largest value: this is within the round-off of the meshes or \
                 the accuracy of their bent sides, and is closed"
            ),
        });
    }

    fn build_matching(&mut self) -> Result<ContactProblem, CaseError> {
        let bodies = self.build_bodies()?;
        self.note_cuts(&bodies);
        let Ok(bodies) = <[Body; 2]>::try_from(bodies) else { unreachable!("a case has two bodies") };
        match self.pair([&bodies[0], &bodies[1]]) {
            Ok(interface) => return Ok(ContactProblem::between(bodies, interface)),
            Err(error) if error.is_mismatch() => {}
            Err(error) => return Err(self.swap_names(self.interface_diagnostic(&error)).into()),
        }
        let (gap, normal) = self.gap_and_normal();
        let [a, b] = &self.contact.surfaces;
        let lengths = [length(&bodies[0], a), length(&bodies[1], b)];
        let common = common_refinement(bodies, [a, b], normal)
            .map_err(|error| CaseError::from(self.swap_names(self.refinement_diagnostic(&error))))?;
        let interface = ContactInterface::pair_refined(&common, [a, b], &gap, normal)
            .map_err(|error| CaseError::from(self.swap_names(self.interface_diagnostic(&error))))?;
        if let Some(changes) = &common.changes {
            let mut note = self.changes_note(changes, lengths);
            if self.contact.geometric && common.facing.iter().any(|f| f.sagitta > BENT * f.spacing) {
                note += "; the gap is measured between smooth curves through the nodes of each";
            }
            self.add_note(note);
        }
        Ok(ContactProblem::between(common.bodies, interface))
    }

    /// Helps if the two names of `contact.surfaces` fit the other way round.
    fn swap_names(&self, fault: Diagnostic) -> Diagnostic {
        let [b, a] = &self.contact.surfaces;
        let (gap, normal) = self.gap_and_normal();
        let fits = |bodies: Vec<Body>| {
            let Ok(bodies) = <[Body; 2]>::try_from(bodies) else { return false };
            let [first, second] = &bodies;
            match ContactInterface::pair_along(first, second, [a, b], &gap, normal) {
                Ok(_) => true,
                Err(error) if error.is_mismatch() => {
                    common_refinement(bodies, [a, b], normal).is_ok_and(|common| {
                        ContactInterface::pair_refined(&common, [a, b], &gap, normal).is_ok()
                    })
                }
                Err(_) => false,
            }
        };
        let swapped = a != b && self.build_bodies().is_ok_and(fits);
        if swapped {
            fault.help(Some(format!("swap the two names: `surfaces = [\"{a}\", \"{b}\"]`")))
        } else {
            fault
        }
    }

    /// * `lengths`: of the surfaces as they were.
    fn changes_note(&self, changes: &Changes, lengths: [f64; 2]) -> String {
        let body = |b: usize| {
            let added = changes.added[b];
            let (name, snapped) = (&self.bodies[b].name, changes.snapped[b]);
            let mut text = format!("\"{name}\" {} added, {snapped} snapped", counted(added, "node"));
            if snapped > 0 {
                text += &format!(
                    " (moved along the surface by at most {})",
                    significant(changes.largest_move[b])
                );
            }
            if changes.free[b] > 0.0 {
                let [free, whole] = [changes.free[b], lengths[b]].map(significant);
                text += &format!(", a length of {free} of {whole} faces nothing and is free");
            }
            text
        };
        let [before, after] = [changes.angle_before, changes.smallest_angle].map(|a| a[0].min(a[1]));
        format!(
            "the contact surfaces do not match and were refined in common: {}; {}; smallest angle there {after:.1} degrees \
             (before: {before:.1})",
            body(0),
            body(1)
        )
    }

    /// Attributes an error of the common refinement to `[contact]`; bodies are called by their names.
    fn refinement_diagnostic(&self, error: &CommonRefinementError) -> Diagnostic {
        let (path, body) = match error {
            CommonRefinementError::NoSurface { body, .. }
            | CommonRefinementError::Mesh { body, .. }
            | CommonRefinementError::Body { body, .. } => (format!("contact.surfaces.{body}"), Some(*body)),
            _ => ("contact.surfaces".to_owned(), None),
        };
        let message = format!("the surfaces do not match: {}", self.with_name(error, body));
        let (expected, fix) = cures::of_refinement(error);
        self.diagnostic(code::CONTACT, &path, message).expected(expected).fix(fix)
    }
}

/// Adds up the edges of a side.
fn length(body: &Body, side: &str) -> f64 {
    let edges = body.mesh().group(side).unwrap_or(&[]).iter();
    edges.map(|&edge| body.mesh().edge_ends(edge)).map(|[p, q]| norm(q - p)).sum()
}
