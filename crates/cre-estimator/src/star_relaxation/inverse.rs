//! Inverses of the stars' blocks, several of one size at a time.

use super::airy::packed;

/// Blocks that are inverted at a time.
const LANES: usize = 8;

/// One number per block.
type Lanes = [f64; LANES];

const ZERO: Lanes = [0.0; LANES];

/// A pivot below this fraction of its diagonal entry is round-off: its unknown is omitted from the star.
const PIVOT_FLOOR: f64 = 1e-12;

/// Blocks that wait until a batch of their size is full, and working space.
#[derive(Default)]
pub(super) struct Inverter {
    waiting: Vec<Batch>,
    columns: Vec<Lanes>,
}

/// Blocks of one size, lower half by rows, and where their inverses belong.
#[derive(Default)]
struct Batch {
    blocks: Vec<Lanes>,
    targets: Vec<usize>,
}

impl Inverter {
    /// Takes a positive semi-definite block, lower half by rows. Its inverse is written to `inverses` from `target` on,
    /// now or at [`Self::finish`]: on the unknowns with a valid pivot; rows and columns of the others become zero.
    pub(super) fn push(&mut self, block: &[f64], size: usize, target: usize, inverses: &mut [f32]) {
        if self.waiting.len() <= size {
            self.waiting.resize_with(size + 1, Batch::default);
        }
        let batch = &mut self.waiting[size];
        batch.blocks.resize(block.len(), ZERO);
        let lane = batch.targets.len();
        for (lanes, x) in batch.blocks.iter_mut().zip(block) {
            lanes[lane] = *x;
        }
        batch.targets.push(target);
        if batch.targets.len() == LANES {
            batch.invert(size, &mut self.columns, inverses);
        }
    }

    /// Inverts the remaining blocks.
    pub(super) fn finish(&mut self, inverses: &mut [f32]) {
        for (size, batch) in self.waiting.iter_mut().enumerate().filter(|(_, b)| !b.targets.is_empty()) {
            // The content of idle lanes is inverted too and then ignored.
            batch.invert(size, &mut self.columns, inverses);
        }
    }
}

impl Batch {
    fn invert(&mut self, size: usize, columns: &mut Vec<Lanes>, inverses: &mut [f32]) {
        pulp::Arch::new().dispatch(Inversion { blocks: &mut self.blocks, size, columns });
        for (lane, target) in self.targets.drain(..).enumerate() {
            let inverse = &mut inverses[target..target + self.blocks.len()];
            for (x, lanes) in inverse.iter_mut().zip(&self.blocks) {
                *x = lanes[lane] as f32;
            }
        }
    }
}

/// [`invert`], for [`pulp`] to compile for every kind of processor.
struct Inversion<'a> {
    blocks: &'a mut [Lanes],
    size: usize,
    columns: &'a mut Vec<Lanes>,
}

impl pulp::NullaryFnOnce for Inversion<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        invert(self.blocks, self.size, self.columns);
    }
}

/// Computes `a − b c`.
#[inline(always)]
fn minus(a: Lanes, b: Lanes, c: Lanes) -> Lanes {
    std::array::from_fn(|l| a[l] - b[l] * c[l])
}

/// Computes `a b`.
#[inline(always)]
fn times(a: Lanes, b: Lanes) -> Lanes {
    std::array::from_fn(|l| a[l] * b[l])
}

/// Computes `a − Σ b c`.
#[inline(always)]
fn less<'a>(a: Lanes, products: impl Iterator<Item = (&'a Lanes, &'a Lanes)>) -> Lanes {
    products.fold(a, |a, (b, c)| minus(a, *b, *c))
}

/// Inverts blocks in place. `columns` is working space.
#[inline(always)]
fn invert(a: &mut [Lanes], size: usize, columns: &mut Vec<Lanes>) {
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
        let sound: [bool; LANES] = std::array::from_fn(|l| pivot[l] > PIVOT_FLOOR * diagonal[0][l]);
        for x in before {
            *x = std::array::from_fn(|l| if sound[l] { x[l] } else { 0.0 });
        }
        diagonal[0] = std::array::from_fn(|l| if sound[l] { 1.0 / pivot[l].sqrt() } else { 0.0 });
    }
    // L⁻¹, column by column.
    columns.clear();
    columns.resize(size * size, ZERO);
    for (j, column) in columns.chunks_exact_mut(size).enumerate() {
        column[j] = a[packed(j, j)];
        for i in j + 1..size {
            let row = &a[packed(i, 0)..=packed(i, i)];
            column[i] = times(less(ZERO, row[j..i].iter().zip(&column[j..i])), row[i]);
        }
    }
    // L⁻ᵀ L⁻¹
    for i in 0..size {
        let own = &columns[i * size + i..(i + 1) * size];
        for (entry, column) in a[packed(i, 0)..=packed(i, i)].iter_mut().zip(columns.chunks_exact(size)) {
            *entry = less(ZERO, own.iter().zip(&column[i..])).map(|x| -x);
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
    fn inverses_leave_out_what_has_no_pivot_whatever_waits_beside_them() {
        // More than fit in the lanes, and others of another size between them.
        let count = LANES + 3;
        let (mut inverter, mut inverses) = (Inverter::default(), vec![0.0; 16 * count + count]);
        for k in 0..count {
            let full = singular(1.0 + k as f64);
            let lower: Vec<f64> = (0..5).flat_map(|i| full[i][..=i].to_vec()).collect();
            inverter.push(&lower, 5, 16 * k, &mut inverses);
            inverter.push(&[2.0 + k as f64], 1, 16 * count + k, &mut inverses);
        }
        inverter.finish(&mut inverses);
        for k in 0..count {
            let full = singular(1.0 + k as f64);
            let inverse = |i: usize, j: usize| f64::from(inverses[16 * k + packed(i, j)]);
            for i in 0..5 {
                for j in 0..5 {
                    let product: f64 = (0..5).map(|m| inverse(i, m) * full[m][j]).sum();
                    let sound = |m: usize| [0, 2, 3].contains(&m);
                    if sound(i) && sound(j) {
                        assert!((product - f64::from(u8::from(i == j))).abs() < 1e-6, "{i} {j} {product}");
                    } else if !sound(i) {
                        assert_eq!(inverse(i, j), 0.0);
                    }
                }
            }
            assert_eq!(inverses[16 * count + k], (1.0 / (2.0 + k as f64)) as f32);
        }
    }
}
