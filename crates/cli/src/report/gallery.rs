//! Views of a checked scene.
//!
//! The overview shows the scene from three sides: overlapping bodies solid, the others as
//! glass. A close-up shows one overlapping pair from within the entered body, looking out
//! along the contact's normal, with nearer geometry cut away. So the part that pokes
//! through is visible as a whole, in the colors of its depth, on the wall that it pokes
//! through.

use glam::DVec3;
use musculo_collide::surface::{Aabb, triangle, vertex_normals};
use musculo_collide::{Body, BodyId, BodyKind, PairReport, Scene, VertexReport};
use rayon::prelude::*;

use super::ContactField;
use crate::picture::{Appearance, Camera, Color, Image, Subject, draw};

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
    /// Depth at the top of the color scale.
    pub(crate) max_depth: f64,
}

/// Checked scene with its normals and colors.
#[derive(Debug)]
pub(crate) struct Gallery<'a> {
    scene: &'a Scene,
    /// Pairs that overlap.
    overlapping: Vec<&'a PairReport>,
    margin: f64,
    normals: Vec<Vec<DVec3>>,
    colors: Vec<Color>,
}

/// Maximum size of one side of the overview, in pixels.
const OVERVIEW: [usize; 2] = [620, 640];

/// Maximum size of a close-up, in pixels.
const CLOSE_UP: [usize; 2] = [480, 400];

impl<'a> Gallery<'a> {
    pub(crate) fn new(scene: &'a Scene, reports: &'a [PairReport], margin: f64) -> Self {
        let bodies = scene.bodies().par_iter();
        let normals = bodies.map(|body| vertex_normals(body.surface().faces(), body.positions()));
        let mut overlapping: Vec<_> = reports.iter().filter(|pair| pair.overlaps).collect();
        overlapping.sort_by(|p, q| q.max_depth.total_cmp(&p.max_depth));
        let (normals, colors) = (normals.collect(), colors(scene));
        Self { scene, overlapping, margin, normals, colors }
    }

    /// Returns the number of pictures of overview and close-ups together.
    pub(crate) fn len(&self) -> usize {
        3 + self.overlapping.len()
    }

    /// Draws the scene from three sides; `done` is called after each.
    pub(crate) fn overview(&self, done: impl Fn() + Sync) -> Vec<View> {
        // Bodies of the overlapping pairs are solid, or all where there are none.
        let overlaps = |id: BodyId| self.overlapping.iter().any(|pair| pair.pair.contains(id));
        let mut shown = Vec::new();
        for id in self.scene.ids() {
            let is_solid = self.overlapping.is_empty() || overlaps(id);
            shown.push((id, if is_solid { Appearance::Solid } else { Appearance::Glass }));
        }
        let fields = self.fields(&shown, &self.overlapping);
        let subjects = self.subjects(&shown, &fields);

        let is_solid = |subject: &&Subject<'_>| subject.appearance == Appearance::Solid;
        let solid = subjects.iter().filter(is_solid);
        let points: Vec<DVec3> = solid.flat_map(|subject| subject.positions).copied().collect();
        let sides = sides(Aabb::of_points(points.iter().copied()));
        let max_depth = self.overlapping.first().map_or(0.0, |pair| pair.max_depth);
        let draw_side = |Side { title, forward, up }| {
            let camera = Camera::framing(points.iter().copied(), forward, up, OVERVIEW);
            let view = View::draw(title, &subjects, &camera, max_depth);
            done();
            view
        };
        sides.into_par_iter().map(draw_side).collect()
    }

    /// Draws a close-up of every overlapping pair, the deepest first; `done` is called
    /// after each.
    pub(crate) fn close_ups(&self, done: impl Fn() + Sync) -> Vec<View> {
        let draw_pair = |pair: &&PairReport| {
            let view = self.close_up(pair);
            done();
            view
        };
        self.overlapping.par_iter().map(draw_pair).collect()
    }

    fn close_up(&self, pair: &PairReport) -> View {
        let shown = pair.pair.bodies().map(|id| (id, Appearance::Solid));
        let fields = self.fields(&shown, &[pair]);
        let subjects = self.subjects(&shown, &fields);
        let entry = Entry::of(pair, self.scene);
        let [a, b, entered] =
            [pair.pair.a, pair.pair.b, entry.entered].map(|id| self.scene.body(id).name());
        let title = format!("{a} × {b}, from within {entered}");
        View::draw(title, &subjects, &entry.camera(), pair.max_depth)
    }

    fn fields(&self, shown: &[(BodyId, Appearance)], reports: &[&PairReport]) -> Vec<ContactField> {
        let field = |(id, _): &_| ContactField::new(*id, self.scene, reports, self.margin);
        shown.iter().map(field).collect()
    }

