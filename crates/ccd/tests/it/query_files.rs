//! Query files in the folder `ccd` of the environment variable `MUSCULO_DATA`.

#![expect(clippy::print_stdout, reason = "a skipped test prints a line")]

use std::path::PathBuf;

use ccd::{CcdContact, CcdError, CcdParams};
use glam::DVec3;

/// Kind of a query.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    VertexFace,
    EdgeEdge,
}

impl Kind {
    /// Runs the query of this kind.
    pub(crate) fn query(
        self,
        x0: [DVec3; 4],
        x1: [DVec3; 4],
        params: &CcdParams,
    ) -> Result<Option<CcdContact>, CcdError> {
        match self {
            Self::VertexFace => ccd::vertex_face(x0, x1, params),
            Self::EdgeEdge => ccd::edge_edge(x0, x1, params),
        }
    }
}

/// Query with its exact answer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LabeledQuery {
    pub(crate) x0: [DVec3; 4],
    pub(crate) x1: [DVec3; 4],
    /// Exact time of the first contact, rounded down; infinite where there is none.
    pub(crate) time: f64,
    /// Family of the query.
    pub(crate) group: u8,
}

/// Returns the folder with the query files; prints a line if there is none.
pub(crate) fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("MUSCULO_DATA").map(|data| PathBuf::from(data).join("ccd"));
    if folder.is_none() {
        println!("skipped: MUSCULO_DATA is not set");
    }
    folder
}

/// Reads all queries of a file.
pub(crate) fn read(path: &std::path::Path) -> (Kind, Vec<LabeledQuery>) {
    let bytes = std::fs::read(path).expect("the query file can be read");
    assert_eq!(&bytes[..8], b"CCDQ0001", "{} is a query file", path.display());
    let kind = if bytes[8] == 0 { Kind::VertexFace } else { Kind::EdgeEdge };
    let word = |at: usize| <[u8; 8]>::try_from(&bytes[at..at + 8]).expect("eight bytes");
    let count = usize::try_from(u64::from_le_bytes(word(16))).expect("the count fits");
    let number = |i: usize| f64::from_le_bytes(word(32 + 8 * i));
    let point = |i: usize| DVec3::new(number(3 * i), number(3 * i + 1), number(3 * i + 2));
    let groups = 32 + 8 * (24 * count + count) + count;
    let query = |i: usize| LabeledQuery {
        x0: std::array::from_fn(|k| point(8 * i + k)),
        x1: std::array::from_fn(|k| point(8 * i + 4 + k)),
        time: number(24 * count + i),
        group: bytes[groups + i],
    };
    (kind, (0..count).map(query).collect())
}
