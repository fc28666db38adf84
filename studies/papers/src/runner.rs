//! Pieces of a paper, and the runner that drives their scenarios.

use std::cell::Cell;
use std::sync::Arc;

use frame::Crew;
use frame::batch::{self, Job};
use supervise::Error;

use super::Pictures;
pub use super::driven::Driven;
use super::driven::open;
use super::row::Row;

/// Result of a piece.
#[derive(Default)]
pub struct Part {
    pub rows: Vec<Row>,
    pub pictures: Pictures,
}

impl Part {
    /// A result without pictures.
    pub fn of_rows(rows: Vec<Row>) -> Self {
        Self { rows, ..Self::default() }
    }
}

type Reproduce = dyn Fn(&Runner<'_>) -> Result<Part, Error> + Send + Sync;

/// Rows of a paper that wait for no other piece: a few drives, one after another.
#[derive(Clone)]
pub struct Piece {
    /// Its name among those of the paper.
    pub name: String,
    reproduce: Arc<Reproduce>,
}

impl Piece {
    /// A piece with its work.
    pub fn new(
        name: impl Into<String>,
        reproduce: impl Fn(&Runner<'_>) -> Result<Part, Error> + Send + Sync + 'static,
    ) -> Self {
        Self { name: name.into(), reproduce: Arc::new(reproduce) }
    }

    /// Drives its scenarios and compares.
    pub fn reproduce(&self, runner: &Runner<'_>) -> Result<Part, Error> {
        (self.reproduce)(runner)
    }
}

/// The keys of a piece's drive: its number in the piece, and the keys that it sets.
pub fn keys(paper: &str, piece: &str, drive: usize, set: &[&str]) -> Vec<(String, String)> {
    let keys = [
        ("paper", paper.to_owned()),
        ("piece", piece.to_owned()),
        ("drive", drive.to_string()),
        ("set", set.join(" ")),
    ];
    keys.map(|(name, value)| (name.to_owned(), value)).to_vec()
}

/// The drives of one piece.
pub struct Runner<'a> {
    crew: &'a Crew<'a>,
    run: usize,
    /// The paper, and the piece of it.
    names: (&'a str, &'a str),
    drives: Cell<usize>,
    /// Standard deviation of the skilled driver's aimed speed, m/s.
    pub driver_spread_mps: f64,
}

impl<'a> Runner<'a> {
    /// A runner for the piece that is run number `run`.
    pub fn new(
        crew: &'a Crew<'a>,
        run: usize,
        names: (&'a str, &'a str),
        driver_spread_mps: f64,
    ) -> Self {
        Self { crew, run, names, drives: Cell::default(), driver_spread_mps }
    }

    /// Drives a built-in scenario with these keys set.
    pub fn drive(&self, name: &str, keys: &[&str]) -> Result<Driven, Error> {
        let job = Job::lockstep(open(name, keys)?);
        let done = self.crew.drive(self.run, &job)?;
        let scenario = job.scenario;
        batch::whole(&done.summary)?;
        self.drives.set(self.drives.get() + 1);
        let (paper, piece) = self.names;
        let keys = self::keys(paper, piece, self.drives.get(), keys);
        self.crew.observe(self.run, &keys, &scenario, &done);
        Ok(Driven::of(scenario, done))
    }
}
