//! Structures that a plan has built, body by body.

use decimate::CoarseSurface;
use distance_field::FieldDetector;
use medial::MedialDetector;
use proximity::{ContactSurface, ParticleNumbers, SurfaceTree};
use scene::{Body, BodyId, PairId, Revision, Scene};
use surface::{RigidState, parallel};

use crate::bone_field::BoneField;
use crate::choice::StructureSet;
use crate::cost::{count, far_share};
use crate::{
    Accuracy, DetectionMethod, ExclusionReason, OperationCounts, PairPlan, PlanError, StructureKind,
};

/// Part of the tolerance that deviations must leave, in which surfaces that touch are told from those
/// that are deeper. Larger compares bodies that deform by their own surfaces sooner.
const MIN_WIDTH: f64 = 0.02;

/// Structure that was built for a body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Structure {
    /// The body.
    pub body: BodyId,
    /// The kind of structure.
    pub kind: StructureKind,
    /// Number of faces of a surface, nodes of a field, or balls.
    pub size: usize,
    /// Distance between the nodes of a field.
    pub spacing: Option<f64>,
    /// Accuracy of the structure: its deviation from the body's own surface.
    pub accuracy: Accuracy,
    /// Memory, in bytes.
    pub bytes: usize,
    /// Operations of its construction, by which it was chosen.
    pub operations: OperationCounts,
}

/// Structure that might have been built for a body and was not.
#[derive(Clone, Debug, PartialEq)]
pub struct MissingStructure {
    /// The body.
    pub body: BodyId,
    /// The kind of structure.
    pub kind: StructureKind,
    /// Reason why it was not built.
    pub reason: ExclusionReason,
}

/// Structures of all bodies of a scene, in their order.
#[derive(Debug)]
pub(crate) struct Structures {
    /// One per body: true if the tree over its own faces is used.
    pub(crate) uses_tree: Vec<bool>,
    /// The same for the present frame, in which some coarse surfaces deviate too much.
    uses_tree_now: Vec<bool>,
    pub(crate) bodies: Vec<BodyStructures>,
}

/// Structures of one body.
#[derive(Debug, Default)]
pub(crate) struct BodyStructures {
    pub(crate) coarse: Option<CoarseSurface>,
    pub(crate) field: Option<BoneField>,
    pub(crate) medial: Option<MedialDetector>,
    /// Revision of the body whose positions they are at.
    followed: Option<Revision>,
    /// True if the body was placed by a pose there.
    had_pose: bool,
}

/// Surface of a body as it is compared with another one.
#[derive(Clone, Copy)]
pub(crate) struct ComparedSurface<'a> {
    pub(crate) tree: &'a SurfaceTree,
    pub(crate) contact: ContactSurface<'a>,
}

impl<'a> ComparedSurface<'a> {
    /// Returns the body's own surface, where its tree is up to date.
    pub(crate) fn whole(body: &'a Body) -> Option<Self> {
        body.tree().map(|tree| Self { tree, contact: body.contact_surface() })
    }
}

impl Structures {
    /// Returns no structures, for a number of bodies.
    pub(crate) fn new(count: usize) -> Self {
        let bodies = std::iter::repeat_with(BodyStructures::default).take(count).collect();
        Self { uses_tree: vec![false; count], uses_tree_now: Vec::new(), bodies }
    }

    /// Moves coarse surfaces, balls and trees to where the bodies are. Pairs whose coarse surfaces
    /// deviate too much there get trees.
    pub(crate) fn follow(
        &mut self,
        scene: &mut Scene,
        pairs: &[PairPlan],
        tolerance: f64,
    ) -> Result<(), PlanError> {
        let bodies = scene.bodies();
        let size = |number: usize, _: &BodyStructures| count(bodies[number].positions().len());
        parallel::try_for_each_costly_first(&mut self.bodies, size, |number, structures| {
            structures.follow(&bodies[number]).map(|_| ())
        })?;

        // Trees last, since coarse surfaces decide which are needed.
        self.uses_tree_now.clone_from(&self.uses_tree);
        for planned in pairs {
            for id in self.whole_bodies(scene, planned, tolerance).into_iter().flatten() {
                self.uses_tree_now[id.index()] = true;
            }
        }
        scene.fit(&self.uses_tree_now)?;
        Ok(())
    }

