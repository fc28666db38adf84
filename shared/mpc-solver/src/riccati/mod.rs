//! Solver made for the problem: an active-set method for the common case, and an interior point for the rest. Both use
//! one stage-wise recursion.
//!
//! Each phase of a solve either ends it or hands over to the next:
//!
//! 1. *Short* ([`Riccati::short`]), for short horizons alone: a dual active set, warm or cold ([`short`]). If the second
//!    phase fails, it tries once more.
//! 2. *Cold* ([`Riccati::cold`]): the active set without a guess ([`active_set`]).
//! 3. *Interior point* ([`Riccati::interior`]), started near an early trajectory of the cold attempt
//!    ([`interior_point`]). Once its steps are nearly full, they show which inequalities are active. The active set
//!    then finishes exactly in one to three rounds. While the iterate is infeasible, [`infeasibility`] checks whether
//!    its multipliers prove that the problem is.
//!
//! [`crate::residuals`] checks every returned point and is independent of the methods. The status is [`Status::Solved`]
//! only if the optimality conditions hold to 1e-8.
//!
//! Every loop is bounded, and so is the time. At most there are 15 cold rounds, and three starts of the interior point.
//! Each start has 60 iterations and four attempts of five rounds to finish. Together these are 255 sweeps over the
//! horizon, linear in `N`. A short horizon has two attempts beside them, of at most 49 rounds each. The
//! tests on 400,000 random feasible problems print the largest number used, and so does the fuzzer on hostile ones.
//!
//! The equations are at the head of [`lqr`]. [`curve`] describes the active set's view of the penalties,
//! [`interior_point`] the inequalities as pairs.

mod active_set;
mod complementarity;
mod curve;
mod infeasibility;
mod interior_point;
mod lanes;
mod lqr;
mod matrix;
mod short;
mod working_set;

use crate::kkt::{Multipliers, Residuals, residuals};
use crate::problem::Problem;
use crate::solver::{Report, Solver, Start, Status};
use active_set::{ActiveSet, From, Point};
use interior_point::InteriorPoint;
use lqr::LinearQuadratic;
use short::{Short, ShortStart};

/// Largest scaled residual of the optimality conditions that counts as solved.
const TOLERANCE: f64 = 1e-8;
/// Largest number of iterations from one start of the interior point.
const MAX_ITERATIONS: u32 = 60;
/// Mean product of the pairs below which the optimality conditions are evaluated.
const MU_TOLERANCE: f64 = 1e-6;
/// Fraction of the first iterate's linear residuals that counts as zero.
const RESIDUAL_TOLERANCE: f64 = 1e-9;
/// Evaluations of the optimality conditions without progress after which the machine's precision is reached. The ratio
/// is what counts as progress. If limits hold without a force, an iteration gains less than a digit.
const MAX_EVALUATIONS: u32 = 8;
const PROGRESS: f64 = 0.7;
/// Conditions under which the active set tries to finish: remaining fractions of the linear residuals and of the mean
/// product, and number of attempts.
const FINISH_RESIDUAL: f64 = 1e-3;
const FINISH_PRODUCT: f64 = 1e-2;
const MAX_FINISHES: u32 = 3;
/// Length of a step below which the problem may be infeasible: infeasible problems have short
/// steps.
const HINDERED: f64 = 0.5;
/// Number of iterations between two tests for infeasibility.
const INFEASIBILITY_INTERVAL: u32 = 4;
/// Fraction of the linear residuals that a start must remove within its trial.
const LEAST_PROGRESS: f64 = 0.1;

struct InteriorStart {
    /// Factor on the distance from the boundary.
    distance: f64,
    /// Iterations after which it must have made progress; `None` for the last start.
    trial: Option<u32>,
}

/// Starts, each farther inside than the previous one: a start that is stuck at the boundary is
/// left.
const STARTS: [InteriorStart; 3] = [
    InteriorStart { distance: 1.0, trial: Some(8) },
    InteriorStart { distance: 30.0, trial: Some(8) },
    InteriorStart { distance: 1000.0, trial: None },
];

/// Result of a phase.
type Ending = (Status, Residuals);

/// End of the iterations from one start of the interior point.
enum Descent {
    Ended(Ending),
    /// Another start may do better.
    Stuck,
}

