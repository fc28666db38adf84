//! All families of inequalities together: the bounds of the inputs, the rows, the light.
//!
//! The work is done lane by lane for a block of stages. The sweeps over the stages call it block by
//! block. A sweep mostly waits for its divisions and sums, and the machine works on the block in
//! that time.

use super::input::InputBarrier;
use super::light::LightBarrier;
use super::pairs::{Lengths, Limits, Prediction, Targets};
use super::path::PathBlock;
use super::row::RowBarrier;
use crate::kkt::Multipliers;
use crate::limits::MAX_ROWS;
use crate::problem::Problem;
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::light_curve::LightCurve;
use crate::riccati::lqr::BlockModel;
use crate::riccati::row_curve::STIFFNESS;
use crate::riccati::working_set::WorkingSet;

/// Distance of the first inputs from their bounds, as a fraction of the range.
const START_MARGIN: f64 = 0.3;

/// Pairs of a problem.
#[derive(Clone, Debug)]
pub(super) struct Barriers {
    pub(super) input: InputBarrier,
    rows: [RowBarrier; MAX_ROWS],
    light: LightBarrier,
    /// Number of rows of the present problem.
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

    /// Starts near a trajectory, with slacks of at least `slack` and products of about `mu`.
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

    /// Returns the number of pairs, including those that fill the last blocks.
    pub(super) fn pairs(&self) -> usize {
        let rows: usize = self.rows[..self.count].iter().map(RowBarrier::pairs).sum();
        self.input.pairs() + rows + self.light.pairs()
    }

    /// Adds the pairs of block `j` to its model for the predictor; returns the sum of the products.
    #[inline(always)]
    pub(super) fn linearize(&mut self, j: usize, x: &[Lanes; 3], model: &mut BlockModel) -> Lanes {
        let mut gap = self.input.linearize(j, model);
        for row in &mut self.rows[..self.count] {
            gap = gap + row.linearize(j, x, model);
        }
        gap + self.light.linearize(j, x, model)
    }

    /// Applies the predictor's changes of the trajectory to the pairs of block `j`.
    #[inline(always)]
    pub(super) fn predict(&mut self, j: usize, change: &PathBlock, prediction: &mut Prediction) {
        self.input.predict(j, change.u, prediction);
        for row in &mut self.rows[..self.count] {
            row.predict(j, &change.x, prediction);
        }
        self.light.predict(j, &change.x, prediction);
    }

    /// Sets the corrector's targets of block `j` ([`Targets`]). Returns their terms in the
    /// gradients of inputs and states.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, j: usize, targets: Targets) -> (Lanes, [Lanes; 3]) {
        let slope = self.input.set_targets(j, targets);
        let mut added = [Lanes::default(); 3];
        for row in &mut self.rows[..self.count] {
            row.set_targets(j, targets, &mut added);
        }
        self.light.set_targets(j, targets, &mut added);
        (slope, added)
    }

    /// Applies the step's changes of the trajectory to the pairs of block `j`, and updates the
    /// limits of the step.
    #[inline(always)]
    pub(super) fn correct(&mut self, j: usize, change: &PathBlock, limits: &mut Limits) {
        self.input.correct(j, change.u, limits);
        for row in &mut self.rows[..self.count] {
            row.correct(j, &change.x, limits);
        }
        self.light.correct(j, &change.x, limits);
    }

    /// Advances block `j` by the step.
    #[inline(always)]
    pub(super) fn advance(&mut self, j: usize, du: Lanes, lengths: Lengths) {
        self.input.advance(j, du, lengths);
        for row in &mut self.rows[..self.count] {
            row.advance(j, lengths);
        }
        self.light.advance(j, lengths);
    }

    /// Writes the guess of the active set that the last step suggests; `terminal` is the multiplier
    /// of the terminal equality.
    pub(super) fn suggest(&self, problem: &Problem, guess: &mut WorkingSet, terminal: &[f64; 3]) {
        let sides = &mut guess.sides[..problem.horizon];
        for (j, sides) in sides.chunks_mut(WIDTH).enumerate() {
            sides.copy_from_slice(&self.input.sides(j)[..sides.len()]);
        }
        if let Some(cost) = &problem.light {
            self.light.suggest(&LightCurve::new(cost), &mut guess.light[..problem.light_len]);
        }
        guess.has_row_tangents = self.count > 0;
        let rows = self.rows[..self.count].iter().map(RowBarrier::largest_multiplier);
        let scale = terminal.iter().map(|y| y.abs()).chain(rows).fold(1.0, f64::max);
        guess.row_stiffness = STIFFNESS * scale;
        for (row, tangents) in self.rows[..self.count].iter().zip(&mut guess.rows) {
            row.suggest(guess.row_stiffness, &mut tangents[..=problem.horizon]);
        }
    }

    /// Copies the multipliers to `multipliers`.
    pub(super) fn read(&self, multipliers: &mut Multipliers) {
        for (out, row) in multipliers.rows.iter_mut().zip(&self.rows[..self.count]) {
            row.read(out);
        }
        self.light.read(&mut multipliers.light);
    }
}
