//! Trust in announced ends of signals.
//!
//! A roadside unit shows what a driver sees: the present phase. Its announced end is a prediction, and only what
//! happens later tells whether it was right. For each signal an error of its ends is kept, `e`:
//!
//! ```text
//! the phase is seen to end at another time, or to outlast its end     e = max(e, how far off)
//! the announced end jumps, beyond what its bounds leave open          e = e + jump; MOST_S in the last seconds
//! the phase ends as announced                                         e = e / 4
//! ```
//!
//! A signal without evidence of its own has the error of the last evidence on another: ends of one road come from one
//! control centre. By degrees less is used of an announcement:
//!
//! | error | used of the announcement |
//! |---|---|
//! | up to [`ACCURACY_S`] | all |
//! | up to [`USELESS_S`] | ends earlier by `e` for greens and yellows, later by `e` for reds; then the green's end is open |
//! | more | the shown phase: a red lasts, a green can end with each message, its yellow lasts as long as announced |
//!
//! Two senders that disagree about an end are a matter of the on-board unit: it hands on an open end.

use super::{Check, Findings};
use messages::{Interval, PhaseState, Signal, Spat};

/// Accuracy of an announced end, s: marks are tenths of a second, and its two bounds are rounded apart.
const ACCURACY_S: f64 = 0.2;
/// Time from a switch to the message that shows it and back, s: a message may be on its way at either end.
const SWITCH_S: f64 = 0.35;
/// Error from which an announced end is of no use, s: it saves a driver's reaction to the shown phase, 1 s (ITE 2020).
const USELESS_S: f64 = 1.0;
/// Largest error that is kept, s: three phases that end as announced give back full trust.
const MOST_S: f64 = 10.0;
/// Time before an end in which a jump leaves no trust, s: the law is then committed, as a comfortable stop from
/// 15 m/s takes this long.
const LAST_S: f64 = 5.0;
/// Time until the next message can show another phase, with what clocks may differ, s.
const NEXT_MESSAGE_S: f64 = 0.4;
/// Silence after which a phase may be the same again after another one, s.
const GAP_S: f64 = 3.0;
/// Longest silence around a switch that shows an end to hold, s.
const SEEN_S: f64 = 1.0;
/// Length of a yellow without an announcement, s: the shortest by MUTCD 2009, section 4D.26.
const SHORTEST_YELLOW_S: f64 = 3.0;
/// Number of signals that are kept.
const REMEMBERED: usize = 16;

/// A signal and what its announcements are worth.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// Announcement that the next ones are compared with.
    signal: Signal,
    /// Time of the last message, s.
    heard_s: f64,
    /// Latest start of a yellow that began in sight, s.
    yellow_from_s: Option<f64>,
    yellow_s: Option<f64>,
    /// Error of its ends by its own evidence, s.
    error_s: Option<f64>,
}

/// Compares what was announced with what is seen.
#[derive(Clone, Debug)]
pub struct Countdown {
    known: [Option<Known>; REMEMBERED],
    /// Error by the last evidence on any signal, s.
    error_s: f64,
    /// Time by which clocks may differ, s.
    clocks_s: f64,
    /// Step and acquisition, ns, of the last message: one of the same age may contain more.
    last: Option<(u64, i64)>,
    used: Box<Spat>,
    doubts: bool,
}

impl Default for Countdown {
    fn default() -> Self {
        Self::new(0.0)
    }
}

/// Evidence of a message on one signal.
#[derive(Clone, Copy, Debug, Default)]
struct Evidence {
    /// Time between a switch, or the present, and its announcement, s.
    off_s: f64,
    /// Jump of an announced end beyond its bounds, s.
    jump_s: f64,
    /// The jump came in the last seconds.
    is_late: bool,
    /// The phase ended as announced.
    holds: bool,
}

impl Countdown {
    /// Nothing known yet, of units whose clocks may differ by `clocks_s` from the vehicle's.
    pub fn new(clocks_s: f64) -> Self {
        Self {
            known: [None; REMEMBERED],
            error_s: 0.0,
            clocks_s,
            last: None,
            used: Box::new(bytemuck::Zeroable::zeroed()),
            doubts: false,
        }
    }

