//! Map of a range of motion: the angle of first contact over two turns before the last one.
//!
//! Cells are computed in parallel, row by row. A [cache](super::run_cache) keeps those that are
//! finished.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use musculo_collide::surface::parallel;
use musculo_collide::{BodyId, JointScene, JointTurns, Scene};

use super::run_cache::{CacheKind, KeptParts, PartKeeper, content_hash};
use super::vector::Vector;
use crate::failure::Failure;
use crate::phase::Phase;
use crate::report::{MapCell, RangeMap};

/// Arguments of a map.
#[derive(Debug, Args)]
pub(super) struct MapArguments {
    /// Turn before the last one, for a map: its axis, its angles in degrees and their number; given
    /// twice
    ///
    /// Each turn is about an axis that the turns before it have turned: first that of the first
    /// --over, last that of --axis.
    #[arg(
        long,
        value_name = "X,Y,Z:FROM:TO:COUNT",
        allow_hyphen_values = true,
        conflicts_with = "json"
    )]
    over: Vec<Grid>,

    /// Draw the map
    #[arg(long, value_name = "FILE.svg", requires = "over", conflicts_with = "json")]
    pub(super) map: Option<PathBuf>,

    /// Write the cells of the map as a table
    #[arg(long, value_name = "FILE.csv", requires = "over", conflicts_with = "json")]
    pub(super) table: Option<PathBuf>,

    /// Keep finished cells in this file, and take those of an interrupted run from it
    #[arg(long, value_name = "FILE", requires = "over", conflicts_with = "json")]
    pub(super) cache: Option<PathBuf>,
}

/// Angles of a turn.
#[derive(Clone, Copy, Debug)]
struct Grid {
    axis: Vector,
    from: f64,
    to: f64,
    count: usize,
}

/// Largest number of angles of a turn.
const MAX_COUNT: usize = 1000;

impl FromStr for Grid {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [axis, from, to, count] = text.split(':').collect::<Vec<_>>()[..] else {
            return Err("expected an axis, two angles and a number, separated by colons".to_owned());
        };
        let angle = |text: &str| match text.trim().parse::<f64>() {
            Ok(angle) if angle.abs() <= 360.0 => Ok(angle),
            _ => Err(format!("'{text}' is no angle within a full turn, 360 degrees")),
        };
        let axis: Vector = axis.parse()?;
        if axis.0.try_normalize().is_none() {
            return Err(format!("the axis {} has no direction", axis.0));
        }
        match count.trim().parse() {
            Ok(count) if (2..=MAX_COUNT).contains(&count) => {
                Ok(Self { axis, from: angle(from)?, to: angle(to)?, count })
            }
            _ => Err(format!("'{count}' is no number of angles from 2 to {MAX_COUNT}")),
        }
    }
}

impl Grid {
    /// Returns the angles in degrees.
    fn angles(self) -> Vec<f64> {
        let mut angles = Vec::with_capacity(self.count);
        for number in 0..self.count {
            let [number, last] =
                [number, self.count - 1].map(|n| f64::from(u32::try_from(n).unwrap_or(u32::MAX)));
            angles.push(self.from + (self.to - self.from) * (number / last));
        }
        angles
    }
}

/// Last turn of a map, and the bodies that follow all three.
pub(super) struct LastTurn<'a> {
    pub(super) turning: &'a [BodyId],
    pub(super) axis: Vector,
    pub(super) center: Vector,
    /// Largest angle in degrees.
    pub(super) to: f64,
}

impl MapArguments {
    /// Returns true if a map is to be computed.
    pub(super) fn is_map(&self) -> bool {
        !self.over.is_empty()
    }

    /// Checks that there are two turns before the last, and that no other output is the cache.
    pub(super) fn check(&self) -> Result<(), Failure> {
        if !matches!(self.over.len(), 0 | 2) {
            let problem = format!("--over is given {} times, but a map has two", self.over.len());
            return Err(Failure::new(problem));
        }
        if let Some(cache) = &self.cache
            && [&self.map, &self.table].contains(&&self.cache)
        {
            return Err(Failure::in_file(cache, "is the cache, and another output as well"));
        }
        Ok(())
    }

