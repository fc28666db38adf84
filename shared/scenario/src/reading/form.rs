//! Reading of values into types, with the path of what does not fit. Before that they are compared with their
//! declaration.
//!
//! The declaration knows the words that an author needs: the keys of this table, the kinds of that list. A reader by
//! types alone would also take a list for a table.

use serde::de::{DeserializeOwned, Unexpected};
use serde_path_to_error::Segment;
use toml::{Table, Value};

use super::problem::{Problem, accepted};
use crate::schema::{self, Key, Schema, Shape, Variant};

/// Reads a value into a type that declares its keys; `path` is the value's own.
pub(super) fn declared<T: DeserializeOwned + Schema>(
    value: Value,
    path: &str,
) -> Result<T, Problem> {
    check_form::<T>(&value, path)?;
    plain(value, path)
}

/// Compares a value with the declaration of a type; `path` is the value's own.
pub(crate) fn check_form<T: Schema>(value: &Value, path: &str) -> Result<(), Problem> {
    check(schema::shape_of::<T>(), value, path)
}

/// Reads a value into a type; `path` is the value's own.
pub(crate) fn plain<T: DeserializeOwned>(value: Value, path: &str) -> Result<T, Problem> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let path = error.path().iter().fold(path.to_owned(), |path, segment| match segment {
            Segment::Seq { index } => below(&path, index),
            Segment::Map { key } => below(&path, key),
            Segment::Enum { variant } => below(&path, variant),
            Segment::Unknown => path,
        });
        in_words(path, error.inner().message())
    })
}

/// A reader's sentence in the words of a scenario. Its two parts come apart.
fn in_words(path: String, said: &str) -> Problem {
    let (message, expected) = said.split_once(", expected ").unwrap_or((said, ""));
    let quoted = |text: &str| -> Vec<String> {
        text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    };
    let word = quoted(message).first().cloned().unwrap_or_default();
    let known = || {
        let words = quoted(expected);
        accepted(&word, words.iter().map(String::as_str))
    };
    match message.split_once(" `").map(|(kind, _)| kind) {
        Some("unknown field") => {
            Problem::new(path, format!("unknown key `{word}`"), known()).of_key()
        }
        Some("unknown variant") => Problem::new(path, format!("unknown value `{word}`"), known()),
        Some("missing field") => Problem::new(path, format!("missing key `{word}`"), ""),
        _ if expected.starts_with("a nonzero ") => {
            Problem::new(path, message, "a whole number of 1 or more")
        }
        _ if expected == "a sequence" => Problem::new(path, message, "a list"),
        _ => Problem::new(path, message, expected),
    }
}

fn check(shape: &Shape, value: &Value, path: &str) -> Result<(), Problem> {
    let wrong = |expected: &str| {
        Err(Problem::new(path, format!("invalid type: {}", found(value)), expected))
    };
    match (shape, value) {
        (Shape::Free, _)
        | (Shape::Boolean, Value::Boolean(_))
        | (Shape::Number { .. }, Value::Integer(_))
        | (Shape::Number { is_whole: false, .. }, Value::Float(_)) => Ok(()),
        (Shape::Text { words }, Value::String(word))
            if words.is_empty() || words.contains(word) =>
        {
            Ok(())
        }
        (Shape::List(element), Value::Array(list)) => {
            let mut elements = list.iter().enumerate();
            elements.try_for_each(|(i, value)| check(element, value, &below(path, i)))
        }
        (Shape::Tuple(elements, _), Value::Array(list)) if elements.len() == list.len() => {
            let mut pairs = elements.iter().zip(list).enumerate();
            pairs.try_for_each(|(i, (element, value))| check(element, value, &below(path, i)))
        }
        (Shape::Tuple(_, words), Value::Array(list)) => {
            Err(Problem::new(path, format!("invalid length {}", list.len()), *words))
        }
        (Shape::Table(keys), Value::Table(table)) => self::table(keys, table, path, None),
        (Shape::Choice(variants), _) => choice(variants, value, path),
        (Shape::Kinds(kinds), Value::Table(table)) => kind(kinds, table, path),
        (Shape::Text { words }, Value::String(word)) => {
            let known = words.iter().map(String::as_str);
            Err(Problem::new(path, format!("unknown value `{word}`"), accepted(word, known)))
        }
        (Shape::Boolean, _) => wrong("true or false"),
        (Shape::Text { .. }, _) => wrong("a string"),
        (Shape::Number { is_whole: true, .. }, _) => wrong("a whole number"),
        (Shape::Number { is_whole: false, .. }, _) => wrong("a number"),
        (Shape::List(of), _) if matches!(**of, Shape::Text { .. }) => {
            wrong("a list of words, such as [\"python3\", \"law.py\"]")
        }
        (Shape::List(_), _) => wrong("an array"),
        (Shape::Tuple(_, words), _) => wrong(words),
        (Shape::Table(_) | Shape::Kinds(_), _) => wrong("a table"),
    }
}

