//! The robust method: a primal-dual interior point with Mehrotra's predictor and corrector.
//!
//! Each iteration factors once and solves twice, for the change of the trajectory: computed as a difference of
//! two trajectories it would lose the digits that the stiff models of active limits need. Dynamics,
//! slacks, stationarity and the terminal equality are linear in the iterates, so a step of length `a`
//! takes the part `a` of their residuals away; what remains to watch are the products of the pairs.

use super::active::ActiveSet;
use super::barrier::input::InputBarrier;
use super::barrier::light::LightBarrier;
use super::barrier::row::RowBarrier;
use super::recursion::{InputModel, Models, Open, Plant, Sweep};
use crate::kkt::Multipliers;
use crate::problem::{MAX_ROWS, Problem, Terminal, dot, quadratic};

/// Distance of the first inputs from their bounds, part of the range.
const START_MARGIN: f64 = 0.3;
/// Least first slack of rows and light, m or m/s.
const START_SLACK: f64 = 1.0;
/// First products, part of the quadratic cost of the first trajectory, and their limits.
const START_PRODUCT: f64 = 1e-2;
const START_PRODUCTS: (f64, f64) = (1.0, 1e5);

/// Least target product: less would not improve the answer, only the conditioning suffers.
const LEAST_TARGET: f64 = 1e-14;

/// What an iteration did.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Mean product of the pairs before it.
    pub(super) mu: f64,
    /// Length of the predictor's step.
    affine: f64,
    /// Length of the step taken.
    length: f64,
}

impl Step {
    /// Whether both steps were nearly full: the active set then shows.
    pub(super) fn is_fast(&self) -> bool {
        self.affine > 0.8 && self.length > 0.9
    }
}

/// Work memory.
#[derive(Clone, Debug)]
pub(super) struct Interior {
    sweep: Sweep,
    input: InputBarrier,
    rows: [RowBarrier; MAX_ROWS],
    light: LightBarrier,
    y: [f64; 3],
    /// What is left of the first iterate's linear residuals.
    open: f64,
    /// The trajectory of `input.u`, and the gradient of the quadratic cost along it.
    states: Vec<[f64; 3]>,
    input_gradients: Vec<f64>,
    state_gradients: Vec<[f64; 3]>,
    /// Full step of the current iteration.
    input_changes: Vec<f64>,
    state_changes: Vec<[f64; 3]>,
    /// Constant part of the corrector's change of the inputs.
    constants: Vec<f64>,
}

struct Barriers<'a> {
    problem: &'a Problem,
    input: &'a InputBarrier,
    rows: &'a [RowBarrier],
    light: &'a LightBarrier,
    input_gradients: &'a [f64],
    state_gradients: &'a [[f64; 3]],
}

impl Models for Barriers<'_> {
    const DRIVEN: bool = false;

    #[inline(always)]
    fn input(&self, k: usize) -> InputModel {
        InputModel::Free(self.input.weight[k], self.input_gradients[k])
    }

    #[inline(always)]
    fn gradient(&self, k: usize) -> [f64; 3] {
        self.state_gradients[k]
    }

    #[inline(always)]
    fn functions(&self, k: usize, add: impl FnMut(&[f64; 3], f64, f64)) {
        each_function(self.problem, self.rows, self.light, k, add);
    }
}

