//! Plausibility of signal timing.
//!
//! A certain announcement of a roadside unit stays certain: a later announcement with another end contradicts it. The
//! two do not show which of them is wrong. So the phase is green only where both agree, until the shown phase refutes
//! one. New messages can contradict what is known of other signals. A signal that they name for the first
//! time is taken to be off by as much.

use super::{Check, Findings};
use messages::{Interval, MAX_INTERVALS, PhaseState, Signal, Spat};

/// Time by which an announced end may differ, s.
const TOLERANCE_S: f64 = 0.2;
/// Time by which a shown phase may outlast its announced end, s: the message was on its way.
const OVERDUE_S: f64 = 0.15;
/// Time until the next message shows another phase, with what clocks may differ, s.
const NEXT_MESSAGE_S: f64 = 0.4;
/// Number of signals that are kept.
const REMEMBERED: usize = 16;

/// Announcement of a signal.
#[derive(Clone, Copy, Debug)]
struct Known {
    signal: Signal,
    heard_s: f64,
}

/// Compares each announcement with those before.
#[derive(Clone, Debug)]
pub struct Countdown {
    known: [Option<Known>; REMEMBERED],
    /// Time by which a shown phase may outlast its announced end, s.
    overdue_s: f64,
    /// Error of the ends of known signals, s, while it lasts.
    offset_s: Option<f64>,
    /// Step and acquisition, ns, of the last message: one of the same age as the last one may contain more.
    last: Option<(u64, i64)>,
    believed: Box<Spat>,
    contradicts: bool,
}

impl Default for Countdown {
    fn default() -> Self {
        Self {
            known: [None; REMEMBERED],
            overdue_s: OVERDUE_S,
            offset_s: None,
            last: None,
            believed: Box::new(bytemuck::Zeroable::zeroed()),
            contradicts: false,
        }
    }
}

/// Relation of an announcement to the known timing.
enum Comparison {
    /// The same, or nothing can be said against it.
    Agrees,
    /// Its ends are off by so much, s.
    Off(f64),
    /// The known timing was wrong.
    Refutes,
    /// It leaves open how long the phase lasts: nothing is to be learned of it.
    Open,
}

impl Countdown {
    /// Nothing known yet, of units whose clocks may differ by `clocks_s` from the vehicle's.
    #[must_use]
    pub fn new(clocks_s: f64) -> Self {
        Self { overdue_s: OVERDUE_S + clocks_s, ..Self::default() }
    }

    /// Takes the newest message; returns its valid part, and whether that is less than the whole.
    pub fn look<'a>(
        &'a mut self,
        sample: &'a Spat,
        time_s: f64,
        findings: &mut Findings,
    ) -> (&'a Spat, bool) {
        let this = (sample.header.step, sample.header.acquisition_ns);
        if self.last != Some(this) {
            self.last = Some(this);
            self.take(sample, time_s, findings);
        }
        if self.contradicts { (&self.believed, true) } else { (sample, false) }
    }

    fn take(&mut self, sample: &Spat, time_s: f64, findings: &mut Findings) {
        let now_s = sample.header.acquisition_ns as f64 / 1e9;
        *self.believed = *sample;
        let count = usize::try_from(sample.count).map_or(0, |n| n.min(sample.signals.len()));
        let (mut off, mut agreed, mut overdue) = (None::<f64>, false, false);
        for signal in &mut self.believed.signals[..count] {
            let Some(slot) = find(&self.known, signal) else { continue };
            let Some(Known { signal: known, .. }) = self.known[slot] else { continue };
            if is_overdue(signal, now_s, self.overdue_s) {
                overdue = true;
                *signal = as_shown(signal, now_s).unwrap_or(known);
                continue;
            }
            match compare(&known, signal, now_s) {
                Comparison::Agrees | Comparison::Refutes => {
                    agreed = true;
                    self.known[slot] = Some(Known { signal: *signal, heard_s: now_s });
                }
                Comparison::Open => {}
                Comparison::Off(by_s) => {
                    off = Some(
                        off.map_or(by_s, |off| if by_s.abs() > off.abs() { by_s } else { off }),
                    );
                    *signal = both(signal, by_s);
                }
            }
        }
        self.offset_s = match (off, agreed) {
            (Some(by_s), _) => Some(by_s),
            (None, true) => None,
            (None, false) => self.offset_s,
        };
        for signal in &mut self.believed.signals[..count] {
            if signal.count > 0 && find(&self.known, signal).is_none() {
                if is_overdue(signal, now_s, self.overdue_s) {
                    overdue = true;
                    signal.count = 0;
                    continue;
                }
                let mut known = *signal;
                if let Some(by_s) = self.offset_s {
                    off = off.or(Some(by_s));
                    known = shifted(signal, -by_s);
                    *signal = both(signal, by_s);
                }
                remember(&mut self.known, Known { signal: known, heard_s: now_s });
            }
        }
        let share = off.map_or(0.0, |by_s| by_s.abs() / TOLERANCE_S);
        findings.note(Check::CountdownAgainstHistory, time_s, share);
        findings.note(Check::CountdownAgainstClock, time_s, if overdue { 2.0 } else { 0.0 });
        self.contradicts = off.is_some() || overdue;
    }
}

