//! Structures that cannot pay, whatever is chosen.

use scene::Scene;

use super::{COARSE, FIELD, Planner, field_seconds};
use crate::StructureKind;
use crate::bone_field::FieldSize;
use crate::choice::place;
use crate::cost::count;

/// Largest time of exact detection per face of both bodies of a pair \[s\]: the deepest overlaps of
/// anatomy take half of it. Below, structures that would pay are not considered; above, work is
/// counted for structures that do not.
const MAX_SECONDS_PER_FACE: f64 = 4e-6;

impl Planner<'_> {
    /// Finds the structures that could not pay even if they saved all work of their body's pairs.
    pub(super) fn find_useless(&mut self, scene: &Scene) {
        // A structure saves no more than all work of its body's pairs, in every frame.
        let frames = f64::from(self.params.frames);
        let mut max_saved = vec![0.0; scene.bodies().len()];
        for pair in self.pairs.iter().filter(|pair| pair.forced.is_none()) {
            let faces = pair.pair.bodies().map(|id| count(scene.body(id).surface().faces().len()));
            for id in pair.pair.bodies() {
                max_saved[id.index()] += frames * MAX_SECONDS_PER_FACE * (faces[0] + faces[1]);
            }
        }

        // What costs as much to build is useless; so is a field that misses the tolerance.
        for (number, body) in scene.bodies().iter().enumerate() {
            let saved = max_saved[number];
            let present = self.present[number];
            let coarse = self.coarse_construction(number, body).seconds();
            if coarse >= saved && !present.has(StructureKind::Coarse) {
                self.useless[number] = self.useless[number].with(COARSE);
            }
            let is_closed_bone = body.is_rigid() && body.has_inside().is_ok();
            if is_closed_bone {
                let size = FieldSize::new(body, self.params.tolerance, self.params.margin);
                self.field_sizes[number] = Some(size);
            }
            let pays = self.field_sizes[number].is_some_and(|size| {
                let is_built = present.has(StructureKind::Field);
                size.bound() <= self.params.tolerance && (is_built || field_seconds(size) < saved)
            });
            if !pays {
                self.useless[number] = self.useless[number].with(FIELD);
            }
        }
    }

    /// Finds the coarse surfaces that take longer to build than all counted work of their body's pairs.
    pub(super) fn find_useless_by_work(&mut self, scene: &Scene) {
        let frames = f64::from(self.params.frames);
        let mut frame = vec![0.0; scene.bodies().len()];
        for (pair, work) in self.pairs.iter().zip(&self.workloads) {
            for id in pair.pair.bodies() {
                frame[id.index()] += work.exact().seconds();
            }
        }

        // At best they save that, and to refit the body's own tree.
        for (number, body) in scene.bodies().iter().enumerate() {
            let saved =
                frame[number] + self.follow(number, body)[place(StructureKind::Tree)].seconds();
            let coarse = self.coarse_construction(number, body).seconds();
            if coarse >= frames * saved && !self.present[number].has(StructureKind::Coarse) {
                self.useless[number] = self.useless[number].with(COARSE);
            }
        }
    }
}
