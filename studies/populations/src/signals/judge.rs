//! Figures of a drive through a corridor, beside the fastest legal trip and the bound.
//!
//! A trip ends well behind the last line, so that the speed at that line counts.
//!
//! A cycle is missed at a line if a red begins between two times: when the bound crosses it, with the delay that the
//! drive had at the line before, and when the drive crosses it. So it counts once, and not at the lines behind it.

use frame::batch::Done;
use report::Passing;
use scenario::Scenario;
use scenario::v2x::{Phase, Signal};
use serde::{Deserialize, Serialize};
use v2x_sim::program::Program;

use super::bound;
use super::corridor::Corridor;

/// Distance behind the last line at which a trip ends, m.
pub const BEYOND_M: f64 = 150.0;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    pub is_led: bool,
    /// Time before a line at which its countdown arrives at the set speed, s.
    pub ahead_s: f64,
    /// Trip time, s. It counts to the end of the run if the trip's end was not reached.
    pub trip_s: f64,
    /// The same beyond the fastest legal trip, s.
    pub excess_s: f64,
    /// The same at the last line, s.
    pub excess_at_line_s: f64,
    pub beyond_bound_s: f64,
    /// Stop lines that were not passed before the run's end.
    pub not_passed: usize,
    pub lines: usize,
    /// Those crossed a whole cycle later than the bound does.
    pub cycles_missed: usize,
}

impl Facts {
    /// Judges a drive through a corridor.
    pub fn of(corridor: &Corridor, scenario: &Scenario, done: &Done) -> Self {
        let control = &done.summary.control;
        let signals = &scenario.v2x.signals;
        let steps = &done.drive.steps;
        let passed_s: Vec<f64> = signals
            .iter()
            .map_while(|signal| supervise::passed_s(steps, signal.stop_line_m.value()))
            .collect();
        let ended_s = steps.last().map_or(0.0, |step| step.time_s);
        let end_m = BEYOND_M + corridor.last_line_m();
        let (at_line_s, fastest_s) = fastest(scenario, end_m);
        let bound_s = bound::earliest_s(corridor, end_m);
        let trip_s = supervise::passed_s(steps, end_m).unwrap_or(ended_s);
        Self {
            is_led: corridor.lead.is_some(),
            ahead_s: corridor.ahead_s,
            trip_s,
            excess_s: trip_s - fastest_s,
            beyond_bound_s: trip_s - bound_s.get(signals.len()).copied().unwrap_or(ended_s),
            excess_at_line_s: control.trip.trip_time_s.unwrap_or(ended_s) - at_line_s,
            not_passed: signals.len() - passed_s.len(),
            lines: signals.len(),
            cycles_missed: cycles_missed(signals, &bound_s, &passed_s),
        }
    }
}

/// Time when the fastest legal trip passes the last line and `end_m`, s; 0 where it never does.
fn fastest(scenario: &Scenario, end_m: f64) -> (f64, f64) {
    let start = Some(Passing::start(scenario));
    let mut signals = scenario.v2x.signals.iter();
    let last = signals.try_fold(start, |ego, signal| Some(ego?.past(scenario, signal))).flatten();
    let end = last.and_then(|last| last.along(scenario, end_m));
    (last.map_or(0.0, |last| last.time_s), end.map_or(0.0, |end| end.time_s))
}

/// Lines that were crossed a whole cycle later than by the bound.
fn cycles_missed(signals: &[Signal], bound_s: &[f64], passed_s: &[f64]) -> usize {
    let mut delay_s = 0.0;
    let mut missed = 0;
    for ((signal, bound_s), passed_s) in signals.iter().zip(bound_s).zip(passed_s) {
        missed += usize::from(turns_red_between(signal, bound_s + delay_s, *passed_s));
        delay_s = f64::max(passed_s - bound_s, 0.0);
    }
    missed
}

/// True if a signal turns red between two times.
fn turns_red_between(signal: &Signal, from_s: f64, to_s: f64) -> bool {
    let program = Program::new(signal);
    let mut intervals = program.intervals((from_s * 1e9) as u64);
    let mut from_s = intervals.next().and_then(|shown| shown.end_ns);
    for interval in intervals {
        if from_s.is_none_or(|begins_ns| begins_ns as f64 / 1e9 >= to_s) {
            return false;
        }
        if interval.phase == Phase::Red {
            return true;
        }
        from_s = interval.end_ns;
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scenario() -> Scenario {
        let signal = |id, line_m| {
            format!(
                "[[v2x.signals]]\nintersection_id = {id}\nstop_line_m = {line_m}\nprogram = [\
                 {{ phase = \"green\", duration_s = 20 }}, {{ phase = \"red\", duration_s = 20 }}]\n"
            )
        };
        let text = format!(
            "schema_version = 1\nname = \"x\"\nset_speed_mps = 10\n[plant]\ninitial_speed_mps = 10\n{}{}",
            signal(1, 150),
            signal(2, 300)
        );
        Scenario::parse("x.toml", &text).expect("the keys are right")
    }

    #[test]
    fn a_missed_cycle_is_counted_at_its_line_alone() {
        // 15 s to the first line in green; the second is red from 20 to 40 s.
        let scenario = scenario();
        let missed =
            |passed_s: &[f64]| cycles_missed(&scenario.v2x.signals, &[15.0, 40.0], passed_s);
        assert_eq!(missed(&[16.0, 41.0]), 0);
        // A cycle at the first line delays the second as well, which is then reached in green.
        assert_eq!(missed(&[41.0, 57.0]), 1);
        assert_eq!(missed(&[16.0, 81.0]), 1);
        assert_eq!(missed(&[41.0, 121.0]), 2);
        assert_eq!(missed(&[16.0]), 0);
    }
}
