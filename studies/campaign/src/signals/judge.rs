//! Figures of a drive through a corridor, beside the fastest legal trip.
//!
//! A trip ends well behind the last line, so that the speed at that line counts.
//!
//! A green is the first that could be reached from the line before, not beyond the lead. It is used if the line is
//! crossed before the red that follows it. So a missed green counts once, at its line, and not at the lines behind it.

use super::draw::Corridor;
use frame::batch::Done;
use group::report::Outcome;
use group::{DriveStep, RequirementVerdict};
use report::Passing;
use scenario::Scenario;
use scenario::v2x::{Phase, Signal};
use serde::{Deserialize, Serialize};
use v2x_sim::program::Program;

/// Distance behind the last line at which a trip ends, m.
pub const BEYOND_M: f64 = 150.0;

/// The record of a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// The corridor's number, from 1.
    pub corridor: usize,
    /// The law.
    pub law: String,
    /// True if there was a lead.
    pub is_led: bool,
    /// Time before a line at which its countdown arrives at the set speed, s.
    pub ahead_s: f64,
    /// End of the run.
    pub outcome: Outcome,
    /// Trip time beyond the fastest legal trip, s. It counts to the end of the run if the trip's end was not reached.
    pub excess_s: f64,
    /// The same at the last line, s.
    pub excess_at_line_s: f64,
    /// Trip time beyond the fastest legal trip that stays behind the lead, s.
    pub excess_behind_lead_s: f64,
    /// Stop lines that were not passed before the run's end.
    pub not_passed: usize,
    /// Stop lines of the corridor.
    pub lines: usize,
    /// Those crossed in the first green that could be reached.
    pub greens_used: usize,
    /// Standstills.
    pub stops: u64,
    /// Energy at the wheels.
    pub energy_kwh_per_100km: Option<f64>,
    /// Root mean square of the jerk.
    pub rms_jerk_mps3: Option<f64>,
    /// Largest jerk.
    pub max_jerk_mps3: Option<f64>,
    /// Times that the emergency brake braked.
    pub interventions: u64,
    /// The laws of the user's own and the requirements of the command, as its words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub options: Vec<String>,
    /// Verdicts on the requirements.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub requirements: Vec<RequirementVerdict>,
}

impl Kept {
    /// Judges a drive.
    pub fn of(corridor: usize, scenario: &Scenario, done: &Done) -> Self {
        let control = &done.summary.control;
        let figures = &control.figures;
        let signals = &scenario.v2x.signals;
        let steps = &done.drive.steps;
        let passed: Vec<Passing> =
            signals.iter().map_while(|signal| passing(signal.stop_line_m.value(), steps)).collect();
        let ended_s = steps.last().map_or(0.0, |step| step.time_s);
        let end_m = BEYOND_M + signals.last().map_or(0.0, |signal| signal.stop_line_m.value());
        let lead = Corridor::new(corridor as u64).lead;
        let rear = |time_s: f64| lead.as_ref().map_or(f64::INFINITY, |lead| lead.rear_m(time_s));
        let (at_line_s, fastest_s) = fastest(scenario, end_m, &report::nothing_ahead);
        let (_, behind_lead_s) = fastest(scenario, end_m, &rear);
        let trip_s = passing(end_m, steps).map_or(ended_s, |end| end.time_s);
        Self {
            corridor,
            law: done.summary.controller.clone(),
            is_led: !scenario.actors.is_empty(),
            ahead_s: Corridor::new(corridor as u64).ahead_s,
            outcome: done.summary.outcome,
            excess_s: trip_s - fastest_s,
            excess_behind_lead_s: trip_s - behind_lead_s,
            excess_at_line_s: control.trip.trip_time_s.unwrap_or(ended_s) - at_line_s,
            not_passed: signals.len() - passed.len(),
            lines: signals.len(),
            greens_used: greens_used(scenario, &passed, &rear),
            stops: figures.stops.unwrap_or(0),
            energy_kwh_per_100km: figures.wheel_energy_kwh_per_100km,
            rms_jerk_mps3: figures.rms_jerk_mps3,
            max_jerk_mps3: figures.max_abs_jerk_mps3,
            interventions: done.summary.aebs.interventions.unwrap_or(0),
            options: Vec::new(),
            requirements: done.summary.requirements.clone(),
        }
    }

    /// The run broke no requirement.
    pub fn holds(&self) -> bool {
        self.outcome == Outcome::Completed
    }

