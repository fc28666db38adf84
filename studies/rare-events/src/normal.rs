//! The standard normal distribution.

use std::f64::consts::FRAC_1_SQRT_2;

/// Distribution function.
///
/// ```
/// assert!((rare_events::normal::cdf(1.0) - 0.841344746068543).abs() < 1e-15);
/// ```
pub fn cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::cdf;

    /// Abramowitz and Stegun, table 26.1.
    #[test]
    fn the_distribution_function_is_that_of_the_table() {
        assert!((cdf(1.0) - 0.841344746068543).abs() < 1e-15);
        assert!((cdf(-5.0) / 2.866515718791939e-7 - 1.0).abs() < 1e-12);
        assert!((cdf(1.959963984540054) - 0.975).abs() < 1e-14);
    }
}
