//! Numbers and expressions as fem-core's data, and what the mesh makes of them.

use super::pair_notes::PairNote;
use super::{Case, Contact, Dimension, Friction, Value};
use crate::diagnostic::{CaseError, code};
use fem_core::body::{Body, ConditionList, DataDifference, Difference};
use fem_core::geometry::Point;
use fem_core::interface::{ContactInterface, ContactProblem, NodePair};

/// Writes an expression for a note.
pub(super) fn quoted(value: Option<&Value>) -> String {
    match value {
        Some(Value::Expression(expression)) => crate::diagnostic::excerpt(expression.text()),
        Some(Value::Nodal(_)) => "values at nodes".to_owned(),
        _ => "a function".to_owned(),
    }
}

/// This many data that linear edges cannot represent, besides the worst one, are no longer described one by one.
const MOST_ALONE: usize = 3;

impl<S: Dimension> Case<S> {
    /// Says what the reader of the results should know of the data: where the stress out of the plane is not known, and
    /// which data given by expressions linear facets cannot represent, and how much the data of this mesh differ from
    /// them: the bound of the error is for the data of the mesh.
    ///
    /// * `problem`: bodies in the file's order.
    pub fn data_notes(&self, problem: &ContactProblem<S>) -> Vec<String> {
        let mut notes = S::stress_notes(self);
        let of_body = |(k, body): (usize, &Body<S>)| {
            let found = body.interpolated_data().into_iter();
            found.map(|found| (self.datum(k, &found), found.difference)).collect::<Vec<_>>()
        };
        let data = problem.bodies.iter().enumerate().flat_map(of_body);
        let (mut data, endless): (Vec<_>, Vec<_>) =
            data.partition(|(_, difference)| difference.largest.is_finite());
        let described = |data: &[(String, Difference)]| -> Vec<String> {
            data.iter().map(|(what, difference)| note::<S>(what, *difference)).collect()
        };
        // Each datum without a finite value is said.
        notes.extend(described(&endless));
        let others = data.len().saturating_sub(1);
        if others < MOST_ALONE {
            notes.extend(described(&data));
        } else {
            data.sort_by(|a, b| b.1.largest.total_cmp(&a.1.largest));
            let worst = described(&data[..1]).pop();
            notes.extend(worst.map(|worst| {
                format!(
                    "{worst}; {others} other data are not linear {} either, and differ by no more",
                    S::ALONG
                )
            }));
        }
        notes.extend(self.notes_inside(problem));
        let mut of_pairs = Vec::new();
        let gaps = S::interpolated_gaps(problem);
        let measured = |of: &Contact<S>| {
            of.geometric || of.obstacle.is_some() && !self.is_given(&format!("{}.gap", of.path))
        };
        // All measured gaps of a kind get one note, with the largest difference.
        let worst = |given: &Contact<S>| {
            let alike = |of: &Contact<S>| measured(of) && of.obstacle.is_some() == given.obstacle.is_some();
            let of_kind =
                self.contacts.iter().zip(&gaps).filter(|(of, _)| alike(of)).filter_map(|(_, found)| *found);
            of_kind.fold(Difference { largest: 0.0, mean: 0.0 }, |worst, of| Difference {
                largest: worst.largest.max(of.largest),
                mean: worst.mean.max(of.mean),
            })
        };
        for (k, difference) in gaps.iter().enumerate() {
            let (Some(difference), Some(given)) = (*difference, self.contacts.get(k)) else { continue };
            let measured = measured(given);
            let said = match (measured, given.obstacle.is_some()) {
                (true, true) => ": the distance from it".to_owned(),
                (true, false) => {
                    " = \"geometric\": the gap between smooth curves through the nodes of each surface"
                        .to_owned()
                }
                (false, _) => format!(" = {}", quoted(Some(&given.gap))),
            };
            let words = match measured {
                true => measured_gap::<S>(&said, worst(given)),
                false => note::<S>(&said, difference),
            };
            let key = if measured && given.obstacle.is_some() { "obstacle" } else { "gap" };
            let (alone, shared) = (format!("{}.{key}{words}", given.path), format!("{key}{words}"));
            of_pairs.push(PairNote { contact: k, alone, shared });
        }
        notes.extend(self.joined(of_pairs));
        for (given, pair) in self.contacts.iter().zip(&problem.contacts) {
            let (Some(Friction::Tresca { limit }), Some(first)) =
                (&given.friction, problem.bodies.get(pair.body))
            else {
                continue;
            };
            if let Some(difference) = pair.interpolated_limit(first) {
                notes.push(note::<S>(
                    &format!("{}.friction.limit = {}", given.path, quoted(Some(limit))),
                    difference,
                ));
            }
        }
        notes
    }

