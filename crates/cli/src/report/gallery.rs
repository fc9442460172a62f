//! Views of a checked scene.
//!
//! The overview shows the scene from three sides: overlapping bodies solid, the others as
//! glass. A close-up shows one overlapping pair from within the entered body, looking out
//! along the contact's normal, with nearer geometry cut away. So the part that pokes
//! through is visible as a whole, in the colors of its depth, on the wall that it pokes
//! through.

use glam::DVec3;
use musculo_collide::surface::{Aabb, vertex_normals};
use musculo_collide::{BodyId, Depth, PairReport, Scene};
use rayon::prelude::*;

use super::OverlapShape;
use super::body_color::colors;
use super::contact_triangles::contact_triangles;
use super::pair_record::rounding;
use super::viewer::{Model, ShownSurfaces};
use crate::scene::Unit;
use picture::{Appearance, Camera, Color, ContactTriangle, Image, Subject, draw};

/// Picture with the data of its caption.
#[derive(Debug)]
pub(crate) struct View {
    pub(crate) title: String,
    pub(crate) image: Image,
    /// Width in pixels.
    pub(crate) width: usize,
    /// Height in pixels.
    pub(crate) height: usize,
    /// Width of the view, in length units.
    pub(crate) span: f64,
    pub(crate) scale: ColorScale,
}

/// Values at the ends of a picture's color scale.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ColorScale {
    pub(crate) quantity: Quantity,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

/// Quantity that colors stand for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Quantity {
    Depth,
    Gap,
    Pressure,
}

impl ColorScale {
    fn of_depth(max_depth: f64) -> Self {
        Self { quantity: Quantity::Depth, from: 0.0, to: max_depth }
    }
}

/// Checked scene with its normals and colors.
#[derive(Debug)]
pub(crate) struct Gallery<'a> {
    pub(super) scene: &'a Scene,
    /// Pairs that overlap, the deepest first.
    overlapping: Vec<DrawnOverlap<'a>>,
    normals: Vec<Vec<DVec3>>,
    colors: Vec<Color>,
}

/// Overlap with the clipped parts of both surfaces.
#[derive(Debug)]
struct DrawnOverlap<'a> {
    report: &'a PairReport,
    /// Depth at the top of the color scale.
    max_depth: f64,
    /// Parts of the first body inside the second, and of the second inside the first.
    contact: [Vec<ContactTriangle>; 2],
}

/// Maximum size of one side of the overview, in pixels.
const OVERVIEW: [usize; 2] = [620, 640];

/// Maximum size of a close-up, in pixels.
pub(super) const CLOSE_UP: [usize; 2] = [480, 400];

