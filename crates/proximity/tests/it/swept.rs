//! First contacts during a step, beside those of all vertices, edges and faces.

use ccd::{CandidateContact, CcdError, CcdParams, MovingPoints};
use fixtures::shapes::{self, cube};
use glam::DVec3;
use kdop::{StepTree, Workspace};
use proximity::{ContactKind, SurfaceTree, SweptContact, SweptError, SweptQuery, SweptSide};
use surface::TriangleSurface;
use surface::progress::Progress;

/// Two bodies at both ends of a step, the particles of the second after those of the first.
struct Step {
    trees: [[SurfaceTree; 2]; 2],
    ends: [Vec<DVec3>; 2],
}

impl Step {
    /// Moves each vertex of two bodies.
    fn new(bodies: [&fixtures::Mesh; 2], moved: impl Fn(usize, DVec3) -> DVec3) -> Self {
        let trees = [0, 1].map(|body| {
            let start = SurfaceTree::new(bodies[body].surface(), bodies[body].positions.clone());
            let start = start.expect("a tree");
            let mut end = start.clone();
            end.set_positions(bodies[body].positions.iter().map(|x| moved(body, *x)))
                .expect("finite");
            [start, end]
        });
        let ends = [0, 1].map(|end| {
            let of = |body: usize| trees[body][end].positions().as_slice().to_vec();
            [of(0), of(1)].concat()
        });
        Self { trees, ends }
    }

    fn motion(&self) -> MovingPoints<'_> {
        MovingPoints::new(&self.ends[0], &self.ends[1]).expect("finite points")
    }

    fn sides(&self) -> [SweptSide<'_>; 2] {
        let mut first_particle = 0;
        [0, 1].map(|body| {
            let [start, end] = &self.trees[body];
            let tree = StepTree::new(start.tree(), end.tree()).expect("one arrangement");
            let side = SweptSide { surface: start.surface(), tree, first_particle };
            first_particle += u32::try_from(start.surface().vertex_count()).expect("few");
            side
        })
    }
}

/// Lists all vertices of one side against all faces of the other, both ways.
fn all_vertex_faces([a, b]: [(&TriangleSurface, u32); 2]) -> Vec<[u32; 4]> {
    let mut all = Vec::new();
    for [(p, first_p), (q, first_q)] in [[a, b], [b, a]] {
        for vertex in 0..u32::try_from(p.vertex_count()).expect("few") {
            for [r, s, t] in q.faces().iter().map(|face| face.map(|corner| first_q + corner)) {
                all.push([first_p + vertex, r, s, t]);
            }
        }
    }
    all
}

fn all_edge_edges([(a, first_a), (b, first_b)]: [(&TriangleSurface, u32); 2]) -> Vec<[u32; 4]> {
    let mut all = Vec::new();
    for [p, q] in a.edges() {
        for [r, s] in b.edges() {
            all.push([first_a + p, first_a + q, first_b + r, first_b + s]);
        }
    }
    all
}

/// Particles of a contact, in no order, with its kind and the bits of its interval.
type Key = ([u32; 4], bool, [u64; 2]);

fn key(kind: ContactKind, mut particles: [u32; 4], interval: [f64; 2]) -> Key {
    particles.sort_unstable();
    (particles, kind == ContactKind::VertexFace, interval.map(f64::to_bits))
}

fn keys(kind: ContactKind, queries: &[[u32; 4]], found: &[CandidateContact]) -> Vec<Key> {
    let of = |found: &CandidateContact| {
        key(kind, queries[found.candidate], [found.contact.lo, found.contact.hi])
    };
    found.iter().map(of).collect()
}

/// Computes the contacts of all vertices, edges and faces, in the order of their keys.
fn brute_force(step: &Step, params: &CcdParams) -> Vec<Key> {
    let sides = step.sides().map(|side| (side.surface, side.first_particle));
    let motion = step.motion();
    let queries = all_vertex_faces(sides);
    let found = motion.vertex_face_contacts(&queries, params).expect("in range");
    let mut all = keys(ContactKind::VertexFace, &queries, &found);
    let queries = all_edge_edges(sides);
    let found = motion.edge_edge_contacts(&queries, params).expect("in range");
    all.extend(keys(ContactKind::EdgeEdge, &queries, &found));
    all.sort_unstable();
    all
}

