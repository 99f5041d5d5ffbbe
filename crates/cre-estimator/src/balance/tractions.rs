//! The unknowns of a balance: one traction for each row, and one pressure for each bent facet, on which it is constant, with friction also the directions
//! of [`turn_fields`].

use crate::friction::{at_corners, facet_limit, least, on_bent_facet, turn_fields, turns_of};
use crate::recovery::Recovery;
use fem_core::geometry::Coordinates;
use fem_core::interface::{ContactFacet, ContactInterface, ContactPair, ContactProblem};

/// The unknown tractions of all contact lines, line after line.
#[derive(Clone, Debug)]
pub(super) struct Tractions {
    pub(super) lines: Vec<LineTractions>,
}

/// The unknown tractions of a contact line.
#[derive(Clone, Debug)]
pub(super) struct LineTractions {
    /// The number of its first unknown.
    pub(super) start: usize,
    /// Unknowns at pairs of nodes: along the normals, then along the tangents.
    pub(super) rows: usize,
    /// Facets with an own pressure, whose unknowns follow, and then those of their friction, direction after direction: all bent ones, or none.
    pub(super) facets: Vec<usize>,
    /// Directions of friction.
    tangents: usize,
    /// The length or area that belongs to each unknown, m or m².
    pub(super) weights: Vec<f64>,
}

impl LineTractions {
    /// The number of unknowns.
    pub(super) fn count(&self) -> usize {
        self.rows + self.facets.len() * (1 + self.tangents)
    }

    /// Returns the number of the limit that an unknown of friction has, see [`Self::limits`]; `None` for a pressure.
    pub(super) fn disc_of<S: Recovery>(
        &self,
        interface: &ContactInterface<S>,
        unknown: usize,
    ) -> Option<usize> {
        let (nodes, facets) = (interface.pairs().len(), self.facets.len());
        match unknown.checked_sub(self.rows) {
            None => (unknown >= nodes).then(|| unknown % nodes),
            Some(own) => (own >= facets).then(|| nodes + own % facets),
        }
    }

    /// Lists the limits of friction: at the pairs, then on the facets with an own pressure, Pa.
    ///
    /// * `at_pairs`: empty without friction; `pressure`: at the corners of the facets, with Coulomb friction.
    pub(super) fn limits<S: Recovery>(
        &self,
        pair: &ContactPair<S>,
        at_pairs: Vec<f64>,
        pressure: &[S::Axes<f64>],
    ) -> Vec<f64> {
        if at_pairs.is_empty() {
            return at_pairs;
        }
        let facets = pair.interface.facets();
        let own =
            self.facets.iter().map(|k| least(&facet_limit(pair, &facets[*k], &at_pairs, pressure.get(*k))));
        let idle = |k: &usize| self.is_idle(*k);
        let nodes = (0..at_pairs.len()).map(|k| if idle(&k) { 0.0 } else { at_pairs[k] });
        nodes.chain(own).collect()
    }

    /// Tells whether an unknown, from the first one of the line, takes part in nothing: all facets around its pair have own pressures.
    pub(super) fn is_idle(&self, unknown: usize) -> bool {
        !self.facets.is_empty() && unknown < self.rows && self.weights[unknown] == 0.0
    }

    /// Tells whether a facet has an own pressure.
    fn owns<S: Recovery>(&self, facet: &ContactFacet<S>) -> bool {
        facet.bent && !self.facets.is_empty()
    }

    fn new<S: Recovery>(pair: &ContactPair<S>, start: usize, by_facet: bool) -> Self {
        let interface = &pair.interface;
        let (pairs, rows) = (interface.pairs(), pair.row_count());
        let all = interface.facets();
        let mut weights: Vec<f64> = pair.rows().map(|row| pairs[row.pair].weight).collect();
        let tangents = if pair.friction.acts() { S::DIM - 1 } else { 0 };
        let mut facets = Vec::new();
        if by_facet && S::BALANCED_BY_FACET && interface.has_bent_facets() {
            facets.extend((0..all.len()).filter(|k| all[*k].bent));
            weights = vec![0.0; rows];
            for facet in all.iter().filter(|facet| !facet.bent) {
                for corner in 0..S::DIM {
                    let sources = interface.sources(facet, corner);
                    let share = facet.measure / (S::DIM * sources.len().max(1)) as f64;
                    for row in sources.iter().flat_map(|k| (*k as usize..rows).step_by(pairs.len())) {
                        weights[row] += share;
                    }
                }
            }
            (0..=tangents).for_each(|_| weights.extend(facets.iter().map(|k| all[*k].measure)));
        }
        Self { start, rows, facets, tangents, weights }
    }

