//! Instances of the paper: `tests/data/cacc-instances.csv` as problems.

#![allow(dead_code, reason = "each test file uses its part")]

use mpc_solver::{LightCost, LightStage, Problem, Row, Softness, Solver};

const CSV: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/cacc-instances.csv"));

/// Control period \[s\].
pub(crate) const T: f64 = 0.1;

/// Number of steps of the drives' problems.
pub(crate) const HORIZON: usize = 100;
/// Weights of the states and of the input, and the buffer, of [`cacc`].
pub(crate) const STATE_WEIGHTS: [f64; 3] = [19.243, 135.712, 0.00159];
pub(crate) const INPUT_WEIGHT: f64 = 1.0;
pub(crate) const BUFFER_M: f64 = 12.0;

/// Row of the table.
pub(crate) struct Instance {
    pub(crate) id: usize,
    pub(crate) step: usize,
    pub(crate) x0: [f64; 3],
    pub(crate) sign: f64,
    pub(crate) t0: f64,
    pub(crate) h: f64,
    pub(crate) stages: usize,
    pub(crate) objective: f64,
    pub(crate) feasible: bool,
}

impl Instance {
    /// Returns the light's margins, stage by stage.
    pub(crate) fn light(&self) -> impl Iterator<Item = LightStage> + use<> {
        let (sign, t0, h) = (self.sign, self.t0, self.h);
        (1..=self.stages).map(move |k| {
            let t = t0 - k as f64 * T;
            LightStage { gradient: [sign, sign * t, sign * 0.5 * t * t], offset: sign * h }
        })
    }

    /// Writes this instance into a problem of [`cacc`].
    pub(crate) fn apply(&self, problem: &mut Problem) {
        problem.set_initial_state(self.x0);
        problem.set_light(self.light());
    }
}

/// Returns all rows.
pub(crate) fn instances() -> Vec<Instance> {
    CSV.lines().skip(1).map(parse).collect()
}

fn parse(line: &str) -> Instance {
    let field: Vec<&str> = line.split(',').collect();
    let number = |i: usize| field[i].parse::<f64>().expect("the table holds numbers");
    let lit = field[7] == "1";
    Instance {
        id: number(0) as usize,
        step: number(3) as usize,
        x0: [number(4), number(5), number(6)],
        sign: number(8),
        t0: number(9),
        h: number(10),
        stages: if lit { number(11) as usize } else { 0 },
        objective: number(13),
        feasible: field[14] == "1",
    }
}

/// Returns the objective of a solver's last solution.
pub(crate) fn cost(problem: &Problem, solver: &dyn Solver) -> f64 {
    problem.objective(solver.inputs(), solver.states())
}

/// Returns the paper's problem with the joint weights, over `n` steps.
pub(crate) fn cacc(n: usize) -> Problem {
    let tau = 0.5;
    Problem::builder(n)
        .dynamics([[1.0, T, 0.0], [0.0, 1.0, T], [0.0, 0.0, 1.0 - T / tau]], [0.0, 0.0, T / tau])
        .state_weights(STATE_WEIGHTS)
        .input_cost(INPUT_WEIGHT)
        .input_bounds(-4.9, 4.9)
        .terminal_equality([0.0; 3])
        .row(Row {
            gradient: [1.0, 0.0, 0.0],
            from: 1,
            to: n - 1,
            limit: BUFFER_M,
            softness: Softness::Hard,
        })
        .light(LightCost { weight: 275_773.0, threshold: 108.5, softness: Softness::Hard })
        .build()
        .expect("the paper's problem is well posed")
}
