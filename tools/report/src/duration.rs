//! Times as text.

use runtime::statistics::Percentiles;

/// True if `count` samples carry the percentile of `share`: one of them at least is expected beyond it.
///
/// ```
/// use report::print::carries;
///
/// assert!(carries(100, 0.99) && !carries(99, 0.99));
/// ```
pub fn carries(count: u64, share: f64) -> bool {
    // Rounded: 100 * (1 - 0.99) is a little more than 1 in binary.
    (count as f64 * (1.0 - share) * 1e6).round() >= 1e6
}

/// The 99th percentile where the samples carry it, in µs.
pub fn p99(p: &Percentiles) -> Option<f64> {
    carries(p.count, 0.99).then_some(p.p99)
}

/// A duration in µs with the unit that reads best.
///
/// ```
/// assert_eq!(report::print::duration(1_234.0), "1.23 ms");
/// ```
pub fn duration(us: f64) -> String {
    if us < 1e3 {
        format!("{us:.1} µs")
    } else if us < 1e6 {
        format!("{:.2} ms", us / 1e3)
    } else {
        format!("{:.2} s", us / 1e6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_choose_their_unit() {
        assert_eq!(duration(12.34), "12.3 µs");
        assert_eq!(duration(1234.0), "1.23 ms");
        assert_eq!(duration(2_500_000.0), "2.50 s");
    }
}