    /// Names a datum by body, side and key.
    fn datum(&self, body: usize, found: &DataDifference) -> String {
        use super::{Imposition, Load, Rest};
        let given = &self.bodies[body];
        let index = found.place.index;
        let (on, key, value) = match found.place.list {
            ConditionList::Displacement => {
                let Some(condition) = given.displacements.get(index) else { return String::new() };
                let (key, value): (String, _) = match (&condition.imposition, found.component) {
                    (Imposition::Components(values), Some(c)) => {
                        (S::MOTIONS[c].to_owned(), values[c].as_ref())
                    }
                    (Imposition::Normal(value), _) => ("normal".to_owned(), Some(value)),
                    _ => ("displacement".to_owned(), None),
                };
                (&condition.on, key, value)
            }
            ConditionList::Traction => {
                let Some(condition) = given.tractions.get(index) else { return String::new() };
                let (key, value): (String, _) = match (&condition.load, found.component) {
                    (Load::Vector(values), Some(c)) => {
                        (format!("traction {}", S::COORDINATES[c]), Some(&values[c]))
                    }
                    (Load::Pressure(value), _) => ("pressure".to_owned(), Some(value)),
                    _ => ("traction".to_owned(), None),
                };
                (&condition.on, key, value)
            }
            ConditionList::Spring => {
                let Some(condition) = given.springs.get(index) else { return String::new() };
                let (key, value): (String, _) = match (&condition.rest, found.component) {
                    (_, None) => ("stiffness".to_owned(), Some(&condition.stiffness)),
                    (Some(Rest::Vector(values)), Some(c)) => {
                        (format!("rest {}", S::COORDINATES[c]), Some(&values[c]))
                    }
                    (Some(Rest::Component(value)), _) => ("rest".to_owned(), Some(value)),
                    (None, _) => ("rest".to_owned(), None),
                };
                (&condition.on, key, value)
            }
            // Its data are numbers, not functions.
            _ => return String::new(),
        };
        format!("body \"{}\", {key} = {} on \"{on}\"", given.name, quoted(value))
    }

    /// Refuses an initial λ that is not finite at a contact node of a body.
    ///
    /// * `contact`: the number of the pair; `bodies`: all bodies, in the file's order.
    pub(super) fn check_lambda(
        &self,
        contact: usize,
        bodies: &[Body<S>],
        interface: &ContactInterface<S>,
    ) -> Result<(), CaseError> {
        let lambda = self.solver.lambda.scalar::<S>();
        let members = &self.contacts[contact].bodies;
        let of_nodes = |p: &NodePair<S>| {
            let at = |(side, b): (usize, &usize)| bodies[*b].mesh().points()[p.nodes[side]];
            members.iter().enumerate().map(at).collect::<Vec<_>>()
        };
        let mut points = interface.pairs().iter().flat_map(of_nodes);
        let Some(p) = points.find(|p| !lambda.at(*p).is_finite()) else { return Ok(()) };
        let message = format!("`solver.lambda`: the value at {} is {}", Point::from(p), lambda.at(p));
        let fault = self.diagnostic(code::CONDITION, "solver.lambda", message).expected("a finite number");
        Err(fault
            .fix("change the expression where it divides by zero or leaves its range, or write 0.0")
            .into())
    }

    /// Finds the key of the first expression in a condition.
    pub(super) fn expression_path(&self, condition: &str) -> String {
        let of_vector =
            ["vector", "rest"].into_iter().flat_map(|key| (0..S::DIM).map(move |c| format!("{key}.{c}")));
        let others = S::MOTIONS[..S::DIM].iter().chain(&["normal", "pressure", "rest", "value"]);
        let others = others.map(|key| (*key).to_owned());
        let mut paths = others.chain(of_vector).map(|key| format!("{condition}.{key}"));
        let is_expression = |path: &String| {
            self.place(path).filter(|_| self.is_given(path)).is_some_and(|place| {
                place.source.text().get(place.span.clone()).is_some_and(|t| t.starts_with(['"', '\'']))
            })
        };
        paths.find(is_expression).unwrap_or_else(|| condition.to_owned())
    }
}

fn measured_gap<S: Dimension>(what: &str, difference: Difference) -> String {
    format!(
        "{what} is not linear {}, so the bound is for a gap that differs from it by at most {:.1e} of its largest \
         value ({:.1e} in the mean); finer {} make this smaller by the square of their length",
        S::ALONG,
        difference.largest,
        difference.mean,
        S::WORDS.facets
    )
}

fn note<S: Dimension>(what: &str, difference: Difference) -> String {
    let checked = format!("checked at {} points of every {}", S::facet_samples().len(), S::WORDS.facet);
    if difference.largest.is_infinite() {
        return format!(
            "{what}: without a finite value at a point between the nodes ({checked}); the bound is for data that are linear \
             from node to node"
        );
    }
    // The stiffness of springs is constant on a facet.
    let shape = match what.contains(", stiffness = ") {
        true => format!("not constant on every {}", S::WORDS.facet),
        false => format!("not linear {}", S::ALONG),
    };
    format!(
        "{what}: {shape}, so the bound is for interpolated data; at the points checked they differ from the \
         expression by at most {:.1e} of its largest value ({:.1e} in the mean; {checked})",
        difference.largest, difference.mean
    )
}
