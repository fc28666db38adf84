//! Charts of time: latency of each hop, longest chains.

use super::chart::{Axis, Bands, Curve, Plot, Row, Span, Stroke, Tone};
use super::picture::RunPicture;
use crate::print::duration;
use runtime::statistics::{Latencies, QuantileCurve};
use supervise::report::{Parts, WorstChain};

/// Chains drawn as timelines; the table has all.
const DRAWN_CHAINS: usize = 5;

/// The hops in order of time: name of the figure, name for readers, colour. Waits are dotted, work is dashed,
/// transport is solid.
const HOPS: [(&str, &str, Tone, Stroke); 7] = [
    ("radar_publish", "radar publishes", Tone::Series(1), Stroke::Dashed),
    ("controller_queue", "waits for the controller", Tone::Series(4), Stroke::Dotted),
    ("radar_transport", "controller wakes", Tone::Series(2), Stroke::Solid),
    ("controller_compute", "controller computes", Tone::Series(3), Stroke::Dashed),
    ("command_wait", "waits for the plant", Tone::Muted, Stroke::Dotted),
    ("command_transport", "plant wakes", Tone::Series(6), Stroke::Solid),
    ("actuate", "plant actuates", Tone::Series(5), Stroke::Dashed),
];

/// Distributions of the chain's hops on a logarithmic axis; `None` without samples.
pub fn latencies(run: &RunPicture, count: u64) -> Option<Plot> {
    let whole = [
        ("reaction_time", "reaction time", Tone::Series(0), Stroke::Solid),
        ("net_reaction", "software overhead", Tone::Series(7), Stroke::Dashed),
    ];
    let drawn = whole.iter().chain(&HOPS).filter_map(|(figure, name, tone, stroke)| {
        let curve = run.latencies.get(*figure)?;
        let points = distribution(curve, count);
        let name = format!("{name}{}", zeros(curve));
        (!points.is_empty()).then(|| Curve::new(&name, *tone, points).stroke(*stroke))
    });
    cumulative(&format!("Latency of each hop (n = {count})"), count, drawn.collect())
}

pub struct Distribution<'a> {
    /// Name for the legend.
    pub label: String,
    pub tone: Tone,
    pub stroke: Stroke,
    pub latencies: &'a Latencies,
}

