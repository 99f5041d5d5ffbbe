//! Inverses of the stars' blocks, one block of the same size in each lane.

use crate::lanes::{LaneRow, MOST_LANES};

/// A pivot of a block in double precision below this fraction of its diagonal entry is round-off: its unknown is omitted from the star.
pub(crate) const ROUND_OFF: f64 = 1e-12;

/// Place of entry (i, j) of a symmetric matrix in its lower half by rows.
pub(crate) const fn packed(i: usize, j: usize) -> usize {
    if i < j { j * (j + 1) / 2 + i } else { i * (i + 1) / 2 + j }
}

/// Inverts positive semi-definite blocks in place, lower half by rows: on the unknowns with a valid pivot; rows and columns of the others become
/// zero.
///
/// * `floor`: a pivot below this fraction of its diagonal entry is not valid; `columns`: working space.
pub(crate) fn invert(blocks: &mut [LaneRow], size: usize, floor: f64, columns: &mut Vec<LaneRow>) {
    pulp::Arch::new().dispatch(Inversion { blocks, size, floor, columns });
}

/// [`invert()`], for [`pulp`] to compile for every kind of processor.
struct Inversion<'a> {
    blocks: &'a mut [LaneRow],
    size: usize,
    floor: f64,
    columns: &'a mut Vec<LaneRow>,
}

impl pulp::NullaryFnOnce for Inversion<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        invert_lanes(self.blocks, self.size, self.floor, self.columns);
    }
}

/// Computes `a − b c`.
#[inline(always)]
fn minus(a: LaneRow, b: LaneRow, c: LaneRow) -> LaneRow {
    std::array::from_fn(|l| a[l] - b[l] * c[l])
}

/// Computes `a b`.
#[inline(always)]
fn times(a: LaneRow, b: LaneRow) -> LaneRow {
    std::array::from_fn(|l| a[l] * b[l])
}

/// Computes `a − Σ b c`.
#[inline(always)]
fn less<'a>(a: LaneRow, products: impl Iterator<Item = (&'a LaneRow, &'a LaneRow)>) -> LaneRow {
    products.fold(a, |a, (b, c)| minus(a, *b, *c))
}

/// Inverts blocks in place. `columns` is working space.
#[inline(always)]
fn invert_lanes(a: &mut [LaneRow], size: usize, floor: f64, columns: &mut Vec<LaneRow>) {
    // L, with the inverses of its pivots on the diagonal: zero, like their rows, for invalid ones.
    for i in 0..size {
        let (above, rest) = a.split_at_mut(packed(i, 0));
        let row = &mut rest[..=i];
        for j in 0..i {
            let other = &above[packed(j, 0)..=packed(j, j)];
            row[j] = times(less(row[j], row[..j].iter().zip(other)), other[j]);
        }
        let (before, diagonal) = row.split_at_mut(i);
        let pivot = less(diagonal[0], before.iter().zip(before.iter()));
        let sound: [bool; MOST_LANES] = std::array::from_fn(|l| pivot[l] > floor * diagonal[0][l]);
        for x in before {
            *x = std::array::from_fn(|l| if sound[l] { x[l] } else { 0.0 });
        }
        diagonal[0] = std::array::from_fn(|l| if sound[l] { 1.0 / pivot[l].sqrt() } else { 0.0 });
    }
    // L⁻¹, column by column.
    columns.clear();
    columns.resize(size * size, LaneRow::default());
    for (j, column) in columns.chunks_exact_mut(size).enumerate() {
        column[j] = a[packed(j, j)];
        for i in j + 1..size {
            let row = &a[packed(i, 0)..=packed(i, i)];
            column[i] = times(less(LaneRow::default(), row[j..i].iter().zip(&column[j..i])), row[i]);
        }
    }
    // L⁻ᵀ L⁻¹
    for i in 0..size {
        let own = &columns[i * size + i..(i + 1) * size];
        for (entry, column) in a[packed(i, 0)..=packed(i, i)].iter_mut().zip(columns.chunks_exact(size)) {
            *entry = less(LaneRow::default(), own.iter().zip(&column[i..])).map(|x| -x);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows 0, 2 and 3 of a positive matrix; row 1 is zero and row 4 the sum of 0 and 2.
    fn singular(scale: f64) -> [[f64; 5]; 5] {
        let small = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 2.0]];
        let from = |i: usize| -> Vec<(usize, f64)> {
            match i {
                0 => vec![(0, 1.0)],
                2 => vec![(1, 1.0)],
                3 => vec![(2, 1.0)],
                4 => vec![(0, 1.0), (1, 1.0)],
                _ => vec![],
            }
        };
        let entry = |i, j| {
            let products =
                from(i).into_iter().flat_map(|(p, f)| from(j).into_iter().map(move |(q, g)| (p, q, f * g)));
            products.map(|(p, q, f)| scale * f * small[p][q]).sum()
        };
        std::array::from_fn(|i| std::array::from_fn(|j| entry(i, j)))
    }

    #[test]
    fn inverses_leave_out_what_has_no_pivot_whatever_is_beside_them() {
        let all: [_; MOST_LANES] = std::array::from_fn(|lane| singular(1.0 + lane as f64));
        let lower = (0..5).flat_map(|i| (0..=i).map(move |j| (i, j)));
        let mut blocks: Vec<LaneRow> =
            lower.map(|(i, j)| std::array::from_fn(|lane| all[lane][i][j])).collect();
        invert(&mut blocks, 5, ROUND_OFF, &mut Vec::new());
        for (lane, full) in all.iter().enumerate() {
            let inverse = |i: usize, j: usize| blocks[packed(i, j)][lane];
            for i in 0..5 {
                for j in 0..5 {
                    let product: f64 = (0..5).map(|m| inverse(i, m) * full[m][j]).sum();
                    let sound = |m: usize| [0, 2, 3].contains(&m);
                    if sound(i) && sound(j) {
                        assert!((product - f64::from(u8::from(i == j))).abs() < 1e-12, "{i} {j} {product}");
                    } else if !sound(i) {
                        assert_eq!(inverse(i, j), 0.0);
                    }
                }
            }
        }
    }
}
