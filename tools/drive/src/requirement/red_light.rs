//! `no-red-light`: each stop line against the program of its signal.
//!
//! | at a red phase | margin, m |
//! |---|---|
//! | the ego was past the line when it turned red | the way past it |
//! | the ego waits before the line | least distance to it while it is red |
//! | the ego crosses the line | minus the distance at which it turned red |

use super::evidence::{Evidence, Finding};
use crate::DriveStep;
use scenario::v2x::Phase;
use v2x_sim::program::Program;

pub(super) fn no_red_light(evidence: &Evidence<'_>) -> Finding {
    let steps = &evidence.drive.steps;
    let (Some(first), Some(last)) = (steps.first(), steps.last()) else {
        return Finding::UNDECIDED;
    };
    let mut worst = Finding::UNDECIDED;
    for signal in &evidence.scenario.v2x.signals {
        let line_m = signal.stop_line_m.value();
        if line_m <= first.position_m {
            continue;
        }
        for (from_s, to_s) in red_phases(&Program::new(signal), last.time_s) {
            let (from_s, to_s) = (from_s.max(first.time_s), to_s.min(last.time_s));
            if from_s > to_s {
                continue;
            }
            let found = phase(steps, line_m, from_s, to_s);
            if found.value < worst.value || (!found.met && worst.met) {
                worst = found;
            }
        }
    }
    worst
}

/// The finding of one red phase within the drive.
fn phase(steps: &[DriveStep], line_m: f64, from_s: f64, to_s: f64) -> Finding {
    let at_red_m = position_m(steps, from_s) - line_m;
    if at_red_m >= 0.0 {
        return Finding { value: at_red_m, time_s: from_s, ..Finding::UNDECIDED };
    }
    let at_end_m = position_m(steps, to_s) - line_m;
    if at_end_m <= 0.0 {
        return Finding { value: -at_end_m, time_s: to_s, ..Finding::UNDECIDED };
    }
    let crossed = steps.iter().find(|step| step.position_m >= line_m);
    let time_s = crossed.map_or(to_s, |step| step.time_s);
    Finding { value: at_red_m, time_s, met: false, ..Finding::UNDECIDED }
}

/// Begin and end of each red phase that begins by `until_s`, s.
fn red_phases(program: &Program, until_s: f64) -> Vec<(f64, f64)> {
    let mut red = Vec::new();
    let mut from_s = 0.0;
    for interval in program.intervals(0) {
        let to_s = interval.end_ns.map_or(f64::INFINITY, |end_ns| end_ns as f64 / 1e9);
        if interval.phase == Phase::Red {
            red.push((from_s, to_s));
        }
        from_s = to_s;
        if from_s > until_s {
            break;
        }
    }
    red
}

/// Position of the ego at `time_s`, m; it moves evenly between two steps, as for the referee.
fn position_m(steps: &[DriveStep], time_s: f64) -> f64 {
    let next = steps.partition_point(|step| step.time_s <= time_s);
    let Some(before) = next.checked_sub(1).map(|index| &steps[index]) else {
        return steps[0].position_m;
    };
    let Some(after) = steps.get(next) else { return before.position_m };
    let share = (time_s - before.time_s) / (after.time_s - before.time_s);
    before.position_m + share * (after.position_m - before.position_m)
}
