//! TOML values with the places of their keys and values.

mod part;
mod read;

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Deserialize;
use toml::Spanned;
use toml::de::DeValue;

pub(super) use part::Parts;

/// A value with its place. Two values are equal when they are the same wherever they stand.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    key: Option<Range<usize>>,
    place: Range<usize>,
    content: Content,
}

#[derive(Clone, Debug)]
enum Content {
    /// Text that is not a value: a number of too many digits.
    Unreadable(String),
    Scalar(toml::Value),
    Array(Vec<Placed>),
    Table(BTreeMap<String, Placed>),
}

/// A path that leads nowhere.
pub(super) struct DeadEnd {
    /// The part of the path that cannot be followed.
    pub(super) span: Range<usize>,
    pub(super) message: String,
    pub(super) expected: String,
}

impl PartialEq for Placed {
    fn eq(&self, other: &Self) -> bool {
        self.plain() == other.plain()
    }
}

impl Placed {
    /// An empty table at a place.
    pub(super) fn empty(place: Range<usize>) -> Self {
        Self { key: None, place, content: Content::Table(BTreeMap::new()) }
    }

    /// A value of a document whose positions begin at `base`.
    pub(super) fn of(value: &Spanned<DeValue<'_>>, base: usize) -> Self {
        let shifted = |span: Range<usize>| base + span.start..base + span.end;
        let content = match value.get_ref() {
            DeValue::Table(table) => {
                let entry = |(key, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
                    let name: &std::borrow::Cow<'_, str> = key.get_ref();
                    (name.to_string(), Self::of(value, base).with_key(shifted(key.span())))
                };
                Content::Table(table.iter().map(entry).collect())
            }
            DeValue::Array(array) => {
                Content::Array(array.iter().map(|value| Self::of(value, base)).collect())
            }
            other => match scalar(value) {
                Some(value) => Content::Scalar(value),
                None => Content::Unreadable(match other {
                    DeValue::Integer(number) => format!("integer `{number}`"),
                    DeValue::Float(number) => format!("number `{number}`"),
                    _ => other.type_str().to_owned(),
                }),
            },
        };
        Self { key: None, place: shifted(value.span()), content }
    }

    /// A value that is not part of a text, with all its parts at one place.
    pub(super) fn at(value: toml::Value, place: &Range<usize>) -> Self {
        let content = match value {
            toml::Value::Table(table) => {
                let entries = table.into_iter();
                Content::Table(entries.map(|(key, value)| (key, Self::at(value, place))).collect())
            }
            toml::Value::Array(array) => {
                Content::Array(array.into_iter().map(|value| Self::at(value, place)).collect())
            }
            scalar => Content::Scalar(scalar),
        };
        Self { key: None, place: place.clone(), content }
    }

    /// The same with the place of the key that holds it.
    fn with_key(mut self, key: Range<usize>) -> Self {
        self.key = Some(key);
        self
    }

    /// Its place.
    pub(super) fn place(&self) -> Range<usize> {
        self.place.clone()
    }

    /// The place of its key.
    pub(super) fn key_place(&self) -> Option<Range<usize>> {
        self.key.clone()
    }

    /// The elements, if it is a list.
    pub(super) fn elements(&self) -> Option<&[Self]> {
        match &self.content {
            Content::Array(array) => Some(array),
            Content::Scalar(_) | Content::Unreadable(_) | Content::Table(_) => None,
        }
    }

    /// The keys with their values, if it is a table.
    pub(super) fn entries(&self) -> Option<&BTreeMap<String, Self>> {
        match &self.content {
            Content::Table(table) => Some(table),
            Content::Scalar(_) | Content::Unreadable(_) | Content::Array(_) => None,
        }
    }

    /// The whole number, if it is one.
    pub(super) fn as_integer(&self) -> Option<i64> {
        match &self.content {
            Content::Scalar(value) => value.as_integer(),
            Content::Unreadable(_) | Content::Array(_) | Content::Table(_) => None,
        }
    }

    /// The value of a key of a table, or of an index of a list.
    pub(super) fn get(&self, segment: &str) -> Option<&Self> {
        match &self.content {
            Content::Table(table) => table.get(segment),
            Content::Array(array) => array.get(segment.parse::<usize>().ok()?),
            Content::Scalar(_) | Content::Unreadable(_) => None,
        }
    }