impl<'a> Gallery<'a> {
    /// Prepares the pictures; `shapes` are those of the overlapping pairs.
    pub(crate) fn new(scene: &'a Scene, shapes: &[OverlapShape<'a>]) -> Self {
        let bodies = scene.bodies().par_iter();
        let normals: Vec<Vec<DVec3>> =
            bodies.map(|body| vertex_normals(body.surface().faces(), body.positions())).collect();
        let drawn = shapes.par_iter().map(|shape| DrawnOverlap::new(shape, scene, &normals));
        let mut overlapping: Vec<DrawnOverlap<'a>> = drawn.collect();
        overlapping.sort_by(|p, q| q.max_depth.total_cmp(&p.max_depth));
        Self { scene, overlapping, normals, colors: colors(scene) }
    }

    /// Builds the model of the scene that a page turns.
    pub(crate) fn model(&self, surfaces: &ShownSurfaces, unit: Unit) -> Model {
        let mut overlaps = Vec::new();
        for drawn in &self.overlapping {
            overlaps.push((drawn.report, drawn.contact.each_ref().map(Vec::as_slice)));
        }
        Model::of_state(self.scene, surfaces, unit, &overlaps)
    }

    /// Returns the number of pictures of overview and close-ups together.
    pub(crate) fn len(&self) -> usize {
        3 + self.overlapping.len()
    }

    /// Draws the scene from three sides; `done` is called after each.
    pub(crate) fn overview(&self, done: impl Fn() + Sync) -> Vec<View> {
        // Bodies of the overlapping pairs are solid, or all where there are none.
        let mut shown = Vec::new();
        for id in self.scene.ids() {
            let is_solid = self.overlapping.is_empty() || self.overlaps(id);
            shown.push((id, if is_solid { Appearance::Solid } else { Appearance::Glass }));
        }
        let contact = contact_of(&shown, &self.overlapping.iter().collect::<Vec<_>>());
        let subjects = self.subjects(&shown, &contact);

        let mut points: Vec<DVec3> = Vec::new();
        for subject in &subjects {
            if subject.appearance == Appearance::Solid {
                let corners = subject.faces.as_flattened().iter();
                points.extend(corners.map(|&corner| subject.positions[corner as usize]));
            }
        }
        let sides = sides(Aabb::of_points(points.iter().copied()));
        let max_depth = self.overlapping.first().map_or(0.0, |drawn| drawn.max_depth);
        let draw_side = |Side { title, forward, up }| {
            let camera = Camera::framing(points.iter().copied(), forward, up, OVERVIEW);
            let scale = ColorScale::of_depth(max_depth);
            let view = View::draw(title, &subjects, &camera, scale);
            done();
            view
        };
        sides.into_par_iter().map(draw_side).collect()
    }

    /// Returns true for a body of an overlapping pair.
    fn overlaps(&self, id: BodyId) -> bool {
        self.overlapping.iter().any(|drawn| drawn.report.pair.contains(id))
    }

    /// Draws a close-up of every overlapping pair, the deepest first; `done` is called
    /// after each.
    pub(crate) fn close_ups(&self, done: impl Fn() + Sync) -> Vec<View> {
        let draw_pair = |drawn: &DrawnOverlap<'_>| {
            let view = self.close_up(drawn);
            done();
            view
        };
        self.overlapping.par_iter().map(draw_pair).collect()
    }

    fn close_up(&self, drawn: &DrawnOverlap<'_>) -> View {
        let pair = drawn.report.pair;
        let shown = pair.bodies().map(|id| (id, Appearance::Solid));
        let contact = contact_of(&shown, &[drawn]);
        let subjects = self.subjects(&shown, &contact);
        let entry = Entry::of(drawn, self.scene);
        let [a, b, entered] = [pair.a, pair.b, entry.entered].map(|id| self.scene.body(id).name());
        let title = format!("{a} × {b}, from within {entered}");
        View::draw(title, &subjects, &entry.camera(), ColorScale::of_depth(drawn.max_depth))
    }

    pub(super) fn subjects<'s>(
        &'s self,
        shown: &[(BodyId, Appearance)],
        contact: &'s [Vec<ContactTriangle>],
    ) -> Vec<Subject<'s>> {
        let mut subjects = Vec::new();
        for (&(id, appearance), contact) in shown.iter().zip(contact) {
            let body = self.scene.body(id);
            subjects.push(Subject {
                positions: body.positions(),
                normals: &self.normals[id.index()],
                faces: body.surface().faces(),
                contact,
                color: self.colors[id.index()],
                appearance,
            });
        }
        subjects
    }
}

impl<'a> DrawnOverlap<'a> {
    fn new(shape: &OverlapShape<'a>, scene: &Scene, normals: &[Vec<DVec3>]) -> Self {
        let OverlapShape { report, geometry } = shape;
        let [a, b] = report.pair.bodies();
        let triangles = |side: usize, own: BodyId, other: BodyId| {
            let (body, normals) = (scene.body(own), &normals[own.index()]);
            let tree = scene.body(other).tree();
            tree.map_or(Vec::new(), |tree| {
                contact_triangles(&geometry.patches[side], body, normals, tree)
            })
        };
        let contact = [triangles(0, a, b), triangles(1, b, a)];
        let max_depth = report.max_depth().map_or(0.0, |depth| depth.lower);
        let max_depth = if max_depth > rounding(report.pair, scene) { max_depth } else { 0.0 };
        Self { report, max_depth, contact }
    }
}

