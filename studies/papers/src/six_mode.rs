//! Six-mode switching ACC (Wang et al. 2014): the mode sequence and its switching times.

use super::row::{EXACT, Row, Tolerance, paper, requirement, within};
use super::runner::{Driven, Part, Runner};
use group::Error;

/// Scenarios driven.
pub const RUNS: usize = 1;

/// The paper gives whole seconds; this is less than rounding alone would excuse.
const PRINTED_S: Tolerance = within(0.3, "printed in whole seconds");
/// No initial speed meets the paper's first two times: what meets the second is this late for the
/// first.
const INITIAL_SPEED_S: Tolerance = within(
    1.1,
    "the initial speed is not printed, and none meets both the first and the second time",
);

/// Switches of the paper: from mode, to mode, s.
const SWITCHES: [(u32, u32, f64, Tolerance); 6] = [
    (6, 1, 4.0, INITIAL_SPEED_S),
    (1, 2, 8.0, PRINTED_S),
    (2, 5, 14.0, PRINTED_S),
    (5, 4, 16.0, PRINTED_S),
    (4, 2, 18.0, PRINTED_S),
    (2, 4, 26.0, PRINTED_S),
];

/// Drives the scenario and compares.
pub fn reproduce(runner: &Runner<'_>) -> Result<Part, Error> {
    let driven = runner.drive("six-mode", &[])?;
    let modes = modes(&driven);
    let switches: Vec<_> = modes
        .windows(2)
        .filter(|pair| pair[0].1 != pair[1].1)
        .map(|pair| (pair[0].1, pair[1].1, pair[1].0))
        .collect();
    let mut rows: Vec<_> = SWITCHES
        .iter()
        .enumerate()
        .map(|(index, &(from, to, at_s, tolerance))| {
            // In its place in the sequence, or not at all.
            let ours = switches.get(index).filter(|ours| (ours.0, ours.1) == (from, to));
            let id = format!("switch.{from}-{to}_s");
            Row::near(&id, "s", paper(at_s), ours.map(|ours| ours.2), tolerance)
        })
        .collect();
    let extra = switches.len().saturating_sub(SWITCHES.len());
    rows.push(
        Row::near("switch.others", "", requirement(0.0), Some(extra as f64), EXACT)
            .with_note("switches beyond the paper's six"),
    );
    let end = driven.drive.steps.last().map(|step| step.speed_mps);
    let standing = within(0.01, "what a plot shows as standing");
    rows.push(Row::near("end.speed_mps", "m/s", paper(0.0), end, standing));
    Ok(Part { rows, drives: vec![driven.picture()], pictures: Vec::new() })
}

/// (time, mode in the paper's numbers) at every control cycle.
fn modes(driven: &Driven) -> Vec<(f64, u32)> {
    let steps = driven.drive.steps.iter();
    steps.filter_map(|step| step.mode.map(|mode| (step.time_s, mode + 1))).collect()
}
