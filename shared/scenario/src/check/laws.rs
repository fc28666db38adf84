//! Checks of the user's own laws.

use crate::name::Name;
use crate::{Problem, Scenario};

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
