//! `timegap compare`: laws side by side on the same scenarios.
//!
//! ```text
//! scenario 1 ─┬─ law A ─► row ┐
//!             └─ law B ─► row ┴─► block of scenario 1: the best of each column is marked
//! ```

mod columns;

pub use columns::schema;

use clap::Args;
use frame::batch::{self, Done, Job, ProcessesSample};
use frame::parts::{self, PartOptions};
use frame::{Found, Needs, Options, Study};
use group::{Error, Failure, GroupOptions, LawOptions, ModeName, ScenarioOptions};
use messages::Service;
use report::results::{Document, ResultOptions};
use report::summary::{Aebs, Control, LawAccount, Timing, braked};
use report::{RunPicture, overlay};

use group::report::Outcome;
use runtime::Mode;
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

#[derive(Debug, Serialize)]
struct Comparison {
    schema_version: u32,
    ok: bool,
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
    #[serde(default)]
    law: Option<LawAccount>,
}

/// Interventions of the emergency brake in a run.
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

/// Options that a merge takes from the parts.
const WITHOUT_MERGE: [&str; 5] = ["scenarios", "controllers", "laws", "mode", "set"];

/// Arguments of `compare`.
#[derive(Debug, Args)]
#[command(mut_arg("merge", |merge| merge.conflicts_with_all(WITHOUT_MERGE).conflicts_with_all(parts::OF_RUNS)))]
pub struct CompareArguments {
    /// Names of built-in scenarios, or TOML files
    #[arg(required_unless_present_any = ["merge", "resume"])]
    pub scenarios: Vec<String>,
    /// Controllers, by commas [default: all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub controllers: Vec<String>,
    /// Laws of the user's own.
    #[command(flatten)]
    pub laws: LawOptions,
    /// Clock: figures of the drive repeat exactly in `lockstep`; `realtime` also measures deadlines
    #[arg(long, value_enum, default_value_t = ModeName::Lockstep)]
    pub mode: ModeName,
    /// Change any key of every scenario, by its dotted path (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Parts of the comparison.
    #[command(flatten)]
    pub parts: PartOptions,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Directory and forms of the results.
    #[command(flatten)]
    pub results: ResultOptions,
}

/// Runs the command.
///
/// # Errors
/// A scenario or law that cannot be driven, else as [`frame::study::run`].
pub fn run(arguments: &CompareArguments) -> Result<ExitCode, Error> {
    frame::study::run::<Laws>(arguments)
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
    "--service controller=PROGRAM: the program would replace each of {laws} laws, and all rows would be the same; \
     expected one law by --controllers"
)]
pub struct OneProgram {
    laws: usize,
}

impl Failure for OneProgram {}

/// The study: each scenario with each law.
struct Laws {
    runs: Vec<Run>,
    mode: Mode,
}

/// A run, with the name of its scenario in results.
struct Run {
    label: String,
    scenario: Scenario,
}

/// The name of a scenario in results: its own, or its file's where another file has the same name.
fn label(argument: &str, all: &[(String, String)]) -> String {
    let own = all.iter().find(|(known, _)| known == argument).map_or(argument, |(_, name)| name);
    if all.iter().filter(|(_, name)| name == own).count() < 2 {
        return own.to_owned();
    }
    let stem = |argument: &str| {
        Path::new(argument).file_stem().map(|stem| stem.to_string_lossy().into_owned())
    };
    match stem(argument) {
        Some(own)
            if all.iter().filter(|(known, _)| stem(known).as_ref() == Some(&own)).count() == 1 =>
        {
            own
        }
        _ => argument.to_owned(),
    }
}

/// The laws of the user's own: of the options, then those that every scenario declares.
fn own_laws(arguments: &CompareArguments) -> Result<Vec<String>, Error> {
    let mut own = arguments.laws.names();
    let options = ScenarioOptions {
        set: arguments.set.clone(),
        laws: arguments.laws.clone(),
        // Any law will do to read what the file declares.
        controller: Some("acc-mpc".to_owned()),
        ..ScenarioOptions::default()
    };
    let mut declared: Option<Vec<String>> = None;
    for argument in &arguments.scenarios {
        let laws = group::open(argument, &options)?.laws;
        match &mut declared {
            Some(declared) => declared.retain(|name| laws.contains_key(name)),
            None => declared = Some(laws.into_keys().collect()),
        }
    }
    own.extend(
        declared.into_iter().flatten().filter(|name| !arguments.laws.names().contains(name)),
    );
    Ok(own)
}

