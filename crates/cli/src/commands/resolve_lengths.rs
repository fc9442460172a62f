//! Lengths of overlap removal, as options of the commands that do it.

use clap::Args;
use musculo_collide::ResolveParams;

use crate::scene::Unit;

/// Smoothing length where none is given \[mm\]: a few edges of a muscle's mesh.
const SMOOTHING_MM: f64 = 6.0;

/// Lengths are in the scene's unit.
#[derive(Debug, Args)]
pub(super) struct ResolveLengths {
    /// Clearance between pushed bodies, in the scene's unit [default: 0.02 mm]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    clearance: Option<f64>,

    /// Distance along a surface over which a push spreads, in the scene's unit [default: 6 mm]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    smooth: Option<f64>,

    /// Depth by which bodies may still overlap at the end, in the scene's unit [default: 0.05 mm]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    tolerance: Option<f64>,

    /// Rounds of detection and pushing at most
    #[arg(long, value_name = "N", default_value_t = ResolveParams::with_smoothing(SMOOTHING_MM).max_rounds)]
    rounds: u32,
}

impl ResolveLengths {
    /// With what was not given as it is for millimetres.
    pub(super) fn params(&self, unit: Unit) -> ResolveParams {
        let ResolveParams { tolerance, clearance, smoothing, .. } =
            ResolveParams::with_smoothing(SMOOTHING_MM);
        let or = |given: Option<f64>, mm: f64| given.unwrap_or_else(|| unit.of_millimetres(mm));
        ResolveParams {
            tolerance: or(self.tolerance, tolerance),
            clearance: or(self.clearance, clearance),
            smoothing: or(self.smooth, smoothing),
            max_rounds: self.rounds,
        }
    }
}