    /// Returns the structures that can be kept where the bodies are, per body: all but coarse
    /// surfaces that deviate too much for one of their pairs.
    pub(crate) fn present(&self, pairs: &[PairPlan], tolerance: f64) -> Vec<StructureSet> {
        let mut is_stale = vec![false; self.bodies.len()];
        for planned in pairs {
            for id in self.stale_bodies(planned, tolerance).into_iter().flatten() {
                is_stale[id.index()] = true;
            }
        }

        let mut present = Vec::new();
        for (number, of_body) in self.bodies.iter().enumerate() {
            let mut set = StructureSet::default();
            for (kind, is_built) in [
                (StructureKind::Tree, self.uses_tree[number]),
                (StructureKind::Coarse, of_body.coarse.is_some() && !is_stale[number]),
                (StructureKind::Field, of_body.field.is_some()),
                (StructureKind::Medial, of_body.medial.is_some()),
            ] {
                if is_built {
                    set = set.with(StructureSet::of(kind));
                }
            }
            present.push(set);
        }
        present
    }

    /// Takes the structures over that a choice needs and that were not built anew.
    pub(crate) fn adopt(&mut self, earlier: &mut Self, chosen: &[StructureSet]) {
        let bodies = self.bodies.iter_mut().zip(&mut earlier.bodies);
        for ((own, earlier), set) in bodies.zip(chosen) {
            if set.has(StructureKind::Coarse) && own.coarse.is_none() {
                own.coarse = earlier.coarse.take();
            }
            if set.has(StructureKind::Field) && own.field.is_none() {
                own.field = earlier.field.take();
            }
            if set.has(StructureKind::Medial) && own.medial.is_none() {
                own.medial = earlier.medial.take();
            }
        }
    }

    /// Moves the structures of two bodies that a pair needs, which is in the plan or not, and
    /// counts the operations.
    pub(crate) fn follow_pair(
        &mut self,
        scene: &mut Scene,
        pair: PairId,
        planned: Option<&PairPlan>,
        tolerance: f64,
    ) -> Result<OperationCounts, PlanError> {
        let far_share = far_share(scene);
        let mut operations = OperationCounts::default();
        for id in pair.bodies() {
            let structures = &mut self.bodies[id.index()];
            if structures.follow(scene.body(id))? {
                operations = operations + structures.follow_operations(scene.body(id), far_share);
            }
        }

        // Trees of whole bodies, unless coarse surfaces stand for them.
        let is_coarse = match planned {
            Some(planned) => self.coarse_sides(scene, planned, tolerance),
            None => [false; 2],
        };

        // Trees that are up to date already cost nothing.
        self.uses_tree_now.clear();
        self.uses_tree_now.resize(self.bodies.len(), false);
        for (id, is_coarse) in pair.bodies().into_iter().zip(is_coarse) {
            let body = scene.body(id);
            if !is_coarse && body.tree().is_none() {
                self.uses_tree_now[id.index()] = true;
                operations = operations + refit(count(body.surface().faces().len()), far_share);
            }
        }
        scene.fit(&self.uses_tree_now)?;
        Ok(operations)
    }

