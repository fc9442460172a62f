//! Edges of one surface that the curve passes, found by their numbers.

use std::ops::Range;

/// An edge with its passings.
#[derive(Clone, Debug)]
pub(crate) struct CutEdge {
    pub(crate) edge: u32,
    /// Its passings; until these are known, its ends of stretches.
    pub(crate) passings: Range<u32>,
    /// Entering passings less leaving ones, along the edge from its lower-numbered end: the
    /// difference of the winding numbers of its ends.
    pub(crate) net: i32,
}

/// The edges of one surface that are passed; its memory is reused from pair to pair.
#[derive(Debug, Default)]
pub(crate) struct CutEdges {
    /// The edges, in the order in which their ends were counted.
    list: Vec<CutEdge>,
    /// One per edge of the surface: 1 + its place in the list, or 0. While ends are counted, their
    /// number.
    places: Vec<u32>,
}

impl CutEdges {
    /// Empties the list, for a surface of `count` edges. The array stays zero outside of the list.
    pub(crate) fn clear(&mut self, count: usize) {
        for cut in self.list.drain(..) {
            self.places[cut.edge as usize] = 0;
        }
        if self.places.len() < count {
            self.places.resize(count, 0);
        }
    }

    /// Counts an end of a stretch on an edge.
    pub(crate) fn count(&mut self, edge: u32) {
        let ends = &mut self.places[edge as usize];
        if *ends == 0 {
            self.list.push(CutEdge { edge, passings: 0..0, net: 0 });
        }
        *ends += 1;
    }

    /// Gives each edge whose ends have been counted an empty range, with room for its ends before the
    /// next. Returns the end of all, which begin at `start`.
    pub(crate) fn make_room(&mut self, mut start: u32) -> u32 {
        for (place, cut) in (1..).zip(&mut self.list) {
            cut.passings = start..start;
            start += std::mem::replace(&mut self.places[cut.edge as usize], place);
        }
        start
    }

    /// Takes the next place in the room of an edge.
    pub(crate) fn take_place(&mut self, edge: u32) -> usize {
        let end = &mut self.list[self.places[edge as usize] as usize - 1].passings.end;
        *end += 1;
        *end as usize - 1
    }

    /// Returns the place of an edge in the list; none for [`NO_EDGE`](surface::NO_EDGE), which faces
    /// have that repeat a vertex.
    #[inline]
    pub(crate) fn place(&self, edge: u32) -> Option<usize> {
        let place = *self.places.get(edge as usize)?;
        place.checked_sub(1).map(|place| place as usize)
    }

    /// Returns an edge that is passed.
    #[inline]
    pub(crate) fn get(&self, edge: u32) -> Option<&CutEdge> {
        self.place(edge).map(|place| &self.list[place])
    }

    /// Returns the edges, in the order in which their ends were counted.
    pub(crate) fn as_slice(&self) -> &[CutEdge] {
        &self.list
    }

    /// Returns the edges to be changed, in the same order.
    pub(crate) fn as_mut_slice(&mut self) -> &mut [CutEdge] {
        &mut self.list
    }
}