    /// Returns the tractions that belong to pressures and friction at the pairs.
    fn target<S: Recovery>(&self, pair: &ContactPair<S>, rows: &[f64]) -> Vec<f64> {
        let interface = &pair.interface;
        let facets = || self.facets.iter().map(|k| &interface.facets()[*k]);
        let at_rows = (0..self.rows).map(|k| if self.is_idle(k) { 0.0 } else { rows[k] });
        let mut target: Vec<f64> =
            at_rows.chain(facets().map(|facet| interface.pressure(facet, rows)[0])).collect();
        let friction = &rows[interface.pairs().len()..];
        let turns: Vec<Vec<f64>> = match self.tangents {
            0 => Vec::new(),
            _ => facets().map(|facet| turns_of(pair, facet, friction)).collect(),
        };
        target.extend((0..self.tangents).flat_map(|k| turns.iter().map(move |of_facet| of_facet[k])));
        target
    }

    /// Lists the unknown pressures, from the first unknown of the line, with the openings there, m: on a facet the mean.
    ///
    /// * `by_pair`: opening of each pair, m.
    pub(super) fn openings<S: Recovery>(
        &self,
        interface: &ContactInterface<S>,
        by_pair: &[f64],
    ) -> Vec<(usize, f64)> {
        let of_facet = |k: &usize| -> f64 {
            interface.facets()[*k].openings(by_pair).as_ref().iter().sum::<f64>() / S::DIM as f64
        };
        let on_facets = (self.rows..).zip(self.facets.iter().map(of_facet));
        (0..).zip(by_pair.iter().copied()).chain(on_facets).collect()
    }

    /// Computes the pressure at the corners of each facet, and at each pair the mean of the facets around, Pa.
    ///
    /// * `values`: of the unknowns of this line.
    pub(super) fn pressure<S: Recovery>(
        &self,
        interface: &ContactInterface<S>,
        values: &[f64],
    ) -> (Vec<S::Axes<f64>>, Vec<f64>) {
        let pairs = interface.pairs();
        let (rows, own) = values.split_at(self.rows.min(values.len()));
        let mut own = own.iter();
        let of_facet = |facet: &ContactFacet<S>| match self.owns(facet) {
            true => {
                let pressure = own.next().copied().unwrap_or(0.0);
                S::axes(|_| pressure)
            }
            false => interface.pressure(facet, rows),
        };
        let by_facet: Vec<S::Axes<f64>> = interface.facets().iter().map(of_facet).collect();
        if self.facets.is_empty() {
            return (by_facet, rows[..pairs.len()].to_vec());
        }
        let mut by_pair = vec![0.0; pairs.len()];
        for (facet, pressure) in interface.facets().iter().zip(&by_facet) {
            for corner in facet.free_corners() {
                by_pair[facet.pairs[corner] as usize] += facet.measure / S::DIM as f64 * pressure[corner];
            }
        }
        by_pair.iter_mut().zip(pairs).for_each(|(sum, pair)| *sum /= pair.weight);
        (by_facet, by_pair)
    }

    /// Computes friction in the rows along tangents, on the facets with an own pressure the mean of the facets around, and at the corners of each
    /// facet, Pa.
    ///
    /// * `values`: of the unknowns of this line; `limit`: at the corners of the facets, Pa; empty without friction.
    pub(super) fn friction<S: Recovery>(
        &self,
        pair: &ContactPair<S>,
        values: &[f64],
        limit: &[S::Axes<f64>],
    ) -> (Vec<f64>, Vec<S::Axes<S::Vector>>) {
        let interface = &pair.interface;
        let nodes = interface.pairs().len();
        let rows = &values[nodes..self.rows];
        let own = values.get(self.rows + self.facets.len()..).unwrap_or_default();
        let mut number = 0..self.facets.len();
        let of_facet = |(facet, limit): (&ContactFacet<S>, &S::Axes<f64>)| match self.owns(facet) {
            true => {
                let first = number.next().unwrap_or(0);
                let turn: Vec<f64> = own[first..].iter().step_by(self.facets.len()).copied().collect();
                on_bent_facet(pair, facet, &turn, limit)
            }
            false => at_corners(pair, facet, rows, limit),
        };
        let by_facet: Vec<S::Axes<S::Vector>> = interface.facets().iter().zip(limit).map(of_facet).collect();
        if self.facets.is_empty() {
            return (rows.to_vec(), by_facet);
        }
        let mut means = vec![0.0; rows.len()];
        for (facet, traction) in interface.facets().iter().zip(&by_facet) {
            for corner in facet.free_corners() {
                let k = facet.pairs[corner] as usize;
                let pair_of = &interface.pairs()[k];
                let share = facet.measure / S::DIM as f64 / pair_of.weight;
                let size = pair_of.normal.times(&pair_of.normal);
                let parts = pair.tangential_parts(k, traction[corner]);
                for (row, part) in (k..means.len()).step_by(nodes).zip(parts) {
                    means[row] += share / size * part;
                }
            }
        }
        (means, by_facet)
    }

