//! Arguments of overlap removal, shared by the commands that do it.

use clap::Args;
use musculo_collide::{CheckParams, ResolveParams};

use crate::failure::Failure;
use crate::load::LoadedScene;
use crate::phase::Phase;

/// Parameters of overlap removal, with lengths in the scene's unit.
#[derive(Debug, Args)]
pub(super) struct ResolveArgs {
    /// Distance that all surfaces keep, faces and edges included, in the scene's unit [default: none,
    /// surfaces may touch]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    gap: Option<f64>,

    /// Length along a surface over which a push fades, in the scene's unit [default: the depth of
    /// the deepest vertex, and at least 3/2 of the mean edge of the soft bodies]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    smooth: Option<f64>,

    /// Largest depth of a surface in another body that may remain, in the scene's unit [default: smoothing / 120]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    tolerance: Option<f64>,

    /// Largest relative change of a soft body's volume; no face may turn over, and no body cross
    /// itself anew
    #[arg(long, value_name = "SHARE", default_value_t = 0.01, allow_negative_numbers = true)]
    max_volume_change: f64,

    /// Largest strain of a soft body: change of an edge's length over its length, or over the body's
    /// mean edge where that is longer
    #[arg(long, value_name = "SHARE", default_value_t = 3.0, allow_negative_numbers = true)]
    max_strain: f64,

    /// Largest displacement of a vertex, in depths of the deepest overlap; that of the smoothing length is
    /// allowed in any case
    #[arg(long, value_name = "DEPTHS", default_value_t = 3.0, allow_negative_numbers = true)]
    max_displacement: f64,

    /// Maximum number of rounds of detection and pushing
    #[arg(long, value_name = "N", default_value_t = 60)]
    rounds: u32,
}

/// Smoothing length in mean edges of the soft bodies, at least: less leaves dents, more moves
/// tissue that has no contact.
const SMOOTHING_IN_EDGES: f64 = 1.5;

impl ResolveArgs {
    /// Returns the parameters, with defaults by the overlaps and the edges of the soft bodies.
    pub(super) fn params(&self, loaded: &mut LoadedScene) -> Result<ResolveParams, Failure> {
        // A push that fades over less than it is deep turns faces over.
        let smoothing = match self.smooth {
            Some(smoothing) => smoothing,
            None => deepest_vertex(loaded)?.max(SMOOTHING_IN_EDGES * loaded.soft_edge()),
        };

        // Other lengths follow the smoothing, unless they are given.
        let default = ResolveParams::with_smoothing(smoothing);
        Ok(ResolveParams {
            tolerance: self.tolerance.unwrap_or(default.tolerance),
            gap: self.gap.unwrap_or(0.0),
            max_rounds: self.rounds,
            max_volume_change: self.max_volume_change,
            max_strain: self.max_strain,
            max_displacement: self.max_displacement,
            ..default
        })
    }
}

/// Returns the depth of the deepest vertex of the scene.
fn deepest_vertex(loaded: &mut LoadedScene) -> Result<f64, Failure> {
    let params = CheckParams::without_measures(0.0);
    let reports = Phase::run("finding overlaps", |progress| loaded.scene.check(&params, progress))?;
    Ok(reports.iter().map(|report| report.max_vertex_depth).fold(0.0, f64::max))
}
