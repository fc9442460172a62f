//! Many candidates at once, by index into shared positions.
//!
//! Candidates come from a broad phase, which passes on mostly pairs that do not
//! meet. They are filtered in groups, and what is left is searched one by one.
//! Answers are those of the single queries, in the order of the candidates, and
//! the same to the bit for any number of threads.

use glam::DVec3;

use crate::contact::{CcdContact, CcdParams};
use crate::error::{CcdError, StepEnd};
use crate::lanes::{self, LANES, LaneCorners, Vectors};
use crate::polygon::{Corners, Shape, check_finite};
use crate::search::first_contact;

/// Positions of all points at the start and the end of a step, known to be
/// finite and equally many.
#[derive(Clone, Copy, Debug)]
pub struct MovingPoints<'a> {
    pub(crate) x0: &'a [DVec3],
    pub(crate) x1: &'a [DVec3],
}

/// A contact of one candidate of a list.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CandidateContact {
    /// Place of the candidate in its list.
    pub candidate: usize,
    /// Its first contact.
    pub contact: CcdContact,
}

/// The first contact of all.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FirstContact {
    /// A vertex meets a face; the place is one in the list of these.
    VertexFace(CandidateContact),
    /// Two edges meet; the place is one in the list of these.
    EdgeEdge(CandidateContact),
}

impl FirstContact {
    /// The contact, whichever kind.
    #[must_use]
    pub fn contact(&self) -> &CcdContact {
        match self {
            Self::VertexFace(found) | Self::EdgeEdge(found) => &found.contact,
        }
    }
}

impl<'a> MovingPoints<'a> {
    /// Checks positions at the start and the end of a step (both `|V|`).
    ///
    /// # Errors
    ///
    /// When they differ in number, or a coordinate is not finite.
    pub fn new(x0: &'a [DVec3], x1: &'a [DVec3]) -> Result<Self, CcdError> {
        if x0.len() != x1.len() {
            return Err(CcdError::PositionCount { start: x0.len(), end: x1.len() });
        }
        check_finite(x0, StepEnd::Start)?;
        check_finite(x1, StepEnd::Finish)?;
        Ok(Self { x0, x1 })
    }

    /// Position of one point at a time in `0.0..=1.0` of the step.
    ///
    /// # Panics
    ///
    /// When there is no such point.
    #[must_use]
    pub fn at(&self, point: u32, time: f64) -> DVec3 {
        self.x0[point as usize].lerp(self.x1[point as usize], time)
    }

