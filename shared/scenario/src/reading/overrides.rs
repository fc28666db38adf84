//! Keys of a scenario set from the command line.

use std::borrow::Cow;
use std::ops::Range;

use serde::Deserialize;
use toml::de::{DeValue, ValueDeserializer};
use toml::{Spanned, Table, Value};

use super::error::ScenarioError;

/// Most segments of an overridden key's path.
const MAX_SEGMENTS: usize = 16;

/// Keys to be set over a scenario file's own, in order: a later one wins.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    list: Vec<Override>,
    are_shared: bool,
}

/// One key and its value, as given in an option of the command line.
#[derive(Clone, Debug)]
pub(super) struct Override {
    /// The option as a person would type it: `--set plant.period_ms=5`, `--seed 7`.
    option: String,
    /// Names of the keys from the top, with their place in `option`.
    path: Vec<(String, Range<usize>)>,
    /// Start of the value in `option`; it ends with the option.
    value_start: usize,
}

impl Overrides {
    /// No override.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds the argument of a `--set`: `dotted.path=VALUE`, array elements by their index
    /// (`actors.0.gap_m=30` or `actors[0].gap_m=30`). VALUE is a TOML value; a plain word needs no
    /// quotes. A profile of an actor replaces the one from the file. It also replaces the initial
    /// speed if the new profile is a table of speeds.
    ///
    /// # Errors
    /// When the argument has no `=` or its path is not one. The value is read with the scenario.
    pub fn set(&mut self, argument: &str) -> Result<(), ScenarioError> {
        self.set_by("--set", argument)
    }

    /// Adds the same kind of argument on behalf of another option, which errors name.
    ///
    /// # Errors
    /// As for [`Overrides::set`].
    pub fn set_by(&mut self, option: &str, argument: &str) -> Result<(), ScenarioError> {
        let start = option.len() + 1;
        let option = format!("{option} {argument}");
        let Some(equals) = argument.find('=') else {
            return Err(ScenarioError::in_option(&option, start..option.len(), "no `=`")
                .expecting("KEY=VALUE, for example plant.period_ms=5"));
        };
        let mut path = Vec::new();
        let mut at = start;
        for segment in argument[..equals].split(['.', '[']) {
            let span = at..at + segment.len();
            at = span.end + 1;
            let opened = option[..span.start].ends_with('[');
            let inner = segment.strip_suffix(']');
            let name = inner.unwrap_or(segment).trim();
            let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            let is_key = !name.is_empty() && name.chars().all(bare);
            if !is_key || opened != inner.is_some() || path.len() == MAX_SEGMENTS {
                let message = format!("`{name}` cannot be a key of a scenario");
                return Err(ScenarioError::in_option(&option, span, &message)
                    .expecting("names joined by dots, for example actors.0.gap_m"));
            }
            path.push((name.to_owned(), span));
        }
        self.list.push(Override { option, path, value_start: start + equals + 1 });
        Ok(())
    }

    /// Adds an option of its own that stands for a key, such as `--seed 7` for `seed`. Errors name
    /// the option.
    pub fn option(&mut self, option: &str, path: &str, value: &str) {
        let value_start = option.len() + 1;
        let option = format!("{option} {value}");
        let path = path.split('.').map(|name| (name.to_owned(), 0..value_start - 1)).collect();
        self.list.push(Override { option, path, value_start });
    }

    /// The same for a file that is run with several laws. A key that one of them does not read is
    /// noted, not refused.
    #[must_use]
    pub fn shared(self) -> Self {
        Self { are_shared: true, ..self }
    }

    pub(super) fn are_shared(&self) -> bool {
        self.are_shared
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Override> {
        self.list.iter()
    }

    /// The keys of a file with these laid over them.
    pub(super) fn laid_over(&self, root: Table) -> Result<Table, ScenarioError> {
        let mut root = Value::Table(root);
        self.list.iter().try_for_each(|option| option.lay_over(&mut root))?;
        match root {
            Value::Table(root) => Ok(root),
            other => unreachable!("a table stays one: {other:?}"),
        }
    }
}

impl Override {
    pub(super) fn option(&self) -> &str {
        &self.option
    }

    pub(super) fn path(&self) -> &[(String, Range<usize>)] {
        &self.path
    }

