//! Distributions of a variable.

use crate::normal;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// The distribution of a variable.
///
/// ```
/// use rare_events::Distribution;
///
/// let headway: Distribution = "lognormal(1.4, 0.35)".parse()?;
/// assert_eq!(headway.at(0.0), 1.4, "the first number is the median");
/// assert!("normal(1)".parse::<Distribution>().is_err());
/// # Ok::<(), rare_events::DistributionError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Distribution {
    Normal {
        mean: f64,
        deviation: f64,
    },
    /// The logarithm is normal.
    LogNormal {
        median: f64,
        /// Standard deviation of the natural logarithm.
        log_deviation: f64,
    },
    /// Even over an interval.
    Uniform {
        /// Least value.
        from: f64,
        /// Largest value.
        to: f64,
    },
    /// Measured values, between which the distribution function is a straight line.
    Empirical(Vec<f64>),
}

/// A text or values that make no distribution.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DistributionError {
    /// Another form.
    #[error(
        "`{0}` is not a distribution, expected normal(MEAN, DEVIATION), lognormal(MEDIAN, LOG_DEVIATION), uniform(FROM, TO) or csv(FILE, COLUMN)"
    )]
    Form(String),
    /// A number that the distribution cannot have.
    #[error("{name} = {value}, expected {expected}")]
    Number { name: &'static str, value: f64, expected: &'static str },
    /// Too few measured values.
    #[error("{0} different values, expected 10 or more")]
    Few(usize),
}

/// Least number of different measured values: fewer show nothing of a tail.
const LEAST_VALUES: usize = 10;

impl Distribution {
    /// The distribution of measured values.
    ///
    /// # Errors
    /// [`DistributionError::Few`]; [`DistributionError::Number`] for a value that is not finite.
    pub fn empirical(mut values: Vec<f64>) -> Result<Self, DistributionError> {
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            let (name, expected) = ("value", "a finite number");
            return Err(DistributionError::Number { name, value: *value, expected });
        }
        values.sort_by(f64::total_cmp);
        let different = values.windows(2).filter(|pair| pair[0] < pair[1]).count() + 1;
        if values.is_empty() || different < LEAST_VALUES {
            return Err(DistributionError::Few(if values.is_empty() { 0 } else { different }));
        }
        Ok(Self::Empirical(values))
    }

    /// The value at a standard normal coordinate: the quantile of its distribution function.
    pub fn at(&self, z: f64) -> f64 {
        match self {
            Self::Normal { mean, deviation } => mean + deviation * z,
            Self::LogNormal { median, log_deviation } => median * libm::exp(log_deviation * z),
            Self::Uniform { from, to } => from + (to - from) * normal::cdf(z),
            Self::Empirical(values) => {
                let place = normal::cdf(z) * (values.len() - 1) as f64;
                let below = (place as usize).min(values.len() - 2);
                let share = place - below as f64;
                values[below] + share * (values[below + 1] - values[below])
            }
        }
    }

    fn check(self) -> Result<Self, DistributionError> {
        let wrong =
            |name, value, expected| Err(DistributionError::Number { name, value, expected });
        match self {
            Self::Normal { deviation, .. } if deviation <= 0.0 => {
                wrong("DEVIATION", deviation, "a number above 0")
            }
            Self::LogNormal { median, .. } if median <= 0.0 => {
                wrong("MEDIAN", median, "a number above 0")
            }
            Self::LogNormal { log_deviation, .. } if log_deviation <= 0.0 => {
                wrong("LOG_DEVIATION", log_deviation, "a number above 0")
            }
            Self::Uniform { from, to } if from >= to => wrong("FROM", from, "less than TO"),
            right => Ok(right),
        }
    }
}

impl FromStr for Distribution {
    type Err = DistributionError;

    /// Reads the forms with two numbers. The caller that has its folder reads a CSV file.
    fn from_str(text: &str) -> Result<Self, DistributionError> {
        let form = || DistributionError::Form(text.trim().to_owned());
        let (name, rest) = text.trim().split_once('(').ok_or_else(form)?;
        let (a, b) =
            rest.strip_suffix(')').and_then(|rest| rest.split_once(',')).ok_or_else(form)?;
        let number = |text: &str| {
            let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(form)
        };
        match name.trim() {
            "normal" => Self::Normal { mean: number(a)?, deviation: number(b)? }.check(),
            "lognormal" => {
                Self::LogNormal { median: number(a)?, log_deviation: number(b)? }.check()
            }
            "uniform" => Self::Uniform { from: number(a)?, to: number(b)? }.check(),
            _ => Err(form()),
        }
    }
}

impl fmt::Display for Distribution {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Normal { mean, deviation } => write!(f, "normal({mean}, {deviation})"),
            Self::LogNormal { median, log_deviation } => {
                write!(f, "lognormal({median}, {log_deviation})")
            }
            Self::Uniform { from, to } => write!(f, "uniform({from}, {to})"),
            Self::Empirical(values) => {
                let (least, most) = (values[0], values[values.len() - 1]);
                write!(f, "{} measured values from {least} to {most}", values.len())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_textbook() {
        let at = |text: &str, z: f64| text.parse::<Distribution>().expect(text).at(z);
        assert_eq!(at("normal(10, 2)", -1.5), 7.0);
        assert!((at("lognormal(2, 0.5)", 2.0) - 2.0 * std::f64::consts::E).abs() < 1e-12);
        assert_eq!(at(" uniform( -1 , 3 ) ", 0.0), 1.0);
        let measured = Distribution::empirical((0..=10).rev().map(f64::from).collect());
        let measured = measured.expect("eleven values");
        assert_eq!(measured.at(0.0), 5.0);
        assert!((measured.at(-0.674_489_750_196_081_7) - 2.5).abs() < 1e-12);
        assert_eq!((measured.at(-40.0), measured.at(40.0)), (0.0, 10.0));
    }

    #[test]
    fn bad_distributions_are_refused() {
        for (text, what) in [
            ("normal(1)", "is not a distribution"),
            ("weibull(1, 2)", "expected normal("),
            ("normal(1, x)", "is not a distribution"),
            ("normal(1, 0)", "DEVIATION = 0"),
            ("lognormal(-1, 2)", "MEDIAN = -1"),
            ("uniform(3, 3)", "less than TO"),
        ] {
            let said = text.parse::<Distribution>().expect_err(text).to_string();
            assert!(said.contains(what), "{said}");
        }
        assert_eq!(Distribution::empirical(vec![1.0; 50]), Err(DistributionError::Few(1)));
        assert!(Distribution::empirical(vec![f64::NAN; 50]).is_err());
    }
}
