//! `timegap string`: cars in one lane, each with its own stack, and what becomes of a disturbance on its
//! way from the first to the last.
//!
//! ```text
//! scenario ─► car 1 ─ true motion ─► car 2 ─ true motion ─► … ─► car N
//!               │                      │                           │
//!               └────── speeds and gap errors, as norms or as a sine's amplitude ──► gains
//! ```
//!
//! The first car drives the scenario as it stands. Each one after it drives the same scenario with one
//! other vehicle: the car before it, as that one really moved. A string is stable when no car makes
//! the disturbance larger (Swaroop and Hedrick, 1996, in the sense of the norms that are printed).

mod arguments;
mod drive;
mod growing;
mod limits;
mod measure;
mod motion;
mod page;
mod print;
mod response;
mod results;
mod scene;
#[cfg(test)]
mod theory;
mod wave;

pub use arguments::StringArguments;

use std::process::ExitCode;

use group::Error;
use indicatif::ProgressBar;
use report::output::OutputDirectory;

use arguments::Task;
use drive::Drives;
use frame::batch::{OtherBytes, ProcessesSample};
use limits::{Limits, Point};
use results::Results;
use scene::Plan;

/// Above this a gain counts as amplification: what is left of it in a figure that was measured over a
/// finite time.
pub const STABLE_GAIN: f64 = 1.005;

/// Runs the command.
///
/// # Errors
/// A scenario, law or range that cannot be driven, else what keeps the runs from
/// starting.
pub fn run(arguments: &StringArguments) -> Result<ExitCode, Error> {
    // Everything is read before anything runs.
    let task = Task::read(arguments)?;
    let output = OutputDirectory::create(&arguments.output, "string")?;
    let runs = task.runs();
    let bar = report::progress::count_bar(runs, arguments.json);
    bar.set_message(format!("string of {}", task.plan.vehicles));
    let mut drives = Drives::new(&arguments.group, &bar, arguments.jobs, task.plan.seed(), runs);
    let cars = drives.string(&task.plan)?;
    let frequencies = frequencies(&task, &mut drives)?;
    let limits = limits(&task, &mut drives)?;
    let processes_sample = finish(drives, runs, &bar)?;
    let results = Results::new(&task, &cars, frequencies, limits, processes_sample);
    let json = serde_json::to_string_pretty(&results).expect("plain data") + "\n";
    let written = output
        .write("string.json", json.as_bytes())
        .and_then(|()| output.write("string.csv", results.csv().as_bytes()))
        .and_then(|()| output.write("gains.csv", results.gains_csv().as_bytes()))
        .and_then(|()| output.write(report::FILE, page::page(&results, &cars).as_bytes()));
    if arguments.json {
        report::print::out(&json)?;
    } else {
        report::print::out(&print::text(&results))?;
        report::print::out(&output.places())?;
    }
    // Printed first: a full disk does not take what was measured.
    written?;
    Ok(if results.all_completed() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The whole string behind a sine of each frequency.
fn frequencies(task: &Task, drives: &mut Drives<'_>) -> Result<Vec<response::Response>, Error> {
    let waves: Vec<_> = task.frequencies.iter().map(|&hz| task.plan.behind_wave(hz)).collect();
    let strings = waves.into_iter().collect::<Result<Vec<Plan>, _>>()?;
    let driven = drives.strings(&strings)?;
    Ok(driven
        .iter()
        .zip(&task.frequencies)
        .map(|(cars, &hz)| response::response(hz, cars))
        .collect())
}

/// Every law alone behind a sine of each frequency, for each value of the swept key.
fn limits(task: &Task, drives: &mut Drives<'_>) -> Result<Vec<Limits>, Error> {
    let mut all = Vec::new();
    let Some((param, plans)) = &task.sweep else { return Ok(all) };
    for law in plans {
        let mut strings = Vec::new();
        for plan in &law.plans {
            for &hz in &task.sweep_frequencies {
                strings.push(plan.behind_wave(hz)?);
            }
        }
        let driven = drives.strings(&strings)?;
        let per_value = task.sweep_frequencies.len();
        let points = driven.chunks(per_value).zip(&param.values).map(|(driven, value)| {
            let curve = driven.iter().zip(&task.sweep_frequencies);
            Point::new(value, curve.map(|(cars, &hz)| response::response(hz, cars)).collect())
        });
        all.push(Limits::new(&law.controller, &param.key, points.collect()));
    }
    Ok(all)
}

/// Says what came of the runs that were repeated in process groups.
fn finish(
    drives: Drives<'_>,
    runs: usize,
    bar: &ProgressBar,
) -> Result<ProcessesSample, OtherBytes> {
    let sample = drives.into_sample();
    bar.finish_and_clear();
    sample.print(runs, bar);
    sample.agreed(|_| String::new())
}
