//! `[laws.NAME]`: laws of the user's own, under names that may stand wherever a controller is named.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use serde::de::{Error, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use super::Scenario;
use super::controller::words;
use super::name::Name;
use super::problem::Problem;

/// Laws of the user's own, by name.
pub type OwnLaws = BTreeMap<String, OwnLaw>;

/// A law of the user's own: a program, or a function of the program that starts the run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OwnLaw {
    /// The program: its name on the PATH or its path, then its arguments.
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "words")]
    pub command: Vec<String>,
    /// Directory in which the program runs. If absent, as for `controller.directory`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directory: Option<PathBuf>,
    /// The program that starts the run computes the law, such as a program in Python.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub caller: bool,
    /// Variables of the program's environment.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub env: BTreeMap<String, Word>,
    /// Arguments behind the command: `gain = 0.4` is `--gain=0.4`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub arguments: BTreeMap<String, Word>,
}

impl OwnLaw {
    /// The words that start the program.
    ///
    /// ```
    /// use scenario::own_law::{OwnLaw, Word};
    ///
    /// let mut law = OwnLaw { command: vec!["./law".to_owned()], ..OwnLaw::default() };
    /// law.arguments.insert("gain".to_owned(), Word("0.4".to_owned()));
    /// assert_eq!(law.words(), ["./law", "--gain=0.4"]);
    /// ```
    #[must_use]
    pub fn words(&self) -> Vec<String> {
        let arguments = self.arguments.iter().map(|(key, Word(value))| format!("--{key}={value}"));
        self.command.iter().cloned().chain(arguments).collect()
    }

    /// The variables of its environment.
    #[must_use]
    pub fn variables(&self) -> Vec<(String, String)> {
        self.env.iter().map(|(key, Word(value))| (key.clone(), value.clone())).collect()
    }
}

/// A word for a program. A file may have a number or a truth value in its place.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Word(pub String);

impl<'de> Deserialize<'de> for Word {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AnyWord;

        impl Visitor<'_> for AnyWord {
            type Value = Word;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a text, a number or a truth value")
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Word, E> {
                match text.contains('\0') {
                    true => Err(E::invalid_value(
                        Unexpected::Other("a zero byte"),
                        &"a text without one",
                    )),
                    false => Ok(Word(text.to_owned())),
                }
            }

            fn visit_bool<E>(self, value: bool) -> Result<Word, E> {
                Ok(Word(value.to_string()))
            }

            fn visit_i64<E>(self, value: i64) -> Result<Word, E> {
                Ok(Word(value.to_string()))
            }

            fn visit_u64<E>(self, value: u64) -> Result<Word, E> {
                Ok(Word(value.to_string()))
            }

            fn visit_f64<E>(self, value: f64) -> Result<Word, E> {
                Ok(Word(value.to_string()))
            }
        }

        deserializer.deserialize_any(AnyWord)
    }
}

/// Settles where the laws' programs run; `own` is the scenario file's directory.
pub(super) fn place(laws: &mut OwnLaws, own: Option<&Path>) {
    for law in laws.values_mut() {
        law.directory = super::controller::place_of(&law.command, law.directory.take(), own);
    }
}

/// Checks names and that each law is one thing.
pub(super) fn check(scenario: &Scenario) -> Result<(), Problem> {
    for (name, law) in &scenario.laws {
        let path = format!("laws.{name}");
        if let Err(error) = Name::try_from(name.clone()) {
            return Err(Problem::new(path, format!("`{name}` is {error}"), "another name"));
        }
        if law.command.is_empty() != law.caller {
            let message = format!("the law `{name}` has no program, or more than one");
            let expected = "a command, such as [\"python3\", \"law.py\"]";
            return Err(Problem::new(path, message, expected));
        }
        if law.command.is_empty() && !(law.env.is_empty() && law.arguments.is_empty()) {
            let message = format!("the law `{name}` is not a program of its own");
            return Err(Problem::new(path, message, "env and arguments with a command alone"));
        }
        let is_variable = |key: &str| !key.is_empty() && !key.contains(['=', '\0']);
        if let Some(key) = law.env.keys().find(|key| !is_variable(key)) {
            let message = format!("`{key}` cannot be a variable of an environment");
            return Err(Problem::new(format!("{path}.env"), message, "a name without `=`"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Overrides;

    const TEXT: &str = "schema_version = 1\nname = \"mine\"\n[laws.gentle]\n";

    fn read(lines: &str) -> Result<Scenario, String> {
        Scenario::parse("mine.toml", &format!("{TEXT}{lines}")).map_err(|error| error.to_string())
    }

    #[test]
    fn a_program_has_arguments_and_variables_of_its_own() {
        let lines =
            "command = [\"law\", \"-x\"]\nenv = { GAIN = 0.25, ON = true }\narguments.n = 3\n";
        let scenario = read(lines).expect("a law");
        let law = &scenario.laws["gentle"];
        assert_eq!(law.words(), ["law", "-x", "--n=3"]);
        let pair = |key: &str, value: &str| (key.to_owned(), value.to_owned());
        assert_eq!(law.variables(), [pair("GAIN", "0.25"), pair("ON", "true")]);
        let again = Scenario::parse("again", &scenario.to_toml()).expect("its own text");
        assert_eq!(again, scenario);
        assert_eq!(Scenario::from_bytes(&scenario.to_bytes()).expect("its own bytes"), scenario);
    }

    #[test]
    fn a_key_of_a_law_can_be_set_and_swept() {
        let mut overrides = Overrides::new();
        overrides.set("laws.gentle.env.GAIN=0.5").expect("a key");
        let text = format!("{TEXT}command = [\"law\"]\n");
        let all = |_: &Scenario| Ok(crate::Reads::everything());
        let scenario = Scenario::parse_with("mine.toml", &text, &overrides, &all).expect("a law");
        assert_eq!(scenario.laws["gentle"].env["GAIN"], Word("0.5".to_owned()));
    }

    #[test]
    fn a_table_of_no_law_or_of_two_is_refused_at_its_place() {
        for (lines, what) in [
            ("", "has no program, or more than one"),
            ("command = [\"a\"]\ncaller = true", "or more than one"),
            ("caller = true\nenv.A = 1", "is not a program of its own"),
            ("library = \"b.so\"", "unknown key `library`"),
            ("command = \"law\"", "a list of words"),
            ("comand = [\"law\"]", "did you mean `command`?"),
            ("command = [\"law\"]\nenv.A = [1]", "a text, a number or a truth value"),
        ] {
            let shown = read(lines).expect_err(lines);
            assert!(shown.contains("mine.toml:") && shown.contains(what), "{shown}");
        }
    }
}
