//! The fast method: which inputs are at their bounds, and where on its graph is the light?
//!
//! One round is a backward sweep with the inputs of the current guess held and the light's curve replaced
//! by its tangents, and a forward sweep in which every input is the minimiser of its stage's cost-to-go,
//! clamped to its bounds. That sweep renews the guess:
//!
//! ```text
//! u_k = clamp(−(F x_k + f + β y)/δ, u_min, u_max),     held next time iff clamped
//! ```
//!
//! When no input changes sides and all margins lie on their tangents' points of contact, the
//! trajectory satisfies the optimality conditions: `−(F x + f + βy)/δ − u` is the bound's multiplier over
//! `−δ`. The guess then is right after one round or two for most cruise problems, and after about seven with a
//! light. It is a semismooth Newton method without a safeguard: it may cycle. Rows that become active one after the
//! other on a third-order chain make it cycle for sure, so that from nothing it only asks whether rows hold;
//! it treats them like the light when the guess comes from the interior point or a previous solution.

use super::light_graph::{LightGraph, Tangent};
use super::recursion::{InputModel, Models, Plant, Sweep};
use super::row_graph::RowTangent;
use crate::kkt::Multipliers;
use crate::problem::{LightStage, MAX_ROWS, Problem, dot};

/// Rounds before the method is given up.
const MAX_ROUNDS: u32 = 12;
/// Rounds after which a violated row is no longer hoped to come right.
const PATIENCE: u32 = 2;
/// Relative distance from the light's curve that counts as none.
const ON_CURVE: f64 = 2e-10;

/// Where the method ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// Optimal up to the check of the optimality conditions.
    Settled,
    /// Some row is violated, or the rounds ran out.
    GivenUp,
}

/// Work memory and the guess that survives from solve to solve.
#[derive(Clone, Debug)]
pub(super) struct ActiveSet {
    sweep: Sweep,
    /// The input's bound it is held at: −1, 0 (free) or 1.
    sides: Vec<i8>,
    /// `tangents[k]` belongs to stage `k + 1`.
    tangents: Vec<Tangent>,
    /// `rows[j][k]` belongs to stage `k`; only if `with_rows`.
    rows: [Vec<RowTangent>; MAX_ROWS],
    with_rows: bool,
    /// Whether any of them acted in the last round.
    rows_act: bool,
}

/// Where a solve of the active set starts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum From {
    /// From nothing; rows only have to hold.
    Nothing,
    /// From the guess at hand, for so many rounds at most.
    Guess(u32),
}

struct Guess<'a> {
    problem: &'a Problem,
    sides: &'a [i8],
    tangents: &'a [Tangent],
    stages: &'a [LightStage],
    rows: &'a [Vec<RowTangent>],
}

impl Models for Guess<'_> {
    const DRIVEN: bool = true;

    #[inline(always)]
    fn input(&self, k: usize) -> InputModel {
        let gradient = self.problem.r_lin[k];
        match self.sides[k] {
            0 => InputModel::Free(0.0, gradient),
            1 => InputModel::Held(self.problem.u_max, gradient),
            _ => InputModel::Held(self.problem.u_min, gradient),
        }
    }

    #[inline(always)]
    fn gradient(&self, k: usize) -> [f64; 3] {
        if k < self.problem.horizon { self.problem.q_lin[k] } else { self.problem.p_lin }
    }

    #[inline(always)]
    fn functions(&self, k: usize, mut add: impl FnMut(&[f64; 3], f64, f64)) {
        if k <= self.stages.len() {
            let (stage, tangent) = (&self.stages[k - 1], &self.tangents[k - 1]);
            add(&stage.gradient, tangent.slope, -tangent.force(stage.offset));
        }
        for (j, tangents) in self.rows.iter().enumerate() {
            let tangent = &tangents[k];
            if tangent.acts() {
                let force = tangent.at(-self.problem.limits[j][k]);
                add(&self.problem.rows[j].gradient, tangent.slope, force);
            }
        }
    }
}

impl ActiveSet {
    pub(super) fn new(max_horizon: usize) -> Self {
        Self {
            sweep: Sweep::new(max_horizon),
            sides: vec![0; max_horizon],
            tangents: vec![Tangent::default(); max_horizon],
            rows: std::array::from_fn(|_| vec![RowTangent::default(); max_horizon + 1]),
            with_rows: false,
            rows_act: false,
        }
    }

