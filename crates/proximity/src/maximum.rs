//! Largest value of a function, by branch and bound.
//!
//! The caller divides the domain into pieces, each with an upper bound on the function there.
//! The piece with the largest bound is split until no bound on the rest exceeds the largest
//! value that was evaluated by more than a small share.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use surface::DirectedHausdorff;

/// Excess of a bound over the largest evaluated value at which splitting ends, relative to that
/// value.
///
/// Smaller bounds are tighter, and take many more splits where the function is flat.
const RELATIVE_SLACK: f64 = 0.05;

/// Branch and bound search for the largest value of a non-negative function over pieces.
///
/// Pieces leave the search in the order of their bounds, largest first; of equal bounds, in the
/// order they were added.
///
/// ```
/// use proximity::MaximumSearch;
///
/// // The largest value of x (1 − x) on 0.0..=1.0, whose slope is at most 1.
/// let value = |x: f64| x * (1.0 - x);
/// let mut search = MaximumSearch::new(1e-9, f64::INFINITY);
/// search.add(1.0, [0.0, 1.0]);
/// while let Some((_, [from, to])) = search.next() {
///     let middle = 0.5 * (from + to);
///     search.evaluated(value(middle));
///     for [from, to] in [[from, middle], [middle, to]] {
///         search.add(value(from) + (to - from), [from, to]);
///     }
/// }
/// let bounds = search.bounds();
/// assert!(bounds.lower <= 0.25 && 0.25 <= bounds.upper && bounds.upper < 0.27);
/// ```
#[derive(Debug)]
pub struct MaximumSearch<T> {
    pieces: BinaryHeap<Waiting<T>>,
    added: usize,
    lower: f64,
    /// Largest bound of the pieces that were left out.
    left_out: f64,
    relative_slack: f64,
    min_slack: f64,
    limit: f64,
}

/// Piece that waits for being split.
#[derive(Debug)]
struct Waiting<T> {
    bound: f64,
    /// Number of pieces added before it: breaks ties, so that the order is fixed.
    number: usize,
    piece: T,
}

impl<T> Ord for Waiting<T> {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound).then(other.number.cmp(&self.number))
    }
}

impl<T> PartialOrd for Waiting<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> PartialEq for Waiting<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl<T> Eq for Waiting<T> {}

impl<T> Default for MaximumSearch<T> {
    /// Starts a search for the maximum itself, without slack but the relative one.
    fn default() -> Self {
        Self::new(0.0, f64::INFINITY)
    }
}

impl<T> MaximumSearch<T> {
    /// Starts a search without pieces.
    ///
    /// A bound no more than `min_slack` above the largest evaluated value is tight enough.
    /// Bounds up to `limit` are tight enough, too: pass infinity to find the maximum, or a
    /// number to decide whether it is exceeded.
    #[must_use]
    pub const fn new(min_slack: f64, limit: f64) -> Self {
        let pieces = BinaryHeap::new();
        let relative_slack = RELATIVE_SLACK;
        Self { pieces, added: 0, lower: 0.0, left_out: 0.0, relative_slack, min_slack, limit }
    }

    /// Starts anew, in the memory that is there.
    ///
    /// Besides the slack of [`new`](Self::new), a bound is tight enough where it exceeds the largest
    /// evaluated value by `relative_slack` of that value, 5 % otherwise.
    pub fn restart(&mut self, min_slack: f64, relative_slack: f64) {
        self.pieces.clear();
        (self.added, self.lower, self.left_out) = (0, 0.0, 0.0);
        (self.min_slack, self.relative_slack) = (min_slack, relative_slack);
    }

    /// Starts anew as by [`new`](Self::new), in the memory that is there.
    pub fn restart_within(&mut self, min_slack: f64, limit: f64) {
        self.restart(min_slack, RELATIVE_SLACK);
        self.limit = limit;
    }

    /// Records a value that the function takes.
    #[inline]
    pub fn evaluated(&mut self, value: f64) {
        self.lower = self.lower.max(value);
    }

    /// Adds a piece with no value above `bound`.
    pub fn add(&mut self, bound: f64, piece: T) {
        if bound <= self.sufficient() {
            self.left_out = self.left_out.max(bound);
        } else {
            self.pieces.push(Waiting { bound, number: self.added, piece });
            self.added += 1;
        }
    }

    /// Records the bound of a piece that is left out, since its bound is tight enough.
    pub fn leave_out(&mut self, bound: f64) {
        self.left_out = self.left_out.max(bound);
    }

    /// Takes out the piece with the largest bound; `None` where the bounds are tight enough.
    #[expect(clippy::should_implement_trait, reason = "pieces are added between calls")]
    pub fn next(&mut self) -> Option<(f64, T)> {
        if self.remaining() <= self.sufficient() {
            return None;
        }
        let Waiting { bound, piece, .. } = self.pieces.pop()?;
        Some((bound, piece))
    }

    /// Returns the largest evaluated value; 0 without one.
    #[must_use]
    pub const fn lower(&self) -> f64 {
        self.lower
    }

    /// Returns the number of pieces that were put aside for splitting.
    #[must_use]
    pub const fn added(&self) -> usize {
        self.added
    }

    /// Returns the bound that is tight enough at present.
    #[inline]
    #[must_use]
    pub fn sufficient(&self) -> f64 {
        (self.lower + self.min_slack.max(self.relative_slack * self.lower)).min(self.limit)
    }

    /// Returns the largest bound of the pieces that are left; 0 without one.
    #[must_use]
    pub fn remaining(&self) -> f64 {
        self.pieces.peek().map_or(0.0, |piece| piece.bound)
    }

    /// Returns bounds on the maximum.
    #[must_use]
    pub fn bounds(&self) -> DirectedHausdorff {
        let upper = self.remaining().max(self.left_out).max(self.lower);
        DirectedHausdorff { lower: self.lower, upper }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_that_are_left_out_count_in_the_bound() {
        let mut search = MaximumSearch::new(0.0, f64::INFINITY);
        search.evaluated(1.0);
        for bound in [1.02, 1.04, 1.03] {
            search.add(bound, ());
        }
        assert_eq!((search.added(), search.bounds().upper), (0, 1.04));
        search.leave_out(1.05);
        search.leave_out(1.01);
        assert_eq!((search.bounds().lower, search.bounds().upper), (1.0, 1.05));

        // A bound above the slack of 5 % waits, until it is the last.
        search.add(1.06, ());
        assert_eq!((search.added(), search.bounds().upper), (1, 1.06));
        assert_eq!(search.next(), Some((1.06, ())));
        assert_eq!((search.next(), search.bounds().upper), (None, 1.05));
    }
}
