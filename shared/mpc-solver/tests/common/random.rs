//! Random problems over the whole operating range, feasible by construction.
//!
//! A random input within its bounds is rolled out. Hard limits, a hard light's margins and the terminal
//! equality are then placed such that this trajectory satisfies them. Soft limits may be anywhere.

#![allow(dead_code, reason = "each test file uses its part")]

use mpc_solver::{LightCost, LightStage, Problem, ProblemBuilder, Row, Softness};
use rand_core::Rng;
use rand_pcg::Pcg64Mcg;

/// Seeded source of the numbers of a problem.
pub(crate) struct Draw(Pcg64Mcg);

impl Draw {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::new((u128::from(seed) << 64) | 0xcafe_f00d_d15e_a5e5))
    }

    /// Returns a uniform number in `[lo, hi)`.
    pub(crate) fn uniform(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * random::uniform(&mut self.0)
    }

    /// Returns `10^x`, `x` uniform in `[lo, hi)`.
    pub(crate) fn decades(&mut self, lo: f64, hi: f64) -> f64 {
        10f64.powf(self.uniform(lo, hi))
    }

    /// Returns true with probability `p`.
    pub(crate) fn chance(&mut self, p: f64) -> bool {
        self.uniform(0.0, 1.0) < p
    }

    /// Returns a uniform integer in `0..n`.
    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n as u64) as usize
    }

    fn softness(&mut self, p_hard: f64) -> Softness {
        if self.chance(p_hard) {
            return Softness::Hard;
        }
        let quadratic = if self.chance(0.5) { 0.0 } else { self.decades(-1.0, 4.0) };
        Softness::Soft { linear: self.decades(1.0, 5.0), quadratic }
    }
}

/// Returns a random problem with jointly feasible constraints.
pub(crate) fn problem(draw: &mut Draw) -> Problem {
    let n = [25, 50, 100, 100, 100, 150][draw.below(6)];
    let t = [0.05, 0.1, 0.1, 0.2][draw.below(4)];
    let tau = draw.uniform(0.2, 1.0).max(1.5 * t);
    let headway = if draw.chance(0.5) { 0.0 } else { draw.uniform(0.8, 2.5) };
    let (u_min, u_max) = (draw.uniform(-8.0, -2.0), draw.uniform(1.0, 5.0));
    let x0 = [draw.uniform(-100.0, 30.0), draw.uniform(-15.0, 20.0), draw.uniform(-5.0, 3.0)];
    let q = [draw.decades(-1.0, 3.0), draw.decades(-1.0, 4.0), draw.decades(-3.0, 2.0)];
    // Euler's step for the input, or one that reaches the speeds within the step.
    let jump = if draw.chance(0.15) { 0.5 * t * t / tau } else { 0.0 };
    let b = [0.3 * t * jump, jump, t / tau];
    let mut builder = Problem::builder(n)
        .dynamics([[1.0, t, t * headway], [0.0, 1.0, t], [0.0, 0.0, 1.0 - t / tau]], b)
        .input_bounds(u_min, u_max)
        .state_weights(q)
        .input_cost(draw.decades(-1.0, 1.0))
        .initial_state(x0);
    if draw.chance(0.3) {
        builder = builder.jerk_cost(draw.decades(-2.0, 0.5), tau);
    }
    let tail = draw.decades(0.0, 2.0);
    builder = builder.terminal_weights(q.map(|w| w * tail));

    let lead = if draw.chance(0.5) { draw.uniform(-6.0, 4.0) } else { 0.0 };
    let disturbance = |k: usize| [0.0, -t * lead * (-0.5 * t * k as f64).exp(), 0.0];
    let path = roll(draw, n, [t, tau, headway], b, (u_min, u_max), x0, &disturbance);
    if draw.chance(0.5) {
        builder = builder.terminal_equality(path[n]);
    }
    let (builder, limits) = rows(draw, builder, n, &path);
    let (builder, stages) = light(draw, builder, n, t, &path);
    let mut problem = builder.build().expect("the ranges hold only valid numbers");
    for (k, d) in problem.disturbances_mut().iter_mut().enumerate() {
        *d = disturbance(k);
    }
    for (j, limits) in limits.iter().enumerate() {
        problem.row_limits_mut(j).copy_from_slice(limits);
    }
    problem.set_light(stages);
    problem
}

