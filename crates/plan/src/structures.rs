//! Structures that a plan has built, body by body.

use decimate::CoarseSurface;
use distance_field::FieldDetector;
use medial::MedialDetector;
use scene::{Body, BodyId, PairId, Revision, Scene};
use surface::{RigidState, parallel};

use crate::bone_field::BoneField;
use crate::box_depth::max_depth_by_face_boxes;
use crate::choice::StructureSet;
use crate::coarse_levels::{CoarseLevels, MAX_DEVIATION};
use crate::cost::{count, far_share};
use crate::{
    Accuracy, DetectionMethod, ExclusionReason, OperationCounts, PairPlan, PlanError, PlanParams,
    StructureKind,
};

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
    pub(crate) uses_tree_now: Vec<bool>,
    /// Per body, the number of pairs in which they do.
    pub(crate) stale_counts: Vec<usize>,
    pub(crate) bodies: Vec<BodyStructures>,
}

/// Structures of one body.
#[derive(Debug, Default)]
pub(crate) struct BodyStructures {
    pub(crate) coarse: Option<CoarseLevels>,
    pub(crate) field: Option<BoneField>,
    pub(crate) medial: Option<MedialDetector>,
    /// Revision of the body whose positions they are at.
    followed: Option<Revision>,
    /// True if the body was placed by a pose there.
    had_pose: bool,
}

impl Structures {
    /// Returns no structures, for a number of bodies.
    pub(crate) fn new(count: usize) -> Self {
        let bodies = std::iter::repeat_with(BodyStructures::default).take(count).collect();
        let [uses_tree, uses_tree_now] = [(); 2].map(|()| vec![false; count]);
        Self { uses_tree, uses_tree_now, stale_counts: Vec::new(), bodies }
    }

    /// Moves coarse surfaces, balls and trees to where the bodies are. Pairs whose coarse surfaces
    /// deviate too much there get trees.
    pub(crate) fn follow(
        &mut self,
        scene: &mut Scene,
        pairs: &[PairPlan],
        params: &PlanParams,
    ) -> Result<(), PlanError> {
        let bodies = scene.bodies();
        let size = |number: usize, _: &BodyStructures| count(bodies[number].positions().len());
        parallel::try_for_each_costly_first(&mut self.bodies, size, |number, structures| {
            structures.follow(&bodies[number], params.tolerance).map(|_| ())
        })?;

        // Trees last, since coarse surfaces decide which are needed.
        self.uses_tree_now.clone_from(&self.uses_tree);
        self.choose_whole(scene, pairs, params);
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
        params: &PlanParams,
    ) -> Result<OperationCounts, PlanError> {
        let far_share = far_share(scene);
        let mut operations = OperationCounts::default();
        for id in pair.bodies() {
            let structures = &mut self.bodies[id.index()];
            if structures.follow(scene.body(id), params.tolerance)? {
                operations = operations + structures.follow_operations(scene.body(id), far_share);
            }
        }

        // Trees of whole bodies, unless coarse surfaces stand for them or show that they are apart.
        self.uses_tree_now.clone_from(&self.uses_tree);
        self.choose_whole(scene, planned.map_or(&[], std::slice::from_ref), params);
        let is_coarse = match planned {
            Some(planned) if self.are_apart(pair, params.margin) => planned.is_coarse,
            Some(planned) => self.coarse_sides(scene, planned, params.tolerance),
            None => [false; 2],
        };

        // Trees that are up to date already cost nothing.
        let mut is_fitted = vec![false; self.bodies.len()];
        for (id, is_coarse) in pair.bodies().into_iter().zip(is_coarse) {
            let body = scene.body(id);
            if !is_coarse && body.tree().is_none() {
                is_fitted[id.index()] = true;
                operations = operations + refit(count(body.surface().faces().len()), far_share);
            }
        }
        scene.fit(&is_fitted)?;
        Ok(operations)
    }

