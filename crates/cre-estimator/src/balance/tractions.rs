//! The unknowns of a balance: one traction for each row, and one pressure for each bent facet, on which it is constant.

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
    /// Facets with an own pressure, whose unknowns follow: all bent ones of a line without friction, or none.
    pub(super) facets: Vec<usize>,
    /// The length or area that belongs to each unknown, m or m².
    pub(super) weights: Vec<f64>,
}

impl LineTractions {
    /// The number of unknowns.
    pub(super) fn count(&self) -> usize {
        self.rows + self.facets.len()
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
        let mut facets = Vec::new();
        if by_facet && S::BALANCED_BY_FACET && !pair.friction.acts() && interface.has_bent_facets() {
            facets.extend((0..all.len()).filter(|k| all[*k].bent));
            weights = vec![0.0; rows];
            for facet in all.iter().filter(|facet| !facet.bent) {
                for corner in 0..S::DIM {
                    let sources = interface.sources(facet, corner);
                    let share = facet.measure / (S::DIM * sources.len().max(1)) as f64;
                    sources.iter().for_each(|k| weights[*k as usize] += share);
                }
            }
            weights.extend(facets.iter().map(|k| all[*k].measure));
        }
        Self { start, rows, facets, weights }
    }

    /// Returns the tractions that belong to pressures and friction at the pairs.
    fn target<S: Recovery>(&self, interface: &ContactInterface<S>, rows: &[f64]) -> Vec<f64> {
        let at_rows = (0..self.rows).map(|k| if self.is_idle(k) { 0.0 } else { rows[k] });
        let facets = self.facets.iter().map(|k| interface.pressure(&interface.facets()[*k], rows)[0]);
        at_rows.chain(facets).collect()
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

    /// Computes the work of a unit of each unknown on a motion.
    ///
    /// * `motion`: at the pairs, m.
    pub(super) fn work<S: Recovery>(&self, pair: &ContactPair<S>, motion: &[S::Vector]) -> Vec<f64> {
        let mut work =
            self.work_along(pair, motion, |facet, corner| pair.interface.corner_pair(facet, corner).normal);
        let tangents = if pair.friction.acts() { S::DIM - 1 } else { 0 };
        for k in 0..tangents {
            let along = |facet: &ContactFacet<S>, corner: usize| pair.corner_tangents(facet, corner)[k];
            work.extend(self.work_along(pair, motion, along));
        }
        work
    }

    /// Computes the work of a unit traction at each pair and on each facet with an own pressure.
    ///
    /// * `direction`: of the traction at a corner of a facet.
    fn work_along<S: Recovery>(
        &self,
        pair: &ContactPair<S>,
        motion: &[S::Vector],
        direction: impl Fn(&ContactFacet<S>, usize) -> S::Vector,
    ) -> Vec<f64> {
        let interface = &pair.interface;
        let (mut work, mut own) = (vec![0.0; motion.len()], Vec::new());
        for facet in interface.facets() {
            let moved = S::axes(|corner| match facet.clamped[corner] {
                None => motion[facet.pairs[corner] as usize],
                Some(_) => S::Vector::ZERO,
            });
            // ∫ (Σ p_i n_i φ_i)·u, as in the nodal forces of the pressure.
            let mut at = S::axes(|corner| {
                let others = (0..S::DIM).filter(|other| *other != corner);
                let sum = others.fold(moved[corner] * 2.0, |sum, other| sum + moved[other]);
                facet.measure / (S::DIM * (S::DIM + 1)) as f64 * direction(facet, corner).times(&sum)
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
        work.extend(own);
        work
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
        lines.flat_map(|((line, pair), rows)| line.target(&pair.interface, rows)).collect()
    }

    /// Lists the lines, each with its values of all.
    pub(super) fn split<'a>(
        &'a self,
        values: &'a [f64],
    ) -> impl Iterator<Item = (&'a LineTractions, &'a [f64])> {
        self.lines.iter().map(|line| (line, &values[line.start..line.start + line.count()]))
    }
}
