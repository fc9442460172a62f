//! Faces of another surface near those of one surface, for the few faces that have any.

use kdop::{Tree, Workspace};
use surface::Aabb;
use surface::progress::Progress;

use crate::{PairError, SurfaceTree};

/// Pairs of faces that may be near each other, listed for both surfaces: a gigabyte with the lists of
/// [`NearFaces`]. Fewer leave out margins in use: within 50 mm of each other, the largest bodies of a
/// thigh take 652 MB. With more, a few pairs of bodies at a time take all memory.
const MAX_PAIRS: usize = 1 << 26;

/// Lists the pairs of faces of two surfaces that may be within a margin of each other, in place of
/// earlier ones.
///
/// # Errors
///
/// - [`PairError::TooManyNearFaces`] for more than 2²⁶ pairs.
/// - [`PairError::Interrupted`] when `progress` ends the call.
pub fn list_near_faces(
    bodies: [&SurfaceTree; 2],
    margin: f64,
    workspace: &mut Workspace,
    pairs: &mut Vec<[u32; 2]>,
    progress: Progress<'_>,
) -> Result<(), PairError> {
    // A margin in another unit than the positions takes all faces in: that is known before any is listed.
    let [faces_a, faces_b] = bodies.map(|body| body.surface().faces().len());
    if faces_a.saturating_mul(faces_b) > MAX_PAIRS && are_within(bodies, margin) {
        return Err(PairError::TooManyNearFaces { margin, limit: MAX_PAIRS });
    }
    list_pairs(bodies.map(SurfaceTree::tree), margin, MAX_PAIRS, workspace, pairs, progress)
}

/// Returns true if a box around both bodies is no wider than the margin.
fn are_within(bodies: [&SurfaceTree; 2], margin: f64) -> bool {
    let points = bodies.into_iter().flat_map(|body| body.positions().as_slice());
    let bounds = Aabb::of_points(points.copied());
    (bounds.max - bounds.min).length() <= margin
}

/// As [`list_near_faces`], with a limit.
fn list_pairs(
    [a, b]: [&Tree; 2],
    margin: f64,
    limit: usize,
    workspace: &mut Workspace,
    pairs: &mut Vec<[u32; 2]>,
    progress: Progress<'_>,
) -> Result<(), PairError> {
    /// Pairs of faces between two polls for interruption: a millisecond.
    const POLL_INTERVAL: u32 = 16_384;

    pairs.clear();
    let mut polls = progress.every(POLL_INTERVAL);
    let listed = a.try_pairs(b, margin, workspace, |face_a, face_b| {
        if pairs.len() == limit {
            return Err(PairError::TooManyNearFaces { margin, limit });
        }
        pairs.push([face_a, face_b]);
        Ok(polls.step()?)
    });
    if listed.is_err() {
        // Nor is memory kept for as many.
        *pairs = Vec::new();
    }
    listed
}

/// Variable-length lists of near faces, for the faces of a surface that have any.
///
/// Memory grows to the number of faces of the surface; time to fill it goes with the number of
/// pairs alone.
#[derive(Debug, Default)]
pub struct NearFaces {
    /// Per face: 1 + its row, or 0.
    rows: Vec<u32>,
    /// Faces that have a row, ascending.
    faces: Vec<u32>,
    /// Per row, the start of its entries; one more at the end.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl NearFaces {
    /// Sorts pairs of (face, face of the other surface) by the first, in place of earlier ones; the
    /// order of the others is that of the pairs.
    ///
    /// `face_count` is that of the surface.
    ///
    /// # Panics
    ///
    /// When a face is not below the count, and for 2³² pairs and more.
    pub fn refill(&mut self, face_count: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) {
        self.clear();
        let Self { rows, faces, starts, entries } = self;
        if rows.len() < face_count {
            rows.resize(face_count, 0);
        }

        // Count the entries of each face, and collect the faces that have some.
        let mut count: u64 = 0;
        for (face, _) in pairs.clone() {
            count += 1;
            assert!(count < u64::from(u32::MAX), "32-bit numbers count the pairs");
            let entries = &mut rows[face as usize];
            if *entries == 0 {
                faces.push(face);
            }
            *entries += 1;
        }
        faces.sort_unstable();

        // The count of a face becomes its start, which moves on to its end as entries are added.
        let mut start = 0;
        for &face in &*faces {
            starts.push(start);
            start += std::mem::replace(&mut rows[face as usize], start);
        }
        starts.push(start);
        entries.resize(start as usize, 0);
        for (face, entry) in pairs {
            let next = &mut rows[face as usize];
            entries[*next as usize] = entry;
            *next += 1;
        }
        for (row, &face) in (1..).zip(&*faces) {
            rows[face as usize] = row;
        }
    }

    /// Removes all pairs.
    pub(crate) fn clear(&mut self) {
        for face in self.faces.drain(..) {
            self.rows[face as usize] = 0;
        }
        self.starts.clear();
        self.entries.clear();
    }

    /// Returns the faces that have near ones, ascending, each with these.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &[u32])> {
        self.faces.iter().map(|&face| (face, self.row(face)))
    }

    /// Returns the faces of the other surface near a face.
    #[must_use]
    #[inline]
    pub fn row(&self, face: u32) -> &[u32] {
        match self.rows.get(face as usize) {
            None | Some(0) => &[],
            Some(&row) => {
                let row = row as usize;
                &self.entries[self.starts[row - 1] as usize..self.starts[row] as usize]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes::icosphere;

    use super::*;

    #[test]
    fn as_many_pairs_are_listed_as_are_allowed() {
        let ball = icosphere(1.0, 1);
        let ball = SurfaceTree::new(ball.surface(), ball.positions).expect("positions are finite");
        let trees = [ball.tree(); 2];
        let count = ball.surface().faces().len().pow(2);
        let (mut workspace, mut pairs) = (Workspace::default(), Vec::new());
        for (limit, margin) in [(count, 3.0), (count - 1, 3.0), (count - 1, 0.1)] {
            let listed =
                list_pairs(trees, margin, limit, &mut workspace, &mut pairs, Progress::none());
            if margin > 1.0 && limit < count {
                assert_eq!(listed, Err(PairError::TooManyNearFaces { margin, limit }));
                assert_eq!(pairs.capacity(), 0, "memory of the list");
            } else {
                assert_eq!(listed, Ok(()), "{limit} pairs within {margin}");
                assert_eq!(pairs.len() == count, margin > 1.0, "{} pairs", pairs.len());
            }
        }
    }

    #[test]
    fn rows_hold_their_pairs_and_no_earlier_ones() {
        let mut near = NearFaces::default();
        let pairs = [(7, 3), (2, 9), (7, 1), (5, 4), (2, 8)];
        near.refill(10, pairs.into_iter());
        let rows: Vec<&[u32]> = (0..10).map(|face| near.row(face)).collect();
        assert_eq!(rows[7], [3, 1]);
        assert_eq!(rows[2], [9, 8]);
        assert_eq!(rows[5], [4]);
        let listed: Vec<(u32, &[u32])> = near.iter().collect();
        assert_eq!(listed, [(2, &[9, 8][..]), (5, &[4]), (7, &[3, 1])]);
        assert_eq!(rows.iter().filter(|row| !row.is_empty()).count(), 3);

        near.refill(12, [(11, 0)].into_iter());
        assert_eq!(near.row(11), [0]);
        assert!((0..11).all(|face| near.row(face).is_empty()));
        near.clear();
        assert!((0..13).all(|face| near.row(face).is_empty()));
    }
}
