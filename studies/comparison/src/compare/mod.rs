//! `timegap compare`: controllers side by side on the same scenarios.

mod columns;
mod page;

use clap::Args;
use frame::batch::{self, Job, ProcessesSample, Source};
use frame::parts::{self, Merged, Part, PartOptions, Study, name_incomplete};
use group::{Error, Failure, GroupOptions, ModeName, ScenarioOptions};
use messages::Service;
use report::RunPicture;
use report::output::{OutputDirectory, OutputOptions};
use report::print;
use report::summary::{Aebs, Control, Timing};
use report::table::{Align, TextTable};

use runtime::report::Outcome;
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::process::ExitCode;

#[derive(Debug, Serialize)]
struct Comparison {
    schema_version: u32,
    rows: Vec<Row>,
    processes_sample: ProcessesSample,
}

#[derive(Debug, Serialize, Deserialize)]
struct Row {
    scenario: String,
    controller: String,
    mode: String,
    outcome: Outcome,
    control: Control,
    timing: Timing,
    aebs: Braking,
    #[serde(skip)]
    picture: RunPicture,
}

/// What the emergency brake did in a run.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Braking {
    enabled: bool,
    warnings: Option<u64>,
    interventions: Option<u64>,
    braking_s: Option<f64>,
}

impl Braking {
    fn of(aebs: &Aebs) -> Self {
        let Aebs { enabled, warnings, interventions, braking_s, .. } = *aebs;
        Self { enabled, warnings, interventions, braking_s }
    }
}

/// Words that the parts have said already, by their names.
const WITHOUT_MERGE: [&str; 4] = ["scenarios", "controllers", "mode", "set"];

/// Arguments of `compare`.
#[derive(Debug, Args)]
#[command(mut_arg("merge", |merge| merge.conflicts_with_all(WITHOUT_MERGE).conflicts_with_all(parts::OF_RUNS)))]
pub struct CompareArguments {
    /// Names of built-in scenarios, or TOML files
    #[arg(required_unless_present = "merge")]
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
    /// A part of the comparison, or parts put together.
    #[command(flatten)]
    pub parts: PartOptions,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Where the results go, and in which form.
    #[command(flatten)]
    pub output: OutputOptions,
    /// Print the rows as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
pub fn run(arguments: &CompareArguments) -> Result<ExitCode, Error> {
    if arguments.parts.merge.is_empty() { drive(arguments) } else { merge(arguments) }
}

/// A scenario would be driven twice, in rows that cannot be told apart.
#[derive(Debug, thiserror::Error)]
#[error("{name} is there twice, expected each scenario once")]
pub struct Twice {
    name: String,
}

impl Failure for Twice {}

/// Every row would be of the same program.
#[derive(Debug, thiserror::Error)]
#[error(
    "--service controller=PROGRAM: the program drives in the place of each of {laws} laws, so that their rows are \
     the same, expected one law by --controllers"
)]
pub struct OneProgram {
    laws: usize,
}

impl Failure for OneProgram {}

/// The runs: each scenario with each controller, read before anything runs.
fn scenarios(arguments: &CompareArguments) -> Result<Vec<Scenario>, Error> {
    let controllers = batch::laws::named(&arguments.controllers)?;
    let mut programs = arguments.group.programs.iter();
    if controllers.len() > 1 && programs.any(|(service, _)| *service == Service::Controller) {
        return Err(OneProgram { laws: controllers.len() }.into());
    }
    let twice = |(place, name): &(usize, &String)| arguments.scenarios[..*place].contains(name);
    if let Some((_, name)) = arguments.scenarios.iter().enumerate().find(twice) {
        return Err(Twice { name: name.clone() }.into());
    }
    let mut scenarios = Vec::new();
    for name in &arguments.scenarios {
        for controller in &controllers {
            let options = ScenarioOptions {
                controller: Some(controller.clone()),
                set: arguments.set.clone(),
                ..ScenarioOptions::default()
            };
            let scenario = group::open(name, &options)?;
            for notice in scenario.notices() {
                eprintln!("note: {notice}");
            }
            batch::check(&scenario, arguments.mode.into(), &arguments.group)?;
            scenarios.push(scenario);
        }
    }
    Ok(scenarios)
}

/// Does the runs that are left of this part.
fn drive(arguments: &CompareArguments) -> Result<ExitCode, Error> {
    let scenarios = scenarios(arguments)?;
    let mode = arguments.mode.into();
    let study = Study::of_this_command(scenarios.len(), &scenarios[0]);
    let (mut part, output) = Part::<Row>::open(&arguments.parts, &arguments.output, study)?;
    let left = part.left();
    let bar = report::progress::count_bar(part.runs(), arguments.json);
    bar.set_position((part.runs() - left.len()) as u64);
    let repeated = part.repeated(&left, scenarios[0].seed.value());
    let at_once = batch::at_once(None, mode);
    let make = |index: usize| {
        Ok(Job {
            scenario: scenarios[left[index]].clone(),
            mode,
            sample_every: None,
            record: false,
        })
    };
    let source = Source { runs: left.len(), make: &make };
    let mut pictures: BTreeMap<usize, RunPicture> = BTreeMap::new();
    let mut each = |index: usize, job: &Job, result: Result<batch::Done, Error>| {
        let done = result?;
        pictures.insert(left[index], RunPicture::of_drive(&job.scenario, &done.drive));
        let summary = done.summary;
        let row = Row {
            scenario: summary.scenario,
            controller: summary.controller,
            mode: summary.mode.to_owned(),
            outcome: summary.outcome,
            control: summary.control,
            timing: summary.timing,
            aebs: Braking::of(&summary.aebs),
            picture: RunPicture::default(),
        };
        part.keep(left[index], row, done.repetition.as_ref())
    };
    let end = batch::run_made(&repeated, &source, at_once, &arguments.group, &bar, &mut each);
    part.finish(end, left.len(), &bar, &output)?;
    let (mut rows, sample) = part.into_results();
    for (run, picture) in pictures {
        rows[run].as_mut().expect("it was driven").picture = picture;
    }
    let sample = sample.agreed(|run| {
        let Scenario { name, controller, .. } = &scenarios[run];
        format!(" ({} with {})", name.as_str(), controller.name.as_str())
    })?;
    conclude(arguments, rows, sample, &output)
}

