//! Which pictures a report shows, and from where.
//!
//! The overview shows the scene from three sides: overlapping bodies solid, the
//! others as glass. A close-up shows one overlapping pair from within the body
//! that the other one enters, looking out along the contact's normal, with
//! everything nearer cut away: so the part that pokes through is seen whole, in
//! the colours of its depth, on the wall that it pokes through.

use glam::DVec3;
use musculo_collide::{Body, BodyId, BodyKind, PairReport, Scene};
use rayon::prelude::*;

use super::ContactField;
use crate::picture::{Appearance, Camera, Colour, Image, Subject, draw, vertex_normals};

/// A picture with what its caption needs.
#[derive(Debug)]
pub(crate) struct Sight {
    pub(crate) title: String,
    pub(crate) image: Image,
    /// Pixels.
    pub(crate) width: usize,
    /// Pixels.
    pub(crate) height: usize,
    /// Width of what is shown, in length units.
    pub(crate) span: f64,
    /// Depth at the top of the colour scale.
    pub(crate) deepest: f64,
}

/// A checked scene, ready to be drawn.
#[derive(Debug)]
pub(crate) struct Gallery<'a> {
    scene: &'a Scene,
    reports: &'a [PairReport],
    reach: f64,
    normals: Vec<Vec<DVec3>>,
    colours: Vec<Colour>,
}

/// Pixels that an overview may take, one of its sides.
const OVERVIEW: [usize; 2] = [620, 640];

/// Pixels that a close-up may take.
const CLOSE_UP: [usize; 2] = [480, 400];

impl<'a> Gallery<'a> {
    pub(crate) fn new(scene: &'a Scene, reports: &'a [PairReport], reach: f64) -> Self {
        let normals =
            scene.bodies().par_iter().map(|b| vertex_normals(b.positions(), b.surface().faces()));
        Self { scene, reports, reach, normals: normals.collect(), colours: colours(scene) }
    }

    /// The scene from three sides; `done` is called after each.
    pub(crate) fn overview(&self, done: impl Fn() + Sync) -> Vec<Sight> {
        let overlapping =
            |id: BodyId| self.reports.iter().any(|pair| pair.overlaps && pair.pair.contains(id));
        let nothing_overlaps = !self.scene.ids().any(overlapping);
        let shown: Vec<(BodyId, Appearance)> = self
            .scene
            .ids()
            .map(|id| {
                let is_solid = nothing_overlaps || overlapping(id);
                (id, if is_solid { Appearance::Solid } else { Appearance::Glass })
            })
            .collect();
        let fields: Vec<ContactField> = self.fields(&shown, self.reports);
        let subjects = self.subjects(&shown, &fields);
        let solid = || {
            let solid = subjects.iter().filter(|subject| subject.appearance == Appearance::Solid);
            solid.flat_map(|subject| subject.positions.iter().copied())
        };
        let deepest = self.reports.iter().map(|pair| pair.max_depth).fold(0.0, f64::max);
        sides(extent(solid()))
            .into_par_iter()
            .map(|(title, forward, up)| {
                let camera = Camera::framing(solid(), forward, up, OVERVIEW);
                let sight = Sight::draw(title, &subjects, &camera, deepest);
                done();
                sight
            })
            .collect()
    }

    /// Close-ups of the given pairs; `done` is called after each.
    pub(crate) fn close_ups(&self, pairs: &[&PairReport], done: impl Fn() + Sync) -> Vec<Sight> {
        let close_up = |pair: &&PairReport| {
            let sight = self.close_up(pair);
            done();
            sight
        };
        pairs.par_iter().map(close_up).collect()
    }

    fn close_up(&self, pair: &PairReport) -> Sight {
        let contact = Entry::of(pair, self.scene);
        let shown = pair.pair.bodies().map(|id| (id, Appearance::Solid));
        let fields = self.fields(&shown, [pair]);
        let subjects = self.subjects(&shown, &fields);
        let camera = contact.camera();
        let title = format!(
            "{} × {}, seen from within {}",
            self.scene.body(pair.pair.a).name(),
            self.scene.body(pair.pair.b).name(),
            self.scene.body(contact.entered).name(),
        );
        Sight::draw(title, &subjects, &camera, pair.max_depth)
    }

