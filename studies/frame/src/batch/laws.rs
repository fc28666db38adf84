//! The laws that an option names.

use controller::laws;
use group::Failure;

/// Why `--controllers` names no laws.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum LawsError {
    /// There is nothing between two commas.
    #[error("--controllers {list}: a name is missing, expected names by commas")]
    Missing {
        /// The argument.
        list: String,
    },
    /// There is no such law.
    #[error("--controllers {list}: unknown value `{name}`, expected {}", names.join(", "))]
    Unknown {
        /// The argument.
        list: String,
        /// The name.
        name: String,
        /// The known laws.
        names: Vec<&'static str>,
    },
    /// A law would be driven twice, and counted twice.
    #[error("--controllers {list}: {name} is there twice, expected each once")]
    Twice {
        /// The argument.
        list: String,
        /// The name.
        name: String,
    },
    /// The command makes the scenarios, and none has a program.
    #[error("--controllers {list}: no program of yours takes part in these runs, expected {}", names.join(", "))]
    NoProgram {
        /// The argument.
        list: String,
        /// The laws that take part.
        names: Vec<&'static str>,
    },
}

impl Failure for LawsError {}

/// Each law of `option` once; all of timegap's own where the option is empty.
///
/// ```
/// use frame::batch::laws;
///
/// let chosen = ["acc-mpc".to_owned(), "six-mode".to_owned()];
/// assert_eq!(laws::named(&chosen).unwrap(), chosen);
/// assert!(laws::named(&[]).unwrap().len() > 2, "all of timegap's own");
/// ```
///
/// # Errors
/// [`LawsError`].
pub fn named(option: &[String]) -> Result<Vec<String>, LawsError> {
    if option.is_empty() {
        return Ok(laws::own().map(|law| law.name.to_owned()).collect());
    }
    let list = || option.join(",");
    for (place, name) in option.iter().enumerate() {
        if name.is_empty() {
            return Err(LawsError::Missing { list: list() });
        }
        if laws::find(name).is_none() {
            let names = laws::ALL.iter().map(|law| law.name).collect();
            return Err(LawsError::Unknown { list: list(), name: name.clone(), names });
        }
        if option[..place].contains(name) {
            return Err(LawsError::Twice { list: list(), name: name.clone() });
        }
    }
    Ok(option.to_vec())
}

/// The same for a command that makes its scenarios. No program of the user's takes part in them.
///
/// # Errors
/// [`LawsError`].
pub fn own_named(option: &[String]) -> Result<Vec<String>, LawsError> {
    let named = named(option)?;
    let names: Vec<&'static str> = laws::own().map(|law| law.name).collect();
    if named.iter().any(|name| !names.contains(&name.as_str())) {
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
        let all = named(&[]).expect("all");
        assert_eq!(Ok(all.clone()), own_named(&[]));
        assert_eq!(named(&all), Ok(all.clone()));
        assert!(all.iter().all(|name| name != "external"), "{all:?}");
    }

    #[test]
    fn a_name_that_is_none_or_there_twice_is_refused_with_what_was_expected() {
        for (names, what) in [
            ("acc-mpc,", "a name is missing"),
            ("", "a name is missing"),
            ("acc-mpc,nope", "unknown value `nope`, expected acc-mpc, "),
            ("acc-mpc,six-mode,acc-mpc", "acc-mpc is there twice"),
        ] {
            let said = named(&list(names)).expect_err(names).to_string();
            assert!(said.starts_with("--controllers ") && said.contains(what), "{said}");
        }
        assert!(named(&list("external")).is_ok());
        let said = own_named(&list("external")).expect_err("no program").to_string();
        assert!(said.contains("expected acc-mpc, "), "{said}");
    }
}
