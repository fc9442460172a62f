//! Ties that give way where faces would turn over by them: held and free vertices may stand side by side along a rough
//! interface.

use crate::ResolveError;
use crate::attempts::Attempts;

/// Attempts with ever more vertices let go. Below, few of a rough interface are found; above, what ties do not hold up
/// takes longer.
const MAX_ATTEMPTS: usize = 6;

impl Attempts<'_> {
    /// Removes overlaps with tied vertices let go at faces that would turn over, and with more of them as long as there
    /// are others, if that leaves less.
    pub(crate) fn loosen_ties(&mut self) -> Result<(), ResolveError> {
        if !self.end.may_be_better() {
            return Ok(());
        }
        let mut tried = self.exempt.clone();
        for _ in 0..MAX_ATTEMPTS {
            let known = tried.loose.len();
            tried.loose.extend(std::mem::take(&mut self.strained_ties));
            if tried.loose.len() == known {
                break;
            }
            let worse = self.try_again(self.start.params, &tried)?;
            if worse.is_none() {
                self.exempt.clone_from(&tried);
                if !self.end.may_be_better() {
                    break;
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use glam::DVec3;
    use scene::{BodyId, BodyKind, Scene};
    use surface::progress::Progress;

    use super::*;
    use crate::attempts::Start;
    use crate::run::Run;
    use crate::soft_positions::soft_positions;
    use crate::{Conditions, ResolveParams, Tie};

    /// A soft plate that is tied to a bone below it, and a post that is in its side just above the bone.
    fn tied_plate() -> (Scene, Conditions, ResolveParams) {
        let bone = shapes::plate(DVec3::new(30.0, 30.0, 6.0), [10, 10]);
        let soft = shapes::plate(DVec3::new(20.0, 20.0, 3.0), [20, 20]);
        let post = shapes::icosphere(2.0, 2).translated(DVec3::new(11.2, 0.3, 0.52));
        let mut scene = Scene::new();
        for (name, kind, mesh) in [
            ("bone", BodyKind::Rigid, bone.translated(DVec3::Z * -3.0)),
            ("soft", BodyKind::Deformable, soft.translated(DVec3::Z * 1.51)),
            ("post", BodyKind::Rigid, post),
        ] {
            scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body");
        }
        let [bone, soft, post] = ["bone", "soft", "post"].map(|name| id(&scene, name));
        scene.ignore(bone, post);
        let ties = vec![Tie { bodies: [soft, bone], distance: 0.1 }];
        let conditions = Conditions { ties, ..Conditions::default() };
        let params = ResolveParams { gap: 0.05, ..ResolveParams::for_overlaps(0.8, 1.0) };
        (scene, conditions, params)
    }

    fn id(scene: &Scene, name: &str) -> BodyId {
        scene.find(name).expect("a body")
    }

    #[test]
    fn ties_around_a_face_that_turned_over_are_strained() {
        let (mut scene, conditions, params) = tied_plate();
        let soft = id(&scene, "soft");
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        assert_eq!(run.broken_limits(true).expect("limits"), []);
        assert!(run.strained_ties.is_empty(), "{:?}", run.strained_ties);

        // A corner of the lower side across its neighbors, and one of the upper side, which is not tied.
        for (height, is_tied) in [(0.01, true), (3.01, false)] {
            let is_corner = |x: &&DVec3| x.truncate().length() < 0.1 && (x.z - height).abs() < 0.1;
            assert_eq!(run.scene.body(soft).positions().iter().filter(is_corner).count(), 1);
            let moved = |x: &DVec3| if is_corner(&x) { *x + 1.7 * DVec3::X } else { *x };
            run.move_soft(|_, from| Some(from.iter().map(moved).collect())).expect("a state");
            let broken = run.broken_limits(false).expect("limits");
            assert!(broken.len() == 1 && broken[0].flipped_faces > 0, "{broken:?}");
            let x = run.tissues[soft.index()].rest.clone();
            let near = |&(body, vertex): &(BodyId, u32)| {
                let x = x[vertex as usize];
                body == soft && x.z < 0.1 && x.truncate().length() < 3.2
            };
            assert_eq!(!run.strained_ties.is_empty(), is_tied, "{:?}", run.strained_ties);
            assert!(run.strained_ties.iter().all(near), "{:?}", run.strained_ties);
            run.restore().expect("the start");
            run.detect_moved(&[true; 3]).expect("contacts");
        }
    }

    #[test]
    fn ties_are_let_go_where_that_leaves_less() {
        let (start, conditions, params) = tied_plate();
        let soft = id(&start, "soft");
        let rest = soft_positions(&start);
        let near_post = |(vertex, x): (u32, &DVec3)| {
            let is_near = x.z < 0.1 && x.distance(DVec3::new(11.2, 0.3, 0.52)) < 4.0;
            is_near.then_some((soft, vertex))
        };
        let held: Vec<_> = (0..).zip(&rest[soft.index()]).filter_map(near_post).collect();
        assert!(held.len() > 10, "{held:?}");
        for strained in [held, Vec::new()] {
            let mut scene = start.clone();
            let start = Start { params, conditions: &conditions, ties: None, carried: &[] };
            let attempts = Attempts::begin(start, &mut scene, Progress::none());
            let mut attempts = attempts.expect("a resolution");
            let first = &attempts.end;
            assert!(!first.resolved && first.ties[0].loose == 0, "{:?}", first.ties);
            let left = first.left();
            attempts.strained_ties.clone_from(&strained);
            attempts.loosen_ties().expect("a resolution");
            let Attempts { end, exempt, .. } = attempts;
            assert_eq!(end.ties[0].loose, strained.len());
            assert_eq!(exempt.loose.len(), strained.len());
            assert_eq!(end.resolved || end.left() < left, !strained.is_empty());
            assert_eq!(end.ties[0].tied + strained.len(), 441);
        }
    }
}
