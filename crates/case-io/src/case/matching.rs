//! The problem of a case: its bodies as they are if their contact surfaces match, refined to match if they do not.

use super::pair_notes::PairNote;
use super::{Case, cures};
use crate::diagnostic::{CaseError, Diagnostic, code, significant};
use fem_core::body::Body;
use fem_core::geometry::{norm, shown};
use fem_core::interface::common_refinement::{
    Changes, CommonRefinementError, Measured, Surfaces, common_refinement, common_refinements,
};
use fem_core::interface::{
    ContactInterface, ContactProblem, FacingSide, GapChange, InterfaceError, facing_edges,
};
use fem_core::mesh::id::EdgeId;
use mesh_io::words::counted;
use std::collections::{BTreeSet, HashMap};

/// Surfaces whose edges are farther from a smooth curve, in their lengths, are bent.
const BENT: f64 = 1e-6;
/// Surfaces closer than this part of the gap are drawn touching.
const TOUCHING: f64 = 1e-6;
/// Corners of the contact line from this angle on, in degrees, get a note.
const CORNER: f64 = 30.0;
/// A pair is refined at most this often: another pair of the same body may put nodes on its line.
const MOST_REFINEMENTS: usize = 4;

/// The bodies of a case while their contact surfaces are made to match.
struct Meshes {
    bodies: Vec<Body>,
    /// The contact sides of each pair: the sides in the case, or copies that belong to the pair alone.
    sides: Vec<Vec<String>>,
    /// The common refinement of each pair, as it was measured; `None` if the nodes of its surfaces match.
    measured: Vec<Option<Measured>>,
    /// The note about each common refinement.
    notes: Vec<Option<PairNote>>,
}

impl Case {
    /// Makes the contact problem, bodies in the file's order. A corner of the contact line gets a note.
    /// Contact surfaces that do not match node by node get a common refinement, and the case a note that says
    /// what that changed.
    ///
    /// # Errors
    /// See [`Case::build_bodies`] and [`Case::build_interface`]; surfaces without a common refinement.
    pub fn build_problem(&mut self) -> Result<ContactProblem, CaseError> {
        let problem = self.build_matching()?;
        self.note_corner(&problem);
        self.note_gap_change(&problem);
        for (k, pair) in problem.contacts.iter().enumerate() {
            self.check_lambda(k, &problem.bodies, &pair.interface)?;
        }
        Ok(problem)
    }

    /// Says how the normal is chosen at a corner of a contact line.
    fn note_corner(&mut self, problem: &ContactProblem) {
        for (k, pair) in problem.contacts.iter().enumerate() {
            let averaged = self.contacts[k].normal.is_none() && self.contacts[k].obstacle.is_none();
            let corner = || pair.interface.sharpest_corner(&problem.bodies[pair.body]);
            let Some((point, degrees)) = averaged.then(corner).flatten().filter(|c| c.1 > CORNER) else {
                continue;
            };
            let path = &self.contacts[k].path;
            self.add_note(format!(
                "the contact line turns by {degrees:.1} degrees at ({}, {}): the contact normal there is the mean of its two \
                 edges' normals, weighted by their lengths; finer edges round the corner off, a `[[body.curve]]` of both \
                 bodies beside it makes it a corner with two normals, `{path}.normal` gives one direction, and more than 60 \
                 degrees are refused",
                shown(point[0]),
                shown(point[1])
            ));
        }
    }

    /// Says by how much the gap of the case moves the surfaces against those that are drawn.
    fn note_gap_change(&mut self, problem: &ContactProblem) {
        for (k, pair) in problem.contacts.iter().enumerate() {
            if let Some(change) = pair.interface.gap_change() {
                self.note_one_gap_change(k, change);
            }
        }
    }

    fn note_one_gap_change(&mut self, contact: usize, change: GapChange) {
        let [x, y] = change.point.map(significant).into();
        let drawn = match change.drawn {
            d if d.abs() < TOUCHING * change.used => "touching".to_owned(),
            d if d > 0.0 => format!("apart by {}", significant(d)),
            d => format!("overlapping by {}", significant(-d)),
        };
        let moved = significant((change.used - change.drawn).abs());
        let given = &self.contacts[contact];
        let path = format!("{}.gap", given.path);
        self.add_note(match self.is_given(&path) && !given.geometric {
            true => format!(
                "{path} overrides the meshes and moves the surfaces by at most {moved}: at ({x}, {y}) they are drawn \
                 {drawn}, and the gap is {}",
                significant(change.used)
            ),
            false => format!(
                "the surfaces are drawn {drawn} at ({x}, {y}), the largest value: this is within the round-off of the meshes or \
                 the accuracy of their bent sides, and is closed"
            ),
        });
    }

