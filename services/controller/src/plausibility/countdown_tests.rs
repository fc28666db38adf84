//! What is used of announced ends that hold, jump, slide, come late or leave a choice.

use super::countdown::Countdown;
use super::{Check, Findings};
use bytemuck::Zeroable;
use messages::{Interval, PhaseState, Signal, Spat};

const RED: u32 = PhaseState::StopAndRemain as u32;
const GREEN: u32 = PhaseState::ProtectedMovementAllowed as u32;
const YELLOW: u32 = PhaseState::ProtectedClearance as u32;
const OPEN: f64 = f64::INFINITY;

/// A signal with certain ends of its phases.
fn signal(id: u32, phases: &[(u32, f64)]) -> Signal {
    let mut signal = Signal { intersection_id: id, count: phases.len() as u64, ..Signal::zeroed() };
    for (place, (state, end_s)) in signal.intervals.iter_mut().zip(phases) {
        let (min_end_s, likely_end_s, max_end_s) = (*end_s, *end_s, *end_s);
        *place = Interval { state: *state, confidence: 15, min_end_s, likely_end_s, max_end_s };
    }
    signal
}

/// Red until 20 s, green until 40 s, yellow until 43 s, and again red from then on, in cycles of 40 s. Ends are
/// announced `off_s` wrong.
fn cycle(id: u32, now_s: f64, off_s: f64) -> Signal {
    let ends = (0..4).flat_map(|cycle| {
        let from_s = 40.0 * f64::from(cycle);
        [(RED, from_s + 20.0), (GREEN, from_s + 40.0), (YELLOW, from_s + 43.0)]
    });
    // Yellow is a part of the next cycle's red.
    let left = ends.filter(|(_, end_s)| *end_s > now_s + 1e-9).take(8);
    signal(id, &left.map(|(state, end_s)| (state, end_s + off_s)).collect::<Vec<_>>())
}

fn spat(now_s: f64, signals: &[Signal]) -> Spat {
    let mut spat = Spat { count: signals.len() as u64, ..Spat::zeroed() };
    spat.header.acquisition_ns = (now_s * 1e9).round() as i64;
    spat.signals[..signals.len()].copy_from_slice(signals);
    spat
}

#[derive(Default)]
struct Drive {
    countdown: Countdown,
    findings: Findings,
}

impl Drive {
    /// Looks at a message; returns the used ends (earliest, latest) of its first signal, and whether it is doubted.
    fn look(&mut self, now_s: f64, signals: &[Signal]) -> (Vec<(u32, f64, f64)>, bool) {
        let message = spat(now_s, signals);
        let (used, doubts) = self.countdown.look(&message, now_s + 0.1, &mut self.findings);
        let signal = &used.signals[0];
        let ends = signal.intervals[..signal.count as usize].iter();
        let tenths = |s: f64| (10.0 * s).round() / 10.0;
        let end = |i: &Interval| (i.state, tenths(i.min_end_s), tenths(i.max_end_s));
        (ends.map(end).collect(), doubts)
    }

    /// Looks at a message in each tenth of a second; returns the last.
    fn drive(
        &mut self,
        (from_s, to_s): (f64, f64),
        of: impl Fn(f64) -> Signal,
    ) -> (Vec<(u32, f64, f64)>, bool) {
        let times = ((10.0 * from_s) as u32..=(10.0 * to_s) as u32).map(|k| f64::from(k) / 10.0);
        times.map(|now_s| self.look(now_s, &[of(now_s)])).last().expect("one")
    }
}

#[test]
fn right_announcements_are_used_whole() {
    let mut drive = Drive::default();
    for k in 0..1000 {
        let now_s = f64::from(k) / 10.0;
        let whole = cycle(1, now_s, 0.0);
        let (used, doubts) = drive.look(now_s, &[whole]);
        let ends: Vec<f64> = used.iter().map(|(_, min_s, _)| *min_s).collect();
        let told = whole.intervals[..whole.count as usize].iter().map(|i| i.min_end_s);
        assert!(!doubts && told.eq(ends.iter().copied()), "{now_s}: {ends:?}");
    }
}

