//! Continuous collision queries with exact answers: read from files, or generated.

use std::array;
use std::io::{self, ErrorKind};
use std::path::Path;

use glam::DVec3;

use crate::measure::as_f64;

/// Primitives of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QueryKind {
    /// A vertex, then the corners of a face.
    VertexFace,
    /// The ends of one edge, then of another.
    EdgeEdge,
}

/// One query: four points at both ends of a step, and the exact answer.
#[derive(Clone, Copy, Debug)]
pub struct CcdQuery {
    /// Primitives that the points make.
    pub kind: QueryKind,
    /// Points at time 0.
    pub x0: [DVec3; 4],
    /// Points at time 1.
    pub x1: [DVec3; 4],
    /// Exact time of the first contact, rounded down: infinite for none, NaN if unknown.
    pub time: f64,
}

/// Queries of one kind.
#[derive(Clone, Debug)]
pub struct QuerySet {
    /// Name of the set.
    pub name: String,
    /// Primitives of all queries.
    pub kind: QueryKind,
    /// The queries.
    pub queries: Vec<CcdQuery>,
}

/// Bytes before the first position, and numbers per query: 8 points.
const HEADER: usize = 32;
const NUMBERS: usize = 24;

/// Reads a file of labelled queries.
///
/// Its bytes: magic `CCDQ0001`, then little endian kind (u32, 0 vertex-face, 1 edge-edge), flags
/// (u32), count (u64), zero (u64), positions (f64, 8 points per query), times (f64), and unused
/// bytes.
///
/// # Errors
///
/// When the file cannot be read or is not such a file.
pub fn read(folder: &Path, name: &str) -> io::Result<QuerySet> {
    let bytes = std::fs::read(folder.join(name).with_extension("ccdq"))?;
    let invalid = || io::Error::new(ErrorKind::InvalidData, format!("{name} is not a query file"));
    let (header, numbers) = bytes.split_at_checked(HEADER).ok_or_else(invalid)?;
    if !header.starts_with(b"CCDQ0001") {
        return Err(invalid());
    }

    // The header, then all numbers of the rest.
    let kind = if header[8] == 0 { QueryKind::VertexFace } else { QueryKind::EdgeEdge };
    let count = u64::from_le_bytes(array::from_fn(|i| header[16 + i]));
    let numbers: Vec<f64> = numbers
        .chunks_exact(8)
        .map(|bytes| f64::from_le_bytes(array::from_fn(|i| bytes[i])))
        .collect();
    let count = usize::try_from(count).map_err(|_| invalid())?;
    if count.checked_mul(NUMBERS + 1).is_none_or(|needed| numbers.len() < needed) {
        return Err(invalid());
    }

    // Positions of all queries, then their times.
    let (positions, times) = numbers.split_at(NUMBERS * count);
    let mut queries = Vec::new();
    for (x, &time) in positions.chunks_exact(NUMBERS).zip(times) {
        let (x0, x1) = x.split_at(NUMBERS / 2);
        queries.push(CcdQuery { kind, x0: points(x0), x1: points(x1), time });
    }
    Ok(QuerySet { name: name.to_owned(), kind, queries })
}

fn points(coordinates: &[f64]) -> [DVec3; 4] {
    array::from_fn(|i| DVec3::from_slice(&coordinates[3 * i..]))
}

/// Generates queries at random: points in a unit cube that move by up to half of it.
#[must_use]
pub fn random(kind: QueryKind, count: usize) -> QuerySet {
    generate("random", kind, count, 0x9e37_79b9_7f4a_7c15, |[start, motion]| {
        let x0 = start.map(|x| 0.5 * x);
        [x0, array::from_fn(|i| x0[i] + 0.5 * motion[i])]
    })
}

/// Generates degenerate queries: points on a small lattice that move on it, so that many touch at
/// a corner, at an edge, at an end of the step, or move in one plane.
#[must_use]
pub fn on_lattice(kind: QueryKind, count: usize) -> QuerySet {
    let to_lattice = |ends: [[DVec3; 4]; 2]| ends.map(|x| x.map(|x| (2.0 * x).round()));
    generate("lattice", kind, count, 0x2545_f491_4f6c_dd1d, to_lattice)
}

/// Generates queries without answers: `place` maps two sets of points in the unit cube to both
/// ends of the step.
fn generate(
    name: &str,
    kind: QueryKind,
    count: usize,
    seed: u64,
    place: impl Fn([[DVec3; 4]; 2]) -> [[DVec3; 4]; 2],
) -> QuerySet {
    let mut generator = Xorshift(seed);
    let mut queries = Vec::new();
    for _ in 0..count {
        let [x0, x1] = place([generator.points(), generator.points()]);
        queries.push(CcdQuery { kind, x0, x1, time: f64::NAN });
    }
    let suffix = if kind == QueryKind::VertexFace { "vf" } else { "ee" };
    QuerySet { name: format!("{name}_{suffix}"), kind, queries }
}

/// Pseudorandom numbers by a 64-bit xorshift.
struct Xorshift(u64);

impl Xorshift {
    /// Returns a number in `-1.0..1.0`.
    fn signed_unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        f64::from(u32::try_from(self.0 >> 32).unwrap_or(0)) / f64::from(1_u32 << 31) - 1.0
    }

    /// Returns points in the cube of these numbers.
    fn points(&mut self) -> [DVec3; 4] {
        points(&[0.0; NUMBERS / 2].map(|_| self.signed_unit()))
    }
}

/// Returns the mean extent of queries: the maximum distance of a point from the first.
#[must_use]
pub fn mean_extent<'a>(queries: impl IntoIterator<Item = &'a CcdQuery>) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    for query in queries {
        sum += query.x0.iter().map(|x| x.distance(query.x0[0])).fold(0.0, f64::max);
        count += 1;
    }
    sum / as_f64(count.max(1))
}

impl QuerySet {
    /// Returns true if all queries have exact answers.
    #[must_use]
    pub fn is_labelled(&self) -> bool {
        self.queries.iter().all(|query| !query.time.is_nan())
    }

    /// Returns all points at both ends of the step, and the indices of each query's points.
    #[must_use]
    pub fn as_motion(&self) -> ([Vec<DVec3>; 2], Vec<[u32; 4]>) {
        let x0 = self.queries.iter().flat_map(|query| query.x0).collect();
        let x1 = self.queries.iter().flat_map(|query| query.x1).collect();
        let indices = (0..).step_by(4).map(|first| [first, first + 1, first + 2, first + 3]);
        ([x0, x1], indices.take(self.queries.len()).collect())
    }
}
