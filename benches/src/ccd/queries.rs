//! Queries with exact answers: read from files, or made.

use std::io;
use std::path::Path;

use glam::DVec3;

/// What is tested against what.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A vertex, then the corners of a face.
    VertexFace,
    /// The ends of one edge, then of another.
    EdgeEdge,
}

/// One query: four points at both ends of a step, and the exact answer.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// Points at time 0.
    pub x0: [DVec3; 4],
    /// Points at time 1.
    pub x1: [DVec3; 4],
    /// Exact time of the first contact, rounded down; infinite for none.
    pub time: f64,
}

/// Queries of one kind.
#[derive(Clone, Debug)]
pub struct QuerySet {
    /// Name of the set.
    pub name: String,
    /// What they ask.
    pub kind: Kind,
    /// The queries.
    pub queries: Vec<Query>,
}

/// Bytes before the first position.
const HEADER: usize = 32;

/// Reads a file of labelled queries: magic `CCDQ0001`, then little endian kind
/// (u32, 0 vertex-face, 1 edge-edge), flags (u32), count (u64), zero (u64),
/// positions (f64, 8 points a query), times (f64), and bytes that are not used.
///
/// # Errors
///
/// When the file cannot be read or is not such a file.
pub fn read(folder: &Path, name: &str) -> io::Result<QuerySet> {
    let bytes = std::fs::read(folder.join(name).with_extension("ccdq"))?;
    let invalid = || io::Error::new(io::ErrorKind::InvalidData, format!("{name} is no query file"));
    let word = |at: usize| -> io::Result<[u8; 8]> {
        bytes.get(at..at + 8).and_then(|word| word.try_into().ok()).ok_or_else(invalid)
    };
    if &word(0)? != b"CCDQ0001" {
        return Err(invalid());
    }
    let kind = if bytes[8] == 0 { Kind::VertexFace } else { Kind::EdgeEdge };
    let count = usize::try_from(u64::from_le_bytes(word(16)?)).map_err(|_| invalid())?;
    let number = |i: usize| Ok::<_, io::Error>(f64::from_le_bytes(word(HEADER + 8 * i)?));
    let points = |query: usize, end: usize| -> io::Result<[DVec3; 4]> {
        let mut points = [DVec3::ZERO; 4];
        for (i, point) in points.iter_mut().enumerate() {
            let at = 3 * (8 * query + 4 * end + i);
            *point = DVec3::new(number(at)?, number(at + 1)?, number(at + 2)?);
        }
        Ok(points)
    };
    let query = |i: usize| {
        Ok(Query { x0: points(i, 0)?, x1: points(i, 1)?, time: number(24 * count + i)? })
    };
    let queries = (0..count).map(query).collect::<io::Result<_>>()?;
    Ok(QuerySet { name: name.to_owned(), kind, queries })
}

/// Queries that are made rather than read: points in a unit cube that move by
/// up to half of it. Their exact answers are not known.
#[must_use]
pub fn made(kind: Kind, count: usize) -> QuerySet {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut point =
        |size: f64| DVec3::from_array(std::array::from_fn(|_| size * signed_unit(&mut state)));
    let query = |_| {
        let x0 = std::array::from_fn(|_| point(0.5));
        Query { x0, x1: x0.map(|x| x + point(0.5)), time: f64::NAN }
    };
    let name = if kind == Kind::VertexFace { "made_vf" } else { "made_ee" };
    QuerySet { name: name.to_owned(), kind, queries: (0..count).map(query).collect() }
}

/// Queries that are made to be degenerate: points on a lattice of few places that move on it, so
/// that many touch at a corner, at an edge, at an end of the step, or move in one plane. Their exact
/// answers are not known.
#[must_use]
pub fn made_on_lattice(kind: Kind, count: usize) -> QuerySet {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut point =
        || DVec3::from_array(std::array::from_fn(|_| (2.0 * signed_unit(&mut state)).round()));
    let query = |_| {
        let x0 = std::array::from_fn(|_| point());
        Query { x0, x1: std::array::from_fn(|_| point()), time: f64::NAN }
    };
    let name = if kind == Kind::VertexFace { "lattice_vf" } else { "lattice_ee" };
    QuerySet { name: name.to_owned(), kind, queries: (0..count).map(query).collect() }
}

/// A number in `-1.0..1.0`, by a 64-bit xorshift generator.
fn signed_unit(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    f64::from(u32::try_from(*state >> 32).unwrap_or(0)) / f64::from(1_u32 << 31) - 1.0
}

impl QuerySet {
    /// Whether the exact answers are known.
    #[must_use]
    pub fn is_labelled(&self) -> bool {
        self.queries.iter().all(|query| !query.time.is_nan())
    }

    /// Every `step`-th query.
    #[must_use]
    pub fn thinned(&self, step: usize) -> Vec<Query> {
        self.queries.iter().step_by(step).copied().collect()
    }

    /// All points at both ends of the step, and the places of each query's
    /// among them.
    #[must_use]
    pub fn as_motion(&self) -> ([Vec<DVec3>; 2], Vec<[u32; 4]>) {
        let x0 = self.queries.iter().flat_map(|query| query.x0).collect();
        let x1 = self.queries.iter().flat_map(|query| query.x1).collect();
        let places = (0..).step_by(4).map(|first| [first, first + 1, first + 2, first + 3]);
        ([x0, x1], places.take(self.queries.len()).collect())
    }
}
