//! All families of inequalities together: the bounds of the inputs, the rows, the light.
//!
//! The work is done lane by lane for a block of stages. The sweeps over the stages call it block by
//! block. A sweep mostly waits for its divisions and sums, and the machine works on the block in
//! that time.

use super::bound::{Bound, StartPairs};
use super::input::InputBarrier;
use super::pairs::{PathBlock, Prediction, Targets};
use crate::kkt::Multipliers;
use crate::limits::MAX_ROWS;
use crate::problem::Problem;
use crate::riccati::curve::{Curve, STIFFNESS};
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::lqr::{BlockModel, BlockModels, Cost};
use crate::riccati::working_set::WorkingSet;

/// Distance of the first inputs from their bounds, as a fraction of the range.
const START_MARGIN: f64 = 0.3;

/// Pairs of a problem.
#[derive(Clone, Debug)]
pub(super) struct Barriers {
    pub(super) input: InputBarrier,
    /// The rows, then the light.
    bounds: [Bound; MAX_ROWS + 1],
    /// Numbers of rows, and of rows and light.
    rows: usize,
    count: usize,
}

impl Barriers {
    pub(super) fn new(max_horizon: usize) -> Self {
        let bounds = std::array::from_fn(|_| Bound::new(max_horizon));
        Self { input: InputBarrier::new(max_horizon), bounds, rows: 0, count: 0 }
    }

    /// Starts near a trajectory.
    pub(super) fn start(
        &mut self,
        problem: &Problem,
        inputs: &[f64],
        states: &[[f64; 3]],
        start: StartPairs,
    ) {
        self.input.start(inputs, (problem.u_min, problem.u_max), START_MARGIN, start.mu);
        let limits = problem.rows.iter().zip(&problem.limits);
        for (bound, (row, h)) in self.bounds.iter_mut().zip(limits) {
            bound.start_row(row, h, states, start);
        }
        self.rows = problem.rows.len();
        self.count = self.rows;
        if let Some(light) = problem.light.as_ref().filter(|_| problem.light_len > 0) {
            self.bounds[self.rows].start_light(light, problem, states, start);
            self.count += 1;
        }
    }

    /// Returns the number of pairs, including those that fill the last blocks.
    pub(super) fn pairs(&self) -> usize {
        self.input.pairs() + self.bounds[..self.count].iter().map(Bound::pairs).sum::<usize>()
    }

    /// Adds the pairs of block `j` to its model for the predictor; returns the sum of the products.
    #[inline(always)]
    pub(super) fn linearize(&mut self, j: usize, x: &[Lanes; 3], model: &mut BlockModel) -> Lanes {
        let mut gap = self.input.linearize(j, model);
        for bound in &mut self.bounds[..self.count] {
            gap = gap + bound.linearize(j, x, model);
        }
        gap
    }

    /// Applies the predictor's changes of the trajectory to the pairs of block `j`.
    #[inline(always)]
    pub(super) fn predict(&mut self, j: usize, change: &PathBlock, prediction: &mut Prediction) {
        self.input.predict(j, change.u, prediction);
        for bound in &mut self.bounds[..self.count] {
            bound.predict(j, &change.x, prediction);
        }
    }

    /// Sets the corrector's targets of block `j` ([`Targets`]). Returns their terms in the
    /// gradients of inputs and states.
    #[inline(always)]
    pub(super) fn set_targets(&mut self, j: usize, targets: Targets) -> (Lanes, [Lanes; 3]) {
        let slope = self.input.set_targets(j, targets);
        let mut added = [Lanes::default(); 3];
        for bound in &mut self.bounds[..self.count] {
            bound.set_targets(j, targets, &mut added);
        }
        (slope, added)
    }

    /// Applies the step's changes of the trajectory to the pairs of block `j`, and updates the
    /// limit of the step.
    #[inline(always)]
    pub(super) fn correct(&mut self, j: usize, change: &PathBlock, limit: &mut Lanes) {
        self.input.correct(j, change.u, limit);
        for bound in &mut self.bounds[..self.count] {
            bound.correct(j, &change.x, limit);
        }
    }

    #[inline(always)]
    pub(super) fn advance(&mut self, j: usize, du: Lanes, length: f64) {
        self.input.advance(j, du, length);
        for bound in &mut self.bounds[..self.count] {
            bound.advance(j, length);
        }
    }

    /// Writes the guess of the active set that the last step suggests; `terminal` is the multiplier
    /// of the terminal equality.
    pub(super) fn suggest(&self, problem: &Problem, guess: &mut WorkingSet, terminal: &[f64; 3]) {
        let sides = &mut guess.sides[..problem.horizon];
        for (j, sides) in sides.chunks_mut(WIDTH).enumerate() {
            sides.copy_from_slice(&self.input.sides(j)[..sides.len()]);
        }
        let rows = self.bounds[..self.rows].iter().flat_map(Bound::multipliers);
        let all = rows.map(|(_, mu)| mu).chain(terminal.iter().map(|y| y.abs()));
        let stiffness = STIFFNESS * all.fold(1.0, f64::max);
        guess.row_stiffness = stiffness;
        let rows = problem.rows.iter().zip(&problem.limits).zip(&self.bounds);
        for (((row, limits), bound), tangents) in rows.zip(&mut guess.rows) {
            bound.suggest(|k| Curve::of_row(row.softness, limits[k], stiffness), tangents);
        }
        if let Some(cost) = problem.light.as_ref().filter(|_| self.count > self.rows) {
            self.bounds[self.rows].suggest(|_| Curve::of_light(cost), &mut guess.light);
        }
    }

    pub(super) fn read(&self, multipliers: &mut Multipliers) {
        for (out, bound) in multipliers.rows.iter_mut().zip(&self.bounds[..self.rows]) {
            bound.multipliers().for_each(|(k, mu)| out[k] = mu);
        }
        for bound in &self.bounds[self.rows..self.count] {
            bound.multipliers().for_each(|(k, mu)| multipliers.light[k] = mu);
        }
    }
}

/// The iterate as models of the stages.
pub(super) struct Models<'a> {
    pub(super) r: f64,
    pub(super) barriers: &'a mut Barriers,
    pub(super) cost: &'a Cost,
    pub(super) iterate: &'a [PathBlock],
    /// Sum of the products of the pairs so far.
    pub(super) gap: Lanes,
}

impl BlockModels for Models<'_> {
    const IS_WHOLE: bool = false;

    #[inline(always)]
    fn block(&mut self, j: usize) -> BlockModel {
        let PathBlock { u, x } = &self.iterate[j];
        let mut model = self.cost.block_at(j, self.r, *u, x);
        self.gap = self.gap + self.barriers.linearize(j, x, &mut model);
        model
    }
}
