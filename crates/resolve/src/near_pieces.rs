//! Near faces and vertices of two bodies, by pairs of their pieces.

use std::collections::BTreeMap;

use proximity::NearVertex;
use scene::PairReport;

use crate::tissue::Tissue;

/// Numbers of two pieces, of either body of a pair.
pub(crate) type PiecePair = [u32; 2];

/// Near faces and vertices of two pieces of a pair.
#[derive(Default)]
pub(crate) struct NearPieces {
    /// Vertices of either body.
    pub(crate) near: [Vec<NearVertex>; 2],
    pub(crate) crossing_faces: Vec<[u32; 2]>,
}

impl Tissue {
    /// Returns the number of the piece that a face is of; 0 in bodies of one piece.
    pub(crate) fn piece_of_face(&self, face: u32) -> u32 {
        self.piece_of(self.corners(face)[0])
    }

    /// Returns the number of the piece that a vertex is of; 0 in bodies of one piece.
    fn piece_of(&self, vertex: u32) -> u32 {
        self.pieces.get(vertex as usize).copied().unwrap_or_default()
    }
}

/// Splits what is near between two bodies by their pieces, in the order of their numbers.
pub(crate) fn near_pieces(
    [a, b]: [&Tissue; 2],
    report: &PairReport,
) -> BTreeMap<PiecePair, NearPieces> {
    let mut pieces: BTreeMap<PiecePair, NearPieces> = BTreeMap::new();
    for near in &report.a_against_b.near {
        let pair = [a.piece_of(near.vertex), b.piece_of_face(near.face)];
        pieces.entry(pair).or_default().near[0].push(*near);
    }
    for near in &report.b_against_a.near {
        let pair = [a.piece_of_face(near.face), b.piece_of(near.vertex)];
        pieces.entry(pair).or_default().near[1].push(*near);
    }
    for &[face_a, face_b] in &report.crossing_faces {
        let pair = [a.piece_of_face(face_a), b.piece_of_face(face_b)];
        pieces.entry(pair).or_default().crossing_faces.push([face_a, face_b]);
    }
    pieces
}
