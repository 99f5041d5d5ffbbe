//! The problem of a case: its bodies, paired by fem-core, with errors at the places of their keys, and notes.

use super::pair_notes::PairNote;
use super::{Case, Dimension, Friction, fixes};
use crate::diagnostic::{CaseError, Diagnostic, code, significant};
use contact_geometry::common_refinement::CommonRefinementError;
use contact_geometry::{PairingError, Refined, Sides};
use fem_core::body::Body;
use fem_core::geometry::{Coordinates, Point, shown};
use fem_core::interface::{BondError, Bonds, ContactPair, ContactProblem, GapChange, InterfaceError};
use mesh_io::words::counted;
use std::collections::HashSet;

/// Surfaces closer than this part of the gap are drawn touching.
const TOUCHING: f64 = 1e-6;
/// Corners of the contact line from this angle on, in degrees, get a note.
const CORNER: f64 = 30.0;

/// Notes about a problem, each once.
pub type Notes = Vec<String>;

impl<S: Dimension> Case<S> {
    /// Makes the contact problem, bodies in the file's order, and says what is worth knowing about it: how the meshes were read,
    /// corners of the contact line, and what was changed so that contact surfaces match.
    ///
    /// # Errors
    /// See [`Case::build_bodies`]; surfaces that cannot be paired, at the place of the key that causes it, and a `solver.lambda`
    /// that is not finite at one of their nodes.
    pub fn build(&self) -> Result<(ContactProblem<S>, Notes), CaseError> {
        let contacts = (0..self.contacts.len()).map(|k| self.contact(k));
        let contacts = contacts.collect::<Result<Vec<contact_geometry::Contact<S>>, CaseError>>()?;
        let paired = S::pair(self.build_bodies()?, &contacts);
        let paired = paired.map_err(|error| self.pairing_diagnostic(&contacts, &error))?;
        let mut notes = self.mesh_notes().to_vec();
        notes.extend(S::notes(self, &paired));
        let problem = paired.problem;
        let pairs = || problem.contacts.iter().enumerate();
        let changes = pairs().filter_map(|(k, pair)| Some((k, pair.interface.gap_change()?)));
        notes.extend(changes.map(|(k, change)| self.gap_change_note(k, change)));
        for (k, pair) in pairs() {
            self.check_lambda(k, &problem.bodies, &pair.interface)?;
        }
        Bonds::new(&problem).map_err(|error| self.bond_diagnostic(&error))?;
        if let Some((pair, point)) = problem.contact_across_cut() {
            return Err(self.contact_across_cut(pair, point.into()).into());
        }
        let mut known = HashSet::new();
        notes.retain(|note| known.insert(note.clone()));
        Ok((problem, notes))
    }

    /// Refuses a pair whose contact continues across a cut.
    fn contact_across_cut(&self, pair: usize, point: Point) -> Diagnostic {
        let given = &self.contacts[pair];
        let message = format!(
            "the pair \"{}\": its contact continues across a cut at {point}, and is pressed or rubbed along the axis of the cut there",
            given.name
        );
        let expected = "a rim of the cut without contact, or with contact perpendicular to its axis and without friction";
        self.diagnostic(code::CONTACT, &given.path, message)
            .expected(expected)
            .fix("move the plane of the cut away from the contact")
    }

    /// Attributes an error of bonded bodies to the pair that it names; bodies are called by their names.
    fn bond_diagnostic(&self, error: &BondError) -> CaseError {
        let given = &self.contacts[error.pair()];
        let message = error.to_string();
        let message = message.split_once(": ").map_or(message.as_str(), |(_, message)| message);
        let message = format!("the pair \"{}\": {message}", given.name);
        let (expected, fix) = fixes::of_bonds(error);
        self.diagnostic(code::CONTACT, &given.path, message).expected(expected).fix(fix).into()
    }

