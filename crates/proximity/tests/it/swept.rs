//! Swept queries with parameters out of range.

use ccd::{CcdError, CcdParams, MovingPoints};
use fixtures::shapes::cube;
use glam::DVec3;
use kdop::{StepTree, Workspace};
use proximity::{SurfaceTree, SweptError, SweptQuery, SweptSide};
use surface::progress::Progress;

/// Bodies so far apart that no query is made.
#[test]
fn parameters_out_of_range_are_refused_without_a_query() {
    let [a, b] = [0.0, 100.0].map(|x| {
        let mesh = cube(1.0).translated(x * DVec3::X);
        SurfaceTree::new(mesh.surface(), mesh.positions).expect("a tree")
    });
    let mut x = a.positions().as_slice().to_vec();
    let second = u32::try_from(x.len()).expect("few");
    x.extend_from_slice(b.positions().as_slice());
    let motion = MovingPoints::new(&x, &x).expect("finite points");

    let run = |params: &CcdParams| {
        let [of_a, of_b] = [(&a, 0), (&b, second)].map(|(body, first_particle)| SweptSide {
            surface: body.surface(),
            tree: StepTree::at_rest(body.tree()),
            first_particle,
        });
        let query = SweptQuery::new(&motion, params);
        query.run(&of_a, &of_b, &mut Workspace::default(), Progress::none())
    };
    assert_eq!(run(&CcdParams::DEFAULT).expect("in range").candidates, 0);
    let params = CcdParams { min_separation: -1.0, ..CcdParams::DEFAULT };
    assert_eq!(run(&params), Err(SweptError::Ccd(CcdError::MinSeparation(-1.0))));
    let params = CcdParams { t_max: 2.0, ..CcdParams::DEFAULT };
    assert_eq!(run(&params), Err(SweptError::Ccd(CcdError::TimeMax(2.0))));
}
