//! The laws that drive a study, with the keys and requirements of all its drives.

use clap::Args;
use controller::laws;
use scenario::{Overrides, Scenario, Setting};
use serde::{Deserialize, Serialize};
use supervise::{Error, LawOptions, UsageError};

/// Options of a study of several laws, for all its drives.
#[derive(Clone, Debug, Default, Args, Serialize, Deserialize)]
pub struct DriveOptions {
    /// Laws that drive, by commas [default: those of --law, or the study's]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub controllers: Vec<String>,
    /// Laws of the user's own.
    #[command(flatten)]
    pub laws: LawOptions,
    /// Change a key of every scenario, by its dotted path (repeatable)
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<Setting>,
    /// Judge every drive by a requirement as well: a formula or a name (repeatable; docs/search.md)
    #[arg(long = "require", value_name = "FORMULA")]
    pub require: Vec<String>,
}

impl DriveOptions {
    /// The laws of a study that makes its scenarios: the named ones, else all of timegap's and the user's.
    pub fn own_named(&self) -> Result<Vec<String>, UsageError> {
        self.laws.check()?;
        let named = own_named(&self.controllers, &self.laws.names())?;
        self.laws.expect_all_in(&named)?;
        Ok(named)
    }

    /// The scenario of a study's own settings with these options.
    pub fn scenario(&self, settings: &[Setting]) -> Result<Scenario, Error> {
        let mut overrides = Overrides::new().shared();
        self.laws.lay_over("--law", &mut overrides);
        self.set.iter().cloned().for_each(|setting| overrides.set(setting));
        let mut scenario = Scenario::of_settings(settings, &overrides, &laws::check)?;
        scenario.require.formulas.extend_from_slice(&self.require);
        supervise::requirements(&scenario)?;
        Ok(scenario)
    }

    /// The options as words of a command line, without the laws that drive.
    pub fn words(&self) -> Vec<String> {
        let set = self.set.iter().flat_map(|setting| ["--set".to_owned(), setting.to_string()]);
        let require = self.require.iter().flat_map(|one| ["--require".to_owned(), one.clone()]);
        self.laws.words().into_iter().chain(set).chain(require).collect()
    }
}

/// Each law of `option` once; where the option is empty all of timegap's own that drive such a vehicle, and the user's,
/// which are `own`.
///
/// ```
/// use frame::batch::laws;
///
/// let chosen = ["acc-mpc".to_owned(), "gentle".to_owned()];
/// let own = ["gentle".to_owned()];
/// assert_eq!(laws::named(&chosen, &own, false).unwrap(), chosen);
/// assert!(laws::named(&chosen, &[], false).is_err(), "no law has this name");
/// assert!(laws::named(&[], &own, false).unwrap().len() > 3, "timegap's own, and gentle");
/// ```
pub fn named(option: &[String], own: &[String], is_truck: bool) -> Result<Vec<String>, UsageError> {
    if option.is_empty() {
        let ours = laws::driving(is_truck).map(|law| law.name.to_owned());
        return Ok(ours.chain(own.iter().cloned()).collect());
    }
    let refuse = |why: &str, expected: &str| Err(refusal(option, why, expected));
    for (place, name) in option.iter().enumerate() {
        if name.is_empty() {
            return refuse("a name is missing", "names by commas");
        }
        if laws::find(name).is_none() && !own.contains(name) {
            let names = laws::ALL.iter().map(|law| law.name).chain(own.iter().map(String::as_str));
            let expected = scenario::accepted(name, names);
            return refuse(&format!("unknown value `{name}`"), &expected);
        }
        if option[..place].contains(name) {
            return refuse(&format!("{name} is there twice"), "each once");
        }
    }
    Ok(option.to_vec())
}

/// The same for a command that makes its scenarios, all with cars. The law `external` has no program in them.
fn own_named(option: &[String], own: &[String]) -> Result<Vec<String>, UsageError> {
    let named = named(option, own, false)?;
    let ours = laws::own().map(|law| law.name.to_owned());
    let names: Vec<String> = ours.chain(own.iter().cloned()).collect();
    if named.iter().any(|name| !names.contains(name)) {
        let expected = format!("laws by --law NAME=COMMAND, or {}", names.join(", "));
        return Err(refusal(option, "`external` has no program in these runs", &expected));
    }
    Ok(named)
}

fn refusal(option: &[String], why: &str, expected: &str) -> UsageError {
    UsageError::option("--controllers", option.join(","), why, expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(names: &str) -> Vec<String> {
        names.split(',').map(str::to_owned).collect()
    }

    #[test]
    fn no_name_is_every_law_of_our_own() {
        let all = named(&[], &[], false).expect("all");
        assert_eq!(Ok(all.clone()), own_named(&[], &[]));
        assert_eq!(named(&all, &[], false), Ok(all.clone()));
        let of_trucks = named(&[], &[], true).expect("all");
        assert_eq!(of_trucks, [all.clone(), list("predictive")].concat());
        assert!(all.iter().all(|name| name != "external"), "{all:?}");
    }

    #[test]
    fn an_invalid_or_repeated_name_is_refused_with_the_expected_form() {
        for (names, what) in [
            ("acc-mpc,", "a name is missing"),
            ("", "a name is missing"),
            ("acc-mpc,nope", "unknown value `nope`, expected `acc-mpc`, "),
            ("acc-mcp", "(did you mean `acc-mpc`?)"),
            ("acc-mpc,six-mode,acc-mpc", "acc-mpc is there twice"),
        ] {
            let said = named(&list(names), &[], false).expect_err(names).to_string();
            assert!(said.starts_with("--controllers ") && said.contains(what), "{said}");
        }
        assert!(named(&list("external"), &[], false).is_ok());
        let said =
            own_named(&list("external"), &list("gentle")).expect_err("no program").to_string();
        assert!(
            said.contains("by --law NAME=COMMAND, or acc-mpc, ") && said.contains("gentle"),
            "{said}"
        );
    }
}