fn intervals(signal: &Signal) -> &[Interval] {
    let count = usize::try_from(signal.count).map_or(0, |count| count.min(MAX_INTERVALS));
    &signal.intervals[..count]
}

fn find(known: &[Option<Known>; REMEMBERED], signal: &Signal) -> Option<usize> {
    let id = |signal: &Signal| (signal.intersection_id, signal.signal_group);
    known.iter().position(|known| known.is_some_and(|known| id(&known.signal) == id(signal)))
}

fn remember(known: &mut [Option<Known>; REMEMBERED], new: Known) {
    let heard_s = |slot: &Option<Known>| slot.map_or(f64::NEG_INFINITY, |known| known.heard_s);
    if let Some(oldest) = known.iter_mut().min_by(|a, b| heard_s(a).total_cmp(&heard_s(b))) {
        *oldest = Some(new);
    }
}

/// The phase that is shown should be over by its own end.
fn is_overdue(signal: &Signal, now_s: f64, overdue_s: f64) -> bool {
    intervals(signal).first().is_some_and(|shown| shown.max_end_s < now_s - overdue_s)
}

/// A green that outlasts its announced end is still shown. It can end with each message, and then its yellow comes.
/// `None` without an announced yellow.
fn as_shown(signal: &Signal, now_s: f64) -> Option<Signal> {
    let [green, yellow, ..] = intervals(signal) else { return None };
    let states = [PhaseState::ProtectedMovementAllowed, PhaseState::ProtectedClearance];
    let yellow_s = yellow.min_end_s - green.max_end_s;
    if [green.state, yellow.state] != states.map(PhaseState::to_wire) || !yellow_s.is_finite() {
        return None;
    }
    let mut shown = Signal { count: 2, ..*signal };
    for (interval, end_s) in shown.intervals.iter_mut().zip([NEXT_MESSAGE_S, yellow_s]) {
        let end_s = now_s + end_s;
        (interval.min_end_s, interval.likely_end_s, interval.max_end_s) = (end_s, end_s, end_s);
    }
    (yellow_s > NEXT_MESSAGE_S).then_some(shown)
}

fn compare(known: &Signal, signal: &Signal, now_s: f64) -> Comparison {
    let (known, new) = (intervals(known), intervals(signal));
    let Some(first) = new.first() else { return Comparison::Agrees };
    // Phase that should be shown; around a switch also the one before or after it.
    let shown = |from_s: f64| known.iter().position(|interval| interval.likely_end_s > from_s);
    let candidates = [now_s, now_s - OVERDUE_S - TOLERANCE_S, now_s + OVERDUE_S + TOLERANCE_S];
    let mut places = candidates.into_iter().filter_map(shown);
    let Some(place) = places.find(|place| known[*place].state == first.state) else {
        return Comparison::Refutes;
    };
    if first.likely_end_s.is_infinite() && known[place].likely_end_s.is_finite() {
        return Comparison::Open;
    }
    let mut off_s: f64 = 0.0;
    for (known, new) in known[place..].iter().zip(new) {
        let early_s = known.min_end_s - new.likely_end_s;
        let late_s = new.likely_end_s - known.max_end_s;
        if early_s > TOLERANCE_S || late_s > TOLERANCE_S {
            off_s = new.likely_end_s - known.likely_end_s;
        }
    }
    if off_s.is_finite() && off_s.abs() > TOLERANCE_S {
        Comparison::Off(off_s)
    } else {
        Comparison::Agrees
    }
}

