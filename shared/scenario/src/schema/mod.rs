//! The keys of a scenario file as data: every key with its type, unit, range, default and meaning.
//!
//! A table's struct is the declaration of its keys, by `#[derive(Schema)]`. Editors get a JSON Schema made of this
//! data. People get a reference page, and a search the ranges of what it may vary.
//!
//! ```
//! use scenario::schema::{Schema, Shape};
//!
//! let Shape::Table(keys) = scenario::plant::Plant::shape() else { panic!("a table") };
//! let period = keys.iter().find(|key| key.name == "period_ms").expect("a key of the plant");
//! assert_eq!(period.default, Some(10.into()));
//! let Shape::Number { range, unit, .. } = period.shape else { panic!("a number") };
//! assert_eq!((range, unit), (Some((1.0, 10_000.0)), "ms"));
//! ```

mod types;

use std::any::TypeId;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use serde::Serialize;

pub use scenario_derive::{Schema, tables};

/// A type that reads a value of a scenario file.
pub trait Schema: Sized + 'static {
    /// True if a key of this type can always be left out.
    const IS_OPTION: bool = false;

    fn shape() -> Shape;

    /// Accepted values in words; none if the shape gives them.
    fn expected() -> Option<String> {
        None
    }
}

#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    Boolean,
    Number {
        is_whole: bool,
        /// Smallest and largest value; none if every value is accepted. [`Key::expected`] names an end that is not
        /// part of the range.
        range: Option<(f64, f64)>,
        /// Unit; empty for a number without one, and for one whose key alone names it.
        unit: &'static str,
    },
    Text {
        /// The accepted texts; empty if there are others.
        words: Vec<String>,
    },
    /// A list of such values.
    List(Box<Shape>),
    /// A list with one value of each of these types, and what it is in words.
    Tuple(Vec<Shape>, &'static str),
    /// A table with these keys and no others.
    Table(Vec<Key>),
    /// One of these words; a variant with a shape is the only key of a table.
    Choice(Vec<Variant>),
    /// A table with the key `kind`, a word that determines its other keys.
    Kinds(Vec<(String, Vec<Key>)>),
    /// A table of another form: a control law checks it, or a translation fills it.
    Free,
}

/// A word of a [`Shape::Choice`].
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    pub name: String,
    pub meaning: String,
    /// Form of the value that the word is the key of; none for a word alone.
    pub shape: Option<Shape>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    pub name: String,
    /// Type of its value.
    pub shape: Shape,
    /// Accepted values in words; none if the type gives them.
    pub expected: Option<String>,
    /// True if it must be written.
    pub is_required: bool,
    /// Value of a key that is left out, as TOML; none if such a key has no value.
    pub default: Option<toml::Value>,
    pub meaning: String,
}

/// A value's form in TOML, as the keys of a table or as the default of a key.
pub fn written(value: &impl Serialize) -> Option<toml::Value> {
    toml::Value::try_from(value).ok()
}

impl Key {
    /// A key whose value is read into a `T`. It must be written if it has no default, unless it is an option.
    pub fn of<T: Schema>(name: &str, meaning: &str, default: Option<Option<toml::Value>>) -> Self {
        let shape = T::shape();
        Self {
            name: name.to_owned(),
            expected: T::expected(),
            is_required: default.is_none() && !T::IS_OPTION,
            default: default.flatten().filter(|_| shape.is_plain()),
            shape,
            meaning: meaning.to_owned(),
        }
    }
}

impl Shape {
    /// True if a default of this type is one value: each key of a table has its own.
    fn is_plain(&self) -> bool {
        match self {
            Self::List(element) => element.is_plain(),
            other => !matches!(other, Self::Table(_) | Self::Kinds(_) | Self::Free),
        }
    }
}

/// The keys of the table that is read into a `T`; none if it is not a table.
pub fn keys_of<T: Schema>() -> Vec<Key> {
    match T::shape() {
        Shape::Table(keys) => keys,
        _ => Vec::new(),
    }
}

/// The form of a type's values, which is made once in a process.
pub fn shape_of<T: Schema>() -> &'static Shape {
    static SHAPES: Mutex<BTreeMap<TypeId, &'static Shape>> = Mutex::new(BTreeMap::new());
    let known = |shapes: &BTreeMap<_, &'static Shape>| shapes.get(&TypeId::of::<T>()).copied();
    let lock = || SHAPES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(shape) = known(&lock()) {
        return shape;
    }
    let shape = Box::leak(Box::new(T::shape()));
    lock().entry(TypeId::of::<T>()).or_insert(shape)
}

