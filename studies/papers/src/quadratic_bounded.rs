//! Multi-objective ACC by quadratic boundedness (Gao et al. 2015): the published scenarios.
//!
//! The paper says "about": half a second for a switching time, which is what its plots can be read
//! to; an upper bound is compared as one.

use super::row::{EXACT, Kind, Row, Tolerance, paper, requirement, within};
use super::runner::{Driven, Part, Runner, together};
use group::Error;

/// Scenarios driven.
pub const RUNS: usize = 3;

/// Tolerance of a time that the paper gives as "about".
const ABOUT_S: Tolerance =
    within(0.5, "the paper says \"about\"; its plots can be read to half a second");

/// Reason of the wider tolerance: a place and a time are read from one plot.
const ABOUT_RANGE: &str = "the paper says \"about\"; the gap grows slowly where it passes 150 m";
/// Most turns of a request that does not oscillate: two for each manoeuvre of the scenario.
const TURNS: f64 = 6.0;

/// Bound of acceleration and request, m/s².
const BOUND_MPS2: f64 = 3.5;
/// Set speed, m/s.
const SET_SPEED_MPS: f64 = 110.0 / 3.6;

/// Drives the scenarios and compares.
pub fn reproduce(runner: &Runner<'_>) -> Result<Part, Error> {
    let scenarios =
        [("follow", follow as fn(&Driven) -> Vec<Row>), ("depart", depart), ("cut-in", cut_in)];
    let driven = together(
        scenarios.map(|(name, _)| move || runner.drive(&format!("quadratic-bounded-{name}"), &[])),
    );
    let mut part = Part::default();
    for ((name, judge), driven) in scenarios.into_iter().zip(driven) {
        let driven = driven?;
        part.rows.extend(judge(&driven));
        part.rows.extend(bounded(name, &driven));
        part.drives.push(driven.picture());
    }
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
    vec![
        Row::near("follow.end_of_cruise_s", "s", paper(10.0), followed, ABOUT_S),
        Row::at_most("follow.steady_by_s", "s", paper(30.0), unsteady, ABOUT_S)
            .with_note("gap error below 2 m and speed error below 0.3 m/s from then on"),
    ]
}

fn depart(driven: &Driven) -> Vec<Row> {
    let steps = || driven.drive.steps.iter();
    let left = steps().find(|s| s.gap_m.is_some_and(|gap| gap > 150.0)).map(|s| s.time_s);
    let fastest = steps().map(|step| step.speed_mps).fold(0.0, f64::max);
    let overshoot = (fastest - SET_SPEED_MPS).max(0.0) * 3.6;
    vec![
        Row::near(
            "depart.switch_to_cruise_s",
            "s",
            paper(27.5),
            first_mode(driven, 20.0, 0),
            ABOUT_S,
        ),
        Row::near("depart.lead_out_of_range_s", "s", paper(54.0), left, within(1.0, ABOUT_RANGE)),
        Row::near(
            "depart.speed_overshoot_kmh",
            "km/h",
            paper(0.0),
            Some(overshoot),
            within(0.05, "too small to see in the paper's plot"),
        ),
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
        ),
        Row::near(
            "cut-in.gap_overshoot_m",
            "m",
            paper(0.0),
            Some(overshoot),
            within(0.25, "too small to see in the paper's plot"),
        ),
        Row::shown(
            "cut-in.hardest_braking_mps2",
            "m/s²",
            Kind::Paper,
            hardest,
            "the paper says \"large\"; no certified design that was found brakes harder than 1.32",
        ),
    ]
}

/// What holds in every scenario: acceleration within its bound, a request that does not oscillate.
fn bounded(name: &str, driven: &Driven) -> Vec<Row> {
    let control = &driven.summary.control.figures;
    let largest = [control.min_accel_mps2, control.max_accel_mps2]
        .into_iter()
        .flatten()
        .map(f64::abs)
        .fold(0.0, f64::max);
    let requests = driven.drive.steps.iter().filter_map(|step| step.request_mps2);
    let turns = turns(requests);
    vec![
        Row::at_most(
            &format!("{name}.largest_acceleration_mps2"),
            "m/s²",
            paper(BOUND_MPS2),
            Some(largest),
            EXACT,
        ),
        Row::at_most(
            &format!("{name}.turns_of_the_request"),
            "",
            requirement(TURNS),
            Some(turns),
            EXACT,
        )
        .with_note("the paper says that the throttle does not oscillate"),
    ]
}

/// Number of times that a signal turns by more than a hundredth.
fn turns(signal: impl Iterator<Item = f64>) -> f64 {
    let (mut turns, mut extreme, mut rising) = (0.0, None, true);
    for value in signal {
        let kept = *extreme.get_or_insert(value);
        if (value > kept) == rising {
            extreme = Some(value);
        } else if (value - kept).abs() > 0.01 {
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
        assert_eq!(turns([0.0, 1.0, 2.0].into_iter()), 0.0);
        assert_eq!(turns([0.0, 1.0, 0.0, 1.0].into_iter()), 2.0);
        assert_eq!(turns([0.0, 1.0, 0.995, 1.0].into_iter()), 0.0);
    }
}
