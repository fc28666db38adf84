//! Multi-objective ACC by quadratic boundedness (Gao et al. 2015): the published scenarios, in two sets.
//!
//! One set has the certified design of the reconstruction, the other has the output gains that the paper prints.
//! Nothing is proven for these gains. Desired gap, bounds and the radar's range are not printed: both sets take the
//! reconstruction's. The paper writes "about" for one figure alone, the 54 s.

mod actuators;

use super::page::over_time;
use super::row::{EXACT, Kind, Row, Tolerance, paper, reconstruction, requirement, within};
use super::runner::{Driven, Gallery, Part, Piece, Runner};
use actuators::{Pedals, pedals};
use controller::laws::quadratic_bounded::Parameters;
use scenario::Setting;
use supervise::{DriveStep, Error};

/// The sets, with the key that chooses the gains.
const SETS: [(&str, &str); 2] =
    [("certified design", "certified"), ("gains as printed, uncertified", "printed")];

/// Tolerance of a time that is printed to the half second.
const PRINTED: Tolerance =
    within(0.5, "printed to the half second; desired gap and car are not the paper's");
/// Tolerance of a time behind which there are a place and a plot.
const ABOUT: Tolerance =
    within(1.0, "the paper says \"about\"; the gap grows slowly where it passes 150 m");
/// Tolerance of an overshoot that the paper denies.
const UNSEEN_KMH: Tolerance = within(0.05, "too small to see in the paper's plot");
const UNSEEN_M: Tolerance = within(0.25, "too small to see in the paper's plot");
/// Inferred values behind the rows.
const GAP: &str = "the desired gap: the paper's is lost";
const RANGE: &str = "the desired gap is lost, and the radar's range of 150 m is not printed";
const CAR: &str = "the car of the inverse model: the paper's is not described";
/// Most turns of signals that do not oscillate: two for each manoeuvre and pedal of the scenario.
const TURNS: f64 = 8.0;
const SET_SPEED_MPS: f64 = 110.0 / 3.6;
/// The scenarios, in the order of the figures from 3 on.
const SCENARIOS: [&str; 3] = ["follow", "depart", "cut-in"];

pub fn pieces() -> Vec<Piece> {
    SETS.map(|(set, gains)| Piece::new(set, move |runner| reproduce(runner, set, gains))).into()
}

/// Drives the scenarios with a set of gains and compares.
fn reproduce(runner: &Runner<'_>, set: &str, gains: &str) -> Result<Part, Error> {
    let gains = [Setting::new("controller.quadratic_bounded.gains", gains)];
    let drive = |name: &str| runner.drive(&format!("quadratic-bounded-{name}"), &gains);
    let [follows, departs, cuts_in] =
        [drive(SCENARIOS[0])?, drive(SCENARIOS[1])?, drive(SCENARIOS[2])?];
    let mut part = Part {
        rows: [follow(&follows), depart(&departs), cut_in(&cuts_in, &follows)].concat(),
        ..Part::default()
    };
    for (name, driven) in SCENARIOS.iter().zip([&follows, &departs, &cuts_in]) {
        part.rows.extend(index_rows(name, driven).into_iter().chain([smooth(name, driven)]));
        let (drive, picture) = driven.picture();
        part.pictures.drives.push((format!("{drive} · {set}"), picture));
    }
    part.rows = part.rows.into_iter().map(|row| row.in_set(set)).collect();
    let drives: Vec<_> = SCENARIOS.into_iter().zip([&follows, &departs, &cuts_in]).collect();
    let plot = |title, unit, of: fn(Pedals) -> f64| {
        let points = |driven: &Driven| driven.points(|step| Some(of(pressed(step))));
        over_time(title, unit, &drives, &points)
    };
    part.pictures.galleries.push(Gallery {
        heading: format!("Figures 3c, 4c, 5c, inverse model of a saloon: {set}"),
        plots: vec![
            plot("Throttle opening", "%", |pedals| pedals.throttle_percent),
            plot("Brake pressure", "MPa", |pedals| pedals.pressure_mpa),
        ],
    });
    Ok(part)
}

