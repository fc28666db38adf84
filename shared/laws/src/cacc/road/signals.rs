//! Memory of the signals ahead.
//!
//! An announced stop line stays until it is passed. A signal that falls silent, or whose phase becomes unknown, does
//! not count as green. Its last announcement is kept, in absolute time, for a vehicle that can no longer stop
//! comfortably.

use law::{Input, MAX_PHASES, MAX_SIGNALS, Phase, SignalAhead};

/// Ids of signals: that of the intersection times this, plus the signal group's.
const GROUPS: u32 = 256;

/// A phase that is missing for no longer than this is the one that was announced, s.
const BRIDGED_S: f64 = 0.25;
/// Two announcements of one end differ by no more than this, s.
const SAME_END_S: f64 = 0.35;

/// A time during which a line may be crossed, on the clock of [`Input::time_s`], s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Green {
    /// Start of green.
    pub(super) from_s: f64,
    /// Earliest end of green. A pass counts on no later one, except where the filter can stop for it.
    pub(super) to_s: f64,
    /// Likely end of the shown green, if it differs; infinite if it is not known.
    pub(super) likely_s: f64,
    /// End of the yellow that follows; the end of green where none is announced.
    pub(super) clear_s: f64,
}

/// A stop line ahead and what its signal announced.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Line {
    /// Intersection and signal group.
    pub(super) id: u32,
    /// Position of the stop line on the ego's odometer, m.
    pub(super) at_m: f64,
    /// True if the current phase is known.
    pub(super) known: bool,
    /// Time when the phase was last known, s.
    heard_s: f64,
    greens: [Green; MAX_PHASES],
    count: usize,
}

impl Line {
    /// The announced greens that have not ended, and the one whose yellow has not, in order of
    /// time.
    pub(super) fn greens(&self) -> &[Green] {
        &self.greens[..self.count]
    }

    /// The green, or its yellow, that is shown at `now_s`. If a line's signal is silent, only a green that was shown
    /// before counts. A green that was announced for later may not have come.
    pub(super) fn shown(&self, now_s: f64) -> Option<&Green> {
        let heard = if self.known { now_s } else { self.heard_s };
        self.greens().iter().find(|green| green.from_s <= heard && now_s < green.clear_s)
    }

    fn read(&mut self, signal: &SignalAhead, now_s: f64) {
        let before = self.greens;
        let intervals = &signal.intervals[..signal.count.min(MAX_PHASES)];
        let mut from = now_s;
        let mut count = 0;
        let mut greens = [Green::default(); MAX_PHASES];
        let mut first = true;
        for interval in intervals {
            let to = now_s + interval.ends_in_s;
            // An interval that is over, or one out of order, shows nothing about the future.
            if !(interval.ends_in_s > 0.0 && to >= from) {
                continue;
            }
            match interval.phase {
                Phase::Green => {
                    let likely_s = if first { to.max(now_s + signal.likely_s) } else { to };
                    greens[count] = Green { from_s: from, to_s: to, likely_s, clear_s: to };
                    count += 1;
                }
                Phase::Yellow if count > 0 && greens[count - 1].to_s == from => {
                    greens[count - 1].clear_s = to;
                }
                Phase::Yellow if first => {
                    // The green that this yellow follows ended when it was last announced to.
                    let same = |green: &&Green| (green.clear_s - to).abs() <= SAME_END_S;
                    let known = before[..self.count].iter().find(same);
                    let to_s = known.map_or(from, |green| green.to_s.min(from));
                    greens[count] = Green { from_s: to_s, to_s, likely_s: to_s, clear_s: to };
                    count += 1;
                }
                Phase::Yellow | Phase::Red => {}
                Phase::Unknown => break,
            }
            // A red opens the line when another phase is shown: its likely end serves to plan.
            let is_likely = first && interval.phase == Phase::Red && signal.likely_s > 0.0;
            from = if is_likely { to.min(now_s + signal.likely_s) } else { to };
            first = false;
        }
        // Between the end of green and the next message, the yellow that was announced for then holds.
        let heard_s = self.heard_s;
        let was_open = |green: &Green| green.from_s <= heard_s && now_s < green.clear_s;
        let bridged = now_s - heard_s <= BRIDGED_S && self.greens().first().is_some_and(was_open);
        self.known = !first || bridged;
        if !first {
            self.heard_s = now_s;
            self.greens = greens;
            self.count = count;
        }
    }
}

