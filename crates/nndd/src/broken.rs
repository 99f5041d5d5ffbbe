//! All bodies in their interface unknowns, side by side: rows of any number of terms, dependent ones among them.
//!
//! The amounts of the free motions of obstacles follow the unknowns of the bodies, as a body without stiffness.

use crate::error::NnddError;
use crate::vector::dot;
use contact_qp::IndependentRows;
use fem_core::condensation::InterfaceOperator;
use fem_core::contact_system::{ContactRow, ContactSystem, Partner, RowMotion};
use fem_core::each_body;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use std::sync::OnceLock;

/// Numbers with their values, ascending.
pub(crate) type Sparse = Vec<(usize, f64)>;

/// All bodies, with the opening `o = c − B x` of each row.
pub(crate) struct Broken<'a> {
    pub(crate) system: &'a ContactSystem<'a>,
    parts: Vec<Part<'a>>,
    /// The terms of `B` by row.
    pub(crate) rows: Vec<Vec<(usize, f64)>>,
    /// `c`, the gap less what supports and obstacles impose, by row, m.
    pub(crate) gaps: Vec<f64>,
    /// The forces on the unknowns that hold traces of zero, N/m: `S x + Bᵀ P = load`.
    pub(crate) load: Vec<f64>,
    /// The diagonal of `S`, N/m²; 0 of an obstacle.
    pub(crate) diagonal: Vec<f64>,
    /// The energy of the bodies under their condensed loads alone, `gᵀ S⁺ g`: traces may be zero where bodies are strained.
    pub(crate) size: f64,
    /// The numbers of the motions of obstacles, in the order of their unknowns.
    obstacles: Vec<usize>,
}

/// A body. With `S_s` of the body on its springs, which it has if it floats, and `Q` an orthonormal basis of its free motions, the body
/// alone has `S = S_s − S_s Q (Qᵀ S_s Q)⁻¹ Qᵀ S_s`.
struct Part<'a> {
    condensed: &'a InterfaceOperator,
    /// Its unknowns.
    unknowns: Range<usize>,
    /// The numbers of its motions, and `Q`.
    numbers: Vec<usize>,
    motions: IndependentRows,
    basis: DMatrix<f64>,
    /// `S_s Q`, and `(Qᵀ S_s Q)⁻¹`.
    moved: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// An orthonormal basis of all its free motions, column after column: those that the pairs do not resist keep their springs.
    free: Vec<f64>,
    /// `S_s⁻¹`, if it was asked for.
    matrix: OnceLock<Vec<f64>>,
}

