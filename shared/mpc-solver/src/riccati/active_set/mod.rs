//! Fast method: a semismooth Newton method on the set of active constraints.
//!
//! A guess states which inputs are at their bounds and which rows act. It also states where each stage lies on the
//! light's curve. A round solves the linear-quadratic problem of the guess:
//!
//! 1. *Backward sweep* ([`super::lqr`]). The inputs of the guess are held, and tangents replace the light's curve. It
//!    starts at the last stage at which the guess has changed. The first sweep has free inputs alone ([`models`]).
//! 2. *Row response* ([`response`]): effect of the working rows' multipliers on the trajectory.
//! 3. *Complementarity* ([`dual`], [`super::complementarity`]): exact multipliers of these rows and of the
//!    terminal equality.
//! 4. *Forward sweep* ([`forward`]), which clamps every input to its bounds.
//! 5. *New guess*: the clamped sides of the inputs, tangents at the new margins ([`models`]), and the rows that the
//!    trajectory violates ([`rows`]).
//!
//! The trajectory is optimal under three conditions. No input changes sides, no further row is violated, and all
//! margins are at their tangents' points of contact. The multiplier of a bound is then `v − u` times `−δ`. Most cruise
//! problems settle after one or two rounds. With a light it takes about seven, with the light and a row about eleven.
//!
//! The method has no safeguard and may wander. It ends because the rounds are bounded and
//! [`give_up`] drops attempts that wander; [`crate::Riccati`] then uses another method.
//!
//! A guess from the interior point holds its rows by tangents in the sweep itself. There may be many of them, and they
//! are nearly right. In a cold attempt, rows enter the working set when the trajectory violates them. This starts in the
//! second round, because the first one ignores the light.

mod dual;
mod forward;
mod give_up;
mod models;
mod response;
mod rows;

use super::lqr::{Cost, LinearQuadratic, Sweep};
use super::working_set::{Side, WorkingSet};
use crate::kkt::Multipliers;
use crate::problem::{Problem, Terminal};
use forward::{Policy, Trajectory};
use give_up::Progress;
use models::{FirstSweep, Models};
use response::RowResponse;
use rows::{Update, WorkingRows};

/// Largest numbers of rounds, of a cold attempt and from an iterate.
const MAX_ROUNDS: u32 = 15;
const FINISH_ROUNDS: u32 = 5;
/// Number of rounds whose trajectories may start the interior point; later ones may have diverged.
const EARLY_ROUNDS: u32 = 3;
/// Relative distance from a curve that counts as zero.
const ON_CURVE: f64 = 2e-9;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum From {
    Nothing,
    /// The guess of an iterate of the interior point.
    Iterate,
}

/// Primal and dual variables filled by an attempt.
pub(super) struct Point<'a> {
    pub(super) inputs: &'a mut [f64],
    pub(super) states: &'a mut [[f64; 3]],
    pub(super) multipliers: &'a mut Multipliers,
}

/// Guess and work memory.
#[derive(Clone, Debug)]
pub(super) struct ActiveSet {
    pub(super) guess: WorkingSet,
    rows: WorkingRows,
    cost: Cost,
    first_sweep: FirstSweep,
    sweep: Sweep,
    response: RowResponse,
    next_sides: Vec<Side>,
    /// Inputs of the last early trajectory ([`EARLY_ROUNDS`]).
    pub(super) early_inputs: Vec<f64>,
}