    /// Returns a body as it is compared, by its coarse surface or its own. `None` where its own
    /// faces have no tree that is up to date.
    pub(crate) fn compared<'a>(
        &'a self,
        scene: &'a Scene,
        id: BodyId,
        is_coarse: bool,
    ) -> Option<ComparedSurface<'a>> {
        let whole = scene.body(id).contact_surface();
        match self.coarse(id).filter(|_| is_coarse) {
            None => ComparedSurface::whole(scene.body(id)),
            Some(coarse) => Some(ComparedSurface {
                tree: coarse.tree(),
                // Contacts of a coarse surface are of the vertices that it has kept.
                contact: ContactSurface {
                    surface: coarse.tree().surface(),
                    positions: coarse.tree().positions(),
                    particles: ParticleNumbers {
                        kept: Some(&coarse.reduced().kept),
                        ..whole.particles
                    },
                    ..whole
                },
            }),
        }
    }

    /// Returns the coarse surface of a body, if it has one.
    pub(crate) fn coarse(&self, id: BodyId) -> Option<&CoarseSurface> {
        self.bodies[id.index()].coarse.as_ref()
    }

    /// Bounds the deviations of the compared surfaces of a pair from the bodies' own, α of A and β
    /// of B.
    ///
    /// Depths differ by no more than α + β. Take a point of one of A's two surfaces that is deeper
    /// than that in one of B's. Within α there is a point of A's other surface, still deeper than
    /// β, since the way there is too short to leave B. So it is inside B's other surface, too, and
    /// less deep there by β at most.
    pub(crate) fn deviations(&self, pair: PairId, is_coarse: [bool; 2]) -> [f64; 2] {
        let bodies = pair.bodies();
        [0, 1].map(|side| {
            let of_body = &self.bodies[bodies[side].index()];
            if is_coarse[side] { of_body.coarse_accuracy().bound } else { 0.0 }
        })
    }

    /// Bounds the difference between the depths of the compared surfaces and of the bodies' own.
    fn deviation(&self, pair: PairId, is_coarse: [bool; 2]) -> f64 {
        self.deviations(pair, is_coarse).iter().sum()
    }

    /// Returns which bodies of a pair are compared by coarse surfaces where they are: those of the
    /// plan, or one of them if the tolerance does not allow both. The one that leaves fewer faces to
    /// compare stays, not the one that deviates less.
    pub(crate) fn coarse_sides(
        &self,
        scene: &Scene,
        planned: &PairPlan,
        tolerance: f64,
    ) -> [bool; 2] {
        let PairPlan { pair, is_coarse: [a, b], .. } = *planned;
        let mut alone = [[a, false], [false, b]];
        if self.compared_faces(scene, pair, alone[1]) < self.compared_faces(scene, pair, alone[0]) {
            alone.reverse();
        }
        let mut choices = [[a, b], alone[0], alone[1]].into_iter();
        let allowed = choices.find(|&sides| self.is_allowed(pair, sides, tolerance));
        allowed.unwrap_or([false; 2])
    }

    /// Returns true if the deviations of coarse surfaces leave enough of the tolerance.
    fn is_allowed(&self, pair: PairId, is_coarse: [bool; 2], tolerance: f64) -> bool {
        self.deviation(pair, is_coarse) <= (1.0 - MIN_WIDTH) * tolerance
    }

    /// Counts the faces of both bodies of a pair as they are compared.
    fn compared_faces(&self, scene: &Scene, pair: PairId, is_coarse: [bool; 2]) -> usize {
        let mut faces = 0;
        for (id, is_coarse) in pair.bodies().into_iter().zip(is_coarse) {
            let whole = scene.body(id).surface();
            let coarse = self.coarse(id).filter(|_| is_coarse);
            faces += coarse.map_or(whole, |coarse| coarse.tree().surface()).faces().len();
        }
        faces
    }

    /// Returns the bodies of a pair that are compared by their own surfaces instead of coarse ones,
    /// of which both deviate too much.
    fn whole_bodies(
        &self,
        scene: &Scene,
        planned: &PairPlan,
        tolerance: f64,
    ) -> [Option<BodyId>; 2] {
        let is_coarse = self.coarse_sides(scene, planned, tolerance);
        let bodies = planned.pair.bodies();
        [0, 1].map(|side| (planned.is_coarse[side] && !is_coarse[side]).then_some(bodies[side]))
    }

    /// Returns the bodies of a pair whose coarse surfaces have to be built anew: the one that
    /// deviates most, until the tolerance allows the rest.
    fn stale_bodies(&self, planned: &PairPlan, tolerance: f64) -> [Option<BodyId>; 2] {
        let (pair, mut is_coarse) = (planned.pair, planned.is_coarse);
        while is_coarse != [false; 2] && !self.is_allowed(pair, is_coarse, tolerance) {
            let [without_a, without_b] = [[false, is_coarse[1]], [is_coarse[0], false]];
            let is_a_worse = self.deviation(pair, without_a) <= self.deviation(pair, without_b);
            is_coarse = if is_a_worse { without_a } else { without_b };
        }
        let bodies = pair.bodies();
        [0, 1].map(|side| (planned.is_coarse[side] && !is_coarse[side]).then_some(bodies[side]))
    }

    /// Returns the detector of a rigid body's field, and the state of the body; `None` where it
    /// has no field.
    pub(crate) fn field_detector(
        &self,
        scene: &Scene,
        id: BodyId,
    ) -> Result<Option<(&FieldDetector, RigidState)>, PlanError> {
        let Some(field) = &self.bodies[id.index()].field else { return Ok(None) };

        // Vertices moved one by one have left the frame of the field.
        let body = scene.body(id);
        let Some(pose) = body.pose() else {
            return Err(PlanError::NoPose { name: body.name().to_owned() });
        };
        Ok(Some((&field.detector, RigidState::at_rest(pose))))
    }

    /// Returns the accuracy of a pair's depth and gaps.
    pub(crate) fn accuracy(&self, planned: &PairPlan, tolerance: f64) -> Accuracy {
        let [a, b] = planned.pair.bodies().map(|id| &self.bodies[id.index()]);
        match planned.method {
            // The bracket on the depth holds the deviations, and its depth is within the tolerance.
            DetectionMethod::Exact | DetectionMethod::Coarse => Accuracy::proved(tolerance),
            DetectionMethod::Field => {
                let field = if planned.bone == Some(planned.pair.a) { a } else { b };
                let accuracy = field.field_accuracy();
                Accuracy { bound: accuracy.bound.max(tolerance), ..accuracy }
            }
            DetectionMethod::Medial => {
                let bound = a.medial_accuracy().bound.max(b.medial_accuracy().bound);
                Accuracy { is_proved: false, ..Accuracy::proved(bound) }
            }
        }
    }

    /// Lists the structures, in the order of the bodies.
    pub(crate) fn list(&self, scene: &Scene) -> Vec<Structure> {
        let far_share = far_share(scene);
        let mut list = Vec::new();
        for (id, structures) in scene.ids().zip(&self.bodies) {
            let body = scene.body(id);
            if self.uses_tree[id.index()] {
                let bytes = body.tree().map_or(0, |tree| tree.tree().bytes());
                list.push(Structure {
                    body: id,
                    kind: StructureKind::Tree,
                    size: body.surface().faces().len(),
                    spacing: None,
                    accuracy: Accuracy::EXACT,
                    bytes,
                    operations: tree_construction(body),
                });
            }
            list.extend(structures.list(body, id, far_share));
        }
        list
    }
}