    /// First contacts of vertices with faces, each candidate a vertex and the
    /// corners of a face. Only candidates with a contact are listed.
    ///
    /// # Errors
    ///
    /// When a parameter is out of range, or a candidate refers to a point that
    /// does not exist.
    pub fn vertex_face_contacts(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Vec<CandidateContact>, CcdError> {
        self.contacts::<3>(candidates, params)
    }

    /// First contacts of edges with edges, each candidate the ends of one and
    /// of the other. Only candidates with a contact are listed.
    ///
    /// # Errors
    ///
    /// As [`MovingPoints::vertex_face_contacts`].
    pub fn edge_edge_contacts(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Vec<CandidateContact>, CcdError> {
        self.contacts::<4>(candidates, params)
    }

    /// The first contact among all candidates: up to its `lo`, everything is
    /// free to move. Of contacts with the same `lo` it is the first listed,
    /// vertices and faces before edges.
    ///
    /// Cheaper than listing all contacts, since none that is later than one
    /// already found has to be looked for.
    ///
    /// # Errors
    ///
    /// As [`MovingPoints::vertex_face_contacts`].
    pub fn first_contact(
        &self,
        vertex_faces: &[[u32; 4]],
        edge_edges: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Option<FirstContact>, CcdError> {
        let first = self.first_of::<3>(vertex_faces, params)?;
        let t_max = first.map_or(params.t_max, |found| found.contact.lo);
        let second = self.first_of::<4>(edge_edges, &CcdParams { t_max, ..*params })?;
        let second =
            second.filter(|second| first.is_none_or(|first| second.contact.lo < first.contact.lo));
        Ok(second.map(FirstContact::EdgeEdge).or(first.map(FirstContact::VertexFace)))
    }

    /// Places of the vertex-face candidates that the filters cannot drop:
    /// certainly all with a contact until `params.t_max`, and a few without.
    ///
    /// # Errors
    ///
    /// As [`MovingPoints::vertex_face_contacts`].
    pub fn filter_vertex_faces(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Vec<usize>, CcdError> {
        self.filter::<3>(candidates, params)
    }

    /// Places of the edge-edge candidates that the filters cannot drop.
    ///
    /// # Errors
    ///
    /// As [`MovingPoints::vertex_face_contacts`].
    pub fn filter_edge_edges(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Vec<usize>, CcdError> {
        self.filter::<4>(candidates, params)
    }

    fn contacts<const N: usize>(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Vec<CandidateContact>, CcdError>
    where
        Shape<N>: Corners<N>,
        Shape<N>: LaneCorners,
    {
        self.check(candidates, params)?;
        let chunks = map_chunks(candidates, |from, chunk| {
            let mut found = Vec::new();
            self.visit::<N>(from, chunk, *params, |contact, _| found.push(contact))?;
            Ok(found)
        });
        chunks.into_iter().try_fold(Vec::new(), |mut all, chunk| {
            all.append(&mut chunk?);
            Ok(all)
        })
    }

    fn filter<const N: usize>(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Vec<usize>, CcdError>
    where
        Shape<N>: LaneCorners,
    {
        self.check(candidates, params)?;
        let chunks = map_chunks(candidates, |from, chunk| {
            let mut left = Vec::new();
            for (group, points) in chunk.chunks(LANES).enumerate() {
                let lanes = self.left_over::<N>(points, params);
                left.extend(bits(lanes).map(|lane| from + group * LANES + lane));
            }
            left
        });
        Ok(chunks.concat())
    }

    /// The first contact of a list. The list is worked off in rounds of fixed
    /// size, and what a round has found limits the next, so that the answer
    /// does not depend on how the chunks of a round are scheduled.
    fn first_of<const N: usize>(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Option<CandidateContact>, CcdError>
    where
        Shape<N>: Corners<N>,
        Shape<N>: LaneCorners,
    {
        self.check(candidates, params)?;
        let mut first: Option<CandidateContact> = None;
        for (round, candidates) in candidates.chunks(ROUND).enumerate() {
            let t_max = first.map_or(params.t_max, |found| found.contact.lo);
            let params = CcdParams { t_max, ..*params };
            let chunks = map_chunks(candidates, |from, chunk| {
                self.first_of_chunk::<N>(round * ROUND + from, chunk, params)
            });
            for found in chunks {
                first = earlier(first, found?);
            }
        }
        Ok(first)
    }

    fn first_of_chunk<const N: usize>(
        &self,
        from: usize,
        chunk: &[[u32; 4]],
        params: CcdParams,
    ) -> Result<Option<CandidateContact>, CcdError>
    where
        Shape<N>: Corners<N>,
        Shape<N>: LaneCorners,
    {
        let mut first = None;
        self.visit::<N>(from, chunk, params, |contact, t_max| {
            first = earlier(first, Some(contact));
            *t_max = t_max.min(contact.contact.lo);
        })?;
        Ok(first)
    }

    /// Calls `found` for each candidate of a chunk with a contact. It may
    /// lower the last time of interest for those that follow.
    fn visit<const N: usize>(
        &self,
        from: usize,
        chunk: &[[u32; 4]],
        mut params: CcdParams,
        mut found: impl FnMut(CandidateContact, &mut f64),
    ) -> Result<(), CcdError>
    where
        Shape<N>: Corners<N>,
        Shape<N>: LaneCorners,
    {
        for (group, points) in chunk.chunks(LANES).enumerate() {
            for lane in bits(self.left_over::<N>(points, &params)) {
                let [x0, x1] = self.gather(&points[lane]);
                if let Some(contact) = first_contact::<N>(&x0, &x1, &params)? {
                    let candidate = from + group * LANES + lane;
                    found(CandidateContact { candidate, contact }, &mut params.t_max);
                }
            }
        }
        Ok(())
    }

    /// One bit for each of up to `LANES` candidates that the filters cannot drop.
    #[inline]
    fn left_over<const N: usize>(&self, points: &[[u32; 4]], params: &CcdParams) -> u32
    where
        Shape<N>: LaneCorners,
    {
        let last = points.len() - 1;
        let lanes: [[u32; 4]; LANES] = std::array::from_fn(|lane| points[lane.min(last)]);
        let gather = |x: &[DVec3]| -> [Vectors; 4] {
            std::array::from_fn(|i| Vectors::gather(lanes.map(|lane| x[lane[i] as usize])))
        };
        let (x0, x1) = (gather(self.x0), gather(self.x1));
        lanes::left_over::<Shape<N>>(&x0, &x1, params.t_max, params.min_separation)
            & ((2 << last) - 1)
    }

    fn check(&self, candidates: &[[u32; 4]], params: &CcdParams) -> Result<(), CcdError> {
        params.validate()?;
        for (candidate, points) in candidates.iter().enumerate() {
            self.check_points(candidate, points)?;
        }
        Ok(())
    }

    #[inline]
    fn check_points(&self, candidate: usize, points: &[u32; 4]) -> Result<(), CcdError> {
        let count = self.x0.len();
        match points.iter().find(|&&point| point as usize >= count) {
            None => Ok(()),
            Some(&point) => Err(CcdError::PointOutOfRange { candidate, point, count }),
        }
    }

    /// Positions of points at both ends of the step, if they exist.
    pub(crate) fn points(
        &self,
        candidate: usize,
        points: &[u32; 4],
    ) -> Result<[[DVec3; 4]; 2], CcdError> {
        self.check_points(candidate, points)?;
        Ok(self.gather(points))
    }

    #[inline]
    fn gather(&self, points: &[u32; 4]) -> [[DVec3; 4]; 2] {
        [self.x0, self.x1].map(|x| points.map(|point| x[point as usize]))
    }
}

/// Candidates that are worked off as one task: at tens of nanoseconds each, far
/// more than handing it to a thread costs.
const CHUNK: usize = 1024;

/// Candidates worked off before what they have found limits the time for the
/// rest. Fewer would leave threads waiting, more would look for contacts that
/// are too late to matter.
const ROUND: usize = 16 * CHUNK;

/// Calls `f` with each chunk of a list and its place, in order or in parallel,
/// and returns what it returned, in order.
#[cfg(not(feature = "rayon"))]
fn map_chunks<R>(candidates: &[[u32; 4]], f: impl Fn(usize, &[[u32; 4]]) -> R + Sync) -> Vec<R> {
    candidates.chunks(CHUNK).enumerate().map(|(i, chunk)| f(i * CHUNK, chunk)).collect()
}

/// Calls `f` with each chunk of a list and its place, in order or in parallel,
/// and returns what it returned, in order.
#[cfg(feature = "rayon")]
fn map_chunks<R: Send>(
    candidates: &[[u32; 4]],
    f: impl Fn(usize, &[[u32; 4]]) -> R + Sync,
) -> Vec<R> {
    use rayon::prelude::*;

    candidates.par_chunks(CHUNK).enumerate().map(|(i, chunk)| f(i * CHUNK, chunk)).collect()
}

/// Places of the bits that are set, ascending.
#[inline]
fn bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (lowest < u32::BITS).then_some(lowest as usize)
    })
}

/// The earlier of two contacts, the first one if they are equally early.
fn earlier(a: Option<CandidateContact>, b: Option<CandidateContact>) -> Option<CandidateContact> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.contact.lo < a.contact.lo { b } else { a }),
        (a, b) => a.or(b),
    }
}
