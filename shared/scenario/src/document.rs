//! A scenario's text as a TOML document with positions, and the overrides laid over it.
//!
//! Positions of overridden values count on past the end of the text, one stretch per override, so
//! that one error path serves both: a position leads back to the file's line or to the option.

use std::borrow::Cow;
use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::ScenarioError;
use super::overrides::{Override, Overrides};
use super::placed::Placed;
use super::problem::Problem;

/// First line of a scenario that a run keeps.
pub(super) const KEPT: &str = "# As it took effect: every key is written.\n";

/// Longest text of a scenario, bytes.
pub const MAX_TEXT_BYTES: usize = 1 << 20;

/// A parsed document with its overrides.
pub(super) struct Document<'a> {
    source: &'a str,
    text: &'a str,
    options: Vec<(usize, &'a str)>,
    is_shared: bool,
    root: Spanned<DeTable<'a>>,
}

impl<'a> Document<'a> {
    /// Parses `text` and lays `overrides` over it, in their order.
    pub(super) fn parse(
        source: &'a str,
        text: &'a str,
        overrides: &'a Overrides,
    ) -> Result<Self, ScenarioError> {
        if text.len() > MAX_TEXT_BYTES {
            let message = format!("the text has {} bytes", text.len());
            return Err(ScenarioError::whole(source, message)
                .expecting(format!("at most {MAX_TEXT_BYTES} bytes")));
        }
        let root = DeTable::parse(text).map_err(|error| {
            let span = error.span().unwrap_or(0..0);
            ScenarioError::at(source, text, span, error.message())
        })?;
        let is_shared = overrides.are_shared();
        let mut document = Self { source, text, options: Vec::new(), is_shared, root };
        let mut base = text.len() + 1;
        for option in overrides.iter() {
            document.lay_over(option, base)?;
            document.options.push((base, option.option()));
            base += option.option().len() + 1;
        }
        Ok(document)
    }

    /// Reads the document into a type; what `take` takes out of it comes apart.
    pub(super) fn read<T: DeserializeOwned, A>(
        &self,
        take: impl FnOnce(&mut DeTable<'_>) -> A,
    ) -> Result<(T, A), ScenarioError> {
        let mut root = self.root.clone();
        let apart = take(root.get_mut());
        let span = root.span();
        let root = Placed::of(&Spanned::new(span.clone(), DeValue::Table(root.into_inner())));
        T::deserialize(&root).map(|value| (value, apart)).map_err(|refusal| {
            let place = refusal.place().cloned().unwrap_or(span);
            self.error(place, refusal.message()).expecting(refusal.expected())
        })
    }

    /// The text of an integer at the top level, when there is one.
    pub(super) fn integer(&self, key: &str) -> Option<&str> {
        Some(self.root.get_ref().get(key)?.get_ref().as_integer()?.as_str())
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
            Some((span, true)) if !written || span.start > self.text.len() => span,
            _ => nearest,
        };
        self.error(span, &problem.message).expecting(problem.expected.as_str())
    }

    fn error(&self, span: Range<usize>, message: &str) -> ScenarioError {
        let option = self.options.iter().rev().find(|(base, _)| *base <= span.start);
        match option {
            Some(&(base, option)) => {
                let span = span.start - base..span.end.saturating_sub(base);
                ScenarioError::in_option(option, span, message)
            }
            None => ScenarioError::at(self.source, self.text, span, message),
        }
    }

    /// Whether the key was written, in the text or on the command line.
    pub(super) fn has(&self, path: &str) -> bool {
        self.locate(path).1
    }

    /// Whether the key was set on the command line.
    pub(super) fn is_set(&self, path: &str) -> bool {
        let (span, written) = self.locate(path);
        written && span.start > self.text.len()
    }

    /// Whether a run has kept the text.
    pub(super) fn is_kept(&self) -> bool {
        self.text.starts_with(KEPT)
    }

    /// Whether a written key may be meant for another choice than the present one: the file serves
    /// several, as built-in ones and those of runs do, or a key that chooses was set on the command line and this one was not.
    pub(super) fn is_for_another(&self, choosing: &[&str], path: &str) -> bool {
        let serves_many = self.source.starts_with("built-in ") || self.is_kept();
        let is_chosen_anew = serves_many || choosing.iter().any(|choosing| self.is_set(choosing));
        self.is_shared || (is_chosen_anew && !self.is_set(path))
    }

    /// Dotted paths of the values that were written below `table`; an array is one value.
    pub(super) fn written_below(&self, table: &str) -> Vec<String> {
        fn collect(path: &str, table: &DeTable<'_>, into: &mut Vec<String>) {
            for (key, value) in table.iter() {
                let path = format!("{path}.{}", key.get_ref());
                match value.get_ref() {
                    DeValue::Table(table) => collect(&path, table, into),
                    _ => into.push(path),
                }
            }
        }
        let mut paths = Vec::new();
        if let Some(DeValue::Table(found)) = self.root.get_ref().get(table).map(Spanned::get_ref) {
            collect(table, found, &mut paths);
        }
        paths
    }

