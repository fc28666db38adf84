//! The settings of a scenario, as a law reads them. Each key that was asked for is noted.
//!
//! A law is built from a [`Reader`] alone. So the descriptor shows which keys have an effect on it,
//! and no list of them is kept. `laws::check` refuses the others.

use crate::settings::{Settings, read};
use scenario::controller::Controller;
use scenario::{Problem, Reads, Scenario};
use std::cell::RefCell;

/// A scenario's settings for one law.
#[derive(Debug)]
pub struct Reader<'a> {
    /// The scenario, for what stands outside `[controller]`.
    pub scenario: &'a Scenario,
    reads: RefCell<Reads>,
}

/// Reads a key of `[controller]` by its path: `key!(reader, weights.q1)`.
#[macro_export]
macro_rules! key {
    ($reader:expr, $first:ident $(. $rest:ident)*) => {
        $reader.key(
            concat!(stringify!($first) $(, ".", stringify!($rest))*),
            |controller| controller.$first $(.$rest)*.clone(),
        )
    };
}

impl<'a> Reader<'a> {
    pub fn new(scenario: &'a Scenario) -> Self {
        let reads = RefCell::new(Reads::of(scenario.controller.name.as_str()));
        Self { scenario, reads }
    }

    /// A value of `[controller]`; `path` is relative to that table.
    pub fn key<T>(&self, path: &str, value: impl FnOnce(&Controller) -> T) -> T {
        self.reads.borrow_mut().key(path);
        value(&self.scenario.controller)
    }

    /// The law's own table, read and checked.
    ///
    /// # Errors
    /// The place of the first wrong key or value.
    pub fn table<T: Settings>(&self, name: &str) -> Result<T, Problem> {
        let settings: T = read(&self.scenario.controller, name)?;
        self.reads.borrow_mut().table(name);
        Ok(settings)
    }

    /// Takes back keys of a table that the chosen variant or the vehicle does not use.
    pub fn without(&self, table: &str, keys: &[&str]) {
        keys.iter().for_each(|key| self.reads.borrow_mut().without(format!("{table}.{key}")));
    }

    /// The law's own table, read and checked, for a formulation that uses these keys of it alone.
    ///
    /// # Errors
    /// The place of the first wrong key or value.
    pub fn part_of_table<T: Settings>(&self, name: &str, keys: &[&str]) -> Result<T, Problem> {
        let settings = read(&self.scenario.controller, name)?;
        keys.iter().for_each(|key| self.reads.borrow_mut().key(&format!("{name}.{key}")));
        Ok(settings)
    }

    /// Counts what a backup law has read as read for it alone.
    pub fn keep_backup(&self, backup: Self) {
        self.reads.borrow_mut().backup(backup.reads());
    }

    pub fn reads(self) -> Reads {
        self.reads.into_inner()
    }
}
