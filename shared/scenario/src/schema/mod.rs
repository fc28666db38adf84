//! The form of a scenario file as data: every key with its type, range, default and meaning, for editors
//! (a JSON Schema) and for the reference of all keys.
//!
//! It is taken from the types that read the file: `trace` asks them through serde, `notes` finds their
//! doc comments.

mod asked;
mod notes;
mod trace;

use crate::Scenario;
use crate::faults::{Kind, keys_of};
use asked::Asked;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use trace::{Form, Knowledge, Refusal, range, words};

/// A value's type.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// `true` or `false`.
    Boolean,
    /// A number, in the unit that the key's name carries.
    Number {
        /// True for whole numbers.
        is_whole: bool,
        /// Smallest and largest; none where any will do. [`Key::expected`] says where an end is not allowed.
        range: Option<(f64, f64)>,
    },
    /// A text.
    Text {
        /// The texts that are accepted; empty where others are, too.
        words: Vec<String>,
    },
    /// A list of such values.
    List(Box<Shape>),
    /// A list of so many values, each of its own type.
    Tuple(Vec<Shape>),
    /// A table with these keys and no others.
    Table(Vec<Key>),
    /// One of these words; those with a shape are the only key of a table.
    Choice(Vec<(String, Option<Shape>)>),
    /// A table with the key `kind`, a word on which its other keys depend.
    Kinds(Vec<(String, Vec<Key>)>),
    /// A table of another form: a control law checks it, or a translation fills it.
    Free,
}

/// A key of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Name.
    pub name: String,
    /// Type of its value.
    pub shape: Shape,
    /// What a value is to be, in words; none where the type says it all.
    pub expected: Option<String>,
    /// True if it cannot be left out.
    pub is_required: bool,
    /// The value that holds when it is left out, as TOML; none where leaving it out means that there is
    /// none.
    pub default: Option<toml::Value>,
    /// What it means.
    pub meaning: String,
}

/// The keys of a scenario file.
///
/// # Panics
/// If a type of this crate reads a form that `trace` does not know, which a test rules out.
#[must_use]
pub fn keys() -> Vec<Key> {
    let (known, _): (_, Scenario) = trace::learn();
    let all: Vec<String> = known.nodes.keys().filter(|path| is_key(path)).cloned().collect();
    let (known, required) = required(known, &all);
    let defaults = defaults(&known, &all, &required);
    let form = Forms { known: &known, required: &required, defaults: &defaults, source: None };
    let mut keys = form.keys("", "");
    keys.retain(|key| key.name != "faults");
    let after_actors = keys.iter().position(|key| key.name == "actors").map_or(0, |i| i + 1);
    keys.insert(after_actors, faults());
    keys
}

/// The dotted path of the only key of a scenario file with this name.
pub(super) fn path_of(name: &str) -> Option<String> {
    let mut found = Vec::new();
    collect_paths(&keys(), "", name, &mut found);
    let path = found.pop()?;
    found.is_empty().then_some(path)
}

fn collect_paths(keys: &[Key], above: &str, name: &str, found: &mut Vec<String>) {
    for key in keys {
        let path =
            if above.is_empty() { key.name.clone() } else { format!("{above}.{}", key.name) };
        if let Shape::Table(below) = &key.shape {
            collect_paths(below, &path, name, found);
        }
        if key.name == name {
            found.push(path);
        }
    }
}

/// The keys of a table that a control law reads into `T`, which is declared in the text `source`.
///
/// # Panics
/// If `T` reads a form that `trace` does not know.
#[must_use]
pub fn of_law<T: DeserializeOwned + Default + Serialize>(source: &'static str) -> Vec<Key> {
    let (known, _): (_, T) = trace::learn();
    let defaults = toml::Value::try_from(T::default()).expect("plain numbers and words");
    let required = BTreeSet::new();
    let source = Some(source);
    Forms { known: &known, required: &required, defaults: &defaults, source }.keys("", "")
}

/// The list of faults, which is read key by key.
fn faults() -> Key {
    let kinds = Kind::ALL.map(|kind| {
        let mut asked = Asked::of("faults", kind.name());
        keys_of(kind, &mut asked).expect("what was asked for is right");
        (kind.name().to_owned(), asked.keys)
    });
    Key {
        name: "faults".to_owned(),
        shape: Shape::List(Box::new(Shape::Kinds(kinds.into()))),
        expected: None,
        is_required: false,
        default: None,
        meaning: notes::of("", "Scenario", "faults").unwrap_or_default(),
    }
}

/// True if the path ends with a key.
fn is_key(path: &str) -> bool {
    !path.is_empty() && !path.ends_with(']') && !path.ends_with('>')
}

/// The keys that cannot be left out.
fn required(mut known: Knowledge, all: &[String]) -> (Knowledge, BTreeSet<String>) {
    let mut required = BTreeSet::new();
    for path in all.iter().filter(|path| !path.contains('<')) {
        let (kept, read) = trace::read_without::<Scenario>(known, [path.clone()].into());
        known = kept;
        if let Err(Refusal(message)) = read {
            let name = path.rsplit_once('.').map_or(path.as_str(), |(_, name)| name);
            assert_eq!(message, format!("missing field `{name}`"), "{path}");
            required.insert(path.clone());
        }
    }
    (known, required)
}

