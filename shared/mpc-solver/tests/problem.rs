//! Refusals of the builder, and sensitivity of the optimality conditions.

mod common;

use common::{cacc, instances};
use mpc_solver::{
    Clarabel, LightCost, MAX_HORIZON, Problem, ProblemBuilder, ProblemError, Riccati, Row,
    Softness, Solver, Start, residuals,
};

fn valid() -> ProblemBuilder {
    Problem::builder(10)
        .dynamics([[1.0, 0.1, 0.0], [0.0, 1.0, 0.1], [0.0, 0.0, 0.8]], [0.0, 0.0, 0.2])
        .input_bounds(-1.0, 1.0)
        .input_cost(1.0)
}

fn row() -> Row {
    let softness = Softness::Hard;
    Row { gradient: [1.0, 0.0, 0.0], from: 1, to: 10, limit: 0.0, softness }
}

fn error(builder: ProblemBuilder) -> ProblemError {
    builder.build().expect_err("it must be refused")
}

#[test]
fn accepts_what_is_well_posed() {
    assert!(valid().build().is_ok());
    // Semidefinite is enough, also with a cost of state times input.
    assert!(valid().state_weights([1.0, 0.0, 0.0]).jerk_cost(2.0, 0.5).build().is_ok());
    assert!(valid().row(Row { limit: f64::INFINITY, ..row() }).build().is_ok());
}

#[test]
fn refuses_what_is_not_and_says_why() {
    let unit = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(error(Problem::builder(0)), ProblemError::Horizon(0));
    let long = MAX_HORIZON + 1;
    assert_eq!(error(Problem::builder(long)), ProblemError::Horizon(long));
    let mut lower = unit;
    lower[2][0] = 0.1;
    assert_eq!(error(valid().dynamics(lower, [0.0, 0.0, 1.0])), ProblemError::NotUpperTriangular);
    assert_eq!(error(valid().dynamics(unit, [0.0; 3])), ProblemError::NoInput);
    let nan = [f64::NAN, 0.0, 0.0];
    assert_eq!(error(valid().dynamics(unit, nan)), ProblemError::NotFinite("dynamics"));
    assert_eq!(error(valid().input_bounds(1.0, -1.0)), ProblemError::EmptyInputRange);
    let open = f64::INFINITY;
    assert_eq!(error(valid().input_bounds(-1.0, open)), ProblemError::NotFinite("input bound"));
    assert_eq!(error(valid().input_cost(0.0)), ProblemError::InputCost);
    assert_eq!(error(valid().input_cost(f64::NAN)), ProblemError::NotFinite("cost"));
    assert_eq!(
        error(valid().state_weights([1.0, -1.0, 0.0])),
        ProblemError::NotConvex("stage cost")
    );
    assert_eq!(error(valid().cross_cost([0.0, 0.0, 1.0])), ProblemError::NotConvex("stage cost"));
    let mut skew = unit;
    skew[0][1] = 0.5;
    assert_eq!(error(valid().state_cost(skew)), ProblemError::NotSymmetric("state cost"));
    assert_eq!(error(valid().terminal_cost(skew)), ProblemError::NotSymmetric("terminal cost"));
    let bent = [[1.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(error(valid().terminal_cost(bent)), ProblemError::NotConvex("terminal cost"));
    let five = (0..5).fold(valid(), |builder, _| builder.row(row()));
    assert_eq!(error(five), ProblemError::TooManyRows(5));
    assert_eq!(error(valid().row(Row { from: 0, ..row() })), ProblemError::RowStages(0));
    assert_eq!(error(valid().row(Row { to: 11, ..row() })), ProblemError::RowStages(0));
    assert_eq!(error(valid().row(Row { gradient: [0.0; 3], ..row() })), ProblemError::EmptyRow(0));
    let limit = f64::NEG_INFINITY;
    assert_eq!(error(valid().row(Row { limit, ..row() })), ProblemError::NotFinite("row limit"));
    let free = Softness::Soft { linear: 0.0, quadratic: 1.0 };
    assert_eq!(error(valid().row(Row { softness: free, ..row() })), ProblemError::PenaltyWeight);
    let light = LightCost { weight: 1.0, threshold: 0.0, softness: Softness::Hard };
    assert_eq!(error(valid().light(light)), ProblemError::Light);
    let dark = LightCost { weight: f64::NAN, threshold: 1.0, softness: Softness::Hard };
    assert_eq!(error(valid().light(dark)), ProblemError::Light);
    assert!(error(valid().input_cost(-1.0)).to_string().contains("must be positive"));
}

#[test]
fn the_conditions_notice_every_kind_of_change() {
    let table = instances();
    // Light, bounds, the buffer row and the terminal equality all active.
    let instance = &table[810];
    let mut problem = cacc(100);
    instance.apply(&mut problem);
    let mut solver = Riccati::new(100);
    solver.solve(&problem, Start::Cold);
    let mut states = vec![[0.0; 3]; 101];
    let mut check = |inputs: &[f64], multipliers: &mpc_solver::Multipliers| {
        problem.roll_out(inputs, &mut states);
        residuals(&problem, inputs, &states, multipliers)
    };
    let (inputs, multipliers) = (solver.inputs().to_vec(), solver.multipliers().clone());
    assert!(check(&inputs, &multipliers).max() < 1e-8);
    let mut other = inputs.clone();
    other[0] += 1e-3;
    assert!(check(&other, &multipliers).feasibility > 1e-4);
    other[0] = 5.0;
    assert!(check(&other, &multipliers).feasibility > 0.09);
    let scale = multipliers.light.iter().fold(0.0, |top: f64, a| top.max(*a));
    let mut wrong = multipliers.clone();
    wrong.light[10] += 1e-3 * scale;
    assert!(check(&inputs, &wrong).max() > 1e-6);
    let mut wrong = multipliers.clone();
    wrong.rows[0][5] += 1e-3 * scale;
    assert!(check(&inputs, &wrong).complementarity > 1e-6);
    let mut wrong = multipliers.clone();
    wrong.terminal[0] *= 1.001;
    assert!(check(&inputs, &wrong).stationarity > 1e-6);
    let mut wrong = multipliers;
    wrong.rows[0][60] = f64::NAN;
    assert_eq!(check(&inputs, &wrong).max(), f64::INFINITY);
}

#[test]
fn a_problem_shows_its_rows_in_their_order() {
    let second = Row { gradient: [0.0, 1.0, 0.0], from: 3, to: 7, ..row() };
    let problem = valid().row(row()).row(second).build().expect("it is well posed");
    let stages: Vec<_> =
        problem.rows().iter().map(|row| (row.gradient[1], row.from, row.to)).collect();
    assert_eq!(stages, [(0.0, 1, 10), (1.0, 3, 7)]);
}

#[test]
fn both_solvers_serve_behind_one_trait() {
    let solvers: [Box<dyn Solver>; 2] = [Box::new(Riccati::new(100)), Box::new(Clarabel::new())];
    for mut solver in solvers {
        let problem = cacc(100);
        solver.solve(&problem, Start::Cold);
        assert!(problem.objective(solver.inputs(), solver.states()).abs() < 1e-6);
    }
}
