//! `timegap test r157`: UN R157's matrices, by its performance models and by our control laws.
//!
//! ```text
//! matrix ─► case ─┬─ models ──────────────► verdict ┐
//!                 └─ law, brake on and off ► verdict ┴─► limits: collisions where a model has none
//! ```
//!
//! A run of the study is a case with a law, driven with the emergency brake, and without it where the brake acted.

mod document;
mod drive;
mod limits;
mod matrix;
mod picture;
mod results;
mod scene;

pub use drive::verdict;
pub use matrix::{Case, Matrix, sample};
pub use scene::Scenes;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use controller::laws;
use drive::Ends;
use frame::batch::{self, Job};
use frame::{Command, Crew, DriveOptions, Entry, Found, Needs, Recorded, RunOptions, Study};
use report::results::{Document, Schema};
use results::{Driven, Judged, MatrixResult, Results};
use serde::{Deserialize, Serialize};
use supervise::{Error, UsageError};

use crate::{Model, Verdict};

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct R157Arguments {
    /// Matrices, by commas [default: all]
    #[arg(long, value_enum, value_name = "NAME,...", value_delimiter = ',')]
    pub matrix: Vec<Matrix>,
    /// Laws, keys and requirements of all drives.
    #[command(flatten)]
    pub drives: DriveOptions,
    /// Drive the regulation's models alone, without controllers and processes
    #[arg(long, conflicts_with_all = ["controllers", "laws", "set", "require", "processes", "programs", "ready_timeout", "shard", "resume"])]
    pub models_only: bool,
    /// Draw this many cases of each matrix [default: all]
    #[arg(long, value_name = "N")]
    pub sample: Option<NonZeroUsize>,
    /// Seed of the drawn cases and of the sensors' noise
    #[arg(long, value_name = "S", default_value_t = 1)]
    pub seed: u32,
    /// Write the models' outcomes of the cut-ins as CSV
    #[arg(long, value_name = "FILE")]
    #[serde(skip)]
    pub table: Option<PathBuf>,
}

/// Every case of every matrix by every law, in this order.
pub struct Plan {
    arguments: R157Arguments,
    scenes: Scenes,
    matrices: Vec<(Matrix, Vec<Case>)>,
    laws: Vec<String>,
}

pub fn schema() -> Schema {
    Schema::of::<Results>("r157")
}

pub fn run(command: &Command<R157Arguments>) -> Result<ExitCode, Error> {
    if let Some(path) = &command.study.table {
        command.study.write_table(path)?;
    }
    frame::run::<Plan>(command)
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Plan>();

impl Study for Plan {
    type Arguments = R157Arguments;
    type Record = Ends;
    type Seen = ();

    const NAME: &'static str = "r157";
    const NEEDS: Needs = Needs::All;

    fn plan(arguments: &R157Arguments, _: &RunOptions) -> Result<Self, Error> {
        let R157Arguments { drives, models_only, .. } = arguments;
        let plan = Self {
            arguments: arguments.clone(),
            scenes: Scenes::new(arguments.seed.into(), drives.clone()),
            matrices: arguments.matrices(),
            laws: match models_only {
                true => Vec::new(),
                false => drives.own_named()?,
            },
        };
        plan.subject()?;
        Ok(plan)
    }

    fn runs(&self) -> usize {
        self.matrices.iter().map(|(_, cases)| cases.len() * self.laws.len()).sum()
    }

    /// A scenario that identifies the study.
    fn subject(&self) -> Result<String, Error> {
        let law = self.laws.first().map_or(laws::ALL[0].name, String::as_str);
        Ok(self.scenes.scenario(&Matrix::CutIn.cases()[0], law, false)?.to_toml())
    }

    fn drive(&self, run: usize, crew: &Crew<'_>) -> Recorded<Self> {
        let (_, (_, case), law) = self.place(run);
        let record = Ends::of(|aebs| {
            let job = Job::lockstep(self.scenes.scenario(case, law, aebs)?);
            let done = crew.drive(run, &job)?;
            batch::whole(&done.summary)?;
            crew.observe(run, &self.keys_of(run, aebs), &job.scenario, &done);
            Ok(done)
        })?;
        Ok((record, ()))
    }

    fn keys(&self, run: usize) -> Vec<(String, String)> {
        self.keys_of(run, false)
    }

    fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
        let ends: Vec<Ends> = found.records.all()?.into_iter().map(|(_, ends)| ends).collect();
        let judged = self.judged(&ends)?;
        let matrices: Vec<MatrixResult> = judged.iter().map(Judged::result).collect();
        let ok = matrices.iter().all(MatrixResult::holds);
        let results = Results { schema_version: 1, ok, matrices };
        Ok(document::document(&results, &judged, &self.arguments))
    }
}

