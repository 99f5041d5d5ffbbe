//! From the numbers a file gives to nodes or elements to their places in a list.

/// Means 'no such number' in the dense table.
const ABSENT: u32 = u32::MAX;

/// Finds the place of a number among ascending, different numbers.
pub(crate) struct NumberIndex {
    first: u64,
    table: Table,
}

enum Table {
    /// Number `first + k` has place `k`.
    Contiguous(usize),
    /// Place of number `first + k`.
    Dense(Vec<u32>),
    /// The numbers themselves, to be searched.
    Sorted(Vec<u64>),
}

impl NumberIndex {
    /// Prepares the search; `numbers` ascend without repetition, and there are fewer than 2³² of them.
    pub(crate) fn new(numbers: &[u64]) -> Self {
        let (Some(&first), Some(&last)) = (numbers.first(), numbers.last()) else {
            return Self { first: 0, table: Table::Contiguous(0) };
        };
        let span = last - first;
        let table = if span == numbers.len() as u64 - 1 {
            Table::Contiguous(numbers.len())
        } else if span / 4 < numbers.len() as u64 {
            // At most four entries per number: what a file with few holes needs, and never more than it can pay for.
            let mut dense = vec![ABSENT; span as usize + 1];
            for (place, number) in numbers.iter().enumerate() {
                dense[(number - first) as usize] = place as u32;
            }
            Table::Dense(dense)
        } else {
            Table::Sorted(numbers.to_vec())
        };
        Self { first, table }
    }

    /// Finds the place of a number.
    pub(crate) fn find(&self, number: u64) -> Option<u32> {
        let offset = number.checked_sub(self.first);
        match &self.table {
            Table::Contiguous(len) => offset.filter(|k| *k < *len as u64).map(|k| k as u32),
            Table::Dense(dense) => {
                let k = usize::try_from(offset?).ok()?;
                dense.get(k).copied().filter(|place| *place != ABSENT)
            }
            Table::Sorted(numbers) => numbers.binary_search(&number).ok().map(|k| k as u32),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::NumberIndex;

    #[test]
    fn every_kind_of_table_finds_what_is_there_and_nothing_else() {
        for numbers in [vec![], vec![5, 6, 7, 8], vec![3, 5, 6, 9], vec![1, 1 << 40, u64::MAX]] {
            let index = NumberIndex::new(&numbers);
            for probe in [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 1 << 40, u64::MAX - 1, u64::MAX] {
                let expected = numbers.iter().position(|n| *n == probe).map(|k| k as u32);
                assert_eq!(index.find(probe), expected, "{probe} in {numbers:?}");
            }
        }
    }
}