impl ActiveSet {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self {
            guess: WorkingSet::new(max_horizon),
            rows: WorkingRows::new(),
            cost: Cost::new(max_horizon),
            first_sweep: FirstSweep::new(max_horizon),
            sweep: Sweep::new(max_horizon),
            response: RowResponse::new(max_horizon),
            next_sides: vec![Side::Free; max_horizon],
            early_inputs: vec![0.0; max_horizon],
        }
    }

    /// Solves; returns whether the attempt settled, and the number of rounds. The point is that of the last round.
    pub(super) fn solve(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        from: From,
        point: &mut Point,
    ) -> (bool, u32) {
        let n = problem.horizon;
        let is_cold = from == From::Nothing;
        let max_rounds = if is_cold { MAX_ROUNDS } else { FINISH_ROUNDS };
        if is_cold {
            self.guess.sides.fill(Side::Free);
        }
        self.rows.clear();
        self.cost.start(problem);
        // Last stage at which the guess differs from that of the previous sweep.
        let mut last_changed = n;
        for round in 1..=max_rounds {
            // The first round of a cold attempt ignores light and rows; it only finds the margins.
            let is_bare = is_cold && round == 1;
            if !self.minimise(problem, lq, from, is_bare, last_changed, point) {
                return (false, round);
            }
            if is_cold && round <= EARLY_ROUNDS {
                self.early_inputs[..n].copy_from_slice(&point.inputs[..n]);
            }
            let progress = self.progress(problem, round);
            let off_curve = self.guess.renew_light(problem, is_bare, point);
            let is_at_rest = progress.changed == 0 && off_curve <= ON_CURVE;
            let rows = if is_cold {
                let most = progress.most_violated(problem.light_len > 0);
                match self.rows.update(problem, point.states, most) {
                    Update::TooMany => return (false, round),
                    Update::Stuck if is_at_rest => return (false, round),
                    update => RowChange::by_working_set(update == Update::Complete),
                }
            } else {
                self.guess.renew_rows(problem, point)
            };
            if is_at_rest && rows.is_complete {
                if is_cold {
                    self.rows.write(problem, &mut point.multipliers.rows);
                }
                return (true, round);
            }
            if is_bare {
                self.rows.clear();
            }
            let is_wandering = if is_cold {
                progress.is_hopeless()
            } else {
                progress.refutes_iterate(rows.parts, max_rounds - round)
            };
            if is_wandering {
                return (false, round);
            }
            let (sides, next) = (&mut self.guess.sides[..n], &self.next_sides[..n]);
            last_changed = sides.iter().zip(next).rposition(|(a, b)| a != b).unwrap_or(0);
            last_changed = last_changed.max(problem.light_len).max(rows.last_stage);
            sides.copy_from_slice(next);
        }
        (false, max_rounds)
    }

    /// Performs steps 1 to 4 of a round; returns false if multipliers or trajectory are not finite.
    fn minimise(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        from: From,
        is_bare: bool,
        last_changed: usize,
        point: &mut Point,
    ) -> bool {
        let cost_to_go = if is_bare {
            self.first_sweep.fill(problem, lq, &self.cost, &mut self.sweep)
        } else {
            let rows = if from == From::Nothing { 0 } else { problem.rows.len() };
            let mut models = Models { problem, cost: &self.cost, guess: &self.guess, rows };
            lq.factor(problem, &mut models, &mut self.sweep, last_changed)
        };
        let sides = &self.guess.sides;
        self.response.compute(problem, lq, &self.sweep, sides, &self.rows.members);
        let rows = &mut self.rows.members;
        let Some(y) = dual::solve(problem, &cost_to_go, &self.response, rows) else { return false };
        point.multipliers.terminal = y;
        let (sweep, response) = (&self.sweep, &self.response);
        let policy = Policy { lq, sweep, terminal: y, response, rows: &self.rows.members };
        let Point { inputs, states, .. } = point;
        policy.simulate(problem, &mut Trajectory { inputs, states, sides: &mut self.next_sides });
        let end = &point.states[problem.horizon];
        (end[0] + end[1] + end[2] + y[0] + y[1] + y[2]).is_finite()
    }

    fn progress(&self, problem: &Problem, round: u32) -> Progress {
        let n = problem.horizon;
        let (before, after) = (&self.guess.sides[..n], &self.next_sides[..n]);
        Progress {
            round,
            horizon: n,
            changed: before.iter().zip(after).filter(|(before, after)| before != after).count(),
            free: after.iter().filter(|side| **side == Side::Free).count(),
            has_terminal_equality: matches!(problem.terminal, Terminal::Equality(_)),
        }
    }
}

/// Changes of a round in the rows of the guess.
struct RowChange {
    /// True if nothing changed: all rows hold with their present multipliers.
    is_complete: bool,
    /// Number of stages at which a row moved to another part of its curve.
    parts: usize,
    /// Last stage with a new tangent.
    last_stage: usize,
}

impl RowChange {
    /// Returns a change without new tangents.
    fn by_working_set(is_complete: bool) -> Self {
        Self { is_complete, parts: 0, last_stage: 0 }
    }
}
