//! Axes: from values to places on the page.

/// Spread of values along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Evenly spaced.
    Linear {
        /// Least value.
        low: f64,
        /// Largest value.
        high: f64,
    },
    /// Logarithmic; both ends are above 0.
    Log {
        /// Least value.
        low: f64,
        /// Largest value.
        high: f64,
    },
    /// Shares of a distribution, 0 to 1. Each nine of the tail takes the same room: 90 %, 99 %, 99.9 %.
    Percentile { nines: u32 },
}

/// Text form of an axis's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Number,
    /// A whole number.
    Count,
    /// A duration in µs with the unit that reads best.
    DurationUs,
    Percent,
}

/// One axis.
///
/// ```
/// use report::chart::Axis;
///
/// let speed = Axis::holding("m/s", [3.0, 17.3].into_iter());
/// assert_eq!((speed.share(0.0), speed.share(20.0)), (0.0, 1.0));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity, with its unit.
    pub label: String,
    /// Spread of the values.
    pub scale: Scale,
    /// Text form of the values.
    pub format: Format,
}

impl Axis {
    pub fn time(until_s: f64) -> Self {
        Self::linear("time, s", 0.0, until_s.max(1e-3))
    }

    pub fn linear(label: &str, low: f64, high: f64) -> Self {
        let scale = Scale::Linear { low, high };
        Self { label: label.into(), scale, format: Format::Number }
    }

    /// A linear axis that holds all of `values`, widened to whole ticks; never empty. It reaches below 0 only
    /// where a value does.
    pub fn holding(label: &str, values: impl Iterator<Item = f64>) -> Self {
        let (mut low, mut high) = bounds(values).unwrap_or((0.0, 1.0));
        if high - low < 1e-6 * high.abs().max(1.0) {
            let least = if low >= 0.0 { 0.0 } else { f64::NEG_INFINITY };
            (low, high) = ((low - 0.5).max(least), high + 0.5);
        }
        let step = nice_step(high - low, 5);
        Self::linear(label, (low / step).floor() * step, (high / step).ceil() * step)
    }

    pub fn counts(label: &str, values: impl Iterator<Item = f64>) -> Self {
        let high = bounds(values).map_or(1.0, |(_, high)| high);
        let step = nice_step(high.max(5.0), 5).max(1.0);
        Self::whole(label, 0.0, (high.max(5.0) / step).ceil() * step)
    }

    pub fn whole(label: &str, low: f64, high: f64) -> Self {
        Self { format: Format::Count, ..Self::linear(label, low, high) }
    }

    /// Durations in µs over whole or half decades.
    pub fn durations(label: &str, values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = bounds(values.filter(|us| *us > 0.0)).unwrap_or((1.0, 10.0));
        let low = 10_f64.powf((low.log10() * 2.0).floor() / 2.0);
        let high = 10_f64.powf((high.log10() * 2.0 + 1e-9).ceil() / 2.0).max(low * 10.0);
        let scale = Scale::Log { low, high };
        Self { label: label.into(), scale, format: Format::DurationUs }
    }

    /// Frequencies from `low` to `high`, both above 0, on a logarithmic scale.
    pub fn frequencies(unit: &str, low: f64, high: f64) -> Self {
        let scale = Scale::Log { low, high: high.max(low * 1.1) };
        Self { label: format!("frequency, {unit}"), scale, format: Format::Number }
    }

    /// Shares of a distribution of `count` samples.
    pub fn percentiles(label: &str, count: u64) -> Self {
        let nines = (2.0 * count.max(1) as f64).log10().ceil().clamp(2.0, 6.0) as u32;
        let scale = Scale::Percentile { nines };
        Self { label: label.into(), scale, format: Format::Percent }
    }

    /// Place of a value: 0 to 1 inside the axis.
    pub fn share(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear { low, high } => (value - low) / (high - low),
            Scale::Log { low, high } => {
                (value.max(low).log10() - low.log10()) / (high.log10() - low.log10())
            }
            Scale::Percentile { nines } => {
                let nines = f64::from(nines);
                (-(1.0 - value).max(10_f64.powf(-nines)).log10() / nines).clamp(0.0, 1.0)
            }
        }
    }
}

/// A number with a true minus sign; zero has no sign.
///
/// ```
/// assert_eq!(report::chart::number(-4.89, 1), "−4.9");
/// ```
pub fn number(value: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", value.abs());
    let zero = text.bytes().all(|byte| matches!(byte, b'0' | b'.'));
    if value < 0.0 && !zero { format!("−{text}") } else { text }
}

/// Least and largest finite value.
pub(super) fn bounds(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |bounds, value| match bounds {
        None => Some((value, value)),
        Some((low, high)) => Some((value.min(low), value.max(high))),
    })
}

/// The least of 1, 2 or 5 times a power of ten that divides `range` into at most `most` parts.
fn nice_step(range: f64, most: usize) -> f64 {
    let rough = range / most.max(1) as f64;
    let power = 10_f64.powf(rough.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .map(|digit| digit * power)
        .into_iter()
        .find(|step| *step >= rough * 0.999)
        .unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_holds_its_values_even_when_there_is_one_or_no_value() {
        for values in [vec![], vec![3.0], vec![f64::NAN, -2.0, 17.3], vec![1e-9, 2e-9]] {
            let axis = Axis::holding("", values.iter().copied());
            for value in values.iter().filter(|value| value.is_finite()) {
                let share = axis.share(*value);
                assert!((-1e-9..=1.0 + 1e-9).contains(&share), "{axis:?} {value}");
            }
            assert!(matches!(axis.scale, Scale::Linear { low, high } if low < high), "{axis:?}");
        }
    }

    #[test]
    fn a_count_begins_at_zero_and_durations_reach_over_decades() {
        for values in [vec![], vec![0.0, 0.0], vec![3.0], vec![0.0, 17.0], vec![1200.0]] {
            let axis = Axis::counts("", values.iter().copied());
            assert!(matches!(axis.scale, Scale::Linear { low: 0.0, .. }), "{axis:?}");
            assert!(values.iter().all(|value| axis.share(*value) <= 1.0), "{axis:?}");
        }
        let axis = Axis::durations("", [30.0, 12_000.0].into_iter());
        assert!(axis.share(30.0) >= 0.0 && axis.share(12_000.0) <= 1.0);
    }

    #[test]
    fn each_nine_takes_the_same_room() {
        let axis = Axis::percentiles("", 1_000);
        let nine = axis.share(0.9);
        assert!((axis.share(0.99) - 2.0 * nine).abs() < 1e-9);
        assert!((axis.share(1.0) - 1.0).abs() < 1e-9 && axis.share(0.0) == 0.0);
    }

    #[test]
    fn numbers_have_a_minus_and_no_negative_zero() {
        assert_eq!(number(-4.89, 1), "−4.9");
        assert_eq!(number(-0.01, 1), "0.0");
    }
}
