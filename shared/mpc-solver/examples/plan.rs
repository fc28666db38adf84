//! A car brakes for a stop line 60 m ahead: built once, solved each cycle. `cargo run --example plan`.

use mpc_solver::{Problem, ProblemError, Riccati, Row, Softness, Solver, Start, Status};

fn main() -> Result<(), ProblemError> {
    // State: distance past the line (m), speed (m/s), acceleration (m/s²). Input: requested acceleration.
    let horizon = 80;
    let mut problem = Problem::builder(horizon)
        .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
        .state_weights([0.01, 1.0, 1.0])
        .input_cost(1.0)
        .input_bounds(-4.0, 2.0)
        .row(Row {
            gradient: [1.0, 0.0, 0.0],
            from: 1,
            to: horizon,
            limit: 0.0,
            softness: Softness::Soft { linear: 1e3, quadratic: 0.0 },
        })
        .build()?;
    let mut solver = Riccati::new(horizon);
    let mut state = [-60.0, 15.0, 0.0];
    for cycle in 0..100 {
        problem.set_initial_state(state);
        let report = solver.solve(&problem, Start::Shifted(1));
        assert_eq!(report.status, Status::Solved);
        if cycle % 20 == 0 {
            println!(
                "{:.1} m, {:.1} m/s: request {:.2} m/s²",
                state[0],
                state[1],
                solver.inputs()[0]
            );
        }
        state = solver.states()[1];
    }
    Ok(())
}
