//! Soft bodies that move with what they are attached to, where nothing else moves them.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat4, DVec3};
use musculo_collide::kdop::Workspace;
use musculo_collide::{BodyId, Scene};

use super::skin::smooth_step;
use super::{Follows, Replay, RestReason};

/// Two bodies that are attached to each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Attached {
    pub(crate) bodies: [BodyId; 2],
    /// Distance within which they are: 0 where they have nodes in common.
    pub(crate) within: f64,
}

/// Two parts between which a body moves.
#[derive(Debug, PartialEq)]
pub(super) struct Between {
    /// Names of their maps; none for one that rests.
    pub(super) maps: [Option<String>; 2],
    /// Share of the second one for each vertex.
    pub(super) shares: Vec<f64>,
}

/// Body that moves with those to which it is attached.
#[derive(Debug, PartialEq)]
pub(crate) struct AttachedBody {
    pub(crate) body: String,
    /// Those that decide about its motion.
    pub(crate) to: Vec<String>,
}

impl Between {
    /// Computes the positions of the body in a frame.
    pub(super) fn deform(&self, rest: &[DVec3], maps: &BTreeMap<String, DMat4>) -> Vec<DVec3> {
        let map = |name: &Option<String>| name.as_ref().map_or(DMat4::IDENTITY, |name| maps[name]);
        let [first, second] = [map(&self.maps[0]), map(&self.maps[1])];
        let between = |(x, share): (&DVec3, &f64)| {
            (1.0 - share) * first.transform_point3(*x) + *share * second.transform_point3(*x)
        };
        rest.iter().zip(&self.shares).map(between).collect()
    }
}

/// Parts of a motion that bodies are attached to, by their maps: none for one that rests.
type Parts = BTreeMap<Option<String>, Vec<Attached>>;

impl Replay {
    /// Lets soft bodies without a map or a skin move with the bodies to which they are attached: with bones and what
    /// follows a map, and those that are attached to none of these with other tissue. One that is attached to two that
    /// move apart is between them, by its distances from both. Attached to more, it rests. Returns those that move.
    ///
    /// Trees of the scene must be up to date.
    pub(crate) fn follow_attached(
        &mut self,
        scene: &Scene,
        attached: &[Attached],
    ) -> Vec<AttachedBody> {
        let is_soft = |id: BodyId| !scene.body(id).is_rigid();
        let mut is_known: Vec<bool> = Vec::new();
        for (follower, id) in self.followers.iter().zip(scene.ids()) {
            is_known.push(follower.follows != Follows::Nothing || !is_soft(id));
        }

        let mut moved = Vec::new();
        loop {
            // From what is known already, so that the order of bodies does not matter.
            let mut next = Vec::new();
            for id in scene.ids().filter(|id| !is_known[id.index()]) {
                let parts = self.parts_of(id, attached, &is_known);
                if !parts.is_empty() {
                    next.push((id, parts));
                }
            }
            if next.is_empty() {
                break;
            }
            for (id, parts) in next {
                is_known[id.index()] = true;
                let follows = between(scene, id, &parts);
                let body = scene.body(id).name().to_owned();
                if follows == Follows::Nothing {
                    for resting in self.resting.iter_mut().filter(|resting| resting.body == body) {
                        let is_one = parts.len() == 1;
                        resting.reason =
                            if is_one { RestReason::Attached } else { RestReason::AttachedToMany };
                    }
                    continue;
                }
                self.resting.retain(|resting| resting.body != body);
                self.followers[id.index()].follows = follows;
                let of_others = parts.values().flatten().map(|it| other(it, id));
                let to: BTreeSet<BodyId> = of_others.flatten().collect();
                let to = to.into_iter().map(|id| scene.body(id).name().to_owned()).collect();
                moved.push(AttachedBody { body, to });
            }
        }
        moved
    }

    /// Lists the parts that a body is attached to, of bodies that are known and follow one part.
    fn parts_of(&self, id: BodyId, attached: &[Attached], is_known: &[bool]) -> Parts {
        let mut parts = Parts::new();
        for it in attached {
            let Some(other) = other(it, id).filter(|other| is_known[other.index()]) else {
                continue;
            };
            let map = match &self.followers[other.index()].follows {
                Follows::Map(name) => Some(name.clone()),
                Follows::Nothing => None,
                Follows::Skin | Follows::Between(_) => continue,
            };
            parts.entry(map).or_default().push(*it);
        }
        parts
    }
}

/// Returns the other one of two attached bodies; `None` if a body is neither.
fn other(attached: &Attached, id: BodyId) -> Option<BodyId> {
    match attached.bodies {
        [a, b] if a == id => Some(b),
        [a, b] if b == id => Some(a),
        _ => None,
    }
}

/// Returns what a body follows that is attached to some parts.
fn between(scene: &Scene, id: BodyId, parts: &Parts) -> Follows {
    let mut each = parts.iter();
    match (each.next(), each.next(), each.next()) {
        (Some((Some(name), _)), None, None) => Follows::Map(name.clone()),
        (Some((first, of_first)), Some((second, of_second)), None) => {
            let mut shares = Vec::new();
            for &x in scene.body(id).positions() {
                let [near, far] = [of_first, of_second].map(|of| distance(scene, id, of, x));
                let sum = near + far;
                shares.push(if sum > 0.0 { smooth_step(near / sum) } else { 0.5 });
            }
            Follows::Between(Between { maps: [first.clone(), second.clone()], shares })
        }
        _ => Follows::Nothing,
    }
}