impl Study for Laws {
    type Arguments = CompareArguments;
    type Record = Row;
    type Seen = RunPicture;

    const NAME: &'static str = "compare";
    const NEEDS: Needs = Needs::Part;

    fn options(arguments: &CompareArguments) -> Options<'_> {
        let CompareArguments { parts, group, results, .. } = arguments;
        Options { parts: Some(parts), jobs: None, group, results }
    }

    fn plan(arguments: &CompareArguments) -> Result<Self, Error> {
        let laws = batch::laws::named(&arguments.controllers, &own_laws(arguments)?)?;
        let mut programs = arguments.group.programs.iter();
        if laws.len() > 1 && programs.any(|(service, _)| *service == Service::Controller) {
            return Err(OneProgram { laws: laws.len() }.into());
        }
        let twice = |(place, name): &(usize, &String)| arguments.scenarios[..*place].contains(name);
        if let Some((_, name)) = arguments.scenarios.iter().enumerate().find(twice) {
            return Err(Twice { name: name.clone() }.into());
        }
        let mode = arguments.mode.into();
        let mut runs: Vec<Run> = Vec::new();
        let mut names: Vec<(String, String)> = Vec::new();
        for argument in &arguments.scenarios {
            for law in &laws {
                let options = ScenarioOptions {
                    controller: Some(law.clone()),
                    set: arguments.set.clone(),
                    laws: arguments.laws.clone(),
                    ..ScenarioOptions::default()
                };
                let scenario = group::open(argument, &options)?;
                for notice in scenario.notices() {
                    eprintln!("note: {notice}");
                }
                batch::check(&scenario, mode, &arguments.group)?;
                if names.last().is_none_or(|(known, _)| known != argument) {
                    names.push((argument.clone(), scenario.name.as_str().to_owned()));
                }
                runs.push(Run { label: argument.clone(), scenario });
            }
        }
        runs.iter_mut().for_each(|run| run.label = label(&run.label, &names));
        Ok(Self { runs, mode })
    }

    fn runs(&self) -> usize {
        self.runs.len()
    }

    fn mode(&self) -> Mode {
        self.mode
    }

    fn seed(&self) -> u64 {
        self.runs[0].scenario.seed.value()
    }

    fn job(&self, run: usize) -> Result<Job, Error> {
        Ok(Job { mode: self.mode, ..Job::lockstep(self.runs[run].scenario.clone()) })
    }

    fn record(
        &self,
        run: usize,
        job: &Job,
        result: Result<Done, Error>,
    ) -> Result<(Row, RunPicture), Error> {
        let Done { summary, drive, .. } = result?;
        let row = Row {
            scenario: self.runs[run].label.clone(),
            controller: summary.controller,
            mode: summary.mode.to_owned(),
            outcome: summary.outcome,
            control: summary.control,
            timing: summary.timing,
            aebs: Braking::of(&summary.aebs),
            law: summary.law,
        };
        Ok((row, RunPicture::of_drive(&job.scenario, &drive)))
    }

    fn describe(&self, run: usize) -> String {
        let Run { label, scenario } = &self.runs[run];
        format!(" ({label} with {})", scenario.controller.name.as_str())
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let rows: Vec<(usize, Row)> = found.records.all()?;
        let drives = drives(&rows, &found.seen);
        let rows: Vec<Row> = rows.into_iter().map(|(_, row)| row).collect();
        Ok(document(rows, found.sample, drives))
    }
}

/// The drives of each scenario over each other. Parts of a comparison keep figures alone.
fn drives(rows: &[(usize, Row)], seen: &BTreeMap<usize, RunPicture>) -> Vec<(String, String)> {
    let blocks = rows.chunk_by(|(_, a), (_, b)| a.scenario == b.scenario);
    let drawn = blocks.filter_map(|rows| {
        let pictures =
            rows.iter().map(|(run, row)| Some((row.controller.as_str(), seen.get(run)?)));
        let pictures: Vec<_> = pictures.collect::<Option<_>>()?;
        Some((rows[0].1.scenario.clone(), overlay(&pictures)))
    });
    drawn.collect()
}

