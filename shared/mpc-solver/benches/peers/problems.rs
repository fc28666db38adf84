//! Problem sets of public benchmarks that have this solver's form, and the drives of `acc-mpc`.
//!
//! The public ones are in H. J. Ferreau's collection for D. Kouzoupis, A. Zanelli, H. Peyrl and H. J. Ferreau,
//! "Towards proper assessment of QP algorithms for embedded model predictive control", ECC 2015, pp. 2609–2616.
//! Their numbers are those of the sources below:
//!
//! * *ball on plate*: S. Richter, "Computational complexity certification of gradient methods for real-time model
//!   predictive control", dissertation, ETH Zurich, 2012. Section 9.6.1, variants 1 to 4
//! * *FiOrdOs*: its example of an input- and state-constrained system, 2012; variants 1 to 3
//! * *FORCES*: its simple unstable example, 2012; variants 1 and 2, and 1 with other horizons
//!
//! Each has two states (the third one here is zero), an upper triangular matrix, and one input. The input and
//! the states have bounds. A set is the sequence of problems of the closed loop from the benchmark's initial
//! state.

use mpc_solver::{Problem, Riccati, Row, Softness, Solver, Start, Status};
use serde::Serialize;

/// A bound `g'x ≤ limit` at stages `from` to `to`.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Limit {
    gradient: [f64; 3],
    from: usize,
    to: usize,
    limit: f64,
}

/// Problems that differ in their initial states.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Set {
    pub(crate) name: String,
    pub(crate) horizon: usize,
    a: [[f64; 3]; 3],
    b: [f64; 3],
    q: [[f64; 3]; 3],
    r: f64,
    p: [[f64; 3]; 3],
    /// Set point: the state costs are of its difference.
    target: [f64; 3],
    bounds: [f64; 2],
    rows: Vec<Limit>,
    /// The last state must be zero.
    ends_at_zero: bool,
    pub(crate) starts: Vec<[f64; 3]>,
}

impl Set {
    /// The problem of the first start.
    pub(crate) fn problem(&self) -> Problem {
        let mut builder = Problem::builder(self.horizon)
            .dynamics(self.a, self.b)
            .state_cost(self.q)
            .terminal_cost(self.p)
            .input_cost(self.r)
            .input_bounds(self.bounds[0], self.bounds[1]);
        if self.ends_at_zero {
            builder = builder.terminal_equality([0.0; 3]);
        }
        for row in &self.rows {
            let Limit { gradient, from, to, limit } = *row;
            let softness = Softness::Hard;
            builder = builder.row(Row { gradient, from, to, limit, softness });
        }
        let mut problem = builder.build().expect("the benchmarks are convex");
        let gradient = |m: &[[f64; 3]; 3]| m.map(|row| -dot(&row, &self.target));
        problem.state_gradients_mut().fill(gradient(&self.q));
        problem.set_terminal_gradient(gradient(&self.p));
        problem
    }

