//! Which nodes are inside, by the rule that was asked for.

use surface::{Positions, SurfaceError, TriangleSurface};

use crate::crossings::{Crossing, by_row};
use crate::grid::Grid;
use crate::inside::Inside;
use crate::winding::{Winding, face_crossings, winding};
use crate::{FieldError, SignRule, flood};

/// Inside, and what the rule found out about the surface.
pub(crate) struct Signed {
    pub(crate) inside: Inside,
    /// What the winding number knows besides.
    pub(crate) winding: Option<Winding>,
}

/// What stops a flood.
#[derive(Clone, Copy)]
pub(crate) enum Barrier<'a> {
    /// Voxels that are switched on.
    Voxels(&'a [bool]),
    /// The surface itself, between and at nodes, given squared distances of
    /// these in spacings.
    Surface(&'a [f32]),
}

pub(crate) fn sign(
    rule: SignRule,
    surface: &TriangleSurface,
    x: Positions<'_>,
    grid: &Grid,
    barrier: Barrier<'_>,
) -> Result<Signed, FieldError> {
    match rule {
        SignRule::Winding => {
            let mut winding = winding(surface, x, grid);
            let inside = std::mem::take(&mut winding.inside);
            Ok(Signed { inside, winding: Some(winding) })
        }
        SignRule::Parity => {
            check_closed(surface, "parity")?;
            let crossings = face_crossings(surface, x, grid);
            let rows = grid.dims()[1] * grid.dims()[2];
            let inside = Inside::from_rows(by_row(&crossings, rows).map(odd), Vec::new());
            Ok(Signed { inside, winding: None })
        }
        SignRule::Flood => {
            check_closed(surface, "flood")?;
            let mask = match barrier {
                Barrier::Voxels(voxels) => flood::behind_voxels(voxels, grid.dims()),
                Barrier::Surface(squared) => flood::behind_links(surface, x, grid, squared)?,
            };
            Ok(Signed { inside: Inside::from_mask(&mask, grid.dims()[0]), winding: None })
        }
    }
}

/// Nodes at which the parity of a row's crossings changes.
fn odd(row: &[Crossing]) -> Vec<usize> {
    let here = row.chunk_by(|a, b| a.node == b.node);
    here.filter(|here| here.len() % 2 == 1).map(|here| here[0].node).collect()
}

/// Every edge has an even number of faces: nothing leads around the surface.
fn check_closed(surface: &TriangleSurface, rule: &'static str) -> Result<(), FieldError> {
    let is_open = |edge: &u32| surface.edge_faces(*edge).len() % 2 == 1;
    let mut open = (0..).take(surface.edges().len()).filter(is_open);
    let Some(first) = open.next() else {
        return Ok(());
    };
    let [from, to] = surface.edges()[first as usize];
    let face = surface.edge_faces(first)[0];
    let source = SurfaceError::Open { count: 1 + open.count(), from, to, face };
    Err(FieldError::Sign { rule, source })
}