impl BodyStructures {
    /// Moves coarse surface and balls to where the body is. Returns true if they were elsewhere.
    fn follow(&mut self, body: &Body) -> Result<bool, PlanError> {
        if self.followed == Some(body.revision()) {
            return Ok(false);
        }
        if let Some(coarse) = &mut self.coarse {
            // A pose keeps the shape, whose deviation was bounded at the first one.
            let reference = body.reference().filter(|_| body.pose().is_some());
            match reference.filter(|_| self.had_pose) {
                Some(reference) => coarse.follow_rigidly(body.positions(), reference)?,
                None => coarse.follow(body.positions())?,
            }
            self.had_pose = reference.is_some();
        }
        if let Some(medial) = &mut self.medial {
            medial.follow(body.checked_positions())?;
        }
        self.followed = Some(body.revision());
        Ok(true)
    }

    /// Counts the operations of [`follow`](Self::follow).
    fn follow_operations(&self, body: &Body, far_share: f64) -> OperationCounts {
        let mut operations = OperationCounts::default();
        if let Some(coarse) = &self.coarse {
            let faces = count(coarse.tree().surface().faces().len());
            operations = coarse_follow(body, faces, far_share);
        }
        if self.medial.is_some() {
            operations.tied_vertices = count(body.positions().len());
        }
        operations
    }

