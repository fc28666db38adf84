//! Means with their spread, and intervals for the centre of paired differences.
//!
//! ```text
//! figures of law A over the seeds ─┬─► Spread: mean ± deviation, n
//! figures of law B over the seeds ─┴─► A - B, seed by seed ─► Interval: [low, high]
//! ```
//!
//! A mean over seeds means little without its spread. Two laws that met the same seeds are compared seed by seed. The
//! common effect of a seed then cancels in the difference.
//!
//! ```
//! let differences = [0.4, 0.1, 0.3, 0.2, 0.6, 0.3];
//! let interval = statistics::interval(&differences, 0.05).expect("six pairs are enough");
//! assert_eq!((interval.low, interval.high), (0.1, 0.6));
//! assert!(interval.leaves_out_zero());
//! ```

mod paired;
mod quantile;

pub use paired::{Interval, interval, least_pairs};
pub use quantile::{beta_quantile, poisson_interval, student_t};

/// The mean of some values with their spread.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// The mean; none without values.
    pub mean: Option<f64>,
    /// Standard deviation of a sample (n - 1 in the denominator); none of fewer than two values.
    pub deviation: Option<f64>,
    /// Number of values.
    pub n: usize,
}

impl Spread {
    /// The spread of `values`.
    ///
    /// ```
    /// let spread = statistics::Spread::of(&[1.0, 4.0]);
    /// assert_eq!((spread.mean, spread.n), (Some(2.5), 2));
    /// assert_eq!(spread.deviation, Some(4.5_f64.sqrt()));
    /// ```
    pub fn of(values: &[f64]) -> Self {
        let n = values.len();
        if n == 0 {
            return Self::default();
        }
        let mean = values.iter().sum::<f64>() / n as f64;
        let squares = values.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
        let deviation = (n > 1).then(|| (squares / (n - 1) as f64).sqrt());
        Self { mean: Some(mean), deviation, n }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_value_has_no_spread_and_no_value_no_mean() {
        assert_eq!(Spread::of(&[]), Spread::default());
        assert_eq!(Spread::of(&[3.0]), Spread { mean: Some(3.0), deviation: None, n: 1 });
    }
}
