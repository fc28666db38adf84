//! Expected improvement.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Expected amount by which a normal value is below `target`.
///
/// ```
/// use gaussian_process::expected_improvement;
///
/// assert_eq!(expected_improvement((1.0, 0.0), 3.0), 2.0, "a certain value");
/// let even = expected_improvement((0.0, 1.0), 0.0);
/// assert!((even - 0.398_942_280_4).abs() < 1e-9, "half of the mean deviation");
/// ```
pub fn expected_improvement((mean, variance): (f64, f64), target: f64) -> f64 {
    let (gain, deviation) = (target - mean, variance.sqrt());
    if deviation <= 1e-12 {
        return gain.max(0.0);
    }
    let z = gain / deviation;
    let density = libm::exp(-0.5 * z * z) / TAU.sqrt();
    let below = 0.5 * libm::erfc(-z * FRAC_1_SQRT_2);
    (gain * below + deviation * density).max(0.0)
}
