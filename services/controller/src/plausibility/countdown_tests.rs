//! Tolerances of announced signal timing at their bounds, and the stored signals.

use super::countdown::Countdown;
use super::{Check, Findings};
use bytemuck::Zeroable;
use messages::{Interval, Signal, Spat};

const RED: u32 = 3;
const GREEN: u32 = 6;
const YELLOW: u32 = 8;

fn interval(state: u32, end_s: f64) -> Interval {
    let ends =
        Interval { min_end_s: end_s, likely_end_s: end_s, max_end_s: end_s, ..Interval::zeroed() };
    Interval { state, ..ends }
}

fn signal(id: u32, phases: &[(u32, f64)]) -> Signal {
    let mut signal = Signal { intersection_id: id, count: phases.len() as u64, ..Signal::zeroed() };
    for (place, (state, end_s)) in signal.intervals.iter_mut().zip(phases) {
        *place = interval(*state, *end_s);
    }
    signal
}

fn spat(now_s: f64, signals: &[Signal]) -> Spat {
    let mut spat = Spat { count: signals.len() as u64, ..Spat::zeroed() };
    spat.header.acquisition_ns = (now_s * 1e9).round() as i64;
    spat.signals[..signals.len()].copy_from_slice(signals);
    spat
}

/// Looks at one message after another; returns the valid part of each, and whether that is less than the whole.
fn looked(messages: &[Spat]) -> Vec<(Spat, bool)> {
    let (mut countdown, mut findings) = (Countdown::default(), Findings::default());
    let mut results = Vec::new();
    for message in messages {
        let (believed, contradicts) = countdown.look(message, 0.0, &mut findings);
        results.push((*believed, contradicts));
    }
    results
}

fn last(messages: &[Spat]) -> (Spat, bool) {
    looked(messages).pop().expect("one of them")
}

/// Ends of a signal's phases, each of which has one time for its earliest and latest end.
fn ends(spat: &Spat, place: usize) -> Vec<f64> {
    let signal = &spat.signals[place];
    let intervals = &signal.intervals[..signal.count as usize];
    let certain = |i: &Interval| i.min_end_s == i.likely_end_s && i.max_end_s == i.likely_end_s;
    assert!(intervals.iter().all(certain), "{intervals:?}");
    intervals.iter().map(|interval| interval.likely_end_s).collect()
}

#[test]
fn an_end_may_differ_by_the_tolerance() {
    for (off_s, contradicts) in [(0.19, false), (0.21, true), (-0.19, false), (-0.21, true)] {
        let first = spat(5.0, &[signal(1, &[(RED, 20.0), (GREEN, 30.0)])]);
        let second = spat(5.1, &[signal(1, &[(RED, 20.0 + off_s), (GREEN, 30.0 + off_s)])]);
        assert_eq!(last(&[first, second]).1, contradicts, "{off_s}");
        // One that announces a range is not contradicted within it.
        let mut wide = first;
        for interval in &mut wide.signals[0].intervals[..2] {
            (interval.min_end_s, interval.max_end_s) =
                (interval.likely_end_s - 1.0, interval.likely_end_s + 1.0);
        }
        assert!(!last(&[wide, second]).1, "{off_s}");
        let beyond = 1.0 * f64::signum(off_s) + off_s;
        let second = spat(5.1, &[signal(1, &[(RED, 20.0 + beyond), (GREEN, 30.0 + beyond)])]);
        assert_eq!(last(&[wide, second]).1, contradicts, "{beyond} with a range");
    }
}

#[test]
fn a_phase_may_outlast_its_end_by_the_time_of_a_message() {
    for (late_s, contradicts) in [(0.14, false), (0.16, true)] {
        // The first announcement of a signal, and one of a known signal.
        let red = signal(1, &[(RED, 10.0), (GREEN, 20.0)]);
        assert_eq!(last(&[spat(10.0 + late_s, &[red])]).1, contradicts, "{late_s}");
        let messages = [spat(5.0, &[red]), spat(10.0 + late_s, &[red])];
        let (believed, found) = last(&messages);
        assert_eq!(found, contradicts, "{late_s}");
        assert_eq!(ends(&believed, 0), [10.0, 20.0]);
    }
    // A new signal whose phase is over shows nothing.
    let (believed, _) = last(&[spat(11.0, &[signal(1, &[(RED, 10.0), (GREEN, 20.0)])])]);
    assert_eq!(believed.signals[0].count, 0);
}