    fn fields<'p>(
        &self,
        shown: &[(BodyId, Appearance)],
        reports: impl IntoIterator<Item = &'p PairReport> + Clone,
    ) -> Vec<ContactField> {
        let overlapping =
            |reports: &mut dyn Iterator<Item = &'p PairReport>| -> Vec<&'p PairReport> {
                reports.filter(|pair| pair.overlaps).collect()
            };
        let reports = overlapping(&mut reports.into_iter());
        let field = |&(id, _): &(BodyId, Appearance)| {
            ContactField::new(id, self.scene, reports.iter().copied(), self.reach)
        };
        shown.iter().map(field).collect()
    }

    fn subjects<'s>(
        &'s self,
        shown: &[(BodyId, Appearance)],
        fields: &'s [ContactField],
    ) -> Vec<Subject<'s>> {
        let subject = |(&(id, appearance), field): (&(BodyId, Appearance), &'s ContactField)| {
            let body = self.scene.body(id);
            Subject {
                positions: body.positions(),
                normals: &self.normals[id.index()],
                faces: body.surface().faces(),
                signed_gaps: &field.signed_gaps,
                crossing: &field.crossing,
                colour: self.colours[id.index()],
                appearance,
            }
        };
        shown.iter().zip(fields).map(subject).collect()
    }
}

impl Sight {
    fn draw(title: String, subjects: &[Subject<'_>], camera: &Camera, deepest: f64) -> Self {
        Self {
            title,
            image: draw(subjects, camera, deepest),
            width: camera.width(),
            height: camera.height(),
            span: camera.span(),
            deepest,
        }
    }
}

/// The colour of each body: bone, flesh or sheet, neighbours of one kind in
/// different shades.
fn colours(scene: &Scene) -> Vec<Colour> {
    const SHADES: [f64; 5] = [1.0, 0.80, 1.16, 0.90, 0.72];
    let shade = |(number, body): (usize, &Body)| {
        let colour = match body.kind() {
            BodyKind::Rigid => [0xe8, 0xde, 0xc6],
            BodyKind::Deformable => [0xd6, 0x8c, 0x80],
            BodyKind::Open => [0x8f, 0xae, 0xc8],
        };
        let shade = if body.kind() == BodyKind::Rigid { 1.0 } else { SHADES[number % 5] };
        Colour::from_srgb(colour) * shade
    };
    scene.bodies().iter().enumerate().map(shade).collect()
}

/// Titles and directions (forward, up) of the three sides: the longest
/// direction of the scene stands upright.
fn sides([low, high]: [DVec3; 2]) -> [(String, DVec3, DVec3); 3] {
    let axes = [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)];
    let size = (high - low).to_array();
    // Of equal lengths the last stands: z is up in most data.
    let up = (0..3).max_by(|&i, &j| size[i].total_cmp(&size[j])).unwrap_or(2);
    let (side, front) = (axes[(up + 1) % 3], axes[(up + 2) % 3]);
    [(front, 1.0), (side, -1.0), (front, -1.0)].map(|((name, axis), sign)| {
        let sign_name = if sign > 0.0 { "+" } else { "−" };
        (format!("along {sign_name}{name}"), sign * axis, axes[up].1)
    })
}

fn extent(points: impl Iterator<Item = DVec3>) -> [DVec3; 2] {
    points.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)])
}

/// How one body enters another.
#[derive(Debug)]
struct Entry {
    entered: BodyId,
    /// Points of the entering body in contact.
    points: Vec<DVec3>,
    /// The deepest of them, or their middle where none is inside.
    centre: DVec3,
    /// Out of the entered body.
    outward: DVec3,
    /// Length below which a close-up would show less than a few faces.
    least_radius: f64,
}