/// Checks that a contact is of its particles at its time.
fn check_contact(found: &SweptContact, motion: &MovingPoints<'_>, params: &CcdParams) {
    let time = found.contact.time.expect("a time");
    assert!(time <= found.latest, "{found:?}");
    let offset = found.contact.offset;
    assert_eq!(offset.to_bits(), params.min_separation.to_bits(), "{found:?}");
    let error = found.contact.identity_error(|particle| motion.at(particle, time));
    assert!(error < 1e-12, "{error}: {found:?}");
}

/// A ball that turns and grows while it flies by, or through, another one.
#[test]
fn contacts_of_a_step_are_those_of_all_vertices_edges_and_faces() {
    let bodies = [shapes::icosphere(4.0, 2), shapes::octasphere(3.0, 2)];
    let mut contacts = 0;
    for (start, end, min_separation) in [
        (DVec3::new(7.2, 0.5, 0.1), DVec3::new(6.0, 0.2, 0.4), 0.0),
        (DVec3::new(7.2, 0.5, 0.1), DVec3::new(6.9, 0.2, 0.4), 0.1),
        (DVec3::new(9.0, -6.0, 0.3), DVec3::new(3.0, 7.0, 0.2), 0.0),
        (DVec3::new(5.5, 0.3, 0.2), DVec3::new(5.0, 1.0, 0.1), 0.02),
    ] {
        let other = bodies[1].clone().translated(start);
        let turn = fixtures::arithmetic::rotation(DVec3::new(1.0, 2.0, 2.0), 0.05);
        let step = Step::new([&bodies[0], &other], |body, x| match body {
            0 => 1.01 * x,
            _ => end + turn * (x - start),
        });
        let params = CcdParams { min_separation, ..CcdParams::DEFAULT };
        let motion = step.motion();
        let [a, b] = step.sides();
        let query = SweptQuery::new(&motion, &params);
        let found =
            query.run(&a, &b, &mut Workspace::default(), Progress::none()).expect("in range");

        let of = |found: &SweptContact| {
            let mut particles = [0; 4];
            for (particle, term) in particles.iter_mut().zip(found.contact.stencil.terms()) {
                *particle = term.particle;
            }
            let time = found.contact.time.expect("a time");
            key(found.kind, particles, [time, found.latest])
        };
        assert!(found.contacts.is_sorted_by_key(|found| found.contact.time), "not by time");
        let mut keys: Vec<Key> = found.contacts.iter().map(of).collect();
        keys.sort_unstable();
        assert_eq!(keys, brute_force(&step, &params), "to {end}");
        found.contacts.iter().for_each(|found| check_contact(found, &motion, &params));
        assert!(found.candidates >= keys.len());
        contacts += keys.len();
    }
    assert!(contacts > 100, "{contacts} contacts");
}

/// Queries are made in batches: one of more than fits, of all pairs of two bodies of many faces.
#[test]
fn more_queries_than_a_batch_holds_lose_none() {
    let ball = shapes::octasphere(4.0, 2);
    let other = ball.clone().rotated(DVec3::new(1.0, 2.0, 3.0), 0.1);
    let step = Step::new([&ball, &other], |_, x| x);
    // Within the separation of all, each is a contact at the start.
    let params = CcdParams { min_separation: 9.0, ..CcdParams::DEFAULT };
    let motion = step.motion();
    let [a, b] = step.sides();
    let query = SweptQuery::new(&motion, &params);
    let found = query.run(&a, &b, &mut Workspace::default(), Progress::none()).expect("in range");
    let sides = [&a, &b].map(|side| (side.surface, side.first_particle));
    let all = all_vertex_faces(sides).len() + all_edge_edges(sides).len();
    assert_eq!((found.candidates, found.contacts.len()), (all, all));
    assert!(all > 1 << 15, "{all} fit a batch");
    assert!(found.contacts.iter().all(|found| found.at_start && found.contact.time == Some(0.0)));
}

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
