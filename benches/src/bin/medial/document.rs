//! The document that says how accurate medial surfaces are.

/// Its text, of the tables below its headings.
pub(crate) fn text(accuracy: &str, deformation: &str, detection: &str) -> String {
    format!("{HEAD}\n{accuracy}{DEFORMATION}\n{deformation}{DETECTION}\n{detection}")
}

const HEAD: &str = "\
# Accuracy of medial surfaces

Written by `cargo run --release -p benches --bin medial docs/accuracy-medial.md`, with the Visible Human Female's left thigh in the folder of
`MUSCULO_DATA`. All lengths are in mm.

## By number of balls

![Error of medial surfaces over their number of balls](chart/medial.svg)

`cargo xtask chart medial` draws this from the table.

*rms* and *95 %* are of the signed distance of the union of balls over the surface, at its vertices by their areas. *surface to balls* and
*balls to surface* are the bounds that `Deviation` gives: no point of the surface is farther outside of the balls, and no ball reaches farther
out of the surface; beside each, the most that 100,000 samples apart from those of the fit and of the bound showed. Parts and holes are
counted on a grid of 1 mm. *s* is time of one thread of a processor for one row, with what it needs of the common start. *extent* is the
diagonal of the box around the muscle.
";

const DEFORMATION: &str = "
## Following deformation

Root mean square of the same distance after the surface has been deformed: at rest, with the centres carried along and radii as they were, and
with centres and radii refitted; beside each, the larger of the two bounds. Stretched and shortened muscles keep their volume.
";

const DETECTION: &str = "
## Detection

Neighbouring muscles that touch at rest, pushed 1 and 3 mm into each other. *surfaces* projects the vertices of one on the faces of the other
that may be within 1 mm, which is not yet to tell which are inside; *vertices × balls* finds the vertices inside with their depths, for the
exact foot and for that on the bare face; *balls × balls* finds all pairs of primitives that overlap. Counted are tests of four bounds of nine
directions each, tests of single directions, and leaves: distances of a point from a face, or of a point or a primitive from a primitive.
Directions are cheaper than leaves, that of the plane which touches a slab's balls less so than others. Depths are compared with exact ones,
and vertices missed are those inside that are not inside of the balls: with the bound on the distance from surface to balls as reach, none is,
unless the union has a void there.
";