    /// Makes the bodies and pairs them. If the surfaces of a pair do not match, they are refined in common.
    fn build_matching(&mut self) -> Result<ContactProblem, CaseError> {
        let bodies = self.build_bodies()?;
        let count = self.contacts.len();
        let notes = (0..count).map(|_| None).collect();
        let mut meshes = Meshes { sides: Vec::new(), measured: vec![None; count], notes, bodies };
        self.separate_sides(&mut meshes);
        let interfaces = self.matching_interfaces(&mut meshes)?;
        self.note_cuts(&meshes.bodies);
        let notes = meshes.notes.into_iter().flatten().collect();
        self.joined(notes).into_iter().for_each(|note| self.add_note(note));
        let mut problem = ContactProblem::new(meshes.bodies);
        for (given, interface) in self.contacts.iter().zip(interfaces) {
            problem = match (&given.obstacle, &given.bodies[..]) {
                (None, [a, b]) => problem.contact([*a, *b], interface),
                (Some(obstacle), [a]) => problem.obstacle(*a, interface, obstacle.of_core()),
                _ => unreachable!("the reader has refused a pair of {:?}", given.bodies),
            };
        }
        for (k, given) in self.contacts.iter().enumerate() {
            if let Some(friction) = &given.friction {
                problem = problem
                    .with_friction(k, friction.of_core())
                    .map_err(|error| CaseError::from(self.interface_diagnostic(k, &error)))?;
            }
        }
        Ok(problem)
    }

    /// Pairs the surfaces of all pairs, those that do not match after a common refinement: then all pairs of the changed bodies are made again.
    fn matching_interfaces(&self, meshes: &mut Meshes) -> Result<Vec<ContactInterface>, CaseError> {
        let count = self.contacts.len();
        let mut of_body: HashMap<usize, Vec<usize>> = HashMap::new();
        for (k, contact) in self.contacts.iter().enumerate() {
            contact.bodies.iter().for_each(|b| of_body.entry(*b).or_default().push(k));
        }
        let mut refined = vec![0; count];
        let mut interfaces: Vec<Option<ContactInterface>> = (0..count).map(|_| None).collect();
        let mut missing: Vec<usize> = (0..count).collect();
        while !missing.is_empty() {
            // The pairs that are to be refined, each with the reason.
            let mut waiting: Vec<(usize, InterfaceError)> = Vec::new();
            let mut again = BTreeSet::new();
            for k in missing {
                let error = match self.interface(k, meshes) {
                    Ok(interface) => {
                        interfaces[k] = Some(interface);
                        continue;
                    }
                    Err(error) => error,
                };
                again.insert(k);
                let first = refined[k] == 0;
                let apart = matches!(error, InterfaceError::NotFacing { .. }) && first;
                if apart && self.take_facing(k, meshes) {
                    continue;
                }
                let occupied = matches!(error, InterfaceError::Occupied { .. }) && first;
                let mismatch = error.is_mismatch() && refined[k] < MOST_REFINEMENTS;
                if self.contacts[k].obstacle.is_none() && (occupied || mismatch) {
                    waiting.push((k, error));
                } else if again.len() == 1 {
                    return Err(self.swap_names(k, self.interface_diagnostic(k, &error)).into());
                }
            }
            for body in self.refine(&waiting, &mut refined, meshes)? {
                // Pairs of one body may share nodes.
                again.extend(of_body.get(&body).into_iter().flatten());
            }
            missing = again.into_iter().collect();
        }
        Ok(interfaces.into_iter().flatten().collect())
    }