/// Puts parts together. A page has no pictures then: parts keep figures.
fn merge(arguments: &CompareArguments) -> Result<ExitCode, Error> {
    let merged =
        Merged::<Row>::read("compare", &arguments.parts.merge, arguments.output.out.as_deref())?;
    let scenarios = scenarios(&merged.study.arguments()?)?;
    merged.check(scenarios.len(), &scenarios[0])?;
    name_incomplete(&merged.incomplete);
    let output = OutputDirectory::create(&arguments.output, "compare")?;
    let whole = merged.incomplete.is_empty();
    let code = conclude(arguments, merged.results, merged.sample, &output)?;
    Ok(if whole { code } else { ExitCode::FAILURE })
}

/// Writes and prints.
fn conclude(
    arguments: &CompareArguments,
    rows: Vec<Option<Row>>,
    processes_sample: ProcessesSample,
    output: &OutputDirectory,
) -> Result<ExitCode, Error> {
    let rows: Vec<_> = rows.into_iter().flatten().collect();
    let whole = rows.iter().all(|row| row.outcome == Outcome::Completed);
    let comparison = Comparison { schema_version: 1, rows, processes_sample };
    let json = serde_json::to_string_pretty(&comparison).expect("plain data");
    let written = output.write("compare.json", (json.clone() + "\n").as_bytes());
    let written =
        written.and_then(|()| output.write(report::FILE, page::page(&comparison.rows).as_bytes()));
    if arguments.json {
        print::out(&(json + "\n"))?;
    } else {
        print::out(&table(&comparison.rows))?;
        print::out(&output.places())?;
    }
    written?;
    Ok(if whole { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The rows as text: one table for each scenario.
fn table(rows: &[Row]) -> String {
    let blocks = rows.chunk_by(|a, b| a.scenario == b.scenario).map(|rows| {
        let columns = columns::shown(rows);
        let figures = columns.iter().map(|column| (column.heading, Align::Right));
        let head = [("", Align::Left), ("outcome", Align::Left)].into_iter().chain(figures);
        let mut table = TextTable::new(head);
        for row in rows {
            let words = [row.controller.clone(), print::outcome_word(row.outcome).to_owned()];
            table.row(words.into_iter().chain(columns.iter().map(|column| column.cell(row))));
        }
        let (scenario, mode) = (&rows[0].scenario, &rows[0].mode);
        format!("{scenario} ({mode})\n{}", table.text())
    });
    blocks.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::FromArgMatches;
    use report::{Following, Trip};
    use runtime::report::ControlFigures;

    /// A row of a car: without fuel, and without deadlines, since it was driven in lockstep.
    fn row(controller: &str, min_gap_m: f64) -> Row {
        let figures = ControlFigures {
            min_gap_m: Some(min_gap_m),
            rms_gap_error_m: Some(0.5),
            ..ControlFigures::default()
        };
        let following = Following { min_time_gap_s: Some(1.25), median_time_gap_s: Some(1.5) };
        Row {
            scenario: "following".into(),
            controller: controller.into(),
            mode: "lockstep".into(),
            outcome: Outcome::Completed,
            control: Control { figures, following, trip: Trip::default(), mode_changes: None },
            timing: Timing::default(),
            aebs: Braking { interventions: Some(2), ..Braking::default() },
            picture: RunPicture::default(),
        }
    }

    #[test]
    fn time_gaps_are_shown_and_columns_without_a_figure_are_not() {
        let rows = [row("acc-mpc", 20.0), row("six-mode", -0.01)];
        for text in [table(&rows), page::page(&rows)] {
            for heading in ["min time gap, s", "median time gap, s", "gap error rms, m"] {
                assert!(text.contains(heading), "{heading}: {text}");
            }
            for heading in ["fuel", "missed", "gap error at the end"] {
                assert!(!text.contains(heading), "{heading}: {text}");
            }
            assert!(!text.contains("-0.0") && !text.contains("−0.0"), "{text}");
        }
    }

    #[test]
    fn one_program_is_not_compared_with_itself() {
        let arguments = |words: &[&str]| {
            let command = CompareArguments::augment_args(clap::Command::new("compare"));
            let matches = command.get_matches_from([&["compare", "cacc-a"], words].concat());
            CompareArguments::from_arg_matches(&matches).expect("they are arguments")
        };
        let program = ["--service", "controller=./mine"];
        let said = scenarios(&arguments(&program)).expect_err("many laws").to_string();
        assert!(said.contains("expected one law by --controllers"), "{said}");
        let one = [&program[..], &["--controllers", "acc-mpc"]].concat();
        assert_eq!(scenarios(&arguments(&one)).expect("one law").len(), 1);
    }
}
