//! The robust method: a primal-dual interior point with Mehrotra's predictor and corrector.
//!
//! Every inequality is a pair of a slack and a multiplier ([`pairs`]) whose product is driven to zero. Written with the new
//! values (marked ⁺), the pairs of one stage and their local variables boil down to one linear function of
//! the state or input `z`, `multiplier⁺ = H z⁺ + g`; everything else follows from `z⁺` once the sweep has found it. With
//! the compliance `C = 1/H`
//!
//! ```text
//! input   H = λ_l/s_l + λ_u/s_u            s_l = u − u_min,   s_u = u_max − u
//! row     C = s/μ                          hard:  s = h − z
//!         C = s/μ + σ/(ν + κσ)             soft:  s = h + σ − z,   ν = λ + κσ − μ
//! light   C = s/α + 1/(2(α + β)/p + β/(d_th − p))    hard:  s = D − p,       w/p² = α + β
//!         … + σ/(λ − α)                    soft:  s = D + σ − p
//! ```
//!
//! `2(α + β)/p` is the primal-dual form of the curvature `2w/p³`.
//!
//! An iteration factors once and solves twice, for the change of the trajectory: computed as a difference of
//! two trajectories it would lose the digits that the stiff models of active limits need. Dynamics,
//! slacks, stationarity and the terminal equality are linear in the iterates, so that a step of length `a`
//! takes the part `a` of their residuals away; what remains to watch are the products of the pairs.
//!
//! The method itself does not end: [`InteriorPoint::iterate`] is one iteration, and [`crate::Riccati`] bounds their number. It
//! fails when a step cannot be represented, and then leaves the iterate as it was.

mod barriers;
mod input;
mod light;
mod pairs;
mod row;

use multiversion::multiversion;

use super::lqr::{CostToGo, InputModel, LinearQuadratic, StageModels, Sweep};
use super::working_set::WorkingSet;
use crate::kkt::Multipliers;
use crate::problem::{Problem, Terminal, dot, quadratic};
use barriers::Barriers;

/// Least first slack of rows and light, m or m/s.
const START_SLACK: f64 = 3.0;
/// First products, part of the quadratic cost of the first trajectory, and their limits.
const START_PRODUCT: f64 = 1e-2;
const START_PRODUCTS: (f64, f64) = (1.0, 1e6);
/// Least target product: less would not improve the answer, only the conditioning suffers.
const LEAST_TARGET: f64 = 1e-14;
/// Least part of the mean product that a step aims at.
const LEAST_CENTRING: f64 = 1e-6;

/// What an iteration did.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Mean product of the pairs before it.
    pub(super) mu: f64,
    /// Length of the predictor's step.
    predictor: f64,
    /// Length of the step taken.
    pub(super) length: f64,
}

impl Step {
    /// Whether both steps were nearly full: what is active then shows.
    pub(super) fn is_fast(&self) -> bool {
        self.predictor > 0.8 && self.length > 0.9
    }
}

/// The change of a trajectory.
#[derive(Clone, Debug)]
struct Change {
    inputs: Vec<f64>,
    states: Vec<[f64; 3]>,
}

/// The iterate and work memory.
#[derive(Clone, Debug)]
pub(super) struct InteriorPoint {
    barriers: Barriers,
    sweep: Sweep,
    /// `y`.
    terminal: [f64; 3],
    /// What is left of the first iterate's linear residuals, as a part of them.
    residual: f64,
    /// The states that the inputs of the barriers lead to.
    states: Vec<[f64; 3]>,
    /// Gradient of the quadratic cost at the iterate.
    input_gradients: Vec<f64>,
    state_gradients: Vec<[f64; 3]>,
    predictor: Change,
    /// Predictor and corrector together.
    step: Change,
    /// Constant part of the corrector's change of the inputs.
    constants: Vec<f64>,
}

impl InteriorPoint {
    pub(super) fn new(max_horizon: usize) -> Self {
        let change =
            || Change { inputs: vec![0.0; max_horizon], states: vec![[0.0; 3]; max_horizon + 1] };
        Self {
            barriers: Barriers::new(max_horizon),
            sweep: Sweep::new(max_horizon),
            terminal: [0.0; 3],
            residual: 1.0,
            states: vec![[0.0; 3]; max_horizon + 1],
            input_gradients: vec![0.0; max_horizon],
            state_gradients: vec![[0.0; 3]; max_horizon + 1],
            predictor: change(),
            step: change(),
            constants: vec![0.0; max_horizon],
        }
    }

