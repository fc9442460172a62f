//! Shapes about as large as muscles, in millimeters, and random numbers of a seed.

use fixtures::Mesh;
use fixtures::random::Random;
use fixtures::shapes::ellipsoid;
use glam::DVec3;
use medial::{
    Ball, ContactBody, FootRule, Generated, MedialContact, MedialDetector, MedialError,
    MedialParams, MedialSurface, generate,
};
use proximity::{ParticleNumbers, SurfaceTree};
use surface::progress::Progress;

/// A flat, bent belly, 120 long.
pub(crate) fn muscle() -> Mesh {
    ellipsoid(DVec3::new(60.0, 22.0, 9.0), 3)
        .mapped(|p| p + DVec3::Z * (0.004 * p.x * p.x + 2.0 * (p.y / 12.0).sin()))
}

/// A flat belly, 80 long.
pub(crate) fn small_muscle() -> Mesh {
    ellipsoid(DVec3::new(40.0, 16.0, 8.0), 4)
}

/// The medial surface of a mesh.
pub(crate) fn generated(mesh: &Mesh, params: &MedialParams) -> Result<Generated, MedialError> {
    let surface = mesh.surface();
    generate(&surface, surface.positions(&mesh.positions)?, params, Progress::none())
}

/// The medial surface of a mesh by a number of balls.
pub(crate) fn with_balls(mesh: &Mesh, count: usize) -> MedialSurface {
    generated(mesh, &MedialParams::balls(count)).expect("a closed mesh").medial
}

/// A body with its detector and the numbers of its particles.
pub(crate) struct Detected {
    pub(crate) tree: SurfaceTree,
    pub(crate) detector: MedialDetector,
    pub(crate) first_particle: u32,
    pub(crate) is_rigid: bool,
}

impl Detected {
    /// Generates balls for a mesh.
    pub(crate) fn new(mesh: &Mesh, balls: usize, margin: f64, first_particle: u32) -> Self {
        Self::from_medial(mesh, with_balls(mesh, balls), margin, first_particle)
    }

    /// Takes the balls of a mesh.
    pub(crate) fn from_medial(
        mesh: &Mesh,
        medial: MedialSurface,
        margin: f64,
        first_particle: u32,
    ) -> Self {
        let tree = SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("finite");
        let (surface, x) = (tree.surface(), tree.positions());
        let detector = MedialDetector::from_medial(surface, x, margin, medial).expect("closed");
        Self { tree, detector, first_particle, is_rigid: false }
    }

    pub(crate) fn body(&self) -> ContactBody<'_> {
        let particles = ParticleNumbers::from(self.first_particle);
        ContactBody { tree: &self.tree, particles, is_rigid: self.is_rigid }
    }

    /// Moves the body, and its balls with it.
    pub(crate) fn move_to(&mut self, positions: &[DVec3]) {
        self.tree.set_positions(positions.iter().copied()).expect("finite");
        self.detector.follow(self.tree.positions()).expect("its own body");
    }

    fn position(&self, particle: u32) -> Option<DVec3> {
        let vertex = particle.checked_sub(self.first_particle)? as usize;
        self.tree.positions().as_slice().get(vertex).copied()
    }
}

/// Asserts every identity that a detector of contacts promises.
pub(crate) fn assert_consistent(contacts: &[MedialContact], bodies: &[&Detected]) {
    let at = |particle| {
        bodies.iter().find_map(|body| body.position(particle)).expect("a particle of a body")
    };
    for MedialContact { contact, ball, .. } in contacts {
        let error = contact.identity_error(at);
        assert!(error < 1e-11, "identity {error}: {contact:?}");
        assert!((contact.normal.length() - 1.0).abs() < 1e-12, "{contact:?}");
        assert!(contact.offset >= 0.0, "{contact:?}");
        let sum: f64 = contact.stencil.terms().iter().map(|term| term.weight).sum();
        let expected = if contact.anchor.is_some() { sum.signum() } else { 0.0 };
        assert!((sum - expected).abs() < 1e-14, "{contact:?}");
        assert!((ball.weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{ball:?}");
    }
}

/// The distance of a point from the union, by comparison with all primitives.
pub(crate) fn brute_force_distance(medial: &MedialSurface, p: DVec3) -> f64 {
    let mut distance = f64::INFINITY;
    for (primitive, _) in (0_u32..).zip(medial.primitives()) {
        distance = distance.min(medial.foot(p, primitive, FootRule::Exact).distance);
    }
    distance
}

/// Weights on a regular grid over a triangle.
pub(crate) fn grid_weights(steps: u32) -> impl Iterator<Item = [f64; 3]> {
    (0..=steps).flat_map(move |i| {
        (0..=steps - i).map(move |j| {
            let [b, c] = [i, j].map(|k| f64::from(k) / f64::from(steps));
            [1.0 - b - c, b, c]
        })
    })
}

/// A number of a range.
pub(crate) fn number(random: &mut Random, from: f64, to: f64) -> f64 {
    from + (to - from) * random.unit()
}

/// A vector with components of at most `size`.
pub(crate) fn vector(random: &mut Random, size: f64) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| number(random, -size, size)))
}

/// True once in `count` times.
pub(crate) fn one_in(random: &mut Random, count: usize) -> bool {
    random.below(count) == 0
}

/// Three balls, often such that they coincide, lie on a line or contain others.
pub(crate) fn slab(random: &mut Random) -> [Ball; 3] {
    let mut ball = || Ball::new(vector(random, 20.0), number(random, 0.0, 10.0));
    let [a, b, mut c] = [ball(), ball(), ball()];
    match random.below(8) {
        0 => c = b,
        1 => c.center = a.center.lerp(b.center, 0.3),
        2 => c.center = 2.0 * b.center - a.center,
        3 => return [a; 3],
        4 => c.center = b.center + 1e-9 * c.center,
        _ => {}
    }
    [a, b, c]
}

/// A few slabs, cones and isolated balls.
pub(crate) fn random_medial(random: &mut Random, size: f64) -> MedialSurface {
    let count = 3 + random.below(12);
    let ball = |random: &mut Random| Ball::new(vector(random, size), number(random, 0.0, 3.0));
    let balls: Vec<Ball> = (0..count).map(|_| ball(random)).collect();
    let (mut cones, mut slabs) = (Vec::new(), Vec::new());
    for _ in 0..random.below(9) {
        let [a, b, c] = [0; 3].map(|_| u32::try_from(random.below(count)).expect("a small number"));
        if a != b && b != c && c != a {
            slabs.push([a, b, c]);
        } else if a != b {
            cones.push([a, b]);
        }
    }
    MedialSurface::new(balls, cones, slabs).expect("valid by construction")
}
