//! Stop lines: when the ego crosses them, and what their signals show then.

use scenario::v2x::Phase;
use serde::{Deserialize, Serialize};

use super::{Sample, Violation, seconds};
use crate::report::ControlFigures;

/// Most signals watched at a time.
pub const MAX_SIGNALS: usize = 16;

/// A signal as it truly is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalTruth {
    /// Identity, equal for equal signals.
    pub id: u32,
    /// Position of the stop line along the road, m.
    pub stop_line_m: f64,
    /// Phase at the time of the sample.
    pub phase: Phase,
    /// Time since the start of the run at which this phase ends; `None`: it stays.
    pub ends_ns: Option<u64>,
    /// The phase after this one.
    pub next_phase: Phase,
}

impl SignalTruth {
    /// The phase at a time, up to the end of the phase after the present one.
    pub fn phase_at(&self, time_s: f64) -> Phase {
        match self.ends_ns {
            Some(ends_ns) if time_s >= seconds(ends_ns) => self.next_phase,
            _ => self.phase,
        }
    }
}

/// The stop lines near the ego.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct StopLines {
    watched: [Option<SignalTruth>; MAX_SIGNALS],
    /// The first signal of the run: the figures are about it.
    first: Option<u32>,
    pub(super) red_lights: u32,
}

impl StopLines {
    /// Takes the signals of a sample. Returns the first stop line that the ego has crossed on red since `last`.
    pub(super) fn observe(
        &mut self,
        last: Option<&Sample>,
        sample: &Sample,
        signals: &[SignalTruth],
        figures: &mut ControlFigures,
    ) -> Option<Violation> {
        if self.first.is_none() {
            self.first = signals.first().map(|signal| signal.id);
        }
        let mut violation = None;
        if let Some(last) = last {
            for slot in 0..MAX_SIGNALS {
                if let Some(signal) = self.watched[slot] {
                    violation = violation.or(self.passage(last, sample, &signal, figures));
                }
            }
        }
        self.remember(signals);
        violation
    }

    /// Looks at one signal over the time from the sample before to this one.
    fn passage(
        &mut self,
        last: &Sample,
        sample: &Sample,
        signal: &SignalTruth,
        figures: &mut ControlFigures,
    ) -> Option<Violation> {
        let first = self.first == Some(signal.id);
        let (from, to) = (last.ego.position_m, sample.ego.position_m);
        let switch_s = signal.ends_ns.map(seconds);
        if let Some(switch_s) = switch_s
            && first
            && figures.past_stop_line_at_switch_m.is_none()
            && switch_s > last.time_s
            && switch_s <= sample.time_s
        {
            let share = (switch_s - last.time_s) / (sample.time_s - last.time_s);
            let place = from + share * (to - from);
            figures.past_stop_line_at_switch_m = Some(place - signal.stop_line_m);
        }
        if !(from < signal.stop_line_m && signal.stop_line_m <= to) {
            return None;
        }
        let share = (signal.stop_line_m - from) / (to - from);
        let time_s = last.time_s + share * (sample.time_s - last.time_s);
        if first && figures.stop_line_crossing_s.is_none() {
            figures.stop_line_crossing_s = Some(time_s);
        }
        if signal.phase_at(time_s) != Phase::Red {
            return None;
        }
        self.red_lights += 1;
        Some(Violation::RedLight { time_s, id: signal.id })
    }

    /// Keeps the signals for the next sample. A signal that is missing (out of radio range, or a lost message) stays
    /// as it was.
    fn remember(&mut self, signals: &[SignalTruth]) {
        for signal in signals.iter().filter(|signal| signal.stop_line_m.is_finite()) {
            let known = |slot: &&mut Option<SignalTruth>| slot.is_some_and(|s| s.id == signal.id);
            let slot = match self.watched.iter_mut().find(known) {
                Some(slot) => Some(slot),
                None => self.watched.iter_mut().min_by(|a, b| place(a).total_cmp(&place(b))),
            };
            if let Some(slot) = slot {
                *slot = Some(*signal);
            }
        }
    }
}

/// Order in which stored signals give way to new ones: free slots first, then the farthest behind.
fn place(slot: &Option<SignalTruth>) -> f64 {
    slot.map_or(f64::NEG_INFINITY, |signal| signal.stop_line_m)
}
