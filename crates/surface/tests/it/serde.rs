//! Plain data written and read back.

use surface::glam::DVec3;
use surface::{
    Contact, Inspection, Meeting, Pseudonormals, Stencil, Term, TriangleSurface,
    closest_between_segments, closest_on_triangle, inspect,
};

fn assert_survives<T>(value: &T)
where
    T: serde::Serialize + serde::de::DeserializeOwned + PartialEq + std::fmt::Debug,
{
    let text = serde_json::to_string(value).expect("writable");
    let back: T = serde_json::from_str(&text).expect("readable");
    assert_eq!(&back, value, "{text}");
}

#[test]
fn plain_data_survives_writing_and_reading() {
    let surface = TriangleSurface::new(4, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3]]).unwrap();
    let x = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let x = surface.positions(&x).unwrap();
    let report: Inspection = inspect(&surface, x);
    assert!(!report.findings.is_empty());
    assert_survives(&report);
    assert_survives(&Pseudonormals::new(&surface, x));
    assert_survives(&closest_on_triangle(DVec3::ONE, x.corners([0, 1, 2])));
    assert_survives(&closest_between_segments([DVec3::X, DVec3::Y], [DVec3::Z, DVec3::ONE]));
    assert_survives(&Meeting::Touching);
    assert_survives(&Contact {
        stencil: Stencil::new(&[Term { particle: 3, weight: -1.0 }]).unwrap(),
        anchor: None,
        normal: DVec3::Z,
        offset: 0.0,
        gap: -0.25,
        time: Some(0.5),
    });
}
