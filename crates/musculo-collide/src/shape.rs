//! A surface where it is, with the tree of bounds over its faces.

use glam::DVec3;
use kdop::{Leaves, Tree, TreeError};
use surface::TriangleSurface;

use crate::{BodyKind, NoInside, pair};

/// What detection sees of a body.
#[derive(Debug)]
pub(crate) struct Shape {
    surface: TriangleSurface,
    positions: Vec<DVec3>,
    no_inside: Option<NoInside>,
    /// The first vertex of each connected part, found with the tree.
    parts: Vec<u32>,
    tree: Option<Tree>,
    bounds: Bounds,
}

/// What a shape's tree bounds at present.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Bounds {
    /// Nothing, or positions that are no longer those of the shape.
    Stale,
    /// The shape where it is.
    State,
    /// The shape's way to somewhere else.
    Sweep,
}

impl Shape {
    /// A surface at positions that were checked to fit it.
    pub(crate) fn new(kind: BodyKind, surface: TriangleSurface, positions: Vec<DVec3>) -> Self {
        let no_inside = NoInside::find(kind, &surface);
        let parts = Vec::new();
        Self { surface, positions, no_inside, parts, tree: None, bounds: Bounds::Stale }
    }

    pub(crate) fn surface(&self) -> &TriangleSurface {
        &self.surface
    }

    pub(crate) fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.surface.faces()[face as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// Whether counting crossings tells an inside, or why not.
    pub(crate) fn has_inside(&self) -> Result<(), NoInside> {
        self.no_inside.map_or(Ok(()), Err)
    }

    /// Rewrites the positions, as many as there are; the tree follows when it
    /// is next asked to.
    pub(crate) fn positions_mut(&mut self) -> &mut [DVec3] {
        self.bounds = Bounds::Stale;
        &mut self.positions
    }

    /// The first vertex of each connected part; the tree must have been built.
    pub(crate) fn parts(&self) -> impl Iterator<Item = u32> {
        self.parts.iter().copied()
    }

    /// The tree over its faces, which must have been brought up to date.
    pub(crate) fn tree(&self) -> &Tree {
        self.tree.as_ref().expect("trees are built before pairs are looked at")
    }

    /// Bytes of its tree, if there is one.
    pub(crate) fn tree_bytes(&self) -> usize {
        self.tree.as_ref().map_or(0, Tree::bytes)
    }

    /// Bytes of its positions, its faces and its tree.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&self.positions[..]) + size_of_val(self.surface.faces()) + self.tree_bytes()
    }

    /// Brings the tree to the present state.
    pub(crate) fn bound_state(&mut self) -> Result<(), TreeError> {
        if self.bounds == Bounds::State {
            return Ok(());
        }
        match &mut self.tree {
            Some(tree) => tree.refit(&self.positions)?,
            None => self.build_tree()?,
        }
        self.bounds = Bounds::State;
        Ok(())
    }

    /// Brings the tree around the way from the present state to `x1`.
    pub(crate) fn bound_sweep(&mut self, x1: &[DVec3]) -> Result<(), TreeError> {
        if self.tree.is_none() {
            self.build_tree()?;
        }
        if let Some(tree) = &mut self.tree {
            tree.refit_swept(&self.positions, x1)?;
        }
        self.bounds = Bounds::Sweep;
        Ok(())
    }

    fn build_tree(&mut self) -> Result<(), TreeError> {
        self.parts = pair::parts(&self.surface);
        self.tree = Some(Tree::build(Leaves::Triangles(self.surface.faces()), &self.positions)?);
        Ok(())
    }
}
