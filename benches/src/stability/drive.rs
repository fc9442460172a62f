//! Translations of bones over time.

use glam::DVec3;
use musculo_collide::RigidMotion;

/// Translation of a bone over time.
#[derive(Clone, Copy, Debug)]
pub enum Drive {
    /// It stays.
    Still,
    /// It moves by a way in a time, and stays there.
    To(DVec3, f64),
    /// It moves by a way and back in a time.
    ToAndBack(DVec3, f64),
}

impl Drive {
    /// Returns the way from the start.
    #[must_use]
    pub fn way(self, time: f64) -> DVec3 {
        match self {
            Self::Still => DVec3::ZERO,
            Self::To(way, end) => way * smooth(time / end),
            Self::ToAndBack(way, end) => way * smooth(2.0 * (0.5 - (time / end - 0.5).abs())),
        }
    }

    /// Returns the motion of a step: the velocity that leads to its end.
    #[must_use]
    pub fn motion(self, time: f64, step: f64) -> RigidMotion {
        let velocity = (self.way(time + step) - self.way(time)) / step;
        RigidMotion { velocity, ..RigidMotion::default() }
    }
}

/// Rises from 0 at 0 to 1 at 1 with rest at both.
#[must_use]
pub fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bones_move_as_fast_as_they_get_on() {
        for drive in [Drive::To(DVec3::X, 0.4), Drive::ToAndBack(DVec3::X, 0.4), Drive::Still] {
            let mut way = drive.way(0.0);
            for step in 0..500_u32 {
                way += 1e-3 * drive.motion(1e-3 * f64::from(step), 1e-3).velocity;
            }
            assert!((way - drive.way(0.5)).length() < 1e-12, "{drive:?}");
        }
    }
}