#[test]
fn an_end_may_jump_within_its_bounds_and_the_accuracy() {
    for (off_s, doubts) in [(0.19, false), (0.21, true), (-0.19, false), (-0.21, true)] {
        let mut drive = Drive::default();
        drive.look(5.0, &[cycle(1, 5.0, 0.0)]);
        assert_eq!(drive.look(5.1, &[cycle(1, 5.1, off_s)]).1, doubts, "{off_s}");
        // One that announces a range is not contradicted within it.
        let mut drive = Drive::default();
        let mut wide = cycle(1, 5.0, 0.0);
        for interval in &mut wide.intervals[..8] {
            interval.min_end_s -= 1.0;
            interval.max_end_s += 1.0;
        }
        drive.look(5.0, &[wide]);
        assert!(!drive.look(5.1, &[cycle(1, 5.1, off_s)]).1);
        let beyond_s = off_s + off_s.signum();
        let mut drive = Drive::default();
        drive.look(5.0, &[wide]);
        assert_eq!(drive.look(5.1, &[cycle(1, 5.1, beyond_s)]).1, doubts, "{beyond_s}");
    }
}

#[test]
fn a_small_error_widens_the_ends_and_a_large_one_leaves_the_shown_phase() {
    let mut drive = Drive::default();
    drive.look(5.0, &[cycle(1, 5.0, 0.0)]);
    let (used, _) = drive.look(5.1, &[cycle(1, 5.1, 0.8)]);
    assert_eq!(used[..2], [(RED, 20.0, 21.6), (GREEN, 40.0, 41.6)]);
    // Jumps add up: a countdown could slide otherwise.
    let (used, doubts) = drive.look(5.2, &[cycle(1, 5.2, 0.4)]);
    assert_eq!((used, doubts), (vec![(RED, OPEN, OPEN)], true));
    // In green: it can end with the next message, and then its yellow comes.
    let (used, _) = drive.drive((5.3, 25.0), |now_s| cycle(1, now_s, 30.0));
    assert_eq!(used, [(GREEN, 25.4, OPEN), (YELLOW, 28.0, OPEN)]);
    // A yellow that began in sight is as long as it was announced.
    let (used, _) = drive.drive((25.1, 42.0), |now_s| cycle(1, now_s, 30.0));
    assert_eq!(used, [(YELLOW, 42.9, 42.9)]);
}

#[test]
fn a_change_in_the_last_seconds_leaves_no_trust() {
    let mut drive = Drive::default();
    drive.look(16.0, &[cycle(1, 16.0, 0.0)]);
    let (used, _) = drive.look(16.1, &[cycle(1, 16.1, 0.5)]);
    assert_eq!(used, [(RED, OPEN, OPEN)]);
}

#[test]
fn a_countdown_that_stands_still_is_found_out() {
    let mut drive = Drive::default();
    let stuck = |now_s: f64| cycle(1, now_s, now_s);
    assert!(!drive.drive((0.0, 0.1), stuck).1);
    assert!(drive.drive((0.2, 0.5), stuck).1);
    assert_eq!(drive.drive((0.6, 4.0), stuck).0, [(RED, OPEN, OPEN)]);
}

#[test]
fn a_phase_that_outlasts_its_end_or_ends_early_contradicts_it() {
    // Too early from the first message on: green is shown at 20 s, and announced to end at 36 s.
    let mut drive = Drive::default();
    let early = |now_s: f64| cycle(1, now_s, -4.0);
    assert!(!drive.drive((10.0, 16.3), early).1);
    assert!(drive.drive((16.4, 16.5), early).1);
    assert_eq!(drive.drive((16.6, 18.0), early).0, [(RED, OPEN, OPEN)]);
    // Too late: the switch comes before its time.
    let mut drive = Drive::default();
    let late = |now_s: f64| cycle(1, now_s, 4.0);
    assert!(!drive.drive((10.0, 19.9), late).1);
    let (used, doubts) = drive.look(20.0, &[late(20.0)]);
    assert_eq!((used, doubts), (vec![(GREEN, 20.4, OPEN), (YELLOW, 23.0, OPEN)], true));
    let finding = |check: Check| drive.findings.of(check).first_s;
    assert_eq!(finding(Check::CountdownAgainstClock), Some(20.1));
    assert_eq!(finding(Check::CountdownAgainstHistory), None);
}

