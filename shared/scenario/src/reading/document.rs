//! A scenario's keys with the overrides laid over them, and the place of each in its text.
//!
//! Reading needs values alone. An error needs a place: it is looked up in the texts by the key's path.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};
use toml::{Spanned, Table, Value};

use super::error::ScenarioError;
use super::foreign::Foreign;
use super::form::{self, below, child};
use super::overrides::{Overrides, Shown};
use super::problem::Problem;
use super::setting::spanned;

/// First line of a scenario that a run keeps.
pub(crate) const KEPT: &str = "# As it took effect: every key is written.\n";

/// Longest text of a scenario, bytes.
pub const MAX_TEXT_BYTES: usize = 1 << 20;

/// The keys of a file with their overrides.
pub(crate) struct Document<'a> {
    origin: Origin<'a>,
    overrides: &'a Overrides,
    pub(super) root: Table,
}

/// Origin of the keys that no option sets.
#[derive(Clone, Copy)]
pub(super) enum Origin<'a> {
    Text {
        source: &'a str,
        text: &'a str,
    },
    /// A file of another format.
    Foreign(&'a Foreign),
    /// A program.
    Values,
}

/// Place of a value, or of the nearest table above it.
struct Place {
    /// The option that set the value; none if the file did.
    option: Option<String>,
    /// Steps of the path that lead to it.
    steps: usize,
    key: Option<Range<usize>>,
    value: Range<usize>,
}

impl<'a> Document<'a> {
    /// Lays `overrides` over the keys of `origin`, in their order.
    pub(super) fn new(
        origin: Origin<'a>,
        root: Table,
        overrides: &'a Overrides,
    ) -> Result<Self, ScenarioError> {
        let root = overrides.laid_over(root)?;
        Ok(Self { origin, overrides, root })
    }

    /// Parses `text`; `source` stands for it in errors.
    pub(crate) fn parse(
        source: &'a str,
        text: &'a str,
        overrides: &'a Overrides,
    ) -> Result<Self, ScenarioError> {
        if text.len() > MAX_TEXT_BYTES {
            let message = format!("the text has {} bytes", text.len());
            return Err(ScenarioError::whole(source, message)
                .expecting(format!("at most {MAX_TEXT_BYTES} bytes")));
        }
        Self::new(Origin::Text { source, text }, Self::root_of(source, text)?, overrides)
    }