/// First time from `from_s` on at which the law's mode is `mode` (0 cruise, 1 follow).
fn first_mode(driven: &Driven, from_s: f64, mode: u32) -> Option<f64> {
    let mut steps = driven.drive.steps.iter();
    steps.find(|step| step.time_s >= from_s && step.mode == Some(mode)).map(|step| step.time_s)
}

fn pressed(step: &DriveStep) -> Pedals {
    pedals(step.speed_mps, step.acceleration_mps2)
}

fn follow(driven: &Driven) -> Vec<Row> {
    let error = driven.figure("gap_error_m").into_iter().zip(driven.figure("speed_error_mps"));
    let followed = first_mode(driven, 0.0, 1);
    // The last time before the lead moves again at which it was not yet steady, and one cycle.
    let unsteady = error
        .filter(|((t, gap), (_, speed))| *t < 40.0 && (gap.abs() >= 2.0 || speed.abs() >= 0.3))
        .map(|((t, _), _)| t)
        .fold(None, |_, t| Some(t + 0.1));
    let before = || driven.drive.steps.iter().filter(|step| step.time_s < 40.0).map(pressed);
    let released = before().filter(|pedals| *pedals == Pedals::default()).count();
    let pressure = before().map(|pedals| pedals.pressure_mpa).fold(0.0, f64::max);
    let step_s = f64::from(driven.scenario.plant.period_ms.value()) / 1e3;
    let released_s = Some(released as f64 * step_s);
    vec![
        Row::near("follow.end_of_cruise_s", "s", paper(10.0), followed, PRINTED)
            .with_source("0 to 10 s: cruise behind the virtual lead")
            .depending_on(GAP),
        Row::at_most("follow.steady_by_s", "s", paper(30.0), unsteady, PRINTED)
            .with_source("10 to 30 s: transition; 30 to 60 s: steady following")
            .depending_on(GAP)
            .with_note("gap error below 2 m and speed error below 0.3 m/s from then on"),
        Row::at_least("follow.released_s", "s", requirement(0.1), released_s, EXACT)
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
    let overshoot = Some((fastest - SET_SPEED_MPS).max(0.0) * 3.6);
    let switch = first_mode(driven, 20.0, 0);
    vec![
        Row::near("depart.switch_to_cruise_s", "s", paper(27.5), switch, PRINTED)
            .with_source("0 to 27.5 s: steady following; from 27.5 s on: to 110 km/h")
            .depending_on(GAP),
        Row::near("depart.lead_out_of_range_s", "s", paper(54.0), left, ABOUT)
            .with_source("figure 4b: at about 54 s the lead leaves the radar's range")
            .depending_on(RANGE),
        Row::near("depart.speed_overshoot_kmh", "km/h", paper(0.0), overshoot, UNSEEN_KMH)
            .with_source("the speed has no overshoot"),
    ]
}

fn cut_in(driven: &Driven, follow: &Driven) -> Vec<Row> {
    let mut steps = driven.drive.steps.iter();
    let braking = steps
        .find(|step| step.time_s > 17.0 && step.request_mps2.is_some_and(|u| u < -0.02))
        .map(|step| step.time_s);
    let overshoot = driven
        .figure("gap_error_m")
        .into_iter()
        .filter(|(t, _)| *t > 18.2)
        .fold(0.0_f64, |most, (_, error)| most.max(-error));
    let hardest = |driven: &Driven| driven.summary.control.figures.min_accel_mps2;
    let harder = hardest(follow).zip(hardest(driven)).map(|(follow, cut_in)| follow - cut_in);
    vec![
        Row::input("cut-in.braking_starts_s", "s", paper(18.0), braking)
            .with_source("at 18 s the car is the lead, and the brake is applied")
            .with_note("the scenario sets the instant; the law needs one control cycle"),
        Row::near("cut-in.gap_overshoot_m", "m", paper(0.0), Some(overshoot), UNSEEN_M)
            .with_source("the gap settles without overshoot"),
        Row::shown(
            "cut-in.hardest_braking_mps2",
            "m/s²",
            Kind::Paper,
            hardest(driven),
            "the paper says \"large\" and prints no number",
        )
        .with_source("figure 5c: a large deceleration at the price of comfort"),
        Row::at_least("cut-in.brakes_harder_than_follow_mps2", "m/s²", paper(0.0), harder, EXACT)
            .with_source("figures 5a, 5c: the car slows down fast, with a large deceleration")
            .depending_on("the cap of 20 m on the gap error that the law takes")
            .with_note(
                "a deceleration at the price of comfort is larger than that of ordinary following",
            ),
    ]
}

/// Signals to the actuators that do not oscillate.
fn smooth(name: &str, driven: &Driven) -> Row {
    let pedals = || driven.drive.steps.iter().map(pressed);
    let throttle = turns(pedals().map(|pedals| pedals.throttle_percent), 1.0);
    let pressure = turns(pedals().map(|pedals| pedals.pressure_mpa), 0.01);
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

const BOUND: &str = "reconstruction's bound: the paper's is lost";
const SOURCE: &str = "section 2.2: the indices stay within bounds taken from real driving";
const CAPPED: &str = "while it follows; the law takes at most 20 m of it, so a car that is first seen far \
                      away is outside the bound";
const CLAMPED: &str = "the law clamps the request to this bound, and the vehicle lags behind it";
const INCREMENT_CLAMPED: &str =
    "the law clamps it to this bound; the printed gains ask for 1.26 at the cut-in";

/// The indices and their bounds. The paper quantifies safety by Dd and Dv, comfort by a and u, handiness by Du, and
/// efficiency by Dd' (section 2.2). Its bounds are lost; the reconstruction's bounds are compared.
fn index_rows(name: &str, driven: &Driven) -> Vec<Row> {
    let p = Parameters::default();
    let largest =
        |values: &mut dyn Iterator<Item = f64>| Some(values.map(f64::abs).fold(0.0, f64::max));
    let figure = |name: &str| largest(&mut driven.figure(name).into_iter().map(|(_, value)| value));
    let steps = || driven.drive.steps.iter();
    let follows = steps().filter(|step| step.figures.is_some()).map(|step| step.mode == Some(1));
    let gap_errors = driven.figure("gap_error_m");
    let followed = gap_errors.into_iter().zip(follows).filter(|(_, follows)| *follows);
    let gap_error = largest(&mut followed.map(|((_, error), _)| error));
    let request = largest(&mut steps().filter_map(|step| step.request_mps2));
    let acceleration = largest(&mut steps().map(|step| step.acceleration_mps2));
    let id = |index: &str| format!("{name}.largest_{index}");
    let row = |index, unit, bound, ours| {
        Row::at_most(&id(index), unit, reconstruction(bound), ours, EXACT).depending_on(BOUND)
    };
    let clamped = |index, bound, ours, note| {
        Row::input(&id(index), "m/s²", reconstruction(bound), ours).with_note(note)
    };
    let rows = [
        row("gap_error_m", "m", p.gap_error_bound_m, gap_error).with_note(CAPPED),
        row("speed_error_mps", "m/s", p.speed_error_bound_mps, figure("speed_error_mps")),
        clamped("acceleration_mps2", p.acceleration_bound_mps2, acceleration, CLAMPED),
        clamped("request_mps2", p.request_bound_mps2, request, CLAMPED),
        clamped(
            "increment_mps2",
            p.increment_bound_mps2,
            figure("increment_mps2"),
            INCREMENT_CLAMPED,
        ),
        row("gap_error_rate_mps", "m/s", p.gap_error_rate_bound_mps, figure("gap_error_rate_mps")),
    ];
    rows.map(|row| row.with_source(SOURCE)).into()
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
