//! Quantiles of Student's t and of the beta distribution, from the incomplete beta function.

/// Most terms of the continued fraction; it converges in far fewer.
const TERMS: u32 = 500;
/// Steps of a bisection: more than the digits of a double.
const HALVINGS: u32 = 200;

/// The regularised incomplete beta function I_x(a, b) for a, b > 0 and x in [0, 1]. Method: the
/// continued fraction of Lentz (DLMF 8.17.22).
pub fn incomplete_beta(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    // The fraction converges fast below the mean; above it the mirrored one is used.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(b, a, 1.0 - x);
    }
    let log_front = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b)
        + a * libm::log(x)
        + b * libm::log1p(-x);
    libm::exp(log_front) * fraction(a, b, x) / a
}

fn fraction(a: f64, b: f64, x: f64) -> f64 {
    const TINY: f64 = 1e-300;
    let away_from_zero = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut c = 1.0;
    let mut d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
    let mut result = d;
    for term in 1..=TERMS {
        let m = f64::from(term);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / away_from_zero(1.0 + even * d);
        c = away_from_zero(1.0 + even / c);
        result *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / away_from_zero(1.0 + odd * d);
        c = away_from_zero(1.0 + odd / c);
        result *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    result
}

/// The x with I_x(a, b) = `share`.
pub fn beta_quantile(a: f64, b: f64, share: f64) -> f64 {
    bisect(0.0, 1.0, |x| incomplete_beta(a, b, x) < share)
}

/// The t with probability `tails` outside ±t under Student's distribution of `degrees` of freedom.
pub fn student_t(degrees: f64, tails: f64) -> f64 {
    let beyond = |t: f64| incomplete_beta(0.5 * degrees, 0.5, degrees / (degrees + t * t));
    bisect(0.0, 1e4, |t| beyond(t) > tails)
}

/// The place between `low` and `high` where `below` turns from true to false.
fn bisect(mut low: f64, mut high: f64, below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if below(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn values_of_the_tables() {
        // Student's t, two-sided 5 %, from any table.
        for (degrees, t) in [(1.0, 12.706), (4.0, 2.776), (19.0, 2.093), (60.0, 2.000)] {
            assert!((student_t(degrees, 0.05) - t).abs() < 1e-3, "{degrees}");
        }
        // I_x(2, 3) = 6 x^2 - 8 x^3 + 3 x^4.
        let exact = |x: f64| 6.0 * x.powi(2) - 8.0 * x.powi(3) + 3.0 * x.powi(4);
        for x in [0.0, 0.1, 0.5, 0.9, 1.0] {
            assert!((incomplete_beta(2.0, 3.0, x) - exact(x)).abs() < 1e-12, "{x}");
        }
    }

    proptest! {
        #[test]
        fn a_quantile_is_the_inverse(a in 0.5..200.0, b in 0.5..200.0, share in 0.001..0.999) {
            let x = beta_quantile(a, b, share);
            prop_assert!((0.0..=1.0).contains(&x));
            prop_assert!((incomplete_beta(a, b, x) - share).abs() < 1e-8);
        }

        #[test]
        fn the_function_rises_and_mirrors(a in 0.5..100.0, b in 0.5..100.0, x in 0.0..1.0) {
            let here = incomplete_beta(a, b, x);
            prop_assert!((0.0..=1.0).contains(&here));
            prop_assert!(incomplete_beta(a, b, (x + 0.01).min(1.0)) >= here - 1e-12);
            prop_assert!((here + incomplete_beta(b, a, 1.0 - x) - 1.0).abs() < 1e-10);
        }
    }
}
