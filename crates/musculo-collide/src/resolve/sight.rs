//! What is between bodies, round by round: pairs of which neither body moved
//! are as they were, and are not looked at again.

use surface::Contact;

use super::contacts;
use crate::pair::{self, Scratch};
use crate::{PairReport, Scene, SceneError, parallel};

/// All pairs within the margin, and how far their edges pass beyond each other.
/// Distances between surfaces and patches are left out.
#[derive(Clone, Debug, Default)]
pub(super) struct Sight {
    pub(super) pairs: Vec<PairReport>,
    pub(super) edges: Vec<Vec<Contact>>,
}

impl Sight {
    /// Looks at every pair.
    pub(super) fn first(scene: &mut Scene, margin: f64) -> Result<Self, SceneError> {
        let all = vec![true; scene.bodies().len()];
        Self::default().again(scene, margin, &all)
    }

    /// Looks again at the pairs of bodies that have moved.
    pub(super) fn again(
        self,
        scene: &mut Scene,
        margin: f64,
        moved: &[bool],
    ) -> Result<Self, SceneError> {
        scene.bound_states()?;
        let scene = &*scene;
        let is_moved = |pair: &PairReport| moved[pair.a.index()] || moved[pair.b.index()];
        let stale: Vec<_> = scene
            .pairs_within(margin)
            .into_iter()
            .filter(|&(a, b)| moved[a.index()] || moved[b.index()])
            .collect();
        let looked = parallel::map_with(&stale, Scratch::default, |scratch, &(a, b)| {
            let report = pair::glance((a, scene.body(a)), (b, scene.body(b)), margin, scratch)?;
            let edges = contacts::of_edges(scene, &report);
            Some((report, edges))
        });
        let kept = self.pairs.into_iter().zip(self.edges).filter(|(pair, _)| !is_moved(pair));
        let mut seen: Vec<_> = kept.chain(looked.into_iter().flatten()).collect();
        seen.sort_unstable_by_key(|(pair, _)| (pair.a, pair.b));
        let (pairs, edges) = seen.into_iter().unzip();
        Ok(Self { pairs, edges })
    }
}
