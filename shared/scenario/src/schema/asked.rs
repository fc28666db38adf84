//! Learns the keys of a table that is read key by key, by running its reader.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;

use super::trace::{self, Form};
use super::{Forms, Key, notes};
use crate::keys::Keys;
use crate::problem::Problem;

/// The keys that a reader asked for.
pub(super) struct Asked {
    pub(super) keys: Vec<Key>,
    /// The top-level table that the keys are below.
    top: &'static str,
    /// The kind that is read.
    kind: &'static str,
}

impl Asked {
    pub(super) fn of(top: &'static str, kind: &'static str) -> Self {
        Self { keys: Vec::new(), top, kind }
    }

    /// Notes a key; a value of its type.
    fn note<T: DeserializeOwned>(
        &mut self,
        key: &'static str,
        is_required: bool,
        default: Option<toml::Value>,
    ) -> T {
        let (known, value): (_, T) = trace::learn();
        let node = &known.nodes[""];
        let is_value = matches!(node.form, Form::Number | Form::Whole | Form::Text);
        let expected = node.expected.clone().filter(|text| is_value && text.contains(' '));
        let (required, defaults) = (BTreeSet::new(), toml::Value::Boolean(false));
        let forms = Forms { known: &known, required: &required, defaults: &defaults, source: None };
        self.keys.push(Key {
            name: key.to_owned(),
            shape: forms.shape("", self.top),
            expected,
            is_required,
            default,
            meaning: notes::of_kind(self.top, self.kind, key).unwrap_or_default(),
        });
        value
    }
}

impl Keys for Asked {
    /// Nothing, so that keys that exclude each other are all asked for.
    fn optional<T: DeserializeOwned>(&mut self, key: &'static str) -> Result<Option<T>, Problem> {
        self.note::<T>(key, false, None);
        Ok(None)
    }

    fn required<T: DeserializeOwned>(&mut self, key: &'static str) -> Result<T, Problem> {
        Ok(self.note(key, true, None))
    }

    fn or<T: DeserializeOwned + Serialize>(
        &mut self,
        key: &'static str,
        default: T,
    ) -> Result<T, Problem> {
        let value = toml::Value::try_from(&default).expect("every value has a form in TOML");
        self.note::<T>(key, false, Some(value));
        Ok(default)
    }

    /// The values are examples, which need not go together.
    fn refuse(&self, _: &str, _: &str, _: String) -> Result<(), Problem> {
        Ok(())
    }
}
