//! Checks of the user's own laws.

use crate::name::Name;
use crate::reading::refuse;
use crate::{Problem, Scenario};

/// Checks names and that each law is one thing.
pub(super) fn check(scenario: &Scenario) -> Result<(), Problem> {
    for (name, law) in &scenario.laws {
        refuse!(if let Err(error) = Name::try_from(name.clone()),
            "laws.{name}": "`{name}` is {error}", "another name");
        refuse!(if law.command.is_empty() != law.caller, "laws.{name}":
            "the law `{name}` has no program, or more than one",
            "a command, such as [\"python3\", \"law.py\"]");
        refuse!(if law.caller && !(law.env.is_empty() && law.arguments.is_empty()),
            "laws.{name}": "the law `{name}` is not a program of its own",
            "env and arguments with a command alone");
        let is_unit = law.command.first().is_some_and(|name| name.ends_with(".fmu"));
        refuse!(if !law.map.is_empty() && !is_unit, "laws.{name}.map":
            "the law `{name}` is not a unit, which has variables", "a command of a unit (.fmu)");
        let is_variable = |key: &str| !key.is_empty() && !key.contains(['=', '\0']);
        refuse!(if let Some(key) = law.env.keys().find(|key| !is_variable(key)),
            "laws.{name}.env": "`{key}` cannot be a variable of an environment",
            "a name without `=`");
    }
    Ok(())
}