    /// Describes a pair for fem-core.
    ///
    /// # Errors
    /// Numbers of bodies and surfaces that the reader would have refused: a program may have changed them since.
    fn contact(&self, contact: usize) -> Result<contact_geometry::Contact<S>, CaseError> {
        let given = &self.contacts[contact];
        let (gap, normal) = self.gap_and_normal(contact);
        let sides = match (&given.obstacle, &given.bodies[..], &given.surfaces[..]) {
            (None, &[a, b], [first, second]) => {
                Sides::Bodies { bodies: [a, b], surfaces: [first.clone(), second.clone()], gap, normal }
            }
            (Some(obstacle), &[body], [surface]) => {
                let gap = self.is_given(&format!("{}.gap", given.path)).then_some(gap);
                Sides::Obstacle { body, surface: surface.clone(), obstacle: obstacle.of_core(), gap }
            }
            (_, bodies, surfaces) => {
                let message = format!("a pair of the bodies {bodies:?} and the surfaces {surfaces:?}");
                let fault = self.diagnostic(code::CONTACT, &given.path, message);
                let fault = fault.expected("a surface of each of two bodies, or of one against an obstacle");
                return Err(fault.fix("give as many bodies as surfaces").into());
            }
        };
        let friction = given.friction.as_ref().map(Friction::of_core);
        Ok(contact_geometry::Contact { name: given.name.clone(), sides, friction })
    }

    /// Attributes an error of the pairing to the key that causes it.
    fn pairing_diagnostic(
        &self,
        contacts: &[contact_geometry::Contact<S>],
        error: &PairingError,
    ) -> CaseError {
        let swapped = |pair: usize, fault| self.swap_names(&contacts[pair], fault).into();
        match error {
            // A load on a side and a law of friction have nothing to do with the names of the surfaces.
            PairingError::Interface {
                pair,
                error:
                    error @ (InterfaceError::Occupied { .. }
                    | InterfaceError::HeldAgainstSlip { .. }
                    | InterfaceError::BadFrictionLimit { .. }
                    | InterfaceError::BadFrictionCoefficient { .. }),
            } => self.interface_diagnostic(*pair, error).into(),
            PairingError::Interface { pair, error } => {
                swapped(*pair, self.interface_diagnostic(*pair, error))
            }
            PairingError::Refinement { pair, error } => {
                swapped(*pair, self.refinement_diagnostic(*pair, error))
            }
            PairingError::Overlay { pair, error } => {
                let (expected, fix) = fixes::of_overlay(error);
                let path = format!("{}.surfaces", self.contacts[*pair].path);
                let fault = self.diagnostic(code::CONTACT, &path, error.to_string());
                swapped(*pair, fault.expected(expected).fix(fix))
            }
            PairingError::Body { body, error } => self.body_diagnostic(*body, error).into(),
        }
    }

    /// Says by how much the gap of the case moves the surfaces against those that are drawn.
    fn gap_change_note(&self, contact: usize, change: GapChange<S>) -> String {
        let at: Vec<String> = change.point.entries().iter().map(|x| significant(*x)).collect();
        let at = at.join(", ");
        let drawn = match change.drawn {
            d if d.abs() < TOUCHING * change.used.abs() => "touching".to_owned(),
            d if d > 0.0 => format!("apart by {}", significant(d)),
            d => format!("overlapping by {}", significant(-d)),
        };
        let moved = significant((change.used - change.drawn).abs());
        let given = &self.contacts[contact];
        let path = format!("{}.gap", given.path);
        match self.is_given(&path) && !given.geometric {
            true => format!(
                "{path} overrides the meshes and moves the surfaces by at most {moved}: at ({at}) they are drawn \
                 {drawn}, and the gap is {}",
                significant(change.used)
            ),
            false => format!(
                "the surfaces are drawn {drawn} at ({at}), the largest value: this is within the round-off of the meshes or \
                 the accuracy of their bent sides, and is closed"
            ),
        }
    }

    /// Helps if the two names of `surfaces` fit the other way round.
    fn swap_names(&self, contact: &contact_geometry::Contact<S>, fault: Diagnostic) -> Diagnostic {
        let Sides::Bodies { bodies: [first, second], surfaces: [b, a], gap, normal } = &contact.sides else {
            return fault;
        };
        let fits = |bodies: Vec<Body<S>>| S::fits([&bodies[*first], &bodies[*second]], [a, b], gap, *normal);
        let swapped = a != b && self.build_bodies().is_ok_and(fits);
        if swapped {
            fault.help(Some(format!("swap the two names: `surfaces = [\"{a}\", \"{b}\"]`")))
        } else {
            fault
        }
    }

