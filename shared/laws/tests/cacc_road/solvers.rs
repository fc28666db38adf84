//! Solvers that do not solve: what the law does without them must be as safe.

use mpc_solver::{Multipliers, Problem, Report, Residuals, Solver, Start, Status};

/// Answer of a [`Fake`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Temper {
    /// Never finds anything.
    Fails,
    /// Calls any inputs within the bounds a solution.
    FalselySolved,
}

/// A solver that does not solve.
pub(crate) struct Fake {
    temper: Temper,
    state: u64,
    inputs: Vec<f64>,
    states: Vec<[f64; 3]>,
    multipliers: Multipliers,
}

impl Fake {
    pub(crate) fn new(temper: Temper, seed: u64) -> Self {
        Self {
            temper,
            state: seed | 1,
            inputs: Vec::new(),
            states: Vec::new(),
            multipliers: Multipliers::new(128),
        }
    }

    fn unit(&mut self) -> f64 {
        self.state ^= self.state << 13;
        self.state ^= self.state >> 7;
        self.state ^= self.state << 17;
        random::unit(self.state)
    }
}

impl Solver for Fake {
    fn solve(&mut self, problem: &Problem, _start: Start) -> Report {
        let n = problem.horizon();
        let (low, high) = problem.input_bounds();
        self.inputs.clear();
        let level = low + (high - low) * self.unit();
        for _ in 0..n {
            let u = level + 0.5 * (self.unit() - 0.5);
            self.inputs.push(u.clamp(low, high));
        }
        self.states.resize(n + 1, [0.0; 3]);
        problem.roll_out(&self.inputs, &mut self.states);
        let (status, residual) = match self.temper {
            Temper::Fails => (Status::IterationLimit, f64::INFINITY),
            Temper::FalselySolved => (Status::Solved, 0.0),
        };
        let residuals = Residuals { stationarity: residual, ..Residuals::default() };
        Report { status, iterations: 1, interior_iterations: 0, residuals }
    }

    fn inputs(&self) -> &[f64] {
        &self.inputs
    }

    fn states(&self) -> &[[f64; 3]] {
        &self.states
    }

    fn multipliers(&self) -> &Multipliers {
        &self.multipliers
    }
}

/// A real solver that stops working.
pub(crate) struct Flaky {
    inner: Box<dyn Solver + Send>,
    left: usize,
}

impl Flaky {
    /// Works for the first `solves` solves.
    pub(crate) fn new(inner: Box<dyn Solver + Send>, solves: usize) -> Self {
        Self { inner, left: solves }
    }
}

impl Solver for Flaky {
    fn solve(&mut self, problem: &Problem, start: Start) -> Report {
        let mut report = self.inner.solve(problem, start);
        if self.left == 0 {
            report.status = Status::Infeasible;
        }
        self.left = self.left.saturating_sub(1);
        report
    }

    fn inputs(&self) -> &[f64] {
        self.inner.inputs()
    }

    fn states(&self) -> &[[f64; 3]] {
        self.inner.states()
    }

    fn multipliers(&self) -> &Multipliers {
        self.inner.multipliers()
    }
}
