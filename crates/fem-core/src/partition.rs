//! Things that are joined two by two, and the sets that this makes.

/// Sets of numbers; each number belongs to one.
#[derive(Debug)]
pub(crate) struct Partition {
    /// Each number points towards the least one of its set.
    parent: Vec<usize>,
}

impl Partition {
    /// Puts each of the numbers below `count` into a set of its own.
    pub(crate) fn new(count: usize) -> Self {
        Self { parent: (0..count).collect() }
    }

    /// Finds the least number of a set, and shortens the way to it.
    pub(crate) fn first(&mut self, mut number: usize) -> usize {
        while self.parent[number] != number {
            self.parent[number] = self.parent[self.parent[number]];
            number = self.parent[number];
        }
        number
    }

    /// Joins the sets of two numbers.
    pub(crate) fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first(a), self.first(b));
        self.parent[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_numbers_have_the_least_one_of_their_set() {
        let mut sets = Partition::new(8);
        for (a, b) in [(7, 5), (1, 3), (5, 3), (2, 6), (3, 3)] {
            sets.join(a, b);
        }
        assert_eq!([0, 1, 2, 3, 4, 5, 6, 7].map(|k| sets.first(k)), [0, 1, 2, 1, 4, 1, 2, 1]);
    }
}
