//! Choice of a solver by name, for configuration.

#[cfg(feature = "clarabel")]
use crate::clarabel::Clarabel;
use crate::riccati::Riccati;
use crate::solver::Solver;

/// Kind of solver.
///
/// ```
/// use mpc_solver::Kind;
///
/// assert_eq!("riccati".parse(), Ok(Kind::Riccati));
/// assert!("simplex".parse::<Kind>().is_err());
/// let solver = Kind::Riccati.create(50);
/// assert!(solver.inputs().is_empty(), "nothing has been solved yet");
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kind {
    /// [`Riccati`], named `riccati`.
    #[default]
    Riccati,
    /// [`Clarabel`], named `clarabel`.
    #[cfg(feature = "clarabel")]
    Clarabel,
}

/// Error of a name that belongs to no solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the solver must be `riccati` or `clarabel`")]
pub struct UnknownSolver;

impl Kind {
    /// Returns a solver for horizons up to `max_horizon`, with its default tolerance.
    pub fn create(self, max_horizon: usize) -> Box<dyn Solver + Send> {
        match self {
            Self::Riccati => Box::new(Riccati::new(max_horizon)),
            #[cfg(feature = "clarabel")]
            Self::Clarabel => Box::new(Clarabel::new()),
        }
    }
}

impl std::str::FromStr for Kind {
    type Err = UnknownSolver;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "riccati" => Ok(Self::Riccati),
            #[cfg(feature = "clarabel")]
            "clarabel" => Ok(Self::Clarabel),
            _ => Err(UnknownSolver),
        }
    }
}