    /// Moves the guess forward by `steps`.
    pub(super) fn shift(&mut self, problem: &Problem, steps: usize) {
        let n = problem.horizon;
        let steps = steps.min(n);
        self.sides.copy_within(steps..n, 0);
        self.sides[n - steps..n].fill(0);
        self.tangents.copy_within(steps..n, 0);
        if self.with_rows {
            for (tangents, row) in self.rows.iter_mut().zip(&problem.rows) {
                tangents.copy_within(steps..=n, 0);
                tangents[n + 1 - steps..=n].fill(RowTangent::default());
                // The row may have moved since.
                for (k, slot) in tangents[..=n].iter_mut().enumerate() {
                    if k < row.from || k > row.to {
                        *slot = RowTangent::default();
                    }
                }
            }
        }
    }

    /// Whether any row acts in the guess.
    pub(super) fn has_rows(&self) -> bool {
        self.with_rows && self.rows_act
    }

    /// Takes another guess: the input's side at stage `k`, the light's tangent at stage `k + 1`, the row's
    /// at `k`.
    pub(super) fn adopt(
        &mut self,
        problem: &Problem,
        side: impl Fn(usize) -> i8,
        light: impl Fn(&LightGraph, usize) -> Tangent,
        row: impl Fn(usize, usize) -> RowTangent,
    ) {
        for (k, slot) in self.sides[..problem.horizon].iter_mut().enumerate() {
            *slot = side(k);
        }
        if let Some(cost) = &problem.light {
            let graph = LightGraph::new(cost);
            for (k, slot) in self.tangents[..problem.light_len].iter_mut().enumerate() {
                *slot = light(&graph, k);
            }
        }
        self.with_rows = !problem.rows.is_empty();
        for (j, limits) in problem.rows.iter().enumerate() {
            for (k, slot) in self.rows[j][..=problem.horizon].iter_mut().enumerate() {
                let in_force = k >= limits.from && k <= limits.to;
                *slot = if in_force { row(j, k) } else { RowTangent::default() };
            }
        }
    }

    /// Solves. Inputs, states and multipliers are those of the last round.
    pub(super) fn solve(
        &mut self,
        problem: &Problem,
        plant: &Plant,
        from: From,
        inputs: &mut [f64],
        states: &mut [[f64; 3]],
        multipliers: &mut Multipliers,
    ) -> (Outcome, u32) {
        let graph = problem.light.as_ref().map(LightGraph::new).unwrap_or_default();
        let lit = problem.light_len > 0;
        let (warm, rounds) = match from {
            From::Nothing => (false, MAX_ROUNDS),
            From::Guess(rounds) => (true, rounds),
        };
        if !warm {
            self.sides.fill(0);
            self.with_rows = false;
        }
        let count = if self.with_rows { problem.rows.len() } else { 0 };
        // Cold, the first round goes without the light and only shows where the margins would be.
        let mut without_light = lit && !warm;
        let mut last = problem.horizon;
        for round in 1..=rounds {
            let pin = {
                let guess = Guess {
                    problem,
                    sides: &self.sides,
                    tangents: &self.tangents,
                    stages: if without_light { &[] } else { problem.light_stages() },
                    rows: &self.rows[..count],
                };
                plant.factor(problem, &guess, &mut self.sweep, last)
            };
            let y = pin.multiplier(problem);
            let changed = if plant.last_only {
                self.forward::<true>(problem, plant, &y, inputs, states)
            } else {
                self.forward::<false>(problem, plant, &y, inputs, states)
            };
            multipliers.terminal = y;
            let sum = states[problem.horizon].iter().sum::<f64>() + y.iter().sum::<f64>();
            if !sum.is_finite() {
                return (Outcome::GivenUp, round);
            }
            let mut off_curve: f64 = 0.0;
            if without_light {
                self.place(problem, &graph, states);
                without_light = false;
                off_curve = 1.0;
            } else if lit {
                off_curve = self.project(problem, &graph, states, &mut multipliers.light);
            }
            let mut last_row = 0;
            if self.with_rows {
                let (distance, stage) = self.project_rows(problem, states, &mut multipliers.rows);
                off_curve = off_curve.max(distance);
                last_row = stage;
            }
            let settled = changed.is_none() && off_curve <= ON_CURVE;
            if !self.with_rows && (settled || round >= PATIENCE) && !rows_hold(problem, states) {
                return (Outcome::GivenUp, round);
            }
            if settled {
                return (Outcome::Settled, round);
            }
            last = changed.unwrap_or(0).max(problem.light_len).max(last_row);
        }
        (Outcome::GivenUp, rounds)
    }

