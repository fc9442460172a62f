//! Elements that several parts of a file have in common, as groups of an MSH file do.

use std::collections::HashSet;

use crate::mesh::Polygons;
use crate::solid::NumberedCells;

/// Elements of the parts that a body has so far.
#[derive(Debug, Default)]
pub(crate) struct KnownElements {
    solids: HashSet<ElementKey>,
    surfaces: HashSet<ElementKey>,
}

/// Number of an element with its nodes, ascending: copies of it may be turned over, and another element may have its
/// number by mistake.
type ElementKey = (u64, Vec<i64>);

impl KnownElements {
    /// Returns the solids of a part that no part before has.
    pub(crate) fn other_solids(&mut self, cells: &NumberedCells) -> NumberedCells {
        let mut keys = Vec::new();
        for (&number, cell) in cells.numbers.iter().zip(&cells.cells) {
            keys.push(element_key(number, cell.nodes().iter().copied().map(i64::from)));
        }
        let others = cells.filtered(|place| !self.solids.contains(&keys[place]));
        self.solids.extend(keys);
        others
    }

    /// Returns the elements of surfaces of a part that no part before has, by their numbers.
    pub(crate) fn other_surfaces(&mut self, polygons: &Polygons, numbers: &[u64]) -> Polygons {
        debug_assert_eq!(polygons.len(), numbers.len(), "each element of a surface has a number");
        let (mut others, mut keys) = (Polygons::default(), Vec::new());
        for (corners, &number) in polygons.iter().zip(numbers) {
            let key = element_key(number, corners.iter().copied());
            if !self.surfaces.contains(&key) {
                others.push(corners.iter().copied());
            }
            keys.push(key);
        }
        self.surfaces.extend(keys);
        others
    }
}

fn element_key(number: u64, nodes: impl Iterator<Item = i64>) -> ElementKey {
    let mut nodes: Vec<i64> = nodes.collect();
    nodes.sort_unstable();
    (number, nodes)
}
