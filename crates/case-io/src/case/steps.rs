//! `[[step]]`: load steps, which scale the conditions and the gaps that have a name.

use super::{BodyCase, Case, Contact, Dimension};
use crate::case_file::{NodeValue, Reader};
use crate::diagnostic::excerpt;
use fem_core::body::{ConditionList, ConditionPlace};
use serde::{Serialize, Serializer};

/// Increments of all steps together, at most.
const MOST: usize = 10_000;

/// `[[step]]`: what the named conditions have at its end.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct StepCase {
    /// The factors of the conditions, and of the gaps of pairs, with these names at the end of the step; other names keep theirs.
    #[serde(serialize_with = "factors")]
    pub factors: Vec<(String, f64)>,
    /// Equal increments.
    pub count: usize,
}

fn factors<S: Serializer>(factors: &[(String, f64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(factors.iter().map(|(name, factor)| (name, factor)))
}

/// The factors of all named conditions at the end of an increment.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Factors {
    /// Names with their factors, in the order of their first use in a step.
    #[serde(serialize_with = "factors")]
    pub named: Vec<(String, f64)>,
}

impl Factors {
    /// Returns the factor of a condition: 1 without a name, 0 with one that no step has named.
    pub fn of(&self, name: Option<&str>) -> f64 {
        let Some(name) = name else { return 1.0 };
        self.named.iter().find(|(known, _)| known == name).map_or(0.0, |(_, factor)| *factor)
    }
}

impl<S: Dimension> BodyCase<S> {
    /// Returns the name of a condition, if it has one.
    pub fn condition_name(&self, place: ConditionPlace) -> Option<&str> {
        let name = match place.list {
            ConditionList::Displacement => self.displacements.get(place.index).map(|c| &c.name),
            ConditionList::Traction => self.tractions.get(place.index).map(|c| &c.name),
            ConditionList::Rigid => self.rigid.get(place.index).map(|c| &c.name),
            ConditionList::Spring => self.springs.get(place.index).map(|c| &c.name),
            ConditionList::Temperature => self.temperatures.get(place.index).map(|c| &c.name),
            ConditionList::Cut => return self.cuts.get(place.index).map(|cut| cut.name.as_str()),
            ConditionList::Curve | ConditionList::Surface | ConditionList::BodyForce => None,
        };
        name?.as_deref()
    }

    /// Lists the names of its conditions; cuts, which act whole if no step names them, are left out.
    pub(super) fn condition_names(&self) -> impl Iterator<Item = &str> {
        let displacements = self.displacements.iter().map(|c| &c.name);
        let tractions = self.tractions.iter().map(|c| &c.name);
        let names = displacements.chain(tractions).chain(self.rigid.iter().map(|c| &c.name));
        let names = names.chain(self.springs.iter().map(|c| &c.name));
        let names = names.chain(self.temperatures.iter().map(|c| &c.name));
        names.filter_map(|name| name.as_deref())
    }
}

impl<S: Dimension> Case<S> {
    /// Returns the factor of a condition of a body.
    pub fn factor(&self, factors: &Factors, body: usize, place: ConditionPlace) -> f64 {
        let name = self.bodies.get(body).and_then(|body| body.condition_name(place));
        match place.list {
            // All cuts have a name.
            ConditionList::Cut => self.factor_in_steps(factors, name),
            _ => factors.of(name),
        }
    }

    /// Returns the factor of the gap of a pair: that of its name, if a step names it.
    pub fn gap_factor(&self, factors: &Factors, pair: usize) -> f64 {
        self.factor_in_steps(factors, self.contacts.get(pair).map(|contact| contact.name.as_str()))
    }

    /// Returns the factor of a name, if a step names it, and otherwise 1.
    fn factor_in_steps(&self, factors: &Factors, name: Option<&str>) -> f64 {
        let mut steps = self.steps.iter().flat_map(|step| &step.factors);
        factors.of(name.filter(|name| steps.any(|(of, _)| of == name)))
    }

    /// Lists the factors at the end of each step. Nothing without steps.
    pub fn step_ends(&self) -> Vec<Factors> {
        let mut now = Factors::default();
        let end = |step: &StepCase| {
            for (name, to) in &step.factors {
                match now.named.iter_mut().find(|(known, _)| known == name) {
                    Some((_, factor)) => *factor = *to,
                    None => now.named.push((name.clone(), *to)),
                }
            }
            now.clone()
        };
        self.steps.iter().map(end).collect()
    }

    /// Lists the factors at the end of each increment, linear from the end of the step before (at first 0). Empty without steps.
    pub fn increments(&self) -> Vec<Factors> {
        let mut all = Vec::new();
        let mut before = Factors::default();
        for (step, end) in self.steps.iter().zip(self.step_ends()) {
            for k in 1..step.count {
                let part = k as f64 / step.count as f64;
                let between = |(name, to): &(String, f64)| {
                    let from = before.of(Some(name));
                    (name.clone(), from + part * (to - from))
                };
                all.push(Factors { named: end.named.iter().map(between).collect() });
            }
            // Exactly the given factors at the end.
            all.push(end.clone());
            before = end;
        }
        all
    }
}

/// Reads the steps.
pub(super) fn steps<S: Dimension>(
    root: &mut Reader<'_>,
    (bodies, contacts): (&[BodyCase<S>], &[Contact<S>]),
) -> Vec<StepCase> {
    let Some(readers) = root.tables("step") else { return Vec::new() };
    let mut steps = Vec::with_capacity(readers.len());
    for r in readers {
        steps.push(step(r, (bodies, contacts)));
    }
    let total = steps.iter().map(|step| step.count).fold(0, usize::saturating_add);
    if total > MOST {
        let message = format!("the steps have {total} increments together");
        root.refuse("step", message, &format!("at most {MOST}"), "make `count` smaller");
    }
    steps
}

fn step<S: Dimension>(mut r: Reader<'_>, (bodies, contacts): (&[BodyCase<S>], &[Contact<S>])) -> StepCase {
    r.require(&["factors"]);
    let mut factors = Vec::new();
    if let Some(r) = r.table("factors") {
        let of_pairs = contacts.iter().filter(|contact| contact.named).map(|contact| contact.name.as_str());
        let of_cuts = bodies.iter().flat_map(|body| &body.cuts).map(|cut| cut.name.as_str());
        let names = bodies.iter().flat_map(BodyCase::<S>::condition_names);
        let known: Vec<&str> = names.chain(of_pairs).chain(of_cuts).collect();
        if r.entries().is_empty() {
            r.refuse(
                "",
                "this step names no condition",
                "a factor or more",
                "write `factors = { push = 1.0 }`",
            );
        }
        for entry in r.entries() {
            let name = entry.key.as_str();
            if !known.contains(&name) {
                let message = format!("no condition and no contact is called {}", excerpt(name));
                let (expected, fix) = match known.is_empty() {
                    true => (
                        "the `name` of a condition or of a contact".to_owned(),
                        format!(
                            "write `name = \"{}\"` into a \
                         [[body.displacement]], a [[body.traction]], a [[body.rigid]], a [[body.spring]], a [[body.cut]] or a [[contact]]",
                            name.escape_debug()
                        ),
                    ),
                    false => (
                        format!("one of the names {}", known.join(", ")),
                        "write one of these names, or name the condition or the contact".to_owned(),
                    ),
                };
                r.refuse(name, message, &expected, &fix);
            }
            let value = match entry.node.value {
                NodeValue::Float(value) => value,
                NodeValue::Integer(value) => value as f64,
                _ => f64::NAN,
            };
            if value.is_finite() {
                factors.push((name.to_owned(), value));
            } else {
                let message = format!("the factor of {} is not a finite number", excerpt(name));
                r.refuse(name, message, "a finite number", "write the number itself, such as 1.0");
            }
        }
    }
    let count = r.count("count", 1).unwrap_or(1);
    r.finish();
    StepCase { factors, count }
}
