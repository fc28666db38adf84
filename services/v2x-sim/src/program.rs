//! Fixed-time signal programs.
//!
//! A program is a list of phases with durations. It begins `offset` before the start of the run and repeats, or runs
//! once and stays in its last phase. Times are whole nanoseconds, so that the millionth cycle is as exact as the
//! first.
//!
//! ```text
//!          ├── green 27 s ──┼ yellow 3 s ┼── red 30 s ──┼── green …
//! ◄─offset─►
//!       start of the run
//! ```
//!
//! Equal neighbouring phases are one interval, also across the end of a cycle. So the end of an interval is always a
//! change, and a countdown never jumps.
//!
//! ```
//! use scenario::{Scenario, builtin, v2x::Phase};
//! use v2x_sim::program::Program;
//!
//! let corridor = Scenario::parse("corridor", builtin::find("corridor").expect("built in").text)?;
//! let program = Program::new(&corridor.v2x.signals[0]);
//! let phase_at = |time_ns| program.intervals(time_ns).next().map(|interval| interval.phase);
//! assert_eq!(phase_at(26_999_999_999), Some(Phase::Green));
//! assert_eq!(phase_at(27_000_000_000), Some(Phase::Yellow));
//! let ends: Vec<_> = program.intervals(0).map(|interval| interval.end_ns).take(2).collect();
//! assert_eq!(ends, [Some(27_000_000_000), Some(30_000_000_000)]);
//! # Ok::<(), scenario::ScenarioError>(())
//! ```

use scenario::v2x::{Phase, Signal};

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Program {
    /// Phases and their ends from the cycle's start, ns.
    phases: Vec<(Phase, u64)>,
    cycle_ns: u64,
    offset_ns: u64,
    repeat: bool,
}

/// Interval in which a signal shows one phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    pub phase: Phase,
    /// End, ns since the start of the run; `None` for an interval without an end.
    pub end_ns: Option<u64>,
}

impl Program {
    /// The program of a signal, which has at least one phase in a checked scenario.
    pub fn new(signal: &Signal) -> Self {
        let mut merged: Vec<(Phase, u64)> = Vec::with_capacity(signal.program.len());
        for step in &signal.program {
            let duration_ns = step.duration_s.nanoseconds();
            match merged.last_mut() {
                Some((phase, total_ns)) if *phase == step.phase => *total_ns += duration_ns,
                _ => merged.push((step.phase, duration_ns)),
            }
        }
        let mut offset_ns = signal.offset_s.nanoseconds();
        if signal.repeat && merged.len() > 1 && merged[0].0 == merged[merged.len() - 1].0 {
            let (_, wrapped_ns) = merged.pop().expect("it has more than one phase");
            merged[0].1 += wrapped_ns;
            offset_ns += wrapped_ns;
        }
        let mut cycle_ns = 0;
        for (_, time_ns) in &mut merged {
            cycle_ns += *time_ns;
            *time_ns = cycle_ns;
        }
        Self { phases: merged, cycle_ns, offset_ns, repeat: signal.repeat }
    }

