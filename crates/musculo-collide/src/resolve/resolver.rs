//! Resolution of one state after another.

use super::carry::{self, Carried};
use super::{Resolution, ResolveParams, Run, SIGHT, STEP};
use crate::{CheckParams, Scene, SceneError};

/// Resolves the states of a moving scene one after the other, and starts each
/// from how tissue was displaced in the last one, where that is better than to
/// start from the state as it stands.
///
/// ```
/// use musculo_collide::glam::DVec3;
/// use musculo_collide::surface::TriangleSurface;
/// use musculo_collide::{BodyKind, ResolveParams, Resolver, Scene};
///
/// // A bone that moves into a muscle, here two tetrahedra of 10 mm.
/// let faces = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
/// let bone = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| 10.0 * corner);
/// let muscle = bone.map(|corner| corner + DVec3::new(1.0, 1.0, 10.5));
/// let mut scene = Scene::new();
/// let id = scene.add("bone", BodyKind::Rigid, TriangleSurface::new(4, faces.clone())?, bone.to_vec())?;
/// let soft = scene.add("muscle", BodyKind::Deformable, TriangleSurface::new(4, faces)?, muscle.to_vec())?;
///
/// let mut resolver = Resolver::new(ResolveParams::MILLIMETRES)?;
/// for up in [0.0, 1.0, 2.0] {
///     // Every body is placed anew: what resolution did to the muscle is taken up by itself.
///     scene.move_body(id, &bone.map(|corner| corner + up * DVec3::Z))?;
///     scene.move_body(soft, &muscle)?;
///     assert!(resolver.resolve(&mut scene)?.resolved);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Resolver {
    params: ResolveParams,
    carried: Vec<Option<Carried>>,
}

impl Resolver {
    /// A resolver that knows no state yet.
    ///
    /// # Errors
    ///
    /// [`SceneError::Resolve`] for a parameter out of range.
    pub fn new(params: ResolveParams) -> Result<Self, SceneError> {
        params.validate()?;
        Ok(Self { params, carried: Vec::new() })
    }

    /// Pushes apart what overlaps in a scene, as [`Scene::resolve`] does.
    ///
    /// The scene's positions are those without any push; displacements of the
    /// last state are added to them first, unless the scene has other bodies
    /// now or is worse off with them.
    ///
    /// # Errors
    ///
    /// Those of [`Scene::check`].
    pub fn resolve(&mut self, scene: &mut Scene) -> Result<Resolution, SceneError> {
        let step = STEP * self.params.smoothing;
        let near = CheckParams { margin: 4.0 * self.params.clearance + SIGHT * step };
        let fits = carry::fit(&self.carried, scene);
        let mut run = Run::start(scene, self.params, near)?;
        if fits && run.goes_on() {
            run.displace(&self.carried)?;
        }
        while run.goes_on() {
            run.round()?;
        }
        let (resolution, carried) = run.finish()?;
        self.carried = carried;
        Ok(resolution)
    }
}
