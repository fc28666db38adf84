//! A key of a scenario and the value that it is set to.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};
use toml::de::{DeValue, ValueDeserializer};
use toml::{Spanned, Value};

use super::error::ScenarioError;
use crate::faults::Fault;

/// Most segments of a key's path.
const MAX_SEGMENTS: usize = 16;

/// A key of a scenario and its value. In a file and on a command line it is a text, `KEY=VALUE`.
///
/// KEY is a dotted path from the top, with elements of lists by their index: `actors.0.gap_m` or `actors[0].gap_m`.
/// VALUE is a TOML value; a plain word needs no quotes.
///
/// ```
/// use scenario::Setting;
///
/// let typed: Setting = "actors[0].gap_m=30".parse()?;
/// let made = Setting::new("actors.0.gap_m", 30);
/// assert_eq!((typed.key(), typed.value()), (made.key(), made.value()));
/// assert_eq!(typed.to_string(), "actors[0].gap_m=30", "it is shown as it was typed");
/// # Ok::<(), scenario::ScenarioError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Setting {
    /// Names from the top.
    pub(super) path: Vec<String>,
    pub(super) value: Value,
    /// The whole text of a person.
    typed: Option<String>,
}

/// The fault in a text that is not a setting: its place, a message and what was expected.
pub(super) type Misread = (Range<usize>, String, String);

/// The error about the `argument` of an option, whose part begins at `start`.
fn in_option(
    (span, message, expected): Misread,
    option: &str,
    argument: &str,
    start: usize,
) -> ScenarioError {
    let shift = option.len() + 1 + start;
    let span = span.start + shift..span.end + shift;
    ScenarioError::in_option(&format!("{option} {argument}"), span, &message).expecting(expected)
}

impl Setting {
    /// The key at a dotted path with a value that a program has.
    pub fn new(key: &str, value: impl Into<Value>) -> Self {
        let path = key.split(['.', '[']).map(|name| name.trim_end_matches(']').trim().to_owned());
        Self { path: path.collect(), value: value.into(), typed: None }
    }

    pub fn faults(faults: &[Fault]) -> Self {
        let value = |fault| Value::try_from(fault).expect("a fault has a form in TOML");
        Self::new("faults", faults.iter().map(value).collect::<Vec<_>>())
    }

    /// Reads the argument of an option, which errors name.
    ///
    /// # Errors
    /// When the argument has no `=`, or its key or value has not the form of one.
    pub fn read(option: &str, argument: &str) -> Result<Self, ScenarioError> {
        Self::misread(argument).map_err(|(why, start)| in_option(why, option, argument, start))
    }

    fn misread(argument: &str) -> Result<Self, (Misread, usize)> {
        let (path, start) = split(argument).map_err(|why| (why, 0))?;
        let value = value_of(&argument[start..]).map_err(|why| (why, start))?;
        let path = path.into_iter().map(|(name, _)| name.to_owned()).collect();
        Ok(Self { path, value, typed: Some(argument.to_owned()) })
    }

    pub fn key(&self) -> String {
        self.path.join(".")
    }

    pub fn value(&self) -> &Value {
        &self.value
    }

    /// Key and value for tables of results: as they were typed, a word without quotes.
    pub fn shown(&self) -> (String, String) {
        match self.typed.as_deref().and_then(|typed| typed.split_once('=')) {
            Some((key, value)) => {
                (key.trim().to_owned(), value.trim().trim_matches('"').to_owned())
            }
            None => (self.key(), plain(&self.value).into_owned()),
        }
    }
}

/// A value without the quotes of a word.
pub(super) fn plain(value: &Value) -> Cow<'_, str> {
    value.as_str().map_or_else(|| value.to_string().into(), Cow::from)
}

/// Reads the value of an option that stands for a key, such as `--seed 7`.
///
/// # Errors
/// When it has not the form of a value.
pub fn option_value(option: &str, text: &str) -> Result<Value, ScenarioError> {
    value_of(text).map_err(|why| in_option(why, option, text, 0))
}

/// Steps of a path with their places in the text.
type Steps<'a> = Vec<(&'a str, Range<usize>)>;

/// Names of the path in `KEY=VALUE` with their places, and the start of the value.
pub(super) fn split(argument: &str) -> Result<(Steps<'_>, usize), Misread> {
    let Some(equals) = argument.find('=') else {
        let expected = "KEY=VALUE, for example plant.period_ms=5".to_owned();
        return Err((0..argument.len(), "no `=`".to_owned(), expected));
    };
    let (mut path, mut at) = (Vec::new(), 0);
    for segment in argument[..equals].split(['.', '[']) {
        let span = at..at + segment.len();
        at = span.end + 1;
        let opened = argument[..span.start].ends_with('[');
        let inner = segment.strip_suffix(']');
        let name = inner.unwrap_or(segment).trim();
        let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        let is_key = !name.is_empty() && name.chars().all(bare);
        if !is_key || opened != inner.is_some() || path.len() == MAX_SEGMENTS {
            let message = format!("`{name}` cannot be a key of a scenario");
            let expected = "names joined by dots, for example actors.0.gap_m".to_owned();
            return Err((span, message, expected));
        }
        path.push((name, span));
    }
    let value = &argument[equals + 1..];
    Ok((path, argument.len() - value.trim_start().len()))
}

/// The value of a text with places from its start. A plain word is a text.
pub(super) fn spanned(text: &str) -> Result<Spanned<DeValue<'_>>, toml::de::Error> {
    let word = || Spanned::new(0..text.len(), DeValue::String(Cow::from(text)));
    DeValue::parse(text).or_else(|error| is_plain_word(text).then(word).ok_or(error))
}

fn value_of(text: &str) -> Result<Value, Misread> {
    let text = text.trim_end();
    let read = |value| Value::deserialize(ValueDeserializer::from(value));
    spanned(text).and_then(read).map_err(|error| {
        if let Some(number) = number_with_unit(text) {
            let message = format!("`{text}` is not a number: the key's name has the unit");
            let expected = format!("a number alone, such as {number}");
            return (0..text.len(), message, expected);
        }
        (error.span().unwrap_or(0..text.len()), error.message().to_owned(), String::new())
    })
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

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.typed {
            Some(typed) => f.write_str(typed),
            None => write!(f, "{}={}", self.key(), self.value),
        }
    }
}

impl std::str::FromStr for Setting {
    type Err = ScenarioError;

    fn from_str(argument: &str) -> Result<Self, ScenarioError> {
        Self::read("--set", argument)
    }
}

impl From<Setting> for String {
    fn from(setting: Setting) -> Self {
        setting.to_string()
    }
}

impl TryFrom<String> for Setting {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        Self::misread(&text).map_err(|((_, message, expected), _)| {
            let expected = if expected.is_empty() { "a TOML value" } else { &expected };
            format!("`{text}`: {message}, expected {expected}")
        })
    }
}