impl<'a> Broken<'a> {
    /// * `resisted`: the numbers of the motions that the pairs resist; the springs of the others stay, and keep them at zero.
    ///
    /// # Errors
    /// [`NnddError::DependentRows`] if the springs of a floating body are not seen on its interface.
    pub(crate) fn new(system: &'a ContactSystem<'a>, resisted: &[usize]) -> Result<Self, NnddError> {
        let mut end = 0;
        let ranges: Vec<Range<usize>> = system.bodies.iter().map(|body| next(&mut end, body.len())).collect();
        let made = each_body(ranges.len(), |b| Part::new(system, b, ranges[b].clone(), resisted));
        let whole = |(body, part): (usize, Option<Part<'a>>)| part.ok_or(NnddError::DependentRows { body });
        let parts: Vec<Part<'a>> = made.into_iter().enumerate().map(whole).collect::<Result<_, _>>()?;
        let mut load: Vec<f64> = parts.iter().flat_map(Part::load).collect();
        let size = parts.iter().map(|part| dot(&part.load(), &part.flexibility(&part.load()))).sum();
        let mut diagonal: Vec<f64> = parts.iter().flat_map(Part::diagonal).collect();
        let gap = |row: &ContactRow| row.gap - row.obstacle.unwrap_or(0.0);
        let mut gaps: Vec<f64> = system.rows.rows.iter().map(gap).collect();
        let mut rows = vec![Vec::new(); gaps.len()];
        for (part, of_body) in parts.iter().zip(&system.of_body) {
            for row in of_body {
                gaps[row.row] -= row.imposed;
                rows[row.row].extend(row.terms.iter().map(|(k, a)| (part.unknowns.start + k, *a)));
            }
        }
        let mut obstacles = Vec::new();
        for (number, of) in system.rows.motions.iter().enumerate().filter(|(_, of)| of.partner.is_obstacle())
        {
            let entries = of.traces.iter().filter(|(_, trace)| *trace != 0.0);
            entries.for_each(|(row, trace)| rows[*row].push((load.len(), *trace)));
            load.push(of.load);
            diagonal.push(0.0);
            obstacles.push(number);
        }
        Ok(Self { system, parts, rows, gaps, load, diagonal, size, obstacles })
    }

    /// Counts the unknowns, those of obstacles last.
    pub(crate) fn len(&self) -> usize {
        self.load.len()
    }

    /// Tells whether an unknown belongs to an obstacle.
    pub(crate) fn is_obstacle(&self, unknown: usize) -> bool {
        unknown + self.obstacles.len() >= self.len()
    }

    /// Returns the unknowns of a body.
    pub(crate) fn of_body(&self, body: usize) -> Range<usize> {
        self.parts[body].unknowns.clone()
    }

    /// Tells whether a body has free motions.
    pub(crate) fn floats(&self, body: usize) -> bool {
        self.system.floats(body)
    }

    /// Computes `S x`, N/m.
    pub(crate) fn stiffness(&self, x: &[f64]) -> Vec<f64> {
        self.each(x, |part, x| part.stiffness(x))
    }

    /// Computes `S⁺ f`, m, for forces that balance each floating body.
    pub(crate) fn flexibility(&self, f: &[f64]) -> Vec<f64> {
        self.each(f, Part::flexibility)
    }

    /// Returns `S_s⁻¹` of a body, column-major, m²/N; computed once.
    pub(crate) fn flexibility_matrix(&self, body: usize) -> &[f64] {
        let Part { condensed, matrix, .. } = &self.parts[body];
        matrix.get_or_init(|| condensed.flexibility())
    }

    /// Returns an orthonormal basis `Q` of the free motions of a body that the pairs resist.
    pub(crate) fn basis(&self, body: usize) -> &DMatrix<f64> {
        &self.parts[body].basis
    }

    /// Computes `S x` of a vector that few bodies see, N/m.
    pub(crate) fn stiffness_sparse(&self, x: &Sparse) -> Sparse {
        let mut forces = Vec::new();
        let of_body = |k: usize| self.parts.partition_point(|part| part.unknowns.end <= k);
        for entries in x.chunk_by(|a, b| of_body(a.0) == of_body(b.0)) {
            let Some(part) = self.parts.get(of_body(entries[0].0)) else { continue };
            forces.extend(part.unknowns.clone().zip(part.stiffness_sparse(entries)));
        }
        forces
    }

    /// Applies an operator of each body; one that sees only zeros is left out.
    fn each(&self, x: &[f64], of: impl Fn(&Part<'a>, &[f64]) -> Vec<f64> + Sync) -> Vec<f64> {
        let parts = each_body(self.parts.len(), |b| {
            let (part, own) = (&self.parts[b], &x[self.parts[b].unknowns.clone()]);
            if own.iter().any(|x| *x != 0.0) { of(part, own) } else { vec![0.0; own.len()] }
        });
        let mut all = parts.concat();
        all.resize(x.len(), 0.0);
        all
    }

    /// Computes the openings, m.
    pub(crate) fn openings(&self, x: &[f64]) -> Vec<f64> {
        let opening = |(gap, terms): (&f64, &Vec<(usize, f64)>)| gap - traced(terms, x);
        self.gaps.iter().zip(&self.rows).map(opening).collect()
    }

    /// Computes `Bᵀ P`, N/m.
    pub(crate) fn pressed(&self, forces: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.len()];
        for (terms, force) in self.rows.iter().zip(forces).filter(|(_, force)| **force != 0.0) {
            terms.iter().for_each(|(k, a)| sum[*k] += a * force);
        }
        sum
    }

    /// Lists the columns of the coarse space in all unknowns, sparse: all rigid motions of every body, held or not, and of the obstacles.
    pub(crate) fn motions(&self) -> Vec<Sparse> {
        let mut found = Vec::new();
        let mut push = |start: usize, values: &[f64]| {
            let column = values.iter().enumerate().filter(|(_, value)| **value != 0.0);
            found.push(column.map(|(k, value)| (start + k, *value)).collect());
        };
        for (b, part) in self.parts.iter().enumerate() {
            part.basis.column_iter().for_each(|q| push(part.unknowns.start, q.as_slice()));
            self.system.rigid[b].iter().for_each(|motion| push(part.unknowns.start, motion));
        }
        (0..self.len()).filter(|k| self.is_obstacle(*k)).for_each(|k| push(k, &[1.0]));
        found
    }

    /// Adds a rigid motion of a body or obstacle to its unknowns.
    pub(crate) fn add_motion(&self, number: usize, amount: f64, x: &mut [f64]) {
        match self.system.rows.motions[number].partner {
            Partner::Body(body) => {
                let own = x[self.of_body(body)].iter_mut().zip(&self.system.free[number]);
                own.for_each(|(x, moved)| *x += amount * moved);
            }
            Partner::Obstacle(_) => {
                let first = self.len() - self.obstacles.len();
                let place = self.obstacles.iter().position(|of| *of == number);
                place.into_iter().for_each(|place| x[first + place] += amount);
            }
        }
    }

    /// Takes the part along all free motions of a body out of forces on its unknowns, so that the rest balances it.
    pub(crate) fn without_motions(&self, body: usize, forces: &mut [f64]) {
        let part = &self.parts[body];
        let own = &mut forces[part.unknowns.clone()];
        for motion in part.free.chunks_exact(own.len().max(1)) {
            let along = dot(motion, own);
            own.iter_mut().zip(motion).for_each(|(force, moved)| *force -= along * moved);
        }
    }

    /// Returns the amounts of all rigid motions, by their numbers, if the unknowns are `x` under forces that hold them.
    ///
    /// * `stiffness`: `S x`.
    pub(crate) fn amounts(&self, x: &[f64], stiffness: &[f64]) -> Vec<f64> {
        let mut amounts = vec![0.0; self.system.rows.motions.len()];
        let of_obstacles = self.len() - self.obstacles.len()..;
        self.obstacles.iter().zip(&x[of_obstacles]).for_each(|(number, amount)| amounts[*number] = *amount);
        for part in self.parts.iter().filter(|part| !part.numbers.is_empty()) {
            let own = part.unknowns.clone();
            let strained = DVector::from_vec(part.flexibility(&stiffness[own.clone()]));
            let rest = DVector::from_column_slice(&x[own]) - strained;
            let coefficients = part.basis.tr_mul(&rest) + part.moved_by_load();
            let of_body = part.motions.expanded(coefficients.as_slice());
            part.numbers.iter().zip(of_body).for_each(|(number, amount)| amounts[*number] = amount);
        }
        amounts
    }
}

/// Computes the sum of the traces of a row, m.
pub(crate) fn traced(terms: &[(usize, f64)], x: &[f64]) -> f64 {
    terms.iter().map(|(k, a)| a * x[*k]).sum()
}

fn next(end: &mut usize, len: usize) -> Range<usize> {
    let start = *end;
    *end += len;
    start..*end
}

impl<'a> Part<'a> {
    /// `None` if its motions are not seen.
    fn new(
        system: &ContactSystem<'a>,
        body: usize,
        unknowns: Range<usize>,
        resisted: &[usize],
    ) -> Option<Self> {
        let condensed = system.bodies[body];
        let (mut numbers, mut columns, mut loads) = (Vec::new(), Vec::new(), Vec::new());
        let (mut all, mut count) = (Vec::new(), 0);
        let of_body = |(_, of): &(usize, &RowMotion)| of.partner == Partner::Body(body);
        for (number, of) in system.rows.motions.iter().enumerate().filter(of_body) {
            all.extend_from_slice(&system.free[number]);
            count += 1;
            if resisted.contains(&number) {
                numbers.push(number);
                columns.extend_from_slice(&system.free[number]);
                loads.push(of.load);
            }
        }
        let free = IndependentRows::new(&all, &vec![0.0; count]).rows;
        let motions = IndependentRows::new(&columns, &loads);
        let basis = DMatrix::from_column_slice(unknowns.len(), motions.right_side.len(), &motions.rows);
        let mut moved = DMatrix::zeros(basis.nrows(), basis.ncols());
        for (q, mut to) in basis.column_iter().zip(moved.column_iter_mut()) {
            condensed.apply_schur(q.as_slice(), to.as_mut_slice());
        }
        let inverse = basis.tr_mul(&moved).try_inverse()?;
        let matrix = OnceLock::new();
        Some(Self { condensed, unknowns, numbers, motions, basis, moved, inverse, free, matrix })
    }

