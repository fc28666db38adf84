//! The laws that an option names.

use controller::laws;
use group::Failure;

/// Reason why `--controllers` names no laws.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum LawsError {
    /// There is nothing between two commas.
    #[error("--controllers {list}: a name is missing, expected names by commas")]
    Missing {
        /// The argument.
        list: String,
    },
    /// There is no such law.
    #[error("--controllers {list}: unknown value `{name}`, expected {}", scenario::accepted(name, names.iter().map(String::as_str)))]
    Unknown {
        /// The argument.
        list: String,
        /// The name.
        name: String,
        /// The known laws.
        names: Vec<String>,
    },
    /// A law would be driven twice, and counted twice.
    #[error("--controllers {list}: {name} is there twice, expected each once")]
    Twice {
        /// The argument.
        list: String,
        /// The name.
        name: String,
    },
    /// The law has no program in these runs.
    #[error(
        "--controllers {list}: `external` has no program in these runs, expected laws by --law NAME=COMMAND, or {}",
        names.join(", ")
    )]
    NoProgram {
        /// The argument.
        list: String,
        /// The laws that take part.
        names: Vec<String>,
    },
}

impl Failure for LawsError {}

/// Each law of `option` once; where the option is empty all of timegap's own, and the user's, which are `own`.
///
/// ```
/// use frame::batch::laws;
///
/// let chosen = ["acc-mpc".to_owned(), "gentle".to_owned()];
/// let own = ["gentle".to_owned()];
/// assert_eq!(laws::named(&chosen, &own).unwrap(), chosen);
/// assert!(laws::named(&chosen, &[]).is_err(), "no law has this name");
/// assert!(laws::named(&[], &own).unwrap().len() > 3, "all of timegap's own, and gentle");
/// ```
///
/// # Errors
/// [`LawsError`].
pub fn named(option: &[String], own: &[String]) -> Result<Vec<String>, LawsError> {
    if option.is_empty() {
        let ours = laws::own().map(|law| law.name.to_owned());
        return Ok(ours.chain(own.iter().cloned()).collect());
    }
    let list = || option.join(",");
    for (place, name) in option.iter().enumerate() {
        if name.is_empty() {
            return Err(LawsError::Missing { list: list() });
        }
        if laws::find(name).is_none() && !own.contains(name) {
            let names = laws::ALL.iter().map(|law| law.name.to_owned());
            let names = names.chain(own.iter().cloned()).collect();
            return Err(LawsError::Unknown { list: list(), name: name.clone(), names });
        }
        if option[..place].contains(name) {
            return Err(LawsError::Twice { list: list(), name: name.clone() });
        }
    }
    Ok(option.to_vec())
}

/// The same for a command that makes its scenarios. The law `external` has no program in them.
///
/// # Errors
/// [`LawsError`].
pub fn own_named(option: &[String], own: &[String]) -> Result<Vec<String>, LawsError> {
    let named = named(option, own)?;
    let ours = laws::own().map(|law| law.name.to_owned());
    let names: Vec<String> = ours.chain(own.iter().cloned()).collect();
    if named.iter().any(|name| !names.contains(name)) {
        return Err(LawsError::NoProgram { list: option.join(","), names });
    }
    Ok(named)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(names: &str) -> Vec<String> {
        names.split(',').map(str::to_owned).collect()
    }

    #[test]
    fn no_name_is_every_law_of_our_own() {
        let all = named(&[], &[]).expect("all");
        assert_eq!(Ok(all.clone()), own_named(&[], &[]));
        assert_eq!(named(&all, &[]), Ok(all.clone()));
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
            let said = named(&list(names), &[]).expect_err(names).to_string();
            assert!(said.starts_with("--controllers ") && said.contains(what), "{said}");
        }
        assert!(named(&list("external"), &[]).is_ok());
        let said =
            own_named(&list("external"), &list("gentle")).expect_err("no program").to_string();
        assert!(
            said.contains("by --law NAME=COMMAND, or acc-mpc, ") && said.contains("gentle"),
            "{said}"
        );
    }
}
