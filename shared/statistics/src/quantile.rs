//! Quantiles and exact intervals, by bisection of `statrs`' distribution functions.
//!
//! Its own quantiles are wrong in the extremes: for 0 of 10⁶ trials they give the upper bound 3.68840e-6 in place of
//! 3.68887e-6. Its regularised incomplete beta and gamma functions are right.

use statrs::function::beta::beta_reg;
use statrs::function::gamma::gamma_lr;

/// Steps of a bisection: more than the digits of a double.
const HALVINGS: u32 = 200;

/// The x with I_x(a, b) = `share`, where I is the regularised incomplete beta function.
pub fn beta_quantile(a: f64, b: f64, share: f64) -> f64 {
    bisect(0.0, 1.0, |x| beta_reg(a, b, x) < share)
}

/// The t with probability `tails` outside ±t under Student's distribution of `degrees` of freedom.
///
/// ```
/// let t = statistics::student_t(4.0, 0.05);
/// assert!((t - 2.776).abs() < 1e-3);
/// ```
pub fn student_t(degrees: f64, tails: f64) -> f64 {
    let beyond = |t: f64| beta_reg(0.5 * degrees, 0.5, degrees / (degrees + t * t));
    bisect(0.0, 1e4, |t| beyond(t) > tails)
}

/// Exact two-sided interval of the mean of a Poisson count (Garwood, 1936), with probability `tails` outside it.
///
/// At a mean equal to the lower limit, `count` or more events have half of that probability. At the upper limit
/// `count` or fewer have it.
pub fn poisson_interval(count: u64, tails: f64) -> [f64; 2] {
    let events = count as f64;
    // `events` or more happen with the lower incomplete gamma function at (events, mean).
    let mean_at = |events: f64, share: f64| {
        bisect(0.0, events + 20.0 * events.sqrt() + 100.0, |mean| {
            mean <= 0.0 || gamma_lr(events, mean) < share
        })
    };
    let low = if count == 0 { 0.0 } else { mean_at(events, 0.5 * tails) };
    [low, mean_at(events + 1.0, 1.0 - 0.5 * tails)]
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
        // Published tables of Garwood's intervals.
        for (count, low, high) in [
            (0, 0.0, 3.689),
            (1, 0.0253, 5.572),
            (5, 1.623, 11.668),
            (10, 4.795, 18.390),
            (100, 81.36, 121.63),
        ] {
            let [found_low, found_high] = poisson_interval(count, 0.05);
            assert!((found_low - low).abs() < 0.01 * (1.0 + low), "{count}: {found_low}");
            assert!((found_high - high).abs() < 0.01 * (1.0 + high), "{count}: {found_high}");
        }
    }

    #[test]
    fn the_bound_of_no_event_in_a_million_has_all_of_its_digits() {
        // Clopper and Pearson: 1 - 0.025^(1/10⁶).
        let exact = -libm::expm1(libm::log(0.025) / 1e6);
        let found = beta_quantile(1.0, 1e6, 0.975);
        assert!((found / exact - 1.0).abs() < 1e-9, "{found}, exactly {exact}");
    }

    proptest! {
        #[test]
        fn a_quantile_is_the_inverse(a in 0.5..200.0, b in 0.5..200.0, share in 0.001..0.999) {
            let x = beta_quantile(a, b, share);
            prop_assert!((0.0..=1.0).contains(&x));
            prop_assert!((beta_reg(a, b, x) - share).abs() < 1e-8);
        }
    }
}
