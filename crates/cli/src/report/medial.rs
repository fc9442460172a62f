//! What is told of a medial surface: its balls, how near they come, its topology.

use musculo_collide::medial::{Deviation, MedialSurface, Topology};
use serde::Serialize;

use super::text::{counted, grouped, measure};

/// A medial surface and the surface it was made of; lengths are in the unit of the
/// mesh.
#[derive(Debug, Serialize)]
pub(crate) struct MedialRecord {
    pub(crate) file: String,
    pub(crate) vertices: usize,
    pub(crate) faces: usize,
    pub(crate) balls: usize,
    pub(crate) slabs: usize,
    pub(crate) cones: usize,
    pub(crate) isolated_balls: usize,
    pub(crate) deviation: Deviation,
    /// Of the union of balls; none where it was not counted.
    pub(crate) union: Option<Topology>,
    /// Of the inside of the surface.
    pub(crate) inside: Option<Topology>,
}

impl MedialRecord {
    pub(crate) fn new(
        file: String,
        [vertices, faces]: [usize; 2],
        medial: &MedialSurface,
        deviation: Deviation,
        [union, inside]: [Option<Topology>; 2],
    ) -> Self {
        Self {
            file,
            vertices,
            faces,
            balls: medial.balls().len(),
            slabs: medial.slabs().len(),
            cones: medial.cones().len(),
            isolated_balls: medial.isolated_balls().len(),
            deviation,
            union,
            inside,
        }
    }
}

/// The whole report but for the time, which no two runs share.
pub(crate) fn medial_table(record: &MedialRecord) -> String {
    let Deviation { surface_to_medial: outside, medial_to_surface: over, rms, p95 } =
        record.deviation;
    let mut text = format!(
        "{}: {} vertices, {} faces\n",
        record.file,
        grouped(record.vertices),
        grouped(record.faces)
    );
    text += &format!(
        "  balls      {}, with {}, {} and {} alone\n",
        grouped(record.balls),
        counted(record.slabs, "slab"),
        counted(record.cones, "cone"),
        grouped(record.isolated_balls),
    );
    text += &format!(
        "  error      {} rms, {} at most at 95 % of the vertices\n",
        measure(rms),
        measure(p95)
    );
    text += &format!(
        "  surface    nowhere more than {} outside the balls ({} seen)\n",
        measure(outside.upper),
        measure(outside.lower)
    );
    text += &format!(
        "  balls      nowhere more than {} outside the surface ({} seen)\n",
        measure(over.upper),
        measure(over.lower)
    );
    text += &format!("  topology   {}\n", topology(record));
    text
}

fn topology(record: &MedialRecord) -> String {
    let words = |topology: &Topology| {
        let tunnels = usize::try_from(topology.tunnels).unwrap_or(0);
        format!(
            "{}, {}, {}",
            counted(topology.components, "part"),
            counted(tunnels, "tunnel"),
            if topology.cavities == 1 {
                "1 cavity".to_owned()
            } else {
                format!("{} cavities", grouped(topology.cavities))
            }
        )
    };
    match (&record.union, &record.inside) {
        (Some(union), Some(inside)) if union == inside => {
            format!("{}, as the surface", words(union))
        }
        (Some(union), Some(inside)) => {
            format!("{}, but the surface has {}", words(union), words(inside))
        }
        _ => "not counted".to_owned(),
    }
}
