//! Text of the document on the accuracy of medial surfaces.

/// Returns the document with its tables.
pub(super) fn text(accuracy: &str, deformation: &str, detection: &str) -> String {
    format!("{HEAD}\n{accuracy}{DEFORMATION}\n{deformation}{DETECTION}\n{detection}")
}

const HEAD: &str = "\
# Accuracy of medial surfaces

Written by `cargo run --release -p benches -- medial docs/accuracy-medial.md`, with the Visible Human Female's left thigh in the folder of
`MUSCULO_DATA`. All lengths are in mm.

## By number of balls

![Error of medial surfaces over their number of balls](chart/medial.svg)

`cargo xtask chart medial` draws this from the table.

- *muscle*: the muscle, *faces*: number of faces of its surface.
- *extent*: diagonal of the bounding box of the muscle.
- *balls*, *slabs*: numbers of balls and of slabs between three of them.
- *rms*: root mean square of the signed distance of the union of balls over the surface, at its vertices weighted by their areas.
- *95 %*: magnitude of that distance that 95 % of the vertices do not exceed.
- *surface to balls*: bound on the directed Hausdorff distance: no point of the surface is farther outside the balls.
- *balls to surface*: bound in the other direction: no point of the balls is farther outside the surface.
- *sampled*: maximum of the distance in the column before over 100,000 samples, other than those of the fit and of the bound.
- *parts and holes*: topology of the union, counted on a grid of 1 mm.
- *s*: processor time to generate the row alone, on one thread.

Below, per number of balls: *rms, median muscle* and *rms, max* over all muscles, the *target* of the rms, and the number of *muscles within*
it.
";

const DEFORMATION: &str = "
## Following deformation

Balls at rest, carried along a deformation of the surface. Stretched and shortened muscles keep their volume.

- *muscle*, *balls*, *deformation*: the muscle, its number of balls, and the deformation along its longest axis.
- *rest*: root mean square of the signed distance as above, before the deformation.
- *constant radii*: the same after it, with moved centers and the radii at rest.
- *refitted*: the same with refitted centers and radii.
- *bound*: larger of the two bounds on the directed Hausdorff distances in the state of the column before.
";

const DETECTION: &str = "
## Detection

Neighboring muscles that touch at rest, pushed into each other.

- *pair*: the muscle whose vertices are detected, and the other one; *push*: distance by which the first is pushed.
- *method*: *surfaces* projects the vertices on the faces of the other muscle within 1 mm, without deciding which are inside.
  *vertices × balls* finds the vertices inside with their depths, by the exact foot or that on the bare face. *balls × balls* finds all
  pairs of primitives that overlap.
- *balls*: number of balls of each muscle.
- *bounds*: number of tests of four bounds of nine directions each.
- *directions*: number of tests of single separating directions. Each costs less than a leaf; that of the plane that touches the balls of a
  slab costs more than the others.
- *leaves*: number of distances of a point from a face, or of a point or a primitive from a primitive.
- *µs*: minimum time of one detection.
- *depth error rms*: root mean square of the difference from exact depths, over the vertices that are found.
- *missed*: vertices inside the muscle and outside the balls, of all inside. With the bound on the distance from surface to balls as margin,
  none is missed unless the union has a void there.
- *deepest missed*: maximum exact depth of these.
";