/// The lines ahead, nearest first.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SignalMemory {
    lines: [Line; MAX_SIGNALS],
    count: usize,
}

impl SignalMemory {
    /// The lines ahead, nearest first.
    pub(super) fn lines(&self) -> &[Line] {
        &self.lines[..self.count]
    }

    /// Takes in what is announced and drops what is passed.
    pub(super) fn update(&mut self, input: &Input) {
        for line in &mut self.lines[..self.count] {
            line.known = false;
        }
        for signal in input.signals.iter().flatten() {
            if signal.distance_m.is_finite() {
                self.take(signal, input);
            }
        }
        let mut kept = 0;
        for i in 0..self.count {
            let is_ahead = self.lines[i].at_m > input.ego.position_m;
            if is_ahead && !is_replaced(self.lines[i].id, input) {
                self.lines[kept] = self.lines[i];
                kept += 1;
            }
        }
        self.count = kept;
        self.lines[..kept].sort_unstable_by(|a, b| a.at_m.total_cmp(&b.at_m));
    }

    fn take(&mut self, signal: &SignalAhead, input: &Input) {
        let at_m = input.ego.position_m + signal.distance_m;
        let known = (0..self.count).find(|&i| self.lines[i].id == signal.id);
        let slot = match known {
            Some(i) => i,
            None if signal.distance_m <= 0.0 => return,
            None if self.count < MAX_SIGNALS => {
                self.count += 1;
                self.count - 1
            }
            // Full: the farthest gives way to a nearer one.
            None => {
                let farthest = self.count - 1;
                if self.lines[farthest].at_m <= at_m {
                    return;
                }
                farthest
            }
        };
        if known.is_none() {
            self.lines[slot] = Line { id: signal.id, ..Line::default() };
        }
        self.lines[slot].at_m = at_m;
        self.lines[slot].read(signal, input.time_s);
    }
}

/// True if the map of a line's intersection no longer has it: another map is in force. In a full list it may only have
/// been
/// left out.
fn is_replaced(id: u32, input: &Input) -> bool {
    let is_full = input.signals.iter().all(Option::is_some);
    let mut told = input.signals.iter().flatten();
    let of_same = |other: &SignalAhead| other.id / GROUPS == id / GROUPS;
    !is_full && told.clone().any(of_same) && told.all(|other| other.id != id)
}

#[cfg(test)]
mod tests {
    use super::*;
    use law::{Ego, PhaseInterval};

    fn input(position_m: f64, time_s: f64, signal: Option<SignalAhead>) -> Input {
        let ego = Ego { position_m, ..Ego::default() };
        let mut input = Input { time_s, ego, ..Input::default() };
        input.signals[0] = signal;
        input
    }

    fn signal(distance_m: f64, phases: &[(Phase, f64)]) -> SignalAhead {
        let count = phases.len();
        let mut signal = SignalAhead { id: 7, distance_m, count, ..SignalAhead::default() };
        for (slot, &(phase, ends_in_s)) in signal.intervals.iter_mut().zip(phases) {
            *slot = PhaseInterval { phase, ends_in_s };
        }
        signal
    }

    #[test]
    fn greens_carry_their_yellow() {
        let mut memory = SignalMemory::default();
        let phases = [
            (Phase::Yellow, 2.0),
            (Phase::Red, 10.0),
            (Phase::Green, 30.0),
            (Phase::Yellow, 33.0),
            (Phase::Red, 50.0),
        ];
        memory.update(&input(100.0, 5.0, Some(signal(80.0, &phases))));
        let line = memory.lines()[0];
        assert_eq!((line.at_m, line.known), (180.0, true));
        let expected = [
            Green { from_s: 5.0, to_s: 5.0, likely_s: 5.0, clear_s: 7.0 },
            Green { from_s: 15.0, to_s: 35.0, likely_s: 35.0, clear_s: 38.0 },
        ];
        assert_eq!(line.greens(), expected);
    }

    #[test]
    fn a_yellow_keeps_the_end_of_its_green() {
        let mut memory = SignalMemory::default();
        let green = [(Phase::Green, 2.0), (Phase::Yellow, 5.0), (Phase::Red, 20.0)];
        memory.update(&input(0.0, 0.0, Some(signal(50.0, &green))));
        for time_s in [3.0, 3.5] {
            let yellow = [(Phase::Yellow, 5.0 - time_s), (Phase::Red, 17.0)];
            memory.update(&input(10.0, time_s, Some(signal(40.0, &yellow))));
            assert_eq!(
                memory.lines()[0].greens()[0],
                Green { from_s: 2.0, to_s: 2.0, likely_s: 2.0, clear_s: 5.0 }
            );
        }
    }

