//! What is nearer than the truncation is told, right up to it.

use distance_field::{FieldMethod, FieldParams, NodeValues};
use fixtures::Mesh;
use fixtures::generate::cases;
use surface::glam::DVec3;

use crate::support::build;

/// A face of a thousandth of a spacing, as good as a point: all that the band
/// around it holds is what lies within its width of that point, so that no surface
/// leaves nodes farther from their nearest band node.
#[test]
fn all_nodes_within_the_truncation_know_a_lone_point() {
    let mut told = 0;
    cases(1, 40, |u| {
        let mut tenth = |from: u32, to: u32| Ok(f64::from(u.int_in_range(from..=to)?) / 10.0);
        let (truncation, band) = (tenth(40, 130)?, tenth(18, 35)?);
        let at = DVec3::new(tenth(0, 9)?, tenth(0, 9)?, tenth(0, 9)?);
        // The far corner of the box keeps its lowest corner, and so the grid, at 0.
        let far = DVec3::splat(-60.0);
        let small = |p: DVec3| [p, p + 1e-3 * DVec3::X, p + 1e-3 * DVec3::Y];
        let mesh =
            Mesh { positions: [small(at), small(far)].concat(), faces: vec![[0, 1, 2], [3, 4, 5]] };
        let method = FieldMethod::ExactBand { band, node_values: NodeValues::Interpolating };
        let params = FieldParams {
            truncation: Some(truncation),
            padding: 14.0,
            method,
            samples: 0,
            ..FieldParams::new(1.0)
        };
        let field = build(&mesh, &params).expect("two faces fit");
        let grid = field.grid();
        let [first, last] = [at - truncation, at + truncation].map(|p| p - grid.origin());
        let nodes = |axis: usize| {
            let within = |&n: &usize| {
                let n = n as f64;
                first[axis] <= n && n <= last[axis]
            };
            (0..grid.dims()[axis]).filter(within).collect::<Vec<usize>>()
        };
        for (k, j) in nodes(2).into_iter().flat_map(|k| nodes(1).into_iter().map(move |j| (k, j))) {
            for i in nodes(0) {
                let distance = grid.position([i, j, k]).distance(at);
                if distance < truncation {
                    let value = field.node([i, j, k]);
                    assert!(
                        (value - distance).abs() < 2e-3,
                        "{value}, not {distance} of {truncation}"
                    );
                    told += 1;
                }
            }
        }
        Ok(())
    });
    assert!(told > 10_000, "{told}");
}
