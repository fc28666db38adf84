//! Multi-objective ACC by quadratic boundedness (Gao et al. 2015): the published scenarios, in two sets.
//!
//! One set has the certified design of the reconstruction, the other has the output gains that the paper prints.
//! Nothing is proven for these gains. Desired gap and bounds are lost: both sets take the reconstruction's. The paper
//! writes "about" for one figure alone, the 54 s.

mod actuators;
mod indices;
mod pictures;

use super::row::{EXACT, Kind, Row, Tolerance, paper, requirement, within};
use super::runner::{Driven, Part, Piece, Runner};
use actuators::Pedals;
use group::Error;
use pictures::pressed;

/// The sets, with the key that chooses the gains.
const SETS: [(&str, &str); 2] = [
    ("certified design", "controller.quadratic_bounded.gains=certified"),
    ("gains as printed, uncertified", "controller.quadratic_bounded.gains=printed"),
];

/// Tolerance of a time that is printed to the half second.
const PRINTED: Tolerance =
    within(0.5, "printed to the half second; desired gap and car are not the paper's");
/// Reason of the wider tolerance: a place and a time are read from one plot.
const ABOUT_RANGE: &str = "the paper says \"about\"; the gap grows slowly where it passes 150 m";
/// Inferred values behind the rows.
const GAP: &str = "the desired gap: the paper's is lost";
const CAR: &str = "the car of the inverse model: the paper's is not described";
/// Most turns of signals that do not oscillate: two for each manoeuvre and pedal of the scenario.
const TURNS: f64 = 8.0;
/// Set speed, m/s.
const SET_SPEED_MPS: f64 = 110.0 / 3.6;

type Judge = fn(&Driven) -> Vec<Row>;
/// The scenarios with the number of their figure.
const SCENARIOS: [(&str, u32, Judge); 3] =
    [("follow", 3, follow), ("depart", 4, depart), ("cut-in", 5, cut_in)];

/// A piece for each scenario.
pub fn pieces() -> Vec<Piece> {
    let piece = |scenario: (&'static str, u32, Judge)| {
        Piece::new(scenario.0, move |runner| reproduce(runner, scenario))
    };
    SCENARIOS.map(piece).into()
}

