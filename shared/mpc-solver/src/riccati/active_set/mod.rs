//! Fast method: a semismooth Newton method on the set of active constraints.
//!
//! A guess states which inputs are at their bounds and which rows act. It also states where each stage lies on the
//! light's curve. A round solves the linear-quadratic problem of the guess:
//!
//! 1. *Backward sweep* ([`super::lqr`]). The inputs of the guess are held, and tangents replace the light's curve. It
//!    starts at the last stage at which the guess has changed. In the first round it starts at the last stage that
//!    differs from free inputs ([`first_sweep`]).
//! 2. *Row response* ([`response`]): effect of the working rows' multipliers on the trajectory.
//! 3. *Complementarity* ([`dual`], [`super::complementarity`]): exact multipliers of these rows and of the
//!    terminal equality.
//! 4. *Forward sweep* ([`forward`]), which clamps every input to its bounds.
//! 5. *New guess*: the clamped sides of the inputs ([`switching`]), tangents at the new margins ([`light`]), and the
//!    rows that the trajectory violates ([`rows`]).
//!
//! The trajectory is optimal under three conditions. No input changes sides, no further row is violated, and all
//! margins are at their tangents' points of contact. The multiplier of a bound is then `v − u` times `−δ`. Most cruise
//! problems settle after one or two rounds. With a light it takes about seven, with the light and a row about eleven.
//!
//! The method has no safeguard and may wander. It ends because the rounds are bounded and
//! [`give_up`] drops attempts that wander; [`crate::Riccati`] then uses another method.
//!
//! A guess from the interior point holds its rows by tangents ([`super::row_curve`]) in the sweep itself. There may be
//! many of them, and they are nearly right. In other attempts, rows enter the working set when the trajectory violates
//! them. This holds for cold attempts and for warm ones after a solution with a working set. A cold attempt starts with
//! this in the second round, because the first one ignores the light.

mod dual;
mod first_sweep;
mod forward;
mod give_up;
mod light;
mod models;
mod response;
mod rows;
mod switching;

use super::light_curve::LightCurve;
use super::lqr::{Cost, LinearQuadratic, Sweep};
use super::working_set::{Side, WorkingSet, differences, last_difference};
use crate::kkt::Multipliers;
use crate::problem::{Problem, Terminal, dot};
use first_sweep::FirstSweep;
use forward::{Policy, Trajectory};
use give_up::{Approach, Descent, Progress};
use models::Models;
use response::RowResponse;
use rows::{Update, WorkingRows};

/// Largest number of rounds of a cold attempt.
const MAX_ROUNDS: u32 = 15;
/// Number of rounds whose trajectories may start the interior point; later ones may have diverged.
const EARLY_ROUNDS: u32 = 3;
/// Relative distance from the light's curve that counts as zero.
const ON_CURVE: f64 = 2e-9;

/// Outcome of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Optimal up to the check of the optimality conditions.
    Settled,
    /// The attempt was given up, or the rounds ran out.
    GivenUp,
}

/// Start of an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum From {
    /// No guess.
    Nothing,
    /// The guess of an earlier solution, with this largest number of rounds.
    Previous(u32),
    /// The guess of an iterate of the interior point, with this largest number of rounds.
    Iterate(u32),
}

/// Primal and dual variables filled by an attempt.
pub(super) struct Point<'a> {
    pub(super) inputs: &'a mut [f64],
    pub(super) states: &'a mut [[f64; 3]],
    pub(super) multipliers: &'a mut Multipliers,
}

