//! Short horizons: a dual active set on the condensed problem, one inequality at a time.
//!
//! The problem in its inputs alone has few unknowns, and its factors serve all first states ([`condensed`]). A solve
//! starts at the optimum without inequalities. It then repeats two steps:
//!
//! 1. The violated inequality that lies farthest outside, in the metric of the cost, becomes a member.
//! 2. The members' multipliers are solved exactly ([`super::complementarity`]).
//!
//! The dual cost rises with every member, so the method ends. A warm solve starts with the members of the last solution,
//! moved forward. A cold one starts with the inputs that the feedback without inequalities holds at their bounds, if
//! all rows hold on its way.
//!
//! The light is not linear, and the terminal equality may leave no input to choose. Problems with either, and those
//! that fail here, go to the methods for long horizons.

mod condensed;

use multiversion::multiversion;

use super::active_set::Point;
use super::complementarity::Complementarity;
use super::lanes::{Lanes, WIDTH};
use super::lqr::{LinearQuadratic, Sweep, Unconstrained};
use crate::limits::MAX_ROWS;
use crate::problem::{Problem, Terminal};
use condensed::{Condensed, set_stage};

/// Largest horizon of the method. Beyond, the sweeps of the long methods are faster than columns.
pub(super) const MAX_SHORT: usize = 40;
/// Largest number of members: an optimum has at most one for each input, and some have left.
const MAX_MEMBERS: usize = MAX_SHORT + 8;
/// Violation that counts as zero, relative to the limit or 1.
const TOLERANCE: f64 = 1e-10;

/// Largest number of held inputs that a cold guess takes. Beyond, and while all rows hold, the sweeps of the long methods
/// settle in a round or two, and each round costs less than the columns of the members.
const MOST_HELD: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ShortStart {
    /// The members of the last solution, moved forward by this number of steps.
    Shifted(usize),
    /// No guess; problems that suit the sweeps are left to them.
    Cold,
    /// No guess, after the sweeps have failed.
    Last,
}

/// An inequality: a left side and the side on which it is bounded.
#[derive(Clone, Copy, Debug, Default)]
struct Member {
    left: usize,
    /// 1 for an upper bound, −1 for the lower bound of an input.
    sign: f64,
}

/// Work memory, and the members that are kept from solve to solve.
#[derive(Clone, Debug)]
pub(super) struct Short {
    condensed: Condensed,
    has_linear_terms: bool,
    /// Sweep of a problem with linear terms.
    sweep: Sweep,
    program: Box<Complementarity<MAX_MEMBERS>>,
    members: [Member; MAX_MEMBERS],
    /// Left sides: of the optimum without inequalities, and of the present point.
    free: Vec<f64>,
    left: Vec<f64>,
    /// Bounds of the left sides, a tolerance outside.
    upper: Vec<f64>,
    lower: Vec<f64>,
    scores: Vec<f64>,
}

impl Short {
    pub(super) fn new(max_horizon: usize) -> Self {
        let size = (max_horizon.min(MAX_SHORT) * (1 + MAX_ROWS)).next_multiple_of(WIDTH);
        Self {
            condensed: Condensed::new(max_horizon),
            has_linear_terms: false,
            sweep: Sweep::new(max_horizon.min(MAX_SHORT)),
            program: Box::new(Complementarity::new(0.0)),
            members: [Member::default(); MAX_MEMBERS],
            free: vec![0.0; size],
            left: vec![0.0; size],
            upper: vec![0.0; size],
            lower: vec![0.0; size],
            scores: vec![0.0; size],
        }
    }

    /// Returns whether the method can solve a problem.
    pub(super) fn serves(problem: &Problem) -> bool {
        problem.horizon <= MAX_SHORT && problem.light_len == 0 && problem.terminal == Terminal::Cost
    }

    /// Writes the inputs and the rows' multipliers of the optimum; returns the number of rounds. `None` if the attempt
    /// fails.
    pub(super) fn solve(
        &mut self,
        problem: &Problem,
        start: ShortStart,
        point: &mut Point,
    ) -> Option<u32> {
        self.condensed.factor(problem);
        let rounds = solve_in(self, problem, start)?;
        let (n, inputs, multipliers) =
            (problem.horizon, &mut *point.inputs, &mut *point.multipliers);
        for (u, left) in inputs[..n].iter_mut().zip(&self.left) {
            // This order turns NaN into a bound.
            *u = left.max(problem.u_min).min(problem.u_max);
        }
        for row in &mut multipliers.rows[..problem.rows.len()] {
            row[..=n].fill(0.0);
        }
        multipliers.terminal = [0.0; 3];
        for (member, mu) in self.members[..self.program.len].iter().zip(&self.program.multipliers) {
            if member.left >= n {
                multipliers.rows[member.left / n - 1][member.left % n + 1] = *mu;
            } else if *mu > 0.0 {
                inputs[member.left] = if member.sign > 0.0 { problem.u_max } else { problem.u_min };
            }
        }
        roll_out(problem, inputs, point.states);
        Some(rounds)
    }

