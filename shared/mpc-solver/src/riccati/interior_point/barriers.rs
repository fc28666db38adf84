//! All families of inequalities together: the bounds of the inputs, the rows, the light.

use super::input::InputBarrier;
use super::light::LightBarrier;
use super::row::RowBarrier;
use crate::kkt::Multipliers;
use crate::limits::MAX_ROWS;
use crate::problem::Problem;
use crate::riccati::light_curve::LightCurve;
use crate::riccati::working_set::WorkingSet;

/// Distance of the first inputs from their bounds, part of the range.
const START_MARGIN: f64 = 0.3;

/// The pairs of a problem.
#[derive(Clone, Debug)]
pub(super) struct Barriers {
    pub(super) input: InputBarrier,
    rows: [RowBarrier; MAX_ROWS],
    light: LightBarrier,
    /// Rows of the problem at hand.
    count: usize,
}

impl Barriers {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self {
            input: InputBarrier::new(max_horizon),
            rows: std::array::from_fn(|_| RowBarrier::new(max_horizon)),
            light: LightBarrier::new(max_horizon),
            count: 0,
        }
    }

    /// Starts near a trajectory with slacks of at least `slack` and products of about `mu`.
    pub(super) fn start(
        &mut self,
        problem: &Problem,
        inputs: &[f64],
        states: &[[f64; 3]],
        slack: f64,
        mu: f64,
    ) {
        self.count = problem.rows.len();
        self.input.start(inputs, (problem.u_min, problem.u_max), START_MARGIN, mu);
        let limits = problem.rows.iter().zip(&problem.limits);
        for (barrier, (row, h)) in self.rows.iter_mut().zip(limits) {
            barrier.start(row, h, states, slack, mu);
        }
        self.light.start(problem.light.as_ref(), problem.light_stages(), states, slack, mu);
    }

    /// Models the pairs for the predictor; returns the sum of the products and their mean.
    #[inline(always)]
    pub(super) fn linearize(&mut self, problem: &Problem, states: &[[f64; 3]]) -> (f64, f64) {
        let (mut gap, mut pairs) = self.input.linearize();
        for (row, h) in self.rows[..self.count].iter_mut().zip(&problem.limits) {
            let (row_gap, row_pairs) = row.linearize(h, states);
            gap += row_gap;
            pairs += row_pairs;
        }
        let (light_gap, light_pairs) = self.light.linearize(problem.light_stages(), states);
        gap += light_gap;
        (gap, gap / (pairs + light_pairs) as f64)
    }

    /// What the predictor's changes of the trajectory mean for the pairs.
    #[inline(always)]
    pub(super) fn expand_predictor(
        &mut self,
        problem: &Problem,
        inputs: &[f64],
        states: &[[f64; 3]],
    ) {
        self.expand(problem, inputs, states, false);
    }

    /// The same with the corrector.
    #[inline(always)]
    pub(super) fn expand_corrector(
        &mut self,
        problem: &Problem,
        inputs: &[f64],
        states: &[[f64; 3]],
    ) {
        self.expand(problem, inputs, states, true);
    }

    #[inline(always)]
    fn expand(
        &mut self,
        problem: &Problem,
        inputs: &[f64],
        states: &[[f64; 3]],
        is_corrected: bool,
    ) {
        self.input.expand(inputs);
        for row in &mut self.rows[..self.count] {
            row.expand(states, is_corrected);
        }
        self.light.expand(problem.light_stages(), states, is_corrected);
    }

    /// Length of the longest predictor step, at most 1.
    #[inline(always)]
    pub(super) fn predictor_length(&self) -> f64 {
        let reciprocal =
            self.input.affine_step_reciprocal().max(self.light.affine_step_reciprocal());
        let rows = self.rows[..self.count].iter().map(RowBarrier::affine_step_reciprocal);
        1.0 / rows.fold(reciprocal, f64::max)
    }

    /// Sum of the products after a predictor step of length `a`.
    #[inline(always)]
    pub(super) fn gap_after_predictor(&self, a: f64) -> f64 {
        let rows: f64 = self.rows[..self.count].iter().map(|row| row.gap_after_affine(a)).sum();
        rows + self.input.gap_after_affine(a) + self.light.gap_after_affine(a)
    }

    /// Sets the corrector's targets, and the slopes that they add: towards products of `tau`, and away from what the
    /// predictor has neglected, of which the part `trust` counts.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, tau: f64, trust: f64) {
        self.input.set_targets(tau, trust);
        for row in &mut self.rows[..self.count] {
            row.set_targets(tau, trust);
        }
        self.light.set_targets(tau, trust);
    }

    /// Reciprocal of the length of the longest step; not finite if the step is not.
    #[inline(always)]
    pub(super) fn step_reciprocal(&self) -> f64 {
        let reciprocal = self.input.step_reciprocal().max(self.light.step_reciprocal());
        let rows = self.rows[..self.count].iter().map(RowBarrier::step_reciprocal);
        rows.fold(reciprocal, f64::max)
    }

    /// Takes the part `a` of the step.
    #[inline(always)]
    pub(super) fn advance(&mut self, inputs: &[f64], a: f64) {
        self.input.advance(inputs, a);
        for row in &mut self.rows[..self.count] {
            row.advance(a);
        }
        self.light.advance(a);
    }

    /// Calls back with `g`, curvature and slope of each modelled function of `g'x_k`.
    #[inline(always)]
    pub(super) fn each_state_function(
        &self,
        problem: &Problem,
        k: usize,
        mut add: impl FnMut(&[f64; 3], f64, f64),
    ) {
        for row in &self.rows[..self.count] {
            let i = k.wrapping_sub(row.from);
            if i < row.len {
                add(&row.gradient, row.curvature[i], row.slope[i]);
            }
        }
        if k <= self.light.len {
            let stage = &problem.light_stages[k - 1];
            add(&stage.gradient, self.light.curvature[k - 1], -self.light.slope[k - 1]);
        }
    }

    /// Adds slope times `g` of each of them to `v`.
    #[inline(always)]
    pub(super) fn add_slopes(&self, problem: &Problem, k: usize, v: &mut [f64; 3]) {
        self.each_state_function(problem, k, |g, _, slope| {
            for i in 0..3 {
                v[i] += slope * g[i];
            }
        });
    }

    /// Writes the guess of the active set that the last step suggests.
    pub(super) fn suggest(&self, problem: &Problem, guess: &mut WorkingSet) {
        for (k, side) in guess.sides[..problem.horizon].iter_mut().enumerate() {
            *side = self.input.side(k);
        }
        if let Some(cost) = &problem.light {
            let curve = LightCurve::new(cost);
            for (k, tangent) in guess.light[..problem.light_len].iter_mut().enumerate() {
                *tangent = self.light.tangent(&curve, k);
            }
        }
        guess.has_row_tangents = self.count > 0;
        for (j, row) in problem.rows.iter().enumerate() {
            for (k, tangent) in guess.rows[j][..=problem.horizon].iter_mut().enumerate() {
                let is_in_force = k >= row.from && k <= row.to;
                *tangent = if is_in_force { self.rows[j].tangent(k) } else { Default::default() };
            }
        }
    }

    /// Copies the multipliers out.
    pub(super) fn read(&self, multipliers: &mut Multipliers) {
        for (out, row) in multipliers.rows.iter_mut().zip(&self.rows[..self.count]) {
            out[row.from..row.from + row.len].copy_from_slice(row.multipliers());
        }
        multipliers.light[1..=self.light.len].copy_from_slice(self.light.multipliers());
    }
}
