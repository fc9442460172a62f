//! Costs of libraries that are compared with nothing else: per face or node, and of a scene by two
//! threads beside one.

use std::error::Error;

use decimate::{Decimation, Preview};
use fixtures::shapes::icosphere;
use fixtures::volume::Block;
use glam::DVec3;
use mesh_io::{MeshFormat, parse_mesh};
use musculo_collide::volume_mesh::{Cell, FollowParams, VolumeMesh};
use proximity::PairProximity;
use rayon::ThreadPoolBuilder;
use surface::inspect;
use surface::progress::Progress;

use crate::bodies::body;
use crate::chart::size::operations::{Operation, Spheres};
use crate::measure::{Report, as_f64};

/// Budget of each measurement \[ms\].
const BUDGET: u64 = 400;

/// Splits of spheres: 20,480 faces, 1,280, and 16,640 in a scene of 13.
const FINE: u32 = 5;
const COARSE: u32 = 3;

/// Radius of spheres, and the way from one center to the other \[mm\].
const RADIUS: f64 = 30.0;
const APART: f64 = 58.0;

/// Distance from a coarser sphere \[mm\].
const TOLERANCE: f64 = 0.1;

type Outcome = Result<(), Box<dyn Error>>;

/// Reports the time of work per unit, of which there are `count`.
fn per_unit(report: &mut Report, name: &str, count: usize, work: &mut dyn FnMut() -> usize) {
    let [time] = report.interleave(name, BUDGET, [("ours", work)]);
    report.cost(name, time / as_f64(count), "ns", f64::INFINITY);
}

/// Inspects a closed surface for all kinds of defects.
pub(super) fn surface(report: &mut Report) -> Outcome {
    let ball = icosphere(RADIUS, FINE);
    let (surface, count) = (ball.surface(), ball.faces.len());
    let x = surface.positions(&ball.positions)?;
    per_unit(report, "inspection, per face", count, &mut || {
        usize::from(inspect(&surface, x).closed())
    });
    Ok(())
}

/// Finds crossings, insides and closest points of two spheres that overlap.
pub(super) fn proximity(report: &mut Report) -> Outcome {
    let a = body(icosphere(RADIUS, FINE));
    let way = DVec3::new(APART, 3.1, 2.3);
    let b = body(icosphere(RADIUS, FINE).translated(way));
    let count = a.surface().faces().len() + b.surface().faces().len();
    let mut pair = PairProximity::default();
    per_unit(report, "overlapping pair, per face", count, &mut || {
        pair.compute(&a, &b, 0.0).expect("few faces are near");
        pair.crossing_faces().len()
    });
    Ok(())
}

/// Coarsens a sphere with proved deviation, and one to look at.
pub(super) fn decimate(report: &mut Report) -> Outcome {
    let full = body(icosphere(RADIUS, COARSE));
    let count = full.surface().faces().len();
    per_unit(report, "decimation, per face", count, &mut || {
        Decimation::new(full.clone(), Progress::none())
            .map_or(0, |all| all.full().surface().faces().len())
    });

    let fine = body(icosphere(RADIUS, FINE));
    let reduced = || {
        Decimation::up_to(fine.clone(), TOLERANCE, Progress::none())?
            .within(TOLERANCE, Progress::none())
    };
    let preview = || Preview::new(fine.surface(), fine.positions().as_slice(), TOLERANCE);
    let sides: [&mut dyn FnMut() -> usize; 2] =
        [&mut || preview().map_or(0, |preview| preview.faces.len()), &mut || {
            reduced().map_or(0, |reduced| reduced.surface.faces().len())
        }];
    report.compare("20k preview / reduced surface", BUDGET, 0.25, sides);
    Ok(())
}

/// Compares a scene by two threads with the same by one.
pub(super) fn scene(report: &mut Report) -> Outcome {
    for operation in [Operation::Check, Operation::Sweep] {
        let mut spheres = [operation.spheres(COARSE)?, operation.spheres(COARSE)?];
        let [one, two] = &mut spheres;
        let pools = [1, 2].map(|threads| ThreadPoolBuilder::new().num_threads(threads).build());
        let [by_one, by_two] = pools;
        let (by_one, by_two) = (by_one?, by_two?);
        let run = |spheres: &mut Spheres| operation.run(spheres).unwrap_or(0);
        let name = format!("{} by two threads / one", operation.name());
        let sides: [&mut dyn FnMut() -> usize; 2] =
            [&mut || by_two.install(|| run(two)), &mut || by_one.install(|| run(one))];
        report.compare(&name, BUDGET, f64::INFINITY, sides);
    }
    Ok(())
}

/// Lets the nodes inside a block follow its boundary.
pub(super) fn volume_mesh(report: &mut Report) -> Outcome {
    let block = Block::new(DVec3::splat(10.0), [8; 3]);
    let cells = block.tetrahedra().into_iter().map(Cell::Tetrahedron).collect();
    let mesh = VolumeMesh::new(block.nodes.len(), cells)?;
    let boundary = mesh.boundary()?;
    let mut bent = Vec::new();
    for &node in &boundary.nodes {
        let x = block.nodes[node as usize];
        bent.push(x + 0.02 * x.z * x.z * DVec3::X);
    }
    let params = FollowParams::default();
    per_unit(report, "following interior, per node", block.nodes.len(), &mut || {
        let followed = mesh.follow(&block.nodes, &boundary, &bent, &params, Progress::none());
        followed.map_or(0, |followed| followed.positions.len())
    });
    Ok(())
}

/// Reads a surface from each format.
pub(super) fn mesh_io(report: &mut Report) -> Outcome {
    let ball = icosphere(RADIUS, FINE);
    for format in [MeshFormat::Ply, MeshFormat::Stl, MeshFormat::Obj, MeshFormat::Vtp] {
        let file = format.encode(&ball.positions, &ball.faces, None);
        let name = format!("reading {}, per face", format.extension());
        per_unit(report, &name, ball.faces.len(), &mut || {
            parse_mesh(&file, format.extension()).map_or(0, |mesh| mesh.faces.len())
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_library_has_a_time() {
        for run in [surface, proximity, decimate, scene, volume_mesh, mesh_io] {
            let mut report = Report::new(1e-3);
            run(&mut report).unwrap();
            assert!(report.shortfalls().is_empty());
        }
    }
}
