//! Model of a page: bodies, overlaps and frames.

use std::collections::BTreeMap;

use glam::{DMat4, DVec3};
use musculo_collide::surface::Aabb;
use musculo_collide::{Body, BodyId, Depth, PairReport, Scene};
use serde::Serialize;

use super::blob::{Blob, Quantizer, Span, fraction};
use super::coarse::{ShownSurface, ShownSurfaces};
use crate::motion::Replay;
use crate::report::body_color::colors;
use crate::report::contact_field::ContactField;
use crate::report::frame_times::FrameTimes;
use crate::scene::Unit;
use picture::{ContactTriangle, viridis};

/// Bodies, overlaps and frames that a page shows.
#[derive(Debug, Serialize)]
pub(crate) struct Model {
    unit: &'static str,
    /// Box of all positions, of which they are fractions.
    origin: DVec3,
    extent: DVec3,
    /// Corners of the box of all bodies in all frames, which the camera has in view.
    view: [DVec3; 2],
    /// Axis that is upright: the longest.
    up: usize,
    /// Depth at the end of the color scale.
    max_depth: f64,
    /// Color scale in 17 steps.
    ramp: Vec<[u8; 3]>,
    bodies: Vec<ModelBody>,
    /// Parts of surfaces inside other bodies, where they are clipped.
    patches: Vec<Patch>,
    frames: Vec<ModelFrame>,
    #[serde(skip)]
    blob: Blob,
}

/// Body of a page.
#[derive(Debug, Serialize)]
struct ModelBody {
    name: String,
    color: [u8; 3],
    vertices: Span,
    #[serde(flatten)]
    corners: Corners,
    /// Maps that move the body, by their numbers in a frame; none for a part at rest.
    maps: Vec<Option<usize>>,
}

/// Part of two surfaces inside each other, as triangles with depths.
#[derive(Debug, Serialize)]
struct Patch {
    a: usize,
    b: usize,
    vertices: Span,
    #[serde(flatten)]
    corners: Corners,
}

/// Corners of triangles, as numbers of vertices.
#[derive(Debug, Serialize)]
struct Corners {
    faces: Span,
    /// True if corners have 32 bits.
    wide: bool,
}

/// Frame of a page.
#[derive(Debug, Serialize)]
struct ModelFrame {
    /// Time in seconds, as it is shown.
    time: Option<String>,
    pairs: Vec<ModelPair>,
    /// Upper rows of the maps.
    maps: Option<Span>,
    /// Depths of vertices inside other bodies, per body.
    depths: Option<Vec<Span>>,
}

/// Overlapping pair of a frame.
#[derive(Clone, Debug, Serialize)]
struct ModelPair {
    a: usize,
    b: usize,
    depth: f64,
    /// Deepest point, or the middle of the overlap.
    at: Option<DVec3>,
}

/// Frame of a motion before its depths are scaled.
#[derive(Debug)]
struct RecordedFrame {
    time: Option<f64>,
    pairs: Vec<ModelPair>,
    /// Vertices in the page's numbers with their depths, per body.
    depths: Vec<Vec<(u32, f64)>>,
}

/// Motion that is being recorded for a page.
#[derive(Debug)]
pub(crate) struct Recording {
    surfaces: Vec<ShownSurface>,
    frames: Vec<RecordedFrame>,
    /// Box of all bodies in all frames.
    bounds: Aabb,
}

impl ModelPair {
    /// Returns the overlapping pairs of reports, the deepest first.
    fn deepest_first<'a>(reports: impl IntoIterator<Item = &'a PairReport>) -> Vec<Self> {
        let mut pairs: Vec<Self> = reports.into_iter().filter_map(Self::new).collect();
        pairs.sort_by(|p, q| q.depth.total_cmp(&p.depth));
        pairs
    }

    /// Returns the overlapping pair of a report, if it is one.
    fn new(report: &PairReport) -> Option<Self> {
        if !report.overlaps {
            return None;
        }
        let mut deepest: Option<Depth> = None;
        let mut centroid = None;
        if let Some(overlap) = &report.overlap {
            let depths = [overlap.depth_of_a_in_b, overlap.depth_of_b_in_a].into_iter().flatten();
            deepest = depths.max_by(|p, q| p.lower.total_cmp(&q.lower));
            centroid = overlap.measures.total.centroid;
        }
        Some(Self {
            a: report.pair.a.index(),
            b: report.pair.b.index(),
            depth: deepest.map_or(report.max_vertex_depth, |depth| depth.lower),
            at: deepest.map(|depth| depth.point).or(centroid),
        })
    }
}

