//! Overlap removal of one state, or of one state after another.

use scene::Scene;
use surface::progress::Progress;

use crate::attempts::{Attempts, Start};
use crate::conditions::TieBonds;
use crate::local_displacements::{LocalDisplacements, fits};
use crate::{Conditions, Resolution, ResolveError, ResolveParams};

/// Pushes apart the bodies of a scene that overlap.
///
/// Rigid bodies do not move. Soft ones yield, and share their overlaps with each other by
/// mass. Vertices far from all pushes keep their positions to the bit.
///
/// # Errors
///
/// As [`Resolver::new`] and [`Resolver::resolve`].
pub fn resolve(
    scene: &mut Scene,
    params: &ResolveParams,
    progress: Progress<'_>,
) -> Result<Resolution, ResolveError> {
    Resolver::new(*params)?.resolve(scene, progress)
}

/// Overlap removal for the states of a moving scene, with warm starting: each state starts
/// from the displacements of the last one, where that is better.
///
/// ```
/// use resolve::glam::DVec3;
/// use resolve::{ResolveParams, Resolver};
/// use scene::{BodyKind, Scene};
/// use surface::TriangleSurface;
/// use surface::progress::Progress;
///
/// // A bone that moves into a muscle, here two tetrahedra of 10 mm.
/// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let bone = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 10.0 * corner);
/// let muscle = bone.map(|corner| corner + DVec3::new(1.0, 1.0, 10.5));
/// let mut scene = Scene::new();
/// let id = scene.add("bone", BodyKind::Rigid, TriangleSurface::new(4, faces.clone())?, bone.to_vec())?;
/// let soft = scene.add("muscle", BodyKind::Deformable, TriangleSurface::new(4, faces)?, muscle.to_vec())?;
///
/// let mut resolver = Resolver::new(ResolveParams::with_smoothing(6.0))?;
/// for up in [0.0, 1.0, 2.0] {
///     // Both bodies are placed without any push; the resolver adds the last one by itself.
///     scene.move_body(id, &bone.map(|corner| corner + up * DVec3::Z))?;
///     scene.move_body(soft, &muscle)?;
///     assert!(resolver.resolve(&mut scene, Progress::none())?.resolved);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Resolver {
    params: ResolveParams,
    conditions: Conditions,
    /// Displacements of the last state.
    carried: Vec<LocalDisplacements>,
    /// Ties of the first state, which hold in all others.
    ties: Option<TieBonds>,
}

impl Resolver {
    /// Returns a resolver without an earlier state.
    ///
    /// # Errors
    ///
    /// [`ResolveError::Parameter`] for a parameter out of range.
    pub fn new(params: ResolveParams) -> Result<Self, ResolveError> {
        params.validate()?;
        Ok(Self { params, conditions: Conditions::default(), carried: Vec::new(), ties: None })
    }

    /// Adds ties and fixed vertices, in place of earlier ones.
    #[must_use]
    pub fn with_conditions(self, conditions: Conditions) -> Self {
        Self { conditions, ties: None, ..self }
    }

    /// Pushes apart the bodies of a scene that overlap, as [`resolve`] does.
    ///
    /// The scene's positions are those without any push. Displacements of the last state are
    /// added first, unless the scene has other bodies now or is worse off with them, and ties hold the vertices that
    /// they held in the first state. Where they lead to no
    /// end, the state is pushed apart by itself, with displacements that fade over its deepest overlap at least.
    /// Where that leads to none either, and where it was by itself before, it is again, with displacements that
    /// fade over half as much again each time, until that is one and a half times its deepest overlap, and then over
    /// less where that is no less than its deepest overlap.
    /// Before all that, tied vertices are let go at faces that would turn over, where that leaves less, and pairs that
    /// no push has a side to take to, as one body in another, are left as they are,
    /// where they hold up others. So are those that no round frees where rounds that free others press bodies into each
    /// other anew, and pairs of soft bodies in the end, unless the best state is kept in any case.
    ///
    /// # Errors
    ///
    /// With soft bodies back where they were, and the next call going on from the last state without an error:
    /// - [`ResolveError::NoSuchVertex`] for a condition that is of another scene;
    /// - [`ResolveError::Polygons`] for a soft body of [`Scene::add_simplex`];
    /// - [`ResolveError::Unwelded`] for a soft body that would tear, since its vertices are not welded;
    /// - [`ResolveError::Interrupted`] when the handler of `progress` ends the call;
    /// - [`ResolveError::Scene`] and [`ResolveError::Response`] for bodies that are too large,
    ///   or too far from the origin to compute with.
    pub fn resolve(
        &mut self,
        scene: &mut Scene,
        progress: Progress<'_>,
    ) -> Result<Resolution, ResolveError> {
        let mut carried = &self.carried[..];
        let mut ties = self.ties.as_ref();
        if !fits(carried, scene) {
            (carried, ties) = (&[], None);
        }
        let start = Start { params: self.params, conditions: &self.conditions, ties, carried };
        let mut attempts = Attempts::begin(start, scene, progress)?;
        attempts.loosen_ties()?;
        attempts.leave_sideless()?;
        attempts.push_otherwise()?;
        attempts.leave_unfreed()?;
        let beyond = attempts.leave_soft_pairs()?;
        attempts.hold_broken()?;

        // Only a state without an error is one to go on from.
        let Attempts { mut end, displacements, ties, .. } = attempts;
        (self.carried, self.ties) = (displacements, Some(ties));
        if !end.resolved {
            end.list_before(beyond);
        }
        Ok(end)
    }
}
