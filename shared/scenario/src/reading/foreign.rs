//! Keys of a scenario that come from a file of another format, each with its place there.

use toml::{Table, Value};

use super::error::ScenarioError;
use super::form::child;

/// Keys of a scenario as a value, with the places in a file that they come from. All other keys have their defaults.
#[derive(Clone, Debug)]
pub(crate) struct Foreign {
    file: String,
    pub(super) table: Table,
    places: Vec<Place>,
}

/// Origin of a key: its path, the place in the file, and what stands there.
#[derive(Clone, Debug)]
struct Place {
    path: String,
    place: String,
    what: String,
}

impl Foreign {
    /// The keys of `file`, which errors name.
    pub(crate) fn new(file: &str, table: Table) -> Self {
        Self { file: file.to_owned(), table, places: Vec::new() }
    }

    /// Notes that the key at `path`, with what is below it, comes from `place`, such as `drive.xml:12`, where `what`
    /// stands.
    pub(crate) fn come_from(&mut self, path: impl Into<String>, place: &str, what: &str) {
        let (path, place, what) = (path.into(), place.to_owned(), what.to_owned());
        self.places.push(Place { path, place, what });
    }

    /// The number of steps of a path that lead to a value.
    pub(super) fn steps(&self, path: &[&str]) -> usize {
        (1..=path.len()).take_while(|&steps| self.value(&path[..steps]).is_some()).count()
    }

    fn value(&self, path: &[&str]) -> Option<&Value> {
        let top = self.table.get(*path.first()?);
        path[1..].iter().fold(top, |value, step| child(value?, step))
    }

    /// The error about the value at `path`.
    pub(super) fn error(&self, path: &str, message: &str) -> ScenarioError {
        let holds = |place: &&Place| {
            let rest = path.strip_prefix(place.path.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let own = self.places.iter().filter(holds).max_by_key(|place| place.path.len());
        let keys = [Some(path), own.map(|own| own.path.as_str())];
        let found = keys.into_iter().flatten().find_map(|key| {
            let steps: Vec<&str> = key.split('.').collect();
            Some((*steps.last()?, self.value(&steps)?))
        });
        let Some((name, value)) = found else {
            let message = format!("the file makes a scenario: {message}");
            return ScenarioError::whole(&self.file, message);
        };
        let (place, what) =
            own.map_or((self.file.as_str(), "the file"), |own| (&own.place, &own.what));
        let message = format!("{what} makes a scenario with {name} = {value}: {message}");
        ScenarioError::whole(place, message)
    }
}