impl Model {
    /// Builds the model of one state, with clipped parts of overlaps per pair.
    pub(crate) fn of_state(
        scene: &Scene,
        surfaces: &ShownSurfaces,
        unit: Unit,
        overlaps: &[(&PairReport, [&[ContactTriangle]; 2])],
    ) -> Self {
        let pairs = ModelPair::deepest_first(overlaps.iter().map(|&(report, _)| report));
        let max_depth = pairs.first().map_or(0.0, |deepest| deepest.depth);

        let bounds = bounds(scene);
        let mut model = Self::new(unit, bounds, bounds, max_depth);
        model.add_bodies(scene, &surfaces.0, None);
        for (report, sides) in overlaps {
            model.add_patch(report, sides);
        }
        model.frames.push(ModelFrame { time: None, pairs, maps: None, depths: None });
        model
    }

    /// Begins a model of bodies within a box at rest, and within another one in all frames.
    fn new(unit: Unit, at_rest: Aabb, in_frames: Aabb, max_depth: f64) -> Self {
        let Quantizer { origin, extent } = Quantizer::new(at_rest);
        let sides = extent.to_array();
        let up = (0..3).max_by(|&i, &j| sides[i].total_cmp(&sides[j])).unwrap_or(2);
        let ramp = (0_u8..=16).map(|step| viridis(f64::from(step) / 16.0).to_srgb()).collect();
        Self {
            unit: unit.symbol(),
            origin,
            extent,
            view: [in_frames.min, in_frames.max],
            up,
            max_depth,
            ramp,
            bodies: Vec::new(),
            patches: Vec::new(),
            frames: Vec::new(),
            blob: Blob::default(),
        }
    }

    /// Returns the arrays of the page.
    pub(super) fn bytes(&self) -> &[u8] {
        self.blob.bytes()
    }

    fn quantizer(&self) -> Quantizer {
        Quantizer { origin: self.origin, extent: self.extent }
    }

    /// Adds all bodies at rest, with the parts of a motion that move them.
    fn add_bodies(&mut self, scene: &Scene, surfaces: &[ShownSurface], replay: Option<&Replay>) {
        let quantizer = self.quantizer();
        for (((number, body), shown), color) in
            scene.bodies().iter().enumerate().zip(surfaces).zip(colors(scene))
        {
            let rest = replay.map_or(body.positions(), |replay| replay.rest(number));
            let mut places = Vec::with_capacity(shown.vertices.len());
            for &vertex in &shown.vertices {
                let position = rest[vertex as usize];
                let [x, y, z] = quantizer.place(position);
                let share = replay.map_or((0, 0.0), |replay| replay.share(number, vertex));
                places.push([x, y, z, packed(share)]);
            }

            let corners = self.add_corners(&shown.faces, places.len());
            self.bodies.push(ModelBody {
                name: body.name().to_owned(),
                color: color.to_srgb(),
                vertices: self.blob.add_u16(&places),
                corners,
                maps: replay.map_or_else(|| vec![None], |replay| replay.maps_of(number)),
            });
        }
    }

    /// Adds corners of triangles, in half the room where vertices are few.
    fn add_corners(&mut self, faces: &[[u32; 3]], vertices: usize) -> Corners {
        if vertices > usize::from(u16::MAX) {
            return Corners { faces: self.blob.add_u32(faces), wide: true };
        }
        let faces: Vec<[u16; 3]> = faces.iter().map(|face| face.map(narrow)).collect();
        Corners { faces: self.blob.add_u16(&faces), wide: false }
    }

    /// Adds the triangles of an overlap, with depths relative to the end of the scale. Corners at
    /// one place are one vertex.
    fn add_patch(&mut self, report: &PairReport, sides: &[&[ContactTriangle]; 2]) {
        let quantizer = self.quantizer();
        let scale = 1.0 / self.max_depth.max(f64::MIN_POSITIVE);
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        let mut numbers: BTreeMap<[u16; 4], u32> = BTreeMap::new();

        for triangle in sides.iter().copied().flatten() {
            faces.push(triangle.map(|point| {
                let [x, y, z] = quantizer.place(point.at);
                let vertex = [x, y, z, fraction(point.depth * scale, u16::MAX)];
                *numbers.entry(vertex).or_insert_with(|| {
                    vertices.push(vertex);
                    u32::try_from(vertices.len() - 1).unwrap_or(u32::MAX)
                })
            }));
        }
        let corners = self.add_corners(&faces, vertices.len());
        let vertices = self.blob.add_u16(&vertices);
        let (a, b) = (report.pair.a.index(), report.pair.b.index());
        self.patches.push(Patch { a, b, vertices, corners });
    }
}

