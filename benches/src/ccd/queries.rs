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
