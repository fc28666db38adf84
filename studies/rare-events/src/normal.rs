//! The standard normal distribution.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Distribution function.
pub fn cdf(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

pub fn density(z: f64) -> f64 {
    libm::exp(-0.5 * z * z) / libm::sqrt(2.0 * PI)
}

/// Quantile of a share within (0, 1); infinite at its ends.
///
/// Acklam's rational approximation (2003) of a relative error of 1.15e-9, and one step of Halley's method.
///
/// ```
/// assert!((rare_events::normal::quantile(0.975) - 1.959963984540054).abs() < 1e-13);
/// ```
pub fn quantile(share: f64) -> f64 {
    if share <= 0.0 {
        return f64::NEG_INFINITY;
    }
    if share >= 1.0 {
        return f64::INFINITY;
    }
    // The upper half by symmetry: 1 - share is exact there.
    if share > 0.5 {
        return -quantile(1.0 - share);
    }
    let z = if share < LOW {
        let q = libm::sqrt(-2.0 * libm::log(share));
        polynomial(&C, q) / (polynomial(&D, q) * q + 1.0)
    } else {
        let q = share - 0.5;
        let r = q * q;
        q * polynomial(&A, r) / (polynomial(&B, r) * r + 1.0)
    };
    let error = (cdf(z) - share) / density(z);
    z - error / (1.0 + 0.5 * z * error)
}

/// Share below which the tail has an approximation of its own.
const LOW: f64 = 0.02425;
const A: [f64; 6] = [
    -3.969683028665376e1,
    2.209460984245205e2,
    -2.759285104469687e2,
    1.38357751867269e2,
    -3.066479806614716e1,
    2.506628277459239,
];
const B: [f64; 5] = [
    -5.447609879822406e1,
    1.615858368580409e2,
    -1.556989798598866e2,
    6.680131188771972e1,
    -1.328068155288572e1,
];
const C: [f64; 6] = [
    -7.784894002430293e-3,
    -3.223964580411365e-1,
    -2.400758277161838,
    -2.549732539343734,
    4.374664141464968,
    2.938163982698783,
];
const D: [f64; 4] =
    [7.784695709041462e-3, 3.224671290700398e-1, 2.445134137142996, 3.754408661907416];

/// A polynomial by its coefficients, highest power first.
fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantile_and_distribution_function_undo_each_other() {
        for share in [1e-300, 1e-12, 1e-6, 0.01, 0.02425, 0.3, 0.5] {
            let z = quantile(share);
            assert!((cdf(z) / share - 1.0).abs() < 1e-9, "{share}: {z}");
            if share > 1e-12 {
                assert!((quantile(1.0 - share) + z).abs() < 1e-6, "{share}");
            }
        }
        // Abramowitz and Stegun, table 26.1.
        assert!((cdf(1.0) - 0.841344746068543).abs() < 1e-15);
        assert!((cdf(-5.0) / 2.866515718791939e-7 - 1.0).abs() < 1e-12);
        assert_eq!((quantile(0.0), quantile(1.0)), (f64::NEG_INFINITY, f64::INFINITY));
    }
}