    /// The place of the key's value, or of the nearest table above it, and which of the two it is.
    fn locate(&self, path: &str) -> (Range<usize>, bool) {
        let mut span = self.root.span();
        let mut value: Option<&DeValue<'_>> = None;
        for segment in path.split('.') {
            let next = match value {
                None => self.root.get_ref().get(segment),
                Some(DeValue::Table(table)) => table.get(segment),
                Some(DeValue::Array(array)) => {
                    segment.parse().ok().and_then(|i: usize| array.get(i))
                }
                Some(_) => None,
            };
            let Some(next) = next else { return (span, false) };
            span = next.span();
            value = Some(next.get_ref());
        }
        (span, true)
    }

    fn lay_over(&mut self, option: &'a Override, base: usize) -> Result<(), ScenarioError> {
        let mut value = option.value()?;
        match (option.path(), value.get_ref()) {
            (path @ [_, _, _, (kind, _), ..], _) => self.make_way_for_profile(path, kind),
            (path @ [_, _, _], DeValue::Table(table)) => {
                table.keys().for_each(|kind| self.make_way_for_profile(path, kind.get_ref()));
            }
            _ => {}
        }
        shift(&mut value, base + option.value_start());
        set_in_table(self.root.get_mut(), option.path(), value, base).map_err(
            |(span, message, expected)| {
                ScenarioError::in_option(option.option(), span, &message).expecting(expected)
            },
        )
    }

    /// An actor has one profile: one that an option sets replaces the file's, and a table of speeds
    /// the initial speed with it.
    fn make_way_for_profile(&mut self, path: &Path, kind: &str) {
        let [(actors, _), (index, _), (key, _), ..] = path else { return };
        if (actors.as_str(), key.as_str()) != ("actors", "profile") {
            return;
        }
        let actors = self.root.get_mut().get_mut("actors").map(Spanned::get_mut);
        let Some(DeValue::Array(actors)) = actors else { return };
        let actor = index.parse().ok().and_then(|index: usize| actors.get_mut(index));
        let Some(DeValue::Table(actor)) = actor.map(Spanned::get_mut) else { return };
        let profile = actor.get_mut("profile").map(Spanned::get_mut);
        if let Some(DeValue::Table(profile)) = profile {
            let keys = std::mem::take(profile).into_iter();
            for (key, value) in keys.filter(|(key, _)| key.get_ref() == kind) {
                profile.insert(key, value);
            }
        }
        if matches!(kind, "cycle" | "speeds" | "csv") {
            actor.remove("initial_speed_mps");
        }
    }
}

/// Names of keys with their places in the option.
type Path = [(String, Range<usize>)];
/// Why a path leads nowhere: place in the option, message, expectation.
type DeadEnd = (Range<usize>, String, String);

/// Puts `new` at `path`, making the tables on the way that do not exist.
fn set_in_table<'a>(
    table: &mut DeTable<'a>,
    path: &'a Path,
    new: Spanned<DeValue<'a>>,
    base: usize,
) -> Result<(), DeadEnd> {
    let [(name, span), rest @ ..] = path else { return Ok(()) };
    let key = || Spanned::new(base + span.start..base + span.end, Cow::from(name.as_str()));
    if rest.is_empty() {
        table.insert(key(), new);
        return Ok(());
    }
    if !table.contains_key(name.as_str()) {
        table.insert(key(), Spanned::new(key().span(), DeValue::Table(DeTable::new())));
    }
    let below = table.get_mut(name.as_str()).expect("the key was there or has been put there");
    set_below(below, (name, span), rest, new, base)
}

/// Puts `new` at `path` inside the value that `name` holds.
fn set_below<'a>(
    value: &mut Spanned<DeValue<'a>>,
    (name, span): (&str, &Range<usize>),
    path: &'a Path,
    new: Spanned<DeValue<'a>>,
    base: usize,
) -> Result<(), DeadEnd> {
    let [(index, index_span), rest @ ..] = path else {
        *value = new;
        return Ok(());
    };
    let kind = value.get_ref().type_str();
    match value.get_mut() {
        DeValue::Table(table) => set_in_table(table, path, new, base),
        DeValue::Array(array) => {
            let length = array.len();
            match index.parse().ok().and_then(|i: usize| array.get_mut(i)) {
                Some(element) => set_below(element, (index, index_span), rest, new, base),
                None => Err((
                    index_span.clone(),
                    format!("no element `{index}` in an array of {length}"),
                    match length {
                        0 => "a value for the whole array".to_owned(),
                        _ => format!("an index from 0 to {}", length - 1),
                    },
                )),
            }
        }
        _ => Err((
            span.clone(),
            format!("`{name}` holds a value ({kind}), so it has no keys"),
            "a table on the way to the key".to_owned(),
        )),
    }
}

/// Moves all positions of a value by `by`.
fn shift(value: &mut Spanned<DeValue<'_>>, by: usize) {
    let span = value.span();
    let mut inner = std::mem::replace(value.get_mut(), DeValue::Boolean(false));
    match &mut inner {
        DeValue::Array(array) => array.iter_mut().for_each(|element| shift(element, by)),
        DeValue::Table(table) => {
            let entries = std::mem::take(table);
            for (key, mut value) in entries {
                shift(&mut value, by);
                let span = key.span();
                table.insert(Spanned::new(span.start + by..span.end + by, key.into_inner()), value);
            }
        }
        _ => {}
    }
    *value = Spanned::new(span.start + by..span.end + by, inner);
}