/// Several distributions in one chart; `None` without samples.
pub fn distributions(title: &str, drawn: &[Distribution<'_>]) -> Option<Plot> {
    let most = drawn.iter().map(|drawn| drawn.latencies.count()).max()?;
    let drawn = drawn.iter().filter(|drawn| drawn.latencies.count() > 0);
    let curves = drawn.map(|drawn| {
        let latencies = drawn.latencies;
        let curve = latencies.quantile_curve();
        let label = format!("{}{}", drawn.label, zeros(&curve));
        let points = distribution(&curve, latencies.count());
        Curve::new(&label, drawn.tone, points).stroke(drawn.stroke)
    });
    cumulative(title, most, curves.collect())
}

fn cumulative(title: &str, count: u64, drawn: Vec<Curve>) -> Option<Plot> {
    let x = Axis::durations("latency", drawn.iter().flat_map(|c| &c.points).map(|p| p.0));
    (!drawn.is_empty()).then(|| Plot {
        y: Axis::percentiles("share of the samples at or below", count),
        height: 320.0,
        ..Plot::over(title, x, "", drawn)
    })
}

/// The longest chains as timelines; `None` without chains.
pub fn worst_chains(chains: &[WorstChain]) -> Option<Bands> {
    let rows: Vec<_> = chains
        .iter()
        .take(DRAWN_CHAINS)
        .map(|chain| {
            let (reaction, waited) = (chain.reaction_time_us, chain.hops_us.command_wait);
            let (reaction, waited) = (duration(reaction), duration(waited));
            let name = format!("{reaction} until {:.3} s, waited {waited}", chain.t_s);
            Row { name, spans: spans(&chain.hops_us) }
        })
        .collect();
    let ends = rows.iter().filter_map(|row| row.spans.last()).map(|span| span.to);
    let longest = ends.fold(0.0, f64::max);
    Some(Bands {
        title: "The longest chains, without the wait for the plant's release".into(),
        x: Axis::linear("ms from radar to actuation", 0.0, longest.max(1e-3)),
        rows,
        marks: Vec::new(),
    })
}

/// Parts of a chain one after the other, ms. Parts without length are left out. So is the wait for the plant:
/// it is part of the design and longer than all else.
fn spans(hops: &Parts<f64>) -> Vec<Span> {
    let command_wait = 0.0;
    let lengths_us = [
        hops.radar_publish,
        hops.controller_queue,
        hops.radar_transport,
        hops.controller_compute,
        command_wait,
        hops.command_transport,
        hops.actuate,
    ];
    let mut from = 0.0;
    let mut spans = Vec::new();
    for ((_, label, tone, _), length_us) in HOPS.iter().zip(lengths_us) {
        let to = from + length_us / 1e3;
        if length_us > 0.0 {
            spans.push(Span { from, to, label: (*label).to_owned(), tone: *tone });
        }
        from = to;
    }
    spans
}

/// A quantile curve as points (latency, share). The largest of n samples is drawn at 1 - 1/2n, since samples
/// do not show the end of the distribution. A logarithmic axis cannot show zeros: the curve begins above their
/// share.
fn distribution(curve: &QuantileCurve, count: u64) -> Vec<(f64, f64)> {
    let last = 1.0 - 0.5 / count.max(1) as f64;
    let positive = || curve.iter().filter(|point| point.1 > 0.0);
    let first = positive().next().map(|point| (point.1, zero_share(curve)));
    first.into_iter().chain(positive().map(|(share, us)| (*us, share.min(last)))).collect()
}

/// Share of the samples that took no time.
fn zero_share(curve: &QuantileCurve) -> f64 {
    curve.iter().filter(|point| point.1 <= 0.0).map(|point| point.0).fold(0.0, f64::max)
}

/// Note for the legend about samples that a logarithmic axis cannot show.
fn zeros(curve: &QuantileCurve) -> String {
    match 100.0 * zero_share(curve) {
        percent if percent > 0.0 => format!(" (zero in {percent:.0} %)"),
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_sample_is_not_the_end_of_the_distribution() {
        let points = distribution(&vec![(0.0, 1.0), (0.5, 2.0), (1.0, 9.0)], 100);
        assert_eq!(points.first(), Some(&(1.0, 0.0)));
        assert_eq!(points.last(), Some(&(9.0, 0.995)));
    }

    #[test]
    fn zeros_are_said_and_not_drawn() {
        let curve = vec![(0.0, 0.0), (0.5, 0.0), (0.75, 40.0), (1.0, 60.0)];
        let points = distribution(&curve, 1_000);
        assert_eq!(points.first(), Some(&(40.0, 0.5)), "begins above the share of zeros");
        assert!(points.iter().all(|point| point.0 > 0.0));
        assert_eq!(zeros(&curve), " (zero in 50 %)");
        assert_eq!(zeros(&vec![(0.0, 1.0), (1.0, 2.0)]), "");
        assert!(distribution(&vec![(0.0, 0.0), (1.0, 0.0)], 9).is_empty(), "nothing to draw");
    }

    #[test]
    fn no_two_hops_look_alike() {
        for (index, hop) in HOPS.iter().enumerate() {
            for other in &HOPS[..index] {
                assert!((hop.2, hop.3) != (other.2, other.3), "{} and {}", hop.1, other.1);
            }
        }
        let waits: Vec<_> = HOPS.iter().filter(|hop| hop.3 == Stroke::Dotted).collect();
        assert!(waits[0].2 == Tone::Series(4) && waits[1].2 == Tone::Muted, "one grey at most");
        assert!(latencies(&RunPicture::default(), 0).is_none());
    }
}
