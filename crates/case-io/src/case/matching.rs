//! The problem of a case: its bodies as they are where their contact surfaces match, refined to match where they do not.

use super::Case;
use crate::diagnostic::{CaseError, Diagnostic, code};
use fem_core::interface::ContactProblem;
use fem_core::interface::common_refinement::{Changes, CommonRefinementError, common_refinement};

impl Case {
    /// Makes the contact problem, bodies in the file's order. Contact surfaces that do not match node by node get a common
    /// refinement, and the case a note that says what that changed.
    ///
    /// # Errors
    /// See [`Case::build_bodies`] and [`Case::build_interface`]; surfaces without a common refinement.
    pub fn build_problem(&mut self) -> Result<ContactProblem, CaseError> {
        let problem = self.build_matching()?;
        self.check_lambda([&problem.bodies[0], &problem.bodies[1]], &problem.interface)?;
        Ok(problem)
    }

    fn build_matching(&mut self) -> Result<ContactProblem, CaseError> {
        let bodies = self.build_bodies()?;
        let mismatch = match self.pair([&bodies[0], &bodies[1]])? {
            Ok(interface) => return Ok(ContactProblem { bodies, interface }),
            Err(error) if error.is_mismatch() => error,
            Err(error) => return Err(self.interface_diagnostic(&error).into()),
        };
        let [a, b] = &self.contact.surfaces;
        let common = common_refinement(bodies, [a, b])
            .map_err(|error| CaseError::from(self.refinement_diagnostic(&error)))?;
        // Nodes that face each other and do not match stand too far apart.
        let changes = common.changes.ok_or_else(|| CaseError::from(self.interface_diagnostic(&mismatch)))?;
        let bodies = common.bodies;
        match self.pair([&bodies[0], &bodies[1]])? {
            Ok(interface) => {
                self.add_note(self.changes_note(&changes));
                Ok(ContactProblem { bodies, interface })
            }
            Err(error) => Err(self.interface_diagnostic(&error).into()),
        }
    }

    fn changes_note(&self, changes: &Changes) -> String {
        let body = |b: usize| {
            let added = changes.added[b];
            let mut text = format!(
                "\"{}\" {added} {} added, {} snapped",
                self.bodies[b].name,
                if added == 1 { "node" } else { "nodes" },
                changes.snapped[b]
            );
            if changes.free[b] > 0.0 {
                text += &format!(", {:.3e} of the surface faces nothing and is free", changes.free[b]);
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

    /// Brings an error of the common refinement back to `[contact]`; bodies are called by their names.
    fn refinement_diagnostic(&self, error: &CommonRefinementError) -> Diagnostic {
        let (path, body) = match error {
            CommonRefinementError::NoSurface { body, .. }
            | CommonRefinementError::Closed { body, .. }
            | CommonRefinementError::Mesh { body, .. }
            | CommonRefinementError::Body { body, .. } => (format!("contact.surfaces.{body}"), Some(*body)),
            _ => ("contact.surfaces".to_owned(), None),
        };
        let mut message = format!("the surfaces do not match: {error}");
        if let Some(body) = body.and_then(|b| self.bodies.get(b).map(|case| (b, case))) {
            message = message.replacen(&format!("body {}", body.0), &format!("body \"{}\"", body.1.name), 1);
        }
        self.diagnostic(code::CONTACT, &path, message)
    }
}