impl Plan {
    /// Matrix, case with its place in the matrix, and law of run number `run`.
    fn place(&self, mut run: usize) -> (Matrix, (usize, &Case), &str) {
        for (matrix, cases) in &self.matrices {
            let number = run % cases.len();
            if let Some(law) = self.laws.get(run / cases.len()) {
                return (*matrix, (number, &cases[number]), law);
            }
            run -= cases.len() * self.laws.len();
        }
        unreachable!("the runs are numbered up to their count")
    }

    /// The keys of a drive of run number `run`.
    fn keys_of(&self, run: usize, aebs: bool) -> Vec<(String, String)> {
        let (matrix, (number, _), _) = self.place(run);
        let keys = [
            ("matrix", matrix.name().to_owned()),
            ("case", (number + 1).to_string()),
            ("aebs", aebs.to_string()),
        ];
        keys.map(|(name, value)| (name.to_owned(), value)).to_vec()
    }

    /// The verdicts of models and drivers, by the ends of all runs.
    fn judged(&self, ends: &[Ends]) -> Result<Vec<Judged>, Error> {
        let mut left = ends;
        let mut all = Vec::new();
        for (matrix, cases) in &self.matrices {
            let mut judged = Judged::new(*matrix, cases.clone());
            for law in &self.laws {
                let (of_law, rest) = left.split_at(cases.len());
                left = rest;
                let from_its_gap = self.yardstick(law, cases)?;
                for aebs in [false, true] {
                    judged.drivers.push(Driven {
                        law: law.clone(),
                        aebs,
                        ends: of_law.iter().map(|ends| ends.end(aebs)).collect(),
                        from_its_gap: from_its_gap.clone(),
                    });
                }
            }
            all.push(judged);
        }
        Ok(all)
    }

    /// Verdicts of `careful-driver` on cut-outs from a law's gap; `None` for other cases.
    fn yardstick(&self, law: &str, cases: &[Case]) -> Result<Option<Vec<Verdict>>, Error> {
        let verdict = |case: &Case| match case {
            Case::CutOut(case) => Some(
                (self.scenes.gap_m(law, case.speed_kmh))
                    .map(|gap_m| case.drive_from(Model::CarefulDriver, gap_m)),
            ),
            Case::CutIn(_) | Case::Following(_) => None,
        };
        let verdicts: Vec<Verdict> = cases.iter().filter_map(verdict).collect::<Result<_, _>>()?;
        Ok((!verdicts.is_empty()).then_some(verdicts))
    }
}

impl R157Arguments {
    fn matrices(&self) -> Vec<(Matrix, Vec<Case>)> {
        let all = Matrix::value_variants();
        let named = |matrix: &&Matrix| self.matrix.is_empty() || self.matrix.contains(matrix);
        let count = self.sample.map_or(usize::MAX, NonZeroUsize::get);
        let draw = |matrix: Matrix| (matrix, sample(matrix.cases(), count, self.seed.into()));
        all.iter().filter(named).copied().map(draw).collect()
    }

    /// The command that drives one law through one matrix.
    fn command(&self, matrix: &str, law: &str) -> String {
        let seed = self.seed.to_string();
        let words =
            ["timegap", "test", "r157", "--matrix", matrix, "--controllers", law, "--seed", &seed];
        let mut words = [words.map(str::to_owned).to_vec(), self.drives.words()].concat();
        let sample = self.sample.map(|count| ["--sample".to_owned(), count.to_string()]);
        words.extend(sample.into_iter().flatten());
        runtime::command_line(&words)
    }