    /// Lists the structures but the tree.
    fn list(&self, body: &Body, id: BodyId, far_share: f64) -> Vec<Structure> {
        let structure = |kind, size, accuracy, bytes| Structure {
            body: id,
            kind,
            size,
            spacing: None,
            accuracy,
            bytes,
            operations: OperationCounts::default(),
        };
        let mut list = Vec::new();
        if let Some(coarse) = &self.coarse {
            let (faces, accuracy) = (coarse.tree().surface().faces().len(), self.coarse_accuracy());
            let coarse = structure(StructureKind::Coarse, faces, accuracy, coarse.bytes());
            let kept = count(faces) / count(body.surface().faces().len());
            let operations = coarse_construction(body, kept, far_share);
            list.push(Structure { operations, ..coarse });
        }
        if let Some(BoneField { detector, accuracy }) = &self.field {
            let (grid, bytes) = (detector.field().grid(), detector.bytes());
            let nodes = grid.node_count();
            let operations =
                OperationCounts { field_nodes: count(nodes), ..OperationCounts::default() };
            let spacing = Some(grid.spacing());
            let field = structure(StructureKind::Field, nodes, *accuracy, bytes);
            list.push(Structure { spacing, operations, ..field });
        }

        // Balls are built only where forced, so that no cost of theirs is compared.
        if let Some(medial) = &self.medial {
            let (balls, accuracy) = (medial.medial().balls().len(), self.medial_accuracy());
            list.push(structure(StructureKind::Medial, balls, accuracy, medial.bytes()));
        }
        list
    }

    /// Returns the proved deviation of the coarse surface, where the body is now.
    fn coarse_accuracy(&self) -> Accuracy {
        let deviation = self.coarse.as_ref().map_or(0.0, CoarseSurface::deviation);
        Accuracy::proved(deviation)
    }

    fn field_accuracy(&self) -> Accuracy {
        self.field.as_ref().map_or(Accuracy::EXACT, |field| field.accuracy)
    }

    /// Returns the certified deviation of the medial surface where it was built.
    fn medial_accuracy(&self) -> Accuracy {
        match &self.medial {
            Some(medial) => {
                Accuracy { is_proved: false, ..Accuracy::proved(medial.deviation().largest()) }
            }
            None => Accuracy::EXACT,
        }
    }
}

/// Returns the operations by which a surface of so many faces is refit, of which a share is far.
pub(crate) fn refit(refit_faces: f64, far_share: f64) -> OperationCounts {
    let far_refit_faces = far_share * refit_faces;
    OperationCounts { refit_faces, far_refit_faces, ..OperationCounts::default() }
}

/// Refits of a face that take as long as the bound on a deviation per vertex.
const FACES_PER_VERTEX: f64 = 3.0;

/// Returns the operations by which a coarse surface of so many faces follows a body: its own refit,
/// and the bound on its deviation, which stays where a pose moves the body.
pub(crate) fn coarse_follow(body: &Body, faces: f64, far_share: f64) -> OperationCounts {
    let moved = if body.pose().is_none() { body.positions().len() } else { 0 };
    refit(faces + FACES_PER_VERTEX * count(moved), far_share)
}

/// Returns the operations that build the tree of a body.
pub(crate) fn tree_construction(body: &Body) -> OperationCounts {
    OperationCounts {
        tree_faces: count(body.surface().faces().len()),
        ..OperationCounts::default()
    }
}

/// Returns the operations that build a coarse surface of a body which keeps a share of its faces.
pub(crate) fn coarse_construction(body: &Body, kept: f64, far_share: f64) -> OperationCounts {
    let decimated_faces = (2.0 - kept) * count(body.surface().faces().len());
    let far_decimated_faces = far_share * decimated_faces;
    OperationCounts { decimated_faces, far_decimated_faces, ..tree_construction(body) }
}
