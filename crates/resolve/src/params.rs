//! Parameters of overlap removal.

use std::ops::RangeInclusive;

use response::{ParameterError, not_negative, positive};
use scene::BodyId;
use surface::MAX_COORDINATE;

use crate::ResolveTuning;

/// Parameters of overlap removal. Lengths are in the scene's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ResolveParams {
    /// Largest depth of an overlap that may remain, `> 0`.
    pub tolerance: f64,
    /// Distance to be kept between the surfaces of every pair, faces and edges included, `>= 0`.
    /// With 0, surfaces that do not cross may touch.
    pub gap: f64,
    /// Length along a surface over which a displacement falls to a third, `> 0`. More keeps
    /// shape better; less moves fewer vertices. Where that leads to no end, pushes are longer in further starts.
    pub smoothing: f64,
    /// Largest number of rounds of detection and pushing, and as many of opening the gap and of settling. After a
    /// third of them without improvement the rest is given up.
    pub max_rounds: u32,
    /// Precision to which positions are rounded before distances are proved.
    pub precision: WrittenPrecision,
    /// Largest relative change of a soft body's volume, `> 0`. No state is accepted that changes one
    /// more, strains an edge more, turns a face over, makes a body cross itself anew, or moves a
    /// vertex too far.
    pub max_volume_change: f64,
    /// Largest strain of a soft body, `> 0`: the change of an edge's length over its length, or over
    /// the mean edge of the body where that is longer. Overlaps of a thigh at rest take less than a half,
    /// a body that is wholly inside another and comes out takes two.
    pub max_strain: f64,
    /// Largest displacement of a vertex \[the deepest overlap at the start\], `> 0`; that of the smoothing length
    /// is within limits in any case. Below, tissue that leaves sideways around a bone is not freed; above,
    /// tissue without room is squeezed out of its place.
    pub max_displacement: f64,
    /// True to keep a state that leaves these limits; they are then listed all the same.
    pub keep_going: bool,
    /// Tuning constants.
    pub tuning: ResolveTuning,
}

/// Precision of the positions in a file that is written afterwards.
///
/// Positions of soft bodies are rounded to it *before* limits are examined and distances proved, so
/// that both hold in the file. Rigid bodies are not changed: their distances are proved at rounded
/// positions. Without a gap nothing is rounded, and surfaces that touch may cross in the file. Nor is a body
/// that is to stay [unrounded](Conditions::unrounded).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "lowercase"))]
pub enum WrittenPrecision {
    /// 32-bit floating point: binary STL, PLY of type `float`.
    Single,
    /// 64-bit floating point: positions are left as they are.
    #[default]
    Double,
}

/// Conditions on a scene beside its gap. Pairs that are to be left out of everything are
/// [ignored](scene::Scene::ignore).
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Conditions {
    /// Pairs of bodies that are attached to each other.
    pub ties: Vec<Tie>,
    /// Vertices of soft bodies that stay where they are, but for [rounding](FixedVertices).
    pub fixed: Vec<FixedVertices>,
    /// Bodies that are stiffer or softer than others.
    pub stiffnesses: Vec<BodyStiffness>,
    /// Closed bodies whose parts are to come apart where they cross each other. Of all others,
    /// self-crossings may not become more.
    pub uncrossed: Vec<BodyId>,
    /// Bodies whose files hold positions as they are, also where those of others are
    /// [rounded](ResolveParams::precision).
    #[cfg_attr(feature = "serde", serde(default))]
    pub unrounded: Vec<BodyId>,
    /// Corners of cells that surfaces hold by themselves.
    #[cfg_attr(feature = "serde", serde(default))]
    pub cell_corners: Vec<CellCorners>,
}

/// Corners of a volume mesh's cells of which all four nodes are on its surface. A cell can follow the surface only while
/// none of them is flat, wherever the nodes inside are.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CellCorners {
    /// The body.
    pub body: BodyId,
    /// Vertices of each corner: its own, and those at the ends of its three edges.
    pub corners: Vec<[u32; 4]>,
    /// Share of its scaled Jacobian at the start that each corner keeps, in `0.0..1.0`.
    pub min_jacobian_share: f64,
}

