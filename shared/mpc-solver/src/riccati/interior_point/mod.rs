//! Robust method: a primal-dual interior point with Mehrotra's predictor and corrector.
//!
//! Every inequality is a pair of a slack and a multiplier ([`pairs`]) whose product is driven to zero. New values are
//! marked ⁺. In them, the pairs of one stage and their local variables reduce to one linear function of the state or
//! input `z`: `multiplier⁺ = H z⁺ + g`. All else follows from `z⁺`, which the sweep computes. With the compliance
//! `C = 1/H`
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
//! An iteration factors once and solves twice for the change of the trajectory. A difference of two
//! trajectories would lose the digits that the stiff models of active limits need.
//!
//! # Step length
//!
//! Primal variables (inputs, states, slacks, `σ`, `p`) and dual ones (multipliers, `ν`, `y`) take one length. Lengths of
//! their own would save 5 % of the iterations. But the light's `w/p² = α + β` is not linear, and different lengths for
//! `p` and `α` can cycle.
//!
//! No residual is carried from iteration to iteration: all are computed at the present iterate, that of `ν` included.
//! A length `a` scales the linear ones by `1 − a`. [`InteriorPoint::remaining_residual`] is a guide for the next phase,
//! not a proof.
//!
//! # Sweeps
//!
//! Each iteration has four sweeps over the stages: backwards and forwards for the predictor, and
//! again for the corrector. The pairs are processed in blocks of [`WIDTH`] stages, lane by lane,
//! one block beside that of the sweep. A backward sweep needs the block ahead of it; a block behind
//! a forward sweep needs the sweep. Neither waits for the other. Trajectories are stored in the
//! same blocks, component by component ([`pairs`]). The predictor's backward sweep takes the models
//! of a whole block ([`super::lqr::BlockModel`]).
//!
//! [`InteriorPoint::iterate`] is one iteration; [`crate::Riccati`] bounds their number. An
//! iteration fails when its step cannot be represented, and then leaves the iterate unchanged.

mod barriers;
mod bound;
mod input;
mod pairs;

use multiversion::multiversion;

use super::lanes::{Lanes, WIDTH};
use super::lqr::{CHAIN, Cost, CostToGo, GENERAL, LinearQuadratic, Shape, Sweep};
use super::working_set::WorkingSet;
use crate::kkt::Multipliers;
use crate::problem::{Problem, Terminal, quadratic};
use barriers::{Barriers, Models};
use bound::StartPairs;
use pairs::{PathBlock, Prediction, Targets, block, block_mut, length, path, place, state};

/// Smallest initial slack of rows and light \[m or m/s\].
const START_SLACK: f64 = 3.0;
/// Initial products as a fraction of the quadratic cost of the first trajectory, and their limits.
const START_PRODUCT: f64 = 1e-2;
const START_PRODUCTS: (f64, f64) = (1.0, 1e6);
/// Smallest target product. At a limit without a force, slack and multiplier are both its root. The optimality
/// conditions require 1e-8 of them.
const LEAST_TARGET: f64 = 1e-20;
/// Smallest fraction of the mean product that a step aims at.
const LEAST_CENTRING: f64 = 1e-6;

/// Cap on the second-order correction, in multiples of the mean product ([`pairs`]).
const MOST_NEGLECTED: f64 = 30.0;
/// Fraction of the longest step that is left out while the products are large. A predictor that cannot move leaves out
/// the further fraction. The limiting pair then stays farther from zero and limits the next step less.
const MARGIN: f64 = 0.01;
const SHORT_MARGIN: f64 = 0.1;

#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Mean product of the pairs before the step.
    pub(super) mu: f64,
    /// Lengths of the predictor, and of the step taken.
    predictor: f64,
    pub(super) length: f64,
}

impl Step {
    /// Returns whether both steps were nearly full, so that they show which inequalities are
    /// active.
    pub(super) fn is_fast(&self) -> bool {
        self.predictor > 0.8 && self.length > 0.9
    }
}

