//! Multi-objective ACC by quadratic boundedness (Gao et al. 2015): the published scenarios.
//!
//! The paper says "about": half a second for a switching time, which is what its plots can be read
//! to; an upper bound is checked as one.

use super::row::Row;
use super::{Driven, Runner};
use group::Error;

/// Scenarios driven.
pub const RUNS: usize = 3;

/// Bound of acceleration and request, m/s².
const BOUND_MPS2: f64 = 3.5;
/// Set speed, m/s.
const SET_SPEED_MPS: f64 = 110.0 / 3.6;

pub fn reproduce(runner: &mut Runner<'_>) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for (name, judge) in
        [("follow", follow as fn(&Driven) -> Vec<Row>), ("depart", depart), ("cut-in", cut_in)]
    {
        let driven = runner.drive(&format!("quadratic-bounded-{name}"), &[])?;
        rows.extend(judge(&driven));
        rows.extend(bounded(name, &driven));
    }
    Ok(rows)
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
        Row::near("follow.end_of_cruise_s", "s", 10.0, followed, 0.5),
        Row::at_most("follow.steady_by_s", "s", 30.0, unsteady, 0.5),
    ]
}

fn depart(driven: &Driven) -> Vec<Row> {
    let steps = || driven.drive.steps.iter();
    let left = steps().find(|s| s.gap_m.is_some_and(|gap| gap > 150.0)).map(|s| s.time_s);
    let fastest = steps().map(|step| step.speed_mps).fold(0.0, f64::max);
    let overshoot = (fastest - SET_SPEED_MPS).max(0.0) * 3.6;
    vec![
        Row::near("depart.switch_to_cruise_s", "s", 27.5, first_mode(driven, 20.0, 0), 0.5),
        Row::near("depart.lead_out_of_range_s", "s", 54.0, left, 1.0),
        Row::near("depart.speed_overshoot_kmh", "km/h", 0.0, Some(overshoot), 0.05),
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
        Row::near("cut-in.braking_starts_s", "s", 18.0, braking, 0.3),
        Row::near("cut-in.gap_overshoot_m", "m", 0.0, Some(overshoot), 0.25),
        Row::shown(
            "cut-in.hardest_braking_mps2",
            "m/s²",
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
            BOUND_MPS2,
            Some(largest),
            0.0,
        ),
        Row::at_most(&format!("{name}.turns_of_the_request"), "", 6.0, Some(turns), 0.0),
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
