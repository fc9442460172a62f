//! Disjoint sets of numbers by union-find.

/// Union-find over the numbers `0..count`, in which the smallest number of each set is its
/// root.
///
/// A find halves the path that it follows. Joining under the smaller root keeps results
/// independent of the order of joins.
///
/// ```
/// use surface::UnionFind;
///
/// let mut sets = UnionFind::new(4);
/// sets.join(3, 1);
/// sets.join(2, 3);
/// assert_eq!([0, 1, 2, 3].map(|number| sets.find(number)), [0, 1, 1, 1]);
/// ```
#[derive(Clone, Debug, Default)]
pub struct UnionFind {
    parents: Vec<u32>,
}

impl UnionFind {
    /// Returns `count` sets of one number each.
    ///
    /// # Panics
    ///
    /// When `count` exceeds 2³².
    #[must_use]
    pub fn new(count: usize) -> Self {
        let mut sets = Self::default();
        sets.reset(count);
        sets
    }

    /// Separates all numbers of `0..count`, in the memory that is there.
    ///
    /// # Panics
    ///
    /// When `count` exceeds 2³².
    pub fn reset(&mut self, count: usize) {
        self.parents.clear();
        self.parents.extend((0..=u32::MAX).take(count));
        assert_eq!(self.parents.len(), count, "32-bit numbers cannot count so many");
    }

    /// Joins the sets of two numbers.
    ///
    /// # Panics
    ///
    /// When a number is not below the count.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// Returns the root of a number's set: its smallest number.
    ///
    /// # Panics
    ///
    /// When the number is not below the count.
    pub fn find(&mut self, mut number: u32) -> u32 {
        while self.parents[number as usize] != number {
            let parent = self.parents[number as usize];
            self.parents[number as usize] = self.parents[parent as usize];
            number = self.parents[number as usize];
        }
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sets_equal_those_found_by_relabeling() {
        fixtures::generate::cases(21, 1000, |u| {
            let count = u.int_in_range(1..=20_u32)?;
            let mut sets = UnionFind::new(count as usize);
            let mut labels: Vec<u32> = (0..count).collect();
            for _ in 0..u.int_in_range(0..=20)? {
                let (a, b) = (u.int_in_range(0..=count - 1)?, u.int_in_range(0..=count - 1)?);
                sets.join(a, b);
                let (p, q) = (labels[a as usize], labels[b as usize]);
                for label in &mut labels {
                    if *label == p.max(q) {
                        *label = p.min(q);
                    }
                }
            }
            let found: Vec<u32> = (0..count).map(|number| sets.find(number)).collect();
            assert_eq!(found, labels);
            Ok(())
        });
    }

    #[test]
    fn a_reset_separates_all() {
        let mut sets = UnionFind::new(2);
        sets.join(0, 1);
        sets.reset(3);
        assert_eq!([0, 1, 2].map(|number| sets.find(number)), [0, 1, 2]);
    }
}
