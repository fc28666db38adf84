//! `timegap compare`: controllers side by side on the same scenarios.

mod page;

use crate::batch::{self, Job};
use clap::Args;
use group::Error;
use group::{GroupOptions, ModeName, ScenarioOptions};
use report::RunPicture;
use report::output::OutputDirectory;
use report::print;
use report::summary::{Control, Timing};
use std::path::PathBuf;

use runtime::report::Outcome;
use serde::Serialize;
use std::fmt::Write;
use std::process::ExitCode;

#[derive(Debug, Serialize)]
struct Comparison {
    schema_version: u32,
    rows: Vec<Row>,
}

#[derive(Debug, Serialize)]
struct Row {
    scenario: String,
    controller: String,
    mode: &'static str,
    outcome: Outcome,
    control: Control,
    timing: Timing,
    #[serde(skip)]
    picture: RunPicture,
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// Names of built-in scenarios, or TOML files
    #[arg(required = true)]
    pub scenarios: Vec<String>,
    /// Controllers, by commas [default: all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub controllers: Vec<String>,
    /// Clock: figures of the drive repeat exactly in `lockstep`; `realtime` also measures deadlines
    #[arg(long, value_enum, default_value_t = ModeName::Lockstep)]
    pub mode: ModeName,
    /// Change any key of every scenario, by its dotted path; may be given again
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Directory for the results [default: runs/<time>-compare]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the rows as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(arguments: &CompareArguments) -> Result<ExitCode, Error> {
    let controllers = if arguments.controllers.is_empty() {
        controller::laws::ALL.iter().map(|law| law.name.to_owned()).collect()
    } else {
        arguments.controllers.clone()
    };
    // Everything is read before anything runs.
    let mode = arguments.mode.into();
    let mut jobs = Vec::new();
    for name in &arguments.scenarios {
        for controller in &controllers {
            let options = ScenarioOptions {
                controller: Some(controller.clone()),
                set: arguments.set.clone(),
                ..ScenarioOptions::default()
            };
            jobs.push(Job { scenario: group::open(name, &options)?, mode, sample_every: None });
        }
    }
    let output = OutputDirectory::create(arguments.out.as_deref(), "compare")?;
    let bar = report::progress::count_bar(jobs.len(), arguments.json);
    let at_once = batch::at_once(None, mode);
    let mut rows: Vec<_> = jobs.iter().map(|_| None).collect();
    batch::run(&jobs, at_once, &arguments.group, &bar, &mut |index, result| {
        let done = result?;
        let picture = RunPicture::of_drive(&jobs[index].scenario, &done.drive);
        let summary = done.summary;
        rows[index] = Some(Row {
            scenario: summary.scenario,
            controller: summary.controller,
            mode: summary.mode,
            outcome: summary.outcome,
            control: summary.control,
            timing: summary.timing,
            picture,
        });
        Ok(())
    })?;
    let rows: Vec<_> = rows.into_iter().flatten().collect();
    bar.finish_and_clear();
    let whole = rows.iter().all(|row| row.outcome == Outcome::Completed);
    let comparison = Comparison { schema_version: 1, rows };
    let json = serde_json::to_string_pretty(&comparison).expect("plain data");
    let written = output.write("compare.json", (json.clone() + "\n").as_bytes());
    let written =
        written.and_then(|()| output.write(report::FILE, page::page(&comparison.rows).as_bytes()));
    if arguments.json {
        print::out(&(json + "\n"));
    } else {
        print::out(&table(&comparison.rows));
        print::out(&format!("results: {}\n", output.path().display()));
        print::out(&format!("report:  {}\n", output.path().join(report::FILE).display()));
    }
    written?;
    Ok(if whole { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The rows for people: one block per scenario.
fn table(rows: &[Row]) -> String {
    let mut text = String::new();
    let mut scenario = None;
    for row in rows {
        if scenario != Some(&row.scenario) {
            scenario = Some(&row.scenario);
            writeln!(
                text,
                "{} ({})\n  {:<18} {:>10} {:>8} {:>8} {:>8} {:>15} {:>8} {:>9} {:>9} {:>8}",
                row.scenario,
                row.mode,
                "",
                "outcome",
                "min gap",
                "min TTC",
                "gap off",
                "acceleration",
                "jerk",
                "law p50",
                "law p99",
                "missed",
            )
            .expect("a string takes all");
        }
        let control = &row.control.figures;
        let number = |value: Option<f64>, unit: &str| {
            value.map_or_else(|| "-".into(), |value| format!("{value:.1}{unit}"))
        };
        let range = match (control.min_accel_mps2, control.max_accel_mps2) {
            (Some(low), Some(high)) => format!("{low:.2} to {high:.2}"),
            _ => "-".into(),
        };
        let solve = row.timing.solve_us;
        writeln!(
            text,
            "  {:<18} {:>10} {:>8} {:>8} {:>8} {:>15} {:>8} {:>9} {:>9} {:>8}",
            row.controller,
            print::outcome_word(row.outcome),
            number(control.min_gap_m, " m"),
            number(control.min_ttc_s, " s"),
            number(control.final_gap_error_m, " m"),
            range,
            number(control.max_abs_jerk_mps3, ""),
            number(solve.map(|p| p.p50), " µs"),
            number(solve.map(|p| p.p99), " µs"),
            row.timing.deadline_misses.map_or_else(|| "-".into(), |misses| misses.to_string()),
        )
        .expect("a string takes all");
    }
    text
}
