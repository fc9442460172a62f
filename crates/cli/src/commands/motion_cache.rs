//! Cache of the frames of a motion.
//!
//! A frame is kept as static and swept detection report it, in JSON with all digits. Everything that
//! a run writes is made of that, of the scene and of the motion.

use std::path::{Path, PathBuf};

use musculo_collide::{PairReport, Scene};
use serde::{Deserialize, Serialize};

use super::run_cache::{CacheKind, KeptParts, PartKeeper, content_hash};
use crate::failure::Failure;
use crate::report::StepRecord;

/// Frame of a motion, and the step that leads to it.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct KeptFrame {
    /// Number of the frame, from 0.
    frame: usize,
    /// Step from the frame before; none to the first frame.
    pub(super) step: Option<StepRecord>,
    /// Pairs that overlap or touch.
    pub(super) reports: Vec<PairReport>,
}

/// Frames of earlier runs in their order, and the file that keeps more of them.
#[derive(Debug)]
pub(super) enum FrameCache {
    /// Frames are left to take.
    Taking(KeptParts),
    Keeping(PartKeeper),
    /// Nothing is kept.
    None,
}

impl FrameCache {
    /// Opens a cache of a motion, by the files that it is made of and its arguments.
    pub(super) fn open(path: &Path, files: &[PathBuf], arguments: &str) -> Result<Self, Failure> {
        let kind = CacheKind { run: "motion", parts: "frames" };
        let inputs = content_hash(files, arguments)?;
        KeptParts::open(path, kind, inputs).map(Self::Taking)
    }

    /// Returns the next frame, if an earlier run has kept it. Frames are taken from 0 on.
    pub(super) fn take(
        &mut self,
        frame: usize,
        scene: &Scene,
    ) -> Result<Option<KeptFrame>, Failure> {
        let Self::Taking(kept) = self else { return Ok(None) };
        let Some(line) = kept.next_line()? else {
            // All frames from here on are computed.
            if let Self::Taking(kept) = std::mem::replace(self, Self::None) {
                *self = Self::Keeping(kept.keep_more()?);
            }
            return Ok(None);
        };

        let taken = serde_json::from_str::<KeptFrame>(&line).ok();
        let taken = taken.filter(|taken| taken.frame == frame && taken.fits(scene));
        taken.map(Some).ok_or_else(|| kept.damaged())
    }

    /// Keeps a frame.
    pub(super) fn keep(&self, frame: &KeptFrame) -> Result<(), Failure> {
        let Self::Keeping(keeper) = self else { return Ok(()) };
        let line = serde_json::to_string(frame);
        keeper.keep(&line.map_err(|error| Failure::new(error.to_string()))?)
    }
}

impl KeptFrame {
    pub(super) fn new(frame: usize, step: Option<StepRecord>, reports: Vec<PairReport>) -> Self {
        Self { frame, step, reports }
    }

    /// Returns true if all bodies and vertices are those of a scene.
    fn fits(&self, scene: &Scene) -> bool {
        let bodies = scene.bodies();
        for report in &self.reports {
            let sides =
                [(report.pair.a, &report.a_against_b), (report.pair.b, &report.b_against_a)];
            for (id, side) in sides {
                let Some(body) = bodies.get(id.index()) else { return false };
                let count = body.surface().vertex_count();
                if side.near.iter().any(|near| near.vertex as usize >= count) {
                    return false;
                }
            }
        }
        true
    }
}
