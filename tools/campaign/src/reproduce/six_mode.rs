//! Six-mode switching ACC (Wang et al. 2014): the mode sequence and its switching times.

use super::row::Row;
use super::{Driven, Runner};
use group::Error;

/// Scenarios driven.
pub const RUNS: usize = 1;

/// Switches of the paper: from mode, to mode, s, accepted difference in s.
const SWITCHES: [(u32, u32, f64, f64); 6] = [
    (6, 1, 4.0, 1.1),
    (1, 2, 8.0, 0.3),
    (2, 5, 14.0, 0.3),
    (5, 4, 16.0, 0.3),
    (4, 2, 18.0, 0.3),
    (2, 4, 26.0, 0.3),
];

pub fn reproduce(runner: &mut Runner<'_>) -> Result<Vec<Row>, Error> {
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
        .map(|(index, &(from, to, paper, tolerance))| {
            // In its place in the sequence, or not at all.
            let ours = switches.get(index).filter(|ours| (ours.0, ours.1) == (from, to));
            Row::near(&format!("switch.{from}-{to}_s"), "s", paper, ours.map(|o| o.2), tolerance)
        })
        .collect();
    let extra = switches.len().saturating_sub(SWITCHES.len());
    rows.push(Row::near("switch.others", "", 0.0, Some(extra as f64), 0.0));
    let end = driven.drive.steps.last().map(|step| step.speed_mps);
    rows.push(Row::near("end.speed_mps", "m/s", 0.0, end, 0.01));
    Ok(rows)
}

/// (time, mode in the paper's numbers) at every control cycle.
fn modes(driven: &Driven) -> Vec<(f64, u32)> {
    let steps = driven.drive.steps.iter();
    steps.filter_map(|step| step.mode.map(|mode| (step.time_s, mode + 1))).collect()
}
