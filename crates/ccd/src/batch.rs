//! Batches of candidates, by index into shared positions.
//!
//! Candidates come from a broad phase, and most of them do not meet. They are filtered in groups,
//! and the remaining ones are searched one by one. Answers are those of the single queries, in the
//! order of the candidates, and the same to the bit for any number of threads.

use glam::DVec3;

use crate::contact::{CcdContact, CcdParams};
use crate::error::{CcdError, StepEnd};
use crate::lanes::{LANES, LaneCorners, Vectors, not_excluded};
use crate::outline::check_finite;
use crate::search::first_contact;
use crate::shape::{Corners, PolygonShape};

const CHUNK: usize = MovingPoints::CHUNK;

/// Number of candidates per round of [`MovingPoints::first_contact`].
///
/// The contacts of a round limit the time of the next. With fewer candidates threads would wait,
/// with more they would search for contacts that are too late to matter.
const ROUND: usize = 16 * CHUNK;

/// Points that move on straight lines during a step, with finite positions.
#[derive(Clone, Copy, Debug)]
pub struct MovingPoints<'a> {
    x0: &'a [DVec3],
    x1: &'a [DVec3],
    /// Distances that points may be from their straight lines; empty for none.
    deviations: &'a [f64],
}

/// Contact of one candidate of a list.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CandidateContact {
    /// Position of the candidate in its list.
    pub candidate: usize,
    /// First contact of the candidate.
    pub contact: CcdContact,
}

/// First contact among all candidates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FirstContact {
    /// Contact of a vertex and a face, with the position in their list.
    VertexFace(CandidateContact),
    /// Contact of two edges, with the position in their list.
    EdgeEdge(CandidateContact),
}

impl FirstContact {
    /// Returns the contact of either kind.
    #[must_use]
    pub fn contact(&self) -> &CcdContact {
        match self {
            Self::VertexFace(found) | Self::EdgeEdge(found) => &found.contact,
        }
    }
}

impl<'a> MovingPoints<'a> {
    /// Number of candidates per task: at tens of nanoseconds each, far more than handing it to a
    /// thread costs. A list of at most as many stays on the calling thread.
    pub const CHUNK: usize = 1024;

