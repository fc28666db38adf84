//! Keys of a scenario set from the command line.

use std::borrow::Cow;
use std::ops::Range;

use toml::Spanned;
use toml::de::DeValue;

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
}

impl Override {
    pub(super) fn option(&self) -> &str {
        &self.option
    }

    pub(super) fn path(&self) -> &[(String, Range<usize>)] {
        &self.path
    }

    pub(super) fn value_start(&self) -> usize {
        self.value_start
    }

    /// The value, with positions from its own start.
    pub(super) fn value(&self) -> Result<Spanned<DeValue<'_>>, ScenarioError> {
        let text = &self.option[self.value_start..];
        match DeValue::parse(text) {
            Ok(value) => Ok(value),
            Err(_) if is_plain_word(text) => {
                Ok(Spanned::new(0..text.len(), DeValue::String(Cow::from(text))))
            }
            Err(_) if number_with_unit(text) => {
                let span = self.value_start..self.option.len();
                let number = text.trim_end_matches(|c: char| !c.is_ascii_digit() && c != '.');
                let message = format!("`{text}` is not a number: the key's name has the unit");
                Err(ScenarioError::in_option(&self.option, span, &message)
                    .expecting(format!("a number alone, such as {number}")))
            }
            Err(error) => {
                let span = error.span().unwrap_or(0..text.len());
                let span = self.value_start + span.start..self.value_start + span.end;
                Err(ScenarioError::in_option(&self.option, span, error.message()))
            }
        }
    }
}

/// A number with a unit behind it, such as `30s` or `20 m/s`.
fn number_with_unit(text: &str) -> bool {
    let number = text.trim_end_matches(|c: char| !c.is_ascii_digit() && c != '.');
    let unit = text[number.len()..].trim();
    number.parse::<f64>().is_ok()
        && unit.starts_with(char::is_alphabetic)
        && unit.chars().all(|c| c.is_alphanumeric() || matches!(c, '/' | '^' | '²' | '³' | '%'))
}

/// A text that can only be meant as a string: it starts like a word or a path.
fn is_plain_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_alphabetic() || matches!(c, '_' | '.' | '/'))
        && !text.contains(|c: char| c.is_control())
}