    /// Gives pairs that share a side, and pairs with a side on which something acts, sides of their own: each takes what faces
    /// it, and the rest keeps its conditions.
    fn separate_sides(&self, meshes: &mut Meshes) {
        let mut uses: HashMap<(usize, &str), usize> = HashMap::new();
        for (b, side) in self.contacts.iter().flat_map(|c| c.bodies.iter().zip(&c.surfaces)) {
            *uses.entry((*b, side)).or_default() += 1;
        }
        meshes.sides = self.contacts.iter().map(|contact| contact.surfaces.clone()).collect();
        let mut known: HashMap<(usize, &str), FacingSide> = HashMap::new();
        for (k, contact) in self.contacts.iter().enumerate() {
            let shared = |(&b, side): (&usize, &String)| {
                let body = &meshes.bodies[b];
                let edges = body.mesh().group(side).unwrap_or(&[]);
                uses[&(b, side.as_str())] > 1 || edges.iter().any(|edge| !body.is_free(*edge))
            };
            let ([a, b], [first, second]) = (&contact.bodies[..], &contact.surfaces[..]) else { continue };
            if contact.bodies.iter().zip(&contact.surfaces).any(shared) {
                let both = [(*a, first.as_str()), (*b, second.as_str())];
                for of in both {
                    known.entry(of).or_insert_with(|| FacingSide::new(&meshes.bodies[of.0], of.1));
                }
                self.take_edges(k, meshes, facing_edges(both.map(|of| &known[&of])));
            }
        }
    }

    /// Gives a pair sides of its own, with the edges that face each other. Tells whether there are any, and fewer than
    /// before.
    fn take_facing(&self, contact: usize, meshes: &mut Meshes) -> bool {
        // Against an obstacle the pairing itself takes what faces it.
        let ([a, b], [first, second]) = (&self.contacts[contact].bodies[..], &meshes.sides[contact][..])
        else {
            return false;
        };
        let sides =
            [(*a, first), (*b, second)].map(|(body, side)| FacingSide::new(&meshes.bodies[body], side));
        let edges = facing_edges(sides.each_ref());
        self.take_edges(contact, meshes, edges)
    }

    fn take_edges(&self, contact: usize, meshes: &mut Meshes, edges: [Vec<EdgeId>; 2]) -> bool {
        let given = &self.contacts[contact];
        let sides = &meshes.sides[contact];
        let before = given.bodies.iter().zip(sides).map(|(b, side)| meshes.bodies[*b].mesh().group(side));
        let fewer = before.zip(&edges).any(|(before, now)| before.is_some_and(|all| all.len() > now.len()));
        if edges.iter().any(Vec::is_empty) {
            return false;
        }
        for (member, edges) in edges.into_iter().enumerate() {
            let own = format!("{} in contact {}", given.surfaces[member], given.name);
            meshes.bodies[given.bodies[member]].add_group(&own, edges);
            meshes.sides[contact][member] = own;
        }
        fewer
    }

    /// Pairs the surfaces of a pair, which may have been refined in common.
    fn interface(&self, contact: usize, meshes: &Meshes) -> Result<ContactInterface, InterfaceError> {
        let (gap, normal) = self.gap_and_normal(contact);
        let given = &self.contacts[contact];
        match (&given.obstacle, &given.bodies[..], &meshes.sides[contact][..]) {
            (None, [a, b], [first, second]) => {
                let bodies = [&meshes.bodies[*a], &meshes.bodies[*b]];
                match &meshes.measured[contact] {
                    Some(measured) => {
                        ContactInterface::pair_measured(bodies, measured, [first, second], &gap, normal)
                    }
                    None => ContactInterface::pair_along(bodies[0], bodies[1], [first, second], &gap, normal),
                }
            }
            (Some(obstacle), [a], [side]) => {
                let given = self.is_given(&format!("{}.gap", given.path));
                let gap = given.then_some(&gap);
                ContactInterface::against(&meshes.bodies[*a], side, &obstacle.of_core(), gap)
            }
            _ => unreachable!("the reader has refused a pair of {:?}", given.bodies),
        }
    }

