//! Gaussian processes: a function from a few values of it, with its uncertainty.
//!
//! ```text
//! y ~ N(0, K + n² I),   K_ij = s² k(r_ij),   k(r) = (1 + √5 r + 5/3 r²) exp(−√5 r)        (Matérn, ν = 5/2)
//! r² = Σ over numbers ((x − x') / l_d)² + Σ over words [x ≠ x'] / l_d²
//!
//! mean(x) = k(x)ᵀ (K + n² I)⁻¹ y,   variance(x) = s² − k(x)ᵀ (K + n² I)⁻¹ k(x)
//! ```
//!
//! | symbol | field | meaning |
//! | --- | --- | --- |
//! | `s` | [`Hyperparameters::signal`] | standard deviation of the function |
//! | `n` | [`Hyperparameters::noise`] | standard deviation of the noise |
//! | `l_d` | [`Hyperparameters::lengths`] | length over which coordinate d matters |
//! | `p_b` | [`Hyperparameters::parts`] | standard deviation of the part of word b of a branch |
//!
//! A [`Kind::Branch`] is a word that decides which numbers matter. Each of its words adds a part of its own to the
//! function, with numbers ([`Kind::Own`]) that only these parts read. The common part of all words is learnt from all
//! points, and a word without effect gets a small part.
//!
//! [`fit`] maximises the marginal likelihood of the values, with a weak prior on the lengths. A [`Process`] grows by
//! one point in O(n²): its Cholesky factor gains a row. [`Watched`] points are asked again and again meanwhile.
//! [`expected_improvement`] is the expected distance of a value below a target. The numbers are the same on every
//! x86-64. Transcendental functions are those of `libm` or the crate's own. Wide registers do the same operations in
//! the same order.
//!
//! Sources: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), chapters 2, 4 and 5. Jones,
//! Schonlau, Welch, Efficient Global Optimization of Expensive Black-Box Functions (1998), equation 15.
//!
//! ```
//! use gaussian_process::{Kind, Process, fit};
//!
//! let kinds = [Kind::Number];
//! let points: Vec<Vec<f64>> = (0..8).map(|k| vec![f64::from(k) / 7.0]).collect();
//! let values: Vec<f64> = points.iter().map(|x| (3.0 * x[0]).sin()).collect();
//! let parameters = fit(&kinds, &points, &values);
//! let process = Process::new(&kinds, parameters, points, values);
//! let (mean, variance) = process.predict(&[0.5]);
//! assert!((mean - 1.5_f64.sin()).abs() < 0.01 && variance < 0.01);
//! ```

#![forbid(unsafe_code)]

mod factor;
mod fit;
mod kernel;
mod lanes;
mod process;

pub use fit::fit;
pub use kernel::{Hyperparameters, Kind};
pub use process::{Process, Watched, expected_improvement};
