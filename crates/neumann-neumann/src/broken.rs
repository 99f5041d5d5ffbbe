//! All bodies in their interface unknowns, side by side: rows of any number of terms, dependent ones among them.
//!
//! A body that was cut is its subdomains, which share displacements: the first of several unknowns that are one displacement leads the others, and rows
//! are in leading unknowns. The amounts of the free motions of obstacles follow the unknowns of the bodies, as a body without stiffness.

mod home;

use crate::error::BalancingError;
use crate::structure::Structure;
use crate::vector::dot;
use contact_qp::IndependentRows;
use fem_core::condensation::InterfaceOperator;
use fem_core::contact_system::{ContactRow, ContactSystem, Partner, SharedUnknowns};
use fem_core::each_body;
use home::{Home, homes, own_part};
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Numbers with their values, ascending.
pub type Sparse = Vec<(usize, f64)>;

/// A rigid motion of length 1 that keeps less than this beside the others depends on them.
const DEPENDENT: f64 = 1e-8;

/// All bodies, with the opening `o = c − B x` of each row.
pub struct Broken<'a> {
    system: Cow<'a, ContactSystem<'a>>,
    parts: Vec<Part<'a>>,
    /// The unknown that leads each one: itself, unless subdomains share its displacement.
    leaders: Vec<usize>,
    shares: bool,
    /// The terms of `B` by row.
    pub rows: Vec<Vec<(usize, f64)>>,
    /// `c`, the gap less what supports and obstacles impose, by row, m.
    pub gaps: Vec<f64>,
    /// The loads of the bodies.
    pub load: Load,
    /// The weights of the unknowns: the diagonal of `S`, of subdomains that of their stiffness, N/m²; 0 of an obstacle.
    pub diagonal: Vec<f64>,
    /// The numbers of the motions of obstacles, in the order of their unknowns.
    obstacles: Vec<usize>,
    /// The numbers of the motions that the pairs resist.
    resisted: Vec<usize>,
    /// The last structure of the matrix of the coarse space.
    pub(crate) structure: Mutex<Option<Arc<Structure>>>,
}

/// Loads, condensed on the interfaces.
#[derive(Clone, Debug)]
pub struct Load {
    /// The forces on the unknowns that hold traces of zero, N/m: `S x + Bᵀ P = load`.
    pub forces: Vec<f64>,
    /// The energy of the bodies under their condensed loads alone, `gᵀ S⁺ g`: traces may be zero where bodies are strained.
    pub size: f64,
}

/// A body or a subdomain. With `S_s` of the body on its springs, which it has if it floats, and `Q` an orthonormal basis of its free motions, the body
/// alone has `S = S_s − S_s Q (Qᵀ S_s Q)⁻¹ Qᵀ S_s`.
struct Part<'a> {
    condensed: &'a InterfaceOperator,
    /// Its unknowns.
    unknowns: Range<usize>,
    /// The numbers of its motions, what makes them independent, and `Q`; of a subdomain see `home`.
    numbers: Vec<usize>,
    motions: IndependentRows,
    basis: DMatrix<f64>,
    /// Of a subdomain on whose springs its body rests.
    home: Option<Home>,
    /// `S_s Q`, and `(Qᵀ S_s Q)⁻¹`.
    moved: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// An orthonormal basis of all its free motions, column after column, if it is not `Q`: those that the pairs do not resist keep their springs.
    free: Option<Vec<f64>>,
    /// `S_s⁻¹`, if it was asked for.
    matrix: OnceLock<Vec<f64>>,
    /// The last traces of [`Broken::energies`], and what they gave.
    energies: Mutex<Option<(Traces, Arc<[f64]>)>>,
}

/// Entries of a sparse matrix of traces by row and column, m.
pub(crate) type Traces = Vec<(u32, u32, f64)>;

