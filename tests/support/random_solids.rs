//! Random assemblies of one to five boxes of tetrahedra, solved by the function that users call, and a judge of what it promises.
//!
//! ```text
//! number ─ family ─► assembly ─ solve: two settings, halved cells, quarters ─► one verdict for each promise
//! ```
//! There are no reference values: runs of one problem must agree. Boxes lie on one grid, so that surfaces match; halved cells lie in those before,
//! data are linear, and so the solution on a finer mesh is an admissible field of the same problem: no bound is below the distance to it.

mod adaptive;
mod build;
mod draw;
mod field;
mod grid;
mod judge;

use crate::matrix::{Promise, Verdict};
use crate::model::Made;
use crate::random::Random;
use build::{Assembly, Condition};
use certified_contact::Settings;
use contact_geometry::{OverlayError, PairingError};
use draw::Draw;
use fem_core::body::{Body, BodyError};
use fem_core::interface::{ContactPair, ContactProblem, InterfaceError};
use fem_core::space::Solid;
use nndd::NewtonSettings;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The families, each with what its problems have in common; problem `n` belongs to family `n` modulo their number.
pub const FAMILIES: [&str; 34] = [
    "one body",
    "stack",
    "boxes on a box",
    "corner of obstacles",
    "wall of boxes",
    "floating bodies",
    "plane driven by a force",
    "rigid side",
    "gap",
    "interference",
    "interference on curves",
    "contrast of moduli",
    "nearly incompressible",
    "orthotropic material",
    "given stiffness",
    "two materials in a body",
    "slivers",
    "other units",
    "early stop",
    "round obstacle",
    "floating on round obstacles",
    "round obstacle driven by a force",
    "curved contact",
    "curved contact held on both sides",
    "friction",
    "floating bodies with friction",
    "curved contact with friction",
    "round obstacle with friction",
    "floating on round obstacles with friction",
    "springs",
    "heat and forces",
    "cuts",
    draw::HELD,
    draw::BONDED,
];

/// The promises that are judged.
pub const PROMISES: [Promise; 9] = [
    Promise::Error,
    Promise::Iteration,
    Promise::Norm,
    Promise::Energy,
    Promise::Force,
    Promise::Balance,
    Promise::Status,
    Promise::Words,
    Promise::Field,
];

/// Assemblies that are drawn for a problem, at most.
const ATTEMPTS: u64 = 60;

/// A random problem, with two settings to solve it by.
#[derive(Debug)]
pub struct Problem {
    /// Its number.
    pub number: u64,
    /// Its family.
    pub family: &'static str,
    assembly: Assembly,
    first: Settings<Solid>,
    second: Settings<Solid>,
}

impl Problem {
    /// Draws the problem with a number; an assembly whose supports and contacts exclude each other is drawn again.
    ///
    /// # Errors
    /// Bodies that cannot be made: a fault of the generator.
    pub fn new(number: u64) -> Made<Self> {
        Self::of_family(number, FAMILIES[(number % FAMILIES.len() as u64) as usize])
    }

    /// Tells if there are spheres or cylinders.
    fn is_round(&self) -> bool {
        self.assembly
            .parts
            .iter()
            .flat_map(|part| part.sides)
            .any(|side| matches!(side, Condition::Round(..)))
    }

    /// Draws the problem with a number as one of a family.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_family(number: u64, family: &'static str) -> Made<Self> {
        for attempt in 0..ATTEMPTS {
            let seed = 1_000_003 * number + 7_919 * attempt + 29;
            let assembly = Draw::new(seed, family).assembly()?;
            match assembly.problem(0) {
                Ok(made) if shows(&assembly, &made, family) && made.bodies.iter().all(moves) => {
                    let mut random = Random::new(seed + 1);
                    let mut first = Settings::default();
                    if family == "early stop" {
                        first = judge::random_settings(&mut random);
                    }
                    let mut second = judge::random_settings(&mut random);
                    // Only the exact method solves friction of solids and forces in cuts.
                    if made.has_friction() || made.bodies.iter().any(Body::has_cut_forces) {
                        second.method = NewtonSettings::default().into();
                    }
                    return Ok(Self { number, family, assembly, first, second });
                }
                Ok(_) => {}
                Err(error) if excluded(error.as_ref()) => {}
                Err(error) => return Err(error),
            }
        }
        Err(format!("no assembly of the family {family} in {ATTEMPTS} attempts").into())
    }
}

