//! The solver made for the problem: an active-set method for the common case, an interior point for
//! the rest, both on one stage-wise recursion.
//!
//! 1. `active` guesses which inputs are at their bounds and where on its graph the light is, solves what
//!    remains, and improves the guess: one or two sweeps for most cruise problems, about seven with a light.
//! 2. `interior` takes over when rows are active or the guesses do not settle. Once its steps are nearly
//!    full it shows which inequalities are active; `active` then finishes in two or three sweeps, exactly.
//! 3. What either returns is checked by [`crate::residuals`], which knows nothing of the methods: the status is
//!    [`Status::Solved`] only if the optimality conditions hold to 1e-8.
//! 4. While the interior point is not feasible, `certificate` asks whether its multipliers prove that
//!    nothing is.
//!
//! The equations are at the head of `recursion`; `light_graph` and `row_graph` have the
//! active set's view of the penalties, `barrier` the inequalities of the
//! interior point.

mod active;
mod barrier;
mod certificate;
mod interior;
mod light_graph;
mod recursion;
mod row_graph;

use crate::kkt::{Multipliers, Residuals, residuals};
use crate::problem::Problem;
use crate::solver::{Report, Solver, Start, Status};
use active::{ActiveSet, From, Outcome};
use interior::Interior;
use recursion::Plant;

/// Largest scaled residual of the optimality conditions that counts as solved.
const TOLERANCE: f64 = 1e-8;
/// Iterations of the interior point.
const MAX_ITERATIONS: u32 = 60;
/// Mean product of the pairs from which on the optimality conditions are looked at.
const NEARLY: f64 = 1e-6;
/// Part of the first iterate's infeasibility that counts as feasible.
const CLOSED: f64 = 1e-9;
/// Iterations after which a start must have closed some of its infeasibility, and how much may be left.
const TRIAL: u32 = 8;
const OPENED: f64 = 0.9;
/// How far inside the starts begin.
const BOLDNESS: [f64; 3] = [1.0, 30.0, 1000.0];
/// Rounds of the active set from the previous solution: more would cost more than a cold start.
const WARM_ROUNDS: u32 = 6;
const WARM_ROUNDS_WITH_ROWS: u32 = 2;
/// How often, and for how many rounds, the active set may try the interior point's suggestion, and what
/// part of the first infeasibility may be left then.
const MAX_TRIES: u32 = 2;
const TRY_ROUNDS: u32 = 5;
const NEARLY_CLOSED: f64 = 1e-3;
/// Fruitless looks at the optimality conditions after which the machine's precision is at its end.
const MAX_LOOKS: u32 = 8;

/// The solver; see the head of the crate for its problem.
#[derive(Clone, Debug)]
pub struct Riccati {
    capacity: usize,
    active: ActiveSet,
    interior: Interior,
    inputs: Vec<f64>,
    states: Vec<[f64; 3]>,
    multipliers: Multipliers,
    horizon: usize,
    /// Whether the active set of the last solve can start the next one.
    settled: bool,
}

impl Riccati {
    /// A solver for horizons up to `max_horizon`; all its memory is allocated here.
    pub fn new(max_horizon: usize) -> Self {
        Self {
            capacity: max_horizon,
            active: ActiveSet::new(max_horizon),
            interior: Interior::new(max_horizon),
            inputs: vec![0.0; max_horizon],
            states: vec![[0.0; 3]; max_horizon + 1],
            multipliers: Multipliers::new(max_horizon),
            horizon: 0,
            settled: false,
        }
    }

    /// The active set's attempt; `None` if it has to be given up.
    fn try_active(
        &mut self,
        problem: &Problem,
        plant: &Plant,
        from: From,
    ) -> (Option<Residuals>, u32) {
        let (outcome, rounds) = self.active.solve(
            problem,
            plant,
            from,
            &mut self.inputs,
            &mut self.states,
            &mut self.multipliers,
        );
        let found = (outcome == Outcome::Settled).then(|| self.residuals(problem));
        (found.filter(|r| r.max() <= TOLERANCE), rounds)
    }

    /// The interior point, from the trajectory at hand; again from farther inside if its steps are
    /// stuck at the boundary.
    fn run_interior(&mut self, problem: &Problem, plant: &Plant) -> (Status, Residuals, u32) {
        let mut iterations = 0;
        for boldness in BOLDNESS {
            let last = boldness == BOLDNESS[BOLDNESS.len() - 1];
            let n = problem.horizon;
            self.interior.start(problem, &self.inputs[..n], &self.states[..=n], boldness);
            let (status, residuals, steps) = self.descend(problem, plant, last);
            iterations += steps;
            if status != Status::IterationLimit || last {
                return (status, residuals, iterations);
            }
            self.inputs.fill(0.5 * (problem.u_min + problem.u_max));
            problem.roll_out(&self.inputs, &mut self.states);
        }
        unreachable!("the last start returns")
    }