impl Entry {
    /// The entering body is the one with the deepest vertex.
    fn of(pair: &PairReport, scene: &Scene) -> Self {
        let deepest = |report: &musculo_collide::VertexReport| {
            report.near.iter().map(|near| near.gap).fold(f64::INFINITY, f64::min)
        };
        let a_enters = deepest(&pair.a_against_b) <= deepest(&pair.b_against_a);
        let (entering, entered, report) = if a_enters {
            (pair.pair.a, pair.pair.b, &pair.a_against_b)
        } else {
            (pair.pair.b, pair.pair.a, &pair.b_against_a)
        };
        let body = scene.body(entering);
        let crossing = || {
            let side = usize::from(!a_enters);
            pair.crossing_faces.iter().map(move |faces| corners(body, faces[side]))
        };
        let inside = || report.near.iter().filter(|near| near.gap < 0.0);
        let mut points: Vec<DVec3> =
            inside().map(|near| body.positions()[near.vertex as usize]).collect();
        let mut outward: DVec3 = inside().map(|near| -near.gap * near.normal).sum();
        let mut centre = inside()
            .min_by(|p, q| p.gap.total_cmp(&q.gap))
            .map(|near| body.positions()[near.vertex as usize]);
        if points.is_empty() {
            outward = -crossing().map(|[p, q, r]| (q - p).cross(r - p)).sum::<DVec3>();
            centre = crossing().next().map(|[p, q, r]| (p + q + r) / 3.0);
        }
        points.extend(crossing().flatten());
        Self {
            entered,
            centre: centre.unwrap_or(DVec3::ZERO),
            outward,
            least_radius: 4.0 * mean_edge(body, &pair.crossing_faces, usize::from(!a_enters)),
            points,
        }
    }

    /// Looks out of the entered body at most of the contact; where it reaches
    /// around a whole bone, at what is around the deepest point.
    fn camera(&self) -> Camera {
        let radius = self.radius();
        let forward = self.outward.normalize_or(DVec3::Y);
        let shown: Vec<DVec3> =
            self.points.iter().copied().filter(|p| p.distance(self.centre) <= radius).collect();
        let margin = 0.45 * radius;
        let around = |point: DVec3| {
            DVec3::AXES
                .into_iter()
                .flat_map(move |axis| [point - margin * axis, point + margin * axis])
        };
        let front = shown.iter().map(|p| (*p - self.centre).dot(forward)).fold(0.0, f64::min);
        let framed = shown.iter().copied().chain([self.centre]).flat_map(around);
        Camera::framing(framed, forward, DVec3::Z, CLOSE_UP)
            .cut_before(self.centre + (front - 0.05 * radius) * forward)
    }

    /// Holds most of the contact.
    fn radius(&self) -> f64 {
        const TENTHS: usize = 9;
        let mut distances: Vec<f64> =
            self.points.iter().map(|point| point.distance(self.centre)).collect();
        distances.sort_by(f64::total_cmp);
        let most = distances.get(distances.len() * TENTHS / 10).copied().unwrap_or(0.0);
        most.max(self.least_radius).max(f64::MIN_POSITIVE)
    }
}

fn corners(body: &Body, face: u32) -> [DVec3; 3] {
    body.surface().faces()[face as usize].map(|vertex| body.positions()[vertex as usize])
}

/// Mean length of an edge of the crossing faces of one side, or of any face.
fn mean_edge(body: &Body, crossing: &[[u32; 2]], side: usize) -> f64 {
    let faces: Vec<u32> = if crossing.is_empty() {
        vec![0]
    } else {
        crossing.iter().map(|faces| faces[side]).collect()
    };
    let around = |face: &u32| {
        let [p, q, r] = corners(body, *face);
        p.distance(q) + q.distance(r) + r.distance(p)
    };
    let count: f64 = faces.iter().map(|_| 3.0).sum();
    faces.iter().map(around).sum::<f64>() / count
}