/// Returns the distance of a point from the bodies of a part, beyond that within which these are attached.
fn distance(scene: &Scene, id: BodyId, of_part: &[Attached], x: DVec3) -> f64 {
    let mut least = f64::INFINITY;
    for it in of_part {
        let tree = other(it, id).and_then(|other| scene.body(other).tree());
        let closest = tree
            .and_then(|tree| tree.closest_point(x, f64::INFINITY, None, &mut Workspace::default()));
        if let Some(closest) = closest {
            least = least.min((x.distance(closest.foot.point) - it.within).max(0.0));
        }
    }
    least.min(f64::MAX)
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use musculo_collide::BodyKind;
    use musculo_collide::surface::Aabb;

    use super::*;
    use crate::motion::{Follower, Motion};

    const MOVED: DVec3 = DVec3::new(3.0, 0.0, -1.0);

    /// A bone that moves and one that rests, cartilage on each, a meniscus on one of these, and a ligament and a band
    /// between both.
    fn replay() -> (Scene, Replay, Vec<Attached>) {
        let mut scene = Scene::new();
        for (name, kind, x) in [
            ("ligament", BodyKind::Deformable, 0.0),
            ("meniscus", BodyKind::Deformable, -6.0),
            ("cartilage", BodyKind::Deformable, -8.0),
            ("other_cartilage", BodyKind::Deformable, 8.0),
            ("femur", BodyKind::Rigid, -10.0),
            ("tibia", BodyKind::Rigid, 10.0),
            ("free", BodyKind::Deformable, 30.0),
            ("band", BodyKind::Deformable, 0.0),
        ] {
            let size = if x == 0.0 { DVec3::new(18.0, 1.0, 1.0) } else { DVec3::splat(2.0) };
            let mesh = shapes::plate(size, [6, 2]).translated(x * DVec3::X);
            scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body");
        }
        scene.fit_all().expect("trees");
        let mut followers = Vec::new();
        let mut resting = Vec::new();
        for body in scene.bodies() {
            let is_femur = body.name() == "femur";
            let follows =
                if is_femur { Follows::Map("femur".to_owned()) } else { Follows::Nothing };
            followers.push(Follower {
                rest: body.positions().to_vec(),
                bounds: Aabb::of_points(body.positions().iter().copied()),
                follows,
            });
            if !is_femur {
                let reason = RestReason::NoSkin;
                resting.push(crate::motion::RestingBody { body: body.name().to_owned(), reason });
            }
        }
        let maps = |x: DVec3| BTreeMap::from([("femur".to_owned(), DMat4::from_translation(x))]);
        let motion = Motion {
            times: vec![None; 2],
            maps: vec![maps(DVec3::ZERO), maps(MOVED)],
            ..Motion::default()
        };
        let id = |name: &str| scene.find(name).expect("a body");
        let pairs = [
            ("femur", "cartilage"),
            ("other_cartilage", "tibia"),
            ("meniscus", "cartilage"),
            ("ligament", "femur"),
            ("tibia", "ligament"),
            ("band", "ligament"),
        ];
        let attached = |(a, b)| Attached { bodies: [id(a), id(b)], within: 1.0 };
        let attached = pairs.map(attached).to_vec();
        let centers = BTreeMap::new();
        (scene, Replay { motion, followers, resting, centers }, attached)
    }

    #[test]
    fn tissue_moves_with_what_it_is_attached_to() {
        let (scene, mut replay, attached) = replay();
        let moved = replay.follow_attached(&scene, &attached);
        let moved: Vec<(&str, String)> =
            moved.iter().map(|it| (it.body.as_str(), it.to.join(" "))).collect();
        let expected = [
            ("ligament", "femur tibia".to_owned()),
            ("cartilage", "femur".to_owned()),
            ("meniscus", "cartilage".to_owned()),
        ];
        assert_eq!(moved, expected);

        // A band that is tied to what is between two does not move, and says so as others that rest.
        let reason =
            |name: &str| replay.resting.iter().find(|it| it.body == name).map(|it| it.reason);
        assert_eq!(reason("other_cartilage"), Some(RestReason::Attached));
        assert_eq!([reason("free"), reason("band")], [Some(RestReason::NoSkin); 2]);
        assert_eq!(reason("meniscus"), None);

        // Vertices within the distance of a tie are where it holds them, and others between.
        let positions = replay.positions(1);
        let step = |name: &str, vertex: usize| {
            let id = scene.find(name).expect("a body");
            positions[id.index()][vertex] - scene.body(id).positions()[vertex]
        };
        for vertex in 0..scene.body(scene.find("meniscus").expect("a body")).positions().len() {
            assert_eq!((step("meniscus", vertex), step("cartilage", vertex)), (MOVED, MOVED));
        }
        let ligament = scene.find("ligament").expect("a body");
        for (vertex, x) in scene.body(ligament).positions().iter().enumerate() {
            let share = step("ligament", vertex).length() / MOVED.length();
            let expected = match x.x {
                x if x < -8.0 => 1.0..=1.0,
                x if x > 8.0 => 0.0..=0.0,
                x if x.abs() < 0.1 => 0.499..=0.501,
                x if x < 0.0 => 0.5..=1.0,
                _ => 0.0..=0.5,
            };
            assert!(expected.contains(&share), "{x}: {share}");
        }

        // So does its path to the next frame.
        let path = replay.path(ligament.index(), 0);
        for (vertex, x) in (0..).zip(&positions[ligament.index()]) {
            let end = musculo_collide::Path::position(&path, vertex, 1.0);
            assert!(end.distance(*x) < 1e-12, "{vertex}");
        }
    }
}