    fn stiffness(&self, x: &[f64]) -> Vec<f64> {
        let mut forces = DVector::zeros(x.len());
        self.condensed.apply_schur(x, forces.as_mut_slice());
        self.without_springs(forces)
    }

    /// Computes `S x` from the columns of the given unknowns, N/m.
    fn stiffness_sparse(&self, x: &[(usize, f64)]) -> Vec<f64> {
        let mut forces = DVector::zeros(self.unknowns.len());
        for (unknown, value) in x {
            let column = self.condensed.schur().chunks(forces.len()).nth(unknown - self.unknowns.start);
            let terms = forces.iter_mut().zip(column.unwrap_or_default());
            terms.for_each(|(force, stiffness)| *force += value * stiffness);
        }
        self.without_springs(forces)
    }

    /// Takes the forces of the springs out of forces under `S_s`.
    fn without_springs(&self, mut forces: DVector<f64>) -> Vec<f64> {
        if self.basis.ncols() > 0 {
            let held = &self.inverse * self.basis.tr_mul(&forces);
            forces -= &self.moved * held;
        }
        forces.data.into()
    }

    fn flexibility(&self, f: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; f.len()];
        self.condensed.trace_from_force(f, &mut x);
        x
    }

    /// Returns the condensed load in balance with the loads of its motions.
    fn load(&self) -> Vec<f64> {
        let load = DVector::from_column_slice(self.condensed.condensed_load());
        (load + &self.moved * self.moved_by_load()).data.into()
    }

    /// Computes the motion `a` whose springs take the condensed load to balance, `g̃ + S_s Q a`.
    fn moved_by_load(&self) -> DVector<f64> {
        let load = DVector::from_column_slice(self.condensed.condensed_load());
        &self.inverse * (DVector::from_column_slice(&self.motions.right_side) - self.basis.tr_mul(&load))
    }

    fn diagonal(&self) -> Vec<f64> {
        let n = self.unknowns.len();
        let springs = (&self.moved * &self.inverse).component_mul(&self.moved).column_sum();
        (0..n).map(|k| self.condensed.schur()[k * (n + 1)] - springs[k]).collect()
    }
}

/// Computes the energy of forces in balance, `fᵀ S⁺ f`.
pub(crate) fn energy(broken: &Broken<'_>, forces: &[f64]) -> f64 {
    dot(forces, &broken.flexibility(forces))
}