    /// Refines the surfaces of pairs in common, of several at once if they are apart, and returns the bodies that were changed.
    ///
    /// * `waiting`: pairs of bodies, each with the reason why it must be refined; `refined`: how often each pair was refined.
    fn refine(
        &self,
        waiting: &[(usize, InterfaceError)],
        refined: &mut [usize],
        meshes: &mut Meshes,
    ) -> Result<BTreeSet<usize>, CaseError> {
        let sides = meshes.sides.clone();
        let surfaces =
            |(k, _): &(usize, InterfaceError)| match (&self.contacts[*k].bodies[..], &sides[*k][..]) {
                ([a, b], [first, second]) => Some(Surfaces {
                    bodies: [*a, *b],
                    groups: [first, second],
                    normal: self.gap_and_normal(*k).1,
                }),
                _ => None,
            };
        let surfaces: Vec<Surfaces<'_>> = waiting.iter().filter_map(surfaces).collect();
        let length =
            |pair: &Surfaces<'_>| [0, 1].map(|b| length(&meshes.bodies[pair.bodies[b]], pair.groups[b]));
        let lengths: Vec<[f64; 2]> = surfaces.iter().map(length).collect();
        let mut changed = BTreeSet::new();
        for (place, found) in common_refinements(&mut meshes.bodies, &surfaces) {
            let (contact, error) = &waiting[place];
            refined[*contact] += 1;
            match found {
                Ok((measured, changes)) => {
                    let note = |changes| self.refinement_note(*contact, &changes, &measured, lengths[place]);
                    if let Some(note) = changes.map(note) {
                        meshes.notes[*contact] = Some(note);
                    }
                    meshes.measured[*contact] = Some(measured);
                    changed.extend(surfaces[place].bodies);
                }
                // Sides that face each other only in part.
                Err(_) if refined[*contact] == 1 && self.take_facing(*contact, meshes) => {}
                // The load on the side is what the user can change.
                Err(_) if matches!(error, InterfaceError::Occupied { .. }) => {
                    return Err(self.interface_diagnostic(*contact, error).into());
                }
                Err(fault) => {
                    return Err(self
                        .swap_names(*contact, self.refinement_diagnostic(*contact, &fault))
                        .into());
                }
            }
        }
        for &b in &changed {
            // A part of a side may end at a new node.
            let body = meshes.bodies[b].reselected();
            meshes.bodies[b] = body.map_err(|error| self.body_diagnostic(b, &error))?;
        }
        Ok(changed)
    }

    /// Says what a common refinement changed.
    ///
    /// * `lengths`: of the surfaces as they were.
    fn refinement_note(
        &self,
        contact: usize,
        changes: &Changes,
        measured: &Measured,
        lengths: [f64; 2],
    ) -> PairNote {
        let given = &self.contacts[contact];
        let bent = given.geometric && measured.facing.iter().flatten().any(|f| f.sagitta > BENT * f.spacing);
        let more =
            if bent { "; the gap is measured between smooth curves through the nodes of each" } else { "" };
        let names: Vec<String> =
            given.bodies.iter().map(|body| format!("\"{}\"", self.bodies[*body].name)).collect();
        let note = |names: [&str; 2]| changes_note(names, changes, lengths) + more;
        let shared = note(["first body", "second body"]);
        let alone = match &names[..] {
            [first, second] => note([first, second]),
            _ => shared.clone(),
        };
        PairNote { contact, alone, shared }
    }

    /// Helps if the two names of `surfaces` fit the other way round.
    fn swap_names(&self, contact: usize, fault: Diagnostic) -> Diagnostic {
        let given = &self.contacts[contact];
        let ([first, second], [b, a]) = (&given.bodies[..], &given.surfaces[..]) else { return fault };
        let (gap, normal) = self.gap_and_normal(contact);
        let fits = |bodies: Vec<Body>| {
            let pair = [&bodies[*first], &bodies[*second]];
            match ContactInterface::pair_along(pair[0], pair[1], [a, b], &gap, normal) {
                Ok(_) => true,
                Err(error) if error.is_mismatch() => common_refinement(pair.map(Body::clone), [a, b], normal)
                    .is_ok_and(|common| {
                        ContactInterface::pair_refined(&common, [a, b], &gap, normal).is_ok()
                    }),
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

    /// Attributes an error of the common refinement to the table of the pair; bodies are called by their names.
    fn refinement_diagnostic(&self, contact: usize, error: &CommonRefinementError) -> Diagnostic {
        let (key, side) = match error {
            CommonRefinementError::NoSurface { body, .. }
            | CommonRefinementError::Mesh { body, .. }
            | CommonRefinementError::Body { body, .. } => (format!("surfaces.{body}"), Some(*body)),
            _ => ("surfaces".to_owned(), None),
        };
        let message = format!("the surfaces do not match: {}", self.with_name(contact, error, side));
        let (expected, fix) = cures::of_refinement(error);
        let path = format!("{}.{key}", self.contacts[contact].path);
        self.diagnostic(code::CONTACT, &path, message).expected(expected).fix(fix)
    }
}

/// Says what a common refinement changed.
///
/// * `names`: of the two bodies; `lengths`: of the surfaces as they were.
fn changes_note(names: [&str; 2], changes: &Changes, lengths: [f64; 2]) -> String {
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

/// Adds up the edges of a side.
fn length(body: &Body, side: &str) -> f64 {
    let edges = body.mesh().group(side).unwrap_or(&[]).iter();
    edges.map(|&edge| body.mesh().edge_ends(edge)).map(|[p, q]| norm(q - p)).sum()
}
