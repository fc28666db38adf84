//! The options of a fault, one for each key of some kind of fault. They are made from the declarations of the kinds.

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, value_parser};
use scenario::faults::{Kind, keys_of};
use scenario::schema::{Key, Shape};
use std::sync::LazyLock;
use toml::{Table, Value};

/// Keys that the target of the command stands for, and one that only a file has.
const NOT_OPTIONS: [&str; 4] = ["service", "topic", "helper", "when"];

/// Keys whose option has a name of its own.
const RENAMED: [(&str, &str); 2] = [("for_s", "for"), ("at_s", "in")];

/// The keys of a fault that the options set.
#[derive(Clone, Debug, Default)]
pub struct FaultOptions {
    pub(super) keys: Table,
}

struct FaultOption {
    key: Key,
    name: String,
    help: String,
}

static OPTIONS: LazyLock<Vec<FaultOption>> = LazyLock::new(|| {
    let mut found: Vec<(Key, Vec<(Kind, String)>)> = Vec::new();
    for kind in Kind::ALL {
        for key in keys_of(kind) {
            let of_kind = (kind, key.meaning.clone());
            match found.iter_mut().find(|(known, _)| known.name == key.name) {
                Some((_, kinds)) => kinds.push(of_kind),
                None if NOT_OPTIONS.contains(&key.name.as_str()) => {}
                None => found.push((key, vec![of_kind])),
            }
        }
    }
    let option = |(key, kinds): (Key, Vec<(Kind, String)>)| {
        let help = help(&key, &kinds);
        FaultOption { name: name(&key.name), help, key }
    };
    found.into_iter().map(option).collect()
});

pub(super) fn name(key: &str) -> String {
    let renamed = RENAMED.into_iter().find(|(of, _)| *of == key);
    renamed.map_or_else(|| key.replace('_', "-"), |(_, name)| name.to_owned())
}

/// The meanings of a key, each with the kinds that give it this one.
fn help(key: &Key, kinds: &[(Kind, String)]) -> String {
    if key.name == "at_s" {
        // A run in progress counts from the command, a file from the start of the run.
        return "Delay from now to the start, s".to_owned();
    }
    let mut meanings: Vec<(&str, Vec<&str>)> = Vec::new();
    for (kind, meaning) in kinds {
        match meanings.iter_mut().find(|(known, _)| known == meaning) {
            Some((_, of)) => of.push(kind.name()),
            None => meanings.push((meaning, vec![kind.name()])),
        }
    }
    let of_kinds = |(meaning, kinds): &(&str, Vec<&str>)| {
        let meaning = meaning.trim_end_matches('.');
        match kinds.len() {
            1..=3 => format!("`{}`: {meaning}", kinds.join("`, `")),
            _ => meaning.to_owned(),
        }
    };
    let help = meanings.iter().map(of_kinds).collect::<Vec<_>>().join("; ");
    match &key.default {
        Some(default) => format!("{help} [default: {default}]"),
        None => help,
    }
}

impl FaultOption {
    fn argument(&'static self) -> Arg {
        let argument = Arg::new(self.name.as_str()).long(self.name.as_str()).help(&self.help);
        let argument = argument.allow_hyphen_values(true);
        match &self.key.shape {
            Shape::Number { is_whole, unit, .. } => {
                let unit = match *unit {
                    "s" => "SECONDS",
                    "ms" => "MS",
                    "MiB" => "MIB",
                    _ => "NUMBER",
                };
                let argument = argument.value_name(unit);
                match is_whole {
                    true => argument.value_parser(value_parser!(i64)),
                    false => argument.value_parser(value_parser!(f64)),
                }
            }
            Shape::Choice(words) => {
                let words: Vec<_> = words.iter().map(|word| word.name.as_str()).collect();
                argument.value_name("NAME").help(format!("{}: {}", self.help, words.join(", ")))
            }
            _ => argument.value_name("NAME"),
        }
    }

    fn value(&self, matches: &ArgMatches) -> Option<Value> {
        match self.key.shape {
            Shape::Number { is_whole: true, .. } => {
                matches.get_one::<i64>(&self.name).copied().map(Value::from)
            }
            Shape::Number { .. } => matches.get_one::<f64>(&self.name).copied().map(Value::from),
            _ => matches.get_one::<String>(&self.name).cloned().map(Value::from),
        }
    }
}

impl Args for FaultOptions {
    fn augment_args(command: Command) -> Command {
        command.args(OPTIONS.iter().map(FaultOption::argument))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for FaultOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut options = Self::default();
        options.update_from_arg_matches(matches)?;
        Ok(options)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        let given = OPTIONS
            .iter()
            .filter_map(|option| Some((option.key.name.clone(), option.value(matches)?)));
        self.keys.extend(given);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(arguments: &[&str]) -> Table {
        let command = FaultOptions::augment_args(Command::new("inject"));
        let arguments = std::iter::once("inject").chain(arguments.iter().copied());
        let matches = command.try_get_matches_from(arguments).expect("they are options");
        FaultOptions::from_arg_matches(&matches).expect("they are keys").keys
    }

    #[test]
    fn every_key_of_every_kind_is_an_option_or_part_of_the_target() {
        for key in Kind::ALL.into_iter().flat_map(keys_of) {
            let is_option = OPTIONS.iter().any(|option| option.key.name == key.name);
            assert_ne!(is_option, NOT_OPTIONS.contains(&key.name.as_str()), "{}", key.name);
        }
    }

    #[test]
    fn options_become_keys_with_their_types() {
        let keys = read(&["--for", "2", "--in", "0.5", "--delay-ms", "20", "--amount", "-3.5"]);
        let wanted = "for_s = 2.0\nat_s = 0.5\ndelay_ms = 20\namount = -3.5";
        assert_eq!(keys, wanted.parse().expect("TOML"));
    }
}