    /// Takes the newest message at the release at `time_s`; returns what to use of it, and whether that is less than
    /// the whole.
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
        (&self.used, self.doubts)
    }

    fn take(&mut self, sample: &Spat, time_s: f64, findings: &mut Findings) {
        let made_s = sample.header.acquisition_ns as f64 / 1e9;
        let switch_s = SWITCH_S + self.clocks_s;
        *self.used = *sample;
        let (mut off, mut jump) = (0.0_f64, 0.0_f64);
        for signal in sample.signals().iter().filter(|signal| signal.count > 0) {
            let slot = self.slot(signal);
            let mut known = match self.known[slot] {
                Some(known) if made_s - known.heard_s <= GAP_S => known,
                known => {
                    let error_s = known.and_then(|known| known.error_s);
                    self.known[slot] = Some(Known::new(signal, made_s, error_s));
                    continue;
                }
            };
            let evidence = known.compare(signal, made_s, time_s, switch_s);
            off = off.max(evidence.off_s / switch_s);
            jump = jump.max(evidence.jump_s / ACCURACY_S);
            let before_s = known.error_s.unwrap_or(self.error_s);
            let error_s = evidence.error_s(before_s, switch_s);
            if let Some(error_s) = error_s {
                self.error_s = error_s;
                known.error_s = Some(error_s);
            }
            known.take(signal, made_s, error_s.is_some());
            self.known[slot] = Some(known);
        }
        self.doubts = false;
        for signal in
            self.used.signals[..sample.signals().len()].iter_mut().filter(|signal| signal.count > 0)
        {
            let Some(known) = find(&self.known, signal).and_then(|slot| self.known[slot]) else {
                continue;
            };
            let error_s = known.error_s.unwrap_or(self.error_s);
            let is_doubted = error_s > ACCURACY_S;
            let shown = &signal.intervals[0];
            let has_no_end = shown.min_end_s.is_finite() && shown.likely_end_s.is_infinite();
            self.doubts |= is_doubted || has_no_end && is_green(shown);
            known.cut(signal, made_s, if is_doubted { error_s } else { 0.0 });
        }
        findings.note(Check::CountdownAgainstHistory, time_s, jump);
        findings.note(Check::CountdownAgainstClock, time_s, off);
    }

    /// Place of a signal; a new one takes the place of the one that was silent for longest.
    fn slot(&mut self, signal: &Signal) -> usize {
        find(&self.known, signal).unwrap_or_else(|| {
            let heard_s = |known: &Option<Known>| known.map_or(f64::NEG_INFINITY, |k| k.heard_s);
            let oldest = (0..REMEMBERED)
                .min_by(|a, b| heard_s(&self.known[*a]).total_cmp(&heard_s(&self.known[*b])))
                .unwrap_or(0);
            self.known[oldest] = None;
            oldest
        })
    }
}

impl Evidence {
    /// Error after it, with the one before; `None` if it says nothing.
    fn error_s(&self, before_s: f64, switch_s: f64) -> Option<f64> {
        let (is_off, jumps) = (self.off_s > switch_s, self.jump_s > ACCURACY_S);
        let mut error_s = if is_off { before_s.max(self.off_s) } else { before_s };
        if jumps {
            error_s = if self.is_late { MOST_S } else { error_s + self.jump_s };
        } else if self.holds {
            error_s /= 4.0;
        }
        (is_off || jumps || self.holds).then_some(error_s.min(MOST_S))
    }
}

impl Known {
    fn new(signal: &Signal, heard_s: f64, error_s: Option<f64>) -> Self {
        let (yellow_from_s, yellow_s) = (None, yellow_s(signal));
        Self { signal: *signal, heard_s, yellow_from_s, yellow_s, error_s }
    }

    /// Compares a message that was made at `made_s` and is used at `time_s` with the earlier announcement.
    fn compare(&self, new: &Signal, made_s: f64, time_s: f64, switch_s: f64) -> Evidence {
        let (old, new) = (self.signal.intervals(), new.intervals());
        let (Some(was), Some(now)) = (old.first(), new.first()) else { return Evidence::default() };
        let mut evidence = Evidence::default();
        let mut place = 0;
        if was.state == now.state {
            evidence.off_s = (made_s - was.max_end_s).max(0.0);
        } else {
            let Some(at) = old.iter().position(|old| old.state == now.state) else {
                return evidence;
            };
            place = at;
            // The switch came after the last message and before this release.
            let ended = &old[place - 1];
            let (early_s, late_s) = (ended.min_end_s - time_s, self.heard_s - ended.max_end_s);
            evidence.off_s = early_s.max(late_s).max(0.0);
            evidence.holds = evidence.off_s <= switch_s
                && ended.max_end_s.is_finite()
                && time_s - self.heard_s <= SEEN_S;
        }
        if !evidence.off_s.is_finite() {
            evidence.off_s = 0.0;
        }
        for (old, new) in old[place..].iter().zip(new) {
            let jump_s = (old.min_end_s - new.likely_end_s).max(new.likely_end_s - old.max_end_s);
            if jump_s.is_finite() {
                evidence.jump_s = evidence.jump_s.max(jump_s);
            }
        }
        evidence.is_late = old[place].likely_end_s.min(now.likely_end_s) - made_s < LAST_S;
        evidence
    }