fn shifted(signal: &Signal, by_s: f64) -> Signal {
    let mut shifted = *signal;
    for interval in &mut shifted.intervals {
        shift(interval, by_s);
    }
    shifted
}

fn shift(interval: &mut Interval, by_s: f64) {
    interval.min_end_s += by_s;
    interval.likely_end_s += by_s;
    interval.max_end_s += by_s;
}

/// Timing that holds for the announcement and for one without its offset. Greens begin at the later of the two, and end
/// at the earlier.
fn both(signal: &Signal, offset_s: f64) -> Signal {
    let mut both = *signal;
    let green = PhaseState::ProtectedMovementAllowed.to_wire();
    let count = intervals(signal).len();
    for k in 0..count {
        let opens =
            signal.intervals.get(k + 1).is_some_and(|next| k + 1 < count && next.state == green);
        let by_s = if opens { (-offset_s).max(0.0) } else { (-offset_s).min(0.0) };
        shift(&mut both.intervals[k], by_s);
    }
    both
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    const RED: u32 = 3;
    const GREEN: u32 = 6;

    /// Messages of a signal that is red until 20 s, then green and red for 10 s each. They are `off_s` off.
    fn spat(id: u32, now_s: f64, off_s: f64) -> Spat {
        let mut spat = Spat::zeroed();
        spat.header.acquisition_ns = (now_s * 1e9) as i64;
        spat.count = 1;
        spat.signals[0] = signal(id, now_s, off_s);
        spat
    }

    fn signal(id: u32, now_s: f64, off_s: f64) -> Signal {
        let mut signal = Signal::zeroed();
        signal.intersection_id = id;
        let ends = [(RED, 20.0), (GREEN, 30.0), (RED, 40.0), (GREEN, 50.0)];
        for (state, end_s) in ends.into_iter().filter(|(_, end_s)| *end_s > now_s) {
            let end_s = end_s + off_s;
            signal.intervals[signal.count as usize] = Interval {
                state,
                confidence: 15,
                min_end_s: end_s,
                likely_end_s: end_s,
                max_end_s: end_s,
            };
            signal.count += 1;
        }
        signal
    }

    fn ends(spat: &Spat) -> Vec<f64> {
        intervals(&spat.signals[0]).iter().map(|interval| interval.likely_end_s).collect()
    }

    #[test]
    fn a_countdown_that_jumps_is_green_only_where_it_is_so_before_and_after() {
        let (mut countdown, mut findings) = (Countdown::default(), Findings::default());
        let mut look = |now_s, off_s| {
            let spat = spat(1, now_s, off_s);
            let (believed, contradicts) = countdown.look(&spat, now_s, &mut findings);
            (ends(believed), contradicts)
        };
        assert_eq!(look(5.0, 0.0), (vec![20.0, 30.0, 40.0, 50.0], false));
        assert_eq!(look(5.1, -2.0), (vec![20.0, 28.0, 40.0, 48.0], true));
        assert_eq!(look(5.2, 2.0), (vec![22.0, 30.0, 42.0, 50.0], true));
        assert_eq!(look(5.3, 0.0), (vec![20.0, 30.0, 40.0, 50.0], false));
    }

    #[test]
    fn a_phase_that_outlasts_its_own_end_refutes_the_countdown() {
        let (mut countdown, mut findings) = (Countdown::default(), Findings::default());
        for k in 0..=205 {
            let now_s = 0.1 * f64::from(k);
            let spat = spat(1, now_s, -2.0);
            let (_, contradicts) = countdown.look(&spat, now_s, &mut findings);
            assert_eq!(contradicts, (18.2..20.0 - 1e-9).contains(&now_s), "{now_s}");
        }
    }

    #[test]
    fn a_phase_may_outlast_its_end_by_what_the_clocks_differ() {
        for (clocks_s, contradicts) in [(0.0, true), (0.25, false)] {
            let (mut countdown, mut findings) = (Countdown::new(clocks_s), Findings::default());
            countdown.look(&spat(1, 19.9, 0.0), 19.9, &mut findings);
            let mut late = spat(1, 19.9, 0.0);
            late.header.acquisition_ns = 20_300_000_000;
            assert_eq!(countdown.look(&late, 20.3, &mut findings).1, contradicts, "{clocks_s}");
        }
    }

    #[test]
    fn the_first_announcement_gives_way_when_the_signal_shows_something_else() {
        let (mut countdown, mut findings) = (Countdown::default(), Findings::default());
        countdown.look(&spat(1, 5.0, -2.0), 5.0, &mut findings);
        for k in 60..=250 {
            let now_s = 0.1 * f64::from(k);
            let spat = spat(1, now_s, 0.0);
            let (believed, contradicts) = countdown.look(&spat, now_s, &mut findings);
            let first = ends(believed)[0];
            assert!(now_s >= 20.0 || first == 20.0, "{now_s}: {first}");
            assert_eq!(contradicts, now_s < 18.35, "{now_s}");
        }
    }

    #[test]
    fn a_countdown_that_ends_too_early_is_still_too_early_in_the_next_phase() {
        let (mut countdown, mut findings) = (Countdown::default(), Findings::default());
        countdown.look(&spat(1, 5.0, 0.0), 5.0, &mut findings);
        countdown.look(&spat(1, 16.0, -2.0), 16.0, &mut findings);
        // Red outlasts its announced end: the on-board unit hands on that its end is not known.
        let mut open = spat(1, 19.0, f64::INFINITY);
        open.signals[0].count = 1;
        countdown.look(&open, 19.0, &mut findings);
        let early = spat(1, 21.0, -2.0);
        let (believed, contradicts) = countdown.look(&early, 21.0, &mut findings);
        assert_eq!((ends(believed), contradicts), (vec![28.0, 40.0, 48.0], true));
    }

    #[test]
    fn a_green_that_outlasts_its_end_is_green_now_and_yellow_for_as_long_as_was_announced() {
        let (mut countdown, mut findings) = (Countdown::default(), Findings::default());
        let at = |now_s: f64| {
            let mut spat = spat(1, now_s, 0.0);
            for (place, (state, end_s)) in
                [(GREEN, 8.0), (8, 11.0), (RED, 30.0)].into_iter().enumerate()
            {
                let ends = Interval {
                    min_end_s: end_s,
                    likely_end_s: end_s,
                    max_end_s: end_s,
                    ..Interval::zeroed()
                };
                spat.signals[0].intervals[place] = Interval { state, ..ends };
            }
            spat.signals[0].count = 3;
            spat
        };
        countdown.look(&at(5.0), 5.0, &mut findings);
        let late = at(9.0);
        let (believed, contradicts) = countdown.look(&late, 9.0, &mut findings);
        assert_eq!((ends(believed), contradicts), (vec![9.4, 12.0], true));
        assert_eq!(believed.signals[0].intervals[0].state, GREEN);
    }

    #[test]
    fn a_message_as_old_as_the_last_one_is_looked_at() {
        let (mut countdown, mut findings) = (Countdown::default(), Findings::default());
        countdown.look(&spat(1, 5.0, 0.0), 5.0, &mut findings);
        let mut next = spat(1, 5.0, 2.0);
        next.header.step = 1;
        let (believed, contradicts) = countdown.look(&next, 5.1, &mut findings);
        assert_eq!((ends(believed), contradicts), (vec![22.0, 30.0, 42.0, 50.0], true));
    }

    #[test]
    fn a_signal_first_met_among_others_that_jumped_is_off_by_as_much() {
        let (mut countdown, mut findings) = (Countdown::default(), Findings::default());
        countdown.look(&spat(1, 5.0, 0.0), 5.0, &mut findings);
        countdown.look(&spat(1, 5.1, -2.0), 5.1, &mut findings);
        let spat = spat(2, 5.2, -2.0);
        let (believed, contradicts) = countdown.look(&spat, 5.2, &mut findings);
        assert!(contradicts);
        assert_eq!(ends(believed), [20.0, 28.0, 40.0, 48.0]);
    }
}
