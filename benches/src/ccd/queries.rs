//! Continuous collision queries with exact answers: read from files, or generated.

use std::array;
use std::io::{self, ErrorKind};
use std::path::Path;

use fixtures::random::Random;
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
    parse(name, &bytes).ok_or_else(|| {
        io::Error::new(ErrorKind::InvalidData, format!("{name} is not a query file"))
    })
}

fn parse(name: &str, bytes: &[u8]) -> Option<QuerySet> {
    let (header, rest) = bytes.split_at_checked(HEADER)?;
    if !header.starts_with(b"CCDQ0001") {
        return None;
    }

    // The header, then all numbers of the rest.
    let kind = if header[8] == 0 { QueryKind::VertexFace } else { QueryKind::EdgeEdge };
    let (count, _) = header[16..].split_first_chunk()?;
    let count = usize::try_from(u64::from_le_bytes(*count)).ok()?;
    let mut numbers = Vec::new();
    for bytes in rest.as_chunks().0 {
        numbers.push(f64::from_le_bytes(*bytes));
    }

    // Positions of all queries, then their times.
    let (positions, times) = numbers.split_at_checked(count.checked_mul(NUMBERS)?)?;
    let mut queries = Vec::new();
    for (x, &time) in positions.chunks_exact(NUMBERS).zip(times.get(..count)?) {
        let (x0, x1) = x.split_at(NUMBERS / 2);
        queries.push(CcdQuery { kind, x0: points(x0), x1: points(x1), time });
    }
    Some(QuerySet { name: name.to_owned(), kind, queries })
}

fn points(coordinates: &[f64]) -> [DVec3; 4] {
    array::from_fn(|i| DVec3::from_slice(&coordinates[3 * i..]))
}

/// Generates queries at random: points in a unit cube that move by up to half of it.
#[must_use]
pub fn random(kind: QueryKind, count: usize) -> QuerySet {
    generate("random", kind, count, |start, target| [0.5 * start, 0.5 * (start + target)])
}

/// Generates degenerate queries: points on a small lattice that move on it, so that many touch at
/// a corner, at an edge, at an end of the step, or move in one plane.
#[must_use]
pub fn on_lattice(kind: QueryKind, count: usize) -> QuerySet {
    generate("lattice", kind, count, |start, target| {
        [(2.0 * start).round(), (2.0 * target).round()]
    })
}

/// Generates queries without answers: `place` maps two points of the cube `-1.0..=1.0` to both
/// ends of a point's step.
fn generate(
    name: &str,
    kind: QueryKind,
    count: usize,
    place: fn(DVec3, DVec3) -> [DVec3; 2],
) -> QuerySet {
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut queries = Vec::new();
    for _ in 0..count {
        let mut query =
            CcdQuery { kind, x0: [DVec3::ZERO; 4], x1: [DVec3::ZERO; 4], time: f64::NAN };
        for (x0, x1) in query.x0.iter_mut().zip(&mut query.x1) {
            [*x0, *x1] = place(in_cube(&mut random), in_cube(&mut random));
        }
        queries.push(query);
    }
    let suffix = if kind == QueryKind::VertexFace { "vf" } else { "ee" };
    QuerySet { name: format!("{name}_{suffix}"), kind, queries }
}

fn in_cube(random: &mut Random) -> DVec3 {
    2.0 * DVec3::new(random.unit(), random.unit(), random.unit()) - DVec3::ONE
}

/// Returns the mean extent of queries: the maximum distance of a point from the first.
#[must_use]
pub fn mean_extent(queries: &[CcdQuery]) -> f64 {
    let mut sum = 0.0;
    for query in queries {
        let mut extent = 0.0_f64;
        for x in query.x0 {
            extent = extent.max(x.distance(query.x0[0]));
        }
        sum += extent;
    }
    sum / as_f64(queries.len().max(1))
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
        let (mut x0, mut x1, mut indices) = (Vec::new(), Vec::new(), Vec::new());
        for (query, first) in self.queries.iter().zip((0..).step_by(4)) {
            x0.extend(query.x0);
            x1.extend(query.x1);
            indices.push([first, first + 1, first + 2, first + 3]);
        }
        ([x0, x1], indices)
    }
}