    /// The command that repeats all drives of its corridor.
    pub fn repeat(&self) -> String {
        let number = self.corridor.to_string();
        let words = ["timegap", "campaign", "signals", "--first", &number, "--seeds", "1"];
        let own = self.options.iter().map(String::as_str);
        runtime::command_line(&words.into_iter().chain(own).collect::<Vec<_>>())
    }

    /// The failure, and the command that repeats it.
    pub fn failure(&self) -> String {
        let outcome = report::print::outcome_word(self.outcome).to_lowercase();
        format!("corridor {}, {}: {outcome}; to repeat: {}", self.corridor, self.law, self.repeat())
    }

    #[cfg(test)]
    pub(super) fn example(law: &str, excess_s: f64) -> Self {
        Self {
            corridor: 1,
            law: law.to_owned(),
            is_led: false,
            ahead_s: 10.0,
            outcome: Outcome::Completed,
            excess_s,
            excess_at_line_s: excess_s,
            excess_behind_lead_s: excess_s,
            not_passed: 0,
            lines: 3,
            greens_used: 3,
            stops: 0,
            energy_kwh_per_100km: None,
            rms_jerk_mps3: None,
            max_jerk_mps3: None,
            interventions: 0,
            options: Vec::new(),
            requirements: Vec::new(),
        }
    }
}

/// Time and speed at which a place was passed.
fn passing(line_m: f64, steps: &[DriveStep]) -> Option<Passing> {
    let pair = steps.windows(2).find(|pair| pair[1].position_m >= line_m)?;
    let way_m = pair[1].position_m - pair[0].position_m;
    let share = if way_m > 0.0 { (line_m - pair[0].position_m) / way_m } else { 0.0 };
    let time_s = pair[0].time_s + share * (pair[1].time_s - pair[0].time_s);
    Some(Passing { time_s, place_m: line_m, speed_mps: pair[1].speed_mps })
}

/// Time when the fastest legal trip passes the last line and `end_m`, s; 0 where it never does.
fn fastest(scenario: &Scenario, end_m: f64, ahead: &dyn Fn(f64) -> f64) -> (f64, f64) {
    let start = Some(Passing::start(scenario));
    let mut signals = scenario.v2x.signals.iter();
    let last =
        signals.try_fold(start, |ego, signal| Some(ego?.past(scenario, signal, ahead))).flatten();
    let end = last.and_then(|last| last.along(scenario, end_m, ahead));
    (last.map_or(0.0, |last| last.time_s), end.map_or(0.0, |end| end.time_s))
}

/// Lines that were crossed in the first green that could be reached from the line before.
fn greens_used(scenario: &Scenario, passed: &[Passing], ahead: &dyn Fn(f64) -> f64) -> usize {
    let mut from = Passing::start(scenario);
    let mut used = 0;
    for (signal, passing) in scenario.v2x.signals.iter().zip(passed) {
        let first = from.past(scenario, signal, ahead);
        let earliest_s = first.map_or(f64::INFINITY, |first| first.time_s);
        used += usize::from(!is_red_between(signal, earliest_s, passing.time_s));
        from = *passing;
    }
    used
}

/// True if a signal shows red somewhere between two times.
fn is_red_between(signal: &Signal, from_s: f64, to_s: f64) -> bool {
    let program = Program::new(signal);
    for interval in program.intervals((from_s * 1e9) as u64) {
        let is_over = interval.end_ns.is_none_or(|end_ns| end_ns as f64 / 1e9 >= to_s);
        match (interval.phase, is_over) {
            (Phase::Red, _) => return true,
            (_, true) => return false,
            (_, false) => {}
        }
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
    fn a_missed_green_is_counted_at_its_line_alone() {
        let at = |time_s, place_m| Passing { time_s, place_m, speed_mps: 10.0 };
        let greens_used = |scenario: &Scenario, passed: &[Passing]| {
            greens_used(scenario, passed, &report::nothing_ahead)
        };
        // 15 s to the first line in green; the second is red from 20 to 40 s.
        let scenario = scenario();
        assert_eq!(greens_used(&scenario, &[at(16.0, 150.0), at(41.0, 300.0)]), 2);
        // The first green is missed; from there the second line is reached in green.
        assert_eq!(greens_used(&scenario, &[at(41.0, 150.0), at(57.0, 300.0)]), 1);
        assert_eq!(greens_used(&scenario, &[at(16.0, 150.0), at(81.0, 300.0)]), 1);
        assert_eq!(greens_used(&scenario, &[at(16.0, 150.0)]), 1);
    }
}
