//! Keys of a scenario that are set over those of its file.

use std::ops::Range;

use toml::{Table, Value};

use super::error::ScenarioError;
use super::form::child;
use super::setting::{Setting, plain, split};

/// Keys to be set over a scenario file's own, in order: a later one wins.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    pub(super) list: Vec<Override>,
    pub(super) are_shared: bool,
}

/// A setting on behalf of an option.
#[derive(Clone, Debug)]
pub(super) struct Override {
    option: &'static str,
    /// The option stands for the key: `--seed 7`.
    is_own: bool,
    setting: Setting,
}

/// An override as a person would type it: `--set plant.period_ms=5`, `--seed 7`.
pub(super) struct Shown {
    pub text: String,
    /// Places of the names of the path.
    pub path: Vec<Range<usize>>,
    /// Start of the value; it ends with the text.
    pub value_start: usize,
}

impl Overrides {
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a setting of `--set`. A profile of an actor replaces the one from the file. It also replaces the initial
    /// speed if the new profile is a table of speeds.
    pub fn set(&mut self, setting: Setting) {
        self.set_by("--set", setting);
    }

    /// Adds a setting on behalf of another option, which errors name.
    pub fn set_by(&mut self, option: &'static str, setting: Setting) {
        self.list.push(Override { option, is_own: false, setting });
    }

    /// Adds an option of its own that stands for a key, such as `--seed 7` for `seed`. Errors name
    /// the option.
    pub fn option(&mut self, option: &'static str, key: &str, value: impl Into<Value>) {
        let setting = Setting::new(key, value);
        self.list.push(Override { option, is_own: true, setting });
    }

    /// The same for a file that is run with several laws. A key that one of them does not read is
    /// noted, not refused.
    pub fn shared(self) -> Self {
        Self { are_shared: true, ..self }
    }

    /// The keys of a file with these laid over them.
    pub(super) fn laid_over(&self, root: Table) -> Result<Table, ScenarioError> {
        let mut root = Value::Table(root);
        self.list.iter().try_for_each(|one| one.lay_over(&mut root))?;
        match root {
            Value::Table(root) => Ok(root),
            other => unreachable!("a table stays one: {other:?}"),
        }
    }
}

impl Override {
    pub(super) fn path(&self) -> &[String] {
        &self.setting.path
    }

    /// The rest of a path to a value that this option sets or is part of what it sets.
    pub(super) fn below<'p>(&self, path: &'p [&'p str]) -> Option<&'p [&'p str]> {
        let (above, below) = path.split_at_checked(self.path().len())?;
        self.path().iter().zip(above).all(|(name, step)| name == step).then_some(below)
    }

    pub(super) fn sets(&self, path: &[&str]) -> bool {
        let follow = |value, step: &&str| child(value, step);
        self.below(path)
            .is_some_and(|below| below.iter().try_fold(&self.setting.value, follow).is_some())
    }

    pub(super) fn shown(&self) -> Shown {
        let (option, start) = (self.option, self.option.len() + 1);
        if self.is_own {
            let text = format!("{option} {}", plain(&self.setting.value));
            return Shown { text, path: vec![0..start - 1; self.path().len()], value_start: start };
        }
        let argument = self.setting.to_string();
        let (path, value_start) = split(&argument).unwrap_or_default();
        let path = path.into_iter().map(|(_, span)| span.start + start..span.end + start).collect();
        Shown { text: format!("{option} {argument}"), path, value_start: value_start + start }
    }

    fn refuse(&self, step: usize, message: &str, expected: String) -> ScenarioError {
        let Shown { text, path, .. } = self.shown();
        let span = path.get(step).cloned().unwrap_or_default();
        ScenarioError::in_option(&text, span, message).expecting(expected)
    }

    /// Sets the value at its path, and makes the tables on the way that do not exist.
    fn lay_over(&self, root: &mut Value) -> Result<(), ScenarioError> {
        self.make_way_for_profile(root);
        let mut place = root;
        for (step, name) in self.path().iter().enumerate() {
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
                        self.refuse(step, &message, expected)
                    })?
                }
                _ => {
                    // The root is a table.
                    let holder = step.saturating_sub(1);
                    let name = &self.path()[holder];
                    let message = format!("`{name}` holds a value ({kind}), so it has no keys");
                    let expected = "a table on the way to the key".to_owned();
                    return Err(self.refuse(holder, &message, expected));
                }
            };
        }
        place.clone_from(&self.setting.value);
        Ok(())
    }

    /// An actor has one profile. One that an option sets replaces the file's, and a table of speeds replaces the
    /// initial speed with it.
    fn make_way_for_profile(&self, root: &mut Value) {
        let names: Vec<&str> = self.path().iter().map(String::as_str).collect();
        let ["actors", index, "profile", below @ ..] = names.as_slice() else { return };
        let kinds = match (below.first(), &self.setting.value) {
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
