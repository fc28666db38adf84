//! Progress through signals: the time of the last stop line, and its lower bound.
//!
//! The fastest legal trip is that bound. It respects the set speed, the speed limit and the vehicle's acceleration. It
//! crosses no stop line on red, and meets no other traffic. It arrives at each line at the instant of green, with the
//! highest speed that is possible there.

use crate::{DriveStep, passed_s};
use scenario::Scenario;
use scenario::plant::Plant;
use scenario::v2x::{Phase, Signal};
use serde::{Deserialize, Serialize};
use v2x_sim::program::Program;

/// Step of the fastest trip, s.
const STEP_S: f64 = 0.01;
/// Longest trip that is considered, s.
const LONGEST_S: f64 = 36_000.0;

/// A trip past the last signal of the road, s; null without signals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Trip {
    /// Time at which the ego's front passed the last stop line; null if it did not.
    pub trip_time_s: Option<f64>,
    /// Time of the fastest legal trip; null for trucks.
    pub fastest_legal_trip_s: Option<f64>,
    /// True if energy and fuel of the trip can be compared with those of other trips. For the trip's length, its last
    /// speed must be near its first one. Null without a drive.
    pub energy_is_comparable: Option<bool>,
}

/// Largest share of the acceleration in the energy, as the mean acceleration over the way, m/s². Chosen: a tenth of
/// the 0.2 m/s² that rolling resistance and drag of a car come to at 20 m/s.
const STORED_MPS2: f64 = 0.02;

/// True if a trip stored little of its energy in its speed. A sprint of 10 s did not.
fn is_comparable(steps: &[DriveStep]) -> Option<bool> {
    let (first, last) = steps.first().zip(steps.last())?;
    let way_m = last.position_m - first.position_m;
    let stored = (last.speed_mps.powi(2) - first.speed_mps.powi(2)).abs() / 2.0;
    Some(stored <= STORED_MPS2 * way_m)
}

impl Trip {
    /// Trip time beyond the fastest legal trip, s; none without both.
    pub fn over_fastest_s(&self) -> Option<f64> {
        Some(self.trip_time_s? - self.fastest_legal_trip_s?)
    }

    /// The trip of a drive through a scenario.
    pub fn of(scenario: &Scenario, steps: &[DriveStep]) -> Self {
        let lines = scenario.v2x.signals.iter().map(|signal| signal.stop_line_m.value());
        let energy_is_comparable = is_comparable(steps);
        let Some(last_m) = lines.reduce(f64::max).filter(|last_m| *last_m > 0.0) else {
            return Self { energy_is_comparable, ..Self::default() };
        };
        let trip_time_s = passed_s(steps, last_m);
        Self { trip_time_s, fastest_legal_trip_s: fastest(scenario), energy_is_comparable }
    }
}

/// Earliest time at the last stop line, s.
fn fastest(scenario: &Scenario) -> Option<f64> {
    let mut ego = Passing::start(scenario);
    let ahead = scenario.v2x.signals.iter().filter(|signal| signal.stop_line_m.value() > 0.0);
    for signal in ahead {
        ego = ego.past(scenario, signal)?;
    }
    Some(ego.time_s)
}

/// A place on the fastest legal trip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passing {
    pub time_s: f64,
    /// Position of the front, m.
    pub place_m: f64,
    pub speed_mps: f64,
}

impl Passing {
    pub fn start(scenario: &Scenario) -> Self {
        let speed_mps = scenario.plant.initial_speed_mps.value();
        Self { time_s: 0.0, place_m: 0.0, speed_mps }
    }

    /// The earliest passing of a stop line. `None` for trucks, and if the signal stays red.
    pub fn past(self, scenario: &Scenario, signal: &Signal) -> Option<Self> {
        let program = Program::new(signal);
        let at = self.along(scenario, signal.stop_line_m.value())?;
        let time_s = opens_s(&program, at.time_s)?;
        Some(Self { time_s, ..at })
    }

    /// The earliest passing of a place without signals. `None` for trucks, and if it cannot be reached.
    pub fn along(self, scenario: &Scenario, to_m: f64) -> Option<Self> {
        let plant = &scenario.plant;
        if plant.vehicle.is_truck() {
            return None;
        }
        let limit_mps = scenario.speed_limit_mps.map_or(f64::INFINITY, |limit| limit.value());
        let top_mps = scenario.set_speed_mps.value().min(limit_mps);
        let Self { mut time_s, mut place_m, speed_mps } = self;
        let mut speed_mps = speed_mps.min(top_mps);
        while place_m < to_m {
            let next_mps = (speed_mps + STEP_S * acceleration_mps2(plant, speed_mps)).min(top_mps);
            let way_m = 0.5 * STEP_S * (speed_mps + next_mps);
            if time_s > LONGEST_S || way_m <= 0.0 {
                return None;
            }
            time_s += ((to_m - place_m) / way_m).min(1.0) * STEP_S;
            place_m += way_m;
            speed_mps = next_mps;
        }
        Some(Self { time_s, place_m: to_m, speed_mps })
    }
}