impl<'a> Broken<'a> {
    /// * `resisted`: the numbers of the motions that the pairs resist; the springs of the others stay, and keep them at zero.
    ///
    /// # Errors
    /// [`BalancingError::DependentRows`] if the springs of a floating body are not seen on its interface.
    pub fn new(system: Cow<'a, ContactSystem<'a>>, resisted: &[usize]) -> Result<Self, BalancingError> {
        let mut end = 0;
        let ranges: Vec<Range<usize>> = system.bodies.iter().map(|body| next(&mut end, body.len())).collect();
        let homes = homes(&system, &ranges);
        let made = each_body(ranges.len(), |b| Part::new(&system, (b, &ranges), &homes, resisted));
        let whole = |(k, part): (usize, Option<Part<'a>>)| {
            part.ok_or(BalancingError::DependentRows { body: system.body_of[k] })
        };
        let parts: Vec<Part<'a>> = made.into_iter().enumerate().map(whole).collect::<Result<_, _>>()?;
        let mut leaders: Vec<usize> = (0..end).collect();
        let mut first: HashMap<(usize, u32), usize> = HashMap::new();
        for ((part, body), of) in parts.iter().zip(&system.body_of).zip(&system.subdomains) {
            for (unknown, number) in part.unknowns.clone().zip(&of.numbers) {
                leaders[unknown] = *first.entry((*body, *number)).or_insert(unknown);
            }
        }
        let loads: Vec<Vec<f64>> = parts.iter().map(Part::own_load).collect();
        let size = parts.iter().zip(&loads).map(|(part, load)| dot(load, &part.flexibility(load))).sum();
        let mut forces = loads.concat();
        let diagonal = |(part, of): (&Part<'a>, &SharedUnknowns)| match of.stiffness.is_empty() {
            true => part.diagonal(),
            false => of.stiffness.clone(),
        };
        let mut diagonal: Vec<f64> = parts.iter().zip(&system.subdomains).flat_map(diagonal).collect();
        let gap = |row: &ContactRow| row.gap - row.obstacle.unwrap_or(0.0);
        let mut gaps: Vec<f64> = system.rows.rows.iter().map(gap).collect();
        let mut rows = vec![Vec::new(); gaps.len()];
        for (part, of_body) in parts.iter().zip(&system.of_body) {
            for row in of_body {
                gaps[row.row] -= row.imposed;
                rows[row.row].extend(row.terms.iter().map(|(k, a)| (leaders[part.unknowns.start + k], *a)));
            }
        }
        let mut obstacles = Vec::new();
        for (number, of) in system.rows.motions.iter().enumerate().filter(|(_, of)| of.partner.is_obstacle())
        {
            let entries = of.traces.iter().filter(|(_, trace)| *trace != 0.0);
            entries.for_each(|(row, trace)| rows[*row].push((forces.len(), *trace)));
            leaders.push(forces.len());
            forces.push(of.load);
            diagonal.push(0.0);
            obstacles.push(number);
        }
        let shares = system.has_subdomains();
        let load = Load { forces, size };
        let (resisted, structure) = (resisted.to_vec(), Mutex::default());
        Ok(Self {
            system,
            parts,
            leaders,
            shares,
            rows,
            gaps,
            load,
            diagonal,
            obstacles,
            resisted,
            structure,
        })
    }

