//! Times that B. Gilles (2007, section 4.7.2) gives, and what it says of methods that it does not
//! take, beside the same here and now.

mod bounding_volumes;

use std::fmt::Write;

use baselines::PlacedSurface;
use baselines::layered_depth::{self, LayeredDepthParams};
use baselines::spatial_hash::{self, SpatialHashParams};
use distance_field::{DistanceField, FieldParams};
use fixtures::femur::femur;
use fixtures::muscle::{Placement, scene};
use fixtures::shapes::icosphere;
use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use proximity::{PairProximity, SurfaceTree};
use rayon::{ThreadPoolBuildError, ThreadPoolBuilder};
use surface::mean_edge;
use surface::progress::Progress;

use crate::bodies::{body, depth};
use crate::measure::{Pace, interleave};

/// Rounds of what takes long, and budget of what does not \[ms\].
const ROUNDS: u32 = 5;
const BUDGET: u64 = 400;

/// Radius of spheres, and the way from one center to the other \[mm\].
const RADIUS: f64 = 30.0;
const APART: f64 = 58.0;

/// Pixels of images along the longer side.
const PIXELS: u32 = 256;

/// Returns the tables, measured on one thread.
///
/// # Errors
///
/// When no thread can be started.
pub fn tables() -> Result<String, ThreadPoolBuildError> {
    Ok(ThreadPoolBuilder::new().num_threads(1).build()?.install(measure))
}

fn measure() -> String {
    let mut text = String::from("| what | 2007 | here, one thread |\n|---|---|---|\n");
    trees(&mut text);
    fields(&mut text);
    text += "\n| other body, faces | size of its faces | hashing [ms] | tree [ms] | hashing / tree |\n|---|---|---|---|---|\n";
    hashing(&mut text);
    text += "\n| direction of contact, from the rays | largest depth by images [mm] | exact [mm] | images / exact |\n|---|---|---|---|\n";
    images(&mut text);
    text += "\n| bounding volume | numbers | pairs of volumes tested | pairs of faces left | time [us] | fitted to all [ms] |\n|---|---|---|---|---|---|\n";
    bounding_volumes::rows(&mut text);
    text
}

/// A tree over 6,500 faces: built, refitted, and one over the other.
fn trees(text: &mut String) {
    let muscle = scene(6500, Placement::Oblique).a;
    let faces = muscle.triangles.len();
    let build = || Tree::build(Leaves::Triangles(&muscle.triangles), &muscle.states[0]);
    let Ok(mut tree) = build() else { return };
    let mut turn = 0;
    let [built, refitted] = interleave(
        BUDGET,
        [
            ("built", &mut || build().map_or(0, |tree| tree.leaf_count())),
            ("refitted", &mut || {
                turn = 1 - turn;
                usize::from(tree.refit(&muscle.states[turn]).is_ok())
            }),
        ],
    );
    let [built, refitted] = [built, refitted].map(|time| 1e-6 * time);
    row(text, &format!("tree of {faces} faces, built"), "200 ms", &format!("{built:.2} ms"));
    row(text, "refitted", "10 ms", &format!("{refitted:.3} ms"));
    let ratio = format!("{:.0} times", built / refitted);
    row(text, "built over refitted", "10 times, in words; 20 by its times", &ratio);
}

/// A field of 1 mm of a bone of 80,000 vertices.
fn fields(text: &mut String) {
    let bone = femur(2.0);
    let surface = bone.surface();
    let Ok(x) = surface.positions(&bone.positions) else { return };
    let time = |params: FieldParams| {
        let pace = Pace::long_calls(1);
        let build = || DistanceField::build(&surface, x, &params, Progress::none());
        let mut least = f64::INFINITY;
        for _ in 0..ROUNDS {
            least = least.min(pace.call_time(|| build().map_or(0, |field| field.bytes())));
        }
        format!("{:.2} s", 1e-9 * least)
    };
    let what = format!("field at 1 mm of a bone of {} vertices", bone.positions.len());
    let voxel = time(FieldParams { samples: 0, ..FieldParams::voxel(1.0) });
    row(text, &format!("{what}, by voxels"), "7.5 + 1.5 + 2.5 s", &voxel);
    let exact = time(FieldParams { samples: 0, ..FieldParams::new(1.0) });
    row(text, &format!("{what}, exact near the surface"), "-", &exact);
}

fn row(text: &mut String, what: &str, source: &str, here: &str) {
    let _ = writeln!(text, "| {what} | {source} | {here} |");
}

/// Crossing faces of two spheres, one with ever finer faces, by hashing with cells of the mean edge
/// of both, and by trees.
fn hashing(text: &mut String) {
    let coarse = body(icosphere(RADIUS, 3));
    for level in 3..=6 {
        let other = icosphere(RADIUS, level).translated(DVec3::new(APART, 3.1, 2.3));
        let (faces, other) = (other.faces.len(), body(other));
        let edges = [&coarse, &other].map(|body| mean_edge(body.surface(), body.positions()));
        let params = SpatialHashParams::new(0.5 * (edges[0] + edges[1]));

        // Both find all pairs of faces that cross.
        let mut pair = PairProximity::default();
        let [hashed, by_tree] = interleave(
            BUDGET,
            [
                ("hashing", &mut || {
                    let found = spatial_hash::detect(placed(&coarse), placed(&other), &params);
                    found.ok().and_then(|found| found.crossing_faces).map_or(0, |faces| faces.len())
                }),
                ("tree", &mut || {
                    pair.compute(&coarse, &other, 0.0).expect("few faces are near");
                    pair.crossing_faces().len()
                }),
            ],
        );
        let _ = writeln!(
            text,
            "| {faces} | 1 / {:.0} | {:.2} | {:.2} | {:.1} |",
            edges[0] / edges[1],
            1e-6 * hashed,
            1e-6 * by_tree,
            hashed / by_tree,
        );
    }
}

/// Depths along rays where bodies touch in different directions from these.
fn images(text: &mut String) {
    let workspace = &mut Workspace::default();
    for degrees in [0.0_f64, 30.0, 45.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let way = DVec3::new(sin, 0.0, cos) * APART;
        let a = body(icosphere(RADIUS, 5));
        let b = body(icosphere(RADIUS, 5).rotated(DVec3::ONE, 0.07).translated(way));
        let params = LayeredDepthParams { resolution: PIXELS };
        let found = layered_depth::detect(placed(&a), placed(&b), &params).unwrap_or_default();

        // The deepest vertex of the first sphere, by its ray and by its closest point.
        let (mut by_rays, mut exact) = (0.0_f64, 0.0_f64);
        for inside in found.inside.into_iter().flat_map(|[of_a, _]| of_a) {
            by_rays = by_rays.max(inside.depth);
            exact = exact.max(depth(&b, a.position(inside.vertex), workspace));
        }
        let ratio = by_rays / exact;
        let _ = writeln!(text, "| {degrees}° | {by_rays:.2} | {exact:.2} | {ratio:.2} |");
    }
}

fn placed(body: &SurfaceTree) -> PlacedSurface<'_> {
    PlacedSurface { surface: body.surface(), x: body.positions() }
}