/// A scenario with one element in each list, and nothing in it that can be left out.
fn defaults(known: &Knowledge, all: &[String], required: &BTreeSet<String>) -> toml::Value {
    let in_lists = || all.iter().filter(|path| path.contains("[].") && !path.contains('<'));
    let leads_to_list = |path: &str| {
        let [list, table] = [format!("{path}[]."), format!("{path}.")];
        in_lists().any(|other| other.starts_with(&list) || other.starts_with(&table))
    };
    let left_out = all
        .iter()
        .filter(|path| !path.contains('<') && !required.contains(*path))
        .filter(|path| !leads_to_list(path))
        .cloned()
        .collect();
    let (_, read) = trace::read_without::<Scenario>(known.clone(), left_out);
    let scenario = read.expect("what is required is there");
    toml::Value::try_from(scenario).expect("every scenario has a form in TOML")
}

/// Turns what was learnt into keys.
struct Forms<'a> {
    known: &'a Knowledge,
    required: &'a BTreeSet<String>,
    defaults: &'a toml::Value,
    /// Where the type is declared that is read; none: in this crate.
    source: Option<&'static str>,
}

impl Forms<'_> {
    /// The keys of the table at `path`, below the top-level table `top`.
    fn keys(&self, path: &str, top: &str) -> Vec<Key> {
        let Some(Form::Table(name, keys)) = self.known.nodes.get(path).map(|node| &node.form)
        else {
            return Vec::new();
        };
        keys.iter()
            .filter(|key| self.known.nodes.contains_key(&format!("{path}.{key}")))
            .map(|key| {
                let below = format!("{path}.{key}");
                let top = if path.is_empty() { *key } else { top };
                let node = &self.known.nodes[&below];
                let is_value = matches!(node.form, Form::Number | Form::Whole | Form::Text);
                Key {
                    name: (*key).to_owned(),
                    shape: self.shape(&below, top),
                    // A bare name is a type of Rust's.
                    expected: node.expected.clone().filter(|text| is_value && text.contains(' ')),
                    is_required: self.required.contains(&below),
                    default: self.default(&below),
                    meaning: match self.source {
                        Some(source) => messages::notes::in_source(source, name, key),
                        None => notes::of(if path.is_empty() { "" } else { top }, name, key),
                    }
                    .unwrap_or_default(),
                }
            })
            .collect()
    }

    fn shape(&self, path: &str, top: &str) -> Shape {
        let node = &self.known.nodes[path];
        let expected = node.expected.as_deref();
        match node.form {
            Form::Free => Shape::Free,
            Form::Boolean => Shape::Boolean,
            Form::Whole => Shape::Number { is_whole: true, range: expected.and_then(range) },
            Form::Number => Shape::Number { is_whole: false, range: expected.and_then(range) },
            Form::Text => {
                let words = expected.map(words).unwrap_or_default();
                // An address among them stands for many.
                let is_open = words.iter().any(|word| word.contains("://"));
                Shape::Text { words: if is_open { Vec::new() } else { words } }
            }
            Form::List => Shape::List(Box::new(self.shape(&format!("{path}[]"), top))),
            Form::Tuple(count) => {
                Shape::Tuple((0..count).map(|i| self.shape(&format!("{path}[{i}]"), top)).collect())
            }
            Form::Table(..) => Shape::Table(self.keys(path, top)),
            Form::Choice(variants) => {
                let variant = |name: &&str| {
                    let below = format!("{path}<{name}>");
                    let shape = self.known.nodes.contains_key(&below);
                    ((*name).to_owned(), shape.then(|| self.shape(&below, top)))
                };
                Shape::Choice(variants.iter().map(variant).collect())
            }
        }
    }

    /// The value that holds at `path` when nothing is said.
    fn default(&self, path: &str) -> Option<toml::Value> {
        if self.required.contains(path) || path.contains('<') {
            return None;
        }
        let mut value = self.defaults;
        for step in path.split('.').skip(1) {
            let (key, is_list) = step.strip_suffix("[]").map_or((step, false), |key| (key, true));
            value = value.get(key)?;
            if is_list {
                value = value.get(0)?;
            }
        }
        // Tables and lists of tables say it key by key.
        let is_plain = match value {
            toml::Value::Table(_) => false,
            toml::Value::Array(list) => !list.iter().any(toml::Value::is_table),
            _ => true,
        };
        is_plain.then(|| value.clone())
    }
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
        let keys = keys();
        let period = find(&keys, "plant.period_ms");
        assert_eq!(period.shape, Shape::Number { is_whole: true, range: Some((1.0, 10_000.0)) });
        assert_eq!(period.default, Some(toml::Value::Integer(10)));
        assert!(find(&keys, "name").is_required && !period.is_required);
        assert_eq!(find(&keys, "set_speed_mps").default, Some(toml::Value::Float(33.3)));
        assert_eq!(find(&keys, "speed_limit_mps").default, None);
        assert_eq!(find(&keys, "actors.length_m").default, Some(toml::Value::Float(4.5)));
        assert!(find(&keys, "actors.gap_m").is_required);
        assert_eq!(find(&keys, "runtime.scheduling").default, Some("fifo".into()));
        let Shape::Choice(policies) = &find(&keys, "supervision.restart").shape else { panic!() };
        assert_eq!(policies[1], ("on-failure".to_owned(), None));
        let Shape::Choice(profiles) = &find(&keys, "actors.profile").shape else { panic!() };
        let sine = profiles.iter().find(|(name, _)| name == "sine").expect("it is there");
        let Some(Shape::Table(keys)) = &sine.1 else { panic!("{sine:?}") };
        assert_eq!(keys.len(), 3);
    }

    #[test]
    fn each_kind_of_fault_has_its_own_keys() {
        let keys = keys();
        let Shape::List(fault) = &find(&keys, "faults").shape else { panic!("a list") };
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
                variants.iter().filter_map(|(_, shape)| shape.as_ref()).for_each(|shape| {
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
        check(&keys(), "", &mut without);
        assert_eq!(without, [] as [&str; 0], "a new source of keys belongs into `notes`");
    }
}
