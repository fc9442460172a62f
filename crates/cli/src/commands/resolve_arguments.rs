//! Arguments of overlap removal, shared by the commands that do it.

use clap::Args;
use musculo_collide::{CheckParams, PairReport, ResolveParams};

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

    /// Length along a surface over which a push fades, in the scene's unit [default: twice the depth of
    /// the deepest vertex of bodies that cross, and at least 3/2 of the mean edge of the soft bodies]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    smooth: Option<f64>,

    /// Largest depth of a surface in another body that may remain, in the scene's unit [default: smoothing / 120, and 1/240
    /// without --smooth]
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
    /// allowed in any case, and in a motion that of the frame before with this much of what overlaps by it
    #[arg(long, value_name = "DEPTHS", default_value_t = 3.0, allow_negative_numbers = true)]
    max_displacement: f64,

    /// Maximum number of rounds of detection and pushing
    #[arg(long, value_name = "N", default_value_t = 60)]
    rounds: u32,
}

impl ResolveArgs {
    /// Returns the parameters, with defaults by the overlaps and the edges of the soft bodies.
    pub(super) fn params(&self, loaded: &mut LoadedScene) -> Result<ResolveParams, Failure> {
        // A push that fades over less than it is deep turns faces over. Other lengths follow the smoothing.
        let default = match self.smooth {
            Some(smoothing) => ResolveParams::with_smoothing(smoothing),
            None => ResolveParams::for_overlaps(deepest_vertex(loaded)?, loaded.soft_edge()),
        };
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

/// Returns the depth of the deepest vertex of bodies that cross; of bodies in others, where none do.
fn deepest_vertex(loaded: &mut LoadedScene) -> Result<f64, Failure> {
    let params = CheckParams::without_measures(0.0);
    let reports = Phase::run("finding overlaps", |progress| loaded.scene.check(&params, progress))?;
    Ok(depth_to_push(&reports))
}

/// Returns the depth of the deepest vertex by which pushes are measured. The depth of a body that is wholly inside
/// another, as in a skin, is not how far others are to come.
fn depth_to_push(reports: &[PairReport]) -> f64 {
    let (mut crossing, mut enclosed) = (None, 0.0_f64);
    for report in reports {
        if report.crossing_faces.is_empty() {
            enclosed = enclosed.max(report.max_vertex_depth);
        } else {
            crossing = Some(report.max_vertex_depth.max(crossing.unwrap_or(0.0)));
        }
    }
    crossing.unwrap_or(enclosed)
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use musculo_collide::glam::DVec3;
    use musculo_collide::{BodyKind, Progress, Scene};

    use super::*;

    #[test]
    fn bodies_in_a_skin_are_pushed_by_the_depth_in_each_other() {
        let ball =
            |radius: f64, x: f64| shapes::icosphere(radius, 3).translated(DVec3::new(x, 0.1, 0.2));
        let bodies =
            [("bone", ball(10.0, 0.0)), ("muscle", ball(10.0, 19.0)), ("skin", ball(60.0, 0.0))];
        let mut scene = Scene::new();
        let mut depths = Vec::new();
        for (name, mesh) in bodies {
            scene.add(name, BodyKind::Deformable, mesh.surface(), mesh.positions).expect("a body");
            let reports = scene.check(&CheckParams::without_measures(0.0), Progress::none());
            depths.push(depth_to_push(&reports.expect("reports")));
        }
        assert!(depths[0] == 0.0 && (0.5..1.1).contains(&depths[1]), "{depths:?}");
        assert_eq!(depths[2].to_bits(), depths[1].to_bits(), "{depths:?}");
    }

    #[test]
    fn a_body_in_another_alone_is_pushed_by_its_depth() {
        let mut scene = Scene::new();
        for (name, radius) in [("inner", 5.0), ("outer", 20.0)] {
            let mesh = shapes::icosphere(radius, 3);
            scene.add(name, BodyKind::Deformable, mesh.surface(), mesh.positions).expect("a body");
        }
        let reports = scene.check(&CheckParams::without_measures(0.0), Progress::none());
        let depth = depth_to_push(&reports.expect("reports"));
        assert!((14.0..20.0).contains(&depth), "{depth}");
    }
}