    /// Returns the coarse surface of a body, if it has one.
    pub(crate) fn coarse(&self, id: BodyId) -> Option<&CoarseSurface> {
        self.bodies[id.index()].coarse.as_ref().map(CoarseLevels::present)
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
    pub(crate) fn accuracy(&self, scene: &Scene, planned: &PairPlan, tolerance: f64) -> Accuracy {
        let [a, b] = planned.pair.bodies().map(|id| &self.bodies[id.index()]);
        match planned.method {
            // The bracket on the depth holds the deviations, and its depth is within the tolerance.
            DetectionMethod::Exact | DetectionMethod::Coarse => Accuracy::proved(tolerance),
            DetectionMethod::Field => {
                let field = if planned.bone == Some(planned.pair.a) { a } else { b };
                let accuracy = field.field_accuracy();
                Accuracy { bound: accuracy.bound.max(tolerance), ..accuracy }
            }
            // Balls see no more of the depth than that of vertices, and in bodies that have balls.
            DetectionMethod::Balls => {
                let of_gaps = a.medial_accuracy().bound.max(b.medial_accuracy().bound);
                let bound = of_gaps.max(max_depth_by_face_boxes(scene, planned.pair));
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
    /// Moves coarse surfaces and balls to where the body is. Returns true if they were elsewhere.
    fn follow(&mut self, body: &Body, tolerance: f64) -> Result<bool, PlanError> {
        if self.followed == Some(body.revision()) {
            return Ok(false);
        }
        if let Some(coarse) = &mut self.coarse {
            // A pose keeps the shape, whose deviation was bounded at the first one.
            let reference = body.reference().filter(|_| body.pose().is_some());
            match reference.filter(|_| self.had_pose) {
                Some(reference) => coarse.follow_rigidly(body.positions(), reference)?,
                None => coarse.follow(body.positions(), MAX_DEVIATION * tolerance)?,
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
            let faces = count(coarse.present().tree().surface().faces().len());
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
            let faces = coarse.present().tree().surface().faces().len();
            let accuracy = self.coarse_accuracy();
            let built = structure(StructureKind::Coarse, faces, accuracy, coarse.bytes());
            let finer = coarse.finer_count();
            let kept = count(faces) / count(body.surface().faces().len());
            let operations = coarse_construction(body, kept, finer, far_share);
            list.push(Structure { operations, ..built });
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
    pub(crate) fn coarse_accuracy(&self) -> Accuracy {
        let deviation = self.coarse.as_ref().map_or(0.0, |coarse| coarse.present().deviation());
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

/// Refits of a face that take as long as the bound on a deviation per vertex, near and far.
const FACES_PER_VERTEX: f64 = 2.0;
const FAR_FACES_PER_VERTEX: f64 = 5.0;

/// Returns the operations by which a coarse surface of so many faces follows a body: its own refit,
/// and the bound on its deviation, which stays where a pose moves the body.
///
/// A bound takes a fifth of the memory per face that a tree does, so that its far share grows later.
pub(crate) fn coarse_follow(body: &Body, faces: f64, far_share: f64) -> OperationCounts {
    let moved = if body.pose().is_none() { count(body.positions().len()) } else { 0.0 };
    let far_refit_faces = far_share * (faces + far_share * FAR_FACES_PER_VERTEX * moved);
    let refit_faces = faces + FACES_PER_VERTEX * moved;
    OperationCounts { refit_faces, far_refit_faces, ..OperationCounts::default() }
}

/// Returns the operations that build the tree of a body.
pub(crate) fn tree_construction(body: &Body) -> OperationCounts {
    OperationCounts {
        tree_faces: count(body.surface().faces().len()),
        ..OperationCounts::default()
    }
}

/// Decimations to the coarsest surface that take as long as one to a finer one.
const FINER_DECIMATIONS: f64 = 0.7;

/// Returns the operations that build a coarse surface of a body which keeps a share of its faces, and
/// a number of finer ones.
pub(crate) fn coarse_construction(
    body: &Body,
    kept: f64,
    finer: usize,
    far_share: f64,
) -> OperationCounts {
    let decimations = 1.0 + FINER_DECIMATIONS * count(finer);
    let decimated_faces = decimations * (2.0 - kept) * count(body.surface().faces().len());
    let far_decimated_faces = far_share * decimated_faces;
    OperationCounts { decimated_faces, far_decimated_faces, ..tree_construction(body) }
}
