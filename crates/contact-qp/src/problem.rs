//! A borrowed matrix, and the checks of what a caller gives.

use crate::error::QpError;

/// Largest asymmetry of a dense matrix, and largest negative entry of a diagonal, over the largest entry of the diagonal: computed
/// flexibilities have the rounding of their factors.
const ROUNDING: f64 = 1e-8;

/// A borrowed symmetric n × n matrix.
#[derive(Clone, Copy, Debug)]
pub enum MatrixView<'a> {
    /// Full matrix, both triangles stored.
    Dense {
        /// Number of rows and columns.
        n: usize,
        /// n² entries, column by column.
        values: &'a [f64],
    },
    /// Upper triangle (diagonal included) in compressed sparse columns; rows sorted and unique in each column.
    SparseUpper {
        /// Number of rows and columns.
        n: usize,
        /// Start of each column in `row_indices` and `values`; n + 1 entries, the last one their length.
        column_starts: &'a [usize],
        /// Row of each entry, at most its column.
        row_indices: &'a [usize],
        /// Value of each entry.
        values: &'a [f64],
    },
}

impl MatrixView<'_> {
    /// Checks lengths, order, finite numbers, symmetry, and the signs of the diagonal.
    pub(crate) fn check(&self) -> Result<(), QpError> {
        self.check_entries()?;
        let tolerance = ROUNDING * self.largest_diagonal();
        match (0..self.size()).find(|&i| self.diagonal(i) < -tolerance) {
            Some(index) => Err(QpError::NotPositiveDefinite { index }),
            None => Ok(()),
        }
    }

    /// Returns `max |P_ii|`.
    fn largest_diagonal(&self) -> f64 {
        (0..self.size()).map(|i| self.diagonal(i).abs()).fold(0.0, f64::max)
    }

    fn check_entries(&self) -> Result<(), QpError> {
        match *self {
            Self::Dense { n, values } => {
                // A size whose square overflows cannot match any slice.
                check_length("values", n.saturating_mul(n), values.len())?;
                check_finite("values", values)?;
                check_symmetric(n, values, ROUNDING * self.largest_diagonal())
            }
            Self::SparseUpper { n, column_starts, row_indices, values } => {
                check_length("column_starts", n.saturating_add(1), column_starts.len())?;
                check_length("values", row_indices.len(), values.len())?;
                if n == 0 {
                    check_length("values", 0, values.len())?;
                }
                check_column_starts(column_starts, values.len())?;
                (0..n)
                    .try_for_each(|j| check_rows(j, &row_indices[column_starts[j]..column_starts[j + 1]]))?;
                check_finite("values", values)
            }
        }
    }
}

pub(crate) fn check_length(what: &'static str, expected: usize, found: usize) -> Result<(), QpError> {
    if found == expected { Ok(()) } else { Err(QpError::Length { what, expected, found }) }
}

/// Checks the length of some values, and that they are finite.
pub(crate) fn check_values(what: &'static str, expected: usize, values: &[f64]) -> Result<(), QpError> {
    check_length(what, expected, values.len())?;
    check_finite(what, values)
}

pub(crate) fn check_finite(what: &'static str, values: &[f64]) -> Result<(), QpError> {
    // Without an early exit the sweep vectorises, so valid data are checked quickly.
    if values.iter().fold(true, |all, value| all & value.is_finite()) {
        return Ok(());
    }
    match values.iter().position(|value| !value.is_finite()) {
        Some(place) => Err(QpError::NotFinite { what, place, found: values[place] }),
        None => Ok(()),
    }
}

fn check_symmetric(n: usize, values: &[f64], tolerance: f64) -> Result<(), QpError> {
    // By tiles: a plain sweep would read one triangle with a stride of n and miss the cache each time.
    const TILE: usize = 32;
    for first_column in (0..n).step_by(TILE) {
        let last_column = n.min(first_column + TILE);
        for first_row in (first_column..n).step_by(TILE) {
            for column in first_column..last_column {
                for row in first_row.max(column + 1)..n.min(first_row + TILE) {
                    let (found, expected) = (values[column * n + row], values[row * n + column]);
                    if (found - expected).abs() > tolerance {
                        return Err(QpError::NotSymmetric { row, column, found, expected, tolerance });
                    }
                }
            }
        }
    }
    Ok(())
}

fn check_column_starts(starts: &[usize], entries: usize) -> Result<(), QpError> {
    let last = starts.len() - 1;
    for (place, &found) in starts.iter().enumerate() {
        let least = if place == 0 { 0 } else { starts[place - 1] };
        let most = if place == 0 { 0 } else { entries };
        let least = if place == last { entries.min(most) } else { least };
        if found < least || found > most {
            return Err(QpError::ColumnStarts { place, found, least, most });
        }
    }
    Ok(())
}

fn check_rows(column: usize, rows: &[usize]) -> Result<(), QpError> {
    for (place, &found) in rows.iter().enumerate() {
        if found > column {
            return Err(QpError::BelowDiagonal { column, found });
        }
        if place > 0 && rows[place - 1] >= found {
            return Err(QpError::RowOrder { column, previous: rows[place - 1], found });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_without_a_column_are_refused() {
        let of = |starts: &[usize], entries: usize| {
            let rows = vec![0; entries];
            let values = vec![1.0; entries];
            let view =
                MatrixView::SparseUpper { n: 0, column_starts: starts, row_indices: &rows, values: &values };
            view.check()
        };
        assert!(of(&[0], 0).is_ok());
        for starts in [[0], [5]] {
            let e = of(&starts, 5);
            assert!(matches!(e, Err(QpError::Length { what: "values", expected: 0, found: 5 })), "{e:?}");
        }
    }
}
