//! Tuning constants of overlap removal.
//!
//! All were found by trial, on planted overlaps, on a thigh at rest and on frames of a walk. None is a length:
//! \[ℓ\] is the [smoothing length](crate::ResolveParams::smoothing), a step is
//! [`MAX_STEP`], and the tolerance is [that of the parameters](crate::ResolveParams::tolerance). Numbers
//! of sweeps and numerical tolerances are beside the one place that uses them.

// Rounds.

/// Largest displacement of a vertex per round \[ℓ\]. Below, more rounds are needed; above,
/// vertices pass by the contacts that were detected at the start of the round.
pub(crate) const MAX_STEP: f64 = 0.25;

/// Stiffness of a row's augmented term in rounds that push, as [`GAP_PENALTY`]. Above 1, rows overshoot and
/// open again from sweep to sweep.
pub(crate) const PUSH_PENALTY: f64 = 0.5;

/// Part of the clearance that may be missing from a solution. Below, solutions take longer; above,
/// overlaps remain.
pub(crate) const SOLVED_SHARE: f64 = 0.1;

/// Margin of contact detection \[steps\]. Contacts within it hold tissue while its shape is
/// restored. Below, restored tissue enters bodies that were not detected; above, detection
/// takes longer.
pub(crate) const DETECTION_MARGIN: f64 = 0.6;

/// Addition to the margin \[clearances\]. Below 1, bodies that are nearer than the
/// clearance are not pushed apart; above, detection takes longer.
pub(crate) const CLEARANCE_MARGIN: f64 = 4.0;

/// Least gap to which overlaps are pushed apart \[ℓ\]. Below, edges of curved surfaces cross where
/// vertices are apart; above, tissue moves more.
pub(crate) const CLEARANCE: f64 = 1.0 / 300.0;

/// Rounds without improvement after which the rest is given up. Below, bodies that first
/// have to slide are given up too early; above, hopeless scenes take longer.
pub(crate) const MAX_STALLED_ROUNDS: u32 = 20;

/// Weight of a crossing, shared or spoilt face in the score by which rounds are compared \[tolerances of
/// depth\]. Below, states of many crossings are kept; above, tissue without room stays as deep as it was.
pub(crate) const CROSSING_SCORE: f64 = 0.02;

// Spreading.

/// Distance from pushed vertices over which tissue follows them \[ℓ, and the push\]: deeper pushes spread
/// farther. Below, displacements end steeply, and tissue strains more; above, more tissue moves.
pub(crate) const SPREAD_RADIUS: f64 = 2.0;

/// Longest strut through tissue \[ℓ\]. Below, sheets are squeezed and lose volume; above, rays
/// find sides to which no push gets.
pub(crate) const MAX_STRUT_LENGTH: f64 = 3.0;

// Limits on strain.

/// Largest difference between the displacements of the two ends of an edge \[its length\].
/// Above 1, the edge may turn round; far below, deep overlaps drag more tissue along.
pub(crate) const MAX_STRETCH: f64 = 0.8;

/// Smallest thickness of a sheet \[its thickness at rest\]. At 0, its sides meet; far above,
/// sheets between bones cannot yield.
pub(crate) const MIN_THICKNESS: f64 = 0.35;

/// Rounds with these limits unchanged. Below, tissue is dragged into folds; above, tissue
/// that slides through a narrow place needs more rounds.
pub(crate) const FIRM_ROUNDS: usize = 3;

/// Growth of the limits' factor per later round. Below, narrow places take more rounds;
/// above, tissue is dragged into folds, which take as many.
pub(crate) const LOOSENING: f64 = 0.3;

/// Largest factor on the limits. Below, narrow places are given up; above, folds remain.
pub(crate) const MAX_LOOSENESS: f64 = 3.0;

// Exit sides.

/// Depth of vertices up to which contacts of crossing edges are used \[ℓ\]. Below, edges wait
/// for long; above, edges of deep overlaps push in directions that mean little.
pub(crate) const MAX_DEPTH_WITH_EDGES: f64 = 0.05;

/// Depth at which a vertex's own exit direction counts a third \[ℓ\]. Bones are as thin as this
/// where tissue is deepest in them: above, vertices beyond the middle are trusted and leave
/// by the far side; below, few vertices are left to trust.
pub(crate) const TRUSTED_DEPTH: f64 = 0.15;

/// Cosine above which two directions are on one side, and a face is not about to turn over. At 0,
/// rounding turns a face that stands on its edge, and the normals of coarse meshes are off by some ten
/// degrees; far above, fewer vertices are turned, and deep overlaps need more rounds.
pub(crate) const MIN_COSINE: f64 = 0.2;

/// Share of a patch's area from which the nearest ways out lead through the far side, above which the
/// patch leaves in one direction. Below, muscles that embrace a bone do; above, tips in thin bones do
/// not.
pub(crate) const FAR_SHARE: f64 = 0.1;

// Volume.

/// Change of a body's volume above which rounds continue, and give it back \[its volume\]. Below, rounds are
/// spent on nothing that is measured; above, the change that is promised is exceeded.
pub(crate) const MAX_VOLUME_CHANGE: f64 = 0.001;

/// Largest displacement per round that gives volume back \[displacement so far\]. Below, more
/// rounds are needed; above, it overshoots where little of a body is free.
pub(crate) const MAX_VOLUME_STEP: f64 = 0.5;

// Gap.

/// Addition to the gap that is solved for \[the gap\]. Below, solutions are needed to more digits;
/// above, tissue moves more.
pub(crate) const GAP_SLACK: f64 = 0.02;

/// Stiffness of a row's augmented term, relative to what it moves, in rounds that open the gap, whose
/// rows share many vertices. Below, multipliers take more sweeps to grow; above, rows block each
/// other, and the last openings take many rounds.
pub(crate) const GAP_PENALTY: f64 = 0.25;
