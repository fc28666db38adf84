//! Rates of rare events with their intervals.

/// Confidence that each limit leaves out on its side.
const ONE_SIDE: f64 = 0.025;

/// Exact two-sided 95 % interval of a Poisson count's mean (Garwood, 1936).
///
/// At a mean equal to the lower limit, `count` or more events have the probability 2.5 %. At the upper limit `count` or
/// fewer have it.
pub fn poisson(count: u64) -> [f64; 2] {
    let low = if count == 0 { 0.0 } else { mean_at(count - 1, 1.0 - ONE_SIDE) };
    [low, mean_at(count, ONE_SIDE)]
}

/// The mean at which `count` or fewer events have this probability.
fn mean_at(count: u64, probability: f64) -> f64 {
    let count = count as f64;
    let (mut low, mut high) = (0.0, count + 10.0 * libm::sqrt(count + 1.0) + 10.0);
    // Bisection: 80 halvings are finer than a double's digits.
    for _ in 0..80 {
        let mean = 0.5 * (low + high);
        if at_most(count, mean) > probability { low = mean } else { high = mean }
    }
    0.5 * (low + high)
}

/// The probability of at most `count` events.
fn at_most(count: f64, mean: f64) -> f64 {
    let mut logarithm = -mean;
    let mut sum = libm::exp(logarithm);
    let mut events = 1.0;
    while events <= count {
        logarithm += libm::log(mean / events);
        sum += libm::exp(logarithm);
        events += 1.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Limits from published tables of Garwood's intervals.
    #[test]
    fn intervals_are_those_of_the_tables() {
        for (count, low, high) in [
            (0, 0.0, 3.689),
            (1, 0.0253, 5.572),
            (5, 1.623, 11.668),
            (10, 4.795, 18.390),
            (100, 81.36, 121.63),
        ] {
            let [found_low, found_high] = poisson(count);
            assert!((found_low - low).abs() < 0.01 * (1.0 + low), "{count}: {found_low}");
            assert!((found_high - high).abs() < 0.01 * (1.0 + high), "{count}: {found_high}");
        }
    }
}