/// Tells if an assembly has the feature of its family: the side of a rigid side or a plane may be covered by other boxes.
fn shows(assembly: &Assembly, made: &ContactProblem<Solid>, family: &str) -> bool {
    let mut sides = assembly.parts.iter().flat_map(|part| part.sides);
    match family {
        "heat and forces" => assembly.parts.iter().all(|part| part.inside.is_some()),
        "cuts" => assembly.parts.iter().any(|part| part.cut.is_some()) && made.contact_across_cut().is_none(),
        draw::BONDED => made.contacts.iter().any(|pair| pair.is_bonded()),
        draw::HELD => assembly.touches.iter().any(|touch| touch.held.iter().flatten().any(Option::is_some)),
        "springs" => sides.any(|side| matches!(side, Condition::Springs(..))),
        "rigid side" => sides.any(|side| matches!(side, Condition::Rigid(..))),
        "plane driven by a force" => {
            sides.any(|side| matches!(side, Condition::Plane(_, build::Drive::Force(..))))
        }
        "round obstacle" | "floating on round obstacles" => {
            sides.any(|side| matches!(side, Condition::Round(..)))
        }
        "round obstacle driven by a force" => {
            sides.any(|side| matches!(side, Condition::Round(_, build::Drive::Force(..))))
        }
        "curved contact" => made
            .contacts
            .iter()
            .any(|pair| made.obstacle_of(pair).is_none() && pair.interface.has_bent_facets()),
        "curved contact held on both sides" => made
            .contacts
            .iter()
            .any(|pair| pair.interface.has_bent_facets() && !pair.interface.clamped().is_empty()),
        "interference" => made.contacts.iter().any(presses),
        "interference on curves" => {
            made.contacts.iter().any(|pair| pair.interface.has_bent_facets() && presses(pair))
        }
        "friction" | "floating bodies with friction" => made.has_friction(),
        "curved contact with friction" => {
            made.contacts.iter().any(|pair| made.obstacle_of(pair).is_none() && is_bent_and_rough(pair))
        }
        "round obstacle with friction" | "floating on round obstacles with friction" => {
            made.contacts.iter().any(|pair| made.obstacle_of(pair).is_some() && is_bent_and_rough(pair))
        }
        "two materials in a body" => assembly.parts.iter().any(|part| part.divided.is_some()),
        _ => true,
    }
}

fn presses(pair: &ContactPair<Solid>) -> bool {
    pair.interface.pairs().iter().any(|of| of.gap < 0.0)
}

fn is_bent_and_rough(pair: &ContactPair<Solid>) -> bool {
    pair.friction.acts() && pair.interface.has_bent_facets()
}

/// Tells if a body has an unknown: a node that no support holds in all directions.
fn moves(body: &Body<Solid>) -> bool {
    body.node_constraints().iter().any(|node| !node.supported().is_all())
}

/// Tells if supports, rigid sides and contacts of an assembly exclude each other.
fn excluded(error: &(dyn std::error::Error + 'static)) -> bool {
    let interface = match error.downcast_ref::<PairingError>() {
        Some(PairingError::Interface { error, .. }) => Some(error),
        Some(PairingError::Overlay { error: OverlayError::Thin { .. }, .. }) => return true,
        _ => error.downcast_ref::<InterfaceError>(),
    };
    let body = error.downcast_ref::<BodyError>();
    // A given gap closes a small distance only.
    matches!(
        interface,
        Some(
            InterfaceError::HeldNode { .. }
                | InterfaceError::ClampedOverlap { .. }
                | InterfaceError::Distance { .. }
                | InterfaceError::CoarseFace { .. }
                | InterfaceError::NotFacing { .. }
                | InterfaceError::Overlap { .. }
        )
    ) || matches!(
        body,
        Some(
            BodyError::Conflict { .. }
                | BodyError::RigidOccupied { .. }
                | BodyError::NoSurface { .. }
                | BodyError::CutMisses { .. }
                | BodyError::CutEnds { .. }
                | BodyError::CutHeld { .. }
                | BodyError::OffSurface { .. }
        )
    )
}

/// The outcome of a problem.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Its number.
    pub number: u64,
    /// Its family.
    pub family: &'static str,
    /// Nodes of the coarse mesh.
    pub nodes: usize,
    /// Pairs of bodies or of a body and a plane.
    pub pairs: usize,
    /// How often it was solved.
    pub runs: usize,
    /// How the first run ended.
    pub ended: String,
    /// Why the first run has no certificate.
    pub refused: Option<String>,
    /// `e_cre` of the first run over its distance to the solution on the finest mesh, if that is far above rounding.
    pub effectivity: Option<f64>,
    /// The largest rest of forces and moments on a body, over their size.
    pub worst: f64,
    /// The same with the forces of pairs, of exact solutions.
    pub worst_pair: f64,
    /// How many fields with errors got a bound.
    pub fields: usize,
    /// How many meshes of an adaptive run were judged.
    pub refined: usize,
    /// The verdicts.
    pub verdicts: Vec<Verdict>,
}