    #[inline(always)]
    fn set_bounds(&mut self, problem: &Problem) {
        let (n, stride) = (problem.horizon, self.condensed.stride);
        let outside = |limit: f64, sign: f64| limit + sign * TOLERANCE * limit.abs().max(1.0);
        self.upper[..n].fill(outside(problem.u_max, 1.0));
        self.lower[..n].fill(outside(problem.u_min, -1.0));
        self.upper[n..stride].fill(f64::INFINITY);
        self.lower[n..stride].fill(f64::NEG_INFINITY);
        for (j, row) in problem.rows.iter().enumerate() {
            if row.from <= row.to {
                let upper = &mut self.upper[n * (1 + j) + row.from - 1..n * (1 + j) + row.to];
                for (slot, h) in upper.iter_mut().zip(&problem.limits[j][row.from..=row.to]) {
                    *slot = h + TOLERANCE * h.abs().max(1.0);
                }
            }
        }
    }

    /// Writes the left sides of the optimum without inequalities.
    #[inline(always)]
    fn set_free(&mut self, problem: &Problem) {
        let n = problem.horizon;
        self.has_linear_terms = problem.has_linear_terms();
        if !self.has_linear_terms {
            self.condensed.free(&problem.x0, &mut self.free);
            return;
        }
        let lq = LinearQuadratic::new(problem);
        self.condensed.cost.start(problem);
        let mut models = Unconstrained(&self.condensed.cost);
        lq.factor(problem, &mut models, &mut self.sweep, n);
        let mut x = problem.x0;
        for k in 0..n {
            let gain = &self.sweep.gains[k];
            let u = -gain.input(gain.feedforward[3], &x);
            x = problem.step(k, &x, u);
            set_stage(problem, k, u, &x, &mut self.free);
        }
    }

    /// Adds a member with this multiplier. Its bound is then the program's: beyond a soft one the point is right.
    /// `None` if there are too many members, or if no input changes the left side.
    #[inline(always)]
    fn enter(&mut self, problem: &Problem, member: Member, multiplier: f64) -> Option<()> {
        let program = &mut *self.program;
        let c = program.len;
        if c == MAX_MEMBERS || self.condensed.scale[member.left] == 0.0 {
            return None;
        }
        let column = self.condensed.column(member.left);
        self.members[c] = member;
        program.len += 1;
        if member.sign > 0.0 {
            self.upper[member.left] = f64::INFINITY;
        } else {
            self.lower[member.left] = f64::NEG_INFINITY;
        }
        for (e, other) in self.members[..=c].iter().enumerate() {
            let response = member.sign * other.sign * column[other.left];
            (program.response[c][e], program.response[e][c]) = (response, response);
        }
        program.scale[c] = program.response[c][c];
        let n = problem.horizon;
        let (limit, (weight, curvature)) = if member.left < n {
            let limit = if member.sign > 0.0 { problem.u_max } else { -problem.u_min };
            (limit, (f64::INFINITY, 0.0))
        } else {
            let j = member.left / n - 1;
            (problem.limits[j][member.left % n + 1], problem.rows[j].softness.penalty())
        };
        program.value[c] = member.sign * self.free[member.left] - limit;
        (program.weight[c], program.curvature[c]) = (weight, curvature);
        program.multipliers[c] = multiplier;
        Some(())
    }

    /// Makes the acting members of the last solution, moved forward by `steps`, the first members.
    #[inline(always)]
    fn keep(&mut self, problem: &Problem, steps: usize) -> Option<()> {
        let (before, multipliers) = (self.members, self.program.multipliers);
        let count = self.program.len;
        self.program.clear();
        for (member, mu) in before[..count].iter().zip(multipliers) {
            let Some(left) = member.left.checked_sub(steps) else { continue };
            let is_same_kind = left / problem.horizon == member.left / problem.horizon;
            let is_bounded = left < self.condensed.len && self.upper[left] < f64::INFINITY;
            if mu > 0.0 && is_same_kind && is_bounded {
                self.enter(problem, Member { left, ..*member }, mu)?;
            }
        }
        Some(())
    }

