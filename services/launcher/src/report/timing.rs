//! Pictures and tables of time: the latency of each hop, its percentiles.

use super::chart::{Axis, Curve, Plot, Stroke, Tone};
use super::html::{Column, stacked_table};
use super::picture::RunPicture;
use crate::summary::Summary;
use shared::report::ChainCurves;
use shared::statistics::{Percentiles, QuantileCurve};

/// Distributions of the chain's hops on a logarithmic axis; none without samples.
pub fn latencies(run: &RunPicture, count: u64) -> Option<Plot> {
    let ChainCurves { reaction_time, radar_to_controller, controller_compute, controller_to_plant } =
        &run.latencies;
    let hops = [
        ("reaction time", Tone::Series(0), Stroke::Solid, reaction_time),
        ("radar to controller", Tone::Series(1), Stroke::Solid, radar_to_controller),
        ("controller", Tone::Series(2), Stroke::Dashed, controller_compute),
        ("controller to plant", Tone::Series(3), Stroke::Solid, controller_to_plant),
    ];
    let values = hops.iter().flat_map(|hop| hop.3).map(|point| point.1);
    let x = Axis::durations("latency", values);
    let curves: Vec<_> = hops
        .iter()
        .filter(|hop| hop.3.iter().any(|point| point.1 > 0.0))
        .map(|(name, tone, stroke, curve)| {
            Curve::new(name, *tone, distribution(curve, count)).stroke(*stroke)
        })
        .collect();
    (!curves.is_empty()).then(|| Plot {
        title: format!("Latency of each hop (n = {count})"),
        x,
        y: Axis::percentiles("share of the samples at or below", count),
        height: 300.0,
        strips: Vec::new(),
        curves,
        marks: Vec::new(),
        more_keys: Vec::new(),
    })
}

/// A quantile curve as points (latency, share). The largest of n samples stands at 1 - 1/2n: nobody
/// knows where the distribution ends.
fn distribution(curve: &QuantileCurve, count: u64) -> Vec<(f64, f64)> {
    let last = 1.0 - 0.5 / count.max(1) as f64;
    let first = curve.first().map(|point| (point.1, 0.0));
    first.into_iter().chain(curve.iter().map(|(share, us)| (*us, share.min(last)))).collect()
}

/// Percentiles of everything that was timed; empty where nothing was.
pub fn percentiles(summary: &Summary) -> String {
    let timing = &summary.timing;
    let hops = &timing.hops_us;
    let rows: Vec<Vec<String>> = [
        ("Reaction time, radar to first actuation", timing.reaction_time_us),
        ("… radar to start of the control cycle", hops.radar_to_controller),
        ("… control cycle to its command", hops.controller_compute),
        ("… command to actuation", hops.controller_to_plant),
        ("Data age at every actuation", timing.data_age_us),
        ("Release jitter of the controller", timing.release_jitter_us),
        ("The law alone", timing.solve_us),
    ]
    .into_iter()
    // In simulated time, what takes none says nothing.
    .filter_map(|(name, percentiles)| Some((name, percentiles.filter(|p| p.max > 0.0)?)))
    .map(|(name, percentiles)| row(name, &percentiles))
    .collect();
    if rows.is_empty() {
        return String::new();
    }
    stacked_table(
        &[
            ("", Column::Text),
            ("median", Column::Number),
            ("90 %", Column::MoreNumber),
            ("99 %", Column::Number),
            ("99.9 %", Column::MoreNumber),
            ("99.99 %", Column::MoreNumber),
            ("max", Column::Number),
            ("samples", Column::Number),
        ],
        &rows,
    )
}

/// A percentile that so few samples cannot tell from the maximum is a dash.
fn row(name: &str, p: &Percentiles) -> Vec<String> {
    let known = |nine_in: u64, us: f64| {
        if p.count >= nine_in { crate::print::duration(us) } else { "–".to_owned() }
    };
    vec![
        name.to_owned(),
        known(2, p.p50),
        known(10, p.p90),
        known(100, p.p99),
        known(1_000, p.p999),
        known(10_000, p.p9999),
        crate::print::duration(p.max),
        p.count.to_string(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_without_samples_behind_it_is_a_dash() {
        let p = Percentiles {
            p50: 1.0,
            p90: 2.0,
            p99: 3.0,
            p999: 3.0,
            p9999: 3.0,
            max: 3.0,
            count: 100,
        };
        let row = row("x", &p);
        assert_eq!(row[3], "3.0 µs");
        assert_eq!((row[4].as_str(), row[5].as_str(), row[7].as_str()), ("–", "–", "100"));
    }

    #[test]
    fn the_largest_sample_is_not_the_end_of_the_distribution() {
        let points = distribution(&vec![(0.0, 1.0), (0.5, 2.0), (1.0, 9.0)], 100);
        assert_eq!(points.first(), Some(&(1.0, 0.0)));
        assert_eq!(points.last(), Some(&(9.0, 0.995)));
        assert!(latencies(&RunPicture::default(), 0).is_none());
    }
}
