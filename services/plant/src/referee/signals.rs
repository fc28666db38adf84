//! Stop lines: when the ego crosses them, and what their signals show then.

use messages::{Lane, PhaseState, Signal};
use scenario::v2x::Phase;
use serde::{Deserialize, Serialize};

use super::{Sample, Violation, seconds};
use crate::report::ControlFigures;

/// Most signals watched at a time.
const MAX_SIGNALS: usize = 16;

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
    pub next_phase: Phase,
}

/// Lanes and signals of the ground truth, nearest first.
pub(crate) fn shown(truth: &messages::SignalTruth) -> impl Iterator<Item = (&Lane, &Signal)> {
    truth.lanes().iter().zip(truth.signals())
}

impl SignalTruth {
    /// The signals of the ground truth. A state that no simulator sends counts as red.
    pub(crate) fn all(truth: &messages::SignalTruth) -> impl Iterator<Item = Self> {
        let phase = |state| match PhaseState::from_wire(state) {
            PhaseState::ProtectedMovementAllowed => Phase::Green,
            PhaseState::ProtectedClearance => Phase::Yellow,
            PhaseState::StopAndRemain | PhaseState::Unavailable => Phase::Red,
        };
        shown(truth).map(move |(lane, signal)| {
            let [now, next] = [signal.intervals[0], signal.intervals[1]];
            let end_s = now.likely_end_s;
            Self {
                id: lane.intersection_id.wrapping_mul(256).wrapping_add(lane.signal_group),
                stop_line_m: lane.stop_line_m,
                phase: phase(now.state),
                ends_ns: end_s.is_finite().then(|| (end_s * 1e9).round() as u64),
                next_phase: phase(if signal.count > 1 { next.state } else { now.state }),
            }
        })
    }

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
        signals: impl Iterator<Item = SignalTruth>,
        figures: &mut ControlFigures,
    ) -> Option<Violation> {
        let mut violation = None;
        if let Some(last) = last {
            for signal in self.watched.into_iter().flatten() {
                violation = violation.or(self.passage(last, sample, &signal, figures));
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
    fn remember(&mut self, signals: impl Iterator<Item = SignalTruth>) {
        for signal in signals {
            self.first.get_or_insert(signal.id);
            if !signal.stop_line_m.is_finite() {
                continue;
            }
            let known = |slot: &&mut Option<SignalTruth>| slot.is_some_and(|s| s.id == signal.id);
            let slot = match self.watched.iter_mut().find(known) {
                Some(slot) => Some(slot),
                None => self.watched.iter_mut().min_by(|a, b| place(a).total_cmp(&place(b))),
            };
            if let Some(slot) = slot {
                *slot = Some(signal);
            }
        }
    }
}

/// Order in which stored signals give way to new ones: free slots first, then the farthest behind.
fn place(slot: &Option<SignalTruth>) -> f64 {
    slot.map_or(f64::NEG_INFINITY, |signal| signal.stop_line_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn signals_show_their_phase_its_end_and_the_next_one() {
        let mut truth = messages::SignalTruth::zeroed();
        truth.count = 2;
        for (place, (intersection, line_m)) in [(3, 80.0), (4, 200.0)].into_iter().enumerate() {
            truth.lanes[place].intersection_id = intersection;
            truth.lanes[place].signal_group = 2;
            truth.lanes[place].stop_line_m = line_m;
        }
        let green = PhaseState::ProtectedMovementAllowed.to_wire();
        let yellow = PhaseState::ProtectedClearance.to_wire();
        truth.signals[0].count = 2;
        (truth.signals[0].intervals[0].state, truth.signals[0].intervals[0].likely_end_s) =
            (green, 2.5);
        truth.signals[0].intervals[1].state = yellow;
        truth.signals[1].count = 1;
        (truth.signals[1].intervals[0].state, truth.signals[1].intervals[0].likely_end_s) =
            (yellow, f64::INFINITY);
        truth.signals[1].intervals[1].state = green;
        let first = SignalTruth {
            id: 3 * 256 + 2,
            stop_line_m: 80.0,
            phase: Phase::Green,
            ends_ns: Some(2_500_000_000),
            next_phase: Phase::Yellow,
        };
        let second = SignalTruth {
            id: 4 * 256 + 2,
            stop_line_m: 200.0,
            phase: Phase::Yellow,
            ends_ns: None,
            next_phase: Phase::Yellow,
        };
        assert!(SignalTruth::all(&truth).eq([first, second]));
    }
}