/// True if a value is its type's own default.
pub(crate) fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn find<'a>(keys: &'a [Key], path: &str) -> &'a Key {
        let (first, rest) = path.split_once('.').map_or((path, None), |(a, b)| (a, Some(b)));
        let key = keys.iter().find(|key| key.name == first).unwrap_or_else(|| panic!("{first}"));
        let mut shape = &key.shape;
        if let Shape::List(element) = shape {
            shape = element;
        }
        match (rest, shape) {
            (None, _) => key,
            (Some(rest), Shape::Table(keys)) => find(keys, rest),
            (Some(rest), other) => panic!("{rest} below {other:?}"),
        }
    }

    #[test]
    fn ranges_defaults_and_meanings_come_from_the_types() {
        let keys = crate::keys();
        let period = find(keys, "plant.period_ms");
        let milliseconds =
            Shape::Number { is_whole: true, range: Some((1.0, 10_000.0)), unit: "ms" };
        assert_eq!(period.shape, milliseconds);
        assert_eq!(period.default, Some(toml::Value::Integer(10)));
        assert!(find(keys, "name").is_required && !period.is_required);
        assert_eq!(find(keys, "set_speed_mps").default, Some(toml::Value::Float(33.3)));
        assert_eq!(find(keys, "speed_limit_mps").default, None);
        assert!(!find(keys, "speed_limit_mps").is_required);
        assert_eq!(find(keys, "actors.length_m").default, Some(toml::Value::Float(4.5)));
        assert!(find(keys, "actors.gap_m").is_required);
        assert_eq!(find(keys, "runtime.scheduling").default, Some("fifo".into()));
        let Shape::Choice(policies) = &find(keys, "supervision.restart").shape else { panic!() };
        assert_eq!((policies[1].name.as_str(), &policies[1].shape), ("on-failure", &None));
        let Shape::Choice(profiles) = &find(keys, "actors.profile").shape else { panic!() };
        let sine = profiles.iter().find(|variant| variant.name == "sine").expect("it is there");
        let Some(Shape::Table(keys)) = &sine.shape else { panic!("{sine:?}") };
        assert_eq!(keys.len(), 3);
        assert!(keys[0].is_required && keys[0].meaning.starts_with("Amplitude"));
    }

    #[test]
    fn each_kind_of_fault_has_its_own_keys() {
        let keys = crate::keys();
        let Shape::List(fault) = &find(keys, "faults").shape else { panic!("a list") };
        let Shape::Kinds(kinds) = &**fault else { panic!("{fault:?}") };
        let of = |kind: &str| &kinds.iter().find(|(name, _)| name == kind).expect(kind).1;
        let names: Vec<_> = of("delay").iter().map(|key| key.name.as_str()).collect();
        let all = ["delay_ms", "jitter_ms", "topic", "probability", "for_s", "at_s", "when"];
        assert_eq!(names, all);
        assert!(find(of("delay"), "topic").is_required && !find(of("kill"), "at_s").is_required);
        assert_eq!(find(of("corrupt"), "bits").default, Some(toml::Value::Integer(1)));
        assert!(find(of("hog"), "when.speed_below_mps").meaning.contains("slower"));
    }

    fn check(keys: &[Key], path: &str, without: &mut Vec<String>) {
        for key in keys {
            let path = format!("{path}.{}", key.name);
            if key.meaning.is_empty() {
                without.push(path.clone());
            }
            below(&key.shape, &path, without);
        }
    }

    fn below(shape: &Shape, path: &str, without: &mut Vec<String>) {
        match shape {
            Shape::Table(keys) => check(keys, path, without),
            Shape::List(element) => below(element, path, without),
            Shape::Choice(variants) => {
                variants.iter().filter_map(|variant| variant.shape.as_ref()).for_each(|shape| {
                    below(shape, path, without);
                });
            }
            Shape::Kinds(kinds) => kinds.iter().for_each(|(_, keys)| check(keys, path, without)),
            _ => {}
        }
    }

    #[test]
    fn every_key_has_a_meaning() {
        let mut without = Vec::new();
        check(crate::keys(), "", &mut without);
        assert_eq!(without, [] as [&str; 0]);
    }
}
