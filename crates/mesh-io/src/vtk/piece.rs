//! Points and lists of cells in the pieces of VTK XML files.

use glam::DVec3;

use super::VtkFile;
use super::array::DataArray;
use super::xml::Element;
use crate::text::quoted;
use crate::{FilePlace, ReadError};

/// Piece of a file, which counts its own points from 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece<'a> {
    file: &'a VtkFile<'a>,
    element: &'a Element,
}

/// Points of cells, one after the other, and where those of each end.
#[derive(Debug, Default)]
pub(super) struct CellPoints {
    connectivity: Vec<i64>,
    ends: Vec<i64>,
}

impl<'a> Piece<'a> {
    /// Returns all pieces of a file.
    pub(super) fn all(file: &'a VtkFile<'a>) -> impl Iterator<Item = Self> {
        file.dataset.children("Piece").map(move |element| Self { file, element })
    }

    /// Returns a count among the attributes, 0 where it is left out.
    pub(super) fn count(&self, name: &str) -> Result<usize, ReadError> {
        let text = self.element.attribute(name).unwrap_or("0");
        match text.trim().parse() {
            Ok(count) => Ok(count),
            Err(_) => {
                let problem = format!("{name}={} is not a count", quoted(text));
                Err(self.file.dialect.malformed_at(self.element, problem))
            }
        }
    }

    /// Returns the element of the coordinates, unless there are no points.
    pub(super) fn points(&self) -> Result<Option<&'a Element>, ReadError> {
        if self.count("NumberOfPoints")? == 0 {
            return Ok(None);
        }
        let points = self.element.child("Points");
        match points.and_then(|points| points.child("DataArray")) {
            Some(array) => Ok(Some(array)),
            None => Err(self.file.dialect.missing(FilePlace::Array("Points".to_owned()))),
        }
    }

    /// Adds the points to the positions of earlier pieces.
    pub(super) fn read_points(&self, positions: &mut Vec<DVec3>) -> Result<(), ReadError> {
        let Some(array) = self.points()? else { return Ok(()) };
        let count = self.count("NumberOfPoints")?;
        let coordinates = DataArray::new(self.file, array).floats(count.saturating_mul(3))?;

        let (points, rest) = coordinates.as_chunks::<3>();
        if points.len() != count || !rest.is_empty() {
            let found = coordinates.len();
            let problem = format!("{count} points need three times as many numbers, not {found}");
            return Err(self.malformed("Points", problem));
        }
        positions.extend(points.iter().map(|&point| DVec3::from_array(point)));
        Ok(())
    }

    /// Reads the points of `count` cells in a section.
    pub(super) fn cells(&self, section: &str, count: usize) -> Result<CellPoints, ReadError> {
        let ends = self.array(section, "offsets")?.integers(count)?;
        let last = ends.last().map_or(0, |&end| usize::try_from(end).unwrap_or(usize::MAX));
        let connectivity = self.array(section, "connectivity")?.integers(last)?;
        if ends.len() != count {
            let problem = format!("{count} cells, but {} offsets", ends.len());
            return Err(self.malformed(section, problem));
        }

        CellPoints::new(connectivity, ends).map_err(|problem| self.malformed(section, problem))
    }

    /// Returns the array of a name in a section.
    pub(super) fn array(&self, section: &str, name: &str) -> Result<DataArray<'a>, ReadError> {
        let section = self.element.child(section);
        match section.and_then(|section| section.array(name)) {
            Some(array) => Ok(DataArray::new(self.file, array)),
            None => Err(self.file.dialect.missing(FilePlace::Array(name.to_owned()))),
        }
    }

    /// Returns a refusal of a section.
    pub(super) fn malformed(&self, section: &str, problem: String) -> ReadError {
        self.file.dialect.format.malformed(FilePlace::Element(section.to_owned()), problem)
    }
}

impl CellPoints {
    /// Checks that each cell ends behind the one before; returns the first that does not.
    pub(super) fn new(connectivity: Vec<i64>, ends: Vec<i64>) -> Result<Self, String> {
        let mut start = 0;
        for (cell, &end) in ends.iter().enumerate() {
            let end = usize::try_from(end).unwrap_or(usize::MAX);
            if connectivity.get(start..end).is_none() {
                return Err(format!("offset {cell} does not lie within the connectivity"));
            }
            start = end;
        }
        Ok(Self { connectivity, ends })
    }

    /// Returns the points of each cell.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[i64]> {
        let mut start = 0;
        self.ends.iter().map(move |&end| {
            let end = usize::try_from(end).unwrap_or(0);
            let points = &self.connectivity[start..end];
            start = end;
            points
        })
    }
}

/// Returns the number among all points of a piece's point. A negative one must stay
/// wrong, however many points precede.
pub(super) fn shifted(corner: i64, first: i64) -> i64 {
    if corner < 0 { corner } else { corner.saturating_add(first) }
}