    fn subjects<'s>(
        &'s self,
        shown: &[(BodyId, Appearance)],
        fields: &'s [ContactField],
    ) -> Vec<Subject<'s>> {
        let mut subjects = Vec::new();
        for (&(id, appearance), field) in shown.iter().zip(fields) {
            let body = self.scene.body(id);
            subjects.push(Subject {
                positions: body.positions(),
                normals: &self.normals[id.index()],
                faces: body.surface().faces(),
                signed_gaps: &field.signed_gaps,
                crossing: &field.crossing,
                color: self.colors[id.index()],
                appearance,
            });
        }
        subjects
    }
}

impl View {
    fn draw(title: String, subjects: &[Subject<'_>], camera: &Camera, max_depth: f64) -> Self {
        let (width, height, span) = (camera.width(), camera.height(), camera.span());
        let image = draw(subjects, camera, max_depth);
        Self { title, image, width, height, span, max_depth }
    }
}

/// Returns a color per body: bone, flesh or sheet, neighbors of one kind in different
/// shades.
fn colors(scene: &Scene) -> Vec<Color> {
    const SHADES: [f64; 5] = [1.0, 0.80, 1.16, 0.90, 0.72];
    let mut colors = Vec::new();
    for (body, shade) in scene.bodies().iter().zip(SHADES.into_iter().cycle()) {
        colors.push(match body.kind() {
            BodyKind::Rigid => Color::from_srgb([0xe8, 0xde, 0xc6]),
            BodyKind::Deformable => Color::from_srgb([0xd6, 0x8c, 0x80]) * shade,
            BodyKind::Open => Color::from_srgb([0x8f, 0xae, 0xc8]) * shade,
        });
    }
    colors
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
    /// Points of the entering body in contact.
    points: Vec<DVec3>,
    /// Deepest of them, or a point of a crossing face where none is inside.
    center: DVec3,
    /// Direction out of the entered body.
    outward: DVec3,
    /// Radius below which a close-up would show less than a few faces.
    min_radius: f64,
}

/// Radius of a close-up for contact on faces of one size, in mean edges of these.
const MIN_RADIUS_IN_EDGES: f64 = 4.0;

/// Fraction of the contact's points within the radius of a close-up, in tenths.
const SHOWN_TENTHS: usize = 9;

impl Entry {
    /// Returns the part of the body with the deepest vertex.
    fn of(pair: &PairReport, scene: &Scene) -> Self {
        let deepest = |report: &VertexReport| {
            report.near.iter().map(|near| near.gap).fold(f64::INFINITY, f64::min)
        };
        let a_enters = deepest(&pair.a_against_b) <= deepest(&pair.b_against_a);
        let (entering, entered, report) = if a_enters {
            (pair.pair.a, pair.pair.b, &pair.a_against_b)
        } else {
            (pair.pair.b, pair.pair.a, &pair.b_against_a)
        };
        let body = scene.body(entering);

        let side = usize::from(!a_enters);
        let crossing: Vec<[DVec3; 3]> =
            pair.crossing_faces.iter().map(|faces| corners(body, faces[side])).collect();
        let any = [corners(body, 0)];
        let edge = mean_edge(if crossing.is_empty() { &any } else { &crossing });

        let min_radius = MIN_RADIUS_IN_EDGES * edge;
        let mut entry = Self {
            entered,
            points: Vec::new(),
            center: DVec3::ZERO,
            outward: DVec3::ZERO,
            min_radius,
        };
        entry.add_inside(body, report);
        entry.add_crossing(&crossing);
        entry
    }

    /// Adds the vertices inside; the direction is their normals' mean, weighted by depth.
    fn add_inside(&mut self, body: &Body, report: &VertexReport) {
        let mut min_gap = 0.0;
        for near in report.near.iter().filter(|near| near.gap < 0.0) {
            let at = body.positions()[near.vertex as usize];
            self.points.push(at);
            self.outward -= near.gap * near.normal;
            if near.gap < min_gap {
                (self.center, min_gap) = (at, near.gap);
            }
        }
    }

    /// Adds crossing faces, which give center and direction where no vertex is inside.
    fn add_crossing(&mut self, faces: &[[DVec3; 3]]) {
        if self.points.is_empty()
            && let Some(first) = faces.first()
        {
            self.center = first.iter().sum::<DVec3>() / 3.0;
            self.outward = -faces.iter().map(|face| triangle::normal(*face)).sum::<DVec3>();
        }
        self.points.extend(faces.iter().flatten());
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
        most.max(self.min_radius).max(f64::MIN_POSITIVE)
    }
}

/// Returns the mean length of the edges of some faces.
fn mean_edge(faces: &[[DVec3; 3]]) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for &[p, q, r] in faces {
        sum += p.distance(q) + q.distance(r) + r.distance(p);
        count += 3.0;
    }
    sum / count
}

fn corners(body: &Body, face: u32) -> [DVec3; 3] {
    body.surface().faces()[face as usize].map(|vertex| body.positions()[vertex as usize])
}
