//! The solver made for the problem against the oracle, the table and itself.

mod common;
#[path = "common/random.rs"]
mod random;

use common::{Instance, cacc, cost, instances};
use mpc_solver::{
    Clarabel, Problem, Report, Riccati, Row, Softness, Solver, Start, Status, residuals,
};
use random::Draw;

/// Asserts a solution by the optimality conditions evaluated here, with inputs within their bounds.
fn assert_solved(solver: &Riccati, problem: &Problem, report: &Report, name: &str) {
    assert_eq!(report.status, Status::Solved, "{name}: {report:?}");
    let (lo, hi) = problem.input_bounds();
    assert!(solver.inputs().iter().all(|u| (lo..=hi).contains(u)), "{name}");
    let mut states = vec![[0.0; 3]; problem.horizon() + 1];
    problem.roll_out(solver.inputs(), &mut states);
    let found = residuals(problem, solver.inputs(), &states, solver.multipliers());
    assert!(found.max() <= 1e-8, "{name}: {found:?}");
}

/// Compares two costs.
fn assert_agrees(ours: f64, oracle: f64, tolerance: f64, name: &str) {
    let error = (ours - oracle).abs();
    assert!(error <= tolerance * oracle.abs().max(1.0), "{name}: {ours} against {oracle}");
}

#[test]
fn solves_every_feasible_instance_of_the_table_cold_and_warm() {
    let mut problem = cacc(100);
    let (mut cold, mut warm) = (Riccati::new(100), Riccati::new(100));
    let mut solved = 0;
    for instance in instances().iter().filter(|i| i.feasible) {
        instance.apply(&mut problem);
        let name = format!("instance {}", instance.id);
        let report = cold.solve(&problem, Start::Cold);
        assert_solved(&cold, &problem, &report, &name);
        // The page prints the weights to five figures; the table was made with all of them.
        let found = cost(&problem, &cold);
        let error = (found - instance.objective).abs() / instance.objective.max(1.0);
        assert!(error < 2e-4, "{name}: {report:?}");
        let again = warm.solve(&problem, Start::Shifted(1));
        assert_solved(&warm, &problem, &again, &name);
        assert_agrees(cost(&problem, &warm), found, 1e-9, &name);
        solved += 1;
    }
    assert_eq!(solved, 883);
}

#[test]
fn agrees_with_the_oracle_on_what_the_table_gives_up() {
    let mut problem = cacc(100);
    let (mut solver, mut oracle) = (Riccati::new(100), Clarabel::with_tolerance(1e-9));
    let given_up: Vec<Instance> = instances().into_iter().filter(|i| !i.feasible).collect();
    assert_eq!(given_up.len(), 25);
    for instance in &given_up {
        instance.apply(&mut problem);
        let report = solver.solve(&problem, Start::Cold);
        // The solver that made the table could not solve four of them; they are feasible by a small
        // margin.
        let feasible = [778, 779, 780, 824].contains(&instance.id);
        let expected = if feasible { Status::Solved } else { Status::Infeasible };
        assert_eq!(report.status, expected, "instance {}: {report:?}", instance.id);
        assert!(solver.inputs().iter().all(|u| u.abs() <= 4.9));
        let reference = oracle.solve(&problem, Start::Cold);
        assert_eq!(reference.status != Status::Infeasible, feasible, "instance {}", instance.id);
    }
}

#[test]
fn agrees_with_the_oracle_on_the_table() {
    let mut problem = cacc(100);
    let (mut solver, mut oracle) = (Riccati::new(100), Clarabel::with_tolerance(1e-9));
    for instance in instances().iter().filter(|i| i.feasible).step_by(9) {
        instance.apply(&mut problem);
        solver.solve(&problem, Start::Cold);
        oracle.solve(&problem, Start::Cold);
        assert_agrees(
            cost(&problem, &solver),
            cost(&problem, &oracle),
            1e-7,
            &format!("instance {}", instance.id),
        );
    }
}

