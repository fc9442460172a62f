//! Surfaces by which the bodies of a pair are compared: coarse ones where they are, or their own.

use proximity::{ContactSurface, SurfaceTree};
use scene::{Body, BodyId, PairId, Scene};

use crate::coarse_levels::MIN_WIDTH;
use crate::cost::count;
use crate::structures::Structures;
use crate::{PairPlan, PlanParams};

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
    /// Chooses the bodies that are compared by their own surfaces, until no two coarse ones that may
    /// meet deviate too much: those with the fewest faces for each of their pairs first. One that
    /// deforms much is then whole, instead of all the others that it meets.
    pub(crate) fn choose_whole(&mut self, scene: &Scene, pairs: &[PairPlan], params: &PlanParams) {
        let PlanParams { tolerance, margin, .. } = *params;
        loop {
            // Pairs that are left, per body.
            self.stale_counts.clear();
            self.stale_counts.resize(self.bodies.len(), 0);
            for planned in pairs {
                let is_coarse = self.coarse_sides(scene, planned, tolerance);
                if self.is_allowed(planned.pair, is_coarse, tolerance)
                    || self.are_apart(planned.pair, margin)
                {
                    continue;
                }
                for (id, is_coarse) in planned.pair.bodies().into_iter().zip(is_coarse) {
                    self.stale_counts[id.index()] += usize::from(is_coarse);
                }
            }

            let faces_per_pair = |number: usize| {
                let faces = scene.bodies()[number].surface().faces().len();
                count(faces) / count(self.stale_counts[number])
            };
            let stale = (0..self.bodies.len()).filter(|&number| self.stale_counts[number] > 0);
            let cheapest = |&a: &usize, &b: &usize| faces_per_pair(a).total_cmp(&faces_per_pair(b));
            let Some(number) = stale.min_by(cheapest) else { return };
            self.uses_tree_now[number] = true;
        }
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
                contact: coarse.contact_surface(whole),
            }),
        }
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

    /// Returns true if two bodies with coarse surfaces are farther apart than the margin, as the bounds
    /// of these and their deviations show.
    pub(crate) fn are_apart(&self, pair: PairId, margin: f64) -> bool {
        let [Some(a), Some(b)] = pair.bodies().map(|id| self.coarse(id)) else { return false };
        let reach = margin + a.deviation() + b.deviation();
        !a.tree().tree().root().inflated(reach).overlaps(&b.tree().tree().root())
    }

    /// Returns which bodies of a pair are compared by coarse surfaces where they are: those of the
    /// plan, or some of them if the tolerance does not allow both. Others have trees of their own in
    /// this frame. If either may be coarse, the one is that leaves fewer faces to compare.
    pub(crate) fn coarse_sides(
        &self,
        scene: &Scene,
        planned: &PairPlan,
        tolerance: f64,
    ) -> [bool; 2] {
        let PairPlan { pair, is_coarse, .. } = *planned;
        if self.is_allowed(pair, is_coarse, tolerance) {
            return is_coarse;
        }
        let [a, b] = is_coarse;
        let [is_a_whole, is_b_whole] = pair.bodies().map(|id| self.uses_tree_now[id.index()]);
        let mut alone = [[a && !is_a_whole, b], [a, b && !is_b_whole]];
        if self.compared_faces(scene, pair, alone[1]) < self.compared_faces(scene, pair, alone[0]) {
            alone.reverse();
        }
        let allowed = alone.into_iter().find(|&sides| self.is_allowed(pair, sides, tolerance));
        allowed.unwrap_or([a && !is_a_whole, b && !is_b_whole])
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

    /// Returns the bodies of a pair whose coarse surfaces have to be built anew: the one that
    /// deviates most, until the tolerance allows the rest.
    pub(crate) fn stale_bodies(&self, planned: &PairPlan, tolerance: f64) -> [Option<BodyId>; 2] {
        let (pair, mut is_coarse) = (planned.pair, planned.is_coarse);
        while is_coarse != [false; 2] && !self.is_allowed(pair, is_coarse, tolerance) {
            let [without_a, without_b] = [[false, is_coarse[1]], [is_coarse[0], false]];
            let is_a_worse = self.deviation(pair, without_a) <= self.deviation(pair, without_b);
            is_coarse = if is_a_worse { without_a } else { without_b };
        }
        let bodies = pair.bodies();
        [0, 1].map(|side| (planned.is_coarse[side] && !is_coarse[side]).then_some(bodies[side]))
    }
}
