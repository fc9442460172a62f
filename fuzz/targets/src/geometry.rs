//! Geometry of arbitrary numbers.

use ccd::{CcdContact, CcdError, CcdParams, Certainty};
use distance_field::{DistanceField, FieldGrid, Interpolation, Storage};
use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};

use crate::bytes::Bytes;

type Query = fn([DVec3; 4], [DVec3; 4], &CcdParams) -> Result<Option<CcdContact>, CcdError>;

/// Runs one continuous query in floating point, exactly, and with a separation.
///
/// # Panics
///
/// Where a contact interval leaves the step, or where a contact that exact arithmetic
/// proves is missed or found late.
#[must_use]
pub fn ccd(bytes: &[u8]) -> bool {
    let mut bytes = Bytes::new(bytes);
    let query: Query =
        if bytes.byte().is_multiple_of(2) { ccd::vertex_face } else { ccd::edge_edge };
    let separation = if bytes.byte().is_multiple_of(2) { 0.0 } else { bytes.coordinate().abs() };
    let (x0, x1) = (bytes.points(), bytes.points());

    let params = CcdParams { max_directions: 50, ..CcdParams::DEFAULT };
    let Ok(found) = query(x0, x1, &params) else { return false };
    let exact = query(x0, x1, &CcdParams { max_directions: 50, ..CcdParams::EXACT });
    let exact = exact.expect("both ways refuse the same input");
    for contact in found.iter().chain(&exact) {
        let CcdContact { lo, hi, .. } = *contact;
        assert!((0.0..=1.0).contains(&lo) && lo <= hi && hi <= 1.0, "{lo} {hi}: {x0:?} {x1:?}");
    }

    let certain = exact.filter(|exact| exact.certainty == Certainty::Certain);
    if let Some(exact) = certain {
        let lo = found.map_or(f64::INFINITY, |found| found.lo);
        assert!(lo <= exact.hi, "missed or late: {lo} after {}: {x0:?} {x1:?}", exact.hi);
    }
    let apart = CcdParams { min_separation: separation, ..params };
    if let Ok(kept) = query(x0, x1, &apart) {
        let is_kept = certain.is_none() || kept.is_some();
        assert!(is_kept, "missed by a separation of {separation}: {x0:?} {x1:?}");
    }
    true
}

/// Builds a tree over triangles, refits it to moved and to swept positions.
///
/// # Panics
///
/// Where a tree is invalid, or loses a pair of faces that have a vertex in common.
#[must_use]
pub fn kdop(bytes: &[u8]) -> bool {
    let mut bytes = Bytes::new(bytes);
    let count = usize::from(bytes.byte() % 40);
    let points: Vec<DVec3> = (0..3 + count).map(|_| bytes.point()).collect();
    let moved: Vec<DVec3> = points.iter().map(|p| *p + bytes.point()).collect();
    let mut corner = || u32::from(bytes.byte()) % 43;
    let faces: Vec<[u32; 3]> = (0..count).map(|_| [corner(), corner(), corner()]).collect();

    let Ok(mut tree) = Tree::build(Leaves::Triangles(&faces), &points) else { return false };
    tree.validate().expect("a tree that was built");
    let same = tree.clone();
    check_pairs(&tree, &same, &faces);

    if tree.refit(&moved).is_ok() {
        tree.validate().expect("a tree that was refitted");
    }
    if tree.refit_swept(&points, &moved).is_ok() {
        tree.validate().expect("a tree that was swept");
        check_pairs(&tree, &same, &faces);
    }
    true
}

/// Checks that faces with a common vertex are among the pairs.
fn check_pairs(tree: &Tree, other: &Tree, faces: &[[u32; 3]]) {
    let mut found = Vec::new();
    tree.pairs(other, 0.0, &mut Workspace::default(), |a, b| found.push((a, b)));
    found.sort_unstable();
    for (i, f) in (0..).zip(faces) {
        for (j, g) in (0..).zip(faces) {
            let shares = f.iter().any(|corner| g.contains(corner));
            assert!(!shares || found.binary_search(&(i, j)).is_ok(), "{i} and {j} of {faces:?}");
        }
    }
}

/// Builds a field of arbitrary values, and evaluates it.
///
/// # Panics
///
/// Where a trilinear distance lies outside of the range of the values.
pub fn field(bytes: &[u8]) -> bool {
    let mut bytes = Bytes::new(bytes);
    let dims: [usize; 3] = std::array::from_fn(|_| usize::from(bytes.byte() % 6));
    let spacing = bytes.coordinate();
    let Ok(grid) = FieldGrid::new(bytes.point(), spacing, dims) else { return false };

    #[expect(clippy::cast_possible_truncation, reason = "fields store single precision")]
    let values: Vec<f32> = (0..grid.node_count()).map(|_| bytes.coordinate() as f32).collect();
    let storage = if bytes.byte().is_multiple_of(2) {
        Storage::Float
    } else {
        Storage::Quantized { step: bytes.coordinate() }
    };
    let min = values.iter().copied().fold(f32::INFINITY, f32::min);
    let max = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let Ok(field) = DistanceField::from_values(grid, values, storage) else { return false };

    let rounding = if let Storage::Quantized { step } = storage { 0.5 * step } else { 0.0 };
    let slack = rounding + 1e-6 * f64::from(max.abs().max(min.abs()));
    for _ in 0..8 {
        let p = bytes.point();
        if let Some(sample) = field.evaluate(p, Interpolation::Trilinear) {
            let distance = sample.distance;
            let low = f64::from(min) - slack;
            assert!(low <= distance && distance <= f64::from(max) + slack, "{distance} at {p}");
        }
        let _ = field.evaluate(p, Interpolation::Smooth);
    }
    true
}
