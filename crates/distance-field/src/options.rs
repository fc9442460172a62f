//! How a field is built and stored.

/// Everything a build may be told; lengths in the caller's unit.
///
/// [`BuildOptions::default`] is meant for bones in millimetres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BuildOptions {
    /// Distance between nodes, `> 0`. Halving it takes 8 times the memory; in the
    /// band, which then is half as wide, two fifths of the error are left.
    pub spacing: f64,
    /// Room around the surface's box, `>= 0`: how far outside a point is still
    /// answered.
    pub padding: f64,
    /// How distances are found.
    pub method: Method,
    /// How inside is told from outside.
    pub sign: SignRule,
    /// Distances beyond this are stored as this; none keeps all of them, which
    /// takes half as long again.
    pub truncate: Option<f64>,
    /// What the nodes are kept as.
    pub storage: Storage,
    /// Bytes that the build may hold at once; checked before allocating.
    pub max_bytes: u64,
    /// Points near the surface at which the field is compared with exact
    /// distances; 0 measures nothing.
    pub samples: usize,
}

/// How distances are found.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Method {
    /// Faces switch voxels on, and a Euclidean transform measures the distance
    /// to the nearest of these: quick, but half a spacing wrong and 20° off in
    /// direction, whatever the spacing.
    Seed {
        /// Which voxels a face switches on.
        conversion: Conversion,
        /// How distances spread from them.
        transform: Transform,
    },
    /// Exact distances in a band around the surface, and beyond it exact
    /// distances to the face that the nearest band node is closest to.
    ExactBand {
        /// Half width in spacings, `>= 1.75`, so that all corners of a cell
        /// that the surface crosses are exact.
        band: f64,
        /// Whether each node beyond the band then also tries the faces of its
        /// six neighbours. A band under 3 needs it: without it, a distance just
        /// outside can be wrong by most of a spacing near a sharp rim.
        relax: bool,
        /// What the values at the nodes of the band are right for.
        nodes: NodeValues,
    },
}

/// Which voxels a face switches on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Conversion {
    /// Bresenham lines along the edges and one voxel a column inside: thin,
    /// and with coarse faces not closed against a 6-neighbour flood.
    Bresenham,
    /// The thinnest conversion that a 6-neighbour path cannot cross.
    SixSeparating,
    /// Every voxel the face touches.
    Conservative,
}

/// How distances spread from seed voxels; both are exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Transform {
    /// Saito and Toriwaki 1994: scans bounded by neighbours' distances.
    Saito,
    /// Meijster et al. 2000: lower envelopes, linear whatever the distances.
    Meijster,
}

/// How inside is told from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SignRule {
    /// What the border of the grid cannot reach is inside. Needs a closed surface.
    Flood,
    /// An odd number of crossings along x is inside. Needs a closed surface.
    Parity,
    /// A generalized winding number above one half is inside: right for any
    /// closed surface, and the sensible answer for open, overlapping and partly
    /// flipped ones.
    Winding,
}

/// What the values at nodes are right for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum NodeValues {
    /// The nodes themselves: a value there is the distance. Between them, linear
    /// interpolation of what is convex is too high on average.
    #[default]
    Interpolating,
    /// All that lies between them: each node gives way by a twelfth of its second
    /// differences, by an eighth of a spacing at most and never to the other side,
    /// so that what is interpolated linearly is right on average.
    ///
    /// Over smooth bones three fifths of the error, over others two thirds. The
    /// cubic knows of it and is as right as over interpolating nodes.
    QuasiInterpolating,
}

/// What the nodes are kept as.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Storage {
    /// 32-bit floats: 4 bytes a node.
    Dense,
    /// 16-bit multiples of `step`: 2 bytes a node, wrong by at most half a step.
    Steps {
        /// Length of one step, `> 0`; reaches 32767 steps.
        step: f64,
    },
    /// 16-bit steps in bricks of 8³ cells, of which only those near the surface
    /// are kept. Needs a truncation to leave any out.
    Bricks {
        /// Length of one step, `> 0`; reaches 32767 steps.
        step: f64,
    },
}

impl Method {
    /// The source's pipeline as it stands.
    pub const SEED: Self =
        Self::Seed { conversion: Conversion::Bresenham, transform: Transform::Saito };
    /// Band of three spacings, its nodes those of a quasi-interpolation.
    pub const EXACT_BAND: Self =
        Self::ExactBand { band: 3.0, relax: false, nodes: NodeValues::QuasiInterpolating };

    /// What the values at nodes are right for.
    pub(crate) fn nodes(self) -> NodeValues {
        match self {
            Self::Seed { .. } => NodeValues::Interpolating,
            Self::ExactBand { nodes, .. } => nodes,
        }
    }
}

impl BuildOptions {
    /// The source's pipeline: seed method, signed by flood, nothing truncated.
    #[must_use]
    pub fn seed() -> Self {
        Self { method: Method::SEED, sign: SignRule::Flood, truncate: None, ..Self::default() }
    }
}

impl Default for BuildOptions {
    /// 1 mm spacing, 10 mm padding, exact band, winding number, truncated at
    /// 15 mm, dense, up to 4 GiB.
    fn default() -> Self {
        Self {
            spacing: 1.0,
            padding: 10.0,
            method: Method::EXACT_BAND,
            sign: SignRule::Winding,
            truncate: Some(15.0),
            storage: Storage::Dense,
            max_bytes: 4 << 30,
            samples: 512,
        }
    }
}
