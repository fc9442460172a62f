//! Overlap removal of one state, or of one state after another.

use glam::DVec3;
use scene::{Body, BodyId, PairReport, Scene};
use surface::parallel;
use surface::progress::Progress;

use crate::conditions::TieBonds;
use crate::exempt::Exempt;
use crate::local_displacements::{LocalDisplacements, fits};
use crate::run::{Known, Run};
use crate::{Conditions, Obstacle, Resolution, ResolveError, ResolveParams};

/// Factor on the smoothing length of a start after one that was the same but for it. Near 1, both lead
/// to the same end; above, more tissue moves than was asked for.
const LONGER: f64 = 1.5;

/// Length of pushes up to which a further start has shorter ones \[deepest overlaps\]. Above, those are long, too.
const FAR: f64 = 3.0;

/// Largest number of starts after the first one. Below, deep tissue with short pushes is not freed; above, what has no
/// way out is refused later.
const MAX_FURTHER_STARTS: usize = 6;

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
    pub(crate) params: ResolveParams,
    conditions: Conditions,
    pub(crate) carried: Vec<LocalDisplacements>,
    /// Ties of the first state, which hold in all others.
    ties: Option<TieBonds>,
    /// Tied vertices at faces that the last attempt would have turned over.
    pub(crate) strained_ties: Vec<(BodyId, u32)>,
}

impl Resolver {
    /// Returns a resolver without an earlier state.
    ///
    /// # Errors
    ///
    /// [`ResolveError::Parameter`] for a parameter out of range.
    pub fn new(params: ResolveParams) -> Result<Self, ResolveError> {
        params.validate()?;
        Ok(Self {
            params,
            conditions: Conditions::default(),
            carried: Vec::new(),
            ties: None,
            strained_ties: Vec::new(),
        })
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
    /// With soft bodies back where they were:
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
        let mut carried = std::mem::take(&mut self.carried);
        if !fits(&carried, scene) {
            carried.clear();
            self.ties = None;
        }
        let rest = soft_positions(scene);
        let mut exempt = Exempt::NONE;
        let mut end = self.attempt(self.params, scene, &carried, &exempt, None, progress)?;
        end = self.loosen_ties(scene, end, &rest, &mut exempt, progress)?;
        end = self.leave_sideless(scene, end, &rest, &mut exempt, progress)?;
        if may_be_better(&end) {
            // Longer pushes may also take apart what has no side to be pushed to, where nothing else is left.
            let further = self.other_pushes(&end, carried.is_empty());
            let kept = if end.is_left_without(&exempt) { &exempt } else { &Exempt::NONE };
            end = self.start_again(further, scene, end, &rest, kept, progress)?;
        }
        end = self.leave_unfreed(scene, end, &rest, &mut exempt, progress)?;
        let (end, beyond) = self.leave_soft_pairs(scene, end, &rest, &mut exempt, progress)?;
        let mut end = self.hold_broken(scene, end, &rest, exempt, progress)?;
        if !end.resolved {
            end.list_before(beyond);
        }
        Ok(end)
    }

    /// Starts from the state by itself by other parameters, as long as an end may be better; takes the scene to the
    /// first of the best ends, and returns it.
    fn start_again(
        &mut self,
        further: Vec<ResolveParams>,
        scene: &mut Scene,
        first: Resolution,
        rest: &[Vec<DVec3>],
        exempt: &Exempt,
        progress: Progress<'_>,
    ) -> Result<Resolution, ResolveError> {
        let mut best = first;
        let (mut carried, mut positions) =
            (std::mem::take(&mut self.carried), soft_positions(scene));
        for params in further {
            move_soft_bodies(scene, rest)?;
            let before = (params == self.params).then_some(&best.before[..]);
            let mut end = self.attempt(params, scene, &[], exempt, before, progress)?;
            end.name_exempt(exempt, &best);
            let is_last = !may_be_better(&end);
            if is_last || end.left() < best.left() {
                best = end;
                (carried, positions) = (std::mem::take(&mut self.carried), soft_positions(scene));
            }
            if is_last {
                break;
            }
        }
        self.carried = carried;
        move_soft_bodies(scene, &positions)?;
        Ok(best)
    }