/// Stiffness of one body: bodies share an overlap in inverse proportion to it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyStiffness {
    /// The body.
    pub body: BodyId,
    /// Factor on its elastic energy and on its mass, within [`Self::FACTORS`]; 1 without a record.
    pub factor: f64,
}

impl BodyStiffness {
    /// Range of factors. Of two bodies at its ends the softer one takes all of an overlap but
    /// 1e-18 of it, which is less than rounding; far beyond, products of factors would overflow.
    pub const FACTORS: RangeInclusive<f64> = 1e-9..=1e9;
}

/// Attachment of two bodies: parts of their surfaces that face each other within a distance at the start
/// keep their place relative to each other, and their pair needs no gap. Vertices of soft bodies that are at one
/// place, to the bit, move as one. What crosses is not tied: it comes out. Where surfaces that touch bend, and their meshes differ,
/// tied vertices move off what they come to cross.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Tie {
    /// The two bodies.
    pub bodies: [BodyId; 2],
    /// Largest distance of a vertex from the other surface at which it is tied, `>= 0`.
    pub distance: f64,
}

/// Vertices of a [tie](Tie).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TiedVertices {
    /// Body whose vertices are tied.
    pub follower: BodyId,
    /// Body that they keep their place to.
    pub leader: BodyId,
    /// Number of vertices that keep it.
    pub tied: usize,
    /// Number of vertices within the distance that do not: they are inside, or of faces that cross the other surface,
    /// and come out.
    pub crossing: usize,
    /// Number of vertices within the distance that are let go, since faces at them would turn over.
    pub loose: usize,
    /// Distance of the tie, in the state in which it was found.
    pub distance: f64,
    /// Largest distance of a vertex that keeps its place from it, in the end. Beyond that of the tie, where bodies have
    /// moved apart in a later state without any push: ties do not bring them back.
    pub max_distance: f64,
}

impl TiedVertices {
    /// Returns true if vertices are farther from their places than the distance of the tie and an allowance.
    #[must_use]
    pub fn is_torn(&self, allowance: f64) -> bool {
        self.tied > 0 && self.max_distance > self.distance + allowance
    }
}

/// Vertices of one body that stay where they are. With a gap and a [precision](ResolveParams::precision) of
/// 32 bits they are rounded to it as all vertices of soft bodies are, also where the body is not moved otherwise:
/// the gap is proved of what the file holds. Bodies that are [not rounded](Conditions::unrounded) keep theirs to
/// the bit, but for vertices at the place of a rounded one.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FixedVertices {
    /// The body.
    pub body: BodyId,
    /// Numbers of its vertices.
    pub vertices: Vec<u32>,
}

impl ResolveParams {
    /// Returns parameters for a smoothing length, of which the tolerance is 1/120, without a
    /// gap, 60 rounds, volumes within a hundredth, strains up to 3, and displacements up to three times the
    /// deepest overlap.
    ///
    /// A few edge lengths of the soft bodies are a good smoothing length.
    #[must_use]
    pub const fn with_smoothing(smoothing: f64) -> Self {
        Self {
            tolerance: tolerance_of(smoothing),
            gap: 0.0,
            smoothing,
            max_rounds: 60,
            precision: WrittenPrecision::Double,
            max_volume_change: 0.01,
            max_strain: 3.0,
            max_displacement: 3.0,
            keep_going: false,
            tuning: ResolveTuning::DEFAULT,
        }
    }

    /// Returns parameters for overlaps of a depth between soft bodies of a mean edge length: pushes fade over twice the
    /// depth, or over one and a half edges where that is more, of which the tolerance is 1/240. All else is as with
    /// [that smoothing length](Self::with_smoothing).
    #[must_use]
    pub const fn for_overlaps(deepest: f64, mean_edge: f64) -> Self {
        let smoothing = f64::max(SMOOTHING_IN_DEPTHS * deepest, SMOOTHING_IN_EDGES * mean_edge);
        let tolerance = tolerance_of(smoothing) / SMOOTHING_IN_DEPTHS;
        Self { tolerance, ..Self::with_smoothing(smoothing) }
    }

