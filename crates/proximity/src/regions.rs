//! Segmentation of a surface by another one, each region on one side of it.
//!
//! Faces that meet the other surface belong to no region; the others form regions by common
//! corners. Against a closed surface a region is inside or outside. An open surface has two sides
//! but no inside: corners next to the cut decide on which side their region lies, by the normal
//! at their closest point.
//!
//! Source: B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal system using
//! MRI*, PhD thesis, 2007, section 4.7.2, which mentions such a segmentation for surfaces without
//! an inside.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use glam::DVec3;
use kdop::{Dop18, Workspace};
use surface::progress::Progress;
use surface::{
    NO_EDGE, Pseudonormals, TriangleFeature, TriangleSurface, closest_on_segment,
    closest_on_triangle, triangle,
};

use crate::SurfaceTree;
use crate::crossings::Crossings;
use crate::face_groups::{FaceGroups, area};

/// Connected region of a surface that does not meet another one.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Region {
    /// Its faces, ascending.
    pub faces: Vec<u32>,
    /// Sum of their areas, in the square of the length unit.
    pub area: f64,
    /// Its side of the cutting surface.
    pub side: Side,
}

/// Side of a cutting surface on which a region lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Side {
    /// Inside a surface that has an inside.
    Inside,
    /// Outside of it.
    Outside,
    /// At the cut, in front of an open surface: where its normals point.
    Front,
    /// At the cut, behind an open surface.
    Back,
    /// At the cut on both sides, around the border of an open surface.
    Around,
    /// Not at the cut with an open surface.
    Apart,
}

/// Finds the regions of `a` that do not meet `by`, largest first; one region where nothing is
/// cut.
///
/// Which faces are cut is exact, and so is which region is inside a surface that has an inside.
/// Sides of an open surface are decided by the closest points of corners of cut faces; those
/// closest to its border decide nothing.
///
/// ```
/// use proximity::glam::DVec3;
/// use proximity::{Side, SurfaceTree, regions};
/// use surface::TriangleSurface;
///
/// let x = [[0.0, 0.0, -1.0], [6.0, 0.0, -1.0], [0.0, 0.0, 2.0], [6.0, 0.0, 2.0], [0.0, 0.0, 5.0]];
/// let strip = TriangleSurface::new(5, vec![[0, 1, 2], [1, 3, 2], [2, 3, 4]])?;
/// let strip = SurfaceTree::new(strip, x.map(DVec3::from).to_vec())?;
/// let y = [[-9.0, -9.0, 0.0], [19.0, -9.0, 0.0], [-9.0, 19.0, 0.0]];
/// let floor = TriangleSurface::new(3, vec![[0, 1, 2]])?;
/// let floor = SurfaceTree::new(floor, y.map(DVec3::from).to_vec())?;
///
/// let regions = regions(&strip, &floor);
/// assert_eq!(regions.len(), 1);
/// assert_eq!((&regions[0].faces[..], regions[0].side), (&[2][..], Side::Front));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn regions(a: &SurfaceTree, by: &SurfaceTree) -> Vec<Region> {
    let (mut crossings, mut workspace) = (Crossings::default(), Workspace::default());
    // Without a handler nothing interrupts.
    let _ = crossings.find(a, by, &mut workspace, Progress::none());
    let cut_faces = crossings.cut_faces_of_a;

    // Faces that are not cut, grouped.
    let mut whole_faces = Vec::new();
    let mut cut = cut_faces.iter().peekable();
    for face in (0..).take(a.surface().faces().len()) {
        if cut.next_if_eq(&&face).is_none() {
            whole_faces.push(face);
        }
    }
    let mut groups = FaceGroups::new(a.surface(), &whole_faces);

    // Against a closed surface one vertex decides for its region, against an open one the cut.
    let mut sides = BTreeMap::new();
    if by.has_inside().is_ok() {
        for &vertex in groups.faces.keys() {
            let is_inside = by.contains(a.position(vertex), &mut workspace);
            sides.insert(vertex, if is_inside { Side::Inside } else { Side::Outside });
        }
    } else {
        let normals = Pseudonormals::new(by.surface(), by.positions());
        for vertex in cut_faces.iter().flat_map(|&face| a.surface().faces()[face as usize]) {
            if let Some(side) = side_of_open(by, a.position(vertex), &normals, &mut workspace) {
                let region = sides.entry(groups.root(vertex)).or_insert(side);
                *region = if *region == side { side } else { Side::Around };
            }
        }
    }

    // Largest first; of equal areas the one with the smallest face.
    let mut regions = Vec::new();
    for (root, faces) in groups.faces {
        let side = sides.get(&root).copied().unwrap_or(Side::Apart);
        regions.push(Region { area: area(a, &faces), faces, side });
    }
    regions.sort_by(|p, q| q.area.total_cmp(&p.area).then(p.faces[0].cmp(&q.faces[0])));
    regions
}

