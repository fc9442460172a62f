//! Figures of each crate, held to their bounds.

mod ccd;
#[cfg(feature = "charts")]
mod deep_starts;
mod distance_field;
mod kdop;
#[cfg(feature = "peers")]
mod kdop_peers;
#[cfg(feature = "charts")]
mod libraries;
mod medial;
#[cfg(feature = "charts")]
mod motion;
#[cfg(feature = "charts")]
mod motion_scenes;
mod other_tree;
mod overlap;
mod plain_boxes;
#[cfg(feature = "charts")]
mod plan;
#[cfg(feature = "charts")]
pub(crate) mod resolve;
mod response;
#[cfg(feature = "charts")]
mod stability;

use std::error::Error;

use crate::measure::Report;
use crate::selected;

type Run = fn(&mut Report) -> Result<(), Box<dyn Error>>;

/// Crates with figures; overlap removal, contact in motion, and the stability of detection with response (feature
/// `charts`).
pub const GROUPS: &[(&str, Run)] = &[
    ("ccd", ccd::run),
    #[cfg(feature = "charts")]
    ("decimate", libraries::decimate),
    ("distance-field", distance_field::run),
    ("kdop", kdop::run),
    ("medial", medial::run),
    #[cfg(feature = "charts")]
    ("mesh-io", libraries::mesh_io),
    #[cfg(feature = "charts")]
    ("motion", motion::run),
    ("overlap", overlap::run),
    #[cfg(feature = "charts")]
    ("plan", plan::run),
    #[cfg(feature = "charts")]
    ("proximity", libraries::proximity),
    #[cfg(feature = "charts")]
    ("resolve", resolve::run),
    ("response", response::run),
    #[cfg(feature = "charts")]
    ("scene", libraries::scene),
    #[cfg(feature = "charts")]
    ("stability", stability::run),
    #[cfg(feature = "charts")]
    ("surface", libraries::surface),
    #[cfg(feature = "charts")]
    ("volume-mesh", libraries::volume_mesh),
];

/// Reports the figures of the named crates, or of all without a name.
///
/// # Errors
///
/// When no figures belong to a name, or a scene cannot be set up.
pub fn run(names: &[String], report: &mut Report) -> Result<(), Box<dyn Error>> {
    for (group, run) in selected(GROUPS, names)? {
        report.begin(group);
        run(report)?;
    }
    Ok(())
}
