//! The tables below `[controller]` that belong to the laws.
//!
//! This crate does not depend on a law. It keeps each table as it was written, and the law reads it into a type of its
//! own. An error has the key's path, and is shown at the key as every other.

use std::collections::BTreeMap;

use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::form;
use super::problem::Problem;
use crate::schema::Schema;

/// Tables of `[controller]` that have a type in this crate.
const TYPED: [&str; 2] = ["weights", "curve_speed"];

/// The laws' tables of a scenario, by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(transparent)]
pub struct LawTables(BTreeMap<String, Table>);

impl LawTables {
    /// Names of the tables that were written.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.keys().map(String::as_str)
    }

    /// Reads a table into a type; one that was not written is an empty one.
    ///
    /// # Errors
    /// The place of a key or a value that the type does not accept.
    pub fn read<T: DeserializeOwned + Schema>(&self, name: &str) -> Result<T, Problem> {
        let table = self.0.get(name).cloned().unwrap_or_default();
        form::declared(Value::Table(table), &format!("controller.{name}"))
    }

    /// A complaint about the name of a table that was written.
    pub fn refuse(&self, name: &str, message: &str, expected: &str) -> Problem {
        Problem::new(format!("controller.{name}"), message, expected).of_key()
    }

    /// Takes the laws' tables out of the keys of a scenario.
    pub(super) fn take_from(root: &mut Table) -> Self {
        let mut tables = BTreeMap::new();
        if let Some(Value::Table(controller)) = root.get_mut("controller") {
            controller.retain(|name, value| match value {
                Value::Table(table) if !TYPED.contains(&name) => {
                    tables.insert(name.to_owned(), std::mem::take(table));
                    false
                }
                _ => true,
            });
        }
        Self(tables)
    }
}
