//! Implicit accelerations of stiff nets of springs: the reported residual is that of the result.

use glam::{DMat3, DVec3};
use response::{ImplicitEuler, LinearForces, LinearParams, LinearReport, TimeStep};
use surface::vectors::outer;

use crate::common::Stream;

/// Linear springs between pairs of particles.
struct Net {
    springs: Vec<(usize, usize, DMat3)>,
    w: Vec<f64>,
}

impl LinearForces for Net {
    fn add_stiffness(&self, dx: &[DVec3], out: &mut [DVec3]) {
        for &(i, j, stiffness) in &self.springs {
            let force = stiffness * (dx[i] - dx[j]);
            out[i] -= force;
            out[j] += force;
        }
    }

    fn add_damping(&self, _: &[DVec3], _: &mut [DVec3]) {}
}

impl Net {
    /// Connects particles of masses 1e-6 to 1e6 by springs up to `stiffest`.
    fn new(seed: u64, stiffest: f64) -> Self {
        let mut s = Stream(seed);
        let count = 3 + pick(&mut s, 30);
        let springs = (0..2 * count).map(|_| {
            let i = pick(&mut s, count);
            let j = (i + 1 + pick(&mut s, count - 1)) % count;
            let along = (any(&mut s) + 1e-3 * DVec3::X).normalize();
            let stiffness = stiffest * 10.0_f64.powf(-6.0 * s.next());
            (i, j, stiffness * outer(along, along))
        });
        let springs = springs.collect();
        let w = (0..count).map(|_| [1.0, 1e-6, 1e6, 1.0, 0.0][pick(&mut s, 5)]).collect();
        Self { springs, w }
    }

    /// Solves a step, and computes the residual of its result.
    fn solve(&self, seed: u64, size: f64, params: &LinearParams) -> (LinearReport, f64) {
        // Products with a power of two are exact.
        let (h, mut s) = (1.0 / 128.0, Stream(seed));
        let force: Vec<DVec3> = self.w.iter().map(|_| size * any(&mut s)).collect();
        let v: Vec<DVec3> = self.w.iter().map(|_| any(&mut s)).collect();
        let step = TimeStep::<ImplicitEuler>::new(h).expect("in range");
        let (a, report) = step
            .implicit_accelerations(&self.w, &force, self, &v, params)
            .expect("springs of a test are valid");

        let change: Vec<DVec3> = a.values().iter().map(|a| h * *a).collect();
        let (mut of_v, mut of_change) = (vec![DVec3::ZERO; v.len()], vec![DVec3::ZERO; v.len()]);
        self.add_stiffness(&v, &mut of_v);
        self.add_stiffness(&change, &mut of_change);
        let (mut square, mut whole) = (0.0, 0.0);
        for k in (0..v.len()).filter(|k| self.w[*k] > 0.0) {
            let right = h * force[k] + h * h * of_v[k];
            let left = right - (change[k] / self.w[k] - h * h * of_change[k]);
            square += self.w[k] * left.length_squared();
            whole += self.w[k] * right.length_squared();
        }
        (report, f64::sqrt(square / whole))
    }
}

fn pick(s: &mut Stream, count: usize) -> usize {
    let scaled = s.next() * f64::from(u32::try_from(count).expect("a few"));
    (0..count).rev().find(|k| f64::from(u32::try_from(*k).expect("a few")) <= scaled).unwrap_or(0)
}

fn any(s: &mut Stream) -> DVec3 {
    2.0 * DVec3::new(s.next(), s.next(), s.next()) - 1.0
}

#[test]
fn residuals_are_those_of_the_result() {
    let params = LinearParams { max_iterations: 20_000, ..LinearParams::default() };
    let mut converged = [0; 2];
    for (k, stiffest) in [1e2, 1e12].into_iter().enumerate() {
        for seed in 0..100 {
            let (report, residual) = Net::new(seed, stiffest).solve(seed, stiffest.sqrt(), &params);
            let error = (report.residual - residual).abs();
            assert!(error <= 1e-6 * residual, "{stiffest} seed {seed}: {report:?}, not {residual}");
            converged[k] += i32::from(report.converged);
        }
    }
    assert!(converged[0] == 100 && converged[1] > 50, "{converged:?} converge");
}

#[test]
fn a_limit_of_steps_reports_the_residual_that_is_left() {
    let params = LinearParams { max_iterations: 3, ..LinearParams::default() };
    for seed in 0..30 {
        let (report, residual) = Net::new(seed, 1e6).solve(seed, 1e3, &params);
        assert!(report.iterations <= 3, "{report:?}");
        let error = (report.residual - residual).abs();
        assert!(error <= 1e-6 * residual, "seed {seed}: {report:?}, not {residual}");
    }
}