/// Iterate and work memory.
#[derive(Clone, Debug)]
pub(super) struct InteriorPoint {
    barriers: Barriers,
    sweep: Sweep,
    /// `y`.
    terminal: [f64; 3],
    /// Remaining fraction of the first iterate's linear residuals: the product of `1 − length` over
    /// the steps.
    pub(super) residual: f64,
    cost: Cost,
    /// Inputs of the barriers, and the states that follow from them.
    iterate: Vec<PathBlock>,
    predictor: Vec<PathBlock>,
    /// Sum of predictor and corrector.
    step: Vec<PathBlock>,
    /// Constant part of the corrector's change of the inputs.
    constants: Vec<f64>,
}

impl InteriorPoint {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self {
            barriers: Barriers::new(max_horizon),
            sweep: Sweep::new(max_horizon),
            terminal: [0.0; 3],
            residual: 1.0,
            cost: Cost::new(max_horizon),
            iterate: path(max_horizon),
            predictor: path(max_horizon),
            step: path(max_horizon),
            constants: vec![0.0; WIDTH * (max_horizon / WIDTH + 1)],
        }
    }

    /// Starts near any trajectory; numbers of extreme size in it are limited.
    ///
    /// A `distance` above 1 starts farther inside: slacks grow with it, products with its square.
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
        // This order turns NaN into `most`.
        let mu = distance * distance * (START_PRODUCT * 0.5 * cost).min(most).max(least);
        let pairs = StartPairs { slack: distance * START_SLACK, mu };
        self.barriers.start(problem, inputs, states, pairs);
        self.cost.start(problem);
        // Clear leftovers of an earlier problem beyond the horizon.
        for path in [&mut self.iterate, &mut self.predictor, &mut self.step] {
            path.fill(PathBlock::default());
        }
        let mut x = problem.x0;
        for k in 0..n {
            let (j, lane) = place(k);
            let u = self.barriers.input.value(k);
            self.iterate[j].u.0[lane] = u;
            self.iterate[j].set_state(lane, &x);
            x = problem.step(k, &x, u);
        }
        self.iterate[n / WIDTH].set_state(n % WIDTH, &x);
        self.terminal = [0.0; 3];
        self.residual = 1.0;
    }

    /// Performs one iteration; `None` if the step cannot be computed, with the iterate unchanged.
    pub(super) fn iterate(&mut self, problem: &Problem, lq: &LinearQuadratic) -> Option<Step> {
        match (lq.shape, problem.terminal) {
            (CHAIN, Terminal::Cost) => iterate::<false, CHAIN>(self, problem, lq),
            (CHAIN, Terminal::Equality(_)) => iterate::<true, CHAIN>(self, problem, lq),
            (_, Terminal::Cost) => iterate::<false, GENERAL>(self, problem, lq),
            (_, Terminal::Equality(_)) => iterate::<true, GENERAL>(self, problem, lq),
        }
    }

    #[inline(always)]
    fn iterate_with<const TERMINAL: bool, const SHAPE: Shape>(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
    ) -> Option<Step> {
        // Residuals and model.
        let (cost_to_go, gap) = self.factor(problem, lq);
        let mu = gap / self.barriers.pairs() as f64;

        // Predictor: towards products of zero.
        let (y, prediction) = self.predict::<TERMINAL, SHAPE>(problem, lq, &cost_to_go);
        let predictor = length(prediction.limit, 1.0);
        let neglected = prediction.neglected.sum() / gap;
        // Remaining fraction of the sum of the products, see [`pairs`].
        let left = ((1.0 - predictor) - predictor * predictor * neglected).max(0.0);

        // Corrector: towards products of τ. A short predictor step shows little of the products at full length. The
        // root of its length, used here in place of the length, saves some 3 %
        // of the iterations.
        let targets = Targets {
            product: (mu * (left * left * left).clamp(LEAST_CENTRING, 1.0)).max(LEAST_TARGET),
            trust: predictor.sqrt(),
            most: MOST_NEGLECTED * mu,
        };
        let (dy, limit) = self.correct::<TERMINAL, SHAPE>(problem, lq, &cost_to_go, targets);

        // Step.
        let length = length(limit, fraction_of_longest(mu, predictor));
        let end = state(&self.step, problem.horizon);
        if !(length > 0.0 && (mu + end[0] + end[1] + end[2]).is_finite()) {
            return None;
        }
        self.advance(problem, length, std::array::from_fn(|i| y[i] + dy[i]));
        Some(Step { mu, predictor, length })
    }

    /// Computes the sweep for the model at the iterate, and the sum of the products.
    #[inline(always)]
    fn factor(&mut self, problem: &Problem, lq: &LinearQuadratic) -> (CostToGo, f64) {
        let Self { barriers, cost, iterate, sweep, .. } = self;
        let mut models = Models { r: problem.r, barriers, cost, iterate, gap: Lanes::default() };
        let cost_to_go = lq.factor(problem, &mut models, sweep, problem.horizon);
        (cost_to_go, models.gap.sum())
    }

    /// Computes the predictor's change of the trajectory; returns its `y`.
    #[inline(always)]
    fn predict<const TERMINAL: bool, const SHAPE: Shape>(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        cost_to_go: &CostToGo,
    ) -> ([f64; 3], Prediction) {
        let n = problem.horizon;
        let y = match &problem.terminal {
            Terminal::Cost => [0.0; 3],
            Terminal::Equality(x_f) => {
                let end = state(&self.iterate, n);
                cost_to_go.terminal_system_of_change(&end, x_f).multiplier()
            }
        };
        let path = &mut self.predictor[..=n / WIDTH];
        let mut prediction = Prediction::default();
        let mut x = [0.0; 3];
        for j in 0..=n / WIDTH {
            let gains = block(&self.sweep.gains, WIDTH * j);
            for lane in 0..WIDTH.min(n - WIDTH * j) {
                let gain = &gains[lane];
                let offset = if TERMINAL { gain.offset(&y) } else { gain.feedforward[3] };
                let u = -gain.input(offset, &x);
                path[j].u.0[lane] = u;
                path[j].set_state(lane, &x);
                x = lq.closed_step::<SHAPE>(&x, gain, offset, u);
            }
            if j > 0 {
                self.barriers.predict(j - 1, &path[j - 1], &mut prediction);
            }
        }
        path[n / WIDTH].set_state(n % WIDTH, &x);
        self.barriers.predict(n / WIDTH, &path[n / WIDTH], &mut prediction);
        (y, prediction)
    }

    /// Adds the effect of the corrector's slopes to the predictor, by the recursion of the vectors
    /// alone. Returns the change of `y` and the limit of the step.
    #[inline(always)]
    fn correct<const TERMINAL: bool, const SHAPE: Shape>(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        cost_to_go: &CostToGo,
        targets: Targets,
    ) -> ([f64; 3], Lanes) {
        let n = problem.horizon;
        let barriers = &mut self.barriers;
        let mut v = [0.0; 3];
        let mut t = [0.0; 3];
        // Single lanes are read from memory.
        let mut ring = [(Lanes::default(), [Lanes::default(); 3]); 2];
        ring[n / WIDTH % 2] = barriers.set_targets(n / WIDTH, targets);
        for j in (0..=n / WIDTH).rev() {
            if j > 0 {
                ring[(j - 1) % 2] = barriers.set_targets(j - 1, targets);
            }
            let (slopes, added) = &ring[j % 2];
            let added_at = |lane: usize| [0, 1, 2].map(|i: usize| added[i].0[lane]);
            if j == n / WIDTH {
                v = added_at(n % WIDTH);
            }
            let gains = block(&self.sweep.gains, WIDTH * j);
            let constants = block_mut(&mut self.constants, WIDTH * j);
            for lane in (0..WIDTH.min(n - WIDTH * j)).rev() {
                let (gain, slope) = (&gains[lane], slopes.0[lane]);
                let f = lq.input_of::<SHAPE>(&v) + slope;
                constants[lane] = f * gain.inverse;
                if TERMINAL {
                    for i in 0..3 {
                        t[i] -= gain.feedforward[i] * f;
                    }
                }
                v = lq.closed_costate::<SHAPE>(&v, gain, slope, &added_at(lane));
            }
        }
        let y = match problem.terminal {
            Terminal::Cost => [0.0; 3],
            Terminal::Equality(_) => cost_to_go.factors().solve(&t),
        };
        let path = &mut self.step[..=n / WIDTH];
        let mut limit = Lanes::default();
        let mut x = [0.0; 3];
        for j in 0..=n / WIDTH {
            let gains = block(&self.sweep.gains, WIDTH * j);
            let constants = block(&self.constants, WIDTH * j);
            for lane in 0..WIDTH.min(n - WIDTH * j) {
                let (gain, f) = (&gains[lane], &gains[lane].feedforward);
                let mut offset = constants[lane];
                if TERMINAL {
                    offset += f[0] * y[0] + f[1] * y[1] + f[2] * y[2];
                }
                let u = -gain.input(offset, &x);
                path[j].u.0[lane] = u;
                path[j].set_state(lane, &x);
                x = lq.closed_step::<SHAPE>(&x, gain, offset, u);
            }
            if j > 0 {
                path[j - 1].add(&self.predictor[j - 1]);
                barriers.correct(j - 1, &path[j - 1], &mut limit);
            }
        }
        let last = &mut path[n / WIDTH];
        last.set_state(n % WIDTH, &x);
        last.add(&self.predictor[n / WIDTH]);
        barriers.correct(n / WIDTH, last, &mut limit);
        (y, limit)
    }

    #[inline(always)]
    fn advance(&mut self, problem: &Problem, length: f64, y: [f64; 3]) {
        let part = Lanes::all(length);
        let blocks = self.iterate.iter_mut().zip(&self.step[..=problem.horizon / WIDTH]);
        for (j, (block, change)) in blocks.enumerate() {
            self.barriers.advance(j, change.u, length);
            block.u = block.u + part * change.u;
            for i in 0..3 {
                block.x[i] = block.x[i] + part * change.x[i];
            }
        }
        for (old, new) in self.terminal.iter_mut().zip(y) {
            *old += length * (new - *old);
        }
        self.residual *= 1.0 - length;
    }

    /// Writes the guess of the active set that the last step suggests.
    pub(super) fn suggest(&self, problem: &Problem, guess: &mut WorkingSet) {
        self.barriers.suggest(problem, guess, &self.terminal);
    }

    /// Copies the inputs of the iterate to `inputs`, within their bounds.
    pub(super) fn read_inputs(&self, problem: &Problem, inputs: &mut [f64]) {
        for (k, out) in inputs[..problem.horizon].iter_mut().enumerate() {
            *out = self.barriers.input.value(k).max(problem.u_min).min(problem.u_max);
        }
    }

    /// Copies the multipliers of the iterate to `multipliers`.
    pub(super) fn read_multipliers(&self, multipliers: &mut Multipliers) {
        self.barriers.read(multipliers);
        multipliers.terminal = self.terminal;
    }
}

