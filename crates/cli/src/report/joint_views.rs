//! Pictures of joint contact: each surface as the other one sees it, in the colors of its pressure,
//! or of its gap where nothing presses.

use glam::DVec3;
use musculo_collide::surface::triangle;
use musculo_collide::{Body, JointContact, JointContactParams};
use rayon::prelude::*;

use super::PairContact;
use super::gallery::{CLOSE_UP, ColorScale, Gallery, Quantity, View};
use picture::{Appearance, Camera, ContactPoint, ContactTriangle};

impl Gallery<'_> {
    /// Draws both surfaces of each pair in contact; `done` is called after each pair.
    pub(crate) fn joint_views(
        &self,
        contacts: &[PairContact],
        params: &JointContactParams,
        done: impl Fn() + Sync,
    ) -> Vec<View> {
        let draw_pair = |contact: &PairContact| {
            let views = self.pair_views(contact, params);
            done();
            views
        };
        contacts.par_iter().flat_map_iter(draw_pair).collect()
    }

    fn pair_views(&self, contact: &PairContact, params: &JointContactParams) -> Vec<View> {
        let PairContact { pair, sides } = contact;
        let [a, b] = pair.bodies();
        let mut views = Vec::new();
        for ([own, other], contact) in [[a, b], [b, a]].into_iter().zip(sides) {
            if contact.total.area > 0.0 {
                let [body, against] = [own, other].map(|id| self.scene.body(id));
                let scale = joint_scale(contact, params);
                let triangles = vec![triangles(contact, body, &scale)];
                let subjects = self.subjects(&[(own, Appearance::Solid)], &triangles);
                let title = format!("{} against {}", body.name(), against.name());
                views.push(View::draw(title, &subjects, &camera(contact, body), scale));
            }
        }
        views
    }
}

/// Returns the scale of a contact: pressures where there are some, else gaps from the margin down.
fn joint_scale(contact: &JointContact, params: &JointContactParams) -> ColorScale {
    let (mut min_gap, mut max_pressure) = (params.margin, 0.0_f64);
    for face in contact.faces.iter().filter(|face| face.area > 0.0) {
        min_gap = min_gap.min(face.mean_gap);
        max_pressure = max_pressure.max(face.mean_pressure);
    }
    if max_pressure > 0.0 {
        ColorScale { quantity: Quantity::Pressure, from: 0.0, to: max_pressure }
    } else {
        ColorScale { quantity: Quantity::Gap, from: params.margin, to: min_gap }
    }
}

/// Returns the faces in contact, each with its mean as a value above the start of the scale.
fn triangles(contact: &JointContact, body: &Body, scale: &ColorScale) -> Vec<ContactTriangle> {
    let mut triangles = Vec::new();
    for face in contact.faces.iter().filter(|face| face.area > 0.0) {
        let value = match scale.quantity {
            Quantity::Pressure => face.mean_pressure,
            Quantity::Depth | Quantity::Gap => face.mean_gap,
        };
        let corners = body.corners(face.face);
        let (normal, depth) = (triangle::unit_normal(corners), (value - scale.from).abs());
        triangles.push(corners.map(|at| ContactPoint { at, normal, depth }));
    }
    triangles
}

/// Returns a view of the contact against its mean normal, with some of the surface around it.
fn camera(contact: &JointContact, body: &Body) -> Camera {
    /// Surface that is shown around a contact, relative to the size of the view.
    const AROUND: f64 = 0.2;

    let (mut points, mut normal) = (Vec::new(), DVec3::ZERO);
    for face in contact.faces.iter().filter(|face| face.area > 0.0) {
        let corners = body.corners(face.face);
        points.extend(corners);
        normal += face.area * triangle::unit_normal(corners);
    }
    let radius = points.iter().map(|p| p.distance(contact.total.center)).fold(0.0, f64::max);
    for axis in DVec3::AXES {
        let offset = (1.0 + AROUND) * radius * axis;
        points.extend([contact.total.center - offset, contact.total.center + offset]);
    }
    Camera::framing(points, -normal.normalize_or(DVec3::Y), DVec3::Z, CLOSE_UP)
}
