//! The lowest value on a straight way, beside many samples of it.

use distance_field::{DistanceField, FieldGrid, Interpolation, Storage};
use fixtures::random::Random;
use glam::DVec3;

/// Values that have nothing to do with each other, and ways in all directions,
/// some along the axes or through nodes and some that leave the grid.
fn each_case(mut check: impl FnMut(&DistanceField, [DVec3; 2])) {
    const STEPS: f64 = 8.0;
    let mut random = Random(1);
    for case in 0..300 {
        let point = |random: &mut Random| DVec3::from_array([(); 3].map(|()| random.unit()));
        let (origin, spacing) = (point(&mut random), 0.5 + random.unit());
        let grid = FieldGrid::new(origin, spacing, [5, 4, 6]).expect("a small grid");
        let values = (0..grid.node_count()).map(|_| f32::from(random.byte()) / 256.0).collect();
        let step = 1e-4;
        let storage = [Storage::Float, Storage::Quantized { step }];
        let field = DistanceField::from_values(grid, values, storage[case % 2]);
        let field = field.expect("as many values as nodes");
        let size = spacing * DVec3::new(4.0, 3.0, 5.0);
        let mut end = || {
            let share = 1.4 * point(&mut random) - 0.2;
            let is_on_lattice = case % 4 == 0;
            let share = if is_on_lattice { (STEPS * share).floor() / STEPS } else { share };
            origin + share * size
        };
        check(&field, [end(), end()]);
    }
}

#[test]
fn no_point_of_a_way_is_lower() {
    let mut closest = f64::INFINITY;
    each_case(|field, [a, b]| {
        let at = |share: f64| field.evaluate(a.lerp(b, share), Interpolation::Trilinear);
        let samples = (0..=2000).map(|k| f64::from(k) / 2000.0);
        let sampled = samples.filter_map(at).map(|sample| sample.distance).min_by(f64::total_cmp);
        let Some(sampled) = sampled else { return };
        let lowest = field.min_along_segment([a, b], f64::INFINITY).expect("there are samples");
        assert!(lowest.distance <= sampled + 1e-12, "{lowest:?} above {sampled}");
        closest = closest.min(sampled - lowest.distance);
        // Rounding may carry a place on the border outside.
        if let Some(there) = at(lowest.t.clamp(1e-12, 1.0 - 1e-12)) {
            assert!((there.distance - lowest.distance).abs() < 1e-9, "{lowest:?}, {there:?}");
        }
    });
    assert!(closest < 1e-4, "samples that are never as low show nothing: {closest}");
}

#[test]
fn what_is_not_low_enough_is_not_told() {
    let mut told = 0;
    each_case(|field, ends| {
        let Some(lowest) = field.min_along_segment(ends, f64::INFINITY) else { return };
        assert_eq!(field.min_along_segment(ends, lowest.distance), Some(lowest));
        assert_eq!(field.min_along_segment(ends, lowest.distance - 1e-9), None);
        told += 1;
    });
    assert!(told > 200, "{told}");
}

/// Ways so long that rounding moves their points by cells.
#[test]
fn no_way_is_lower_than_all_nodes() {
    let mut found = 0;
    each_case(|field, [a, b]| {
        let lowest = field.values().into_iter().fold(f32::INFINITY, f32::min);
        for length in [1e15, 1e16, 1e17] {
            let along = length * (b - a);
            if let Some(minimum) = field.min_along_segment([a - along, b + along], f64::INFINITY) {
                assert!(minimum.distance >= f64::from(lowest) - 1e-9, "{minimum:?} {lowest}");
                found += 1;
            }
        }
    });
    assert!(found > 200, "{found}");
}

#[test]
fn a_way_without_numbers_or_length() {
    let grid = FieldGrid::new(DVec3::ZERO, 1.0, [2, 2, 2]).expect("a cell");
    let field = DistanceField::from_values(grid, vec![0.0; 8], Storage::Float).expect("a field");
    for bad in [f64::NAN, f64::INFINITY] {
        for ends in [[DVec3::splat(bad), DVec3::ZERO], [DVec3::ZERO, DVec3::splat(bad)]] {
            assert_eq!(field.min_along_segment(ends, 1.0), None);
        }
    }
    assert!(field.min_along_segment([DVec3::splat(0.5); 2], 1.0).is_some());
    assert_eq!(field.min_along_segment([DVec3::splat(2.0); 2], 1.0), None);
}
