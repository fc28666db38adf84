//! The tables below `[controller]` that belong to the laws.
//!
//! This crate does not depend on a law. It keeps each table as it was written, with the positions of its keys. The law
//! reads the table into a type of its own. A fault is then shown at the key, as for every other.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Serialize, Serializer};

use super::placed::Placed;
use super::problem::Problem;

/// Tables of `[controller]` that have a type in this crate.
const TYPED: [&str; 2] = ["weights", "curve_speed"];

/// The laws' tables of a scenario, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LawTables(BTreeMap<String, Placed>);

impl Serialize for LawTables {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, table)| (name, table.plain())))
    }
}

impl LawTables {
    /// Names of the tables that were written.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// Reads a table into a type; one that was not written is an empty one.
    ///
    /// # Errors
    /// The place of a key or a value that the type does not accept.
    pub fn read<T: DeserializeOwned>(&self, name: &str) -> Result<T, Problem> {
        let empty = Placed::empty(0..0);
        let table = self.0.get(name).unwrap_or(&empty);
        T::deserialize(table).map_err(|error| {
            let path = format!("controller.{name}");
            let problem = Problem::new(path, error.message(), error.expected());
            problem.at(error.place().cloned().unwrap_or_else(|| table.place()))
        })
    }

    /// A complaint about the name of a table that was written.
    #[must_use]
    pub fn refuse(&self, name: &str, message: &str, expected: &str) -> Problem {
        let problem = Problem::new(format!("controller.{name}"), message, expected);
        match self.0.get(name).and_then(Placed::key_place) {
            Some(place) => problem.at(place),
            None => problem,
        }
    }

    /// Takes the laws' tables out of the `controller` table of a document.
    pub(super) fn take_from(root: &mut Placed) -> Self {
        let mut tables = BTreeMap::new();
        if let Some(controller) = root.get_mut("controller") {
            let is_of_a_law = |(name, value): &(&String, &Placed)| {
                value.entries().is_some() && !TYPED.contains(&name.as_str())
            };
            let written = controller.entries().into_iter().flatten();
            let names: Vec<_> = written.filter(is_of_a_law).map(|(name, _)| name.clone()).collect();
            for name in names {
                tables.extend(controller.remove(&name).map(|table| (name, table)));
            }
        }
        Self(tables)
    }
}