    /// Starts near a trajectory, whatever it violates; far numbers in it are not trusted.
    ///
    /// `distance` above 1 starts farther inside: larger slacks, and products larger by its square.
    pub(super) fn start(
        &mut self,
        problem: &Problem,
        inputs: &[f64],
        states: &[[f64; 3]],
        distance: f64,
    ) {
        let n = problem.horizon;
        let cost: f64 = states[..n].iter().map(|x| quadratic(&problem.q, x)).sum();
        let (least, most) = START_PRODUCTS;
        // In this order NaN becomes `most`.
        let mu = distance * distance * (START_PRODUCT * 0.5 * cost).min(most).max(least);
        self.barriers.start(problem, inputs, states, distance * START_SLACK, mu);
        problem.roll_out(&self.barriers.input.u, &mut self.states);
        self.terminal = [0.0; 3];
        self.residual = 1.0;
    }

    /// One iteration; nothing if the step cannot be computed, in which case the iterate stays as it was.
    pub(super) fn iterate(&mut self, problem: &Problem, lq: &LinearQuadratic) -> Option<Step> {
        match (problem.terminal, lq.is_last_only) {
            (Terminal::Cost, true) => iterate::<false, true>(self, problem, lq),
            (Terminal::Equality(_), true) => iterate::<true, true>(self, problem, lq),
            // Rare enough not to deserve code of its own: the terminal columns are not used.
            (_, false) => iterate::<true, false>(self, problem, lq),
        }
    }

    #[inline(always)]
    fn iterate_with<const TERMINAL: bool, const LAST: bool>(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
    ) -> Option<Step> {
        // Residuals and model.
        let (gap, mu) = self.barriers.linearize(problem, &self.states);
        self.differentiate(problem);
        let cost_to_go = self.factor(problem, lq);

        // Predictor: towards products of zero.
        let y = self.predict::<LAST>(problem, lq, &cost_to_go);
        let predictor = self.barriers.predictor_length();
        let left = self.barriers.gap_after_predictor(predictor) / gap;

        // Corrector: towards products of τ. A short predictor step says little about the products at full length; that
        // the root of its length counts, rather than the length, was measured: it saves some 3 % of the iterations.
        let tau = (mu * (left * left * left).clamp(LEAST_CENTRING, 1.0)).max(LEAST_TARGET);
        self.barriers.set_targets(tau, predictor.sqrt());
        let dy = self.correct::<TERMINAL, LAST>(problem, lq, &cost_to_go);

        // Step.
        let reciprocal = self.barriers.step_reciprocal();
        let end = &self.step.states[problem.horizon];
        if !(reciprocal + mu + end[0] + end[1] + end[2]).is_finite() {
            return None;
        }
        let fraction = (1.0 - mu.min(0.01)).max(0.5 + 0.5 * predictor).min(0.9995);
        let length = (fraction / reciprocal.max(f64::MIN_POSITIVE)).min(1.0);
        self.advance(problem, length, std::array::from_fn(|i| y[i] + dy[i]));
        Some(Step { mu, predictor, length })
    }