#[test]
fn agrees_with_the_oracle_on_random_problems() {
    let (mut solver, mut oracle) = (Riccati::new(150), Clarabel::with_tolerance(1e-9));
    let mut compared = 0;
    for seed in 0..300 {
        let problem = random::problem(&mut Draw::new(seed));
        let report = solver.solve(&problem, Start::Cold);
        assert_solved(&solver, &problem, &report, &format!("seed {seed}"));
        let reference = oracle.solve(&problem, Start::Cold);
        // The oracle's own residuals decide whether it can judge to seven figures.
        if reference.status == Status::Solved && reference.residuals.max() < 1e-4 {
            assert_agrees(
                cost(&problem, &solver),
                cost(&problem, &oracle),
                1e-7,
                &format!("seed {seed}"),
            );
            compared += 1;
        }
        // The inputs are feasible, so an exact objective cannot be undercut.
        let (ours, oracle) = (cost(&problem, &solver), cost(&problem, &oracle));
        let slack = 1e-6 * ours.abs().max(1.0);
        if reference.residuals.feasibility < 1e-9 && reference.residuals.complementarity < 1e-9 {
            assert!(oracle > ours - slack, "seed {seed}");
        }
    }
    assert!(compared > 150, "only {compared} comparisons");
}

fn solve_random(seeds: std::ops::Range<u64>) {
    let mut solver = Riccati::new(150);
    for seed in seeds {
        let problem = random::problem(&mut Draw::new(seed));
        let report = solver.solve(&problem, Start::Cold);
        assert_solved(&solver, &problem, &report, &format!("seed {seed}"));
    }
}

#[test]
fn solves_random_feasible_problems() {
    solve_random(1_000..11_000);
}

/// With separate primal and dual lengths, the iterates of this problem's first start cycle.
#[test]
fn one_length_of_the_interior_point_does_not_cycle() {
    let mut solver = Riccati::new(150);
    let problem = random::problem(&mut Draw::new(23_192));
    let report = solver.solve(&problem, Start::Cold);
    assert_solved(&solver, &problem, &report, "seed 23192");
    assert!(report.interior_iterations < 60, "{report:?}");
}

/// A row tangent as steep for multipliers of 1 as for 1e5 would leave residuals of 1e-8 to 3e-8 here.
#[test]
fn row_tangents_leave_the_digits_that_the_multipliers_need() {
    let mut solver = Riccati::new(150);
    for seed in [1_145_649, 1_366_765] {
        let problem = random::problem(&mut Draw::new(seed));
        let report = solver.solve(&problem, Start::Cold);
        assert_solved(&solver, &problem, &report, &format!("seed {seed}"));
    }
}

/// Ahead of the row, neighbouring inputs are at opposite bounds at the solution. Freeing one of
/// them would keep every attempt to finish from settling.
#[test]
fn switches_ahead_of_a_row_in_the_guess_by_its_tangents_are_left_alone() {
    let mut solver = Riccati::new(150);
    let problem = random::problem(&mut Draw::new(13_931));
    let report = solver.solve(&problem, Start::Cold);
    assert_solved(&solver, &problem, &report, "seed 13931");
    let (lo, hi) = problem.input_bounds();
    let is_switch = |pair: &[f64]| pair.contains(&lo) && pair.contains(&hi);
    assert!(solver.inputs().windows(2).any(is_switch));
    assert!(report.interior_iterations < 12, "{report:?}");
}

/// A hopeless cold attempt costs one round.
#[test]
fn a_first_trajectory_that_violates_rows_at_many_stages_is_the_only_one() {
    let mut solver = Riccati::new(150);
    let problem = random::problem(&mut Draw::new(43_212));
    let report = solver.solve(&problem, Start::Cold);
    assert_solved(&solver, &problem, &report, "seed 43212");
    let rounds = report.iterations - report.interior_iterations;
    assert!(rounds <= 2, "one cold, one to finish: {report:?}");
}