    /// Fills in the starts of the closed loop of `steps` steps. It ends early at a problem without a solution.
    fn driven(mut self, start: [f64; 2], steps: usize) -> Self {
        let (mut problem, mut solver) = (self.problem(), Riccati::new(self.horizon));
        let mut x = [start[0], start[1], 0.0];
        for _ in 0..steps {
            problem.set_initial_state(x);
            if solver.solve(&problem, Start::Cold).status != Status::Solved {
                break;
            }
            self.starts.push(x);
            x = solver.states()[1];
        }
        self
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A 2 by 2 matrix in the corner of a 3 by 3 one.
fn corner(m: [[f64; 2]; 2]) -> [[f64; 3]; 3] {
    [[m[0][0], m[0][1], 0.0], [m[1][0], m[1][1], 0.0], [0.0; 3]]
}

/// Bounds of both states at all stages behind the first.
fn state_box(low: [f64; 2], high: [f64; 2], horizon: usize) -> Vec<Limit> {
    let limit = |gradient, limit| Limit { gradient, from: 1, to: horizon, limit };
    vec![
        limit([1.0, 0.0, 0.0], high[0]),
        limit([-1.0, 0.0, 0.0], -low[0]),
        limit([0.0, 1.0, 0.0], high[1]),
        limit([0.0, -1.0, 0.0], -low[1]),
    ]
}

/// Limit of `P ← Q + A'(P − P B (R + B'P B)⁻¹ B'P) A`, the Riccati equation; without `b` Lyapunov's equation.
fn terminal(a: [[f64; 2]; 2], b: Option<[f64; 2]>, q: [[f64; 2]; 2], r: f64) -> [[f64; 2]; 2] {
    let mut p = q;
    for _ in 0..2_000 {
        let mut inner = p;
        if let Some(b) = b {
            let pb = [p[0][0] * b[0] + p[0][1] * b[1], p[1][0] * b[0] + p[1][1] * b[1]];
            let scale = r + b[0] * pb[0] + b[1] * pb[1];
            for i in 0..2 {
                for j in 0..2 {
                    inner[i][j] -= pb[i] * pb[j] / scale;
                }
            }
        }
        let mut next = q;
        for i in 0..2 {
            for j in 0..2 {
                for k in 0..2 {
                    for l in 0..2 {
                        next[i][j] += a[k][i] * inner[k][l] * a[l][j];
                    }
                }
            }
        }
        // The two sums of a pair round differently.
        let mean = (next[0][1] + next[1][0]) / 2.0;
        p = [[next[0][0], mean], [mean, next[1][1]]];
    }
    p
}

/// The sets of the public benchmarks.
pub(crate) fn public() -> Vec<Set> {
    let mut sets = Vec::new();
    let plate = |name: &str, horizon: usize, low: f64, target: f64| Set {
        name: format!("ball on plate {name}"),
        horizon,
        a: corner([[1.0, 0.01], [0.0, 1.0]]),
        b: [-0.0004, -0.0701, 0.0],
        q: corner([[100.0, 0.0], [0.0, 10.0]]),
        r: 1.0,
        p: corner([[100.0, 0.0], [0.0, 10.0]]),
        target: [0.0, target, 0.0],
        bounds: [low, 0.0524],
        rows: state_box([-0.2, -0.1], [0.01, 0.1], horizon),
        ends_at_zero: false,
        starts: Vec::new(),
    };
    sets.push(plate("1", 15, -0.0524, 0.05).driven([-0.05, 0.05], 50));
    sets.push(plate("2", 15, -0.0524, 0.05).driven([-0.05, 0.0], 50));
    sets.push(plate("3", 15, -0.03, 0.05).driven([-0.17, 0.0], 300));
    sets.push(plate("4", 25, -0.0524, 0.0).driven([-0.15, 0.0], 200));

    let (a, b, unit) = ([[0.8, 1.0], [0.0, 0.9]], [-1.0, 2.0], [[1.0, 0.0], [0.0, 1.0]]);
    let fiordos = |name: &str, p: [[f64; 2]; 2], rows: Vec<Limit>| Set {
        name: format!("FiOrdOs {name}"),
        horizon: 5,
        a: corner(a),
        b: [b[0], b[1], 0.0],
        q: corner(unit),
        r: 1.0,
        p: corner(p),
        target: [0.0; 3],
        bounds: [-0.7, 0.7],
        rows,
        ends_at_zero: false,
        starts: Vec::new(),
    };
    let lyapunov = terminal(a, None, unit, 1.0);
    sets.push(fiordos("1", lyapunov, Vec::new()).driven([1.0, 2.0], 20));
    let boxed = state_box([-3.5, -0.5], [3.5, 2.0], 5);
    sets.push(fiordos("2", terminal(a, Some(b), unit, 1.0), boxed).driven([1.0, 2.0], 20));
    sets.push(fiordos("3", lyapunov, Vec::new()).driven([10.0, 20.0], 20));

    let (a, b) = ([[1.1, 1.0], [0.0, 1.0]], [1.0, 0.5]);
    let riccati = terminal(a, Some(b), unit, 1.0);
    let diagonal = [[riccati[0][0], 0.0], [0.0, riccati[1][1]]];
    let forces = [
        ("1", 9, riccati),
        ("2", 9, diagonal),
        ("1, N = 5", 5, riccati),
        ("1, N = 20", 20, riccati),
        ("1, N = 40", 40, riccati),
    ];
    for (name, horizon, p) in forces {
        let set = Set {
            name: format!("FORCES {name}"),
            horizon,
            a: corner(a),
            b: [b[0], b[1], 0.0],
            q: corner(unit),
            r: 1.0,
            p: corner(p),
            target: [0.0; 3],
            bounds: [-0.5, 0.5],
            rows: state_box([-5.0; 2], [5.0; 2], horizon),
            ends_at_zero: false,
            starts: Vec::new(),
        };
        sets.push(set.driven([-4.0, 2.0], 20));
    }
    sets
}

/// The feasible instances of the drives without a light, at their full horizon.
pub(crate) fn drives(starts: Vec<[f64; 3]>, weights: [f64; 3], buffer_m: f64) -> Set {
    let (t, tau, horizon) = (0.1, 0.5, 100);
    let mut q = [[0.0; 3]; 3];
    (0..3).for_each(|i| q[i][i] = weights[i]);
    let gradient = [1.0, 0.0, 0.0];
    Set {
        name: "acc-mpc drives".into(),
        horizon,
        a: [[1.0, t, 0.0], [0.0, 1.0, t], [0.0, 0.0, 1.0 - t / tau]],
        b: [0.0, 0.0, t / tau],
        q,
        r: 1.0,
        p: [[0.0; 3]; 3],
        target: [0.0; 3],
        bounds: [-4.9, 4.9],
        rows: vec![Limit { gradient, from: 1, to: horizon - 1, limit: buffer_m }],
        ends_at_zero: true,
        starts,
    }
}