#[test]
fn an_overdue_green_is_shown_with_a_yellow_that_is_long_enough_alone() {
    let believed = |phases: &[(u32, f64)]| {
        let signal = signal(1, phases);
        ends(&last(&[spat(5.0, &[signal]), spat(9.0, &[signal])]).0, 0)
    };
    let close = |found: &[f64], expected: &[f64]| {
        found.len() == expected.len()
            && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9)
    };
    assert!(close(&believed(&[(GREEN, 8.0), (YELLOW, 8.5), (RED, 30.0)]), &[9.4, 9.5]));
    // Too short a yellow, another order or an open end: what was announced before.
    for phases in [
        [(GREEN, 8.0), (YELLOW, 8.3), (RED, 30.0)],
        [(GREEN, 8.0), (RED, 12.0), (GREEN, 30.0)],
        [(RED, 8.0), (YELLOW, 12.0), (GREEN, 30.0)],
        [(GREEN, 8.0), (YELLOW, f64::INFINITY), (RED, f64::INFINITY)],
    ] {
        assert_eq!(believed(&phases), phases.map(|(_, end_s)| end_s), "{phases:?}");
    }
    assert_eq!(believed(&[(GREEN, 8.0)]), [8.0]);
}

#[test]
fn around_a_switch_the_phase_before_and_the_one_after_agree() {
    let first = spat(5.0, &[signal(1, &[(RED, 20.0), (GREEN, 30.0), (RED, 50.0)])]);
    let at = |now_s: f64, phases: &[(u32, f64)]| last(&[first, spat(now_s, &[signal(1, phases)])]);
    // 0.35 s before and after the switch the other phase is not a refutation: its end is compared.
    assert!(at(20.3, &[(RED, 20.25), (GREEN, 30.3)]).1, "0.25 s late and still red");
    assert!(at(19.7, &[(GREEN, 28.0), (RED, 50.0)]).1, "early green that ends early");
    assert!(!at(19.7, &[(GREEN, 30.1), (RED, 50.0)]).1);
    // Farther from it another phase refutes the known one, and is used.
    let (believed, contradicts) = at(19.6, &[(GREEN, 28.0), (RED, 50.0)]);
    assert_eq!((ends(&believed, 0), contradicts), (vec![28.0, 50.0], false));
}

#[test]
fn the_larger_of_two_offsets_counts_for_a_signal_that_is_new() {
    let two = |a_s: f64, b_s: f64| {
        [
            signal(1, &[(RED, 20.0 + a_s), (GREEN, 30.0 + a_s)]),
            signal(2, &[(RED, 20.0 + b_s), (GREEN, 30.0 + b_s)]),
        ]
    };
    let new = signal(3, &[(RED, 20.0), (GREEN, 30.0)]);
    for (a_s, b_s, worst_s) in
        [(-1.0, -3.0, -3.0), (-3.0, -1.0, -3.0), (1.0, -3.0, -3.0), (2.0, 1.0, 2.0)]
    {
        let first = spat(5.0, &two(0.0, 0.0));
        let [a, b] = two(a_s, b_s);
        let (believed, contradicts) = last(&[first, spat(5.1, &[a, b, new])]);
        assert!(contradicts);
        // A green begins at the later of both times, and ends at the earlier.
        let expected = [20.0 + f64::max(-worst_s, 0.0), 30.0 - f64::max(worst_s, 0.0)];
        assert_eq!(ends(&believed, 2), expected, "{a_s} {b_s}");
        // Its known end is the one that it announces without the offset.
        let honest = signal(3, &[(RED, 20.0 - worst_s), (GREEN, 30.0 - worst_s)]);
        let [a, b] = two(0.0, 0.0);
        let after = spat(5.2, &[a, b, honest]);
        let (believed, contradicts) =
            last(&[first, spat(5.1, &[two(a_s, b_s)[0], two(a_s, b_s)[1], new]), after]);
        assert_eq!(
            (ends(&believed, 2), contradicts),
            (vec![20.0 - worst_s, 30.0 - worst_s], false)
        );
    }
}

