//! A scenario's keys with their positions, and the overrides laid over them.
//!
//! Positions of overridden values count on past the end of the document's own, one stretch per override.
//! So one error path serves both: a position leads back to the file's line or to the option.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::ScenarioError;
use super::foreign::ForeignKeys;
use super::overrides::{Override, Overrides};
use super::placed::{DeadEnd, Placed};
use super::problem::Problem;

/// First line of a scenario that a run keeps.
pub(super) const KEPT: &str = "# As it took effect: every key is written.\n";

/// Longest text of a scenario, bytes.
pub const MAX_TEXT_BYTES: usize = 1 << 20;

/// A parsed document with its overrides.
pub(super) struct Document<'a> {
    origin: Origin<'a>,
    options: Vec<(usize, &'a str)>,
    is_shared: bool,
    root: Placed,
}

/// Origin of the keys that no option sets.
#[derive(Clone, Copy)]
enum Origin<'a> {
    /// A text in TOML; positions count its bytes.
    Text { source: &'a str, text: &'a str },
    /// A file of another format; positions count its keys.
    Foreign(&'a ForeignKeys),
    /// Values from another process, without positions.
    Values,
}

impl Origin<'_> {
    /// Number of positions.
    fn len(self) -> usize {
        match self {
            Self::Text { text, .. } => text.len(),
            Self::Foreign(keys) => keys.len(),
            Self::Values => 0,
        }
    }
}

impl<'a> Document<'a> {
    /// Parses `text` and lays `overrides` over it, in their order.
    pub(super) fn parse(
        source: &'a str,
        text: &'a str,
        overrides: &'a Overrides,
    ) -> Result<Self, ScenarioError> {
        Self::of_parsed(source, text, Self::root_of(source, text)?, overrides)
    }

