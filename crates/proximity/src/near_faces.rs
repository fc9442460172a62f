//! Faces of another surface near those of one surface, for the few faces that have any.

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
    /// When a face is not below the count.
    pub fn refill(&mut self, face_count: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) {
        self.clear();
        let Self { rows, faces, starts, entries } = self;
        if rows.len() < face_count {
            rows.resize(face_count, 0);
        }

        // Count the entries of each face, and collect the faces that have some.
        let mut count = 0;
        for (face, _) in pairs.clone() {
            let entries = &mut rows[face as usize];
            if *entries == 0 {
                faces.push(face);
            }
            *entries += 1;
            count += 1;
        }
        faces.sort_unstable();

        // The count of a face becomes its start, which moves on to its end as entries are added.
        let mut start = 0;
        for &face in &*faces {
            starts.push(start);
            start += std::mem::replace(&mut rows[face as usize], start);
        }
        starts.push(start);
        entries.resize(count, 0);
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
    use super::*;

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