/// Work memory, and the guess that is kept from solve to solve.
#[derive(Clone, Debug)]
pub(super) struct ActiveSet {
    pub(super) guess: WorkingSet,
    rows: WorkingRows,
    cost: Cost,
    first_sweep: FirstSweep,
    sweep: Sweep,
    response: RowResponse,
    next_sides: Vec<Side>,
    /// Sides of the previous guess.
    sides_before: Vec<Side>,
    unclamped: Vec<f64>,
    /// Switch at which the last round freed an input.
    freed_switch: Option<usize>,
    /// Inputs of the last early trajectory ([`EARLY_ROUNDS`]).
    early_inputs: Vec<f64>,
    /// True if a row tangent of the guess acted in the last round.
    row_tangents_act: bool,
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
            sides_before: vec![Side::Free; max_horizon],
            unclamped: vec![0.0; max_horizon],
            freed_switch: None,
            early_inputs: vec![0.0; max_horizon],
            row_tangents_act: false,
        }
    }

    /// Moves the guess forward by `steps`.
    pub(super) fn shift(&mut self, problem: &Problem, steps: usize) {
        let middle = self.guess.shift(problem, steps);
        self.rows.shift(problem, steps, middle);
    }

    /// Returns whether a row tangent of the guess acts.
    pub(super) fn has_acting_row_tangents(&self) -> bool {
        self.guess.has_row_tangents && self.row_tangents_act
    }

    /// Returns the inputs of the last early round of the last cold attempt.
    pub(super) fn early_inputs(&self) -> &[f64] {
        &self.early_inputs
    }

    /// Solves; returns the outcome and the number of rounds. The point is that of the last round.
    pub(super) fn solve(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        from: From,
        point: &mut Point,
    ) -> (Outcome, u32) {
        let n = problem.horizon;
        let curve = problem.light.as_ref().map(LightCurve::new).unwrap_or_default();
        let is_cold = from == From::Nothing;
        let max_rounds = match from {
            From::Nothing => MAX_ROUNDS,
            From::Previous(rounds) | From::Iterate(rounds) => rounds,
        };
        if is_cold {
            self.guess.clear();
        }
        if is_cold || self.guess.has_row_tangents {
            self.rows.clear();
        }
        self.freed_switch = None;
        self.cost.start(problem);
        // A cold first round ignores the light and only finds its margins.
        let mut has_light = problem.light_len == 0 || !is_cold;
        // Last stage at which the guess differs from that of the previous sweep.
        let mut last_changed = n;
        let mut approach = Approach::new(ON_CURVE);
        let mut descent = Descent::new();
        for round in 1..=max_rounds {
            if !self.minimise(problem, lq, round == 1, has_light, last_changed, point) {
                return (Outcome::GivenUp, round);
            }
            if is_cold && round <= EARLY_ROUNDS {
                self.early_inputs[..n].copy_from_slice(&point.inputs[..n]);
            }
            let progress = self.progress(problem, round);
            let was_first_with_light = problem.light_len > 0 && is_cold && round == 2;
            let off_curve = self.renew_light(problem, &curve, &mut has_light, point);
            let rows = if self.guess.has_row_tangents {
                self.renew_row_tangents(problem, point)
            } else if is_cold && round == 1 && !(progress.changed == 0 && off_curve == 0.0) {
                let most = progress.most_violated(problem.light_len > 0);
                if rows::are_violated(problem, point.states, most) {
                    return (Outcome::GivenUp, round);
                }
                RowChange::by_working_set(false)
            } else {
                let most = progress.most_violated(was_first_with_light);
                match self.rows.update(problem, point.states, most) {
                    Update::TooMany => return (Outcome::GivenUp, round),
                    Update::Stuck if progress.changed == 0 && off_curve <= ON_CURVE => {
                        return (Outcome::GivenUp, round);
                    }
                    update => RowChange::by_working_set(update == Update::Complete),
                }
            };
            if progress.changed == 0 && off_curve <= ON_CURVE && rows.is_complete {
                if !self.guess.has_row_tangents {
                    self.rows.write(problem, &mut point.multipliers.rows);
                }
                return (Outcome::Settled, round);
            }
            let is_wandering = match from {
                From::Nothing => {
                    let has_stalled = descent.has_stalled(progress.changed);
                    let may_stall = progress.has_terminal_equality && problem.light_len == 0;
                    progress.is_hopeless() || (may_stall && has_stalled)
                }
                From::Previous(_) => progress.refutes_guess(self.guess.has_row_tangents),
                From::Iterate(_) => {
                    let left = max_rounds - round;
                    let is_at_rest = progress.changed == 0 && rows.parts == 0;
                    approach.is_too_slow(is_at_rest, rows.distance, left)
                        || progress.refutes_iterate(rows.parts, left)
                }
            };
            if is_wandering {
                return (Outcome::GivenUp, round);
            }
            last_changed = self
                .renew_sides(
                    problem,
                    progress.changed <= 1 && off_curve <= ON_CURVE,
                    rows.last_acting,
                )
                .max(problem.light_len)
                .max(rows.last_stage);
        }
        (Outcome::GivenUp, max_rounds)
    }

    /// Performs steps 1 to 4 of a round; returns false if multipliers or trajectory are not finite.
    fn minimise(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        is_first: bool,
        has_light: bool,
        last_changed: usize,
        point: &mut Point,
    ) -> bool {
        let mut models = Models {
            problem,
            cost: &self.cost,
            sides: &self.guess.sides,
            tangents: &self.guess.light,
            stages: if has_light { problem.light_stages() } else { &[] },
            rows: &self.guess.rows[..self.guess.row_count(problem)],
        };
        let cost_to_go = if is_first {
            let last = models.last_modelled(problem.horizon);
            self.first_sweep.fill(problem, lq, &self.cost, &mut models, last, &mut self.sweep)
        } else {
            lq.factor(problem, &mut models, &mut self.sweep, last_changed)
        };
        let sides = &self.guess.sides;
        self.response.compute(problem, lq, &self.sweep, sides, self.rows.members());
        let rows = self.rows.members_mut();
        let Some(y) = dual::solve(problem, &cost_to_go, &self.response, rows) else { return false };
        point.multipliers.terminal = y;
        let (sweep, response) = (&self.sweep, &self.response);
        let policy = Policy { lq, sweep, terminal: y, response, rows: self.rows.members() };
        policy.simulate(
            problem,
            &mut Trajectory {
                inputs: point.inputs,
                states: point.states,
                sides: &mut self.next_sides,
                unclamped: &mut self.unclamped,
            },
        );
        let end = &point.states[problem.horizon];
        (end[0] + end[1] + end[2] + y[0] + y[1] + y[2]).is_finite()
    }

    fn progress(&self, problem: &Problem, round: u32) -> Progress {
        let n = problem.horizon;
        let (before, after) = (&self.guess.sides[..n], &self.next_sides[..n]);
        let free = |side: &Side| u32::from(*side as i8 == Side::Free as i8);
        Progress {
            round,
            horizon: n,
            returns: round > 2 && differences(&self.sides_before[..n], after) == 0,
            changed: differences(before, after),
            free: after.iter().map(free).sum::<u32>() as usize,
            has_terminal_equality: matches!(problem.terminal, Terminal::Equality(_)),
        }
    }

    /// Renews the light's tangents; returns the relative distance of the trajectory from the curve.
    fn renew_light(
        &mut self,
        problem: &Problem,
        curve: &LightCurve,
        has_light: &mut bool,
        point: &mut Point,
    ) -> f64 {
        if !*has_light {
            light::place(problem, curve, point.states, &mut self.guess.light);
            *has_light = true;
            return f64::INFINITY;
        }
        let multipliers = &mut point.multipliers.light;
        light::project(problem, curve, point.states, &mut self.guess.light, multipliers)
    }

    /// Renews the row tangents of the guess.
    fn renew_row_tangents(&mut self, problem: &Problem, point: &mut Point) -> RowChange {
        let mut change = RowChange::by_working_set(true);
        self.row_tangents_act = false;
        let stiffness = self.guess.row_stiffness;
        for (j, row) in problem.rows.iter().enumerate() {
            for k in row.from..=row.to {
                let h = problem.limits[j][k];
                let slot = &mut self.guess.rows[j][k];
                let z = dot(&row.gradient, &point.states[k]) - h;
                if h == f64::INFINITY || (z <= 0.0 && !slot.acts()) {
                    point.multipliers.rows[j][k] = 0.0;
                    continue;
                }
                let (next, mu, distance) = slot.project(row, z, h.abs().max(1.0), stiffness);
                *slot = next;
                self.row_tangents_act |= next.acts();
                if mu > 0.0 {
                    change.last_acting = k.max(change.last_acting);
                }
                point.multipliers.rows[j][k] = mu;
                change.is_complete &= distance <= ON_CURVE;
                change.distance = change.distance.max(distance);
                change.parts += usize::from(distance >= 1.0);
                change.last_stage = change.last_stage.max(k);
            }
        }
        change
    }

    /// Adopts the sides of the last trajectory; row tangents act up to stage `acting`. Returns the
    /// last stage at which the sides differ.
    fn renew_sides(&mut self, problem: &Problem, is_at_rest: bool, acting: usize) -> usize {
        let n = problem.horizon;
        let (sides, next) = (&mut self.guess.sides[..n], &mut self.next_sides[..n]);
        let from = self.rows.last_acting_stage().max(acting);
        let bounds = (problem.u_min, problem.u_max);
        // A switch that was opened and closed again while all else is at rest is right as it is.
        let settled = self.freed_switch.filter(|_| is_at_rest);
        self.freed_switch =
            switching::free_switches(next, sides, &self.unclamped, from, settled, bounds);
        let last = last_difference(sides, next).unwrap_or(0);
        self.sides_before[..n].copy_from_slice(sides);
        sides.copy_from_slice(next);
        last
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
    /// Last stage at which a row tangent acts.
    last_acting: usize,
    /// Largest distance of a row from its curve.
    distance: f64,
}

impl RowChange {
    /// Returns a change without new tangents.
    fn by_working_set(is_complete: bool) -> Self {
        Self { is_complete, parts: 0, last_stage: 0, last_acting: 0, distance: 0.0 }
    }
}
