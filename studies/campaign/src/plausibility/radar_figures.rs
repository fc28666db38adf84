//! Figures of the radar's checks alone, for the example that measures the effect of each of their limits.

use super::{CASES, Checks, Planned, begins_s, quiet};
use group::report::CheckReport;
use group::{Error, LawOptions};
use report::summary::Summary;
use runtime::Mode;

/// A figure with its name: a count, or a time in s that does not exist if nothing was found. More false alarms are
/// worse, and so are fewer found senders.
pub type Figure = (String, f64);

/// The checks whose limits the radar's table has.
const CHECKS: [&str; 3] = ["radar-frozen", "range-rate-against-range", "target-against-track"];

/// Drives `hours` without faults, and `drives` with each false radar, in this process.
///
/// # Errors
/// If a drive cannot be run.
pub fn radar_figures(hours: f64, drives: u32) -> Result<Vec<Figure>, Error> {
    let laws = LawOptions::default();
    let study = Checks { seed: 1, drives: quiet(1, &laws, hours)?, laws, require: Vec::new() };
    let run = |planned: Planned| -> Result<Vec<CheckReport>, Error> {
        let scenario = super::scenario(1, &study.laws, planned)?;
        let group = group::in_process::run(&scenario)?;
        Ok(Summary::new(&scenario, Mode::Lockstep, &group, group.ran_for).checks)
    };
    let mut figures: Vec<Figure> = Vec::new();
    let mut alarmed = [0.0; CHECKS.len()];
    for planned in &study.drives {
        let found = run(*planned)?;
        for (alarmed, name) in alarmed.iter_mut().zip(CHECKS) {
            *alarmed += f64::from(u8::from(
                found.iter().any(|check| check.check == name && check.cycles > 0),
            ));
        }
    }
    figures.extend(
        CHECKS
            .iter()
            .zip(alarmed)
            .map(|(name, alarmed)| (format!("drives with a false {name}"), alarmed)),
    );
    let is_radar = |case: &usize| CASES[*case].3.starts_with("\"radar/tracks\"");
    for case in (0..CASES.len()).filter(is_radar) {
        let (fault, size, ..) = CASES[case];
        let (mut found, mut after_s) = (0.0, 0.0);
        for drive in 0..drives {
            let at_s = begins_s(case, drive);
            let first_s = |check: &CheckReport| check.first_s.filter(|first_s| *first_s >= at_s);
            if let Some(first_s) =
                run(Planned::Faulty(case, drive))?.iter().filter_map(first_s).min_by(f64::total_cmp)
            {
                found += 1.0;
                after_s += first_s - at_s;
            }
        }
        figures.push((format!("{fault} ({size}) found"), found));
        figures.push((format!("{fault} ({size}) found after"), after_s / found));
    }
    Ok(figures)
}