    /// Returns the parameters of further starts, each with longer pushes, until these are far longer than the deepest
    /// vertex is deep, and then one with shorter pushes, where these are no shorter than that. Displacements of the last
    /// state may lead where no way goes on, and so may short pushes: after a first start that was `alone`, pushes begin a little longer; after others no shorter than the deepest vertex is
    /// deep, since those that an earlier state was given for turn faces over.
    fn other_pushes(&self, first_end: &Resolution, alone: bool) -> Vec<ResolveParams> {
        // The depth of what another body encloses is not how far it is to come.
        let is_enclosed = |report: &PairReport| {
            let mut remaining = first_end.remaining.iter();
            remaining.any(|left| left.pair == report.pair && left.obstacle == Obstacle::Enclosed)
        };
        let mut depth: f64 = 0.0;
        for report in first_end.before.iter().filter(|report| !is_enclosed(report)) {
            depth = depth.max(report.max_vertex_depth);
        }

        let asked = self.params.smoothing;
        let first = if alone { LONGER * asked } else { asked.max(depth) };
        let next = |length: &f64| (*length <= LONGER * depth).then_some(LONGER * length);
        let longer = std::iter::successors(Some(first), next).take(MAX_FURTHER_STARTS);
        let may_be_shorter = asked <= FAR * depth && asked >= LONGER * depth;
        let shorter = may_be_shorter.then_some(asked / LONGER);
        longer.chain(shorter).map(|smoothing| ResolveParams { smoothing, ..self.params }).collect()
    }

    /// Removes overlaps by some parameters from one start, with some bodies and pairs left as they are, and keeps the displacements
    /// to carry on. `before` are the overlaps without any displacement, where they are known.
    pub(crate) fn attempt(
        &mut self,
        params: ResolveParams,
        scene: &mut Scene,
        carried: &[LocalDisplacements],
        exempt: &Exempt,
        before: Option<&[PairReport]>,
        progress: Progress<'_>,
    ) -> Result<Resolution, ResolveError> {
        let known = Known { before, ties: self.ties.as_ref() };
        let mut run = Run::new(scene, params, &self.conditions, exempt, known, progress)?;
        if self.ties.is_none() {
            self.ties = Some(run.ties.all.clone());
        }
        run.allowed_displacement = self.params.smoothing;
        let result = run.warm_start(carried).and_then(|()| run.complete());
        match &result {
            Ok(_) => {
                self.carried = run.local_displacements();
                self.strained_ties = std::mem::take(&mut run.strained_ties);
            }
            Err(_) => run.restore()?,
        }
        result
    }
}

/// Returns true if something is left that another start might change: more than what is between rigid
/// bodies.
fn may_be_better(resolution: &Resolution) -> bool {
    let Resolution { broken_limits, self_overlaps, .. } = resolution;
    let is_broken = !broken_limits.is_empty() || !self_overlaps.is_empty();
    !resolution.resolved && (is_broken || resolution.is_left_without(&Exempt::NONE))
}

/// Returns the positions of all soft bodies, with none for rigid ones.
pub(crate) fn soft_positions(scene: &Scene) -> Vec<Vec<DVec3>> {
    let soft = |body: &Body| if body.is_rigid() { Vec::new() } else { body.positions().to_vec() };
    parallel::map_slice_with(scene.bodies(), || (), |(), body| soft(body))
}

/// Moves all soft bodies to the positions given for them.
pub(crate) fn move_soft_bodies(
    scene: &mut Scene,
    positions: &[Vec<DVec3>],
) -> Result<(), ResolveError> {
    for (id, x) in scene.ids().zip(positions) {
        if !scene.body(id).is_rigid() {
            scene.move_body(id, x)?;
        }
    }
    Ok(())
}