    /// Writes the models' outcomes of the cut-ins.
    fn write_table(&self, path: &Path) -> Result<(), Error> {
        let matrices = self.matrices();
        let cases = matrices.iter().flat_map(|(_, cases)| cases);
        let cut_ins: Vec<_> = cases.filter_map(Case::cut_in).collect();
        if cut_ins.is_empty() {
            let why = "the table has the cut-ins, and there are none";
            return Err(
                UsageError::option("--table", path.display(), why, "--matrix cut-in").into()
            );
        }
        std::fs::write(path, matrix::csv(cut_ins)).map_err(Error::path("write", path))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use clap::FromArgMatches;
    use messages::Service;
    use supervise::GroupOptions;
    use supervise::in_process;
    use supervise::report::PlantReport;

    use super::*;

    fn command(words: &[&str]) -> Command<R157Arguments> {
        let command = Command::<R157Arguments>::augment_args(clap::Command::new("r157"));
        let matches = command.get_matches_from([&["r157"], words].concat());
        Command::from_arg_matches(&matches).expect("they are arguments")
    }

    /// Digests of all messages except the brake's own, and the count of its interventions.
    fn drive(case: &Case, law: &str, aebs: bool) -> (BTreeMap<String, String>, u64) {
        let scenes = Scenes::new(1, DriveOptions::default());
        let scenario = scenes.scenario(case, law, aebs).expect("a law");
        let group = in_process::run(&scenario).expect("it runs");
        let plant = group.reports[&Service::Plant].details.read::<PlantReport>();
        let plant = plant.expect("the plant has its own report");
        let reports = group.reports.iter().filter(|(service, _)| **service != Service::Aebs);
        let sent = reports.flat_map(|(_, report)| &report.sent);
        let sent = sent.filter(|sent| sent.topic != "health/heartbeat");
        let digests = sent.map(|sent| (sent.topic.clone(), sent.digest.clone().expect("sealed")));
        (digests.collect(), plant.aebs.as_ref().map_or(0, |brake| brake.interventions))
    }

    #[test]
    fn a_run_in_which_the_brake_never_acted_is_the_run_without_it() {
        let (mut silent, mut acted) = (0, 0);
        for matrix in Matrix::value_variants() {
            for case in sample(matrix.cases(), 8, 3) {
                let (with_brake, interventions) = drive(&case, "six-mode", true);
                let (alone, _) = drive(&case, "six-mode", false);
                if interventions == 0 {
                    assert_eq!(with_brake, alone, "{case:?}");
                    silent += 1;
                } else {
                    assert_ne!(with_brake, alone, "{case:?}");
                    acted += 1;
                }
            }
        }
        assert!(silent > 0 && acted > 0, "{silent} and {acted}");
    }

    #[test]
    fn a_table_without_cut_ins_is_refused_and_a_matrix_counts_once() {
        let table = command(&["--matrix", "following"]).study.write_table(Path::new("x.csv"));
        let said = table.expect_err("no cut-ins").to_string();
        assert!(said.contains("--table x.csv: ") && said.contains("--matrix cut-in"), "{said}");
        let twice = command(&["--matrix", "cut-in,cut-in", "--sample", "5"]).study.matrices();
        assert_eq!(twice.iter().map(|(_, cases)| cases.len()).collect::<Vec<_>>(), [5]);
    }

    #[test]
    fn every_driver_has_the_verdict_of_a_run_of_its_own() {
        let command = command(&["--sample", "2", "--controllers", "six-mode,acc-mpc"]);
        let plan = Plan::plan(&command.study, &command.options).expect("laws");
        assert_eq!(plan.runs(), 12);
        assert_eq!(plan.keys_of(7, true)[0].1, "following", "{:?}", plan.keys_of(7, true));
        let group = GroupOptions { programs: Vec::new(), ready_timeout: 1.0, processes: false };
        let drive = |case: &Case, law: &str, aebs: bool| {
            batch::lockstep(&plan.scenes.scenario(case, law, aebs)?, &group, &|| true)
        };
        let ends = (0..plan.runs()).map(|run| {
            let (_, (_, case), law) = plan.place(run);
            Ends::of(|aebs| drive(case, law, aebs)).expect("it runs")
        });
        let ends: Vec<Ends> = ends.collect();
        for judged in plan.judged(&ends).expect("it runs") {
            let names = judged.drivers.iter().map(|driven| (driven.law.as_str(), driven.aebs));
            let expected =
                ["six-mode", "acc-mpc"].iter().flat_map(|&law| [(law, false), (law, true)]);
            assert!(names.eq(expected), "{judged:?}");
            for Driven { law, aebs, ends, from_its_gap } in &judged.drivers {
                assert_eq!(from_its_gap.is_some(), judged.matrix == Matrix::CutOut);
                for (case, end) in judged.cases.iter().zip(ends) {
                    let own = drive(case, law, *aebs).expect("it runs");
                    assert_eq!(end.verdict, verdict(&own.drive), "{law} {aebs} {case:?}");
                }
            }
        }
    }

    #[test]
    fn a_result_names_the_command_that_drives_its_law_again() {
        let words = ["--sample", "9", "--seed", "4", "--law", "mine=python3 'my law.py'"];
        let command = command(&words).study.command("cut-in", "mine");
        let begin = "timegap test r157 --matrix cut-in --controllers mine --seed 4 --law ";
        assert!(command.starts_with(begin) && command.ends_with("--sample 9"), "{command}");
    }
}
