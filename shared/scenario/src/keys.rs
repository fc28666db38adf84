//! Tables that are read key by key: what has keys of its own in each of its kinds.
//!
//! A reader asks for the keys of its kind. What it did not ask for means nothing there, and the error
//! stands at that key. The same reader, run on [`Asked`](super::schema) keys, tells the schema which
//! keys there are; so the two cannot differ.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::accepted::accepted;
use super::placed::Placed;
use super::problem::Problem;

/// The keys of a table.
pub(super) trait Keys {
    /// The value of a key that may be left out.
    ///
    /// # Errors
    /// When the value is none of the type.
    fn optional<T: DeserializeOwned>(&mut self, key: &'static str) -> Result<Option<T>, Problem>;

    /// The value of a key that must be there.
    ///
    /// # Errors
    /// When it is not there, or its value is none of the type.
    fn required<T: DeserializeOwned>(&mut self, key: &'static str) -> Result<T, Problem>;

    /// The value of a key, or `default` where it is left out.
    ///
    /// # Errors
    /// When the value is none of the type.
    fn or<T: DeserializeOwned + Serialize>(
        &mut self,
        key: &'static str,
        default: T,
    ) -> Result<T, Problem>;

    /// Refuses the value of a key that was read, for what the other keys say.
    ///
    /// # Errors
    /// Where the values are a document's.
    fn refuse(&self, key: &str, message: &str, expected: String) -> Result<(), Problem>;
}

/// The keys of a table that was written down.
pub(super) struct Written<'a> {
    table: &'a Placed,
    path: String,
    /// What the table describes, for messages.
    what: String,
    asked: Vec<&'static str>,
}

impl<'a> Written<'a> {
    /// The keys of `table`, whose place in the document is `path`; `what` it describes.
    ///
    /// # Errors
    /// When it is no table.
    pub(super) fn new(table: &'a Placed, path: &str, what: &str) -> Result<Self, Problem> {
        if table.entries().is_none() {
            let message = format!("{what} is a table");
            return Err(Problem::new(path, message, "a table").at(table.place()));
        }
        Ok(Self { table, path: path.to_owned(), what: what.to_owned(), asked: Vec::new() })
    }

    /// Says more closely what the table describes.
    pub(super) fn describe(&mut self, what: String) {
        self.what = what;
    }

    /// Refuses the keys that were not asked for.
    ///
    /// # Errors
    /// The first of them.
    pub(super) fn finish(self) -> Result<(), Problem> {
        let mut entries = self.table.entries().into_iter().flatten();
        let Some((key, value)) = entries.find(|(key, _)| !self.asked.contains(&key.as_str()))
        else {
            return Ok(());
        };
        let problem = Problem::new(
            format!("{}.{key}", self.path),
            format!("`{key}` means nothing for {}", self.what),
            accepted(key, self.asked.iter().copied()),
        );
        Err(problem.at(value.key_place().unwrap_or_else(|| value.place())))
    }

    fn find(&self, key: &str) -> Option<&'a Placed> {
        self.table.get(key)
    }
}

impl Keys for Written<'_> {
    fn optional<T: DeserializeOwned>(&mut self, key: &'static str) -> Result<Option<T>, Problem> {
        self.asked.push(key);
        let Some(value) = self.find(key) else { return Ok(None) };
        T::deserialize(value).map(Some).map_err(|error| {
            let path = format!("{}.{key}", self.path);
            let problem = Problem::new(path, error.message(), error.expected());
            problem.at(error.place().cloned().unwrap_or_else(|| value.place()))
        })
    }

    fn required<T: DeserializeOwned>(&mut self, key: &'static str) -> Result<T, Problem> {
        let value = self.optional(key)?;
        value.ok_or_else(|| {
            let message = format!("{} needs `{key}`", self.what);
            Problem::new(&self.path, message, format!("`{key}`")).at(self.table.place())
        })
    }

    fn or<T: DeserializeOwned + Serialize>(
        &mut self,
        key: &'static str,
        default: T,
    ) -> Result<T, Problem> {
        self.optional(key).map(|value| value.unwrap_or(default))
    }

    fn refuse(&self, key: &str, message: &str, expected: String) -> Result<(), Problem> {
        let place = self.find(key).unwrap_or(self.table).place();
        Err(Problem::new(format!("{}.{key}", self.path), message, expected).at(place))
    }
}
