//! Symmetric sparse matrices in compressed columns.

/// The lower triangle (diagonal included) of a symmetric matrix in compressed columns, rows ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct SymmetricCsc {
    /// Column `j` holds the entries `starts[j]..starts[j+1]`.
    pub starts: Vec<u32>,
    /// Row of each entry, ≥ its column.
    pub rows: Vec<u32>,
    /// Value of each entry.
    pub values: Vec<f64>,
}

impl SymmetricCsc {
    /// Returns the number of rows and columns.
    pub fn dimension(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Returns the entries `(row, value)` of the lower part of a column.
    pub fn column(&self, j: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.starts[j] as usize..self.starts[j + 1] as usize;
        range.map(|k| (self.rows[k] as usize, self.values[k]))
    }

    /// Multiplies the whole symmetric matrix by a vector.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for j in 0..self.dimension() {
            for (i, a) in self.column(j) {
                y[i] += a * x[j];
                if i != j {
                    y[j] += a * x[i];
                }
            }
        }
        y
    }

    /// Returns the leading `m × m` part.
    pub fn leading(&self, m: usize) -> Self {
        let mut part = Self { starts: vec![0], rows: Vec::new(), values: Vec::new() };
        for j in 0..m {
            for (i, a) in self.column(j).filter(|(i, _)| *i < m) {
                part.rows.push(i as u32);
                part.values.push(a);
            }
            part.starts.push(part.rows.len() as u32);
        }
        part
    }

    /// Returns the same matrix by its upper triangle: `(column starts, rows, values)`, rows ascending.
    pub fn upper(&self) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
        let n = self.dimension();
        let mut starts = vec![0usize; n + 1];
        for &i in &self.rows {
            starts[i as usize + 1] += 1;
        }
        for i in 0..n {
            starts[i + 1] += starts[i];
        }
        let mut cursor = starts.clone();
        let mut rows = vec![0; self.rows.len()];
        let mut values = vec![0.0; self.rows.len()];
        for j in 0..n {
            for (i, a) in self.column(j) {
                rows[cursor[i]] = j;
                values[cursor[i]] = a;
                cursor[i] += 1;
            }
        }
        (starts, rows, values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangle_parts_describe_one_matrix() {
        // [4 1 0; 1 5 2; 0 2 6]
        let m = SymmetricCsc {
            starts: vec![0, 2, 4, 5],
            rows: vec![0, 1, 1, 2, 2],
            values: vec![4.0, 1.0, 5.0, 2.0, 6.0],
        };
        assert_eq!(m.multiply(&[1.0, 1.0, 1.0]), vec![5.0, 8.0, 8.0]);
        assert_eq!(m.upper(), (vec![0, 1, 3, 5], vec![0, 0, 1, 1, 2], vec![4.0, 1.0, 5.0, 2.0, 6.0]));
        assert_eq!(m.leading(2).values, vec![4.0, 1.0, 5.0]);
    }
}
