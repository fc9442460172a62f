//! Detectors of the runner: one method for all pairs that it suits.

use decimate::{CoarseSurface, Decimation};
use distance_field::{DistanceField, FieldParams};
use medial::{MedialDetector, MedialParams};
use musculo_collide::scene::{DetectorParams, PermanentParams, StepDetectors, StepMethod};
use musculo_collide::{BodyId, FieldDetector, PairId, Progress};
use proximity::SurfaceTree;
use response::Restraint;

use super::scenes::World;

/// Accepted error of a depth, and largest overlap that may be left \[mm\].
pub const TOLERANCE: f64 = 0.2;

/// Largest deviation of coarse surfaces \[mm\].
const COARSE_DEVIATION: f64 = 0.1;

/// Balls of a bone and of a soft body, and their margin beyond that of the contacts \[mm\].
const BONE_BALLS: usize = 100;
const SOFT_BALLS: usize = 30;
const BALL_MARGIN: f64 = 1.0;

/// Gap beyond the margin up to which contacts are kept \[mm\].
const SKIN: f64 = 0.5;

/// Method of detection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detector {
    /// Surfaces as they are.
    Exact,
    /// Coarser surfaces of the soft bodies.
    Coarse,
    /// Distance fields of bones; surfaces as they are between soft bodies.
    Field,
    /// Balls that select vertices, which surfaces measure.
    Balls,
    /// Contacts by surfaces that are kept from step to step, and slide.
    Permanent,
}

impl Detector {
    /// All detectors.
    pub const ALL: [Self; 5] =
        [Self::Exact, Self::Coarse, Self::Field, Self::Balls, Self::Permanent];

    /// Returns the name in tables and pictures.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Coarse => "coarse",
            Self::Field => "field",
            Self::Balls => "balls",
            Self::Permanent => "permanent",
        }
    }

    /// Prepares the detection of a scene by this method.
    ///
    /// # Errors
    ///
    /// The reason why a structure cannot be built, as text.
    pub fn prepare(self, world: &World) -> Result<StepDetectors, String> {
        let params = DetectorParams { margin: world.margin, tolerance: TOLERANCE };
        let mut detectors = StepDetectors::new(params).map_err(text)?;
        let ids: Vec<BodyId> = world.scene.ids().collect();
        let (bones, soft) = ids.split_at(world.bones.len());

        // What each method needs beside the surfaces.
        match self {
            Self::Exact | Self::Permanent => {}
            Self::Coarse => {
                detectors.set_default_method(StepMethod::Coarse);
                for &id in soft {
                    detectors.set_coarse(id, coarse(world, id)?);
                }
            }
            Self::Field => {
                for &bone in bones {
                    detectors.set_field(bone, field(world, bone)?);
                    for &id in soft {
                        detectors.set_method(PairId::new(bone, id), StepMethod::Field);
                    }
                }
            }
            Self::Balls => {
                detectors.set_default_method(StepMethod::Balls);
                for &id in &ids {
                    detectors.set_balls(id, balls(world, id)?);
                }
            }
        }

        self.restart(&mut detectors, world)?;
        Ok(detectors)
    }

    /// Forgets the contacts that are kept, for another run.
    ///
    /// # Errors
    ///
    /// Never for the skin that is set here.
    pub fn restart(self, detectors: &mut StepDetectors, world: &World) -> Result<(), String> {
        if self == Self::Permanent {
            let params =
                PermanentParams { restraint: Restraint::Sliding, skin: SKIN, attach_within: 0.0 };
            let ids: Vec<BodyId> = world.scene.ids().collect();
            for (number, &b) in ids.iter().enumerate().skip(world.bones.len()) {
                for &a in &ids[..number] {
                    detectors.set_permanent(PairId::new(a, b), params).map_err(text)?;
                }
            }
        }
        Ok(())
    }
}

fn coarse(world: &World, id: BodyId) -> Result<CoarseSurface, String> {
    let body = world.scene.body(id);
    let tree = SurfaceTree::new(body.surface().clone(), body.positions().to_vec());
    let decimation = Decimation::new(tree.map_err(text)?, Progress::none()).map_err(text)?;
    let reduced = decimation.within(COARSE_DEVIATION, Progress::none()).map_err(text)?;
    CoarseSurface::new(reduced, decimation.full()).map_err(text)
}

fn field(world: &World, id: BodyId) -> Result<FieldDetector, String> {
    let body = world.scene.body(id);
    let params = FieldParams::new(world.field_spacing);
    let (surface, x) = (body.surface(), body.checked_positions());
    let field = DistanceField::build(surface, x, &params, Progress::none()).map_err(text)?;
    FieldDetector::new(field, world.margin).map_err(text)
}

fn balls(world: &World, id: BodyId) -> Result<MedialDetector, String> {
    let body = world.scene.body(id);
    let (surface, x) = (body.surface(), body.checked_positions());
    let count = if body.is_rigid() { BONE_BALLS } else { SOFT_BALLS };
    let (margin, params) = (world.margin + BALL_MARGIN, MedialParams::balls(count));
    MedialDetector::new(surface, x, margin, &params, Progress::none()).map_err(text)
}

/// Returns the text of an error.
fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}
