//! Projected points of a tree: one row of `S` numbers per point, rounded once to f32.

use crate::directions::project;
use crate::extents::Extents;

/// Lower and upper bounds of every point along every direction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Projections<const S: usize> {
    lo: Vec<[f32; S]>,
    /// Empty where upper and lower bounds are the same: points at rest.
    hi: Vec<[f32; S]>,
}

impl<const S: usize> Projections<S> {
    /// Projects all points.
    pub(crate) fn new(extents: &Extents<'_>) -> Self {
        let mut projections = Self::default();
        projections.fill(extents);
        projections
    }

    /// Returns the number of points.
    pub(crate) const fn len(&self) -> usize {
        self.lo.len()
    }

    /// Returns the rows of lower bounds.
    #[inline(always)]
    pub(crate) fn lo(&self) -> &[[f32; S]] {
        &self.lo
    }

    /// Returns the rows of upper bounds.
    #[inline(always)]
    pub(crate) fn hi(&self) -> &[[f32; S]] {
        if self.hi.is_empty() { &self.lo } else { &self.hi }
    }

    /// Returns the rows of points at rest, whose upper and lower bounds are the same.
    #[inline(always)]
    pub(crate) fn at_rest(&self) -> Option<&[[f32; S]]> {
        self.hi.is_empty().then_some(&self.lo)
    }

    /// Returns the size on the heap in bytes.
    pub(crate) const fn bytes(&self) -> usize {
        (self.lo.capacity() + self.hi.capacity()) * size_of::<[f32; S]>()
    }

    /// Replaces all rows; allocates only where there were fewer.
    pub(crate) fn fill(&mut self, extents: &Extents<'_>) {
        self.resize(extents);
        fill_rows(extents, &mut self.lo, &mut self.hi);
    }

    fn resize(&mut self, extents: &Extents<'_>) {
        let exact = extents.exact_points::<S>().is_some();
        self.lo.resize(extents.len(), [0.0; S]);
        self.hi.resize(if exact { 0 } else { extents.len() }, [0.0; S]);
    }
}

/// Writes the rows of some points; upper rows only where they differ from the lower ones.
fn fill_rows<const S: usize>(extents: &Extents<'_>, lo: &mut [[f32; S]], hi: &mut [[f32; S]]) {
    // Lower and upper bounds of points at rest are the same.
    if let Some(points) = extents.exact_points::<S>() {
        for (row, &point) in lo.iter_mut().zip(points) {
            *row = rounded(project(point));
        }
        return;
    }

    let mut rows = lo.iter_mut().zip(hi);
    extents.for_each::<S>(|extent| {
        if let Some((lo, hi)) = rows.next() {
            *lo = rounded(extent.lower);
            *hi = rounded(extent.upper);
        }
    });
}

#[inline(always)]
fn rounded<const S: usize>(row: [f64; S]) -> [f32; S] {
    row.map(to_nearest)
}

/// Rounds to the nearest f32, hence monotonically; beyond the range of f32 to infinity.
#[expect(clippy::cast_possible_truncation, reason = "rounding to nearest is the purpose")]
#[inline(always)]
pub(crate) const fn to_nearest(value: f64) -> f32 {
    value as f32
}
