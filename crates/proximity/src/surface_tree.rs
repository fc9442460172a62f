//! A surface at finite positions, with a bounding volume tree over its faces.

use std::sync::Arc;

use glam::DVec3;
use kdop::{Leaves, StepTree, Tree, TreeError};
use surface::{PositionBuffer, Positions, SurfaceError, TriangleSurface, triangle};

use crate::inverted_parts::InvertedParts;
use crate::{NoInside, ProximityError};

/// Widths of a tree's bounds, relative to those when it was built, above which it is built anew.
///
/// Smaller builds more often, for ten times a refit, and for a shape that a motion there and back
/// leaves again (`cargo run --release -p benches -- trees`); larger leaves traversals with more to
/// visit where a motion stays. The next build takes as much growth again, so that frames between
/// pay for it.
const MAX_LOOSENESS: f64 = 4.0;

/// A triangle surface at finite positions, with a bounding volume tree over its faces.
///
/// Surface, positions and tree always fit each other.
#[derive(Clone, Debug)]
pub struct SurfaceTree {
    surface: Arc<TriangleSurface>,
    positions: PositionBuffer,
    tree: Tree,
    no_inside: Option<NoInside>,
    /// Found with the first tree.
    no_winding_number: Option<NoInside>,
    is_inside_out: bool,
    /// Found with the first tree.
    inverted_parts: InvertedParts,
}

/// A [`SurfaceTree`] whose tree is built at the first use and refit after moves.
///
/// For surfaces that move often and are queried seldom: [`fit`](Self::fit) does the work that is
/// left, and does nothing where the tree is up to date. Positions are held once.
#[derive(Clone, Debug)]
pub struct LazySurfaceTree {
    inner: SurfaceTree,
    fit: Fit,
    /// Bounds of the faces at the end of the last step that was fitted, in the arrangement of the
    /// tree.
    end_tree: Option<Tree>,
    /// True if that step begins at the present positions.
    has_step: bool,
}

/// State of a lazy tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fit {
    Unbuilt,
    /// The tree bounds earlier positions.
    Stale,
    Current,
}

impl SurfaceTree {
    /// Builds a tree over a surface at `positions` (|V|).
    ///
    /// # Errors
    ///
    /// [`ProximityError::Surface`] where the positions do not fit the surface or are not finite,
    /// and [`ProximityError::Tree`] for 2³⁰ faces and more.
    pub fn new(
        surface: impl Into<Arc<TriangleSurface>>,
        positions: Vec<DVec3>,
    ) -> Result<Self, ProximityError> {
        let mut lazy = LazySurfaceTree::new(surface, positions)?;
        lazy.fit()?;
        Ok(lazy.inner)
    }

    /// Declares the surface open: nothing is inside it, whatever its edges say.
    #[must_use]
    pub fn declared_open(self) -> Self {
        let reason = Some(NoInside::DeclaredOpen);
        let inverted_parts = InvertedParts::default();
        let is_inside_out = false;
        Self { no_inside: reason, no_winding_number: reason, is_inside_out, inverted_parts, ..self }
    }

    /// Moves all vertices, and refits the tree; where it has become too loose it is built anew.
    /// Allocates nothing but then.
    ///
    /// The iterator is run twice: values are checked before the first is written.
    ///
    /// # Errors
    ///
    /// [`ProximityError::Surface`] where the positions do not fit the surface or are not finite;
    /// nothing has then changed.
    pub fn set_positions(
        &mut self,
        positions: impl Iterator<Item = DVec3> + Clone,
    ) -> Result<(), ProximityError> {
        self.positions.overwrite(positions)?;
        // Positions that the buffer has taken are ones that the tree takes.
        let x = self.positions.as_positions().as_slice();
        refit(&mut self.tree, &self.surface, x, &|| true)?;
        Ok(())
    }

    /// Returns the surface.
    #[must_use]
    pub fn surface(&self) -> &TriangleSurface {
        &self.surface
    }

    /// Returns the surface, shared.
    #[must_use]
    pub fn shared_surface(&self) -> Arc<TriangleSurface> {
        Arc::clone(&self.surface)
    }