/// Solver made for the problem at the head of the crate.
#[derive(Clone, Debug)]
pub struct Riccati {
    capacity: usize,
    short: Short,
    active: ActiveSet,
    interior: InteriorPoint,
    inputs: Vec<f64>,
    states: Vec<[f64; 3]>,
    multipliers: Multipliers,
    horizon: usize,
    /// Sweeps of the current solve, and those of them that the interior point made.
    iterations: u32,
    interior_iterations: u32,
    /// True after a solution by the method for short horizons, which can start the next solve.
    has_guess: bool,
}

impl Riccati {
    /// Returns a solver for horizons up to `max_horizon`; all its memory is allocated here.
    pub fn new(max_horizon: usize) -> Self {
        Self {
            capacity: max_horizon,
            short: Short::new(max_horizon),
            active: ActiveSet::new(max_horizon),
            interior: InteriorPoint::new(max_horizon),
            inputs: vec![0.0; max_horizon],
            states: vec![[0.0; 3]; max_horizon + 1],
            multipliers: Multipliers::new(max_horizon),
            horizon: 0,
            iterations: 0,
            interior_iterations: 0,
            has_guess: false,
        }
    }

    /// Short horizons; `None` for problems of other methods and after a failed attempt.
    fn short(&mut self, problem: &Problem, start: ShortStart) -> Option<Ending> {
        if !Short::serves(problem) {
            return None;
        }
        let Self { short, inputs, states, multipliers, .. } = self;
        let rounds = short.solve(problem, start, &mut Point { inputs, states, multipliers })?;
        self.iterations += rounds;
        let found = self.residuals(problem);
        self.has_guess = found.max() <= TOLERANCE;
        self.has_guess.then_some((Status::Solved, found))
    }

    /// Phase 2; `None` after a failed attempt.
    fn cold(&mut self, problem: &Problem, lq: &LinearQuadratic) -> Option<Ending> {
        self.multipliers.clear();
        self.try_active(problem, lq, From::Nothing)
    }

    /// Phase 3.
    fn interior(&mut self, problem: &Problem, lq: &LinearQuadratic) -> Ending {
        let n = problem.horizon;
        self.inputs[..n].copy_from_slice(&self.active.early_inputs[..n]);
        for start in &STARTS {
            problem.roll_out(&self.inputs, &mut self.states);
            let (inputs, states) = (&self.inputs[..n], &self.states[..=n]);
            self.interior.start(problem, inputs, states, start.distance);
            if let Descent::Ended(ending) = self.descend(problem, lq, start.trial) {
                return ending;
            }
            self.inputs.fill(0.5 * (problem.u_min + problem.u_max));
        }
        (Status::IterationLimit, self.take_iterate(problem))
    }

    /// Iterations of the interior point from one start.
    fn descend(&mut self, problem: &Problem, lq: &LinearQuadratic, trial: Option<u32>) -> Descent {
        let (mut finishes, mut first_mu) = (0, 0.0);
        let (mut evaluations, mut least) = (0, f64::INFINITY);
        self.multipliers.clear();
        for iteration in 1..=MAX_ITERATIONS {
            self.iterations += 1;
            self.interior_iterations += 1;
            let Some(step) = self.interior.iterate(problem, lq) else { break };
            let residual = self.interior.residual;
            if iteration == 1 {
                first_mu = step.mu;
            }
            let is_near = residual < FINISH_RESIDUAL && step.mu < FINISH_PRODUCT * first_mu;
            if finishes < MAX_FINISHES && step.is_fast() && is_near {
                finishes += 1;
                self.interior.suggest(problem, &mut self.active.guess);
                if let Some(ending) = self.try_active(problem, lq, From::Iterate) {
                    return Descent::Ended(ending);
                }
            }
            if step.mu < MU_TOLERANCE && residual < RESIDUAL_TOLERANCE {
                let found = self.take_iterate(problem);
                if found.max() <= TOLERANCE {
                    return Descent::Ended((Status::Solved, found));
                }
                evaluations = if found.max() < PROGRESS * least { 0 } else { evaluations + 1 };
                least = least.min(found.max());
                if evaluations == MAX_EVALUATIONS {
                    // The active inequalities are long known; only digits are missing.
                    self.interior.suggest(problem, &mut self.active.guess);
                    let polished = self.try_active(problem, lq, From::Iterate);
                    let ending = polished
                        .unwrap_or_else(|| (Status::IterationLimit, self.take_iterate(problem)));
                    return Descent::Ended(ending);
                }
            }
            let is_stuck = trial == Some(iteration) && residual > 1.0 - LEAST_PROGRESS;
            let is_hindered = residual > RESIDUAL_TOLERANCE && step.length < HINDERED;
            if is_stuck || is_hindered && iteration % INFEASIBILITY_INTERVAL == 0 {
                self.interior.read_multipliers(&mut self.multipliers);
                if infeasibility::is_proved(problem, &self.multipliers) {
                    let found = self.take_iterate(problem);
                    return Descent::Ended((Status::Infeasible, found));
                }
            }
            if is_stuck {
                break;
            }
        }
        Descent::Stuck
    }

