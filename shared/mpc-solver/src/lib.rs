//! Solvers for the model-predictive cruise problems: a small state, a long horizon, one input.
//!
//! # The problem
//!
//! With a horizon of `N` steps, a state `x` of three components and a scalar input `u`,
//!
//! ```text
//! minimise    Σ_{k=0}^{N-1} [ ½ x_k'Q x_k + q_k'x_k + (x_k's) u_k + ½ r u_k² + ρ_k u_k ]
//!           + ½ x_N'P x_N + p'x_N
//!           + Σ_j Σ_{k=from_j}^{to_j} ψ_j( g_j'x_k − h_{j,k} )                 (rows)
//!           + Σ_{k=1}^{K} φ( c_k'x_k + o_k )                                   (light)
//! over        u_0 … u_{N-1}
//! subject to  x_{k+1} = A x_k + B u_k + d_k,   x_0 given
//!             u_min ≤ u_k ≤ u_max
//!             x_N = x_f                        (only with `Terminal::Equality`)
//! ```
//!
//! `A` is upper triangular. Like `B`, `Q`, `s`, `r` and `P`, it is constant. `d_k` is a disturbance known in advance
//! (the acceleration of the vehicle ahead). `[Q s; s' r]` is positive semidefinite and `r > 0`, so that the problem is
//! convex and its inputs are unique. The cost of the first state is part of the objective although no input can change
//! it.
//!
//! A *row* (at most [`MAX_ROWS`]) bounds one linear function of the state, from its first stage to its last:
//!
//! ```text
//! hard:  ψ(z) = 0 for z ≤ 0, infinite for z > 0
//! soft:  ψ(z) = min_{σ ≥ max(z, 0)} λ σ + ½ κ σ² = λ max(z, 0) + ½ κ max(z, 0)²
//! ```
//!
//! The soft form is an exact penalty. A penalty weight `λ` above the multiplier of the hard row gives the hard row's
//! solution wherever it exists. Elsewhere it gives a least violation.
//!
//! The *light* is the convex form of a barrier on the predicted margin `D` before the switch. Source: He, Xi, Huang,
//! Chen and Huang 2024, doi 10.3969/j.issn.2095-1469.2024.06.06.
//!
//! ```text
//! hard:  φ(D) = w (1/min(D, d_th) − 1/d_th) for D > 0, infinite for D ≤ 0
//! soft:  φ(D) = min_{σ ≥ 0} w (1/min(D + σ, d_th) − 1/d_th) + λ σ
//! ```
//!
//! If it is soft, it leaves the hyperbola at `D = √(w/λ)`, where its slope is `−λ`. It continues as a straight line.
//! Every state then has a finite cost, and every problem with soft rows and a terminal cost has a solution.
//!
//! # Symbols
//!
//! | symbol | here | unit (cruise problems) |
//! |---|---|---|
//! | `N` | [`Problem::horizon`] | steps |
//! | `x_0` | [`Problem::set_initial_state`] | (m, m/s, m/s²) |
//! | `A`, `B` | [`ProblemBuilder::dynamics`] | per step |
//! | `d_k` | [`Problem::disturbances_mut`] | (m, m/s, m/s²) per step |
//! | `Q`, `s`, `r` | [`ProblemBuilder::state_cost`], [`ProblemBuilder::cross_cost`], [`ProblemBuilder::input_cost`] | cost per product |
//! | `q_k`, `ρ_k`, `p` | [`Problem::state_gradients_mut`], [`Problem::input_gradients_mut`], [`Problem::set_terminal_gradient`] | cost per unit |
//! | `u_min`, `u_max` | [`ProblemBuilder::input_bounds`] | m/s² |
//! | `g_j`, `from_j`, `to_j`, `λ_j`, `κ_j` | [`Row`] | |
//! | `h_{j,k}` | [`Problem::row_limits_mut`] | of `g'x` |
//! | `c_k`, `o_k`, `K` | [`LightStage`], [`Problem::set_light`] | `D` in m |
//! | `w`, `d_th`, `λ` | [`LightCost`] | cost·m, m, cost/m |
//!
//! # Solving
//!
//! Build a [`Problem`] once with [`Problem::builder`]; each cycle overwrite what changed (state, limits,
//! light) and call [`Solver::solve`]. Nothing allocates after construction. [`Riccati`] is the solver
//! made for this problem; `Clarabel` (feature `clarabel`) is the general one, the oracle of the tests.

#![warn(missing_docs)]
#![allow(clippy::needless_range_loop, reason = "matrix code keeps the indices of its equations")]

mod builder;
#[cfg(feature = "clarabel")]
mod clarabel;
mod kkt;
mod limits;
mod problem;
mod riccati;
mod solver;

pub use builder::ProblemBuilder;
#[cfg(feature = "clarabel")]
pub use clarabel::Clarabel;
pub use kkt::{Multipliers, Residuals, residuals};
pub use limits::{MAX_HORIZON, MAX_ROWS, ProblemError};
pub use problem::{LightCost, LightStage, Problem, Row, Softness, Terminal};
pub use riccati::Riccati;
pub use solver::{Report, Solver, Start, Status};

/// The examples of the README run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