#[test]
fn same_input_same_bits_whatever_came_before() {
    let mut problem = cacc(100);
    let mut used = Riccati::new(150);
    for (seed, instance) in instances().iter().filter(|i| i.feasible).step_by(11).enumerate() {
        used.solve(&random::problem(&mut Draw::new(seed as u64)), Start::Cold);
        instance.apply(&mut problem);
        let mut fresh = Riccati::new(100);
        let a = fresh.solve(&problem, Start::Cold);
        let b = used.solve(&problem, Start::Cold);
        assert_eq!(a, b, "instance {}", instance.id);
        assert_eq!(fresh.inputs(), used.inputs());
    }
}

/// One step with one state of interest, solved by hand.
fn one_step() -> mpc_solver::ProblemBuilder {
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // x₁ = x₀ + 2u, cost ½u² + ½·3 x₁², x₀ = 7: u = −6·7/13 without any constraint.
    Problem::builder(1)
        .dynamics(unit, [0.0, 0.0, 2.0])
        .input_cost(1.0)
        .terminal_weights([0.0, 0.0, 3.0])
        .input_bounds(-100.0, 100.0)
        .initial_state([0.0, 0.0, 7.0])
}

fn solve_one(problem: &Problem) -> (f64, Report) {
    let mut solver = Riccati::new(1);
    let report = solver.solve(problem, Start::Cold);
    assert_solved(&solver, problem, &report, "one step");
    (solver.inputs()[0], report)
}

fn row(softness: Softness) -> Row {
    // x₁ ≥ 5.
    Row { gradient: [0.0, 0.0, -1.0], from: 1, to: 1, limit: -5.0, softness }
}

#[test]
fn one_step_by_hand() {
    let valid = "a valid problem";
    let problem = one_step().build().expect(valid);
    let (u, _) = solve_one(&problem);
    assert!((u + 42.0 / 13.0).abs() < 1e-12);
    let x = 7.0 + 2.0 * u;
    let found = problem.objective(&[u], &[[0.0, 0.0, 7.0], [0.0, 0.0, x]]);
    assert!((found - 0.5 * (u * u + 3.0 * x * x)).abs() < 1e-9);
    let (u, _) = solve_one(&one_step().input_bounds(-2.0, 2.0).build().expect(valid));
    assert_eq!(u, -2.0);
    let (u, _) = solve_one(&one_step().row(row(Softness::Hard)).build().expect(valid));
    assert!((u + 1.0).abs() < 1e-9);
    // du/dσ: at x₁ = 5 − σ the row's multiplier must be u/2 + 3 x₁ = 14.5 − 3.25 σ.
    let soft = |linear| row(Softness::Soft { linear, quadratic: 0.0 });
    let (u, _) = solve_one(&one_step().row(soft(15.0)).build().expect(valid));
    assert!((u + 1.0).abs() < 1e-8, "an exact penalty is exact");
    let (u, _) = solve_one(&one_step().row(soft(8.0)).build().expect(valid));
    assert!((7.0 + 2.0 * u - 3.0).abs() < 1e-9, "and gives way below the multiplier: {u}");
}

#[test]
fn answers_bad_numbers_with_a_status() {
    let clean = random::problem(&mut Draw::new(5));
    let n = clean.horizon();
    let mut solver = Riccati::new(150);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut problem = clean.clone();
        problem.set_initial_state([bad, 0.0, 0.0]);
        let mut others = vec![problem];
        let mut problem = clean.clone();
        problem.disturbances_mut()[n - 1][2] = bad;
        others.push(problem);
        let mut problem = clean.clone();
        problem.input_gradients_mut()[3] = bad;
        others.push(problem);
        for problem in &others {
            let report = solver.solve(problem, Start::Shifted(1));
            assert_eq!(report.status, Status::InvalidInput);
            assert_eq!(solver.inputs().len(), n);
            assert!(solver.inputs().iter().all(|u| *u == 0.0));
        }
    }
    let mut huge = clean.clone();
    huge.set_initial_state([1e300, -1e300, 1e300]);
    let report = solver.solve(&huge, Start::Cold);
    assert!(matches!(
        report.status,
        Status::InvalidInput | Status::IterationLimit | Status::Infeasible
    ));
    assert!(solver.inputs().iter().all(|u| u.is_finite()));
    // The refused problem leaves no trace in the next solution.
    let report = solver.solve(&clean, Start::Shifted(1));
    assert_solved(&solver, &clean, &report, "after bad numbers");
    assert_eq!(Riccati::new(10).solve(&clean, Start::Cold).status, Status::InvalidInput);
}

