//! A contact problem of solids and the names of their sides: surfaces that do not match are laid over each other.

use super::contacts::{Contact, Paired, PairingError, Sides, assembled};
use super::overlay::{OverlayChanges, OverlayError, overlay};
use super::solid_pairs::{Known, is_curved, pair_known, solid_against};
use super::{ContactNormal, pairing};
use fem_core::body::Body;
use fem_core::interface::{ContactInterface, InterfaceError};
use fem_core::space::Solid;

/// A pair is laid over itself at most this often: another pair of the same body may cut its rim.
const MOST_OVERLAYS: usize = 4;

/// Pairs the sides of solids. Two surfaces whose nodes do not match are laid over each other, and both bodies are cut there; what does not face the
/// other surface is free.
///
/// * `contacts`: a normal that is given is the direction along which the surfaces are laid over each other.
///
/// # Errors
/// Surfaces that cannot be paired and have no overlay, a law of friction that makes no sense, and conditions that do not fit a cut mesh.
///
/// # Panics
/// If there is no such body.
pub fn paired_solids(
    bodies: Vec<Body<Solid>>,
    contacts: &[Contact<Solid>],
) -> Result<Paired<Solid>, PairingError> {
    let sides = contacts.iter().map(|c| c.sides.members().map(|(_, side)| side.clone()).collect());
    let mut pairs = Pairs {
        contacts,
        sides: sides.collect(),
        known: vec![None; contacts.len()],
        changes: vec![None; contacts.len()],
        bodies,
    };
    let interfaces = pairs.interfaces()?;
    let problem = assembled(pairs.bodies, contacts, interfaces)?;
    Ok(Paired { overlaid: pairs.changes, ..Paired::of(problem) })
}

/// Bodies while their contact surfaces are made to match.
struct Pairs<'a> {
    contacts: &'a [Contact<Solid>],
    bodies: Vec<Body<Solid>>,
    /// The contact sides of each pair: the sides given, or those that an overlay named.
    sides: Vec<Vec<String>>,
    known: Vec<Option<Known>>,
    changes: Vec<Option<OverlayChanges>>,
}

impl Pairs<'_> {
    /// Pairs the surfaces of all pairs, those that do not match after an overlay: then the other pairs of its bodies are made again.
    fn interfaces(&mut self) -> Result<Vec<ContactInterface<Solid>>, PairingError> {
        let count = self.contacts.len();
        let mut overlays = vec![0; count];
        let mut interfaces: Vec<Option<ContactInterface<Solid>>> = (0..count).map(|_| None).collect();
        let mut missing: Vec<usize> = (0..count).collect();
        while !missing.is_empty() {
            let mut changed = vec![false; self.bodies.len()];
            for pair in missing {
                let error = match self.interface(pair) {
                    Ok(interface) => {
                        interfaces[pair] = Some(interface);
                        continue;
                    }
                    Err(error) => error,
                };
                let helps = error.is_mismatch() || matches!(error, InterfaceError::Occupied { .. });
                let Sides::Bodies { bodies, .. } = &self.contacts[pair].sides else {
                    return Err(PairingError::Interface { pair, error });
                };
                if !helps || overlays[pair] == MOST_OVERLAYS {
                    return Err(PairingError::Interface { pair, error });
                }
                overlays[pair] += 1;
                self.overlay(pair)?;
                bodies.iter().for_each(|body| changed[*body] = true);
            }
            let is_changed = |pair: &usize| self.contacts[*pair].sides.members().any(|(b, _)| changed[b]);
            missing = (0..count).filter(is_changed).collect();
        }
        Ok(interfaces.into_iter().flatten().collect())
    }

    fn interface(&self, pair: usize) -> Result<ContactInterface<Solid>, InterfaceError> {
        match &self.contacts[pair].sides {
            Sides::Bodies { bodies, gap, .. } => {
                let bodies = bodies.map(|b| &self.bodies[b]);
                let surfaces = [&*self.sides[pair][0], &*self.sides[pair][1]];
                pair_known(bodies, surfaces, gap, self.known[pair].as_ref())
            }
            Sides::Obstacle { body, surface, obstacle, gap } => {
                solid_against(&self.bodies[*body], surface, obstacle, gap.as_ref())
            }
        }
    }

    /// Lays the surfaces of a pair over each other.
    fn overlay(&mut self, pair: usize) -> Result<(), PairingError> {
        let Contact { name, sides, .. } = &self.contacts[pair];
        let Sides::Bodies { bodies: numbers, surfaces, gap, normal } = sides else { return Ok(()) };
        let bodies = numbers.map(|b| &self.bodies[b]);
        let fault = |error: OverlayError| match error {
            OverlayError::Interface(error) => PairingError::Interface { pair, error },
            error => PairingError::Overlay { pair, error },
        };
        let group = |k: usize| {
            let found = pairing::group(bodies[k], k, &self.sides[pair][k]);
            found.map_err(|error| PairingError::Interface { pair, error })
        };
        let faces = [group(0)?, group(1)?];
        if gap.is_measured() && is_curved(bodies, faces) {
            return Err(fault(OverlayError::MeasuredGap));
        }
        let direction = match normal {
            ContactNormal::Averaged => None,
            ContactNormal::Fixed(direction) => Some(*direction),
        };
        let own = [0, 1].map(|k: usize| format!("{} in contact {name}", surfaces[k]));
        let found = overlay(bodies, faces, own.each_ref().map(String::as_str), direction).map_err(fault)?;
        for (b, body) in numbers.iter().zip(found.bodies) {
            self.bodies[*b] = body;
        }
        self.sides[pair] = own.to_vec();
        self.known[pair] = Some(found.known);
        self.changes[pair] = Some(found.changes.after(self.changes[pair]));
        Ok(())
    }
}
