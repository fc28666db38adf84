//! The solvers by name, for configuration.

use crate::clarabel::Clarabel;
use crate::riccati::Riccati;
use crate::solver::Solver;

/// The solvers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// [`Riccati`], named `riccati`.
    #[default]
    Riccati,
    /// [`Clarabel`], named `clarabel`.
    Clarabel,
}

/// A name that no solver has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the solver must be `riccati` or `clarabel`")]
pub struct UnknownSolver;

impl Kind {
    /// A solver of this kind for horizons up to `max_horizon`, at its default tolerance.
    pub fn create(self, max_horizon: usize) -> Box<dyn Solver + Send> {
        match self {
            Self::Riccati => Box::new(Riccati::new(max_horizon)),
            Self::Clarabel => Box::new(Clarabel::new()),
        }
    }
}

impl std::str::FromStr for Kind {
    type Err = UnknownSolver;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "riccati" => Ok(Self::Riccati),
            "clarabel" => Ok(Self::Clarabel),
            _ => Err(UnknownSolver),
        }
    }
}
