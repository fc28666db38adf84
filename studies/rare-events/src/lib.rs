//! Probabilities of rare events: how often a value is below 0 when its inputs follow given distributions.
//!
//! ```text
//! p = P(g(x) < 0),   x_i = F_i⁻¹(Φ(z_i)),   z = L u,   u ~ N(0, I)
//! ```
//!
//! | symbol | here |
//! |---|---|
//! | g | the caller's function: a drive's margin, for instance |
//! | F_i | [`Distribution`] of a variable |
//! | L | factor of the [`Copula`], from correlations of ranks |
//! | u | a point: independent standard normal coordinates, in which all estimators work |
//!
//! * [`monte_carlo`]: points as they come, with Wilson's interval. It needs some 100 / p runs, and no assumption on g.
//! * [`cross_entropy`]: importance sampling from a normal density that is fitted to the event, in independent replicas.
//!   Its interval is the scatter of the replicas. One replica does not notice a part of the event that it misses.
//! * [`disagree`]: whether two results contradict each other. Monte Carlo has the last word on a fit.
//! * [`sobol`]: which variable explains the variance of g, alone and with others.
//!
//! ```
//! use rare_events::{Budget, cross_entropy, normal};
//!
//! // A sum of two variables exceeds 4 standard deviations: 3.2e-5.
//! let mut sum = |u: &[f64]| -> Result<f64, ()> { Ok(4.0 * 2_f64.sqrt() - u[0] - u[1]) };
//! let found = cross_entropy(2, Budget { runs: 10_000, seed: 1 }, &mut sum).unwrap();
//! let exact = normal::cdf(-4.0);
//! assert!((found.probability / exact - 1.0).abs() < 0.3, "{found:?}");
//! ```

#![forbid(unsafe_code)]

mod copula;
mod cross_entropy;
mod distribution;
mod estimate;
mod factor;
mod gaussian;
mod monte_carlo;
pub mod normal;
mod smoothing;
pub mod sobol;

pub use copula::{Copula, CopulaError};
pub use cross_entropy::{cross_entropy, replica};
pub use distribution::{Distribution, DistributionError};
pub use estimate::{Budget, Estimate, REPLICAS, Replica, disagree, wilson};
pub use monte_carlo::{ENOUGH_EVENTS, monte_carlo, point};

/// The value at a point, below 0 in the event. It may fail.
pub trait Limit<E>: FnMut(&[f64]) -> Result<f64, E> {}

impl<E, F: FnMut(&[f64]) -> Result<f64, E>> Limit<E> for F {}
