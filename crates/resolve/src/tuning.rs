//! Tuning constants of overlap removal.

use response::{ParameterError, not_negative, positive};

/// Tuning constants of overlap removal.
///
/// All were found by trial, on planted overlaps, on a thigh at rest and on frames of a walk. None is a
/// length: \[ℓ\] is the [smoothing length](crate::ResolveParams::smoothing). Numbers of sweeps and
/// numerical tolerances are beside the one place that uses them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ResolveTuning {
    /// Largest displacement of a vertex per round \[ℓ\], `> 0`. Below, more rounds are needed; above,
    /// vertices pass by the contacts that were detected at the start of the round.
    pub max_step: f64,
    /// Margin of contact detection, beside two clearances \[steps\], `>= 0`. Contacts within it hold
    /// tissue while its shape is restored. Below, restored tissue enters bodies that were not detected;
    /// above, detection takes longer.
    pub detection_margin: f64,
    /// Distance from pushed vertices over which tissue follows them \[ℓ, and the push\], and longest strut
    /// through tissue, `> 0`. Below, displacements end steeply, and sheets are squeezed; above, more tissue
    /// moves.
    pub spread_radius: f64,
    /// Strain by which the limit on that of a round is wider than in the round before, up to
    /// the [maximum](crate::ResolveParams::max_strain) \[the maximum\], `> 0`. Below, narrow places take
    /// more rounds; above, tissue is dragged into folds, which take as many.
    pub strain_growth: f64,
    /// Depth up to which contacts are trusted \[ℓ\], `> 0`: those of crossing edges are used in shallower
    /// pairs, and the exit direction of a vertex as deep counts a third. Bones are a few times as thick where
    /// tissue is deepest in them. Below, few are left to trust; above, vertices beyond the middle of a bone
    /// leave by its far side, and edges push in directions that mean little.
    pub shallow_depth: f64,
    /// Cosine above which two directions are on one side, and a face is not about to turn over. At 0,
    /// rounding turns a face that stands on its edge, and the normals of coarse meshes are off by some ten
    /// degrees; far above, fewer vertices are turned, and deep overlaps need more rounds.
    pub min_cosine: f64,
    /// Share of a patch's area from which the nearest ways out lead through the far side, above which the
    /// patch leaves in one direction. Below, muscles that embrace a bone do; above, tips in thin bones do
    /// not.
    pub far_share: f64,
    /// Stiffness of a row's augmented term, relative to what it moves, `> 0`. Below, multipliers take more
    /// sweeps to grow; far above, rows that share vertices block each other.
    pub penalty: f64,
    /// Accuracy of conditions, `> 0`: addition to the gap that is solved for \[the gap\], and give of ties
    /// relative to the tissue beside them. Below, solutions are needed to more digits; above, tissue moves more.
    pub slack: f64,
    /// Change of a body's volume above which rounds continue, and give it back \[the largest one that is
    /// within limits\], `> 0`. Below, rounds are spent on nothing that is measured; near 1, volumes end next
    /// to their limits.
    pub volume_tolerance: f64,
    /// Weight of a crossing, shared or spoilt face in the score by which rounds are compared \[tolerances of
    /// depth\], `>= 0`. Below, states of many crossings are kept; above, tissue without room stays as deep as it
    /// was.
    pub face_weight: f64,
    /// Share of the way from the longest displacement to the longest way out that is taken off per step
    /// of settling, `> 0`. Below, steps are many; above, surfaces block them: the way back is along them, round
    /// their bends.
    pub settled_share: f64,
}

impl ResolveTuning {
    /// The constants that figures are measured with.
    pub const DEFAULT: Self = Self {
        max_step: 0.25,
        detection_margin: 0.6,
        spread_radius: 2.0,
        strain_growth: 0.1,
        shallow_depth: 0.05,
        min_cosine: 0.2,
        far_share: 0.1,
        penalty: 0.5,
        slack: 0.02,
        volume_tolerance: 0.1,
        face_weight: 0.02,
        settled_share: 0.125,
    };

    /// Checks that all constants are in their ranges.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] for the first one that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        positive("max_step", self.max_step)?;
        not_negative("detection_margin", self.detection_margin)?;
        positive("spread_radius", self.spread_radius)?;
        positive("strain_growth", self.strain_growth)?;
        positive("shallow_depth", self.shallow_depth)?;
        not_negative("min_cosine", self.min_cosine)?;
        not_negative("far_share", self.far_share)?;
        positive("penalty", self.penalty)?;
        positive("slack", self.slack)?;
        positive("volume_tolerance", self.volume_tolerance)?;
        not_negative("face_weight", self.face_weight)?;
        positive("settled_share", self.settled_share)?;
        Ok(())
    }
}

impl Default for ResolveTuning {
    fn default() -> Self {
        Self::DEFAULT
    }
}