    /// Computes the cells that the cache does not have.
    pub(super) fn compute(
        &self,
        scene: &Scene,
        last: &LastTurn<'_>,
        inputs: &[PathBuf],
    ) -> Result<RangeMap, Failure> {
        let [first, second] = self.over[..] else {
            return Err(Failure::new("a map needs two turns before the last"));
        };
        let axes = [first.angles(), second.angles()];
        let mut names = Vec::new();
        for &body in last.turning {
            names.push(scene.body(body).name());
        }

        // A cache holds for the content of all inputs and all that is turned, and for nothing else.
        let LastTurn { axis, center, to, .. } = last;
        let arguments = format!("{names:?} {first:?} {second:?} {axis:?} {center:?} {to:?}");
        let cache = match &self.cache {
            Some(path) => CellCache::open(path, content_hash(inputs, &arguments)?)?,
            None => CellCache::default(),
        };

        let turns = JointTurns {
            center: center.0,
            axes: [first.axis.0, second.axis.0, axis.0],
            to: to.to_radians(),
        };
        let joint = JointScene::new(scene.clone(), last.turning, turns)?;
        let cells = cells(&joint, &axes, &cache)?;
        Ok(RangeMap { axes, to: *to, cells })
    }
}

/// Cells of earlier runs by row and column, and the file that keeps more of them.
#[derive(Debug, Default)]
struct CellCache {
    cells: BTreeMap<[usize; 2], MapCell>,
    keeper: Option<PartKeeper>,
}

impl CellCache {
    /// Opens a cache, or makes one.
    fn open(path: &Path, inputs: u64) -> Result<Self, Failure> {
        let kind = CacheKind { run: "map", parts: "cells" };
        let mut kept = KeptParts::open(path, kind, inputs)?;
        let mut cells = BTreeMap::new();
        while let Some(line) = kept.next_line()? {
            let (place, cell) = parse(&line).ok_or_else(|| kept.damaged())?;
            cells.insert(place, cell);
        }
        Ok(Self { cells, keeper: Some(kept.keep_more()?) })
    }

    /// Keeps a cell: its row, its column, and its row of the table.
    fn keep(&self, [row, column]: [usize; 2], cell: &MapCell) -> Result<(), Failure> {
        let Some(keeper) = &self.keeper else { return Ok(()) };
        keeper.keep(format!("{row},{column},{}", cell.to_line()?).trim_end())
    }
}

/// Parses the line of a cell.
fn parse(line: &str) -> Option<([usize; 2], MapCell)> {
    let (row, rest) = line.split_once(',')?;
    let (column, rest) = rest.split_once(',')?;
    Some(([row.parse().ok()?, column.parse().ok()?], MapCell::parse(rest)?))
}

/// Returns all cells, row by row, of which the cache may have some.
fn cells(
    joint: &JointScene,
    [first, second]: &[Vec<f64>; 2],
    cache: &CellCache,
) -> Result<Vec<MapCell>, Failure> {
    let phase = Phase::with_steps("turning", first.len() * second.len());

    // A row has trees of its own, which move with its cells.
    let row = |row: usize| -> Result<Vec<MapCell>, Failure> {
        let (mut cells, mut of_row) = (Vec::new(), None);
        for (column, &angle) in second.iter().enumerate() {
            let place = [row, column];
            phase.step();
            if let Some(cell) = cache.cells.get(&place) {
                cells.push(cell.clone());
                continue;
            }

            let angles = [first[row], angle];
            let joint = of_row.get_or_insert_with(|| joint.clone());
            let end = joint.turn(angles.map(f64::to_radians))?;
            let cell = MapCell::new(angles, &end, joint.scene());
            cache.keep(place, &cell)?;
            cells.push(cell);
        }
        Ok(cells)
    };
    let rows: Result<Vec<_>, _> = parallel::map(first.len(), row).into_iter().collect();
    Ok(rows?.concat())
}