    /// Computes the work of a unit of each unknown on a motion.
    ///
    /// * `motion`: at the pairs, m.
    pub(super) fn work<S: Recovery>(&self, pair: &ContactPair<S>, motion: &[S::Vector]) -> Vec<f64> {
        let normals =
            |facet: &ContactFacet<S>| S::axes(|corner| pair.interface.corner_pair(facet, corner).normal);
        let (mut work, mut own) = self.work_along(pair, motion, normals);
        for k in 0..self.tangents {
            let along = |facet: &ContactFacet<S>| match self.owns(facet) {
                true => turn_fields(pair, facet).nth(k).unwrap_or(S::axes(|_| S::Vector::ZERO)),
                false => S::axes(|corner| pair.corner_tangents(facet, corner)[k]),
            };
            let (at_rows, on_facets) = self.work_along(pair, motion, along);
            work.extend(at_rows);
            own.extend(on_facets);
        }
        work.extend(own);
        work
    }

    /// Computes the work of a unit traction at each pair and on each facet with an own pressure.
    ///
    /// * `direction`: of the traction at the corners of a facet.
    fn work_along<S: Recovery>(
        &self,
        pair: &ContactPair<S>,
        motion: &[S::Vector],
        direction: impl Fn(&ContactFacet<S>) -> S::Axes<S::Vector>,
    ) -> (Vec<f64>, Vec<f64>) {
        let interface = &pair.interface;
        let (mut work, mut own) = (vec![0.0; motion.len()], Vec::new());
        for facet in interface.facets() {
            let moved = S::axes(|corner| match facet.clamped[corner] {
                None => motion[facet.pairs[corner] as usize],
                Some(_) => S::Vector::ZERO,
            });
            let directions = direction(facet);
            // ∫ (Σ p_i n_i φ_i)·u, as in the nodal forces of the pressure.
            let mut at = S::axes(|corner| {
                let others = (0..S::DIM).filter(|other| *other != corner);
                let sum = others.fold(moved[corner] * 2.0, |sum, other| sum + moved[other]);
                facet.measure / (S::DIM * (S::DIM + 1)) as f64 * directions[corner].times(&sum)
            });
            if facet.bent {
                let sum = at.as_ref().iter().sum::<f64>();
                if self.owns(facet) {
                    own.push(sum);
                    continue;
                }
                // It carries the mean of its corners.
                at = S::axes(|_| sum / S::DIM as f64);
            }
            for corner in 0..S::DIM {
                let sources = interface.sources(facet, corner);
                sources.iter().for_each(|k| work[*k as usize] += at[corner] / sources.len() as f64);
            }
        }
        (work, own)
    }
}

impl Tractions {
    /// Takes the tractions of all rows.
    pub(super) fn of_rows<S: Recovery>(problem: &ContactProblem<S>) -> Self {
        Self::new(problem, false)
    }

    /// Takes the tractions of all rows, and the pressures of bent facets instead of those at their corners, if [`Recovery::BALANCED_BY_FACET`].
    pub(super) fn of_facets<S: Recovery>(problem: &ContactProblem<S>) -> Self {
        Self::new(problem, true)
    }

    fn new<S: Recovery>(problem: &ContactProblem<S>, by_facet: bool) -> Self {
        let mut start = 0;
        let line = |pair: &ContactPair<S>| {
            let line = LineTractions::new(pair, start, by_facet);
            start += line.count();
            line
        };
        Self { lines: problem.contacts.iter().map(line).collect() }
    }

    /// The number of unknowns.
    pub(super) fn count(&self) -> usize {
        self.lines.iter().map(LineTractions::count).sum()
    }

    /// Lists the length or area that belongs to each unknown, m or m².
    pub(super) fn weights(&self) -> Vec<f64> {
        self.lines.iter().flat_map(|line| &line.weights).copied().collect()
    }

    /// Lists the tractions that belong to those of all rows.
    ///
    /// * `rows`: by line.
    pub(super) fn targets<S: Recovery>(&self, problem: &ContactProblem<S>, rows: &[Vec<f64>]) -> Vec<f64> {
        let lines = self.lines.iter().zip(&problem.contacts).zip(rows);
        lines.flat_map(|((line, pair), rows)| line.target(pair, rows)).collect()
    }

    /// Lists the lines, each with its values of all.
    pub(super) fn split<'a>(
        &'a self,
        values: &'a [f64],
    ) -> impl Iterator<Item = (&'a LineTractions, &'a [f64])> {
        self.lines.iter().map(|line| (line, &values[line.start..line.start + line.count()]))
    }
}