impl Interior {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self {
            sweep: Sweep::new(max_horizon),
            input: InputBarrier::new(max_horizon),
            rows: std::array::from_fn(|_| RowBarrier::new(max_horizon)),
            light: LightBarrier::new(max_horizon),
            y: [0.0; 3],
            open: 1.0,
            states: vec![[0.0; 3]; max_horizon + 1],
            input_gradients: vec![0.0; max_horizon],
            state_gradients: vec![[0.0; 3]; max_horizon + 1],
            input_changes: vec![0.0; max_horizon],
            state_changes: vec![[0.0; 3]; max_horizon + 1],
            constants: vec![0.0; max_horizon],
        }
    }

    /// Starts near a trajectory, whatever it violates; far numbers in it are not trusted.
    ///
    /// `boldness` above 1 starts farther inside: larger slacks and products.
    pub(super) fn start(
        &mut self,
        problem: &Problem,
        inputs: &[f64],
        states: &[[f64; 3]],
        boldness: f64,
    ) {
        let n = problem.horizon;
        let cost: f64 = states[..n].iter().map(|x| quadratic(&problem.q, x)).sum();
        let (least, most) = START_PRODUCTS;
        // In this order NaN becomes `most`.
        let mu = boldness * boldness * (START_PRODUCT * 0.5 * cost).min(most).max(least);
        let slack = boldness * START_SLACK;
        self.input.start(inputs, (problem.u_min, problem.u_max), START_MARGIN, mu);
        for (barrier, (row, h)) in
            self.rows.iter_mut().zip(problem.rows.iter().zip(&problem.limits))
        {
            barrier.start(row, h, states, slack, mu);
        }
        self.light.start(problem.light.as_ref(), problem.light_stages(), states, slack, mu);
        problem.roll_out(&self.input.u, &mut self.states);
        self.y = [0.0; 3];
        self.open = 1.0;
    }

    /// One iteration; nothing if the step cannot be computed, in which case the iterate stays as it was.
    pub(super) fn iterate(&mut self, problem: &Problem, plant: &Plant) -> Option<Step> {
        match (problem.terminal, plant.last_only) {
            (Terminal::Cost, true) => self.step::<false, true>(problem, plant),
            (Terminal::Equality(_), true) => self.step::<true, true>(problem, plant),
            // Rare enough not to deserve its own code: what is pinned is not used.
            (_, false) => self.step::<true, false>(problem, plant),
        }
    }

    fn step<const PINNED: bool, const LAST: bool>(
        &mut self,
        problem: &Problem,
        plant: &Plant,
    ) -> Option<Step> {
        let count = problem.rows.len();
        let (mut gap, mut pairs) = self.input.predict();
        for (row, h) in self.rows.iter_mut().zip(&problem.limits) {
            let (row_gap, row_pairs) = row.predict(h, &self.states);
            gap += row_gap;
            pairs += row_pairs;
        }
        let (light_gap, light_pairs) = self.light.predict(problem.light_stages(), &self.states);
        gap += light_gap;
        let mu = gap / (pairs + light_pairs) as f64;

        self.differentiate(problem);
        let Self { input, rows, light, sweep, input_gradients, state_gradients, .. } = self;
        let rows = &rows[..count];
        let barriers = Barriers { problem, input, rows, light, input_gradients, state_gradients };
        let end = plant.factor(problem, &barriers, sweep, problem.horizon);
        let y = end.multiplier_of_change(problem, &self.states[problem.horizon]);
        self.forward::<LAST>(problem, plant, &y);
        self.follow(problem, false);
        let rows = &self.rows[..count];
        let mut reach = self.input.reach_affine().max(self.light.reach_affine());
        for row in rows {
            reach = reach.max(row.reach_affine());
        }
        let affine = 1.0 / reach;
        let left: f64 = rows.iter().map(|row| row.gap_affine(affine)).sum();
        let left = left + self.input.gap_affine(affine) + self.light.gap_affine(affine);
        let ratio = left / gap;

        let tau = (mu * (ratio * ratio * ratio).clamp(1e-6, 1.0)).max(LEAST_TARGET);
        // A short predictor step says little about the products at full length.
        let trust = affine;
        self.input.correct(tau, trust);
        for row in &mut self.rows[..count] {
            row.correct(tau, trust);
        }
        self.light.correct(tau, trust);
        let dy = self.resolve::<PINNED, LAST>(problem, plant, &end);
        self.follow(problem, true);
        let mut reach = self.input.reach().max(self.light.reach());
        for row in &self.rows[..count] {
            reach = reach.max(row.reach());
        }
        let last = &self.state_changes[problem.horizon];
        if !(reach + mu + last[0] + last[1] + last[2]).is_finite() {
            return None;
        }
        let fraction = (1.0 - mu.min(0.01)).max(0.5 + 0.5 * affine).min(0.9995);
        let a = (fraction / reach.max(f64::MIN_POSITIVE)).min(1.0);
        self.input.advance(&self.input_changes, a);
        for row in &mut self.rows[..count] {
            row.advance(a);
        }
        self.light.advance(a);
        for i in 0..3 {
            self.y[i] += a * (y[i] + dy[i] - self.y[i]);
        }
        for (x, dx) in self.states.iter_mut().zip(&self.state_changes[..=problem.horizon]) {
            for i in 0..3 {
                x[i] += a * dx[i];
            }
        }

        self.open *= 1.0 - a;
        Some(Step { mu, affine, length: a })
    }

    /// Gradient of the quadratic cost at the iterate.
    fn differentiate(&mut self, problem: &Problem) {
        let n = problem.horizon;
        let (u, states) = (&self.input.u[..n], &self.states[..=n]);
        let by_input = &mut self.input_gradients[..n];
        let by_state = &mut self.state_gradients[..=n];
        let (q, s) = (&problem.q, &problem.s);
        for k in 0..n {
            let (x, linear) = (&states[k], &problem.q_lin[k]);
            by_input[k] = problem.r * u[k] + dot(s, x) + problem.r_lin[k];
            by_state[k] = std::array::from_fn(|i| dot(&q[i], x) + (s[i] * u[k] + linear[i]));
        }
        by_state[n] = std::array::from_fn(|i| dot(&problem.p[i], &states[n]) + problem.p_lin[i]);
    }

    fn forward<const LAST: bool>(&mut self, problem: &Problem, plant: &Plant, y: &[f64; 3]) {
        let n = problem.horizon;
        let gains = &self.sweep.gains[..n];
        let (inputs, states) = (&mut self.input_changes[..n], &mut self.state_changes[..=n]);
        let mut x = [0.0; 3];
        for k in 0..n {
            let u = -gains[k].input(gains[k].offset(y), &x);
            inputs[k] = u;
            x = plant.step::<LAST>(&x, u);
            states[k + 1] = x;
        }
    }

    /// Adds to the step what the corrector's forces make: the recursion again, for the vectors only.
    fn resolve<const PINNED: bool, const LAST: bool>(
        &mut self,
        problem: &Problem,
        plant: &Plant,
        end: &Open,
    ) -> [f64; 3] {
        let n = problem.horizon;
        let Self { input, rows, light, sweep, constants, .. } = self;
        let rows = &rows[..problem.rows.len()];
        let forces = |k: usize, v: &mut [f64; 3]| {
            each_function(problem, rows, light, k, |g, _, force| {
                for i in 0..3 {
                    v[i] += force * g[i];
                }
            });
        };
        let (gains, constants) = (&sweep.gains[..n], &mut constants[..n]);
        let (push, inputs) = (&input.push[..n], &mut self.input_changes[..n]);
        let states = &mut self.state_changes[..=n];
        let mut v = [0.0; 3];
        let mut t = [0.0; 3];
        forces(n, &mut v);
        for k in (0..n).rev() {
            let gain = &gains[k];
            let f = plant.input_of::<LAST>(&v) + push[k];
            constants[k] = f * gain.inverse;
            let mut next = plant.transposed(&v);
            if k > 0 {
                forces(k, &mut next);
            }
            for i in 0..3 {
                v[i] = next[i] - gain.feedback[i] * f;
                if PINNED {
                    t[i] -= gain.open[i] * f;
                }
            }
        }
        let y = match problem.terminal {
            Terminal::Cost => [0.0; 3],
            Terminal::Equality(_) => end.solve(&t),
        };
        let mut x = [0.0; 3];
        for k in 0..n {
            let gain = &gains[k];
            let open = gain.open[0] * y[0] + gain.open[1] * y[1] + gain.open[2] * y[2];
            let u = -gain.input(constants[k] + open, &x);
            inputs[k] += u;
            x = plant.step::<LAST>(&x, u);
            for i in 0..3 {
                states[k + 1][i] += x[i];
            }
        }
        y
    }

    fn follow(&mut self, problem: &Problem, corrected: bool) {
        self.input.follow(&self.input_changes);
        for row in &mut self.rows[..problem.rows.len()] {
            row.follow(&self.state_changes, corrected);
        }
        self.light.follow(problem.light_stages(), &self.state_changes, corrected);
    }

    /// Gives the active set the guess that the last step suggests.
    pub(super) fn suggest(&self, problem: &Problem, active: &mut ActiveSet) {
        active.adopt(
            problem,
            |k| self.input.side(k),
            |graph, k| self.light.tangent(graph, k),
            |j, k| self.rows[j].tangent(k),
        );
    }

    /// What is left of the first iterate's linear residuals, as a part of them.
    pub(super) fn open(&self) -> f64 {
        self.open
    }

    /// Copies the iterate out; the inputs are within their bounds.
    pub(super) fn read(
        &self,
        problem: &Problem,
        inputs: &mut [f64],
        multipliers: &mut Multipliers,
    ) {
        for (out, u) in inputs[..problem.horizon].iter_mut().zip(&self.input.u) {
            *out = u.max(problem.u_min).min(problem.u_max);
        }
        for (out, row) in multipliers.rows.iter_mut().zip(&self.rows[..problem.rows.len()]) {
            out[row.from..row.from + row.len].copy_from_slice(row.multipliers());
        }
        multipliers.light[1..=self.light.len].copy_from_slice(self.light.multipliers());
        multipliers.terminal = self.y;
    }
}

/// Gradient, curvature and force of each function of `x_k`.
#[inline(always)]
fn each_function(
    problem: &Problem,
    rows: &[RowBarrier],
    light: &LightBarrier,
    k: usize,
    mut add: impl FnMut(&[f64; 3], f64, f64),
) {
    for row in rows {
        let i = k.wrapping_sub(row.from);
        if i < row.len {
            add(&row.gradient, row.weight[i], row.force[i]);
        }
    }
    if k <= light.len {
        let stage = &problem.light_stages[k - 1];
        add(&stage.gradient, light.weight[k - 1], -light.force[k - 1]);
    }
}