/// A table with these keys and no others. A fault's `kind` says which keys it has.
fn table(keys: &[Key], table: &Table, path: &str, kind: Option<&str>) -> Result<(), Problem> {
    let known = || {
        let names = keys.iter().map(|key| key.name.as_str());
        kind.map(|_| "kind").into_iter().chain(names)
    };
    for (name, value) in table.iter().filter(|(name, _)| kind.is_none() || *name != "kind") {
        let path = below(path, name);
        let Some(key) = keys.iter().find(|key| key.name == *name) else {
            let message = match kind {
                None => format!("unknown key `{name}`"),
                Some(kind) => format!("`{name}` means nothing for a fault of kind `{kind}`"),
            };
            return Err(Problem::new(path, message, accepted(name, known())).of_key());
        };
        of_key(key, value, &path)?;
    }
    let missing = keys.iter().find(|key| key.is_required && !table.contains_key(&key.name));
    let Some(Key { name, .. }) = missing else { return Ok(()) };
    Err(match kind {
        None => Problem::new(path, format!("missing key `{name}`"), ""),
        Some(kind) => {
            let message = format!("a fault of kind `{kind}` needs `{name}`");
            Problem::new(path, message, format!("`{name}`"))
        }
    })
}

fn of_key(key: &Key, value: &Value, path: &str) -> Result<(), Problem> {
    check(&key.shape, value, path).map_err(|problem| match &key.expected {
        Some(expected) if problem.path == path && !problem.is_of_key => {
            Problem { expected: expected.clone(), ..problem }
        }
        _ => problem,
    })?;
    let number = value.as_float().or(value.as_integer().map(|number| number as f64));
    if let (Shape::Number { range: Some((least, most)), .. }, Some(number), Some(expected)) =
        (&key.shape, number, &key.expected)
        && !(*least..=*most).contains(&number)
    {
        let shown = value.as_integer().map_or(number.to_string(), |whole| whole.to_string());
        return Err(Problem::new(path, format!("{shown} is out of range"), expected.as_str()));
    }
    Ok(())
}

/// A word, or a table with a word as its only key.
fn choice(variants: &[Variant], value: &Value, path: &str) -> Result<(), Problem> {
    let names = || variants.iter().map(|variant| variant.name.as_str());
    let find = |word: &str, path: &str| {
        variants.iter().find(|variant| variant.name == word).ok_or_else(|| {
            Problem::new(path, format!("unknown value `{word}`"), accepted(word, names()))
        })
    };
    let not_one = |found: &str| {
        let expected = format!("exactly one of {}", accepted("", names()));
        Err(Problem::new(path, format!("invalid type: {found}"), expected))
    };
    match value {
        Value::String(word) if find(word, path)?.shape.is_some() => Err(Problem::new(
            path,
            "the kind without what it is to be",
            "a table with its name as the key",
        )),
        Value::String(_) => Ok(()),
        Value::Table(table) => match (table.iter().next(), table.len()) {
            (Some((word, value)), 1) => {
                let path = below(path, word);
                let variant = find(word, &path).map_err(Problem::of_key)?;
                variant.shape.as_ref().map_or(Ok(()), |shape| check(shape, value, &path))
            }
            (_, count) => not_one(&format!("a table of {count} keys")),
        },
        other => not_one(&found(other)),
    }
}

/// A table whose key `kind` determines its other keys.
fn kind(kinds: &[(String, Vec<Key>)], table: &Table, path: &str) -> Result<(), Problem> {
    let Some(kind) = table.get("kind") else {
        return Err(Problem::new(path, "a fault needs `kind`", "`kind`"));
    };
    let word = kind.as_str().unwrap_or_default();
    if let Some((name, keys)) = kinds.iter().find(|(name, _)| name == word) {
        return self::table(keys, table, path, Some(name));
    }
    let message = match kind {
        Value::String(word) => format!("unknown value `{word}`"),
        other => format!("invalid type: {}", found(other)),
    };
    let names = kinds.iter().map(|(name, _)| name.as_str());
    Err(Problem::new(below(path, "kind"), message, accepted(word, names)))
}

/// The path of a key or an index of the value at `path`.
pub(super) fn below(path: &str, key: impl std::fmt::Display) -> String {
    if path.is_empty() { key.to_string() } else { format!("{path}.{key}") }
}

/// The value of a key of a table, or of an index of a list.
pub(super) fn child<'v>(value: &'v Value, step: &str) -> Option<&'v Value> {
    match value {
        Value::Table(table) => table.get(step),
        Value::Array(list) => list.get(step.parse::<usize>().ok()?),
        _ => None,
    }
}

fn found(value: &Value) -> String {
    match value {
        Value::String(text) => Unexpected::Str(text).to_string(),
        Value::Integer(number) => Unexpected::Signed(*number).to_string(),
        Value::Float(number) => Unexpected::Float(*number).to_string(),
        Value::Boolean(truth) => Unexpected::Bool(*truth).to_string(),
        Value::Datetime(_) => "datetime".to_owned(),
        Value::Array(_) => "a list".to_owned(),
        Value::Table(_) => "a table".to_owned(),
    }
}