    /// Checks and holds positions at the start and the end of a step (`|V|` each).
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
        Ok(Self { x0, x1, deviations: &[] })
    }

    /// Lets each point be a distance (|V|, `>= 0`) from its straight line: candidates that come within
    /// the minimum separation and the deviations of both primitives are contacts.
    ///
    /// # Errors
    ///
    /// When there is another number of deviations than of points, or one is negative or not finite.
    pub fn with_deviations(self, deviations: &'a [f64]) -> Result<Self, CcdError> {
        if deviations.len() != self.x0.len() {
            return Err(CcdError::PositionCount { start: self.x0.len(), end: deviations.len() });
        }
        let is_wrong = |deviation: &&f64| !(**deviation >= 0.0 && deviation.is_finite());
        if let Some(&deviation) = deviations.iter().find(is_wrong) {
            return Err(CcdError::MinSeparation(deviation));
        }
        Ok(Self { deviations, ..self })
    }

    /// Returns parameters whose separation has room for the deviations of a candidate.
    fn with_room<const N: usize>(&self, points: [u32; 4], params: &CcdParams) -> CcdParams {
        if self.deviations.is_empty() {
            return *params;
        }

        // A point of a primitive deviates by no more than the worst of its corners.
        let deviation = points.map(|point| self.deviations[point as usize]);
        let [a, b, c, d] = deviation;
        let both = if N == 3 { a + b.max(c).max(d) } else { a.max(b) + c.max(d) };
        let min_separation = (params.min_separation + both) * (1.0 + 2.0 * f64::EPSILON);
        CcdParams { min_separation, ..*params }
    }

    /// Returns the position of one point at a time in `0.0..=1.0` of the step.
    ///
    /// # Panics
    ///
    /// When there is no such point.
    #[must_use]
    pub fn at(&self, point: u32, time: f64) -> DVec3 {
        self.x0[point as usize].lerp(self.x1[point as usize], time)
    }

    /// Finds the first contacts of vertices with faces, each candidate a vertex and the corners of a
    /// face.
    ///
    /// Candidates without a contact are not listed.
    ///
    /// # Errors
    ///
    /// When a parameter is out of range, or a candidate refers to a point that does not exist.
    pub fn vertex_face_contacts(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Vec<CandidateContact>, CcdError> {
        self.contacts::<3>(candidates, params)
    }

    /// Finds the first contacts of edges with edges, each candidate the ends of one and of the
    /// other.
    ///
    /// Candidates without a contact are not listed.
    ///
    /// # Errors
    ///
    /// Those of [`MovingPoints::vertex_face_contacts`].
    pub fn edge_edge_contacts(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Vec<CandidateContact>, CcdError> {
        self.contacts::<4>(candidates, params)
    }

    /// Finds the first contact among all candidates: up to its `lo`, all points are free to move.
    ///
    /// Of contacts with the same `lo` it is the first listed, vertices and faces before edges. This
    /// is cheaper than listing all contacts, since none that is later than one already found is
    /// searched for.
    ///
    /// # Errors
    ///
    /// Those of [`MovingPoints::vertex_face_contacts`].
    pub fn first_contact(
        &self,
        vertex_faces: &[[u32; 4]],
        edge_edges: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Option<FirstContact>, CcdError> {
        // Of edges, only contacts before that of a face matter.
        let face = self.first_of::<3>(vertex_faces, params)?;
        let t_max = face.map_or(params.t_max, |found| found.contact.lo);
        let edge = self.first_of::<4>(edge_edges, &CcdParams { t_max, ..*params })?;
        Ok(match (face, edge) {
            (Some(face), Some(edge)) if face.contact.lo <= edge.contact.lo => {
                Some(FirstContact::VertexFace(face))
            }
            (face, None) => face.map(FirstContact::VertexFace),
            (_, Some(edge)) => Some(FirstContact::EdgeEdge(edge)),
        })
    }

    /// Returns the positions of the vertex-face candidates that the filters cannot drop.
    ///
    /// These are all with a contact until `params.t_max`, and a few without.
    ///
    /// # Errors
    ///
    /// Those of [`MovingPoints::vertex_face_contacts`].
    pub fn filter_vertex_faces(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Vec<usize>, CcdError> {
        self.filter::<3>(candidates, params)
    }

    /// Returns the positions of the edge-edge candidates that the filters cannot drop.
    ///
    /// # Errors
    ///
    /// Those of [`MovingPoints::vertex_face_contacts`].
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
        PolygonShape<N>: Corners<N> + LaneCorners,
    {
        self.validate(candidates, params)?;
        let chunks = map_chunks(candidates, |start, chunk| {
            let mut found = Vec::new();
            self.visit::<N>(start, chunk, *params, |contact, _| found.push(contact))?;
            Ok(found)
        });
        Ok(chunks.into_iter().collect::<Result<Vec<_>, _>>()?.concat())
    }

    fn filter<const N: usize>(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Vec<usize>, CcdError>
    where
        PolygonShape<N>: LaneCorners,
    {
        self.validate(candidates, params)?;
        let chunks = map_chunks(candidates, |start, chunk| {
            let mut kept = Vec::new();
            for (group, points) in chunk.chunks(LANES).enumerate() {
                let lanes = set_bits(self.kept_lanes::<N>(points, params));
                kept.extend(lanes.map(|lane| start + group * LANES + lane));
            }
            kept
        });
        Ok(chunks.concat())
    }

    /// Finds the first contact of a list, in rounds of fixed size.
    fn first_of<const N: usize>(
        &self,
        candidates: &[[u32; 4]],
        params: &CcdParams,
    ) -> Result<Option<CandidateContact>, CcdError>
    where
        PolygonShape<N>: Corners<N> + LaneCorners,
    {
        self.validate(candidates, params)?;
        let mut first: Option<CandidateContact> = None;
        for (round, candidates) in candidates.chunks(ROUND).enumerate() {
            // Whole rounds limit the time of the next, so that the answer does not depend on how
            // the chunks of a round are scheduled.
            let t_max = first.map_or(params.t_max, |found| found.contact.lo);
            let params = CcdParams { t_max, ..*params };
            let chunks = map_chunks(candidates, |start, chunk| {
                self.first_of_chunk::<N>(round * ROUND + start, chunk, params)
            });
            for found in chunks {
                first = earlier(first, found?);
            }
        }
        Ok(first)
    }

    fn first_of_chunk<const N: usize>(
        &self,
        start: usize,
        chunk: &[[u32; 4]],
        params: CcdParams,
    ) -> Result<Option<CandidateContact>, CcdError>
    where
        PolygonShape<N>: Corners<N> + LaneCorners,
    {
        let mut first = None;
        self.visit::<N>(start, chunk, params, |contact, t_max| {
            first = earlier(first, Some(contact));
            *t_max = t_max.min(contact.contact.lo);
        })?;
        Ok(first)
    }

    /// Calls `found` for each candidate of a chunk with a contact.
    ///
    /// It may lower the last time of interest for those that follow.
    fn visit<const N: usize>(
        &self,
        start: usize,
        chunk: &[[u32; 4]],
        mut params: CcdParams,
        mut found: impl FnMut(CandidateContact, &mut f64),
    ) -> Result<(), CcdError>
    where
        PolygonShape<N>: Corners<N> + LaneCorners,
    {
        // Filter a group in lanes, then search the queries that are left.
        for (group, points) in chunk.chunks(LANES).enumerate() {
            for lane in set_bits(self.kept_lanes::<N>(points, &params)) {
                let [x0, x1] =
                    [self.x0, self.x1].map(|x| points[lane].map(|point| x[point as usize]));
                let of_candidate = self.with_room::<N>(points[lane], &params);
                if let Some(contact) = first_contact::<N>(&x0, &x1, &of_candidate)? {
                    let candidate = start + group * LANES + lane;
                    found(CandidateContact { candidate, contact }, &mut params.t_max);
                }
            }
        }
        Ok(())
    }

    /// Filters up to `LANES` candidates: the bit of each that the filters cannot drop is set.
    #[inline]
    fn kept_lanes<const N: usize>(&self, candidates: &[[u32; 4]], params: &CcdParams) -> u32
    where
        PolygonShape<N>: LaneCorners,
    {
        // Spare lanes repeat the last candidate.
        let last = candidates.len() - 1;
        let lanes: [[u32; 4]; LANES] = std::array::from_fn(|lane| candidates[lane.min(last)]);
        let gather = |x: &[DVec3]| -> [Vectors; 4] {
            std::array::from_fn(|i| Vectors::gather(lanes.map(|lane| x[lane[i] as usize])))
        };
        let (x0, x1) = (gather(self.x0), gather(self.x1));

        // Candidates of a group are near each other: the largest separation serves all.
        let mut separation = params.min_separation;
        if !self.deviations.is_empty() {
            for lane in lanes {
                separation = separation.max(self.with_room::<N>(lane, params).min_separation);
            }
        }
        not_excluded::<PolygonShape<N>>(&x0, &x1, params.t_max, separation) & ((2 << last) - 1)
    }

    /// Checks the parameters, and that all candidates refer to points that exist.
    fn validate(&self, candidates: &[[u32; 4]], params: &CcdParams) -> Result<(), CcdError> {
        params.validate()?;
        let count = self.x0.len();
        for (candidate, points) in candidates.iter().enumerate() {
            if let Some(&point) = points.iter().find(|&&point| point as usize >= count) {
                return Err(CcdError::PointOutOfRange { candidate, point, count });
            }
        }
        Ok(())
    }
}

/// Calls `f` with each chunk of a list and its position, on one thread or several, and returns the
/// results in order.
fn map_chunks<R: Send>(
    candidates: &[[u32; 4]],
    f: impl Fn(usize, &[[u32; 4]]) -> R + Sync,
) -> Vec<R> {
    let at_chunk = |(i, chunk): (usize, &[[u32; 4]])| f(i * CHUNK, chunk);
    #[cfg(feature = "rayon")]
    if candidates.len() > CHUNK {
        use rayon::prelude::*;
        return candidates.par_chunks(CHUNK).enumerate().map(at_chunk).collect();
    }
    candidates.chunks(CHUNK).enumerate().map(at_chunk).collect()
}

/// Returns the positions of the bits that are set, ascending.
#[inline]
fn set_bits(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lowest = mask.trailing_zeros();
        mask &= mask.wrapping_sub(1);
        (lowest < u32::BITS).then_some(lowest as usize)
    })
}

/// Returns the earlier of two contacts, the first one if they are equally early.
fn earlier(a: Option<CandidateContact>, b: Option<CandidateContact>) -> Option<CandidateContact> {
    let by_time =
        |a: &CandidateContact, b: &CandidateContact| a.contact.lo.total_cmp(&b.contact.lo);
    a.into_iter().chain(b).min_by(by_time)
}