fn document(
    rows: Vec<Row>,
    processes_sample: ProcessesSample,
    drives: Vec<(String, String)>,
) -> Document {
    let completed = rows.iter().filter(|row| row.outcome == Outcome::Completed).count();
    let ok = completed == rows.len();
    let braked = braked(rows.iter().filter_map(|row| row.aebs.interventions).sum());
    let all = rows.len();
    let by_backup = rows.iter().filter(|row| row.outcome == Outcome::DrivenByBackup);
    let by_backup: Vec<_> = by_backup.flat_map(|row| &row.law).map(ToString::to_string).collect();
    let backup = if by_backup.is_empty() {
        String::new()
    } else {
        format!("; driven by the backup: {}", by_backup.join(", "))
    };
    let verdict = format!("{completed} of {all} runs completed; {braked}{backup}");
    let about = rows.first().map_or("", |row| row.mode.as_str()).to_owned();
    let whole = Comparison { schema_version: 1, ok, rows, processes_sample };
    let table = columns::table(&whole.rows);
    let table = drives.into_iter().fold(table, |table, (of, html)| table.figures(&of, html));
    Document::new("compare", "Comparison of controllers", &whole)
        .about(about)
        .verdict(ok, verdict)
        .table(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::FromArgMatches;
    use group::report::ControlFigures;
    use report::{Following, Trip};

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
            law: None,
        }
    }

    #[test]
    fn time_gaps_are_shown_and_columns_without_a_figure_are_not() {
        let rows = vec![row("acc-mpc", 20.0), row("six-mode", -0.01)];
        let document = document(rows, ProcessesSample::default(), Vec::new());
        for text in [document.console(80), document.page(), document.markdown()] {
            for heading in ["min time gap, s", "median time gap, s", "gap error rms, m"] {
                assert!(text.contains(heading), "{heading}: {text}");
            }
            for heading in ["fuel", "missed", "gap error at the end"] {
                assert!(!text.contains(heading), "{heading}: {text}");
            }
            assert!(!text.contains("-0.0") && !text.contains("−0.0"), "{text}");
        }
        let wrong = report::results::check(&schema().json(), &document.value());
        assert_eq!(wrong, [""; 0]);
        assert!(document.junit().contains("name=\"following, acc-mpc\""), "{}", document.junit());
    }

    #[test]
    fn files_of_one_name_are_told_apart_by_their_files() {
        let all = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
            pairs.iter().map(|(file, name)| ((*file).to_owned(), (*name).to_owned())).collect()
        };
        let one = all(&[("a/x.toml", "mine"), ("cut-in", "cut-in")]);
        assert_eq!(
            (label("a/x.toml", &one), label("cut-in", &one)),
            ("mine".into(), "cut-in".into())
        );
        let two = all(&[("a/x.toml", "mine"), ("b/y.toml", "mine")]);
        assert_eq!((label("a/x.toml", &two), label("b/y.toml", &two)), ("x".into(), "y".into()));
        let same = all(&[("a/x.toml", "mine"), ("b/x.toml", "mine")]);
        assert_eq!(label("b/x.toml", &same), "b/x.toml");
    }

    #[test]
    fn one_program_is_not_compared_with_itself() {
        let arguments = |words: &[&str]| {
            let command = CompareArguments::augment_args(clap::Command::new("compare"));
            let matches = command.get_matches_from([&["compare", "cacc-a"], words].concat());
            CompareArguments::from_arg_matches(&matches).expect("they are arguments")
        };
        let program = ["--service", "controller=./mine"];
        let said = Laws::plan(&arguments(&program)).err().expect("many laws").to_string();
        assert!(said.contains("expected one law by --controllers"), "{said}");
        let one = [&program[..], &["--controllers", "acc-mpc"]].concat();
        assert_eq!(Laws::plan(&arguments(&one)).expect("one law").runs(), 1);
    }
}