    fn descend(
        &mut self,
        problem: &Problem,
        plant: &Plant,
        last: bool,
    ) -> (Status, Residuals, u32) {
        let mut looks = 0;
        let (mut tries, mut extra) = (0, 0);
        self.multipliers.clear();
        for iteration in 1..=MAX_ITERATIONS {
            let Some(step) = self.interior.iterate(problem, plant) else {
                return (Status::IterationLimit, self.take_interior(problem), iteration + extra);
            };
            let (mu, open) = (step.mu, self.interior.open());
            if tries < MAX_TRIES && step.is_fast() && open < NEARLY_CLOSED {
                tries += 1;
                self.interior.suggest(problem, &mut self.active);
                let (found, rounds) = self.try_active(problem, plant, From::Guess(TRY_ROUNDS));
                extra += rounds;
                if let Some(residuals) = found {
                    self.settled = true;
                    return (Status::Solved, residuals, iteration + extra);
                }
            }
            if mu < NEARLY && open < CLOSED {
                let found = self.take_interior(problem);
                looks += 1;
                if found.max() <= TOLERANCE {
                    return (Status::Solved, found, iteration + extra);
                }
                if looks == MAX_LOOKS {
                    return (Status::IterationLimit, found, iteration + extra);
                }
            }
            let stuck = !last && iteration == TRIAL && open > OPENED;
            if open > CLOSED && iteration % 4 == 0 || stuck {
                let found = self.take_interior(problem);
                if certificate::proves_infeasible(problem, &self.multipliers) {
                    return (Status::Infeasible, found, iteration + extra);
                }
                if stuck {
                    return (Status::IterationLimit, found, iteration + extra);
                }
            }
        }
        (Status::IterationLimit, self.take_interior(problem), MAX_ITERATIONS + extra)
    }

    fn take_interior(&mut self, problem: &Problem) -> Residuals {
        self.interior.read(problem, &mut self.inputs, &mut self.multipliers);
        problem.roll_out(&self.inputs, &mut self.states);
        self.residuals(problem)
    }

    fn residuals(&self, problem: &Problem) -> Residuals {
        residuals(problem, &self.inputs, &self.states, &self.multipliers)
    }

    /// The answer to a problem that cannot be computed with.
    fn refuse(&mut self, problem: &Problem) -> Report {
        self.horizon = problem.horizon.min(self.capacity);
        self.settled = false;
        self.inputs.fill(0.0_f64.max(problem.u_min).min(problem.u_max));
        self.states.fill(problem.x0);
        self.multipliers.clear();
        let residuals = Residuals { stationarity: f64::NAN, ..Residuals::default() };
        Report { status: Status::InvalidInput, iterations: 0, residuals, objective: f64::NAN }
    }
}

impl Solver for Riccati {
    fn solve(&mut self, problem: &Problem, start: Start) -> Report {
        let n = problem.horizon;
        if n > self.capacity || problem.check().is_err() {
            return self.refuse(problem);
        }
        let plant = Plant::new(problem);
        let mut found = None;
        let mut iterations = 0;
        let mut try_cold = true;
        if let (Start::Shifted(steps), true) = (start, self.settled && self.horizon == n) {
            self.active.shift(problem, steps);
            self.multipliers.clear();
            // Where rows were active, the cold attempt would fail as well.
            try_cold = !self.active.has_rows();
            let rounds = if try_cold { WARM_ROUNDS } else { WARM_ROUNDS_WITH_ROWS };
            (found, iterations) = self.try_active(problem, &plant, From::Guess(rounds));
        }
        self.horizon = n;
        if found.is_none() && try_cold {
            self.multipliers.clear();
            let (cold, rounds) = self.try_active(problem, &plant, From::Nothing);
            found = cold;
            iterations += rounds;
        }
        self.settled = found.is_some();
        let (status, residuals) = match found {
            Some(residuals) => (Status::Solved, residuals),
            None => {
                let (status, residuals, steps) = self.run_interior(problem, &plant);
                iterations += steps;
                (status, residuals)
            }
        };
        let objective = problem.objective(&self.inputs, &self.states);
        let finite = self.states[..=n].iter().flatten().sum::<f64>().is_finite();
        // A solution outside of the light's domain does not exist: an infinite cost is an overflow.
        if !finite || status == Status::Solved && !objective.is_finite() {
            return Report { iterations, ..self.refuse(problem) };
        }
        Report { status, iterations, residuals, objective }
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