/// Returns the fraction of the longest possible step that is taken.
fn fraction_of_longest(mu: f64, predictor: f64) -> f64 {
    let short = 1.0 - predictor;
    let margin = MARGIN + SHORT_MARGIN * (short * short);
    (1.0 - mu.min(margin)).max(0.5 + 0.5 * predictor).min(0.9995)
}

/// An iteration, compiled for wide registers too: what it calls is inlined.
#[multiversion(targets("x86_64+avx2"))]
fn iterate<const TERMINAL: bool, const SHAPE: Shape>(
    point: &mut InteriorPoint,
    problem: &Problem,
    lq: &LinearQuadratic,
) -> Option<Step> {
    point.iterate_with::<TERMINAL, SHAPE>(problem, lq)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_is_left_out_of_a_step_where_the_predictor_is_short() {
        assert_eq!(fraction_of_longest(1e3, 1.0), 0.9995);
        assert_eq!(fraction_of_longest(1e3, 0.9), 1.0 - (MARGIN + SHORT_MARGIN * 0.1_f64.powi(2)));
        assert_eq!(fraction_of_longest(1e3, 0.0), 1.0 - MARGIN - SHORT_MARGIN);
        assert_eq!(fraction_of_longest(1e-3, 0.0), 0.999);
    }
}
