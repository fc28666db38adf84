//! The problem that the arguments name.

use group::{Error, GroupOptions};

use crate::arguments::SearchArguments;
use crate::problem::{self, Draft, Problem, scenario_name};
use crate::reference::Reference;

impl Problem {
    /// The problem of a command: a search file, or a scenario with `--vary`.
    ///
    /// # Errors
    /// [`problem::ProblemError`], [`problem::FileError`], or mistakes in the scenario.
    pub fn open(arguments: &SearchArguments, group: &GroupOptions) -> Result<Self, Error> {
        let name = arguments.scenario.as_str();
        let mut draft = match problem::read(name)? {
            Some(file) => file.draft()?,
            None => {
                Draft { name: scenario_name(name), scenario: name.to_owned(), ..Draft::default() }
            }
        };
        for argument in &arguments.vary {
            draft.vary(argument)?;
        }
        if let Some(reference) = arguments.reference {
            draft.reference = Some(Reference::named(reference));
        }
        let problem = draft.finish(arguments.scenario_options.clone())?;
        problem.check(group)?;
        Ok(problem)
    }
}