    /// The forward sweep; returns the last input that changed sides.
    fn forward<const LAST: bool>(
        &mut self,
        problem: &Problem,
        plant: &Plant,
        y: &[f64; 3],
        inputs: &mut [f64],
        states: &mut [[f64; 3]],
    ) -> Option<usize> {
        let n = problem.horizon;
        let (gains, sides) = (&self.sweep.gains[..n], &mut self.sides[..n]);
        let (d, inputs, states) = (&problem.d[..n], &mut inputs[..n], &mut states[..=n]);
        let mut x = problem.x0;
        let (least, most) = (-problem.u_max, -problem.u_min);
        let mut changed = None;
        states[0] = x;
        for k in 0..n {
            // In terms of −u.
            let free = gains[k].input(gains[k].offset(y), &x);
            let side = i8::from(free < least) - i8::from(free > most);
            // In this order of operands they are one instruction each.
            let pull = if least > free { least } else { free };
            let pull = if most < pull { most } else { pull };
            if side != sides[k] {
                sides[k] = side;
                changed = Some(k);
            }
            inputs[k] = -pull;
            let next = plant.step::<LAST>(&x, -pull);
            x = [next[0] + d[k][0], next[1] + d[k][1], next[2] + d[k][2]];
            states[k + 1] = x;
        }
        changed
    }

    /// First tangents, from the margins without a light.
    fn place(&mut self, problem: &Problem, graph: &LightGraph, states: &[[f64; 3]]) {
        let margin = |stage: &LightStage, x: &[f64; 3]| dot(&stage.gradient, x) + stage.offset;
        let pairs = || problem.light_stages().iter().zip(&states[1..]);
        let best = pairs().fold(f64::NEG_INFINITY, |best, (c, x)| margin(c, x).max(best));
        for (tangent, (stage, x)) in self.tangents.iter_mut().zip(pairs()) {
            *tangent = graph.start(margin(stage, x), best);
        }
    }

    /// New tangents where the last step has led; returns the largest distance from the curve.
    fn project(
        &mut self,
        problem: &Problem,
        graph: &LightGraph,
        states: &[[f64; 3]],
        multipliers: &mut [f64],
    ) -> f64 {
        let mut worst: f64 = 0.0;
        for (k, stage) in problem.light_stages().iter().enumerate() {
            let margin = dot(&stage.gradient, &states[k + 1]) + stage.offset;
            let (next, alpha, distance) = graph.project(&self.tangents[k], margin);
            self.tangents[k] = next;
            multipliers[k + 1] = alpha;
            worst = worst.max(distance);
        }
        worst
    }

    /// The same for the rows; returns the largest distance, and the last stage with a changed tangent.
    fn project_rows(
        &mut self,
        problem: &Problem,
        states: &[[f64; 3]],
        multipliers: &mut [Vec<f64>; MAX_ROWS],
    ) -> (f64, usize) {
        let (mut worst, mut last): (f64, usize) = (0.0, 0);
        self.rows_act = false;
        for (j, row) in problem.rows.iter().enumerate() {
            for k in row.from..=row.to {
                let h = problem.limits[j][k];
                let slot = &mut self.rows[j][k];
                let z = dot(&row.gradient, &states[k]) - h;
                if h == f64::INFINITY || (z <= 0.0 && !slot.acts()) {
                    multipliers[j][k] = 0.0;
                    continue;
                }
                let (next, mu, distance) = slot.project(row, z, h.abs().max(1.0));
                *slot = next;
                self.rows_act |= next.acts();
                multipliers[j][k] = mu;
                worst = worst.max(distance);
                last = last.max(k);
            }
        }
        (worst, last)
    }
}

/// Whether all rows hold, to rounding.
fn rows_hold(problem: &Problem, states: &[[f64; 3]]) -> bool {
    problem.rows.iter().zip(&problem.limits).all(|(row, limits)| {
        (row.from..=row.to).all(|k| {
            let h = limits[k];
            dot(&row.gradient, &states[k]) <= h + 1e-10 * h.abs().max(1.0)
        })
    })
}