#[test]
fn a_state_that_no_input_can_keep_is_infeasible_hard_and_solved_soft() {
    let build = |softness| {
        let mut problem = Problem::builder(50)
            .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
            .input_cost(1.0)
            .state_weights([1.0, 1.0, 0.0])
            .terminal_weights([10.0, 10.0, 1.0])
            .input_bounds(-4.9, 4.9)
            .row(Row { gradient: [1.0, 0.0, 0.0], from: 1, to: 50, limit: 12.0, softness })
            .build()
            .expect("a valid problem");
        // Past the buffer and closing at 8 m/s: the next two errors are out of reach.
        problem.set_initial_state([12.5, 8.0, 0.0]);
        problem
    };
    let mut solver = Riccati::new(50);
    let hard = build(Softness::Hard);
    assert_eq!(solver.solve(&hard, Start::Cold).status, Status::Infeasible);
    let soft = build(Softness::Soft { linear: 1e4, quadratic: 0.0 });
    let report = solver.solve(&soft, Start::Cold);
    assert_solved(&solver, &soft, &report, "soft");
    assert_eq!(solver.inputs()[0], -4.9);
}

/// Cold and warm results for the whole table, bit by bit. The loops over the stages exist for any
/// x86-64 and for AVX2. The sum below comes from a build without the AVX2 version. On a machine
/// with AVX2 this test compares the two.
#[test]
fn the_answers_have_the_same_bits_with_wide_registers_and_without() {
    let mut problem = cacc(100);
    let mut solver = Riccati::new(100);
    let mut sum: u64 = 0xcbf2_9ce4_8422_2325;
    let mut add = |x: f64| sum = (sum ^ x.to_bits()).wrapping_mul(0x0100_0000_01b3);
    for instance in instances() {
        instance.apply(&mut problem);
        for start in [Start::Cold, Start::Shifted(1)] {
            let report = solver.solve(&problem, start);
            add(cost(&problem, &solver));
            add(f64::from(report.iterations));
            solver.inputs().iter().copied().for_each(&mut add);
        }
    }
    assert_eq!(sum, 0x3081_b6cd_8bd5_6b81, "{sum:#x}");
}

/// `cargo test --release -p mpc-solver --test riccati -- --ignored --nocapture 100_000`: about a
/// minute.
///
/// Two of some 400,000 problems end at the machine's precision, with residuals above 1e-8 (seeds
/// 1,144,342 and 1,199,001). Their status is not `Solved`, and their inputs are usable.
#[test]
#[ignore = "takes a minute"]
fn solves_100_000_random_feasible_problems_of_each_class() {
    const EACH: u64 = 100_000;
    let mut solver = Riccati::new(150);
    let mut counts = [0; 4];
    let mut most_iterations = [0; 4];
    let mut imprecise = Vec::new();
    let mut seed = 1_000_000;
    while counts.iter().any(|count| *count < EACH) {
        let problem = random::problem(&mut Draw::new(seed));
        let report = solver.solve(&problem, Start::Cold);
        if report.status == Status::IterationLimit && report.residuals.max() < 1e-6 {
            imprecise.push(seed);
        } else {
            assert_solved(&solver, &problem, &report, &format!("seed {seed}"));
        }
        let rows = problem.rows().iter().zip(&solver.multipliers().rows);
        let acts = rows.into_iter().any(|(row, mu)| (row.from..=row.to).any(|k| mu[k] > 1e-7));
        let class = usize::from(acts) * 2 + usize::from(!problem.light_stages().is_empty());
        counts[class] += 1;
        most_iterations[class] = report.iterations.max(most_iterations[class]);
        seed += 1;
    }
    println!(
        "no row acts, no light; light; rows; rows and light: {counts:?}, at most {most_iterations:?} \
         iterations; imprecise: {imprecise:?}"
    );
    assert!(imprecise.len() <= 2, "{imprecise:?}");
}