    /// Attributes an error of the common refinement to the table of the pair; bodies are called by their names.
    fn refinement_diagnostic(&self, contact: usize, error: &CommonRefinementError) -> Diagnostic {
        let (key, side) = match error {
            CommonRefinementError::NoSurface { body, .. }
            | CommonRefinementError::Mesh { body, .. }
            | CommonRefinementError::Body { body, .. } => (format!("surfaces.{body}"), Some(*body)),
            _ => ("surfaces".to_owned(), None),
        };
        let message = format!("the surfaces do not match: {}", self.with_name(contact, error, side));
        let (expected, fix) = fixes::of_refinement(error);
        let path = format!("{}.{key}", self.contacts[contact].path);
        self.diagnostic(code::CONTACT, &path, message).expected(expected).fix(fix)
    }
}

impl Case {
    /// Says what boxes cut, what common refinements changed, and how normals at corners are chosen.
    pub(super) fn plane_notes(&self, problem: &ContactProblem, refined: &[Option<Refined>]) -> Notes {
        let mut notes = self.cut_notes(&problem.bodies);
        let refined = refined.iter().enumerate().filter_map(|(k, refined)| Some((k, refined.as_ref()?)));
        notes.extend(self.joined(refined.map(|(k, refined)| self.refinement_note(k, refined)).collect()));
        let pairs = problem.contacts.iter().enumerate();
        notes.extend(pairs.filter_map(|(k, pair)| self.corner_note(k, pair, problem)));
        notes
    }

    /// Says how the normal is chosen at a corner of a contact line.
    fn corner_note(&self, contact: usize, pair: &ContactPair, problem: &ContactProblem) -> Option<String> {
        let given = &self.contacts[contact];
        let averaged = given.normal.is_none() && given.obstacle.is_none();
        let corner = || contact_geometry::sharpest_corner(&pair.interface, &problem.bodies[pair.body]);
        let (point, degrees) = averaged.then(corner).flatten().filter(|c| c.1 > CORNER)?;
        Some(format!(
            "the contact line turns by {degrees:.1} degrees at ({}, {}): the contact normal there is the mean of its two \
             edges' normals, weighted by their lengths; finer edges round the corner off, a `[[body.curve]]` of both \
             bodies beside it makes it a corner with two normals, `{}.normal` gives one direction, and more than 60 \
             degrees are refused",
            shown(point[0]),
            shown(point[1]),
            given.path
        ))
    }

    /// Says what a common refinement changed.
    fn refinement_note(&self, contact: usize, refined: &Refined) -> PairNote {
        let given = &self.contacts[contact];
        let more = if given.geometric && refined.bent {
            "; the gap is measured between smooth curves through the nodes of each"
        } else {
            ""
        };
        let names: Vec<String> =
            given.bodies.iter().map(|body| format!("\"{}\"", self.bodies[*body].name)).collect();
        let note = |names: [&str; 2]| changes_note(names, refined) + more;
        let shared = note(["first body", "second body"]);
        let alone = match &names[..] {
            [first, second] => note([first, second]),
            _ => shared.clone(),
        };
        PairNote { contact, alone, shared }
    }
}

/// Says what a common refinement changed.
///
/// * `names`: of the two bodies.
fn changes_note(names: [&str; 2], Refined { changes, lengths, .. }: &Refined) -> String {
    let body = |b: usize| {
        let (added, snapped) = (changes.added[b], changes.snapped[b]);
        let mut parts = Vec::new();
        if added > 0 {
            parts.push(format!("{} added", counted(added, "node")));
        }
        if snapped > 0 {
            let furthest = significant(changes.largest_move[b]);
            parts.push(format!("{snapped} snapped (moved along the surface by at most {furthest})"));
        }
        if changes.free[b] > 0.0 {
            let [free, whole] = [changes.free[b], lengths[b]].map(significant);
            parts.push(format!("a length of {free} of {whole} faces nothing and is free"));
        }
        (!parts.is_empty()).then(|| format!("{} {}", names[b], parts.join(", ")))
    };
    let parts: Vec<String> = (0..2).filter_map(body).collect();
    let parts = parts.join("; ");
    if changes.added == [0; 2] && changes.snapped == [0; 2] {
        return format!("the contact surfaces do not end together: {parts}");
    }
    let [before, after] = [changes.angle_before, changes.smallest_angle].map(|a| a[0].min(a[1]));
    format!(
        "the contact surfaces do not match and were refined in common: {parts}; smallest angle there {after:.1} degrees (before: \
         {before:.1})"
    )
}
