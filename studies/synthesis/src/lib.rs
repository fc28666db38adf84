//! Synthesis from parameters to a certified design of the law `quadratic-bounded`, by semidefinite programming.
//!
//! The law verifies each design that it loads; it does not need this crate. The crate is empty without the feature
//! `openblas`, since its solver needs that library. `timegap synthesize` runs it.
//!
//! ```text
//! DesignRequest (TOML) ──► line search over alpha ──► semidefinite program ──► Design, verified
//! ```
//!
//! Unknown are X, Y (symmetric, 4 by 4), per rule Ah_i, Bh_i, Ch_i, Dh_i, and multipliers a, b >= 0. alpha and beta are
//! fixed in each solve. With Theta = [[X, I], [I, Y]] > 0 and everything scaled by its bound,
//!
//! ```text
//! minimise  sum weight_j X_jj + 1e-3 tr Y  subject to, for each rule i,
//! 1. [[(1 - alpha) Theta, 0, M_i'], [0, diag(a), G_i'], [M_i, G_i, Theta]] >= 0,  sum a <= alpha,
//!    M_i = [[A_i X + B Ch_i, A_i + B Dh_i C], [Ah_i, Y A_i + Bh_i C]],
//!    G_i = [[E + B Dh_i D], [Y E + Bh_i D]]
//! 2. z X z' <= 1 for every state and for both rows of the gap error rate
//! 3. [[(1 - beta) Theta, 0, c_i'], [0, diag(b), (Dh_i D)'], [c_i, Dh_i D, 1]] >= 0,  sum b <= beta,
//!    c_i = [Ch_i, Dh_i C]
//! 4. [[1, x0'], [x0, X]] >= 0 for every start state.
//! ```
//!
//! The gains follow from a factorisation U N' = I - X Y. The result is checked: the design passes the same verification
//! as one that is read from a file.
//!
//! Alpha, the rate at which the ellipsoid contracts, enters the problem nonlinearly. A line search comes down from the
//! greatest alpha and ends at the first one with a certified design.

#![cfg(feature = "openblas")]

mod program;

use controller::laws::quadratic_bounded::{Design, DesignError, Parameters, STATES};
use controller::settings::SettingError;
use program::Problem;
use serde::Deserialize;

/// Settings of the search.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// Least alpha tried.
    pub least_alpha: f64,
    /// Greatest alpha tried.
    pub greatest_alpha: f64,
    /// Number of alphas tried, equally spaced in the logarithm.
    pub alphas: usize,
    /// beta of the condition on the increment.
    pub beta: f64,
    /// Least eigenvalue asked of Theta and of condition 1, and room kept free at every scaled
    /// bound. So rounding cannot spoil the certificate.
    pub margin: f64,
    /// Weights of the four states' ellipsoid widths in the objective.
    pub weights: [f64; STATES],
    /// True if Fx and Fy may differ between the rules.
    pub rule_outputs: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            least_alpha: 0.005,
            greatest_alpha: 0.05,
            alphas: 13,
            beta: 0.1,
            margin: 1e-6,
            weights: [1.0; STATES],
            rule_outputs: false,
        }
    }
}

impl Options {
    fn validate(&self) -> Result<(), SettingError> {
        let ranges = [
            ("least_alpha", self.least_alpha, 1e-5, 0.9),
            ("greatest_alpha", self.greatest_alpha, self.least_alpha, 0.9),
            ("alphas", self.alphas as f64, 1.0, 100.0),
            ("beta", self.beta, 1e-3, 0.99),
            ("margin", self.margin, 1e-9, 1e-2),
        ];
        let weights = self.weights.map(|w| ("weights", w, 1e-6, 1e6));
        match ranges.into_iter().chain(weights).find(|(_, v, l, m)| !(*l..=*m).contains(v)) {
            Some((key, value, least, most)) => {
                Err(SettingError::OutOfRange { key, value, least, most })
            }
            None => Ok(()),
        }
    }

    /// The alphas of the line search, from the greatest down.
    fn grid(&self) -> impl Iterator<Item = f64> {
        let ratio = self.least_alpha / self.greatest_alpha;
        let steps = self.alphas.max(2) - 1;
        (0..self.alphas)
            .map(move |k| self.greatest_alpha * libm::pow(ratio, k as f64 / steps as f64))
    }
}

/// A parameter file: `[parameters]` and, optionally, `[search]`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DesignRequest {
    /// Purpose of the design.
    pub parameters: Parameters,
    /// Settings of the search.
    #[serde(default)]
    pub search: Options,
}

impl DesignRequest {
    /// Reads a parameter file (TOML).
    ///
    /// # Errors
    /// The parser's message, with line and caret.
    pub fn from_toml(text: &str) -> Result<Self, SynthesisError> {
        toml::from_str(text).map_err(|e| SynthesisError::Syntax(e.to_string()))
    }
}

/// One solve of the line search.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// alpha of this solve.
    pub alpha: f64,
    /// Objective of the certified design, or why there is none.
    pub outcome: Result<f64, TrialFailure>,
    /// Iterations of the solver.
    pub iterations: u32,
}

/// Reason why an alpha gave no certified design.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TrialFailure {
    /// The solver ended without a solution; its status.
    #[error("{0}")]
    Unsolved(String),
    /// The design that the solution gave does not pass its verification.
    #[error(transparent)]
    Unverified(DesignError),
}

/// A certified design and how it was found.
#[derive(Clone, Debug)]
pub struct Synthesis {
    /// The certified design with the greatest alpha.
    pub design: Design,
    /// All solves, from the greatest alpha down; the last one gave the design.
    pub trials: Vec<Trial>,
}

/// Reason why there is no design.
#[derive(Clone, Debug, PartialEq)]
pub enum SynthesisError {
    /// The parameter file cannot be read.
    Syntax(String),
    /// A parameter or an option outside its range.
    Parameter(SettingError),
    /// No alpha gave a design that passes its verification.
    Infeasible(Vec<Trial>),
}

impl std::fmt::Display for SynthesisError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Syntax(what) => write!(f, "not a parameter file: {what}"),
            Self::Parameter(e) => e.fmt(f),
            Self::Infeasible(trials) => {
                write!(f, "no design meets these bounds; tried")?;
                for t in trials {
                    let Err(why) = &t.outcome else { continue };
                    write!(f, "\n  alpha {:.5}: {why}", t.alpha)?;
                }
                Ok(())
            }
        }
    }
}

impl std::error::Error for SynthesisError {}

/// Finds the certified design with the greatest alpha of the line search.
///
/// # Errors
/// A bad parameter, or what each alpha failed with.
pub fn synthesize(request: &DesignRequest) -> Result<Synthesis, SynthesisError> {
    request.parameters.check().map_err(SynthesisError::Parameter)?;
    request.search.validate().map_err(SynthesisError::Parameter)?;
    let mut trials = Vec::new();
    for alpha in request.search.grid() {
        let problem = Problem::new(&request.parameters, &request.search, alpha);
        let (solution, iterations) = problem.solve();
        let certified = solution.and_then(|(unknowns, objective)| {
            let design = problem.recover(&unknowns).map_err(TrialFailure::Unverified)?;
            Ok((objective, design))
        });
        match certified {
            Ok((objective, design)) => {
                trials.push(Trial { alpha, outcome: Ok(objective), iterations });
                return Ok(Synthesis { design, trials });
            }
            Err(why) => trials.push(Trial { alpha, outcome: Err(why), iterations }),
        }
    }
    Err(SynthesisError::Infeasible(trials))
}