    /// Returns the positions of the vertices.
    #[must_use]
    #[inline]
    pub fn positions(&self) -> Positions<'_> {
        self.positions.as_positions()
    }

    /// Returns the position of one vertex.
    ///
    /// # Panics
    ///
    /// When `vertex` is not below the surface's vertex count.
    #[must_use]
    #[inline]
    pub fn position(&self, vertex: u32) -> DVec3 {
        self.positions().at(vertex)
    }

    /// Returns the corners of one face.
    ///
    /// # Panics
    ///
    /// When `face` is not below the surface's face count.
    #[must_use]
    #[inline]
    pub fn corners(&self, face: u32) -> [DVec3; 3] {
        self.positions().corners(self.surface.faces()[face as usize])
    }

    /// Returns the tree over the faces.
    #[must_use]
    #[inline]
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Checks that "inside" is defined.
    ///
    /// Ray parity is defined for any surface whose edges all have an even number of faces, of
    /// whatever orientation.
    ///
    /// # Errors
    ///
    /// [`NoInside`] where the surface was declared open, or has an edge with an odd number of
    /// faces.
    pub fn has_inside(&self) -> Result<(), NoInside> {
        self.no_inside.map_or(Ok(()), Err)
    }

    /// Returns true if the surface is inside out: its faces looked inward when it was made, so that they
    /// enclosed a negative volume. False without an inside, or without a volume beyond rounding.
    #[must_use]
    pub fn is_inside_out(&self) -> bool {
        self.is_inside_out
    }

    /// Returns the sign by which normals of faces point outward.
    pub(crate) fn orientation(&self) -> f64 {
        if self.is_inside_out { -1.0 } else { 1.0 }
    }

    /// Checks that winding numbers are defined: as [`has_inside`](Self::has_inside), and that as many
    /// faces run along each edge in one direction as in the other.
    ///
    /// # Errors
    ///
    /// [`NoInside`] with the first edge that is open or misoriented.
    pub fn has_winding_number(&self) -> Result<(), NoInside> {
        self.no_winding_number.map_or(Ok(()), Err)
    }

    /// Returns the smallest vertex of each closed part whose faces look to the wrong side, ascending:
    /// outward inside another part, so that places are covered twice, or inward where no part is around
    /// it. As when the tree was first built; parts that cross or touch each other everywhere are left
    /// out. None where winding numbers are undefined.
    ///
    /// ```
    /// use proximity::SurfaceTree;
    ///
    /// // A cavity that is given the wrong way round.
    /// let [outer, cavity] = [10.0, 6.0].map(fixtures::shapes::cube);
    /// let wrong = outer.clone().joined(&cavity);
    /// let tree = SurfaceTree::new(wrong.surface(), wrong.positions)?;
    /// assert_eq!(tree.inverted_parts(), [8]);
    ///
    /// let right = outer.joined(&cavity.flipped());
    /// let tree = SurfaceTree::new(right.surface(), right.positions)?;
    /// assert!(tree.inverted_parts().is_empty());
    /// # Ok::<(), proximity::ProximityError>(())
    /// ```
    #[must_use]
    pub fn inverted_parts(&self) -> &[u32] {
        &self.inverted_parts.roots
    }

    /// Returns true if the closed part of a vertex has a place beside it that the surface covers more
    /// than once, or inside out, as [`inverted_parts`](Self::inverted_parts) have. So have parts in
    /// these, though they may look to the right side.
    #[must_use]
    #[inline]
    pub fn is_beside_doubled_place(&self, vertex: u32) -> bool {
        let Self { inverted_parts, .. } = self;
        inverted_parts.is_beside_doubled.get(vertex as usize).copied().unwrap_or(false)
    }

    /// Returns the memory of positions, faces and tree, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.positions().as_slice())
            + size_of_val(self.surface.faces())
            + self.tree.bytes()
    }
}

/// Refits a tree to positions, or builds it anew where it has become too loose; returns true then,
/// and `None` where `keep_going` ends that: the tree is refit.
fn refit(
    tree: &mut Tree,
    surface: &TriangleSurface,
    x: &[DVec3],
    keep_going: &dyn Fn() -> bool,
) -> Result<Option<bool>, TreeError> {
    tree.refit(x)?;
    if tree.looseness() <= MAX_LOOSENESS {
        return Ok(Some(false));
    }
    let leaves = Leaves::Triangles(surface.faces());
    let Some(built) = Tree::build_while(leaves, x, keep_going)? else { return Ok(None) };
    *tree = built;
    Ok(Some(true))
}

/// Returns true if a closed surface has a negative volume, beyond the rounding of coordinates.
fn looks_inward(surface: &TriangleSurface, x: Positions<'_>) -> bool {
    let Some(&origin) = x.as_slice().first() else { return false };
    let corners = || surface.faces().iter().map(|&face| x.corners(face));
    let volume = triangle::signed_volume(corners(), origin);
    let largest = x.as_slice().iter().map(|x| x.abs().max_element()).fold(0.0, f64::max);
    let area: f64 = corners().map(triangle::area).sum();
    -volume > f64::EPSILON * largest * area
}

impl LazySurfaceTree {
    /// Takes a surface at `positions` (|V|). Nothing is built.
    ///
    /// # Errors
    ///
    /// [`SurfaceError`] where the positions do not fit the surface or are not finite.
    pub fn new(
        surface: impl Into<Arc<TriangleSurface>>,
        positions: Vec<DVec3>,
    ) -> Result<Self, SurfaceError> {
        let surface = surface.into();
        let no_inside = NoInside::find(&surface);
        let positions = surface.own_positions(positions)?;
        let inner = SurfaceTree {
            is_inside_out: no_inside.is_none() && looks_inward(&surface, positions.as_positions()),
            positions,
            no_winding_number: no_inside,
            no_inside,
            inverted_parts: InvertedParts::default(),
            tree: Tree::default(),
            surface,
        };
        Ok(Self { inner, fit: Fit::Unbuilt, end_tree: None, has_step: false })
    }