impl Recording {
    /// Largest number of maps that one body of a page follows.
    pub(crate) const MAX_MAPS: usize = 32;

    /// Begins with the bodies of a scene at rest.
    pub(crate) fn new(scene: &Scene) -> Self {
        Self { surfaces: ShownSurfaces::new(scene).0, frames: Vec::new(), bounds: Aabb::EMPTY }
    }

    /// Adds a frame, in which the scene is.
    pub(crate) fn add(&mut self, time: Option<f64>, scene: &Scene, reports: &[PairReport]) {
        let pairs = ModelPair::deepest_first(reports);
        let ids: Vec<BodyId> = scene.ids().collect();
        let mut depths = Vec::new();
        for (&id, shown) in ids.iter().zip(&self.surfaces) {
            let field = ContactField::new(id, scene, reports, 0.0);
            let mut inside = Vec::new();
            for (vertex, &number) in (0_u32..).zip(&shown.vertices) {
                let depth = field.depths[number as usize];
                if depth > 0.0 {
                    inside.push((vertex, depth));
                }
            }
            depths.push(inside);
        }
        self.frames.push(RecordedFrame { time, pairs, depths });
        self.bounds = self.bounds.union(bounds(scene));
    }

    /// Builds the model of all frames.
    pub(crate) fn finish(self, scene: &Scene, replay: &Replay, unit: Unit) -> Model {
        let mut max_depth = 0.0_f64;
        let mut at_rest = Aabb::EMPTY;
        for frame in &self.frames {
            for pair in &frame.pairs {
                max_depth = max_depth.max(pair.depth);
            }
        }
        for body in 0..scene.bodies().len() {
            at_rest = at_rest.union(replay.rest_bounds(body));
        }

        let mut model = Model::new(unit, at_rest, self.bounds, max_depth);
        model.add_bodies(scene, &self.surfaces, Some(replay));
        let times = FrameTimes::new(self.frames.iter().map(|frame| frame.time));
        for (number, RecordedFrame { time, pairs, depths }) in self.frames.into_iter().enumerate() {
            let maps: Vec<[f32; 12]> = replay.maps(number).map(upper_rows).collect();
            let maps = Some(model.blob.add_f32(&maps));
            let mut spans = Vec::new();
            for inside in depths {
                spans.push(model.add_depths(&inside));
            }
            let time = time.map(|time| times.text(Some(time)));
            model.frames.push(ModelFrame { time, pairs, maps, depths: Some(spans) });
        }
        model
    }
}

impl Model {
    /// Adds the depths of vertices: the number of each in two halves, and its depth relative to the
    /// end of the scale.
    fn add_depths(&mut self, inside: &[(u32, f64)]) -> Span {
        let scale = 1.0 / self.max_depth.max(f64::MIN_POSITIVE);
        let mut entries = Vec::with_capacity(inside.len());
        for &(vertex, depth) in inside {
            let [low, high] = [vertex & 0xffff, vertex >> 16];
            // A vertex inside is colored, however shallow.
            let share = fraction(depth * scale, u16::MAX).max(1);
            entries.push([narrow(low), narrow(high), share]);
        }
        self.blob.add_u16(&entries)
    }
}

/// Returns the box around the faces of all bodies.
fn bounds(scene: &Scene) -> Aabb {
    scene.bodies().iter().map(Body::face_bounds).fold(Aabb::EMPTY, Aabb::union)
}

/// Returns a number of 16 bits, which it is known to have.
fn narrow(number: u32) -> u16 {
    u16::try_from(number).unwrap_or(u16::MAX)
}

/// Packs the number of a body's map, and the share of the next one, into 5 and 11 bits.
fn packed((map, share): (usize, f64)) -> u16 {
    const ONE: u16 = (1 << 11) - 1;
    let map = u16::try_from(map).unwrap_or(0).min(31);
    (map << 11) | fraction(share, ONE)
}

#[expect(clippy::cast_possible_truncation, reason = "a picture needs no more digits")]
fn upper_rows(map: &DMat4) -> [f32; 12] {
    let rows = map.transpose().to_cols_array();
    std::array::from_fn(|i| rows[i] as f32)
}