    /// The intervals from a time on, ns since the start of the run. At the instant of a change, the new one is the first.
    pub fn intervals(&self, time_ns: u64) -> impl Iterator<Item = Interval> + '_ {
        let (mut start_ns, mut index) = self.locate(time_ns);
        let mut over = false;
        std::iter::from_fn(move || {
            if over {
                return None;
            }
            let (phase, phase_end_ns) = self.phases[index];
            let last = index + 1 == self.phases.len();
            over = (last && !self.repeat) || self.phases.len() == 1;
            if over {
                return Some(Interval { phase, end_ns: None });
            }
            // With a positive offset the cycle starts before the run.
            let end_ns = (start_ns + phase_end_ns).saturating_sub(self.offset_ns);
            index = if last { 0 } else { index + 1 };
            start_ns += if last { self.cycle_ns } else { 0 };
            Some(Interval { phase, end_ns: Some(end_ns) })
        })
    }

    /// Start of the current cycle in the program's own time (which is ahead by the offset), and index of the current
    /// phase.
    fn locate(&self, time_ns: u64) -> (u64, usize) {
        let program_ns = time_ns.saturating_add(self.offset_ns);
        let start_ns = if self.repeat { program_ns - program_ns % self.cycle_ns } else { 0 };
        let into_ns = program_ns - start_ns;
        let index = self.phases.partition_point(|(_, end_ns)| *end_ns <= into_ns);
        (start_ns, index.min(self.phases.len() - 1))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use scenario::quantity::{Distance, Duration, IntersectionId, SignalGroupId, Time};
    use scenario::v2x::ProgramPhase;

    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn phase_at(program: &Program, time_ns: u64) -> Phase {
        program.intervals(time_ns).next().expect("one is always current").phase
    }

    fn program(phases: &[(Phase, f64)], offset_s: f64, repeat: bool) -> Program {
        Program::new(&Signal {
            stop_line_m: Distance::of(100.0),
            intersection_id: IntersectionId::of(1),
            signal_group: SignalGroupId::of(1),
            offset_s: Time::of(offset_s),
            repeat,
            program: phases
                .iter()
                .map(|&(phase, s)| ProgramPhase { phase, duration_s: Duration::of(s) })
                .collect(),
        })
    }

    fn cycle(offset_s: f64) -> Program {
        let phases = [(Phase::Green, 27.0), (Phase::Yellow, 3.0), (Phase::Red, 30.0)];
        program(&phases, offset_s, true)
    }

    #[test]
    fn phases_follow_each_other_round_and_round() {
        let program = cycle(0.0);
        for start in [0, 60, 60 * 1_000_000] {
            let at = |s: u64| phase_at(&program, (start + s) * SECOND);
            assert_eq!(at(0), Phase::Green);
            assert_eq!(phase_at(&program, (start + 27) * SECOND - 1), Phase::Green);
            assert_eq!(at(27), Phase::Yellow);
            assert_eq!(at(30), Phase::Red);
            assert_eq!(at(59), Phase::Red);
        }
    }

    #[test]
    fn the_offset_moves_the_program_ahead() {
        let program = cycle(34.0);
        assert_eq!(phase_at(&program, 0), Phase::Red);
        assert_eq!(phase_at(&program, 26 * SECOND - 1), Phase::Red);
        assert_eq!(phase_at(&program, 26 * SECOND), Phase::Green);
        let ends: Vec<_> = program.intervals(0).take(3).map(|i| i.end_ns).collect();
        assert_eq!(ends, [Some(26 * SECOND), Some(53 * SECOND), Some(56 * SECOND)]);
        assert_eq!(phase_at(&cycle(60.0), 0), Phase::Green);
        assert_eq!(phase_at(&cycle(34.0 + 600.0), 26 * SECOND), Phase::Green);
    }

    #[test]
    fn a_program_that_runs_once_ends_in_its_last_phase() {
        let program = program(&[(Phase::Green, 5.0), (Phase::Red, 1.0)], 0.0, false);
        let intervals: Vec<_> = program.intervals(0).collect();
        assert_eq!(
            intervals,
            [
                Interval { phase: Phase::Green, end_ns: Some(5 * SECOND) },
                Interval { phase: Phase::Red, end_ns: None },
            ]
        );
        assert_eq!(phase_at(&program, 1000 * SECOND), Phase::Red);
        assert_eq!(program.intervals(1000 * SECOND).count(), 1);
        let late = self::program(&[(Phase::Green, 5.0), (Phase::Red, 1.0)], 50.0, false);
        assert_eq!(late.intervals(0).collect::<Vec<_>>(), intervals[1..]);
    }

    #[test]
    fn equal_neighbours_are_one_interval_across_the_cycles_end_too() {
        let split =
            [(Phase::Red, 10.0), (Phase::Green, 4.0), (Phase::Green, 6.0), (Phase::Red, 5.0)];
        let program = program(&split, 0.0, true);
        let ends: Vec<_> = program.intervals(0).take(4).map(|i| (i.phase, i.end_ns)).collect();
        let at = |s: u64| Some(s * SECOND);
        assert_eq!(
            ends,
            [
                (Phase::Red, at(10)),
                (Phase::Green, at(20)),
                (Phase::Red, at(35)),
                (Phase::Green, at(45))
            ]
        );
        let constant = self::program(&[(Phase::Green, 4.0), (Phase::Green, 6.0)], 3.0, true);
        assert_eq!(
            constant.intervals(7 * SECOND).collect::<Vec<_>>(),
            [Interval { phase: Phase::Green, end_ns: None }]
        );
    }

    fn phases() -> impl Strategy<Value = Phase> {
        prop_oneof![Just(Phase::Green), Just(Phase::Yellow), Just(Phase::Red)]
    }

    proptest! {
        #[test]
        fn the_announced_phases_follow(
            list in prop::collection::vec((phases(), 0.001..90.0f64), 1..10),
            offset_s in 0.0..500.0f64, repeat: bool, time_ns in 0..2_000_000_000_000u64,
        ) {
            let program = program(&list, offset_s, repeat);
            let mut from_ns = time_ns;
            for interval in program.intervals(time_ns).take(8) {
                prop_assert_eq!(phase_at(&program, from_ns), interval.phase);
                let Some(end_ns) = interval.end_ns else {
                    prop_assert_eq!(phase_at(&program, u64::MAX / 4), interval.phase);
                    break;
                };
                prop_assert!(end_ns > from_ns);
                prop_assert_eq!(phase_at(&program, end_ns - 1), interval.phase);
                prop_assert_ne!(phase_at(&program, end_ns), interval.phase);
                from_ns = end_ns;
            }
        }

        #[test]
        fn a_countdown_falls_exactly_as_time_passes(
            list in prop::collection::vec((phases(), 0.5..90.0f64), 1..6),
            offset_s in 0.0..500.0f64, start_ns in 0..100_000_000_000u64,
        ) {
            let program = program(&list, offset_s, true);
            let mut before: Option<Interval> = None;
            for k in 0..2000u64 {
                let now_ns = start_ns + k * 100_000_000;
                let interval = program.intervals(now_ns).next().expect("one is always current");
                if let Some(Interval { end_ns: Some(end_ns), phase }) = before {
                    // The announced end stands until it comes, then the phase changes.
                    if now_ns < end_ns {
                        prop_assert_eq!(interval.end_ns, Some(end_ns));
                        prop_assert_eq!(interval.phase, phase);
                    } else {
                        prop_assert!(interval.end_ns.is_none_or(|next_ns| next_ns > end_ns));
                    }
                }
                before = Some(interval);
            }
        }
    }
}