    /// Takes a message. An announcement stays the one to compare with until evidence comes, its phase ends or it is
    /// found to be open: otherwise an end could slide in small steps.
    fn take(&mut self, signal: &Signal, made_s: f64, is_evidence: bool) {
        let (was, now) = (self.signal.intervals[0], signal.intervals[0]);
        if was.state != now.state {
            self.yellow_from_s = is_yellow(&now).then_some(self.heard_s);
        }
        if was.state != now.state || is_evidence || was.max_end_s.is_infinite() {
            self.signal = *signal;
        }
        self.yellow_s = yellow_s(signal).or(self.yellow_s);
        self.heard_s = made_s;
    }

    /// Cuts an announcement made at `made_s` down to what is of use with an error of its ends.
    fn cut(&self, signal: &mut Signal, made_s: f64, error_s: f64) {
        let is_useless = error_s > USELESS_S;
        let count = signal.intervals().len();
        let shown = signal.intervals[0];
        if is_green(&shown) {
            self.cut_green(signal, made_s, error_s);
        } else if error_s == 0.0 {
        } else if is_yellow(&shown) {
            let began =
                self.yellow_from_s.zip(self.yellow_s).map(|(from_s, long_s)| from_s + long_s);
            let announced = (!is_useless).then_some(shown.min_end_s - error_s);
            signal.count = u64::from(began.or(announced).is_some());
            let end_s = began.unwrap_or(f64::INFINITY).min(announced.unwrap_or(f64::INFINITY));
            set_ends(&mut signal.intervals[0], [end_s; 3]);
        } else if is_useless {
            signal.count = 1;
            set_ends(&mut signal.intervals[0], [f64::INFINITY; 3]);
        } else {
            for interval in &mut signal.intervals[..count] {
                let (min_s, max_s) = (interval.min_end_s - error_s, interval.max_end_s + error_s);
                set_ends(interval, [min_s, max_s, max_s]);
            }
        }
    }

    /// The same of a shown green. One with an open end can end with the next message, and then its yellow comes.
    fn cut_green(&self, signal: &mut Signal, made_s: f64, error_s: f64) {
        let count = signal.intervals().len();
        let [shown, next, ..] = signal.intervals;
        let is_open = error_s > 0.0 || shown.max_end_s - shown.min_end_s > ACCURACY_S;
        let lacks_next = count == 1 && shown.min_end_s.is_finite();
        if !(is_open || lacks_next) {
            return;
        }
        let certain_s = if error_s > USELESS_S { made_s } else { shown.min_end_s - error_s };
        let yellow_s = self.yellow_s.filter(|_| lacks_next || is_yellow(&next));
        let end_s = certain_s.max(made_s + NEXT_MESSAGE_S);
        let Some(yellow_s) = yellow_s.filter(|yellow_s| *yellow_s > NEXT_MESSAGE_S) else {
            // Red may come with the next message.
            signal.count = u64::from(certain_s > made_s);
            set_ends(&mut signal.intervals[0], [certain_s; 3]);
            return;
        };
        let clear_s = certain_s.max(made_s) + yellow_s;
        if !is_open {
            set_ends(&mut signal.intervals[1], [clear_s; 3]);
        } else if error_s > 0.0 {
            set_ends(&mut signal.intervals[0], [end_s, f64::INFINITY, f64::INFINITY]);
            set_ends(&mut signal.intervals[1], [clear_s, f64::INFINITY, f64::INFINITY]);
        } else {
            signal.intervals[0].min_end_s = end_s;
            signal.intervals[1].min_end_s = clear_s;
        }
        signal.intervals[1].state = PhaseState::ProtectedClearance.to_wire();
        signal.count = if error_s > 0.0 { 2 } else { signal.count.max(2) };
    }
}

/// Announced length of a signal's yellow, s. A sender that announces nothing behind a green leaves the shortest.
fn yellow_s(signal: &Signal) -> Option<f64> {
    let intervals = signal.intervals();
    if intervals.len() == 1 && is_green(&intervals[0]) {
        return Some(SHORTEST_YELLOW_S);
    }
    let pair = intervals.windows(2).find(|pair| is_green(&pair[0]) && is_yellow(&pair[1]))?;
    let length_s = pair[1].min_end_s - pair[0].min_end_s;
    (length_s.is_finite() && length_s > 0.0).then_some(length_s)
}

fn set_ends(interval: &mut Interval, [min_s, likely_s, max_s]: [f64; 3]) {
    (interval.min_end_s, interval.likely_end_s, interval.max_end_s) = (min_s, likely_s, max_s);
}

fn is_green(interval: &Interval) -> bool {
    interval.state == PhaseState::ProtectedMovementAllowed.to_wire()
}

fn is_yellow(interval: &Interval) -> bool {
    interval.state == PhaseState::ProtectedClearance.to_wire()
}

fn find(known: &[Option<Known>; REMEMBERED], signal: &Signal) -> Option<usize> {
    let id = |signal: &Signal| (signal.intersection_id, signal.signal_group);
    known.iter().position(|known| known.is_some_and(|known| id(&known.signal) == id(signal)))
}