    /// Tries the active set; `None` if the attempt is given up or misses the tolerance.
    fn try_active(
        &mut self,
        problem: &Problem,
        lq: &LinearQuadratic,
        from: From,
    ) -> Option<Ending> {
        let Self { active, inputs, states, multipliers, .. } = self;
        let (is_settled, rounds) =
            active.solve(problem, lq, from, &mut Point { inputs, states, multipliers });
        self.iterations += rounds;
        if !is_settled {
            return None;
        }
        // The states of the attempt come from the closed loop. Except for rounding, they are those
        // that follow from the inputs; hostile numbers magnify rounding.
        problem.roll_out(&self.inputs, &mut self.states);
        let found = self.residuals(problem);
        (found.max() <= TOLERANCE).then_some((Status::Solved, found))
    }

    /// Adopts the interior point's iterate as the solution.
    fn take_iterate(&mut self, problem: &Problem) -> Residuals {
        self.interior.read_inputs(problem, &mut self.inputs);
        self.interior.read_multipliers(&mut self.multipliers);
        problem.roll_out(&self.inputs, &mut self.states);
        self.residuals(problem)
    }

    fn residuals(&self, problem: &Problem) -> Residuals {
        residuals(problem, &self.inputs, &self.states, &self.multipliers)
    }

    fn report(&self, status: Status, residuals: Residuals) -> Report {
        let Self { iterations, interior_iterations, .. } = *self;
        Report { status, iterations, interior_iterations, residuals }
    }

    /// Returns the report of a problem that cannot be solved because of its numbers.
    fn refuse(&mut self, problem: &Problem) -> Report {
        self.horizon = problem.horizon.min(self.capacity);
        self.has_guess = false;
        self.inputs.fill(0.0_f64.max(problem.u_min).min(problem.u_max));
        self.states.fill(problem.x0);
        self.multipliers.clear();
        let residuals = Residuals { stationarity: f64::NAN, ..Residuals::default() };
        self.report(Status::InvalidInput, residuals)
    }
}

impl Solver for Riccati {
    fn solve(&mut self, problem: &Problem, start: Start) -> Report {
        let n = problem.horizon;
        (self.iterations, self.interior_iterations) = (0, 0);
        if n > self.capacity || problem.check().is_err() {
            return self.refuse(problem);
        }
        let first = match start {
            Start::Shifted(steps) if self.has_guess && self.horizon == n => {
                ShortStart::Shifted(steps)
            }
            _ => ShortStart::Cold,
        };
        self.horizon = n;
        self.has_guess = false;
        let (status, residuals) = self.short(problem, first).unwrap_or_else(|| {
            let lq = LinearQuadratic::new(problem);
            self.cold(problem, &lq)
                .or_else(|| self.short(problem, ShortStart::Last))
                .unwrap_or_else(|| self.interior(problem, &lq))
        });
        let end = &self.states[n];
        if !(end[0] + end[1] + end[2]).is_finite() {
            return self.refuse(problem);
        }
        self.report(status, residuals)
    }

    fn inputs(&self) -> &[f64] {
        &self.inputs[..self.horizon]
    }

    fn states(&self) -> &[[f64; 3]] {
        &self.states[..=self.horizon]
    }

    fn multipliers(&self) -> &Multipliers {
        &self.multipliers
    }
}
