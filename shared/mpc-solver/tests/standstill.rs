//! Limits that hold without a force: a reference that comes to rest on the limit `v >= 0` and stays
//! there.
//!
//! At such a limit slack and multiplier are both zero. An interior point then gains less than a
//! digit per iteration, and both are the root of the target product.

use mpc_solver::{Problem, Report, Riccati, Row, Softness, Solver, Start, Status};

const N: usize = 100;
const STEP_S: f64 = 0.1;
const HEADWAY_S: f64 = 1.5;
const LAG_S: f64 = 0.5;
const WEIGHTS: [f64; 3] = [0.2, 1.0, 0.1];

/// Returns the problem behind a standing lead at `speed_mps`. The reference brakes with
/// `braking_mps2`; the lowest speed may be `-margin_mps`.
fn behind_a_standing_lead(speed_mps: f64, braking_mps2: f64, margin_mps: f64) -> Problem {
    let decay = (-STEP_S / LAG_S).exp();
    let speed = [LAG_S * (1.0 - decay), STEP_S - LAG_S * (1.0 - decay)];
    let position = [LAG_S * STEP_S - LAG_S * speed[0], 0.5 * STEP_S * STEP_S - LAG_S * speed[1]];
    let row = |gradient, limit| Row {
        gradient,
        from: 1,
        to: N,
        limit,
        softness: Softness::Soft { linear: 100.0, quadratic: 0.0 },
    };
    let mut problem = Problem::builder(N)
        .dynamics(
            [
                [1.0, STEP_S, HEADWAY_S * speed[0] + position[0]],
                [0.0, 1.0, speed[0]],
                [0.0, 0.0, decay],
            ],
            [HEADWAY_S * speed[1] + position[1], speed[1], 1.0 - decay],
        )
        .state_weights(WEIGHTS)
        .terminal_weights(WEIGHTS.map(|weight| 5.0 * weight))
        .input_cost(0.05)
        .jerk_cost(0.5, LAG_S)
        .input_bounds(-3.0, 2.0)
        .row(row([1.0, -HEADWAY_S, 0.0], 3.0))
        .row(row([0.0, -1.0, 0.0], margin_mps))
        .build()
        .expect("convex");
    // Its gap is the desired one where it stops.
    let stops_s = speed_mps / braking_mps2;
    let reference = |k: usize| {
        let left_s = (stops_s - STEP_S * k as f64).max(0.0);
        let (v, to_go) = (braking_mps2 * left_s, 0.5 * braking_mps2 * left_s * left_s);
        [HEADWAY_S * v - to_go, v, if left_s > 0.0 { -braking_mps2 } else { 0.0 }]
    };
    problem.set_initial_state(reference(0));
    for (k, gradient) in problem.state_gradients_mut().iter_mut().enumerate() {
        *gradient = std::array::from_fn(|i| -WEIGHTS[i] * reference(k)[i]);
    }
    for (k, gradient) in problem.input_gradients_mut().iter_mut().enumerate() {
        *gradient = -0.05 * reference(k)[2];
    }
    problem.set_terminal_gradient(std::array::from_fn(|i| -5.0 * WEIGHTS[i] * reference(N)[i]));
    problem
}

fn solve(problem: &Problem) -> Report {
    Riccati::new(N).solve(problem, Start::Cold)
}

#[test]
fn a_stop_on_the_limit_of_the_speed_is_solved_from_the_first_start() {
    let (mut interior, mut most) = (0, 0);
    for speed in 1..=40 {
        for braking in 1..=6 {
            let (speed_mps, braking_mps2) = (0.25 * f64::from(speed), 0.5 * f64::from(braking));
            let report = solve(&behind_a_standing_lead(speed_mps, braking_mps2, 0.0));
            let what = format!("{speed_mps} m/s, {braking_mps2} m/s²: {report:?}");
            assert_eq!(report.status, Status::Solved, "{what}");
            interior += u32::from(report.interior_iterations > 0);
            most = most.max(report.interior_iterations);
        }
    }
    println!("{interior} of 240 by the interior point, at most {most} iterations");
    assert!(interior > 20, "the scene no longer asks for the interior point: {interior}");
    assert!(most <= 30, "{most} iterations");
}

#[test]
fn with_room_below_the_limit_the_active_set_finds_it() {
    let with_room = |speed: u32| solve(&behind_a_standing_lead(0.5 * f64::from(speed), 1.5, 0.1));
    let interior = (1..=20).filter(|&speed| with_room(speed).interior_iterations > 0).count();
    assert_eq!(interior, 0);
}