#[test]
fn trust_comes_back_with_phases_that_end_as_announced() {
    let mut drive = Drive::default();
    drive.look(5.0, &[cycle(1, 5.0, 0.0)]);
    assert!(drive.drive((5.1, 19.9), |now_s| cycle(1, now_s, 6.0)).1);
    let right = |now_s: f64| cycle(1, now_s, 0.0);
    assert!(drive.drive((20.0, 59.9), right).1);
    assert!(!drive.drive((60.0, 62.0), right).1, "40, 43 and 60 s are three of them");
}

#[test]
fn an_error_on_one_signal_counts_for_those_without_evidence_of_their_own() {
    let mut drive = Drive::default();
    let ends = |now_s, off_s| [cycle(2, now_s, 0.0), cycle(1, now_s, off_s)];
    drive.look(5.0, &ends(5.0, 0.0));
    assert_eq!(drive.look(5.1, &ends(5.1, 3.0)).0, [(RED, OPEN, OPEN)]);
    let new = [cycle(3, 5.2, 0.0), cycle(1, 5.2, 3.0)];
    assert_eq!(drive.look(5.2, &new).0, [(RED, OPEN, OPEN)]);
}

#[test]
fn a_green_without_a_next_phase_has_the_shortest_yellow() {
    let mut drive = Drive::default();
    let (used, doubts) = drive.look(5.0, &[signal(1, &[(GREEN, 20.0)])]);
    assert_eq!((used, doubts), (vec![(GREEN, 20.0, 20.0), (YELLOW, 23.0, 23.0)], false));
    // One that announces red has none, and one without an end needs none.
    let red = [(GREEN, 20.0), (RED, 50.0)];
    assert_eq!(drive.look(5.0, &[signal(2, &red)]).0.len(), 2);
    assert_eq!(drive.look(6.0, &[signal(3, &[(GREEN, OPEN)])]).0, [(GREEN, OPEN, OPEN)]);
}

#[test]
fn an_open_green_lasts_until_the_next_message_and_its_yellow_after_it() {
    let mut drive = Drive::default();
    let mut actuated = signal(1, &[(GREEN, 5.0), (YELLOW, 9.0), (RED, 40.0)]);
    for interval in &mut actuated.intervals[..3] {
        (interval.likely_end_s, interval.max_end_s) = (interval.min_end_s + 9.0, OPEN);
    }
    let (used, doubts) = drive.look(7.0, &[actuated]);
    assert_eq!(used, [(GREEN, 7.4, OPEN), (YELLOW, 11.0, OPEN), (RED, 40.0, OPEN)]);
    assert!(!doubts, "its likely end is announced");
}

#[test]
fn sixteen_signals_are_kept_and_the_oldest_gives_way() {
    let found = |count: u32, id: u32| {
        let mut drive = Drive::default();
        for k in 0..count {
            drive.look(5.0 + 0.1 * f64::from(k), &[signal(k, &[(RED, 90.0), (GREEN, 99.0)])]);
        }
        drive.look(7.0, &[signal(id, &[(RED, 93.0), (GREEN, 99.0)])]).1
    };
    assert!(found(16, 0) && found(16, 15) && found(17, 1) && found(17, 16));
    assert!(!found(17, 0), "the seventeenth has its place");
}

#[test]
fn counts_beyond_what_fits_are_as_many_as_fit() {
    let mut many = spat(5.0, &[cycle(1, 5.0, 0.0)]);
    many.count = u64::MAX;
    many.signals[0].count = u64::MAX;
    let (mut countdown, mut findings) = (Countdown::default(), Findings::default());
    assert!(!countdown.look(&many, 5.1, &mut findings).1);
}

#[test]
fn clocks_may_differ() {
    let mut findings = Findings::default();
    for (clocks_s, doubts) in [(0.0, true), (0.25, false)] {
        let mut countdown = Countdown::new(clocks_s);
        countdown.look(&spat(19.9, &[cycle(1, 19.9, 0.0)]), 20.0, &mut findings);
        let late = spat(20.5, &[cycle(1, 19.9, 0.0)]);
        assert_eq!(countdown.look(&late, 20.6, &mut findings).1, doubts, "{clocks_s}");
    }
}
