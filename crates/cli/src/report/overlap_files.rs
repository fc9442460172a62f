//! Overlaps as files for ParaView and 3D Slicer: clipped patches and crossing curves.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use glam::DVec3;
use mesh_io::{CellValues, Cells, PointValues, Space, write_vtp_cells};
use musculo_collide::surface::triangle;
use musculo_collide::{Body, CurveChain, OverlapGeometry, PairReport, PatchFace, Scene};

use crate::failure::Failure;
use crate::output::Outputs;

/// Overlapping pair with the shape of its overlap.
#[derive(Debug)]
pub(crate) struct OverlapShape<'a> {
    pub(crate) report: &'a PairReport,
    pub(crate) geometry: OverlapGeometry,
}

/// Folder of files whose names depend on the results, each taken once.
#[derive(Debug)]
pub(crate) struct FileFolder {
    path: PathBuf,
    /// Names that are taken, in lower case.
    names: BTreeSet<String>,
    /// Names of the completed files since they were last handed out.
    completed: Vec<String>,
    /// Space of all positions, where it is known.
    space: Option<Space>,
}

impl FileFolder {
    /// Begins with names that are taken.
    pub(crate) fn new(
        path: &Path,
        names: impl IntoIterator<Item = String>,
        space: Option<Space>,
    ) -> Self {
        let names = names.into_iter().map(|name| name.to_lowercase()).collect();
        Self { path: path.to_owned(), names, completed: Vec::new(), space }
    }

    /// Returns the space that the files state.
    pub(crate) fn space(&self) -> Option<Space> {
        self.space
    }

    /// Hands out the names of the files that were completed since the last call.
    pub(crate) fn take_completed(&mut self) -> Vec<String> {
        std::mem::take(&mut self.completed)
    }

    /// Returns the name of a `.vtp` file, with a number where another file has it, whatever the
    /// case of its letters.
    fn take(&mut self, stem: &str) -> String {
        let mut name = format!("{stem}.vtp");
        let mut number = 1;
        while !self.names.insert(name.to_lowercase()) {
            number += 1;
            name = format!("{stem}_{number}.vtp");
        }
        name
    }

    /// Completes a `.vtp` file.
    pub(super) fn stage(
        &mut self,
        stem: &str,
        content: String,
        outputs: &mut Outputs,
    ) -> Result<(), Failure> {
        let name = self.take(stem);
        outputs.stage_found(&self.path.join(&name), content)?;
        self.completed.push(name);
        Ok(())
    }
}

/// Writes the patches of both bodies and the curve of every overlap into a folder.
pub(crate) fn stage_overlap_files(
    shapes: &[OverlapShape<'_>],
    scene: &Scene,
    folder: &mut FileFolder,
    outputs: &mut Outputs,
) -> Result<(), Failure> {
    for OverlapShape { report, geometry } in shapes {
        let [a, b] = report.pair.bodies().map(|id| scene.body(id));
        for ([own, other], patches) in [[a, b], [b, a]].into_iter().zip(&geometry.patches) {
            if !patches.is_empty() {
                let stem = format!("{}_in_{}", own.name(), other.name());
                folder.stage(&stem, patch_vtp(patches, own, folder.space), outputs)?;
            }
        }
        if !geometry.curve.is_empty() {
            let stem = format!("{}_{}_curve", a.name(), b.name());
            folder.stage(&stem, curve_vtp(&geometry.curve, folder.space), outputs)?;
        }
    }
    Ok(())
}

/// Points with their values, each position once.
#[derive(Debug, Default)]
pub(super) struct PointList {
    pub(super) positions: Vec<DVec3>,
    depths: Vec<f64>,
    numbers: BTreeMap<[u64; 3], u32>,
}

impl PointList {
    /// Returns the number of a point, with its depth where it is new.
    pub(super) fn number(&mut self, at: DVec3, depth: f64) -> u32 {
        let Self { positions, depths, numbers } = self;
        *numbers.entry(at.to_array().map(f64::to_bits)).or_insert_with(|| {
            positions.push(at);
            depths.push(depth);
            u32::try_from(positions.len() - 1).unwrap_or(u32::MAX)
        })
    }
}

/// Writes the parts of a body's faces inside another: a polygon per part, or triangles where a
/// part has holes or several pieces. Points have their depth, cells their face and region.
fn patch_vtp(patches: &[PatchFace], body: &Body, space: Option<Space>) -> String {
    let mut points = PointList::default();
    let (mut cells, mut faces, mut regions) = (Vec::new(), Vec::new(), Vec::new());
    for PatchFace { part, depths } in patches {
        // Every corner of the part takes its number first, with its depth.
        let mut loops = Vec::new();
        for (corners, depths) in part.loops.iter().zip(depths) {
            let numbers = corners.iter().zip(depths);
            loops.push(numbers.map(|(&at, &depth)| points.number(at, depth)).collect::<Vec<u32>>());
        }

        let first = cells.len();
        if loops.len() == 1 {
            cells.append(&mut loops);
        } else {
            let normal = triangle::normal(body.corners(part.face));
            for corners in part.triangles(normal) {
                cells.push(corners.map(|at| points.number(at, 0.0)).to_vec());
            }
        }
        faces.resize(cells.len(), part.face);
        regions.resize(cells.len(), part.region);
        debug_assert!(first < cells.len(), "a part without polygons");
    }

    let values = [PointValues::Scalars("depth", &points.depths)];
    let numbers = [CellValues::Numbers("face", &faces), CellValues::Numbers("region", &regions)];
    write_vtp_cells(&points.positions, Cells::Polygons(&cells), &values, &numbers, space)
}

/// Writes the chains of a curve; cells have their number, and 1 where they are closed.
fn curve_vtp(curve: &[CurveChain], space: Option<Space>) -> String {
    let mut positions = Vec::new();
    let (mut cells, mut numbers, mut closed) = (Vec::new(), Vec::new(), Vec::new());
    for (number, chain) in (0_u32..).zip(curve) {
        let first = u32::try_from(positions.len()).unwrap_or(u32::MAX);
        let mut cell: Vec<u32> = (first..).take(chain.points.len()).collect();
        cell.extend(chain.is_closed.then_some(first));
        cells.push(cell);
        positions.extend(&chain.points);
        numbers.push(number);
        closed.push(u32::from(chain.is_closed));
    }
    let numbers =
        [CellValues::Numbers("loop", &numbers), CellValues::Numbers("is_closed", &closed)];
    write_vtp_cells(&positions, Cells::Lines(&cells), &[], &numbers, space)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_taken_once() {
        let mut names = FileFolder::new(Path::new("o"), ["A_in_b.vtp".to_owned()], None);
        assert_eq!(names.take("a_in_b"), "a_in_b_2.vtp");
        assert_eq!(names.take("A_in_b"), "A_in_b_3.vtp");
        assert_eq!(names.take("b_in_a"), "b_in_a.vtp");
    }
}
