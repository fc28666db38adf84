//! Times as text.

use runtime::statistics::Percentiles;

/// Percentiles of a time in µs, on one line.
pub(crate) fn percentiles(p: &Percentiles) -> String {
    format!(
        "p50 {}, p99 {}, max {} (n = {})",
        duration(p.p50),
        duration(p.p99),
        duration(p.max),
        p.count
    )
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