    /// Gradient of the quadratic cost at the iterate.
    #[inline(always)]
    fn differentiate(&mut self, problem: &Problem) {
        let n = problem.horizon;
        let (u, states) = (&self.barriers.input.u[..n], &self.states[..=n]);
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

    #[inline(always)]
    fn factor(&mut self, problem: &Problem, lq: &LinearQuadratic) -> CostToGo {
        let models = Models {
            problem,
            barriers: &self.barriers,
            input_gradients: &self.input_gradients,
            state_gradients: &self.state_gradients,
        };
        lq.factor(problem, &models, &mut self.sweep, problem.horizon)
    }

    /// The predictor's change of the trajectory; returns its `y`.
    #[inline(always)]
    fn predict<const LAST: bool>(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        cost_to_go: &CostToGo,
    ) -> [f64; 3] {
        let n = problem.horizon;
        let y = match &problem.terminal {
            Terminal::Cost => [0.0; 3],
            Terminal::Equality(x_f) => {
                cost_to_go.terminal_system_of_change(&self.states[n], x_f).multiplier()
            }
        };
        let gains = &self.sweep.gains[..n];
        let (inputs, states) = (&mut self.predictor.inputs[..n], &mut self.predictor.states[..=n]);
        let mut x = [0.0; 3];
        for k in 0..n {
            let offset = gains[k].offset(&y);
            let u = -gains[k].input(offset, &x);
            inputs[k] = u;
            x = lq.closed_step::<LAST>(&x, &gains[k], offset, u);
            states[k + 1] = x;
        }
        self.barriers.expand_predictor(problem, &self.predictor.inputs, &self.predictor.states);
        y
    }

    /// Adds to the predictor what the corrector's slopes make: the recursion again, for the vectors only. Returns the
    /// change of `y`.
    #[inline(always)]
    fn correct<const TERMINAL: bool, const LAST: bool>(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        cost_to_go: &CostToGo,
    ) -> [f64; 3] {
        let n = problem.horizon;
        let barriers = &self.barriers;
        let (gains, constants) = (&self.sweep.gains[..n], &mut self.constants[..n]);
        let slopes = &barriers.input.slope[..n];
        let mut v = [0.0; 3];
        let mut t = [0.0; 3];
        barriers.add_slopes(problem, n, &mut v);
        for k in (0..n).rev() {
            let gain = &gains[k];
            let f = lq.input_of::<LAST>(&v) + slopes[k];
            constants[k] = f * gain.inverse;
            let mut added = [0.0; 3];
            if k > 0 {
                barriers.add_slopes(problem, k, &mut added);
            }
            if TERMINAL {
                for i in 0..3 {
                    t[i] -= gain.feedforward[i] * f;
                }
            }
            v = lq.closed_costate::<LAST>(&v, gain, slopes[k], &added);
        }
        let y = match problem.terminal {
            Terminal::Cost => [0.0; 3],
            Terminal::Equality(_) => cost_to_go.factors().solve(&t),
        };
        let (inputs, states) = (&mut self.step.inputs[..n], &mut self.step.states[..=n]);
        let (first_inputs, first_states) =
            (&self.predictor.inputs[..n], &self.predictor.states[..=n]);
        let mut x = [0.0; 3];
        for k in 0..n {
            let (gain, f) = (&gains[k], &gains[k].feedforward);
            let offset = constants[k] + (f[0] * y[0] + f[1] * y[1] + f[2] * y[2]);
            let u = -gain.input(offset, &x);
            inputs[k] = first_inputs[k] + u;
            x = lq.closed_step::<LAST>(&x, gain, offset, u);
            for i in 0..3 {
                states[k + 1][i] = first_states[k + 1][i] + x[i];
            }
        }
        self.barriers.expand_corrector(problem, &self.step.inputs, &self.step.states);
        y
    }

    /// Takes the part `a` of the step.
    #[inline(always)]
    fn advance(&mut self, problem: &Problem, a: f64, y: [f64; 3]) {
        self.barriers.advance(&self.step.inputs, a);
        for (old, new) in self.terminal.iter_mut().zip(y) {
            *old += a * (new - *old);
        }
        for (x, dx) in self.states.iter_mut().zip(&self.step.states[..=problem.horizon]) {
            for i in 0..3 {
                x[i] += a * dx[i];
            }
        }
        self.residual *= 1.0 - a;
    }

    /// Writes the guess of the active set that the last step suggests.
    pub(super) fn suggest(&self, problem: &Problem, guess: &mut WorkingSet) {
        self.barriers.suggest(problem, guess);
    }

    /// What is left of the first iterate's linear residuals, as a part of them.
    pub(super) fn remaining_residual(&self) -> f64 {
        self.residual
    }

    /// Copies the iterate out; the inputs are within their bounds.
    pub(super) fn read(
        &self,
        problem: &Problem,
        inputs: &mut [f64],
        multipliers: &mut Multipliers,
    ) {
        for (out, u) in inputs[..problem.horizon].iter_mut().zip(&self.barriers.input.u) {
            *out = u.max(problem.u_min).min(problem.u_max);
        }
        self.barriers.read(multipliers);
        multipliers.terminal = self.terminal;
    }
}

/// An iteration, compiled for wide registers too: what it calls is inlined.
#[multiversion(targets("x86_64+avx2"))]
fn iterate<const TERMINAL: bool, const LAST: bool>(
    point: &mut InteriorPoint,
    problem: &Problem,
    lq: &LinearQuadratic,
) -> Option<Step> {
    point.iterate_with::<TERMINAL, LAST>(problem, lq)
}

/// The iterate as models of the stages.
struct Models<'a> {
    problem: &'a Problem,
    barriers: &'a Barriers,
    input_gradients: &'a [f64],
    state_gradients: &'a [[f64; 3]],
}

impl StageModels for Models<'_> {
    const WITH_DISTURBANCE: bool = false;

    #[inline(always)]
    fn input(&self, k: usize) -> InputModel {
        InputModel::Free(self.barriers.input.curvature[k], self.input_gradients[k])
    }

    #[inline(always)]
    fn state_gradient(&self, k: usize) -> [f64; 3] {
        self.state_gradients[k]
    }

    #[inline(always)]
    fn state_functions(&self, k: usize, add: impl FnMut(&[f64; 3], f64, f64)) {
        self.barriers.each_state_function(self.problem, k, add);
    }
}
