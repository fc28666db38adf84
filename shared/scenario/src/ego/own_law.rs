//! `[laws.NAME]`: laws of the user's own, under names that may stand wherever a controller is named.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::controller::place_of;
use scenario_derive::tables;
use serde::{Deserialize, Serialize};
use toml::Value;

/// Laws of the user's own, by name.
pub type OwnLaws = BTreeMap<String, OwnLaw>;

tables! {
    /// A law of the user's own: a program, or a function of the program that starts the run.
    pub struct OwnLaw {
        /// The program: its name on the PATH or its path, then its arguments.
        pub command: Vec<String> = sparse,
        /// Directory in which the program runs. If absent, as for `controller.directory`.
        pub directory: Option<PathBuf>,
        /// The program that starts the run computes the law, such as a program in Python.
        pub caller: bool = sparse,
        /// Variables of the program's environment.
        pub env: BTreeMap<String, Word> = sparse,
        /// Arguments behind the command: `gain = 0.4` is `--gain=0.4`.
        pub arguments: BTreeMap<String, Word> = sparse,
        /// Variables of a unit (.fmu) by the quantities that they have: `speed_mps = "v_ego"`.
        pub map: BTreeMap<String, Word> = sparse,
    }
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
    pub fn words(&self) -> Vec<String> {
        self.command.iter().cloned().chain(unit_words(&self.arguments, &self.map)).collect()
    }

    /// Settles where the program runs; `own` is the scenario file's directory.
    pub(crate) fn place_command(&mut self, own: Option<&Path>) {
        self.directory = place_of(&self.command, self.directory.take(), own);
    }

    pub fn variables(&self) -> Vec<(String, String)> {
        self.env.iter().map(|(key, Word(value))| (key.clone(), value.clone())).collect()
    }
}

/// Arguments and a map as words of a command.
pub(crate) fn unit_words<'a>(
    arguments: &'a BTreeMap<String, Word>,
    map: &'a BTreeMap<String, Word>,
) -> impl Iterator<Item = String> + 'a {
    let arguments = arguments.iter().map(|(key, Word(value))| format!("--{key}={value}"));
    arguments.chain(map.iter().map(|(key, Word(value))| format!("{key}={value}")))
}

/// A word for a program. A file may have a number or a truth value in its place.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "Value")]
pub struct Word(pub String);

impl TryFrom<Value> for Word {
    type Error = String;

    fn try_from(value: Value) -> Result<Self, String> {
        match value {
            Value::String(text) if !text.contains('\0') => Ok(Self(text)),
            Value::Boolean(_) | Value::Integer(_) => Ok(Self(value.to_string())),
            Value::Float(number) => Ok(Self(number.to_string())),
            other => {
                Err(format!("invalid value: {other}, expected a text, a number or a truth value"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Overrides, Scenario};

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
    }

    #[test]
    fn a_key_of_a_law_can_be_set_and_swept() {
        let mut overrides = Overrides::new();
        overrides.set("laws.gentle.env.GAIN=0.5".parse().expect("a key"));
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
            ("command = \"law\"", "a list"),
            ("comand = [\"law\"]", "did you mean `command`?"),
            ("command = [\"law\"]\nenv.A = [1]", "a text, a number or a truth value"),
        ] {
            let shown = read(lines).expect_err(lines);
            assert!(shown.contains("mine.toml:") && shown.contains(what), "{shown}");
        }
    }
}
