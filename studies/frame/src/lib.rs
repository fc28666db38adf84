//! The common part of all studies. A study drives many runs and judges them.
//!
//! ```text
//! arguments ─ plan ─► run 0 … run N-1 ─ job ─► drive ─ record ─► journal ─ judge ─► Document
//!                     └─ workers, parts, resume ─────────────┘              every output
//! ```
//!
//! A study implements [`Study`]. The frame does the rest: workers, the journal, `--shard`, `--resume`, `timegap merge`
//! and `timegap resume`. It also has the progress bar, interrupts, the exit status, and every output. It writes the
//! summary figures of every drive as one tidy table ([`drives`]), and keeps trajectories ([`keep`]).
//!
//! # A new study
//!
//! 1. A folder in `studies` with an arguments struct: what the study asks, as clap arguments that serde can keep.
//!    [`RunOptions`] are beside them in [`Command`]; a study does not declare them.
//! 2. A plan: [`Study::plan`] reads and checks everything before the first run. [`Study::job`] makes run `n`.
//!    The scenarios of all runs do not fit in memory, so a job is made when its turn comes.
//! 3. A record: the plain data of a run that the verdict needs. [`Study::record`] makes it in the worker's thread.
//!    The other half of its result ([`Study::Seen`]) is for pictures alone.
//! 4. Columns: `report::results::Column`, one line each. A column's name is the path of its value in the record's
//!    JSON. Tables of them make a `Document`, with a verdict that answers the command's question.
//! 5. `pub fn run(command) { frame::run::<MyStudy>(command) }`, its row in timegap's `cli.rs`, and
//!    [`Entry::of`]`::<MyStudy>()` among the `STUDIES` of its crate, for `merge` and `resume`.
//!
//! A study whose runs depend on earlier ones gets their records back by [`Study::recall`]. Runs that are not one drive
//! implement [`Study::drive`] with a [`Crew`], and hand each drive to [`Crew::observe`]. Runs begin in the order of
//! their numbers, so that a run may wait for an earlier one. [`Study::is_alone`] names runs beside which no other may
//! go on. [`Study::NEEDS`] says whether some of the runs are worth a result. Records stay on the disk, and
//! [`Records::each`](parts::Records::each) reads them back one by one.
//!
//! ```
//! use clap::Args;
//! use frame::batch::{Done, Job};
//! use frame::{Found, Recorded, RunOptions, Study};
//! use supervise::{Error, ScenarioOptions};
//! use report::results::{Column, Document, Table, count, number};
//! use serde::{Deserialize, Serialize};
//!
//! #[derive(Debug, Args, Serialize, Deserialize)]
//! struct Arguments {
//!     #[arg(long, default_value_t = 2)]
//!     seeds: usize,
//! }
//!
//! #[derive(Serialize, Deserialize)]
//! struct Record { seed: usize, min_gap_m: Option<f64> }
//!
//! const COLUMNS: &[Column<Record>] = &[
//!     count("seed", "seed", "Seed of the run"),
//!     number("min_gap_m", "min gap", "m", 1, "Smallest gap to the vehicle ahead").more(),
//! ];
//!
//! struct Gaps { seeds: usize }
//!
//! impl Study for Gaps {
//!     type Arguments = Arguments;
//!     type Record = Record;
//!     type Seen = ();
//!     const NAME: &'static str = "gaps";
//!
//!     fn plan(arguments: &Arguments, _: &RunOptions) -> Result<Self, Error> {
//!         Ok(Self { seeds: arguments.seeds })
//!     }
//!     fn runs(&self) -> usize {
//!         self.seeds
//!     }
//!     fn job(&self, run: usize) -> Result<Job, Error> {
//!         let seed = Some((run as i64 + 1).into());
//!         let options = ScenarioOptions { seed, ..ScenarioOptions::default() };
//!         Ok(Job::lockstep(supervise::open("following", &options)?))
//!     }
//!     fn record(&self, run: usize, _: &Job, result: Result<Done, Error>) -> Recorded<Self> {
//!         let min_gap_m = result?.summary.control.figures.min_gap_m;
//!         Ok((Record { seed: run + 1, min_gap_m }, ()))
//!     }
//!     fn judge(&self, found: Found<Self>) -> Result<Document, Error> {
//!         let rows: Vec<Record> = found.records.all()?.into_iter().map(|(_, record)| record).collect();
//!         let ok = rows.iter().all(|row| row.min_gap_m.is_none_or(|gap| gap > 2.0));
//!         let table = Table::new("Seeds", COLUMNS, &rows);
//!         let whole = serde_json::json!({"schema_version": 1, "ok": ok, "rows": rows});
//!         Ok(Document::new("gaps", "Gaps", &whole).verdict(ok, "smallest gaps above 2 m").table(table))
//!     }
//! }
//! assert!(Gaps { seeds: 2 }.job(1).is_ok());
//! ```

pub mod batch;
pub mod drives;
pub mod keep;
pub mod param;
pub mod parts;
mod study;

pub use batch::laws::DriveOptions;
pub use study::{
    Command, Crew, Entry, Found, MergeArguments, Needs, Recorded, ResumeArguments, RunOptions,
    Study, merge, resume, run,
};