/// Returns the side of an open surface on which a point lies; `None` on the surface, and where
/// the closest point is on its border.
fn side_of_open(
    open: &SurfaceTree,
    point: DVec3,
    normals: &Pseudonormals,
    workspace: &mut Workspace,
) -> Option<Side> {
    let found = open.closest_point(point, f64::INFINITY, None, workspace)?;
    let (surface, feature) = (open.surface(), found.foot.feature);
    if is_on_border(surface, found.face, feature) {
        return None;
    }

    // Faces without area join others whose normals count together.
    let normal = match thickness_of_thin_faces(open, found.face, feature) {
        Some(thickness) => normal_of_place(open, found.foot.point, thickness, workspace),
        None => normals.at(surface, found.face, feature),
    };
    let height = (point - found.foot.point).dot(normal);
    let side = if height > 0.0 { Side::Front } else { Side::Back };
    (height != 0.0).then_some(side)
}

/// Returns the largest height of the faces around a feature that are too thin to have a certain normal;
/// `None` without any.
fn thickness_of_thin_faces(open: &SurfaceTree, face: u32, feature: TriangleFeature) -> Option<f64> {
    /// Area of a face whose normal is right to ten digits, relative to the square of its longest edge.
    const MIN_AREA: f64 = 1e-6;

    let mut thickness: Option<f64> = None;
    for &face in open.surface().faces_around(&face, feature) {
        let corners = open.corners(face);
        let (area, longest) = (triangle::area(corners), longest_edge(corners));
        if area <= MIN_AREA * longest * longest {
            let height = if longest > 0.0 { 2.0 * area / longest } else { 0.0 };
            thickness = Some(thickness.map_or(height, |thickness| thickness.max(height)));
        }
    }
    thickness
}

/// Computes the sum of the normals of all faces at a place, within a thickness, each weighted by the
/// angle that the face takes there. Faces without area take none of their own.
fn normal_of_place(
    open: &SurfaceTree,
    place: DVec3,
    thickness: f64,
    workspace: &mut Workspace,
) -> DVec3 {
    /// Rounding of a foot, in units of its largest coordinate, with room to spare.
    const ROUNDING: f64 = 64.0 * f64::EPSILON;

    let within = 2.0 * thickness + ROUNDING * place.abs().max_element();
    let mut faces = Vec::new();
    let bounds = Dop18::from_points(&[place]).inflated(within);
    open.tree().query(&bounds, workspace, |face| faces.push(face));
    faces.sort_unstable();

    let mut sum = DVec3::ZERO;
    for face in faces {
        let corners = open.corners(face);
        if closest_on_triangle(place, corners).point.distance(place) <= within {
            sum += angle_at(corners, place, within) * triangle::unit_normal(corners);
        }
    }
    sum
}

/// Returns the angle that a triangle takes about a place on it, up to a distance; 0 for a triangle that
/// is no wider than that.
fn angle_at(corners: [DVec3; 3], place: DVec3, within: f64) -> f64 {
    if 2.0 * triangle::area(corners) <= 2.0 * within * longest_edge(corners) {
        return 0.0;
    }
    for k in 0..3 {
        let [at, next, last] = [0, 1, 2].map(|i| corners[(k + i) % 3]);
        if at.distance(place) <= within {
            return (next - at).angle_between(last - at);
        }
    }
    for k in 0..3 {
        let edge = [corners[k], corners[(k + 1) % 3]];
        if closest_on_segment(place, edge).point.distance(place) <= within {
            return PI;
        }
    }
    TAU
}

fn longest_edge([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

fn is_on_border(surface: &TriangleSurface, face: u32, feature: TriangleFeature) -> bool {
    let is_border = |edge: u32| edge != NO_EDGE && surface.edge_faces(edge).len() < 2;
    let sides = surface.face_edges()[face as usize];
    match feature {
        TriangleFeature::Face => false,
        TriangleFeature::Edge(k) => is_border(sides[k]),
        TriangleFeature::Corner(k) => {
            let corner = surface.faces()[face as usize][k];
            let around = surface.vertex_faces(corner).iter();
            let mut edges = around.flat_map(|&face| surface.face_edges()[face as usize]);
            edges.any(|edge| is_border(edge) && surface.edges()[edge as usize].contains(&corner))
        }
    }
}
