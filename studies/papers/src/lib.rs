//! `timegap reproduce`: a paper's scenarios through the real processes, the expected figures beside
//! ours.
//!
//! Scenarios are driven on all cores: papers, and within a paper everything that does not wait for
//! the result of another run, go on side by side ([`runner`]).
//!
//! The verdict is judged over all rows that are compared, whatever their set: a row outside its
//! tolerance makes it false and the exit status 1. Nothing is excused here. Which rows are known to
//! fail, and why, is written in `docs/papers.md`, which a test compares with a run.

pub mod cacc;
mod cacc_default;
mod columns;
mod console;
mod page;
mod predictive;
mod quadratic_bounded;
pub mod row;
mod runner;
mod six_mode;
mod tally;

use clap::{Args, ValueEnum};
pub use columns::schema;

use frame::batch::ProcessesSample;
use group::Error;
use group::GroupOptions;
use page::page;
use report::RunPicture;
use report::chart::Plot;
use report::output::OutputDirectory;
use report::print;
use report::results::ResultOptions;
use row::{Row, Verdict};
use runner::{Part, Runner, together};
use serde::Serialize;
use std::process::ExitCode;
use tally::Tally;

/// The papers, in the order of their names.
pub const PAPERS: [PaperName; 4] =
    [PaperName::SixMode, PaperName::QuadraticBounded, PaperName::Predictive, PaperName::Cacc];

#[derive(Debug, Serialize)]
struct Reproduction {
    schema_version: u32,
    ok: bool,
    papers: Vec<Paper>,
    processes_sample: ProcessesSample,
}

#[derive(Debug, Serialize)]
struct Paper {
    paper: &'static str,
    /// Counts of its figures within their tolerance, each counted once.
    tally: Vec<Tally>,
    rows: Vec<Row>,
    #[serde(skip)]
    drives: Vec<(String, RunPicture)>,
    #[serde(skip)]
    pictures: Vec<Gallery>,
}

/// Pictures of a paper's own, below one heading.
struct Gallery {
    heading: String,
    plots: Vec<Plot>,
}

impl std::fmt::Debug for Gallery {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} ({} pictures)", self.heading, self.plots.len())
    }
}

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
pub struct ReproduceArguments {
    /// Which paper; all when omitted
    #[arg(value_enum)]
    pub paper: Option<PaperName>,
    /// Standard deviation of the skilled driver's aimed speed, km/h
    #[arg(long, value_name = "KMH", default_value_t = 2.5, value_parser = spread)]
    pub driver_spread: f64,
    /// How each run's processes are started.
    #[command(flatten)]
    pub group: GroupOptions,
    /// Where the results go, and in which forms.
    #[command(flatten)]
    pub results: ResultOptions,
}

/// A spread of a driver's speed, km/h.
fn spread(text: &str) -> Result<f64, NoSpread> {
    text.parse().ok().filter(|value| (0.0..=15.0).contains(value)).ok_or(NoSpread)
}

/// A spread that no driver has.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("expected a number from 0 to 15, in km/h")]
struct NoSpread;

/// A paper by the name of its controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PaperName {
    /// Wang, Liu, Zhang, Tong 2014.
    SixMode,
    /// Gao, Yan, Li, Hu 2015.
    QuadraticBounded,
    /// Li, Zheng, Wang, Wang.
    Predictive,
    /// He, Xi, Huang, Chen, Huang 2024.
    Cacc,
}

impl PaperName {
    /// Name on the command line and in results.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::SixMode => "six-mode",
            Self::QuadraticBounded => "quadratic-bounded",
            Self::Predictive => "predictive",
            Self::Cacc => "cacc",
        }
    }

    /// Scenarios driven, at most.
    const fn runs(self) -> usize {
        match self {
            Self::SixMode => six_mode::RUNS,
            Self::QuadraticBounded => quadratic_bounded::RUNS,
            Self::Predictive => predictive::RUNS,
            Self::Cacc => cacc::RUNS + cacc_default::RUNS,
        }
    }

    fn reproduce(self, runner: &Runner<'_>) -> Result<Part, Error> {
        match self {
            Self::SixMode => six_mode::reproduce(runner),
            Self::QuadraticBounded => quadratic_bounded::reproduce(runner),
            Self::Predictive => predictive::reproduce(runner),
            Self::Cacc => cacc_default::add_rows(cacc::reproduce(runner)?, runner),
        }
    }
}

/// Runs the command.
pub fn run(arguments: &ReproduceArguments) -> Result<ExitCode, Error> {
    let output = OutputDirectory::create(&arguments.results.output, "reproduce")?;
    let papers = arguments.paper.map_or(PAPERS.to_vec(), |paper| vec![paper]);
    let runs = papers.iter().map(|paper| paper.runs()).sum();
    let runner = Runner::new(&arguments.group, runs, arguments.results.json)?;
    let runner = runner.with_driver_spread(arguments.driver_spread / 3.6);
    let parts = together(papers.iter().map(|paper| || paper.reproduce(&runner)));
    let sample = runner.finish();
    let mut done = Vec::new();
    for (name, part) in papers.iter().zip(parts) {
        let Part { rows, drives, pictures } = part?;
        let tally = tally::tally(&rows);
        done.push(Paper { paper: name.as_str(), tally, rows, drives, pictures });
    }
    let processes_sample = sample?;
    let ok = done.iter().flat_map(|paper| &paper.rows).all(|row| row.verdict() != Verdict::Outside);
    let reproduction = Reproduction { schema_version: 1, ok, papers: done, processes_sample };
    let json = serde_json::to_string_pretty(&reproduction).expect("plain data");
    let written = output.write("reproduce.json", (json.clone() + "\n").as_bytes());
    let written = written.and_then(|()| output.write(report::FILE, page(&reproduction).as_bytes()));
    if arguments.results.json {
        print::out(&(json + "\n"))?;
    } else {
        for paper in &reproduction.papers {
            print::out(&console::table(paper.paper, &paper.rows))?;
        }
        print::out(&output.places())?;
    }
    written?;
    arguments.results.export(&columns::document(&reproduction))?;
    Ok(if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
