//! The values of a factor: front by front, children before parents.
//!
//! A front gathers its columns of the matrix and the updates its children leave, eliminates its columns by
//! dense algebra, and leaves its own update, `U = A₂₂ − L₂₁ L₂₁ᵀ`, to its parent.

use super::CholeskyError;
use super::symbolic::{Layout, SymbolicCholesky};
use crate::sparse::SymmetricCsc;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{
    LltError, LltRegularization, cholesky_in_place, cholesky_in_place_scratch,
};
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, MatMut, MatRef, Par};

/// Updates of at most this many rows are computed whole.
const WHOLE: usize = 96;

/// Buffers a task keeps for reuse.
const KEPT: usize = 16;

/// Subtrees of at least this many operations are worth a task of their own.
const TASK: f64 = 2e6;

pub(super) fn factorise(
    symbolic: &SymbolicCholesky,
    matrix: &SymmetricCsc,
) -> Result<Vec<f64>, CholeskyError> {
    let dimension = symbolic.dimension();
    let mut values = zeros(symbolic.stored_values(), dimension)?;
    let mut pool = Pool::default();
    let work = Work { symbolic, matrix };
    // The roots are the fronts that no subtree contains.
    let mut next = symbolic.layouts().len();
    let mut rest = values.as_mut_slice();
    while next > 0 {
        let root = next - 1;
        next = symbolic.layouts()[root].subtree;
        let start = symbolic.layouts()[next].values.start;
        let (before, own) = rest.split_at_mut(start);
        let update = work.subtree(root, own, &mut pool)?;
        pool.give_back(update);
        rest = before;
    }
    Ok(values)
}

struct Work<'a> {
    symbolic: &'a SymbolicCholesky,
    matrix: &'a SymmetricCsc,
}

