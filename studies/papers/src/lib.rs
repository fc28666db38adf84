//! `timegap papers`: a paper's scenarios in lockstep, and the expected figures beside ours.
//!
//! ```text
//! paper ─ pieces ─► scenarios ─► rows: expected, ours, tolerance ─► tables of each set, verdict
//! ```
//!
//! The verdict is over all rows that are compared, whatever their set. A row outside its tolerance makes it false and
//! the exit status 1, without exception. `docs/papers.md` names each row that is known to fail, with its reason. A
//! test compares that page with a run.

pub mod cacc;
mod cacc_varied;
mod page;
mod predictive;
mod quadratic_bounded;
pub mod row;
pub mod runner;
mod six_mode;
mod study;
mod tally;
pub mod trips;

pub use page::schema;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use frame::{Command, Entry};
use report::gate::{Against, Sample};
use report::results::Object;
use row::Row;
use runner::{Pictures, Piece};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use study::Papers;
use supervise::{Error, number_within};
use tally::Tally;

/// The papers, in the order of their results.
pub const PAPERS: [PaperName; 4] =
    [PaperName::SixMode, PaperName::QuadraticBounded, PaperName::Predictive, PaperName::Cacc];

/// Figures of the papers beside ours.
#[derive(Debug, Serialize, JsonSchema)]
struct Reproduction {
    schema_version: u32,
    /// Every compared figure is within its tolerance.
    ok: bool,
    papers: Vec<Paper>,
    /// Figures of each row, for `--against`.
    #[schemars(with = "Vec<Object>")]
    samples: Vec<Sample>,
    /// The rows against those of `--against`; null without it.
    against: Option<Against>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Paper {
    /// Name of the paper's controller.
    paper: &'static str,
    /// Counts of its figures within their tolerance, each counted once.
    tally: Vec<Tally>,
    rows: Vec<Row>,
    #[serde(skip)]
    pictures: Pictures,
}

#[derive(Clone, Debug, Args, Serialize, Deserialize)]
pub struct ReproduceArguments {
    /// Paper [default: all]
    #[arg(value_enum)]
    pub paper: Option<PaperName>,
    /// Standard deviation of the skilled driver's aimed speed, km/h
    #[arg(long, value_name = "KMH", default_value_t = 2.5, value_parser = number_within(0.0..=15.0, "a speed in km/h"))]
    pub driver_spread: f64,
    /// Judge the rows by an earlier result, its reproduce.json: one that got worse is status 1
    #[arg(long, value_name = "FILE")]
    pub against: Option<PathBuf>,
    /// Seeded variants of each scene in which the default law drives, at most 250
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=250))]
    pub variants: u32,
}

/// A paper by the name of its controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
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
        ["six-mode", "quadratic-bounded", "predictive", "cacc"][self as usize]
    }

    /// Its pieces, with `variants` of each scene of the default law.
    fn pieces(self, variants: u32) -> Vec<Piece> {
        match self {
            Self::SixMode => six_mode::pieces(),
            Self::QuadraticBounded => quadratic_bounded::pieces(),
            Self::Predictive => predictive::pieces(),
            Self::Cacc => [cacc::pieces(), cacc_varied::pieces(variants)].concat(),
        }
    }
}

/// The study, for `merge` and `resume`.
pub const ENTRY: Entry = Entry::of::<Papers>();

pub fn run(command: &Command<ReproduceArguments>) -> Result<ExitCode, Error> {
    frame::run::<Papers>(command)
}
