//! Distances beyond the band: to the face that the nearest band node is
//! closest to.
//!
//! That face is nearly always the node's own closest, so carrying it and
//! measuring once costs a fraction of a search a node and is off by hundredths
//! of a spacing only where two faces compete.

use glam::DVec3;

use crate::FieldError;
use crate::band::Nearest;
use crate::envelope::{Envelope, FAR};
use crate::memory::zeroed;
use crate::num::{coordinate, single};
use crate::par;
use crate::spread::{MAX_REACH, seed_closeness, spread};
use crate::units::Units;

/// Where the band's faces have been carried: which nodes are the band's own.
pub(crate) enum Carried {
    /// Within a reach: closeness of the nodes.
    Bounded { closeness: Vec<i16>, seed: i16 },
    /// Everywhere: squared node distances.
    Everywhere { distance: Vec<u32> },
}

impl Carried {
    /// Whether a node lies beyond the band and has a face.
    #[inline]
    pub(crate) fn is_carried(&self, node: usize) -> bool {
        match self {
            Self::Bounded { closeness, seed } => closeness[node] > 0 && closeness[node] != *seed,
            Self::Everywhere { distance } => distance[node] > 0,
        }
    }
}

/// Carries faces to all nodes that may be within `limit` spacings of the
/// surface, or to all.
pub(crate) fn carry(
    nearest: &mut Nearest,
    dims: [usize; 3],
    band: f64,
    limit: Option<f64>,
) -> Result<Carried, FieldError> {
    // A node within the limit has, on the way to its closest point, a band node
    // this far from it: half a cell's diagonal is lost at either end.
    let farthest = limit.map(|limit| (limit - band + 3.0_f64.sqrt()).ceil().max(0.0));
    match farthest {
        Some(reach) if reach <= coordinate(MAX_REACH) => {
            let reach = crate::num::floor_index(reach);
            let mut closeness = zeroed(nearest.face.len())?;
            spread(&mut nearest.face, &mut closeness, dims, reach);
            Ok(Carried::Bounded { closeness, seed: seed_closeness(reach) })
        }
        _ => {
            let mut distance = zeroed(nearest.face.len())?;
            everywhere(&mut nearest.face, &mut distance, dims);
            Ok(Carried::Everywhere { distance })
        }
    }
}

/// One row of nodes along x.
struct Row<'a> {
    face: &'a mut [u32],
    distance: &'a mut [u32],
}

fn everywhere(face: &mut [u32], distance: &mut [u32], [nx, ny, _]: [usize; 3]) {
    let planes = face.chunks_mut(nx * ny).zip(distance.chunks_mut(nx * ny)).collect();
    par::for_each(planes, |_, (face, distance)| {
        let mut rows: Vec<Row<'_>> = rows(face, distance, nx).collect();
        let mut column = Column::default();
        for row in &mut rows {
            column.along(row);
        }
        column.across(&mut rows);
    });
    let rows = rows(face, distance, nx);
    par::for_each(par::walls(rows, ny), |_, mut rows| Column::default().across(&mut rows));
}

fn rows<'a>(
    face: &'a mut [u32],
    distance: &'a mut [u32],
    nx: usize,
) -> impl Iterator<Item = Row<'a>> {
    let rows = face.chunks_mut(nx).zip(distance.chunks_mut(nx));
    rows.map(|(face, distance)| Row { face, distance })
}

#[derive(Default)]
struct Column {
    envelope: Envelope,
    face: Vec<u32>,
}

impl Column {
    fn along(&mut self, row: &mut Row<'_>) {
        self.face.clear();
        self.face.extend_from_slice(row.face);
        let height = |&face: &u32| if face == 0 { FAR } else { 0 };
        self.envelope.height.clear();
        self.envelope.height.extend(row.face.iter().map(height));
        row.distance.fill(FAR);
        self.envelope.minima(|i, j, squared| {
            row.distance[i] = squared;
            row.face[i] = self.face[j];
        });
    }

    fn across(&mut self, rows: &mut [Row<'_>]) {
        for i in 0..rows.first().map_or(0, |row| row.face.len()) {
            self.face.clear();
            self.face.extend(rows.iter().map(|row| row.face[i]));
            self.envelope.height.clear();
            self.envelope.height.extend(rows.iter().map(|row| row.distance[i]));
            self.envelope.minima(|r, from, squared| {
                rows[r].distance[i] = squared;
                rows[r].face[i] = self.face[from];
            });
        }
    }
}

/// Lets every carried node try the faces of its six neighbours, once.
pub(crate) fn relax(
    units: &Units<'_>,
    nearest: &mut Nearest,
    carried: &Carried,
    [nx, ny, nz]: [usize; 3],
) {
    let faces = &nearest.face;
    par::for_each(nearest.squared.chunks_mut(nx).collect(), |r, squared| {
        let [j, k] = [r % ny, r / ny];
        for i in (0..nx).filter(|&i| carried.is_carried(r * nx + i)) {
            let own = faces[r * nx + i];
            let p = DVec3::new(coordinate(i), coordinate(j), coordinate(k));
            for node in neighbours([i, j, k], [nx, ny, nz]) {
                let face = faces[node];
                if face != 0 && face != own {
                    let offer = single(units.face(face - 1).squared_distance(p));
                    squared[i] = squared[i].min(offer);
                }
            }
        }
    });
}

/// The nodes next to a node along the axes.
pub(crate) fn neighbours(
    node: [usize; 3],
    dims: [usize; 3],
) -> impl Iterator<Item = usize> + Clone {
    let strides = [1, dims[0], dims[0] * dims[1]];
    let here = node[0] + strides[1] * node[1] + strides[2] * node[2];
    (0..3).flat_map(move |axis| {
        let below = (node[axis] > 0).then(|| here - strides[axis]);
        let above = (node[axis] + 1 < dims[axis]).then(|| here + strides[axis]);
        below.into_iter().chain(above)
    })
}
