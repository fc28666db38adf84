//! `timegap r157`: UN R157's matrices, by its performance models and by our control laws.

mod judge;
mod matrix;
mod page;
mod print;
mod results;
mod scene;

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use controller::laws;
use group::{Error, GroupOptions};
use indicatif::ProgressBar;
use matrix::{Case, Matrix};
use regulation::{Verdict, table};
use report::output::{OutputDirectory, OutputOptions};
use results::{Judged, MatrixResult, Results};
use runtime::Mode;
use scene::Driver;

use crate::batch::{self, Job, ProcessesSample};

/// Cases that are made scenarios, and run, at a time.
const CHUNK: usize = 512;

/// Arguments of `r157`.
#[derive(Debug, Args)]
pub struct R157Arguments {
    /// Matrices, by commas [default: all]
    #[arg(long, value_enum, value_name = "NAME,...", value_delimiter = ',')]
    pub matrix: Vec<Matrix>,
    /// Controllers, by commas [default: all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', conflicts_with = "models_only")]
    pub controllers: Vec<String>,
    /// Drive the regulation's models alone, no controller
    #[arg(long)]
    pub models_only: bool,
    /// Draw this many cases of each matrix [default: all]
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// Seed of the drawn cases and of the sensors' noise
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u32,
    /// Write the models' outcomes of the cut-ins as a table
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Where the results go.
    #[command(flatten)]
    pub output: OutputOptions,
    /// Print the results as JSON, and nothing else, on standard output
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// [`Error::Usage`] for an unknown controller or a table without cut-ins, else what keeps the runs from
/// starting.
pub fn run(arguments: &R157Arguments) -> Result<ExitCode, Error> {
    let drivers = drivers(arguments)?;
    let mut matrices = arguments.matrix.clone();
    if matrices.is_empty() {
        matrices = Matrix::value_variants().to_vec();
    }
    matrices.sort_unstable();
    matrices.dedup();
    let mut judged: Vec<Judged> =
        matrices.into_iter().map(|matrix| Judged::new(matrix, cases(matrix, arguments))).collect();
    if let Some(path) = &arguments.csv {
        write_table(path, &judged)?;
    }
    let output = OutputDirectory::create(&arguments.output, "r157")?;
    let runs: usize = judged.iter().map(|judged| judged.cases.len() * drivers.len()).sum();
    let bar = report::progress::count_bar(runs, arguments.json);
    let mut batches = Batches::new(arguments, &bar, runs);
    for judged in &mut judged {
        for driver in &drivers {
            let verdicts = batches.drive(&judged.cases, driver)?;
            judged.laws.push((driver.clone(), verdicts));
        }
    }
    let processes_sample = batches.finish(runs)?;
    bar.finish_and_clear();
    let matrices: Vec<MatrixResult> = judged.iter().map(Judged::result).collect();
    let ok = matrices.iter().all(MatrixResult::holds);
    let results = Results { schema_version: 1, ok, matrices, processes_sample };
    let json = serde_json::to_string_pretty(&results).expect("plain data") + "\n";
    let written = output.write("r157.json", json.as_bytes());
    let written =
        written.and_then(|()| output.write(report::FILE, page::page(&results, &judged).as_bytes()));
    if arguments.json {
        report::print::out(&json)?;
    } else {
        report::print::out(&print::text(&results))?;
        report::print::out(&format!("results: {}\n", output.path().display()))?;
        report::print::out(&format!("report:  {}\n", output.path().join(report::FILE).display()))?;
    }
    written?;
    Ok(if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Each law alone and with the emergency brake; nothing for the models alone.
fn drivers(arguments: &R157Arguments) -> Result<Vec<Driver>, Error> {
    if arguments.models_only {
        return Ok(Vec::new());
    }
    let laws: Vec<String> = if arguments.controllers.is_empty() {
        laws::ALL.iter().map(|law| law.name.to_owned()).collect()
    } else {
        arguments.controllers.clone()
    };
    // An unknown law is found before anything runs.
    let cases = Matrix::Following.cases();
    let mut drivers = Vec::new();
    for law in laws {
        let alone = Driver { law, aebs: false };
        let scenario = scene::scenario(&cases[0], &alone, 1)?;
        let with_brake = Driver { aebs: true, ..alone.clone() };
        drivers.push(alone);
        // The emergency brake reads the radar's detections.
        if scenario.perception.gives_detections() {
            drivers.push(with_brake);
        }
    }
    Ok(drivers)
}

fn cases(matrix: Matrix, arguments: &R157Arguments) -> Vec<Case> {
    let cases = matrix.cases();
    match arguments.sample {
        Some(count) => matrix::sample(cases, count.get(), u64::from(arguments.seed)),
        None => cases,
    }
}

/// All runs of the command, a part at a time: so many scenarios would not fit in memory at once.
struct Batches<'a> {
    arguments: &'a R157Arguments,
    bar: &'a ProgressBar,
    /// The runs to be repeated in process groups, of all.
    repeated: BTreeSet<usize>,
    sample: ProcessesSample,
    /// Runs before the next one.
    done: usize,
}

impl<'a> Batches<'a> {
    fn new(arguments: &'a R157Arguments, bar: &'a ProgressBar, runs: usize) -> Self {
        let repeated = batch::choose(arguments.seed.into(), runs);
        Self { arguments, bar, repeated, sample: ProcessesSample::default(), done: 0 }
    }

    /// Drives the cases one by one.
    fn drive(&mut self, cases: &[Case], driver: &Driver) -> Result<Vec<Verdict>, Error> {
        let at_once = batch::at_once(None, Mode::Lockstep);
        let group = &self.arguments.group;
        let mut verdicts = Vec::with_capacity(cases.len());
        for chunk in cases.chunks(CHUNK) {
            let scenario = |case| scene::scenario(case, driver, self.arguments.seed.into());
            let jobs = chunk
                .iter()
                .map(|case| scenario(case).map(Job::lockstep))
                .collect::<Result<Vec<_>, Error>>()?;
            let first = self.done;
            let repeated = (0..jobs.len()).filter(|k| self.repeated.contains(&(first + k)));
            let mut found = vec![Verdict::NONE; jobs.len()];
            let mut each = |index: usize, result: Result<batch::Done, Error>| {
                let done = result?;
                batch::whole(&done.summary)?;
                found[index] = judge::verdict(&done.drive);
                Ok(())
            };
            let sample = batch::run_repeating(
                &repeated.collect(),
                &jobs,
                at_once,
                group,
                self.bar,
                &mut each,
            )?;
            self.sample.add(sample, first);
            self.done += jobs.len();
            verdicts.extend(found);
        }
        Ok(verdicts)
    }

    /// Says what came of the runs that were repeated in process groups.
    fn finish(self, runs: usize) -> Result<ProcessesSample, Error> {
        self.sample.tell(runs, self.bar);
        self.sample.agreed(|_| String::new())
    }
}

fn write_table(path: &std::path::Path, judged: &[Judged]) -> Result<(), Error> {
    let cut_ins: Vec<_> = judged
        .iter()
        .flat_map(|judged| &judged.cases)
        .filter_map(|case| match case {
            Case::CutIn(case) => Some(*case),
            Case::Following(_) | Case::CutOut(_) => None,
        })
        .collect();
    if cut_ins.is_empty() {
        return Err(Error::Usage(
            "--csv writes the cut-ins, and there are none: add --matrix cut-in".into(),
        ));
    }
    let mut text = Vec::new();
    table::write_cut_ins(&mut text, cut_ins).expect("memory takes every byte");
    std::fs::write(path, text).map_err(|reason| Error::Path {
        action: "write",
        path: path.to_owned(),
        reason,
    })
}