    /// Returns the largest displacement of a vertex per round.
    pub(crate) fn max_step(&self) -> f64 {
        self.tuning.max_step * self.smoothing
    }

    /// Returns the change of a body's volume above which rounds continue.
    pub(crate) fn volume_tolerance(&self) -> f64 {
        self.tuning.volume_tolerance * self.max_volume_change
    }

    /// Returns true if positions are rounded to single precision in the end.
    pub(crate) fn rounds_to_single(&self) -> bool {
        self.precision == WrittenPrecision::Single && self.gap > 0.0
    }

    /// Checks that all parameters are in their ranges.
    ///
    /// # Errors
    ///
    /// [`ParameterError`] for the first one that is not.
    pub fn validate(&self) -> Result<(), ParameterError> {
        positive("smoothing", self.smoothing)?;
        positive("tolerance", self.tolerance)?;
        not_negative("gap", self.gap)?;
        for (name, value) in [("smoothing", self.smoothing), ("gap", self.gap)] {
            if value > MAX_LENGTH {
                let range = "at most 1e27, a thousandth of the largest coordinate";
                return Err(ParameterError { name, value, range });
            }
        }
        positive("max_volume_change", self.max_volume_change)?;
        positive("max_strain", self.max_strain)?;
        positive("max_displacement", self.max_displacement)?;
        self.tuning.validate()
    }
}

/// Smoothing length \[deepest overlaps\]. At 1, finely meshed muscles that are packed wrinkle as they come apart; above,
/// more tissue moves that has no contact.
const SMOOTHING_IN_DEPTHS: f64 = 2.0;

/// Smoothing length in mean edges, at least: less leaves dents, more moves tissue that has no contact.
const SMOOTHING_IN_EDGES: f64 = 1.5;

/// Largest length by which bodies are pushed: a thousandth of the largest coordinate, beyond which pushes
/// could move vertices out of the range of numbers.
const MAX_LENGTH: f64 = 1e-3 * MAX_COORDINATE;

/// Returns the tolerance that goes with a smoothing length.
pub(crate) const fn tolerance_of(smoothing: f64) -> f64 {
    smoothing / 120.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detection::clearance;

    #[test]
    fn lengths_beyond_the_range_of_pushes_are_refused_by_name() {
        let asked = ResolveParams::with_smoothing(1.0);
        for (params, name) in [
            (ResolveParams { gap: 2e27, ..asked }, "gap"),
            (ResolveParams { smoothing: 2e27, ..asked }, "smoothing"),
        ] {
            assert_eq!(params.validate().expect_err(name).name, name);
        }
        assert_eq!(ResolveParams { gap: 1e27, ..asked }.validate(), Ok(()));
    }

    #[test]
    fn pushes_fade_over_twice_the_depth_or_over_edges() {
        for (deepest, edge, smoothing) in [(4.0, 2.0, 8.0), (1.0, 2.0, 3.0), (0.0, 2.0, 3.0)] {
            let params = ResolveParams::for_overlaps(deepest, edge);
            let tolerance = smoothing / 240.0;
            let expected = ResolveParams { tolerance, ..ResolveParams::with_smoothing(smoothing) };
            assert_eq!(params, expected);
        }
    }

    #[test]
    fn longer_pushes_end_farther_apart() {
        let asked =
            ResolveParams { tolerance: 0.01, gap: 0.05, ..ResolveParams::with_smoothing(6.0) };
        assert_eq!(clearance(&asked).to_bits(), 0.05_f64.to_bits());
        let longer = ResolveParams { smoothing: 24.0, ..asked };
        assert_eq!(clearance(&longer).to_bits(), 0.1_f64.to_bits());
        let coarse = ResolveParams { tolerance: 0.4, ..asked };
        assert_eq!(clearance(&coarse).to_bits(), 0.2_f64.to_bits());
    }
}
