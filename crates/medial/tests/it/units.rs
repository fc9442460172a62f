//! The same bodies in other units: powers of two, so that all digits are the same.

use glam::DVec3;
use medial::{
    Ball, Deviation, MedialContact, MedialFeature, MedialParams, MedialScratch, MedialSurface,
};
use surface::DirectedHausdorff;

use crate::support::{Detected, generated, muscle};

/// Sizes of units.
fn units() -> [f64; 2] {
    [-90, 90].map(|power| 2.0_f64.powi(power))
}

fn balls_in_unit(unit: f64, medial: &MedialSurface) -> Vec<Ball> {
    let scaled = |ball: &Ball| Ball::new(unit * ball.center, unit * ball.radius);
    medial.balls().iter().map(scaled).collect()
}

fn deviation_in_unit(unit: f64, deviation: &Deviation) -> Deviation {
    let directed = |DirectedHausdorff { lower, upper }: DirectedHausdorff| DirectedHausdorff {
        lower: unit * lower,
        upper: unit * upper,
    };
    Deviation {
        surface_to_medial: directed(deviation.surface_to_medial),
        medial_to_surface: directed(deviation.medial_to_surface),
        rms: unit * deviation.rms,
        p95: unit * deviation.p95,
    }
}

/// Balls, primitives and deviations.
#[test]
fn medial_surfaces_are_the_same_in_any_unit() {
    let mesh = muscle();
    let params = MedialParams::balls(12);
    let one = generated(&mesh, &params).expect("a closed mesh");
    for unit in units() {
        let other = generated(&mesh.clone().mapped(|p| unit * p), &params).expect("as the other");
        assert_eq!(other.medial.primitives(), one.medial.primitives(), "in {unit}");
        assert_eq!(other.medial.balls(), balls_in_unit(unit, &one.medial), "in {unit}");
        assert_eq!(other.deviation, deviation_in_unit(unit, &one.deviation), "in {unit}");
    }
}

/// Contacts of vertices and of balls, and what is near, after both bodies have moved.
#[test]
fn contacts_are_the_same_in_any_unit() {
    let [lifted, turned] =
        [muscle().translated(DVec3::new(3.0, 2.0, 14.0)), muscle().rotated(DVec3::Z, 0.2)];
    let [of_lifted, of_turned] = [&lifted, &turned]
        .map(|mesh| generated(mesh, &MedialParams::balls(12)).expect("a closed mesh").medial);
    let bend = |p: DVec3| p + DVec3::Z * (0.003 * p.x * p.x);
    let found = |unit: f64| {
        let detected = |mesh: &fixtures::Mesh, medial: &MedialSurface, first: u32| {
            let scaled = mesh.clone().mapped(|p| unit * p);
            let mut balls = medial.clone();
            balls.set_balls(&balls_in_unit(unit, medial)).expect("as many");
            let mut detected = Detected::from_medial(&scaled, balls, unit * 0.6, first);
            let moved: Vec<DVec3> = mesh.positions.iter().map(|p| unit * bend(*p)).collect();
            detected.move_to(&moved);
            detected
        };
        let a = detected(&lifted, &of_lifted, 0);
        let mut b = detected(&turned, &of_turned, 100_000);
        let (of_a, of_b) = (a.body(), b.body());
        let scratch = &mut MedialScratch::default();
        let mut contacts = b.detector.vertex_contacts(&of_a, &of_b, scratch);
        contacts.extend(a.detector.pair_contacts(&of_a, &b.detector, &of_b, scratch));
        let mut near = Vec::new();
        b.detector.near_vertices(&of_a, &of_b, unit * 0.3, scratch, &mut near);
        let surface = turned.surface();
        let bound = b.detector.surface_bound(&surface, unit * 0.1, scratch).expect("its surface");
        (contacts, near, bound, b.detector.medial().clone())
    };

    let (contacts, near, bound, medial) = found(1.0);
    let of_vertices = |found: &&MedialContact| matches!(found.feature, MedialFeature::Vertex(_));
    let count = contacts.iter().filter(of_vertices).count();
    assert!(count > 30 && contacts.len() > count + 10 && near.len() > 30, "{count}");
    for unit in units() {
        let (other, other_near, other_bound, other_medial) = found(unit);
        assert_eq!(other_medial.balls(), balls_in_unit(unit, &medial), "in {unit}");
        assert_eq!(other_bound.to_bits(), (unit * bound).to_bits(), "in {unit}");
        assert_eq!((other.len(), other_near.len()), (contacts.len(), near.len()), "in {unit}");
        for (one, other) in contacts.iter().zip(&other) {
            assert_eq!((one.ball, one.feature), (other.ball, other.feature), "in {unit}");
            let (one, other) = (&one.contact, &other.contact);
            assert_eq!((one.stencil, one.normal), (other.stencil, other.normal), "in {unit}");
            assert_eq!((unit * one.gap, unit * one.offset), (other.gap, other.offset));
        }
        for (one, other) in near.iter().zip(&other_near) {
            assert_eq!((one.vertex, one.face), (other.vertex, other.face), "in {unit}");
            assert_eq!((one.normal, unit * one.gap), (other.normal, other.gap), "in {unit}");
        }
    }
}
