//! The same bits for any number of threads.

use glam::DVec3;
use medial::{Deviation, Generated, Links, MedialParams, generate_each};
use surface::progress::Progress;

use crate::support::muscle;

/// Two sizes, and the deviation of one of them after the belly has shortened.
fn sizes_and_deviation() -> (Vec<Generated>, Deviation) {
    let mesh = muscle();
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("finite");
    let params = MedialParams::balls(1);
    let made = generate_each(&surface, x, &[20, 40], &params, Progress::none()).expect("closed");
    let links = Links::new(&made[1].medial, &surface, x).expect("finite");
    let short = mesh.clone().scaled(DVec3::new(0.75, 1.15, 1.15));
    let x = surface.positions(&short.positions).expect("finite");
    let mut medial = made[1].medial.clone();
    links.follow(&mut medial, x).expect("its own links");
    let deviation = Deviation::measure(&medial, &surface, x).expect("closed");
    (made, deviation)
}

#[test]
fn one_two_and_seven_threads_agree_to_the_bit() {
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads start").install(sizes_and_deviation)
    };
    let one = with(1);
    assert_eq!(one, with(2));
    assert_eq!(one, with(7));
}