    /// Returns the system.
    pub fn system(&self) -> &ContactSystem<'a> {
        &self.system
    }

    /// Tells whether subdomains share displacements.
    pub fn shares(&self) -> bool {
        self.shares
    }

    /// Returns the unknown that leads another one: itself, unless subdomains share its displacement.
    pub fn leader(&self, unknown: usize) -> usize {
        self.leaders[unknown]
    }

    /// Gives unknowns that are one displacement the value of the one that leads them.
    pub fn spread(&self, x: &mut [f64]) {
        if self.shares {
            (0..x.len()).for_each(|k| x[k] = x[self.leaders[k]]);
        }
    }

    /// Adds forces on unknowns that are one displacement up at the one that leads them, N/m.
    pub fn gathered(&self, mut forces: Vec<f64>) -> Vec<f64> {
        if self.shares {
            for k in 0..forces.len() {
                let leader = self.leaders[k];
                if leader != k {
                    forces[leader] += std::mem::take(&mut forces[k]);
                }
            }
        }
        forces
    }

    /// Condenses other loads of the bodies.
    ///
    /// * `loads`: of each body the condensed load, and the loads along its free motions, N/m.
    pub fn load_of(&self, loads: &[(Vec<f64>, Vec<f64>)]) -> Load {
        let of = |(part, (load, along)): (&Part<'a>, &(Vec<f64>, Vec<f64>))| part.load(load, along);
        let loads: Vec<Vec<f64>> = self.parts.iter().zip(loads).map(of).collect();
        let energy = |(part, load): (&Part<'a>, &Vec<f64>)| dot(load, &part.flexibility(load));
        let size = self.parts.iter().zip(&loads).map(energy).sum();
        let mut forces = loads.concat();
        forces.resize(self.len(), 0.0);
        Load { forces, size }
    }

    /// Counts the unknowns, those of obstacles last.
    pub fn len(&self) -> usize {
        self.diagonal.len()
    }

    /// Tells whether there are no unknowns.
    pub fn is_empty(&self) -> bool {
        self.diagonal.is_empty()
    }

    /// Tells whether an unknown belongs to an obstacle.
    pub fn is_obstacle(&self, unknown: usize) -> bool {
        unknown + self.obstacles.len() >= self.len()
    }

    /// Returns the unknowns of a body.
    pub fn of_body(&self, body: usize) -> Range<usize> {
        self.parts[body].unknowns.clone()
    }

    /// Tells whether a body has free motions.
    pub fn floats(&self, body: usize) -> bool {
        self.system.floats(body)
    }

    /// Computes `S x`, N/m.
    pub fn stiffness(&self, x: &[f64]) -> Vec<f64> {
        self.each(x, |part, x| part.stiffness(x))
    }

    /// Computes `S⁺ f`, m, for forces that balance each floating body.
    pub fn flexibility(&self, f: &[f64]) -> Vec<f64> {
        self.each(f, Part::flexibility)
    }

    /// Returns `S_s⁻¹` of a body, column-major, m²/N; computed once.
    pub fn flexibility_matrix(&self, body: usize) -> &[f64] {
        let Part { condensed, matrix, .. } = &self.parts[body];
        matrix.get_or_init(|| condensed.flexibility())
    }

    /// Returns an orthonormal basis `Q` of the free motions of a body that the pairs resist.
    pub fn basis(&self, body: usize) -> &DMatrix<f64> {
        &self.parts[body].basis
    }

    /// Computes the upper triangle of `VᵀS V` of some traces of a body, column after column, N/m. If there are rows, the last result is kept: most bodies have the same traces on the next set
    /// of closed ones.
    ///
    /// * `traces`: `V` by row, column, entry, m; `count`: its columns.
    pub fn energies(&self, body: usize, traces: Traces, count: usize) -> Arc<[f64]> {
        let part = &self.parts[body];
        let mut last = part.energies.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, energies)) = last.as_ref().filter(|(known, _)| *known == traces) {
            return energies.clone();
        }
        let mut columns = DMatrix::zeros(part.unknowns.len(), count);
        traces.iter().for_each(|(row, column, value)| columns[(*row as usize, *column as usize)] += value);
        let energies = part.energies_of(&columns);
        let upper = (0..count).flat_map(|column| energies.column(column).into_iter().take(column + 1));
        let energies: Arc<[f64]> = upper.copied().collect();
        if !self.rows.is_empty() {
            *last = Some((traces, energies.clone()));
        }
        energies
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
    pub fn openings(&self, x: &[f64]) -> Vec<f64> {
        let opening = |(gap, terms): (&f64, &Vec<(usize, f64)>)| gap - traced(terms, x);
        self.gaps.iter().zip(&self.rows).map(opening).collect()
    }

    /// Computes `Bᵀ P`, N/m.
    pub fn pressed(&self, forces: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.len()];
        for (terms, force) in self.rows.iter().zip(forces).filter(|(_, force)| **force != 0.0) {
            terms.iter().for_each(|(k, a)| sum[*k] += a * force);
        }
        sum
    }

    /// Lists the columns of the coarse space in all unknowns, sparse: all rigid motions of every body, held or not, independent of each other, and of the
    /// obstacles.
    pub fn motions(&self) -> Vec<Sparse> {
        let mut found = Vec::new();
        let mut push = |start: usize, values: &[f64]| {
            let column = values.iter().enumerate().filter(|(_, value)| **value != 0.0);
            found.push(column.map(|(k, value)| (start + k, *value)).collect());
        };
        for (part, rigid) in self.parts.iter().zip(&self.system.rigid) {
            let mut own: Vec<DVector<f64>> = part.basis.column_iter().map(|q| q.clone_owned()).collect();
            // Those along which a subdomain rests on its springs.
            let held = part.free.iter().filter(|_| part.home.is_some());
            let held = held.flat_map(|free| free.chunks_exact(part.unknowns.len().max(1)));
            // The free motions of a body that supports hold in part are among its rigid ones.
            for motion in rigid.iter().map(Vec::as_slice).chain(held).map(DVector::from_column_slice) {
                let mut rest = &motion / motion.norm();
                for _ in 0..2 {
                    own.iter().for_each(|q| rest -= q * q.dot(&rest));
                }
                if rest.norm() > DEPENDENT {
                    own.push(rest.normalize());
                }
            }
            own.iter().for_each(|motion| push(part.unknowns.start, motion.as_slice()));
        }
        (0..self.len()).filter(|k| self.is_obstacle(*k)).for_each(|k| push(k, &[1.0]));
        found
    }

    /// Adds a rigid motion of a body or obstacle to its unknowns.
    pub fn add_motion(&self, number: usize, amount: f64, x: &mut [f64]) {
        match self.system.rows.motions[number].partner {
            Partner::Body(body) => {
                let Some(place) = self.system.body_of.iter().position(|of| *of == body) else { return };
                let own = x[self.of_body(place).start..].iter_mut().zip(&self.system.free[number]);
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
    pub fn without_motions(&self, body: usize, forces: &mut [f64]) {
        let part = &self.parts[body];
        let own = &mut forces[part.unknowns.clone()];
        let free = part.free.as_deref().unwrap_or(part.basis.as_slice());
        for motion in free.chunks_exact(own.len().max(1)) {
            let along = dot(motion, own);
            own.iter_mut().zip(motion).for_each(|(force, moved)| *force -= along * moved);
        }
    }

    /// Returns the amounts of all rigid motions, by their numbers, if the unknowns are `x` under forces that hold them; of a body in subdomains those of the
    /// rigid motion that is nearest to `x`.
    ///
    /// * `stiffness`: `S x`.
    pub fn amounts(&self, x: &[f64], stiffness: &[f64]) -> Vec<f64> {
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
        for (part, body) in self.parts.iter().zip(&self.system.body_of) {
            let Some(Home { numbers, inverse, .. }) = &part.home else { continue };
            let Some(first) = self.system.body_of.iter().position(|of| of == body) else { continue };
            let own = &x[self.of_body(first).start..];
            let along = |number: &usize| dot(&self.system.free[*number], own);
            let found = inverse * DVector::from_iterator(numbers.len(), numbers.iter().map(along));
            numbers.iter().zip(&found).for_each(|(number, amount)| amounts[*number] = *amount);
        }
        amounts
    }
}

/// Computes the sum of the traces of a row, m.
pub fn traced(terms: &[(usize, f64)], x: &[f64]) -> f64 {
    terms.iter().map(|(k, a)| a * x[*k]).sum()
}

fn next(end: &mut usize, len: usize) -> Range<usize> {
    let start = *end;
    *end += len;
    start..*end
}

impl<'a> Part<'a> {
    /// * `homes`: see [`homes`].
    ///
    /// `None` if its motions are not seen.
    fn new(
        system: &ContactSystem<'a>,
        (body, ranges): (usize, &[Range<usize>]),
        homes: &[Option<usize>],
        resisted: &[usize],
    ) -> Option<Self> {
        let (condensed, unknowns) = (system.bodies[body], ranges[body].clone());
        let own = &system.subdomains[body];
        let first = system.body_of.iter().position(|of| *of == system.body_of[body])?;
        let moved = |number: &usize| own_part(&system.free[*number], ranges, first, body);
        let (mut numbers, held): (Vec<usize>, Vec<usize>) =
            (0..homes.len()).filter(|k| homes[*k] == Some(body)).partition(|k| resisted.contains(k));
        let (mut columns, mut loads) = (own.free.concat(), own.loads.clone());
        // All free motions, if springs hold some of them.
        let mut all = columns.clone();
        let mut home = None;
        if !system.is_subdomain(body) {
            columns.extend(numbers.iter().flat_map(moved));
            loads.extend(numbers.iter().map(|k| system.rows.motions[*k].load));
            all = columns.iter().chain(held.iter().flat_map(moved)).copied().collect();
        } else if !(numbers.is_empty() && held.is_empty()) {
            let of_home = Home::new(std::mem::take(&mut numbers), &held, moved, (&own.free, &system.free))?;
            if let Some(loose) = &of_home.loose {
                let free = DMatrix::from_column_slice(unknowns.len(), own.free.len(), &columns);
                columns = (free * loose.transpose()).data.into();
                loads = (loose * DVector::from_column_slice(&loads)).data.into();
            }
            home = Some(of_home);
        }
        let count = all.len() / unknowns.len().max(1);
        let free = (!held.is_empty()).then(|| IndependentRows::new(&all, &vec![0.0; count]).rows);
        let mut motions = IndependentRows::new(&columns, &loads);
        let rows = std::mem::take(&mut motions.rows);
        let basis = DMatrix::from_vec(unknowns.len(), motions.right_side.len(), rows);
        let mut moved = DMatrix::zeros(basis.nrows(), basis.ncols());
        for (q, mut to) in basis.column_iter().zip(moved.column_iter_mut()) {
            condensed.apply_schur(q.as_slice(), to.as_mut_slice());
        }
        let inverse = basis.tr_mul(&moved).try_inverse()?;
        let (matrix, energies) = (OnceLock::new(), Mutex::new(None));
        Some(Self {
            condensed,
            unknowns,
            numbers,
            motions,
            basis,
            home,
            moved,
            inverse,
            free,
            matrix,
            energies,
        })
    }

    fn stiffness(&self, x: &[f64]) -> Vec<f64> {
        let mut forces = DVector::zeros(x.len());
        self.condensed.apply_schur(x, forces.as_mut_slice());
        if self.basis.ncols() > 0 {
            let held = &self.inverse * self.basis.tr_mul(&forces);
            forces -= &self.moved * held;
        }
        forces.data.into()
    }

    fn energies_of(&self, traces: &DMatrix<f64>) -> DMatrix<f64> {
        let count = traces.ncols();
        let held = DMatrix::from_vec(count, count, self.condensed.energies(traces.as_slice()));
        if self.basis.ncols() == 0 {
            return held;
        }
        let by_springs = self.moved.tr_mul(traces);
        held - by_springs.tr_mul(&(&self.inverse * &by_springs))
    }

    fn flexibility(&self, f: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; f.len()];
        self.condensed.trace_from_force(f, &mut x);
        x
    }

    fn own_load(&self) -> Vec<f64> {
        self.balanced_load(self.condensed.condensed_load(), &self.motions.right_side)
    }

    /// Returns a condensed load in balance with the loads of its motions.
    ///
    /// * `along`: the loads of its motions, N/m.
    fn load(&self, load: &[f64], along: &[f64]) -> Vec<f64> {
        let loose = self.home.as_ref().and_then(|home| home.loose.as_ref());
        let loose = loose.map(|loose| loose * DVector::from_column_slice(along));
        let along = loose.as_ref().map_or(along, |loose| loose.as_slice());
        self.balanced_load(load, &self.motions.right_side_of(along))
    }

    /// * `along`: the loads of the columns of `Q`, N/m.
    fn balanced_load(&self, load: &[f64], along: &[f64]) -> Vec<f64> {
        let load = DVector::from_column_slice(load);
        let motion = self.moved_by(&load, along);
        (load + &self.moved * motion).data.into()
    }

    /// Computes the motion `a` whose springs take the condensed load to balance, `g̃ + S_s Q a`.
    fn moved_by_load(&self) -> DVector<f64> {
        let load = DVector::from_column_slice(self.condensed.condensed_load());
        self.moved_by(&load, &self.motions.right_side)
    }

    fn moved_by(&self, load: &DVector<f64>, along: &[f64]) -> DVector<f64> {
        &self.inverse * (DVector::from_column_slice(along) - self.basis.tr_mul(load))
    }

    fn diagonal(&self) -> Vec<f64> {
        let springs = (&self.moved * &self.inverse).component_mul(&self.moved).column_sum();
        self.condensed.diagonal().iter().zip(&springs).map(|(own, springs)| own - springs).collect()
    }
}