    /// The keys of a text.
    pub(super) fn root_of(source: &str, text: &str) -> Result<Placed, ScenarioError> {
        if text.len() > MAX_TEXT_BYTES {
            let message = format!("the text has {} bytes", text.len());
            return Err(ScenarioError::whole(source, message)
                .expecting(format!("at most {MAX_TEXT_BYTES} bytes")));
        }
        let root = DeTable::parse(text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            ScenarioError::at(source, text, span, error.message())
        })?;
        let root = Spanned::new(root.span(), DeValue::Table(root.into_inner()));
        Ok(Placed::of(&root, 0))
    }

    /// Lays `overrides` over the keys of a text that was parsed before.
    pub(super) fn of_parsed(
        source: &'a str,
        text: &'a str,
        root: Placed,
        overrides: &'a Overrides,
    ) -> Result<Self, ScenarioError> {
        Self::with(Origin::Text { source, text }, root, overrides)
    }

    /// Takes the keys of a file of another format, and lays `overrides` over them.
    pub(super) fn of_foreign(
        keys: &'a ForeignKeys,
        overrides: &'a Overrides,
    ) -> Result<Self, ScenarioError> {
        Self::with(Origin::Foreign(keys), keys.root(), overrides)
    }

    /// Takes the values that another process wrote.
    pub(super) fn of_values(root: Placed) -> Self {
        Self { origin: Origin::Values, options: Vec::new(), is_shared: false, root }
    }

    fn with(
        origin: Origin<'a>,
        root: Placed,
        overrides: &'a Overrides,
    ) -> Result<Self, ScenarioError> {
        let is_shared = overrides.are_shared();
        let mut document = Self { origin, options: Vec::new(), is_shared, root };
        let mut base = origin.len() + 1;
        for option in overrides.iter() {
            document.lay_over(option, base)?;
            document.options.push((base, option.option()));
            base += option.option().len() + 1;
        }
        Ok(document)
    }

    /// Reads the document into a type; what `take` takes out of it comes apart. `place_of` gives the place of a key
    /// that stands in a wrong table.
    pub(super) fn read<T: DeserializeOwned, A>(
        &self,
        take: impl FnOnce(&mut Placed) -> A,
        place_of: impl Fn(&str) -> Option<String>,
    ) -> Result<(T, A), ScenarioError> {
        let mut root = self.root.clone();
        let apart = take(&mut root);
        T::deserialize(&root).map(|value| (value, apart)).map_err(|refusal| {
            let place = refusal.place().cloned().unwrap_or(root.place());
            let elsewhere = refusal.stray().and_then(place_of);
            let hint =
                elsewhere.map_or_else(String::new, |path| format!(" (did you mean `{path}`?)"));
            let expected = refusal.expected().to_owned() + &hint;
            self.error(place, refusal.message()).expecting(expected)
        })
    }

    /// The integer at the top level with this key.
    pub(super) fn integer(&self, key: &str) -> Option<i64> {
        self.root.get(key)?.as_integer()
    }

    /// The error for a problem, at its key's value or at the nearest table above it that exists.
    pub(super) fn problem(&self, problem: &Problem) -> ScenarioError {
        if let Some(place) = problem.place() {
            let error = self.error(place.clone(), &problem.message);
            return error.expecting(problem.expected.as_str());
        }
        let (nearest, written) = self.locate(&problem.path);
        let other = problem.against.as_deref().map(|path| self.locate(path));
        let span = match other {
            Some((span, true)) if !written || span.start > self.origin.len() => span,
            _ => nearest,
        };
        self.error(span, &problem.message).expecting(problem.expected.as_str())
    }

    fn error(&self, span: Range<usize>, message: &str) -> ScenarioError {
        let option = self.options.iter().rev().find(|(base, _)| *base <= span.start);
        match (option, self.origin) {
            (Some(&(base, option)), _) => {
                let span = span.start - base..span.end.saturating_sub(base);
                ScenarioError::in_option(option, span, message)
            }
            (None, Origin::Text { source, text }) => ScenarioError::at(source, text, span, message),
            (None, Origin::Foreign(keys)) => keys.error(span.start, message),
            (None, Origin::Values) => ScenarioError::whole("scenario", message),
        }
    }

    /// True if the key was written, in the text or on the command line.
    pub(super) fn has(&self, path: &str) -> bool {
        self.locate(path).1
    }

    /// True if the key was set on the command line.
    pub(super) fn is_set(&self, path: &str) -> bool {
        let (span, written) = self.locate(path);
        written && span.start > self.origin.len()
    }

    /// True if a run has kept the text.
    pub(super) fn is_kept(&self) -> bool {
        matches!(self.origin, Origin::Text { text, .. } if text.starts_with(KEPT))
    }

    /// True if a written key may be meant for another choice than the present one. Built-in files and
    /// those of runs serve several choices. Or a key that chooses was set on the command line, and this
    /// one was not.
    pub(super) fn is_for_another(&self, choosing: &[&str], path: &str) -> bool {
        let is_builtin =
            matches!(self.origin, Origin::Text { source, .. } if source.starts_with("built-in "));
        let serves_many = is_builtin || self.is_kept();
        let is_chosen_anew = serves_many || choosing.iter().any(|choosing| self.is_set(choosing));
        self.is_shared || (is_chosen_anew && !self.is_set(path))
    }

    /// Dotted paths of the values that were written below `table`; an array is one value.
    pub(super) fn written_below(&self, table: &str) -> Vec<String> {
        let mut paths = Vec::new();
        if let Some(found) = self.root.get(table) {
            found.collect_paths(table, &mut paths);
        }
        paths
    }

    /// The place of the key's value, or of the nearest table above it, and whether it is the former.
    fn locate(&self, path: &str) -> (Range<usize>, bool) {
        let mut value = &self.root;
        for segment in path.split('.') {
            let Some(next) = value.get(segment) else { return (value.place(), false) };
            value = next;
        }
        (value.place(), true)
    }

    fn lay_over(&mut self, option: &'a Override, base: usize) -> Result<(), ScenarioError> {
        let value = Placed::of(&option.value()?, base + option.value_start());
        match option.path() {
            path @ [_, _, _, (kind, _), ..] => self.make_way_for_profile(path, kind),
            path @ [_, _, _] => {
                let kinds = value.entries().into_iter().flatten();
                kinds.for_each(|(kind, _)| self.make_way_for_profile(path, kind));
            }
            _ => {}
        }
        self.root.set(option.path(), value, base).map_err(|DeadEnd { span, message, expected }| {
            ScenarioError::in_option(option.option(), span, &message).expecting(expected)
        })
    }

    /// An actor has one profile. One that an option sets replaces the file's, and a table of speeds replaces the
    /// initial speed with it.
    fn make_way_for_profile(&mut self, path: &[(String, Range<usize>)], kind: &str) {
        let [(actors, _), (index, _), (key, _), ..] = path else { return };
        if (actors.as_str(), key.as_str()) != ("actors", "profile") {
            return;
        }
        let actors = self.root.get_mut("actors").filter(|actors| actors.elements().is_some());
        let Some(actor) = actors.and_then(|actors| actors.get_mut(index)) else { return };
        if let Some(profile) = actor.get_mut("profile") {
            profile.retain(|key| key == kind);
        }
        if matches!(kind, "cycle" | "speeds" | "csv") {
            actor.retain(|key| key != "initial_speed_mps");
        }
    }
}
