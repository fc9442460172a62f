//! Attachments of bodies that do not come apart: tissue that is held cannot give way.

use std::collections::BTreeSet;

use musculo_collide::{BodyId, Conditions, Scene};
use serde::Serialize;

use super::text::grouped;

/// Attachments of a body.
#[derive(Debug, Serialize)]
pub(super) struct AttachmentRecord {
    body: String,
    /// Bodies that it is tied to, in the order of the scene.
    tied_to: Vec<String>,
    fixed_vertices: usize,
    /// True for those of `tied_to` that are rigid.
    #[serde(skip)]
    is_rigid: Vec<bool>,
}

impl AttachmentRecord {
    /// Lists the soft bodies that `is_left` selects and that are attached to anything.
    pub(super) fn list(
        conditions: &Conditions,
        scene: &Scene,
        is_left: impl Fn(&str) -> bool,
    ) -> Vec<Self> {
        let mut records = Vec::new();
        for id in scene.ids() {
            let body = scene.body(id);
            if body.is_rigid() || !is_left(body.name()) {
                continue;
            }
            let record = Self::new(id, conditions, scene);
            if !record.tied_to.is_empty() || record.fixed_vertices > 0 {
                records.push(record);
            }
        }
        records
    }

    fn new(id: BodyId, conditions: &Conditions, scene: &Scene) -> Self {
        // Two ties may be of one pair, and selections may have vertices in common.
        let name = |id: BodyId| scene.body(id).name().to_owned();
        let mut tied_to = BTreeSet::new();
        for tie in &conditions.ties {
            match tie.bodies {
                [a, b] if a == id => tied_to.insert(b),
                [a, b] if b == id => tied_to.insert(a),
                _ => false,
            };
        }
        let fixed = conditions.fixed.iter().filter(|fixed| fixed.body == id);
        let fixed: BTreeSet<u32> = fixed.flat_map(|fixed| &fixed.vertices).copied().collect();
        let is_rigid = tied_to.iter().map(|id| scene.body(*id).is_rigid()).collect();
        let tied_to = tied_to.into_iter().map(name).collect();
        Self { body: name(id), tied_to, fixed_vertices: fixed.len(), is_rigid }
    }

    pub(super) fn text(&self) -> String {
        let tied_to = |rigid: bool| {
            let names = self.tied_to.iter().zip(&self.is_rigid);
            let names: Vec<&str> = names
                .filter_map(|(name, is_rigid)| (*is_rigid == rigid).then_some(name.as_str()))
                .collect();
            (!names.is_empty()).then(|| format!("tied to {}", names.join(" and ")))
        };
        let fixed = (self.fixed_vertices > 0)
            .then(|| format!("fixed at {} of its vertices", grouped(self.fixed_vertices)));
        let held: Vec<String> = tied_to(true).into_iter().chain(fixed).collect();

        // What is tied to soft bodies alone gives way, but not by itself.
        let mut sentences = Vec::new();
        if !held.is_empty() {
            let held = held.join(" and ");
            sentences.push(format!("{} is {held}: what is held there cannot give way", self.body));
        }
        if let Some(tied) = tied_to(false) {
            sentences.push(format!("{} is {tied}: they give way together there", self.body));
        }
        sentences.join(". ")
    }
}
