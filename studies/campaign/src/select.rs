//! Choice of the campaign that a command means, and of its options.

use crate::arguments::CampaignArguments;
use crate::builtin::BUILTIN;
use crate::{columns, curves, plausibility, radio, signals, study};
use frame::{Command, Entry};
use group::{Error, Failure};
use report::results::Schema;
use std::path::Path;
use std::process::ExitCode;

/// A campaign that comes from no file.
#[derive(Debug)]
pub struct Own {
    /// Name, as given on the command line.
    pub name: &'static str,
    /// Its purpose, in one line.
    pub summary: &'static str,
    /// The options that it takes beside those of all campaigns.
    takes: &'static [&'static str],
    run: fn(&Command<CampaignArguments>) -> Result<ExitCode, Error>,
    schema: fn() -> Schema,
}

/// Campaigns that come from no file.
pub const WITHOUT_FILE: [Own; 4] = [
    Own {
        name: radio::NAME,
        summary: "2,000 drives through signals whose frames are lost, late and falsified",
        takes: &["--sample N", "--first N", "--law NAME=COMMAND", "--require FORMULA"],
        run: radio::run,
        schema: radio::schema,
    },
    Own {
        name: signals::NAME,
        summary: "500 corridors of signals, `cacc-mpc` against an ACC that stops for them",
        takes: &["--seeds N", "--first N", "--law NAME=COMMAND", "--require FORMULA"],
        run: signals::run,
        schema: signals::schema,
    },
    Own {
        name: curves::NAME,
        summary: "1,000 random curved roads, and as many curves with queues beside and in the lane",
        takes: &["--seeds N", "--first N", "--law NAME=COMMAND", "--require FORMULA"],
        run: curves::run,
        schema: curves::schema,
    },
    Own {
        name: plausibility::NAME,
        summary: "how often and how fast the checks of the inputs find a false sender",
        takes: &["--hours H", "--seed S", "--law NAME=COMMAND", "--require FORMULA"],
        run: plausibility::run,
        schema: plausibility::schema,
    },
];

/// All studies of the command, for `merge` and `resume`.
pub const STUDIES: [Entry; 5] =
    [study::ENTRY, radio::ENTRY, signals::ENTRY, curves::ENTRY, plausibility::ENTRY];

/// The options that the campaigns of files take.
const OF_FILES: &[&str] = &["--sample N", "--seeds N", "--law NAME=COMMAND", "--require FORMULA"];

/// Reason why no campaign is chosen.
#[derive(Debug, thiserror::Error)]
pub enum SelectionError {
    /// Nothing names one.
    #[error("no campaign is named, expected a file or one of {}", names().collect::<Vec<_>>().join(", "))]
    NoneNamed,
    /// It is neither built in nor a file.
    #[error(
        "{argument}: no built-in campaign and no file of this name, expected a path or {}",
        scenario::accepted(argument, names())
    )]
    Unknown {
        /// The argument.
        argument: String,
    },
    /// An option of other campaigns.
    #[error("{option} is for {of}; the campaign `{name}` takes {}", takes.join(", "))]
    Option {
        /// The option.
        option: &'static str,
        /// The campaigns that take it.
        of: String,
        /// The campaign.
        name: String,
        /// The options that it takes.
        takes: &'static [&'static str],
    },
}

impl Failure for SelectionError {}

/// The names of all campaigns.
fn names() -> impl Iterator<Item = &'static str> {
    BUILTIN.iter().map(|builtin| builtin.name).chain(WITHOUT_FILE.iter().map(|own| own.name))
}

/// Contents of the JSON of all campaigns: of the files, then of the others.
#[must_use]
pub fn schemas() -> Vec<Schema> {
    let own = WITHOUT_FILE.iter().map(|own| (own.schema)());
    std::iter::once(columns::schema()).chain(own).collect()
}

/// Runs the campaign that the arguments name.
pub fn run(command: &Command<CampaignArguments>) -> Result<ExitCode, Error> {
    let arguments = &command.study;
    let name = name(arguments)?;
    let Some(own) = WITHOUT_FILE.iter().find(|own| own.name == name) else {
        refuse_options(arguments, &name, OF_FILES)?;
        return study::run(command);
    };
    refuse_options(arguments, &name, own.takes)?;
    (own.run)(command)
}

/// Name or file of the campaign.
fn name(arguments: &CampaignArguments) -> Result<String, SelectionError> {
    let argument = arguments.campaign.clone().ok_or(SelectionError::NoneNamed)?;
    if names().any(|name| name == argument) || Path::new(&argument).exists() {
        return Ok(argument);
    }
    Err(SelectionError::Unknown { argument })
}

/// Refuses options that the campaign does not take.
fn refuse_options(
    arguments: &CampaignArguments,
    name: &str,
    takes: &'static [&'static str],
) -> Result<(), SelectionError> {
    let given = [
        ("--sample N", arguments.sample.is_some()),
        ("--first N", arguments.first.is_some()),
        ("--seeds N", arguments.seeds.is_some()),
        ("--hours H", arguments.hours.is_some()),
        ("--seed S", arguments.seed.is_some()),
        ("--law NAME=COMMAND", !arguments.laws.laws.is_empty()),
        ("--require FORMULA", !arguments.require.is_empty()),
    ];
    let refused = |(option, is_given): &(&str, bool)| *is_given && !takes.contains(option);
    let Some((option, _)) = given.into_iter().find(refused) else { return Ok(()) };
    let files = OF_FILES.contains(&option).then(|| "campaigns of a file".to_owned());
    let own = WITHOUT_FILE.iter().filter(|own| own.takes.contains(&option));
    let of: Vec<_> = files.into_iter().chain(own.map(|own| format!("`{}`", own.name))).collect();
    let (of, name) = (of.join(", "), name.to_owned());
    Err(SelectionError::Option { option, of, name, takes })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Args, FromArgMatches};

    fn refusal(line: &str) -> Option<String> {
        let words = line.split(' ');
        let command = CampaignArguments::augment_args(clap::Command::new("campaign"));
        let matches = command.try_get_matches_from(words).expect("it is a command");
        let arguments = CampaignArguments::from_arg_matches(&matches).expect("it is one");
        let name = name(&arguments).expect("it is a campaign");
        let own = WITHOUT_FILE.iter().find(|own| own.name == name);
        let takes = own.map_or(OF_FILES, |own| own.takes);
        refuse_options(&arguments, &name, takes).err().map(|refused| refused.to_string())
    }

    #[test]
    fn an_option_of_other_campaigns_is_refused_with_theirs_and_its_own() {
        assert_eq!(refusal("campaign radio --first 3 --sample 2"), None);
        assert_eq!(refusal("campaign kills --seeds 3 --shard 1/2"), None);
        for own in &WITHOUT_FILE {
            assert_eq!(refusal(&format!("campaign {} --require comfort", own.name)), None);
        }
        let said = refusal("campaign kills --first 3").expect("it is not an option of a file");
        assert!(said.starts_with(
            "--first N is for `radio`, `signals`, `curves`; the campaign `kills` takes"
        ));
        let said = refusal("campaign radio --seeds 3").expect("its number is its seed");
        assert!(
            said.contains("campaigns of a file, `signals`, `curves`")
                && said.contains("--sample N")
        );
    }
}