    /// The same, to be changed.
    pub(super) fn get_mut(&mut self, segment: &str) -> Option<&mut Self> {
        match &mut self.content {
            Content::Table(table) => table.get_mut(segment),
            Content::Array(array) => array.get_mut(segment.parse::<usize>().ok()?),
            Content::Scalar(_) | Content::Unreadable(_) => None,
        }
    }

    /// Takes a key out of a table.
    pub(super) fn remove(&mut self, key: &str) -> Option<Self> {
        match &mut self.content {
            Content::Table(table) => table.remove(key),
            Content::Scalar(_) | Content::Unreadable(_) | Content::Array(_) => None,
        }
    }

    /// Keeps the keys of a table that `is_kept` accepts.
    pub(super) fn retain(&mut self, is_kept: impl Fn(&str) -> bool) {
        if let Content::Table(table) = &mut self.content {
            table.retain(|key, _| is_kept(key));
        }
    }

    /// Adds the dotted paths of all values below to `into`; a list is one value.
    pub(super) fn collect_paths(&self, path: &str, into: &mut Vec<String>) {
        for (key, value) in self.entries().into_iter().flatten() {
            let path = format!("{path}.{key}");
            match value.content {
                Content::Table(_) => value.collect_paths(&path, into),
                _ => into.push(path),
            }
        }
    }

    /// Sets the value at `path`, and makes the tables on the way that do not exist. The path's own
    /// positions begin at `base`.
    pub(super) fn set(
        &mut self,
        path: &[(String, Range<usize>)],
        new: Self,
        base: usize,
    ) -> Result<(), DeadEnd> {
        let mut value = self;
        let mut holder = &path[0];
        for step @ (name, span) in path {
            let kind = value.kind();
            let key = base + span.start..base + span.end;
            value = match &mut value.content {
                Content::Table(table) => {
                    let made = || Self::empty(key.clone()).with_key(key.clone());
                    table.entry(name.clone()).or_insert_with(made)
                }
                Content::Array(array) => {
                    let length = array.len();
                    let element = name.parse().ok().and_then(|i: usize| array.get_mut(i));
                    element.ok_or_else(|| DeadEnd {
                        span: span.clone(),
                        message: format!("no element `{name}` in an array of {length}"),
                        expected: match length {
                            0 => "a value for the whole array".to_owned(),
                            _ => format!("an index from 0 to {}", length - 1),
                        },
                    })?
                }
                Content::Scalar(_) | Content::Unreadable(_) => {
                    let (name, span) = holder;
                    return Err(DeadEnd {
                        span: span.clone(),
                        message: format!("`{name}` holds a value ({kind}), so it has no keys"),
                        expected: "a table on the way to the key".to_owned(),
                    });
                }
            };
            holder = step;
        }
        *value = Self { key: value.key.clone(), ..new };
        Ok(())
    }

    /// The value of a key or of the next index, which is made at `place` where it is missing.
    pub(super) fn make(&mut self, segment: &str, place: &Range<usize>) -> &mut Self {
        let index = segment.parse::<usize>().ok();
        if index == Some(0) && self.elements().is_none() {
            self.content = Content::Array(Vec::new());
        }
        let made = || Self::empty(place.clone()).with_key(place.clone());
        match (&mut self.content, index) {
            (Content::Table(table), _) => table.entry(segment.to_owned()).or_insert_with(made),
            (Content::Array(array), Some(index)) => {
                if index == array.len() {
                    array.push(made());
                }
                &mut array[index]
            }
            _ => panic!("`{segment}` is below a value"),
        }
    }

    /// The value alone.
    pub(super) fn plain(&self) -> toml::Value {
        match &self.content {
            Content::Scalar(value) => value.clone(),
            Content::Unreadable(found) => toml::Value::String(found.clone()),
            Content::Array(array) => toml::Value::Array(array.iter().map(Self::plain).collect()),
            Content::Table(table) => toml::Value::Table(
                table.iter().map(|(name, value)| (name.clone(), value.plain())).collect(),
            ),
        }
    }

    /// The name of its type.
    fn kind(&self) -> &'static str {
        match &self.content {
            Content::Scalar(value) => value.type_str(),
            Content::Unreadable(_) => "number",
            Content::Array(_) => "array",
            Content::Table(_) => "table",
        }
    }
}

/// A value that is neither a table nor an array. A number that fits no type is kept as its text, which
/// no reader of numbers accepts.
fn scalar(value: &Spanned<DeValue<'_>>) -> Option<toml::Value> {
    toml::Value::deserialize(toml::de::ValueDeserializer::from(value.clone())).ok()
}