#[test]
fn one_that_agrees_ends_the_offset_and_an_open_one_does_not() {
    let signal_of = |id: u32, off_s: f64| signal(id, &[(RED, 20.0 + off_s), (GREEN, 30.0 + off_s)]);
    let jumped = [spat(5.0, &[signal_of(1, 0.0)]), spat(5.1, &[signal_of(1, -2.0)])];
    let new = signal_of(2, -2.0);
    let after = |message: Spat, then_s: f64| {
        let messages = [&jumped[..], &[message, spat(then_s, &[new])]].concat();
        last(&messages).1
    };
    assert!(!after(spat(5.2, &[signal_of(1, 0.0)]), 5.3), "it is in order again");
    let open = signal(1, &[(RED, f64::INFINITY)]);
    assert!(after(spat(5.2, &[open]), 5.3), "it says nothing of its end");
}

#[test]
fn sixteen_signals_are_kept_and_the_oldest_gives_way() {
    let of = |id: u32, off_s: f64| signal(id, &[(RED, 90.0 + off_s), (GREEN, 99.0 + off_s)]);
    let heard = |count: u32| -> Vec<Spat> {
        (0..count).map(|id| spat(5.0 + 0.1 * f64::from(id), &[of(id, 0.0)])).collect()
    };
    let jumps =
        |count: u32, id: u32| last(&[heard(count), vec![spat(9.0, &[of(id, 3.0)])]].concat()).1;
    assert!(jumps(16, 0) && jumps(16, 15));
    assert!(!jumps(17, 0), "the seventeenth has its place");
    assert!(jumps(17, 1) && jumps(17, 16));
    // Another group of the same intersection is another signal.
    let mut other = of(1, 3.0);
    other.signal_group = 7;
    assert!(!last(&[heard(2), vec![spat(9.0, &[other])]].concat()).1);
}

#[test]
fn counts_beyond_what_fits_are_as_many_as_fit() {
    let mut many = spat(5.0, &[signal(1, &[(RED, 20.0), (GREEN, 30.0)])]);
    many.count = u64::MAX;
    many.signals[0].count = u64::MAX;
    let mut again = many;
    again.header.acquisition_ns += 100_000_000;
    assert_eq!(looked(&[many, again]).iter().filter(|(_, contradicts)| *contradicts).count(), 0);
    // A signal behind the end of the list does not exist.
    let mut hidden = spat(5.0, &[signal(1, &[(RED, 20.0)]), signal(2, &[(RED, 1.0)])]);
    hidden.count = 1;
    assert!(!last(&[hidden]).1);
    hidden.count = 2;
    assert!(last(&[hidden]).1);
}

#[test]
fn each_contradiction_is_counted_by_its_check() {
    let (mut countdown, mut findings) = (Countdown::default(), Findings::default());
    let mut look = |message: &Spat, time_s: f64| {
        countdown.look(message, time_s, &mut findings);
        let found = |check: Check| {
            let (_, finding) = findings.iter().find(|(of, _)| *of == check).expect("one of all");
            (finding.cycles, finding.first_s)
        };
        (found(Check::CountdownAgainstHistory), found(Check::CountdownAgainstClock))
    };
    let of = |off_s: f64| signal(1, &[(RED, 20.0 + off_s), (GREEN, 30.0 + off_s)]);
    assert_eq!(look(&spat(5.0, &[of(0.0)]), 5.05), ((0, None), (0, None)));
    assert_eq!(look(&spat(5.1, &[of(1.0)]), 5.15), ((1, Some(5.15)), (0, None)));
    assert_eq!(
        look(&spat(5.1, &[of(1.0)]), 5.25),
        ((1, Some(5.15)), (0, None)),
        "the same message"
    );
    assert_eq!(look(&spat(20.5, &[of(0.0)]), 20.55), ((1, Some(5.15)), (1, Some(20.55))));
}