fn acceleration_mps2(plant: &Plant, speed_mps: f64) -> f64 {
    let most = plant.max_acceleration_mps2.value();
    plant.powertrain.map_or(most, |powertrain| {
        let watts = 1e3 * powertrain.max_power_kw.value();
        most.min(watts / (powertrain.mass_kg.value() * speed_mps.max(1.0)))
    })
}

/// The first instant from `time_s` on without red, s; `None` if it stays red.
fn opens_s(program: &Program, time_s: f64) -> Option<f64> {
    let mut opens_s = time_s;
    for interval in program.intervals((time_s * 1e9) as u64) {
        if interval.phase != Phase::Red {
            return Some(opens_s);
        }
        opens_s = interval.end_ns? as f64 * 1e-9;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_energy_of_a_sprint_is_not_comparable_and_that_of_a_long_trip_is() {
        let at =
            |position_m, speed_mps| DriveStep { position_m, speed_mps, ..DriveStep::default() };
        assert_eq!(is_comparable(&[at(0.0, 20.0), at(250.0, 30.0)]), Some(false));
        assert_eq!(is_comparable(&[at(0.0, 20.0), at(20_000.0, 30.0)]), Some(true));
        assert_eq!(is_comparable(&[at(0.0, 20.0), at(200.0, 20.0)]), Some(true));
        assert_eq!(is_comparable(&[]), None);
    }

    fn scenario(keys: &str) -> Scenario {
        let text = format!(
            "schema_version = 1\nname = \"x\"\nset_speed_mps = 20\nspeed_limit_mps = 10\n\
             [plant]\ninitial_speed_mps = 10\n{keys}"
        );
        Scenario::parse("x.toml", &text).expect("the keys are right")
    }

    const SIGNALS: &str = "\
        [[v2x.signals]]\nintersection_id = 1\nstop_line_m = 100\n\
        program = [{ phase = \"red\", duration_s = 30 }, { phase = \"green\", duration_s = 30 }]\n\
        [[v2x.signals]]\nintersection_id = 2\nstop_line_m = 200\noffset_s = 30\n\
        program = [{ phase = \"red\", duration_s = 30 }, { phase = \"green\", duration_s = 30 }]\n";

    #[test]
    fn the_fastest_trip_waits_for_green_and_keeps_the_limit() {
        // 10 s to the first line, which opens at 30 s. 40 s at the second, which is red from 30 to 60 s.
        let trip = Trip::of(&scenario(SIGNALS), &[]);
        assert!((trip.fastest_legal_trip_s.expect("it passes") - 60.0).abs() < 1e-6, "{trip:?}");
        assert_eq!(trip.trip_time_s, None);
    }

    #[test]
    fn the_trip_ends_at_the_last_line() {
        let step =
            |time_s: f64| DriveStep { time_s, position_m: 8.0 * time_s, ..DriveStep::default() };
        let steps: Vec<DriveStep> = (0..60).map(|k| step(f64::from(k))).collect();
        let trip = Trip::of(&scenario(SIGNALS), &steps);
        assert!((trip.trip_time_s.expect("it passes") - 25.0).abs() < 1e-9, "{trip:?}");
    }

    #[test]
    fn a_start_from_standstill_takes_the_vehicles_acceleration() {
        let signal = "[[v2x.signals]]\nintersection_id = 1\nstop_line_m = 100\n\
                      program = [{ phase = \"green\", duration_s = 30 }]\n";
        let keys = format!("max_acceleration_mps2 = 2\n{signal}");
        let text = format!(
            "schema_version = 1\nname = \"x\"\nset_speed_mps = 10\n[plant]\ninitial_speed_mps = 0\n{keys}"
        );
        let scenario = Scenario::parse("x.toml", &text).expect("the keys are right");
        // 5 s and 25 m to 10 m/s, then 7.5 s.
        let from_rest = Trip::of(&scenario, &[]).fastest_legal_trip_s;
        assert!((from_rest.expect("it passes") - 12.5).abs() < 0.02, "{from_rest:?}");
    }

    #[test]
    fn without_signals_there_is_no_trip() {
        assert_eq!(Trip::of(&scenario(""), &[]), Trip::default());
    }
}