    /// The rest of a path to a value that this option sets or is part of what it sets.
    pub(super) fn below<'p>(&self, path: &'p [&'p str]) -> Option<&'p [&'p str]> {
        let (above, below) = path.split_at_checked(self.path.len())?;
        self.path.iter().zip(above).all(|((name, _), step)| name == step).then_some(below)
    }

    pub(super) fn value_start(&self) -> usize {
        self.value_start
    }

    /// The value with places from its own start. A plain word is a text.
    pub(super) fn spanned(&self) -> Result<Spanned<DeValue<'_>>, toml::de::Error> {
        let text = &self.option[self.value_start..];
        let word = || Spanned::new(0..text.len(), DeValue::String(Cow::from(text)));
        DeValue::parse(text).or_else(|error| is_plain_word(text).then(word).ok_or(error))
    }

    fn value(&self) -> Result<Value, ScenarioError> {
        let read = |value| Value::deserialize(ValueDeserializer::from(value));
        self.spanned().and_then(read).map_err(|error| {
            let text = &self.option[self.value_start..];
            if let Some(number) = number_with_unit(text) {
                let message = format!("`{text}` is not a number: the key's name has the unit");
                let span = self.value_start..self.option.len();
                return ScenarioError::in_option(&self.option, span, &message)
                    .expecting(format!("a number alone, such as {number}"));
            }
            let span = error.span().unwrap_or(0..text.len());
            let span = self.value_start + span.start..self.value_start + span.end;
            ScenarioError::in_option(&self.option, span, error.message())
        })
    }

    /// Sets the value at its path, and makes the tables on the way that do not exist.
    fn lay_over(&self, root: &mut Value) -> Result<(), ScenarioError> {
        let value = self.value()?;
        self.make_way_for_profile(root, &value);
        let refuse = |span: &Range<usize>, message: String, expected: String| {
            ScenarioError::in_option(&self.option, span.clone(), &message).expecting(expected)
        };
        let (mut place, mut holder) = (root, &self.path[0]);
        for step @ (name, span) in &self.path {
            let kind = place.type_str();
            place = match place {
                Value::Table(table) => {
                    table.entry(name.clone()).or_insert_with(|| Value::Table(Table::new()))
                }
                Value::Array(list) => {
                    let length = list.len();
                    let element = name.parse().ok().and_then(|index: usize| list.get_mut(index));
                    element.ok_or_else(|| {
                        let expected = match length {
                            0 => "a value for the whole array".to_owned(),
                            _ => format!("an index from 0 to {}", length - 1),
                        };
                        let message = format!("no element `{name}` in an array of {length}");
                        refuse(span, message, expected)
                    })?
                }
                _ => {
                    let (name, span) = holder;
                    let message = format!("`{name}` holds a value ({kind}), so it has no keys");
                    return Err(refuse(span, message, "a table on the way to the key".to_owned()));
                }
            };
            holder = step;
        }
        *place = value;
        Ok(())
    }

    /// An actor has one profile. One that an option sets replaces the file's, and a table of speeds replaces the
    /// initial speed with it.
    fn make_way_for_profile(&self, root: &mut Value, value: &Value) {
        let names: Vec<&str> = self.path.iter().map(|(name, _)| name.as_str()).collect();
        let ["actors", index, "profile", below @ ..] = names.as_slice() else { return };
        let kinds = match (below.first(), value) {
            (Some(kind), _) => vec![*kind],
            (None, Value::Table(table)) => table.keys().map(String::as_str).collect(),
            (None, _) => Vec::new(),
        };
        let actors = root.get_mut("actors").and_then(Value::as_array_mut);
        let actor = index.parse().ok().and_then(|index: usize| actors?.get_mut(index));
        let Some(actor) = actor.and_then(Value::as_table_mut) else { return };
        for kind in kinds {
            if let Some(Value::Table(profile)) = actor.get_mut("profile") {
                profile.retain(|key, _| key == kind);
            }
            if matches!(kind, "cycle" | "speeds" | "csv") {
                actor.remove("initial_speed_mps");
            }
        }
    }
}

/// The number of a text such as `30s` or `20 m/s`, which has a unit behind it.
fn number_with_unit(text: &str) -> Option<&str> {
    let number = text.trim_end_matches(|c: char| !c.is_ascii_digit() && c != '.');
    let unit = text[number.len()..].trim();
    let of_unit = |c: char| c.is_alphanumeric() || matches!(c, '/' | '^' | '²' | '³' | '%');
    let is_unit = unit.starts_with(char::is_alphabetic) && unit.chars().all(of_unit);
    (is_unit && number.parse::<f64>().is_ok()).then_some(number)
}

/// A text that can only be meant as a string: it starts like a word or a path.
fn is_plain_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || matches!(c, '_' | '.' | '/'))
        && !text.contains(|c: char| c.is_control())
}
