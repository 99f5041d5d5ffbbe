//! Many short lists of numbers with their values, without memory of their own.

use crate::broken::Sparse;

/// Lists, one after the other.
#[derive(Default)]
pub(crate) struct Lists {
    ends: Vec<usize>,
    entries: Sparse,
}

impl<'l> FromIterator<&'l [(usize, f64)]> for Lists {
    fn from_iter<T: IntoIterator<Item = &'l [(usize, f64)]>>(lists: T) -> Self {
        let mut found = Self::default();
        for list in lists {
            found.entries.extend_from_slice(list);
            found.ends.push(found.entries.len());
        }
        found.entries.shrink_to_fit();
        found
    }
}

impl Lists {
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    pub(crate) fn get(&self, k: usize) -> &[(usize, f64)] {
        let start = if k == 0 { 0 } else { self.ends[k - 1] };
        &self.entries[start..self.ends[k]]
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &[(usize, f64)]> {
        (0..self.len()).map(|k| self.get(k))
    }

    /// Lists the numbers of the lists that have each of `count` numbers, ascending, with the same values.
    pub(crate) fn transposed(&self, count: usize) -> Self {
        let mut ends = vec![0; count];
        self.entries.iter().for_each(|(j, _)| ends[*j] += 1);
        let mut start = 0;
        for end in &mut ends {
            start += std::mem::replace(end, start);
        }
        let mut entries = vec![(0, 0.0); self.entries.len()];
        for (k, list) in self.iter().enumerate() {
            for (j, value) in list {
                entries[ends[*j]] = (k, *value);
                ends[*j] += 1;
            }
        }
        Self { ends, entries }
    }
}

#[cfg(test)]
mod tests {
    use super::Lists;

    #[test]
    fn a_transposed_list_has_the_same_values() {
        let lists: [&[(usize, f64)]; 3] = [&[(2, 1.0), (0, 2.0)], &[], &[(2, 3.0)]];
        let turned = lists.into_iter().collect::<Lists>().transposed(4);
        let found: Vec<_> = turned.iter().collect();
        assert_eq!(found, [&[(0, 2.0)][..], &[], &[(0, 1.0), (2, 3.0)], &[]]);
    }
}
