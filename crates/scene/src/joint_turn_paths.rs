//! Range of motion of a joint: the first contact of a turn, after two turns before it.

use ccd::CcdParams;
use glam::{DAffine3, DQuat, DVec3};
use proximity::SweptContact;
use surface::progress::Progress;
use surface::{RigidBodyPath, RigidPath};

use crate::{BodyId, CheckParams, PairId, PathMove, Scene, SceneError};

/// Three turns about one center, each about an axis that those before it have turned: flexion,
/// adduction and rotation of a hip, in the order of its anatomical coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointTurns {
    /// Center of all turns.
    pub center: DVec3,
    /// Axes of the turns, as they are before any turn; turns are right-handed about them.
    pub axes: [DVec3; 3],
    /// Angle in radians up to which the last turn goes.
    pub to: f64,
}

/// Contact at which a turn ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnContact {
    /// The two bodies.
    pub pair: PairId,
    /// Angle in radians before which no pair meets.
    pub angle: f64,
    /// True if the pair certainly meets there, rather than comes within rounding of it.
    pub certain: bool,
    /// Place of the contact.
    pub at: DVec3,
}

/// End of a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum TurnEnd {
    /// A pair overlaps before the turn.
    Overlap(PairId),
    /// Bodies meet on the way.
    Contact(TurnContact),
    /// Nothing is met.
    Free,
}

/// Scene with bodies that turn about a joint, for many angles of its first two turns.
///
/// A clone has trees of its own, already built, so that several threads can share the angles.
#[derive(Clone, Debug)]
pub struct JointScene {
    scene: Scene,
    turning: Vec<(BodyId, Vec<DVec3>)>,
    turns: JointTurns,
}

impl JointTurns {
    /// Returns the rigid map of the first two turns, by angles in radians.
    #[must_use]
    pub fn map(&self, angles: [f64; 2]) -> DAffine3 {
        // The second turn is about an axis that the first one turns: it comes first.
        let [first, second] =
            [0, 1].map(|k| DQuat::from_axis_angle(self.axes[k].normalize_or(DVec3::X), angles[k]));
        let rotation = first * second;
        DAffine3::from_rotation_translation(rotation, self.center - rotation * self.center)
    }

    /// Returns the path of the last turn after the first two.
    #[must_use]
    pub fn path(&self, angles: [f64; 2]) -> RigidPath {
        self.path_to(angles, self.to)
    }

    /// Returns the path of the last turn up to an angle in radians.
    fn path_to(&self, angles: [f64; 2], to: f64) -> RigidPath {
        let axis = self.map(angles).transform_vector3(self.axes[2]);
        RigidPath::turn(self.center, axis, to)
    }
}

impl JointScene {
    /// Prepares a scene whose bodies `turning` follow the turns, while the others rest. Only pairs of
    /// a body that turns and one that rests are examined.
    ///
    /// # Errors
    ///
    /// [`SceneError::NoSuchBody`], and [`SceneError::Tree`] when a body is too large to build bounds
    /// for.
    pub fn new(
        mut scene: Scene,
        turning: &[BodyId],
        turns: JointTurns,
    ) -> Result<Self, SceneError> {
        let mut bodies = Vec::new();
        for &id in turning {
            bodies.push((id, scene.get(id)?.positions().to_vec()));
        }

        // Bodies of one side keep their distances.
        let ids: Vec<BodyId> = scene.ids().collect();
        for &a in &ids {
            for &b in &ids {
                if a < b && turning.contains(&a) == turning.contains(&b) {
                    scene.ignore(a, b);
                }
            }
        }
        scene.fit_all()?;
        Ok(Self { scene, turning: bodies, turns })
    }

    /// Returns the scene, with its bodies as they were turned last.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Finds the first contact of the last turn, after the first two by angles in radians.
    ///
    /// As [`Scene::first_contacts`]: no contact is missed, and no angle is beyond the true one.
    ///
    /// # Errors
    ///
    /// As [`Scene::first_contacts`].
    pub fn turn(&mut self, angles: [f64; 2]) -> Result<TurnEnd, SceneError> {
        // What overlaps before has no first contact.
        if let Some(pair) = self.first_overlap(angles, 0.0)? {
            return Ok(TurnEnd::Overlap(pair));
        }

        let mut starts = Vec::new();
        for (body, _) in &self.turning {
            starts.push(self.scene.body(*body).positions().to_vec());
        }
        let mut paths = Vec::new();
        for from in &starts {
            paths.push(RigidBodyPath { from, path: self.turns.path(angles) });
        }
        let mut moves = Vec::new();
        for ((body, _), path) in self.turning.iter().zip(&paths) {
            moves.push(PathMove { body: *body, path });
        }
        let swept = self.scene.first_contacts(&moves, &CcdParams::EXACT, Progress::none())?;

        // The earliest of all pairs; of equals the first in the order of the bodies.
        let mut end: Option<TurnContact> = None;
        for pair in &swept.pairs {
            let Some(first) = pair.contacts.first() else { continue };
            let angle = self.turns.to * first.contact.time.unwrap_or(1.0);
            if end.is_none_or(|end| angle.abs() < end.angle.abs()) {
                let at = self.scene.contact_place(pair.pair, first, &moves);
                end = Some(TurnContact { pair: pair.pair, angle, certain: first.certain, at });
            }
        }
        Ok(end.map_or(TurnEnd::Free, TurnEnd::Contact))
    }

    /// Returns true if a pair overlaps after all three turns, by exact static detection.
    ///
    /// # Errors
    ///
    /// As [`Scene::check`].
    pub fn overlaps(&mut self, angles: [f64; 2], last: f64) -> Result<bool, SceneError> {
        Ok(self.first_overlap(angles, last)?.is_some())
    }

    /// Turns bodies by all three angles; returns the first pair that overlaps there.
    fn first_overlap(&mut self, angles: [f64; 2], last: f64) -> Result<Option<PairId>, SceneError> {
        let map = self.turns.path_to(angles, last).map(1.0) * self.turns.map(angles);
        for (body, rest) in &self.turning {
            let x: Vec<DVec3> = rest.iter().map(|&x| map.transform_point3(x)).collect();
            self.scene.move_body(*body, &x)?;
        }

        for report in self.scene.check(&CheckParams::without_measures(0.0), Progress::none())? {
            if report.overlaps {
                return Ok(Some(report.pair));
            }
        }
        Ok(None)
    }
}

impl Scene {
    /// Returns the place of a swept contact: where its first primitive is at its earliest time while
    /// bodies follow paths from where they are.
    #[must_use]
    pub fn contact_place(
        &self,
        pair: PairId,
        contact: &SweptContact,
        moves: &[PathMove<'_>],
    ) -> DVec3 {
        let time = contact.contact.time.unwrap_or(1.0);
        let mut place = DVec3::ZERO;
        for term in contact.contact.stencil.terms() {
            // Weights of the first primitive are negative.
            if term.weight >= 0.0 {
                continue;
            }
            let of_second = self.body(pair.b).particles().contains(&term.particle);
            let id = if of_second { pair.b } else { pair.a };
            let vertex = term.particle - self.body(id).particles().start;
            let x = match moves.iter().find(|moving| moving.body == id) {
                Some(moving) => moving.path.position(vertex, time),
                None => self.body(id).positions()[vertex as usize],
            };
            place -= term.weight * x;
        }
        place
    }
}