    pub(crate) fn root_of(source: &str, text: &str) -> Result<Table, ScenarioError> {
        toml::from_str(text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            let found = text.get(span.clone()).unwrap_or_default();
            // A number of too many digits fits no type.
            let (message, expected) = match error.message().split_once(", expected any valid") {
                Some(_) => (format!("invalid value: integer `{found}`"), "a smaller number"),
                None => (error.message().to_owned(), ""),
            };
            ScenarioError::at(source, text, span, &message).expecting(expected)
        })
    }

    /// Reads the document into a type that does not declare its keys.
    pub(crate) fn read<T: DeserializeOwned>(&self) -> Result<T, ScenarioError> {
        form::plain(Value::Table(self.root.clone()), "").map_err(|problem| self.error(&problem))
    }

    /// True if the key was written, in the text or on the command line.
    pub(crate) fn has(&self, path: &str) -> bool {
        let mut steps = path.split('.');
        let top = steps.next().and_then(|key| self.root.get(key));
        steps.fold(top, |value, step| child(value?, step)).is_some()
    }

    /// True if the key was set on the command line.
    pub(crate) fn is_set(&self, path: &str) -> bool {
        let steps: Vec<&str> = path.split('.').collect();
        self.has(path) && self.overrides.list.iter().any(|one| one.sets(&steps))
    }

    /// True if a run has kept the text.
    pub(crate) fn is_kept(&self) -> bool {
        matches!(self.origin, Origin::Text { text, .. } if text.starts_with(KEPT))
    }

    /// True if a written key may be meant for another choice than the present one. Built-in files and
    /// those of runs serve several choices. Or a key that chooses was set on the command line, and this
    /// one was not.
    pub(crate) fn is_for_another(&self, choosing: &[&str], path: &str) -> bool {
        let is_builtin =
            matches!(self.origin, Origin::Text { source, .. } if source.starts_with("built-in "));
        let serves_many = is_builtin || self.is_kept();
        let is_chosen_anew = serves_many || choosing.iter().any(|choosing| self.is_set(choosing));
        self.overrides.are_shared || (is_chosen_anew && !self.is_set(path))
    }

    /// Dotted paths of the values that were written below `table`, relative to it; a list is one value.
    pub(crate) fn written_below(&self, table: &str) -> Vec<String> {
        let mut paths = Vec::new();
        if let Some(Value::Table(found)) = self.root.get(table) {
            collect_paths(found, "", &mut paths);
        }
        paths
    }

    /// The error for a problem, at its key's value or at the nearest table above it that exists.
    pub(crate) fn error(&self, problem: &Problem) -> ScenarioError {
        let is_whole = |path: &str, place: &Place| place.steps == path.split('.').count();
        let (mut path, mut place) = (problem.path.as_str(), self.place(&problem.path));
        if let Some(other) = &problem.against {
            let instead = self.place(other);
            let is_better = instead.option.is_some() || !is_whole(path, &place);
            if is_whole(other, &instead) && is_better {
                (path, place) = (other, instead);
            }
        }
        let span = place.key.filter(|_| problem.is_of_key).unwrap_or(place.value);
        let error = match (&place.option, self.origin) {
            (Some(option), _) => ScenarioError::in_option(option, span, &problem.message),
            (None, Origin::Text { source, text }) => {
                ScenarioError::at(source, text, span, &problem.message)
            }
            (None, Origin::Foreign(keys)) => keys.error(path, &problem.message),
            (None, Origin::Values) => ScenarioError::whole("scenario", problem.message.as_str()),
        };
        error.expecting(problem.expected.as_str())
    }

    /// The place of a value. An option that sets it or a table around it replaces what stood there before.
    fn place(&self, path: &str) -> Place {
        let path: Vec<&str> = path.split('.').filter(|step| !step.is_empty()).collect();
        let (steps, key, value) = match self.origin {
            Origin::Text { text, .. } => DeTable::parse(text).map_or((0, None, 0..0), |root| {
                let span = root.span();
                follow(&Spanned::new(span, DeValue::Table(root.into_inner())), &path)
            }),
            Origin::Foreign(keys) => (keys.steps(&path), None, 0..0),
            Origin::Values => (0, None, 0..0),
        };
        let mut found = Place { option: None, steps, key, value };
        for option in &self.overrides.list {
            let names = option.path().iter().zip(&path);
            let common = names.take_while(|(name, step)| name == *step).count();
            let below = option.below(&path);
            if below.is_none() && common <= found.steps {
                continue;
            }
            let Shown { text, path: places, value_start } = option.shown();
            // An option that does not set the value made this table on its way.
            let at_key = places[..common].last().cloned().unwrap_or_default();
            let (mut steps, mut key, mut value) = (common, at_key.clone(), at_key);
            if let (Some(below), Ok(set)) = (below, spanned(&text[value_start..])) {
                let shifted = |span: Range<usize>| span.start + value_start..span.end + value_start;
                let (further, last, inside) = follow(&set, below);
                steps += further;
                (key, value) = (last.map_or(key, shifted), shifted(inside));
            }
            found = Place { option: Some(text), steps, key: Some(key), value };
        }
        found
    }
}

/// Follows a path as far as it leads: the number of steps, and the places of the last key and its value.
fn follow(
    value: &Spanned<DeValue<'_>>,
    path: &[&str],
) -> (usize, Option<Range<usize>>, Range<usize>) {
    let (mut value, mut key) = (value, None);
    for (steps, step) in path.iter().enumerate() {
        let next = match value.get_ref() {
            DeValue::Table(table) => table
                .iter()
                .find(|(name, _)| name.get_ref() == step)
                .map(|(name, below)| (Some(name.span()), below)),
            DeValue::Array(list) => {
                let element = step.parse::<usize>().ok().and_then(|index| list.get(index));
                element.map(|element| (None, element))
            }
            _ => None,
        };
        match next {
            Some(next) => (key, value) = next,
            None => return (steps, key, value.span()),
        }
    }
    (path.len(), key, value.span())
}

fn collect_paths(table: &Table, above: &str, into: &mut Vec<String>) {
    for (key, value) in table {
        let path = below(above, key);
        match value {
            Value::Table(table) => collect_paths(table, &path, into),
            _ => into.push(path),
        }
    }
}