impl Trial {
    /// Draws, runs and judges the problem with a number.
    ///
    /// # Errors
    /// Bodies that cannot be made: a fault of the generator.
    pub fn new(number: u64) -> Made<Self> {
        Ok(Self::of(&Problem::new(number)?))
    }

    /// Refines a problem adaptively on up to four meshes, and judges each of them.
    pub fn adaptive(problem: &Problem) -> Self {
        Self::refined(problem, |assembly| assembly.problem(0))
    }

    /// [`Self::adaptive`] of a problem whose surfaces do not match.
    pub fn overlaid(problem: &Problem) -> Self {
        Self::refined(problem, |assembly| assembly.overlaid(&mut Random::new(problem.number)))
    }

    fn refined(problem: &Problem, first: impl Fn(&Assembly) -> Made<ContactProblem<Solid>>) -> Self {
        let assembly = adaptive::flat(&problem.assembly);
        Self::judged(problem, |trial| {
            if let Err(error) = first(&assembly).and_then(|first| adaptive::judge(problem, first, trial)) {
                // Without its gaps and round obstacles an assembly may have supports and contacts that exclude each other.
                trial.say(Promise::Status, excluded(error.as_ref()), || format!("adaptive: {error}"));
            }
        })
    }

    /// Runs and judges a problem.
    pub fn of(problem: &Problem) -> Self {
        Self::judged(problem, |trial| {
            let claims = judge::judge(problem, trial);
            // Fields of other programs get no bound with friction, cuts or bonds.
            if !problem.family.contains("friction") && !["cuts", draw::BONDED].contains(&problem.family) {
                field::judge(problem, &claims, trial);
            }
        })
    }

    fn judged(problem: &Problem, judge: impl Fn(&mut Self)) -> Self {
        let sides = |part: &build::Part| {
            part.sides.iter().filter(|s| matches!(s, Condition::Plane(..) | Condition::Round(..))).count()
        };
        let parts = &problem.assembly.parts;
        let mut trial = Self {
            number: problem.number,
            family: problem.family,
            nodes: parts.iter().map(|part| part.cells.nodes()).sum(),
            pairs: problem.assembly.touches.len() + parts.iter().map(sides).sum::<usize>(),
            runs: 0,
            ended: String::new(),
            refused: None,
            effectivity: None,
            worst: 0.0,
            worst_pair: 0.0,
            fields: 0,
            refined: 0,
            verdicts: Vec::new(),
        };
        // A panic is a defect of the program, and one of the verdicts.
        let judged = catch_unwind(AssertUnwindSafe(|| judge(&mut trial)));
        trial.say(Promise::Status, judged.is_ok(), || "panicked".into());
        trial
    }

    fn say(&mut self, promise: Promise, holds: bool, said: impl FnOnce() -> String) {
        let said = if holds { String::new() } else { said() };
        self.verdicts.push(Verdict { promise, holds, said });
    }

    /// Lists what is violated.
    pub fn violations(&self) -> impl Iterator<Item = &Verdict> {
        self.verdicts.iter().filter(|verdict| !verdict.holds)
    }
}
