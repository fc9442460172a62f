//! Many candidates at once, by index into shared positions.
//!
//! Candidates come from a broad phase, which passes on mostly pairs that do not
//! meet. They are filtered in groups, and what is left is searched one by one.
//! Answers are those of the single queries, in the order of the candidates, and
//! the same to the bit for any number of threads.

use glam::DVec3;

use crate::contact::{Contact, Params};
use crate::error::{CcdError, StepEnd};
use crate::polygon::{Corners, MovingPolygon, check_finite};
use crate::search::first_contact;

/// Positions of all points at the start and the end of a step, known to be
/// finite and equally many.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
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
    pub contact: Contact,
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
    pub fn contact(&self) -> &Contact {
        match self {
            Self::VertexFace(found) | Self::EdgeEdge(found) => &found.contact,
        }
    }
}

impl<'a> Motion<'a> {
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
    /// corners of a face.
    ///
    /// # Errors
    ///
    /// When a parameter is out of range, or a candidate refers to a point that
    /// does not exist.
    pub fn vertex_faces(
        &self,
        candidates: &[[u32; 4]],
        params: &Params,
    ) -> Result<Vec<CandidateContact>, CcdError> {
        self.contacts::<3>(candidates, params)
    }

    /// First contacts of edges with edges, each candidate the ends of both.
    ///
    /// # Errors
    ///
    /// As [`Motion::vertex_faces`].
    pub fn edge_edges(
        &self,
        candidates: &[[u32; 4]],
        params: &Params,
    ) -> Result<Vec<CandidateContact>, CcdError> {
        self.contacts::<4>(candidates, params)
    }

    fn contacts<const N: usize>(
        &self,
        candidates: &[[u32; 4]],
        params: &Params,
    ) -> Result<Vec<CandidateContact>, CcdError>
    where
        MovingPolygon<N>: Corners<N>,
    {
        params.check()?;
        self.check_candidates(candidates)?;
        let mut found = Vec::new();
        for (candidate, points) in candidates.iter().enumerate() {
            let [x0, x1] = self.gather(points);
            if let Some(contact) = first_contact::<N>(&x0, &x1, params)? {
                found.push(CandidateContact { candidate, contact });
            }
        }
        Ok(found)
    }

    fn check_candidates(&self, candidates: &[[u32; 4]]) -> Result<(), CcdError> {
        let count = self.x0.len();
        let exists = |&point: &u32| (point as usize) < count;
        for (candidate, points) in candidates.iter().enumerate() {
            if let Some(&point) = points.iter().find(|point| !exists(point)) {
                return Err(CcdError::PointOutOfRange { candidate, point, count });
            }
        }
        Ok(())
    }

    #[inline]
    fn gather(&self, points: &[u32; 4]) -> [[DVec3; 4]; 2] {
        [self.x0, self.x1].map(|x| points.map(|point| x[point as usize]))
    }
}