    /// Makes the inputs that the clamped feedback holds at their bounds the first members, if all rows hold on its way.
    /// `None` if they are more than `most`.
    #[inline(always)]
    fn guess(&mut self, problem: &Problem, most: usize) -> Option<()> {
        let mut x = problem.x0;
        let (mut held, mut count) = ([Member::default(); MAX_SHORT], 0);
        for k in 0..problem.horizon {
            let (gain, offset) = if self.has_linear_terms {
                (&self.sweep.gains[k], self.sweep.gains[k].feedforward[3])
            } else {
                (&self.condensed.sweep.gains[k], 0.0)
            };
            let v = -gain.input(offset, &x);
            let u = v.max(problem.u_min).min(problem.u_max);
            if u != v {
                held[count] = Member { left: k, sign: if v > u { 1.0 } else { -1.0 } };
                count += 1;
            }
            x = problem.step(k, &x, u);
            set_stage(problem, k, u, &x, &mut self.left);
        }
        if self.worst().is_some() {
            return Some(());
        }
        if count > most {
            return None;
        }
        held[..count].iter().try_for_each(|member| self.enter(problem, *member, 1.0))
    }

    /// Writes the left sides at the members' multipliers.
    #[inline(always)]
    fn set_left(&mut self) {
        let stride = self.condensed.stride;
        let left = &mut self.left[..stride];
        left.copy_from_slice(&self.free[..stride]);
        for (member, mu) in self.members[..self.program.len].iter().zip(&self.program.multipliers) {
            if *mu != 0.0 {
                let step = member.sign * mu;
                for (slot, response) in left.iter_mut().zip(self.condensed.column(member.left)) {
                    *slot -= step * response;
                }
            }
        }
    }

    /// Finds the violated inequality that lies farthest outside.
    #[inline(always)]
    fn worst(&mut self) -> Option<Member> {
        let stride = self.condensed.stride;
        let (left, scores) = (&self.left[..stride], &mut self.scores[..stride]);
        let (upper, lower) = (&self.upper[..stride], &self.lower[..stride]);
        let scale = &self.condensed.scale[..stride];
        let mut worst = Lanes::default();
        let bounds = blocks(upper).zip(blocks(lower)).zip(blocks(scale));
        let scores = scores.as_chunks_mut::<WIDTH>().0.iter_mut();
        for ((slot, left), ((upper, lower), scale)) in scores.zip(blocks(left)).zip(bounds) {
            let outside = (left - upper).greater(lower - left);
            // A left side that no input changes still counts when it is violated.
            let score = outside * scale.greater(Lanes::all(f64::MIN_POSITIVE));
            *slot = score.0;
            worst = score.greater(worst);
        }
        let worst = worst.largest();
        if worst <= 0.0 {
            return None;
        }
        let left = self.scores[..stride].iter().position(|score| *score == worst)?;
        let sign = if self.left[left] > self.upper[left] { 1.0 } else { -1.0 };
        Some(Member { left, sign })
    }
}

/// A solve up to its left sides, compiled for wide registers too.
#[multiversion(targets("x86_64+avx2"))]
fn solve_in(short: &mut Short, problem: &Problem, start: ShortStart) -> Option<u32> {
    short.set_bounds(problem);
    short.set_free(problem);
    let mut rounds = 1;
    match start {
        ShortStart::Shifted(steps) => short.keep(problem, steps)?,
        ShortStart::Cold | ShortStart::Last => {
            short.program.clear();
            short.set_left();
            if short.worst().is_none() {
                return Some(rounds);
            }
            let most = if start == ShortStart::Cold { MOST_HELD } else { MAX_SHORT };
            short.guess(problem, most)?;
        }
    }
    loop {
        if short.program.len > 0 {
            short.program.solve()?;
        }
        short.set_left();
        let Some(member) = short.worst() else { return Some(rounds) };
        // At zero it would have to be released first.
        short.enter(problem, member, f64::MIN_POSITIVE)?;
        rounds += 1;
    }
}

/// [`Problem::roll_out`], with the sums in an order in which a state waits for two of them alone.
fn roll_out(problem: &Problem, inputs: &[f64], states: &mut [[f64; 3]]) {
    let (a, b) = (&problem.a, &problem.b);
    let mut x = problem.x0;
    states[0] = x;
    for (k, u) in inputs[..problem.horizon].iter().enumerate() {
        let d = &problem.d[k];
        let given = [b[0] * u + d[0], b[1] * u + d[1], b[2] * u + d[2]];
        x = [
            a[0][0] * x[0] + (a[0][1] * x[1] + (a[0][2] * x[2] + given[0])),
            a[1][1] * x[1] + (a[1][2] * x[2] + given[1]),
            a[2][2] * x[2] + given[2],
        ];
        states[k + 1] = x;
    }
}

/// The values four by four.
#[inline(always)]
fn blocks(values: &[f64]) -> impl Iterator<Item = Lanes> {
    values.as_chunks::<WIDTH>().0.iter().copied().map(Lanes)
}
