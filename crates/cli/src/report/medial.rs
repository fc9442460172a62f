//! Report of a medial surface: its balls, its deviation, its topology.

use musculo_collide::medial::{Deviation, Topology};
use serde::Serialize;

use super::text::{counted, grouped, measure};

/// Medial surface and the surface that it approximates; lengths are in the unit of the
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
    /// Topology of the union of balls; none where they are too small for the grid.
    pub(crate) union: Option<Topology>,
    /// Topology of the inside of the surface.
    pub(crate) inside: Topology,
}

impl MedialRecord {
    /// Writes the report, without the time, which differs between runs.
    pub(crate) fn to_text(&self) -> String {
        // Each direction has a proved bound, and a value that is reached.
        let Deviation { surface_to_medial: uncovered, medial_to_surface: excess, rms, p95 } =
            self.deviation;
        format!(
            "{}: {} vertices, {} faces\n\
             \x20 balls      {}, with {}, {} and {}\n\
             \x20 error      {} rms, 95 % of the vertices within {}\n\
             \x20 surface    at most {} outside the balls (at least {})\n\
             \x20 balls      at most {} outside the surface (at least {})\n\
             \x20 topology   {}\n",
            self.file,
            grouped(self.vertices),
            grouped(self.faces),
            grouped(self.balls),
            counted(self.slabs, "slab"),
            counted(self.cones, "cone"),
            counted(self.isolated_balls, "isolated ball"),
            measure(rms),
            measure(p95),
            measure(uncovered.upper),
            measure(uncovered.lower),
            measure(excess.upper),
            measure(excess.lower),
            self.topology(),
        )
    }

    fn topology(&self) -> String {
        // The fit is sound if the balls have as many parts and holes as the surface.
        match &self.union {
            None => "not counted: the balls are too small for the grid".to_owned(),
            Some(union) if *union == self.inside => {
                format!("{}, as the surface", topology_text(union))
            }
            Some(union) => {
                let [union, inside] = [union, &self.inside].map(topology_text);
                format!("{union}, but the surface has {inside}")
            }
        }
    }
}

fn topology_text(topology: &Topology) -> String {
    // No plural is formed by rule of "cavity".
    let tunnels = usize::try_from(topology.tunnels).unwrap_or(0);
    let cavities = match topology.cavities {
        1 => "1 cavity".to_owned(),
        count => format!("{} cavities", grouped(count)),
    };
    format!("{}, {}, {cavities}", counted(topology.components, "part"), counted(tunnels, "tunnel"))
}
