//! The binary form in which a scenario reaches a service's process.
//!
//! A text is read once, where a run starts. The values that took effect travel as a tree in postcard's encoding. No
//! text is parsed again, and every number keeps all its bits.

use serde::{Deserialize, Serialize};

use super::document::{Document, Origin};
use super::error::ScenarioError;
use super::open::Place;
use super::reads::Reads;
use crate::{Overrides, Scenario};

#[derive(Serialize, Deserialize)]
enum Value {
    Boolean(bool),
    Whole(i64),
    Number(f64),
    Text(String),
    List(Vec<Value>),
    Table(Vec<(String, Value)>),
}

impl Scenario {
    /// The scenario as it took effect, for another process. [`Scenario::from_bytes`] reads it back.
    ///
    /// ```
    /// use scenario::{Scenario, builtin};
    ///
    /// let text = builtin::find("cut-in").expect("built in").text;
    /// let scenario = Scenario::parse("cut-in", text)?;
    /// let bytes = scenario.to_bytes();
    /// assert!(bytes.len() < scenario.to_toml().len());
    /// assert_eq!(Scenario::from_bytes(&bytes)?, scenario);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to_bytes(&self) -> Vec<u8> {
        let tree =
            toml::Value::try_from(self).expect("every value of a scenario has a form in TOML");
        postcard::to_allocvec(&Value::from(tree)).expect("a tree in memory has an encoding")
    }

    /// Reads what [`Scenario::to_bytes`] wrote.
    ///
    /// # Errors
    /// When the bytes are damaged or come from another version of the program.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ScenarioError> {
        let whole = |message: &str| ScenarioError::whole("scenario", message);
        let tree = postcard::from_bytes::<Value>(bytes)
            .map_err(|e| whole(&format!("the bytes are not a tree of values: {e}")))?;
        let toml::Value::Table(keys) = tree.into() else { return Err(whole("no table of keys")) };
        let none = Overrides::new();
        let document = Document::new(Origin::Values, keys, &none)?;
        Self::of_document(&document, Place::TakenEffect, &|_| Ok(Reads::everything()))
    }
}

impl From<toml::Value> for Value {
    fn from(value: toml::Value) -> Self {
        match value {
            toml::Value::Boolean(truth) => Self::Boolean(truth),
            toml::Value::Integer(number) => Self::Whole(number),
            toml::Value::Float(number) => Self::Number(number),
            toml::Value::String(text) => Self::Text(text),
            // No key is a date, so that a date is refused before it could travel.
            toml::Value::Datetime(date) => Self::Text(date.to_string()),
            toml::Value::Array(list) => Self::List(list.into_iter().map(Self::from).collect()),
            toml::Value::Table(table) => {
                Self::Table(table.into_iter().map(|(key, value)| (key, value.into())).collect())
            }
        }
    }
}

impl From<Value> for toml::Value {
    fn from(value: Value) -> Self {
        match value {
            Value::Boolean(truth) => Self::Boolean(truth),
            Value::Whole(number) => Self::Integer(number),
            Value::Number(number) => Self::Float(number),
            Value::Text(text) => Self::String(text),
            Value::List(list) => Self::Array(list.into_iter().map(Self::from).collect()),
            Value::Table(table) => {
                Self::Table(table.into_iter().map(|(key, value)| (key, value.into())).collect())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Problem, builtin};
    use proptest::prelude::*;
    use std::path::Path;

    fn everything(_: &Scenario) -> Result<Reads, Problem> {
        Ok(Reads::everything())
    }

    fn any_builtin() -> impl Strategy<Value = &'static str> {
        proptest::sample::select(builtin::ALL.iter().map(|it| it.name).collect::<Vec<_>>())
    }

    #[test]
    fn every_builtin_scenario_survives_the_way_through_bytes() {
        for it in builtin::ALL {
            let scenario = Scenario::open(it.name, &Overrides::new(), &everything).expect(it.name);
            let again = Scenario::from_bytes(&scenario.to_bytes()).expect(it.name);
            assert_eq!(again.to_toml(), scenario.to_toml(), "{}", it.name);
            assert_eq!(again, Scenario { notes: Vec::new(), ..scenario }, "{}", it.name);
        }
    }

    #[test]
    fn a_storyboard_survives_the_way_through_bytes() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/openscenario/cut_in.xosc");
        let scenario = Scenario::open_openscenario(
            Path::new(path),
            &Default::default(),
            &Overrides::new(),
            &everything,
        )
        .expect("an example");
        assert!(scenario.storyboard.is_some());
        assert_eq!(Scenario::from_bytes(&scenario.to_bytes()), Ok(scenario));
    }

    proptest! {
        #[test]
        fn numbers_keep_all_their_bits(
            name in any_builtin(), speed in 0.0..60.0f64, seed in 0..i64::MAX,
            gain in -1e300..1e300f64,
        ) {
            let mut overrides = Overrides::new();
            overrides.option("--speed", "set_speed_mps", speed);
            overrides.option("--seed", "seed", seed);
            overrides.option("--gain", "controller.mine.gain", gain);
            let scenario = Scenario::open(name, &overrides, &everything).expect(name);
            let again = Scenario::from_bytes(&scenario.to_bytes()).expect(name);
            prop_assert_eq!(again.set_speed_mps.value().to_bits(), speed.to_bits());
            prop_assert_eq!(again.seed, scenario.seed);
            prop_assert_eq!(again.controller.tables, scenario.controller.tables);
        }

        #[test]
        fn damaged_bytes_are_an_error_or_another_scenario(
            name in any_builtin(), at in any::<prop::sample::Index>(), bits in 1..=255u8,
        ) {
            let scenario = Scenario::open(name, &Overrides::new(), &everything).expect(name);
            let mut bytes = scenario.to_bytes();
            let at = at.index(bytes.len());
            bytes[at] ^= bits;
            let _ = Scenario::from_bytes(&bytes);
            prop_assert!(Scenario::from_bytes(&bytes[..at]).is_err());
        }
    }
}