/// Rolls out a random input within its bounds.
fn roll(
    draw: &mut Draw,
    n: usize,
    [t, tau, headway]: [f64; 3],
    b: [f64; 3],
    (lo, hi): (f64, f64),
    x0: [f64; 3],
    disturbance: &dyn Fn(usize) -> [f64; 3],
) -> Vec<[f64; 3]> {
    let (phase, speed) = (draw.uniform(0.0, 6.3), draw.uniform(0.1, 1.5));
    let (goal, gain) = (draw.uniform(-20.0, 5.0), draw.uniform(0.05, 0.3));
    let mut path = vec![x0];
    for k in 0..n {
        let x = path[k];
        // Towards an error with some damping, disturbed.
        let wish = -gain * (x[0] - goal) - 0.8 * x[1] + 0.5 * (phase + speed * t * k as f64).sin();
        let u = wish.clamp(0.95 * lo, 0.95 * hi);
        let d = disturbance(k);
        path.push([
            x[0] + t * (x[1] + headway * x[2]) + b[0] * u + d[0],
            x[1] + t * x[2] + b[1] * u + d[1],
            x[2] - t / tau * x[2] + b[2] * u + d[2],
        ]);
    }
    path
}

fn rows(
    draw: &mut Draw,
    mut builder: ProblemBuilder,
    n: usize,
    path: &[[f64; 3]],
) -> (ProblemBuilder, Vec<Vec<f64>>) {
    let mut all = Vec::new();
    for gradient in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.3, 1.0, 0.2]] {
        if !draw.chance(0.35) {
            continue;
        }
        let softness = draw.softness(0.5);
        let from = if draw.chance(0.5) { 1 } else { 1 + draw.below(n) };
        let to = if draw.chance(0.5) { n } else { 1 + draw.below(n) };
        let value = |x: &[f64; 3]| (0..3).map(|i| gradient[i] * x[i]).sum::<f64>();
        let top = path[1..].iter().map(value).fold(f64::NEG_INFINITY, f64::max);
        let spare = draw.decades(-3.0, 1.0);
        let sink = if softness == Softness::Hard { 0.0 } else { draw.uniform(0.0, 10.0) };
        // Either one limit that the path touches, or a tube along the path.
        let tube = draw.chance(0.3);
        let mut limits: Vec<f64> =
            path.iter().map(|x| if tube { value(x) } else { top } + spare - sink).collect();
        if draw.chance(0.2) {
            let open = 1 + draw.below(n);
            limits[open..].fill(f64::INFINITY);
        }
        builder = builder.row(Row { gradient, from, to, limit: 0.0, softness });
        all.push(limits);
    }
    (builder, all)
}

fn light(
    draw: &mut Draw,
    builder: ProblemBuilder,
    n: usize,
    t: f64,
    path: &[[f64; 3]],
) -> (ProblemBuilder, Vec<LightStage>) {
    if !draw.chance(0.5) {
        return (builder, Vec::new());
    }
    let softness = draw.softness(0.5);
    let threshold = if draw.chance(0.1) { f64::INFINITY } else { draw.decades(1.0, 2.5) };
    let builder = builder.light(LightCost { weight: draw.decades(2.0, 6.0), threshold, softness });
    let stages = 1 + draw.below(n);
    let t0 = t * (stages as f64 + draw.uniform(0.0, 1.0));
    let sign = if draw.chance(0.5) { 1.0 } else { -1.0 };
    let gradient = |k: usize| {
        let left = t0 - t * k as f64;
        [sign, sign * left, sign * 0.5 * left * left]
    };
    let value = |k: usize| {
        let c = gradient(k);
        (0..3).map(|i| c[i] * path[k][i]).sum::<f64>()
    };
    let least = (1..=stages).map(value).fold(f64::INFINITY, f64::min);
    let spare = match softness {
        Softness::Hard => draw.decades(-1.0, 2.0),
        Softness::Soft { .. } => draw.uniform(-30.0, 60.0),
    };
    let offset = spare - least;
    (builder, (1..=stages).map(|k| LightStage { gradient: gradient(k), offset }).collect())
}