    #[test]
    fn a_likely_end_plans_and_the_earliest_one_is_kept() {
        let mut memory = SignalMemory::default();
        let phases = [(Phase::Green, 0.4), (Phase::Yellow, 3.0)];
        let open = SignalAhead { likely_s: f64::INFINITY, ..signal(80.0, &phases) };
        memory.update(&input(0.0, 5.0, Some(open)));
        let green = Green { from_s: 5.0, to_s: 5.4, likely_s: f64::INFINITY, clear_s: 8.0 };
        assert_eq!(memory.lines()[0].greens(), [green]);
        let red = [(Phase::Red, 20.0), (Phase::Green, 30.0)];
        memory.update(&input(0.0, 9.0, Some(SignalAhead { likely_s: 6.0, ..signal(80.0, &red) })));
        let green = Green { from_s: 15.0, to_s: 39.0, likely_s: 39.0, clear_s: 39.0 };
        assert_eq!(memory.lines()[0].greens(), [green]);
        assert!(memory.lines()[0].shown(9.0).is_none());
    }

    #[test]
    fn a_gap_between_two_messages_is_bridged_for_what_was_open_alone() {
        let unknown = || Some(signal(50.0, &[(Phase::Unknown, 9.0)]));
        let told = |phases: &[(Phase, f64)]| {
            let mut memory = SignalMemory::default();
            memory.update(&input(0.0, 0.0, Some(signal(50.0, phases))));
            memory
        };
        let mut green = told(&[(Phase::Green, 0.1), (Phase::Yellow, 3.0)]);
        green.update(&input(0.0, 0.2, unknown()));
        assert!(green.lines()[0].known && green.lines()[0].shown(0.2).is_some());
        green.update(&input(0.0, 0.4, unknown()));
        assert!(!green.lines()[0].known);
        let mut red = told(&[(Phase::Red, 0.1), (Phase::Green, 9.0)]);
        red.update(&input(0.0, 0.2, unknown()));
        assert!(!red.lines()[0].known);
    }

    #[test]
    fn a_silent_signal_stays_unknown_until_it_is_passed() {
        let mut memory = SignalMemory::default();
        memory.update(&input(0.0, 0.0, Some(signal(50.0, &[(Phase::Green, 9.0)]))));
        memory.update(&input(10.0, 1.0, None));
        assert_eq!(memory.lines().len(), 1);
        assert!(!memory.lines()[0].known);
        assert_eq!(memory.lines()[0].shown(8.9).map(|green| green.to_s), Some(9.0));
        assert_eq!(memory.lines()[0].shown(9.1), None);
        memory.update(&input(20.0, 2.0, Some(signal(30.0, &[(Phase::Unknown, 9.0)]))));
        assert!(!memory.lines()[0].known);
        memory.update(&input(50.5, 4.0, None));
        assert!(memory.lines().is_empty());
    }

    #[test]
    fn a_line_that_its_intersection_no_longer_has_is_dropped() {
        let mut memory = SignalMemory::default();
        let of =
            |id, distance_m| Some(SignalAhead { id, ..signal(distance_m, &[(Phase::Red, 9.0)]) });
        memory.update(&input(0.0, 0.0, of(512, 50.0)));
        memory.update(&input(0.0, 1.0, of(770, 90.0)));
        assert_eq!(memory.lines().len(), 2, "another intersection");
        memory.update(&input(0.0, 2.0, of(513, 80.0)));
        let at_m: Vec<f64> = memory.lines().iter().map(|line| line.at_m).collect();
        assert_eq!(at_m, [80.0, 90.0]);
    }

    #[test]
    fn a_green_announced_for_later_is_not_shown_when_it_is_not_received() {
        let mut memory = SignalMemory::default();
        let phases = [(Phase::Red, 3.0), (Phase::Green, 20.0)];
        memory.update(&input(0.0, 0.0, Some(signal(50.0, &phases))));
        assert!(memory.lines()[0].shown(1.0).is_none());
        memory.update(&input(1.0, 4.0, None));
        assert!(memory.lines()[0].shown(4.0).is_none());
    }
}
