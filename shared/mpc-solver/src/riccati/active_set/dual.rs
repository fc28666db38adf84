//! Joint solution for the multipliers of the terminal equality and of the working rows.
//!
//! After a backward sweep, the error at the end and the violations of the rows are affine in both:
//!
//! ```text
//! x_N − x_f = m − W y − T μ = 0,        z = z̄ − T'y − G μ
//! ```
//!
//! Eliminating `y = W⁻¹(m − T μ)` leaves `z = (z̄ − T'W⁻¹m) − (G − T'W⁻¹T) μ`, the program of
//! [`crate::riccati::complementarity`]. Without a terminal equality `y` and `T` are absent.

use super::response::RowResponse;
use super::rows::{MAX_WORKING_ROWS, WorkingRow};
use crate::problem::{Problem, Terminal, dot};
use crate::riccati::complementarity::{Complementarity, UNREACHABLE};
use crate::riccati::lqr::CostToGo;

/// Solves for both, the rows' multipliers from their present values; `None` if their program cannot
/// be solved.
pub(super) fn solve(
    problem: &Problem,
    cost_to_go: &CostToGo,
    response: &RowResponse,
    rows: &mut [WorkingRow],
) -> Option<[f64; 3]> {
    let mut system = match &problem.terminal {
        Terminal::Cost => None,
        Terminal::Equality(x_f) => Some(cost_to_go.terminal_system(problem, x_f)),
    };
    if !rows.is_empty() {
        let mut program = program_of(problem, response, rows);
        let column = |c: usize| [0, 1, 2].map(|i| response.terminal[i][c]);
        if let Some(system) = &system {
            let y = system.multiplier();
            for c in 0..rows.len() {
                program.value[c] -= dot(&column(c), &y);
                let reduced = system.factors.solve(&column(c));
                for e in 0..rows.len() {
                    program.response[e][c] -= dot(&column(e), &reduced);
                }
            }
        }
        program.solve()?;
        for (c, row) in rows.iter_mut().enumerate() {
            row.multiplier = program.multipliers[c];
            if let Some(system) = &mut system {
                for i in 0..3 {
                    system.miss[i] -= response.terminal[i][c] * row.multiplier;
                }
            }
        }
    }
    Some(system.map_or([0.0; 3], |system| system.multiplier()))
}

/// Returns the rows' program for `y = 0`.
fn program_of(
    problem: &Problem,
    response: &RowResponse,
    rows: &[WorkingRow],
) -> Complementarity<MAX_WORKING_ROWS> {
    let mut program = Complementarity::new(UNREACHABLE);
    program.len = rows.len();
    program.response = response.gram;
    program.value = response.value;
    for (c, row) in rows.iter().enumerate() {
        program.scale[c] = response.gram[c][c];
        program.multipliers[c] = row.multiplier;
        (program.weight[c], program.curvature[c]) = problem.rows[row.row].softness.penalty();
    }
    program
}