    /// Declares the surface open: nothing is inside it, whatever its edges say.
    #[must_use]
    pub fn declared_open(self) -> Self {
        Self { inner: self.inner.declared_open(), ..self }
    }

    /// Moves all vertices. The tree follows at the next [`fit`](Self::fit).
    ///
    /// The iterator is run twice: values are checked before the first is written.
    ///
    /// # Errors
    ///
    /// [`SurfaceError`] where the positions do not fit the surface or are not finite; nothing has
    /// then changed.
    pub fn set_positions(
        &mut self,
        positions: impl Iterator<Item = DVec3> + Clone,
    ) -> Result<(), SurfaceError> {
        self.inner.positions.overwrite(positions)?;
        self.has_step = false;
        if self.fit == Fit::Current {
            self.fit = Fit::Stale;
        }
        Ok(())
    }

    /// Returns the surface tree, built or refit where it is not up to date.
    ///
    /// # Errors
    ///
    /// [`TreeError`] for 2³⁰ faces and more.
    pub fn fit(&mut self) -> Result<&SurfaceTree, TreeError> {
        self.fit_while(&|| true)?;
        Ok(&self.inner)
    }

    /// Builds or refits the tree where it is not up to date, as [`fit`](Self::fit), while
    /// `keep_going` returns true; returns false where it does not, with a tree that is not up to
    /// date.
    ///
    /// # Errors
    ///
    /// As [`fit`](Self::fit).
    pub fn fit_while(&mut self, keep_going: &dyn Fn() -> bool) -> Result<bool, TreeError> {
        let SurfaceTree { surface, positions, tree, no_winding_number, inverted_parts, .. } =
            &mut self.inner;
        let x = positions.as_positions().as_slice();
        match self.fit {
            Fit::Current => {}
            Fit::Stale => {
                // The tree of an end has the arrangement of the surface tree.
                match refit(tree, surface, x, keep_going)? {
                    Some(true) => self.end_tree = None,
                    Some(false) => {}
                    None => return Ok(false),
                }
            }
            Fit::Unbuilt => {
                let leaves = Leaves::Triangles(surface.faces());
                let Some(built) = Tree::build_while(leaves, x, keep_going)? else {
                    return Ok(false);
                };
                *tree = built;
                *no_winding_number =
                    no_winding_number.or_else(|| NoInside::find_misoriented(surface));
                if no_winding_number.is_none() {
                    *inverted_parts = InvertedParts::find(surface, positions.as_positions(), tree);
                }
            }
        }
        self.fit = Fit::Current;
        Ok(true)
    }

    /// Returns true if there is a tree, be it up to date or not.
    #[must_use]
    pub fn is_built(&self) -> bool {
        self.fit != Fit::Unbuilt
    }

    /// Bounds the faces over a step, in which every vertex moves on a straight line from its present
    /// position to `end`. The surface tree is brought up to date.
    ///
    /// # Errors
    ///
    /// As [`fit`](Self::fit), and [`TreeError::WrongLength`] where `end` is of another surface.
    pub fn fit_step(&mut self, end: Positions<'_>) -> Result<(), TreeError> {
        self.fit()?;
        let tree = &self.inner.tree;
        self.end_tree.get_or_insert_with(|| tree.clone()).refit(end.as_slice())?;
        self.has_step = true;
        Ok(())
    }

    /// Returns the bounds over the last step that was [fitted](Self::fit_step); `None` after a move.
    #[must_use]
    pub fn step_tree(&self) -> Option<StepTree<'_>> {
        let end_tree = self.end_tree.as_ref().filter(|_| self.has_step);
        StepTree::new(self.fitted()?.tree(), end_tree?)
    }

    /// Returns the surface tree where it is up to date; `None` before the first
    /// [`fit`](Self::fit), and after a move.
    #[must_use]
    pub fn fitted(&self) -> Option<&SurfaceTree> {
        (self.fit == Fit::Current).then_some(&self.inner)
    }

    /// Returns the connectivity, shared with whoever keeps it.
    #[must_use]
    pub fn shared_surface(&self) -> Arc<TriangleSurface> {
        self.inner.shared_surface()
    }

    /// Returns the surface.
    #[must_use]
    pub fn surface(&self) -> &TriangleSurface {
        self.inner.surface()
    }

    /// Returns the positions of the vertices.
    #[must_use]
    pub fn positions(&self) -> Positions<'_> {
        self.inner.positions()
    }

    /// Checks that "inside" is defined, as [`SurfaceTree::has_inside`].
    ///
    /// # Errors
    ///
    /// As [`SurfaceTree::has_inside`].
    pub fn has_inside(&self) -> Result<(), NoInside> {
        self.inner.has_inside()
    }

    /// Returns true if the surface is inside out, as [`SurfaceTree::is_inside_out`].
    #[must_use]
    pub fn is_inside_out(&self) -> bool {
        self.inner.is_inside_out()
    }
}