/// Gathers the contact of each body that is shown.
fn contact_of(
    shown: &[(BodyId, Appearance)],
    overlaps: &[&DrawnOverlap<'_>],
) -> Vec<Vec<ContactTriangle>> {
    let mut contact = vec![Vec::new(); shown.len()];
    for ((id, _), contact) in shown.iter().zip(&mut contact) {
        for drawn in overlaps {
            for (own, triangles) in drawn.report.pair.bodies().iter().zip(&drawn.contact) {
                if own == id {
                    contact.extend(triangles);
                }
            }
        }
    }
    contact
}

impl View {
    pub(super) fn draw(
        title: String,
        subjects: &[Subject<'_>],
        camera: &Camera,
        scale: ColorScale,
    ) -> Self {
        let (width, height, span) = (camera.width(), camera.height(), camera.span());
        let image = draw(subjects, camera, (scale.to - scale.from).abs());
        Self { title, image, width, height, span, scale }
    }
}

/// View of the overview, with its directions.
struct Side {
    title: String,
    forward: DVec3,
    up: DVec3,
}

/// Returns three sides on which the longest axis of the scene is upright.
fn sides(bounds: Aabb) -> [Side; 3] {
    let axes = [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)];
    let size = bounds.sides().to_array();
    // Of equal lengths the last is upright: z is up in most data.
    let up = (0..3).max_by(|&i, &j| size[i].total_cmp(&size[j])).unwrap_or(2);
    let (side, front) = (axes[(up + 1) % 3], axes[(up + 2) % 3]);
    [("+", front, 1.0), ("−", side, -1.0), ("−", front, -1.0)].map(
        |(sign, (name, axis), factor)| Side {
            title: format!("along {sign}{name}"),
            forward: factor * axis,
            up: axes[up].1,
        },
    )
}

/// Part of one body that enters another.
#[derive(Debug)]
struct Entry {
    entered: BodyId,
    /// Corners of the entering body's clipped parts.
    points: Vec<DVec3>,
    /// Deepest of them.
    center: DVec3,
    /// Direction out of the entered body.
    outward: DVec3,
}

/// Fraction of the contact's points within the radius of a close-up, in tenths.
const SHOWN_TENTHS: usize = 9;

impl Entry {
    /// Returns the part of the body that is deeper in the other.
    fn of(drawn: &DrawnOverlap<'_>, scene: &Scene) -> Self {
        let pair = drawn.report.pair;
        let overlap = drawn.report.overlap.as_ref();
        let depths = match overlap {
            Some(overlap) => [overlap.depth_of_a_in_b, overlap.depth_of_b_in_a],
            None => [None; 2],
        };
        let [of_a, of_b] = depths.map(|depth| depth.map_or(0.0, |depth| depth.lower));
        let side = if drawn.contact[0].is_empty() || of_b > of_a { 1 } else { 0 };

        // The way out is that of the deepest point, or against the mean normal where bodies
        // coincide; that of A points out of A.
        let normal = overlap.map_or(DVec3::ZERO, |overlap| overlap.measures.total.normal);
        let against = if side == 0 { -normal } else { normal };
        let mut points: Vec<DVec3> = Vec::new();
        points.extend(drawn.contact[side].iter().flatten().map(|point| point.at));
        if points.is_empty() {
            points.extend(crossing_points(drawn.report, scene));
        }
        let (center, outward) = match depths[side] {
            Some(Depth { point, foot, .. }) => {
                (point, (foot - point).try_normalize().unwrap_or(against))
            }
            None => (Aabb::of_points(points.iter().copied()).center(), against),
        };
        Self { entered: pair.bodies()[1 - side], points, center, outward }
    }

    /// Returns a view out of the entered body of the contact around the deepest point.
    fn camera(&self) -> Camera {
        let radius = self.radius();
        let forward = self.outward.normalize_or(DVec3::Y);
        let mut framed = Vec::new();
        let mut front = 0.0_f64;
        for &point in &self.points {
            if point.distance(self.center) <= radius {
                framed.push(point);
                front = front.min((point - self.center).dot(forward));
            }
        }
        framed.push(self.center);

        // A margin around every point, and a cut a little before the first.
        let margin = 0.45 * radius;
        let around = |point: &DVec3| {
            let point = *point;
            DVec3::AXES
                .into_iter()
                .flat_map(move |axis| [point - margin * axis, point + margin * axis])
        };
        Camera::framing(framed.iter().flat_map(around), forward, DVec3::Z, CLOSE_UP)
            .with_near_plane(self.center + (front - 0.05 * radius) * forward)
    }

    /// Returns the radius around the center with most of the contact.
    fn radius(&self) -> f64 {
        let mut distances: Vec<f64> =
            self.points.iter().map(|point| point.distance(self.center)).collect();
        distances.sort_by(f64::total_cmp);
        let most = distances.get(distances.len() * SHOWN_TENTHS / 10).copied().unwrap_or(0.0);
        most.max(f64::MIN_POSITIVE)
    }
}

/// Returns the corners of the first body's faces that cross the second: surfaces without an inside
/// have no clipped parts.
fn crossing_points(report: &PairReport, scene: &Scene) -> Vec<DVec3> {
    let body = scene.body(report.pair.a);
    report.crossing_faces.iter().flat_map(|faces| body.corners(faces[0])).collect()
}
