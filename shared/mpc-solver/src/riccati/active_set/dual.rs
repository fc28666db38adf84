//! Joint solution for the multipliers of the terminal equality and of the working rows.
//!
//! After a backward sweep, the error at the end and the violations of the rows are affine in both:
//!
//! ```text
//! x_N − x_f = m − W y − T μ = 0,        z = z̄ − T'y − G μ
//! ```
//!
//! Eliminating `y = W⁻¹(m − T μ)` leaves `z = (z̄ − T'W⁻¹m) − (G − T'W⁻¹T) μ`, the program of
//! [`super::complementarity`]. Without a terminal equality `y` and `T` are absent.

use super::complementarity::{Complementarity, MAX_WORKING_ROWS};
use super::response::RowResponse;
use super::rows::WorkingRow;
use crate::problem::{Problem, Softness, Terminal, dot};
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
        let mut multipliers = [0.0; MAX_WORKING_ROWS];
        for (slot, row) in multipliers.iter_mut().zip(rows.iter()) {
            *slot = row.multiplier;
        }
        program.solve(&mut multipliers)?;
        for (c, row) in rows.iter_mut().enumerate() {
            row.multiplier = multipliers[c];
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
fn program_of(problem: &Problem, response: &RowResponse, rows: &[WorkingRow]) -> Complementarity {
    let mut program = Complementarity {
        len: rows.len(),
        response: response.gram,
        value: response.value,
        ..Complementarity::default()
    };
    for (c, row) in rows.iter().enumerate() {
        program.scale[c] = response.gram[c][c];
        (program.weight[c], program.curvature[c]) = match problem.rows[row.row].softness {
            Softness::Hard => (f64::INFINITY, 0.0),
            Softness::Soft { linear, quadratic } => (linear, quadratic),
        };
    }
    program
}
