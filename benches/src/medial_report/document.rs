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

*rms* and *95 %* are of the signed distance of the union of balls over the surface, at its vertices by their areas. *surface to balls* and
*balls to surface* are bounds on the directed Hausdorff distances: no point of the surface is farther outside of the balls, and no point of
the balls farther outside of the surface. Beside each is the maximum over 100,000 samples, other ones than those of the fit and of the
bound. Parts and holes are counted on a grid of 1 mm. *s* is the processor time to generate the row alone, on one thread. *extent* is the
diagonal of the muscle's bounding box.
";

const DEFORMATION: &str = "
## Following deformation

Root mean square of the same distance after the surface has been deformed: at rest, with moved centers and constant radii, and with refitted
centers and radii. Beside each is the larger of the two bounds. Stretched and shortened muscles keep their volume.
";

const DETECTION: &str = "
## Detection

Neighboring muscles that touch at rest, pushed 1 and 3 mm into each other. *surfaces* projects the vertices of one on the faces of the other
within 1 mm, which does not yet decide which vertices are inside. *vertices × balls* finds the vertices inside with their depths, for the
exact foot and for that on the bare face; *balls × balls* finds all pairs of primitives that overlap. Counted are tests of four bounds of nine
directions each, tests of single directions, and leaves: distances of a point from a face, or of a point or a primitive from a primitive.
A direction costs less than a leaf; that of the plane which touches a slab's balls costs more than the others. Depths are compared with
exact ones. Vertices missed are those inside the muscle and outside the balls: with the bound on the distance from surface to balls as margin,
none is missed unless the union has a void there.
";