/// Drives a scenario with both sets and compares.
fn reproduce(
    runner: &Runner<'_>,
    (name, number, judge): (&'static str, u32, Judge),
) -> Result<Part, Error> {
    let drive = |(_, key): (&str, &str)| runner.drive(&format!("quadratic-bounded-{name}"), &[key]);
    let driven = SETS.into_iter().map(drive).collect::<Result<Vec<_>, _>>()?;
    let mut part = Part::default();
    for ((set, _), driven) in SETS.iter().zip(&driven) {
        let rows = judge(driven).into_iter().chain(indices::rows(name, driven));
        let rows = rows.chain([smooth(name, driven)]);
        part.rows.extend(rows.map(|row| row.in_set(set)));
        let (drive, picture) = driven.picture();
        part.pictures.drives.push((format!("{drive} · {set}"), picture));
    }
    let sets: Vec<_> = SETS.iter().map(|(title, _)| *title).zip(&driven).collect();
    part.pictures.galleries.push(pictures::figure(number, name, &sets));
    Ok(part)
}

/// First time from `from_s` on at which the law's mode is `mode` (0 cruise, 1 follow).
fn first_mode(driven: &Driven, from_s: f64, mode: u32) -> Option<f64> {
    let mut steps = driven.drive.steps.iter();
    steps.find(|step| step.time_s >= from_s && step.mode == Some(mode)).map(|step| step.time_s)
}

fn follow(driven: &Driven) -> Vec<Row> {
    let error = driven.figure("gap_error_m").into_iter().zip(driven.figure("speed_error_mps"));
    let followed = first_mode(driven, 0.0, 1);
    // The last time before the lead moves again at which it was not yet steady, and one cycle.
    let unsteady = error
        .filter(|((t, gap), (_, speed))| *t < 40.0 && (gap.abs() >= 2.0 || speed.abs() >= 0.3))
        .map(|((t, _), _)| t)
        .fold(None, |_, t| Some(t + 0.1));
    let pedals = pressed(driven);
    let before = || pedals.iter().filter(|(t, _)| *t < 40.0);
    let released = before().filter(|(_, pedals)| *pedals == Pedals::default()).count();
    let pressure = before().map(|(_, pedals)| pedals.pressure_mpa).fold(0.0, f64::max);
    let step_s = f64::from(driven.scenario.plant.period_ms.value()) / 1e3;
    vec![
        Row::near("follow.end_of_cruise_s", "s", paper(10.0), followed, PRINTED)
            .with_source("0 to 10 s: cruise behind the virtual lead")
            .depending_on(GAP),
        Row::at_most("follow.steady_by_s", "s", paper(30.0), unsteady, PRINTED)
            .with_source("10 to 30 s: transition; 30 to 60 s: steady following")
            .depending_on(GAP)
            .with_note("gap error below 2 m and speed error below 0.3 m/s from then on"),
        Row::at_least(
            "follow.released_s",
            "s",
            requirement(0.1),
            Some(released as f64 * step_s),
            EXACT,
        )
        .with_source("figure 3c: the throttle is released and the car coasts")
        .depending_on(CAR)
        .with_note("time with neither pedal pressed, inverse model"),
        Row::at_least("follow.brake_pressure_mpa", "MPa", requirement(0.01), Some(pressure), EXACT)
            .with_source("figure 3c: coasting is not enough, so some brake is applied")
            .depending_on(CAR)
            .with_note("largest pressure before the lead speeds up, inverse model"),
    ]
}

fn depart(driven: &Driven) -> Vec<Row> {
    let steps = || driven.drive.steps.iter();
    let left = steps().find(|s| s.gap_m.is_some_and(|gap| gap > 150.0)).map(|s| s.time_s);
    let fastest = steps().map(|step| step.speed_mps).fold(0.0, f64::max);
    let overshoot = (fastest - SET_SPEED_MPS).max(0.0) * 3.6;
    let switch = first_mode(driven, 20.0, 0);
    vec![
        Row::near("depart.switch_to_cruise_s", "s", paper(27.5), switch, PRINTED)
            .with_source("0 to 27.5 s: steady following; from 27.5 s on: to 110 km/h")
            .depending_on(GAP),
        Row::near("depart.lead_out_of_range_s", "s", paper(54.0), left, within(1.0, ABOUT_RANGE))
            .with_source("figure 4b: at about 54 s the lead leaves the radar's range")
            .depending_on(GAP),
        Row::near(
            "depart.speed_overshoot_kmh",
            "km/h",
            paper(0.0),
            Some(overshoot),
            within(0.05, "too small to see in the paper's plot"),
        )
        .with_source("the speed has no overshoot"),
    ]
}

fn cut_in(driven: &Driven) -> Vec<Row> {
    let mut steps = driven.drive.steps.iter();
    let braking = steps
        .find(|step| step.time_s > 17.0 && step.request_mps2.is_some_and(|u| u < -0.02))
        .map(|step| step.time_s);
    let overshoot = driven
        .figure("gap_error_m")
        .into_iter()
        .filter(|(t, _)| *t > 18.2)
        .fold(0.0_f64, |most, (_, error)| most.max(-error));
    let hardest = driven.summary.control.figures.min_accel_mps2;
    vec![
        Row::near(
            "cut-in.braking_starts_s",
            "s",
            paper(18.0),
            braking,
            within(0.3, "printed in whole seconds; three control cycles"),
        )
        .with_source("at 18 s the car is the lead, and the brake is applied")
        .depending_on("the cap of 20 m on the gap error that the law takes"),
        Row::near(
            "cut-in.gap_overshoot_m",
            "m",
            paper(0.0),
            Some(overshoot),
            within(0.25, "too small to see in the paper's plot"),
        )
        .with_source("the gap settles without overshoot"),
        Row::shown(
            "cut-in.hardest_braking_mps2",
            "m/s²",
            Kind::Paper,
            hardest,
            "the paper says \"large\" and prints no number",
        )
        .with_source("figure 5c: a large deceleration at the price of comfort"),
    ]
}

/// Signals to the actuators that do not oscillate.
fn smooth(name: &str, driven: &Driven) -> Row {
    let pedals = pressed(driven);
    let throttle = turns(pedals.iter().map(|(_, pedals)| pedals.throttle_percent), 1.0);
    let pressure = turns(pedals.iter().map(|(_, pedals)| pedals.pressure_mpa), 0.01);
    let id = format!("{name}.turns_of_the_pedals");
    Row::at_most(&id, "", requirement(TURNS), Some(throttle + pressure), EXACT)
        .with_source(
            "figures 3c, 4c: the actuators' signals are smooth, the throttle does not oscillate",
        )
        .depending_on(CAR)
        .with_note("turns of throttle and brake pressure together, inverse model")
}

/// Number of times that a signal turns by more than `least`.
fn turns(signal: impl Iterator<Item = f64>, least: f64) -> f64 {
    let (mut turns, mut extreme, mut rising) = (0.0, None, true);
    for value in signal {
        let kept = *extreme.get_or_insert(value);
        if (value > kept) == rising {
            extreme = Some(value);
        } else if (value - kept).abs() > least {
            turns += 1.0;
            (extreme, rising) = (Some(value), !rising);
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_counted_by_their_size() {
        assert_eq!(turns([0.0, 1.0, 2.0].into_iter(), 0.01), 0.0);
        assert_eq!(turns([0.0, 1.0, 0.0, 1.0].into_iter(), 0.01), 2.0);
        assert_eq!(turns([0.0, 1.0, 0.995, 1.0].into_iter(), 0.01), 0.0);
    }
}