impl Work<'_> {
    /// Factorises the subtree of front `s` in its part of the factor; returns the update for the parent,
    /// `b × b` column-major, lower part.
    fn subtree(&self, s: usize, values: &mut [f64], pool: &mut Pool) -> Result<Vec<f64>, CholeskyError> {
        let layouts = self.symbolic.layouts();
        let layout = &layouts[s];
        let start = layouts[layout.subtree].values.start;
        let (below, panel) = values.split_at_mut(layout.values.start - start);
        let updates = self.children(s, below, pool)?;
        let b = layout.rows.len();
        let mut update = pool.take(b * b, self.symbolic.dimension())?;
        self.gather(layout, panel);
        for (child, from) in updates {
            self.extend_add(&layouts[child], &from, layout, panel, &mut update);
            pool.give_back(from);
        }
        self.eliminate(layout, panel, &mut update)?;
        Ok(update)
    }

    /// Factorises the children's subtrees, large ones at the same time.
    fn children(
        &self,
        s: usize,
        values: &mut [f64],
        pool: &mut Pool,
    ) -> Result<Vec<(usize, Vec<f64>)>, CholeskyError> {
        let layouts = self.symbolic.layouts();
        let base = layouts[layouts[s].subtree].values.start;
        let mut tasks = Vec::new();
        let mut rest = values;
        let mut next = s;
        while next > layouts[s].subtree {
            let child = next - 1;
            next = layouts[child].subtree;
            let (head, own) = rest.split_at_mut(layouts[next].values.start - base);
            rest = head;
            tasks.push((child, own));
        }
        // In ascending order, so that updates are added in the same order always.
        tasks.reverse();
        if tasks.iter().filter(|(child, _)| layouts[*child].flops > TASK).count() < 2 {
            return self.in_turn(tasks, pool);
        }
        let last = tasks.split_off(tasks.len() / 2);
        let (first, second) =
            rayon::join(|| self.in_turn(tasks, pool), || self.in_turn(last, &mut Pool::default()));
        let mut updates = first?;
        updates.extend(second?);
        Ok(updates)
    }

    fn in_turn(
        &self,
        tasks: Vec<(usize, &mut [f64])>,
        pool: &mut Pool,
    ) -> Result<Vec<(usize, Vec<f64>)>, CholeskyError> {
        tasks.into_iter().map(|(child, own)| Ok((child, self.subtree(child, own, pool)?))).collect()
    }

    /// Puts the front's columns of the matrix in its panel.
    fn gather(&self, layout: &Layout, panel: &mut [f64]) {
        let rows = self.symbolic.below(layout);
        let height = layout.width + rows.len();
        for k in 0..layout.width {
            let column = &mut panel[k * height..(k + 1) * height];
            let mut next = 0;
            for (i, value) in self.matrix.column(layout.first + k) {
                let place = if i < layout.first + layout.width {
                    i - layout.first
                } else {
                    while (rows[next] as usize) < i {
                        next += 1;
                    }
                    layout.width + next
                };
                column[place] = value;
            }
        }
    }

    /// Adds a child's update to the front.
    fn extend_add(
        &self,
        child: &Layout,
        from: &[f64],
        layout: &Layout,
        panel: &mut [f64],
        update: &mut [f64],
    ) {
        let place = self.symbolic.in_parent(child);
        let (count, b) = (place.len(), layout.rows.len());
        let height = layout.width + b;
        for (j, &column) in place.iter().enumerate() {
            let source = &from[j * count + j..(j + 1) * count];
            let column = column as usize;
            if column < layout.width {
                let target = &mut panel[column * height..(column + 1) * height];
                for (value, &row) in source.iter().zip(&place[j..]) {
                    target[row as usize] += value;
                }
            } else {
                let column = column - layout.width;
                let target = &mut update[column * b..(column + 1) * b];
                for (value, &row) in source.iter().zip(&place[j..]) {
                    target[row as usize - layout.width] += value;
                }
            }
        }
    }

    /// Eliminates the front's columns: `L₁₁ L₁₁ᵀ = A₁₁`, `L₂₁ = A₂₁ L₁₁⁻ᵀ`, `U = A₂₂ − L₂₁ L₂₁ᵀ`.
    fn eliminate(&self, layout: &Layout, panel: &mut [f64], update: &mut [f64]) -> Result<(), CholeskyError> {
        let (w, b) = (layout.width, layout.rows.len());
        let dimension = self.symbolic.dimension();
        let panel = MatMut::from_column_major_slice_mut(panel, w + b, w);
        let (mut top, bottom) = panel.split_at_row_mut(w);
        let mut memory =
            MemBuffer::try_new(cholesky_in_place_scratch::<f64>(w, Par::Seq, Default::default()))
                .map_err(|_| CholeskyError::OutOfMemory { dimension })?;
        cholesky_in_place(
            top.as_mut(),
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .map_err(|LltError::NonPositivePivot { index }| CholeskyError::NotPositiveDefinite {
            pivot: layout.first + index,
            dimension,
        })?;
        if b == 0 {
            return Ok(());
        }
        let mut bottom = bottom;
        solve_lower_triangular_in_place(top.as_ref(), bottom.as_mut().transpose_mut(), Par::Seq);
        let l: MatRef<'_, f64> = bottom.as_ref();
        let update = MatMut::from_column_major_slice_mut(update, b, b);
        if b <= WHOLE {
            // Nobody reads the upper half; one call for all of it is cheaper than several for the lower one.
            matmul(update, Accum::Add, l, l.transpose(), -1.0, Par::Seq);
        } else {
            let (lower, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
            triangular::matmul(update, lower, Accum::Add, l, whole, l.transpose(), whole, -1.0, Par::Seq);
        }
        Ok(())
    }
}

/// Update matrices that one task has done with: touching fresh memory costs more than the algebra of a
/// small front.
#[derive(Default)]
struct Pool {
    free: Vec<Vec<f64>>,
}

impl Pool {
    /// Takes a buffer of `count` zeros.
    fn take(&mut self, count: usize, dimension: usize) -> Result<Vec<f64>, CholeskyError> {
        let fits = |v: &Vec<f64>| v.capacity() >= count;
        // The one last given back is the one still in the cache.
        match self.free.iter().rposition(fits) {
            Some(k) => {
                let mut buffer = self.free.swap_remove(k);
                buffer.clear();
                buffer.resize(count, 0.0);
                Ok(buffer)
            }
            None => zeros(count, dimension),
        }
    }

    fn give_back(&mut self, buffer: Vec<f64>) {
        if buffer.capacity() > 0 && self.free.len() < KEPT {
            self.free.push(buffer);
        }
    }
}

/// Makes zeros without touching them, after asking whether there is room.
fn zeros(count: usize, dimension: usize) -> Result<Vec<f64>, CholeskyError> {
    Vec::<f64>::new().try_reserve_exact(count).map_err(|_| CholeskyError::OutOfMemory { dimension })?;
    Ok(vec![0.0; count])
}
