//! An ellipsoid of particles on springs: along the edges of its surface, and
//! from every vertex to a particle in the middle.

use glam::DVec3;
use surface::{SurfaceError, TriangleSurface};

/// Half axes \[mm\].
const EXTENT: DVec3 = DVec3::new(11.0, 24.0, 8.0);
/// Where the middle starts \[mm\]: off the bone's top, so that it slides.
const START: DVec3 = DVec3::new(5.0, 0.0, 25.0);
/// Mass of the surface's vertices, and of the particle in the middle \[g\].
const MASS: [f64; 2] = [6.0, 4.0];
/// Stiffness of an edge and of a spoke \[g/s²\].
const STIFFNESS: [f64; 2] = [2e4, 6e3];
/// Damping of a spring \[g/s\].
const DAMPING: f64 = 2.0;
const RINGS: u32 = 11;
const AROUND: u32 = 18;

/// The muscle and its state.
pub(crate) struct Muscle {
    /// Positions: the surface's vertices, then the middle.
    pub(crate) x: Vec<DVec3>,
    pub(crate) v: Vec<DVec3>,
    pub(crate) inverse_mass: Vec<f64>,
    pub(crate) springs: Springs,
    pub(crate) surface: TriangleSurface,
}

/// Linear springs with damping along them.
pub(crate) struct Springs(Vec<Spring>);

struct Spring {
    ends: [usize; 2],
    rest: f64,
    stiffness: f64,
}

impl Muscle {
    pub(crate) fn new() -> Result<Self, SurfaceError> {
        let (mut x, faces) = ellipsoid();
        let surface = TriangleSurface::new(x.len(), faces)?;
        let middle = x.len();
        x.push(START);
        let edges = surface.edges().iter().map(|e| (e.map(|k| k as usize), STIFFNESS[0]));
        let spokes = (0..middle).map(|k| ([k, middle], STIFFNESS[1]));
        let spring = |(ends, stiffness): ([usize; 2], f64)| Spring {
            ends,
            stiffness,
            rest: x[ends[0]].distance(x[ends[1]]),
        };
        let springs = Springs(edges.chain(spokes).map(spring).collect());
        let share = f64::from(RINGS * AROUND + 2) / MASS[0];
        let mut inverse_mass = vec![share; middle];
        inverse_mass.push(MASS[1].recip());
        let v = vec![DVec3::ZERO; x.len()];
        Ok(Self { x, v, inverse_mass, springs, surface })
    }

    /// Center of mass.
    pub(crate) fn middle(&self) -> DVec3 {
        let moments: DVec3 = self.x.iter().zip(&self.inverse_mass).map(|(x, w)| *x / *w).sum();
        moments / (MASS[0] + MASS[1])
    }
}

impl Springs {
    pub(crate) fn forces(&self, x: &[DVec3], v: &[DVec3]) -> Vec<DVec3> {
        let mut forces = vec![DVec3::ZERO; x.len()];
        for spring in &self.0 {
            let [a, b] = spring.ends;
            let along = spring.along(x);
            let stretch = x[a].distance(x[b]) - spring.rest;
            let pull = spring.stiffness * stretch + DAMPING * (v[b] - v[a]).dot(along);
            forces[a] += pull * along;
            forces[b] -= pull * along;
        }
        forces
    }

    /// Adds K `dx` with the part across a spring left out where it is pressed,
    /// so that K stays not positive.
    pub(crate) fn add_stiffness(&self, x: &[DVec3], dx: &[DVec3], out: &mut [DVec3]) {
        for spring in &self.0 {
            let [a, b] = spring.ends;
            let (along, change) = (spring.along(x), dx[b] - dx[a]);
            let across = change - change.dot(along) * along;
            let tension = (1.0 - spring.rest / x[a].distance(x[b])).max(0.0);
            let pull = spring.stiffness * (change.dot(along) * along + tension * across);
            out[a] += pull;
            out[b] -= pull;
        }
    }

    pub(crate) fn add_damping(&self, x: &[DVec3], dv: &[DVec3], out: &mut [DVec3]) {
        for spring in &self.0 {
            let [a, b] = spring.ends;
            let along = spring.along(x);
            let pull = DAMPING * (dv[b] - dv[a]).dot(along) * along;
            out[a] += pull;
            out[b] -= pull;
        }
    }
}

impl Spring {
    fn along(&self, x: &[DVec3]) -> DVec3 {
        (x[self.ends[1]] - x[self.ends[0]]).normalize_or(DVec3::X)
    }
}

fn ellipsoid() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let place = |polar: f64, turn: f64| {
        let on_ball = DVec3::new(polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin());
        START + EXTENT * on_ball
    };
    let mut x = vec![place(0.0, 0.0)];
    for ring in 1..=RINGS {
        let polar = std::f64::consts::PI * f64::from(ring) / f64::from(RINGS + 1);
        for k in 0..AROUND {
            x.push(place(polar, std::f64::consts::TAU * f64::from(k) / f64::from(AROUND)));
        }
    }
    x.push(place(std::f64::consts::PI, 0.0));
    let (at, last) = (|ring: u32, k: u32| 1 + ring * AROUND + k % AROUND, RINGS * AROUND + 1);
    let mut faces = Vec::new();
    for k in 0..AROUND {
        faces.push([0, at(0, k + 1), at(0, k)]);
        faces.push([last, at(RINGS - 1, k), at(RINGS - 1, k + 1)]);
        for ring in 0..RINGS - 1 {
            faces.push([at(ring, k), at(ring + 1, k + 1), at(ring + 1, k)]);
            faces.push([at(ring, k), at(ring, k + 1), at(ring + 1, k + 1)]);
        }
    }
    (x, faces)
}
