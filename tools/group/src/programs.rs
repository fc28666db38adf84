//! The programs of the user's in a run: those of `--service`, and the one that a foreign law consists of.

use crate::Error;
use controller::laws;
use messages::Service;
use runtime::Program;
use scenario::{Problem, Scenario};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Who really runs in the place of which service, or computes for it.
///
/// # Errors
/// [`Error::Usage`] where one of them is no program.
pub fn programs(
    services: &BTreeMap<Service, PathBuf>,
    scenario: &Scenario,
) -> Result<BTreeMap<Service, Program>, Error> {
    let here = std::env::current_dir().unwrap_or_default();
    let mut programs = BTreeMap::new();
    for (&service, path) in services {
        programs.insert(service, of_service(service, path, &here)?);
    }
    if !programs.contains_key(&Service::Controller)
        && let Some(program) = of_law(scenario)?
    {
        programs.insert(Service::Controller, program);
    }
    Ok(programs)
}

/// The program in the place of `service`.
///
/// # Errors
/// [`Error::Usage`] where it is none.
pub fn of_service(service: Service, path: &Path, here: &Path) -> Result<Program, Error> {
    let command = [path.to_string_lossy().into_owned()];
    Program::of(&command, here)
        .map_err(|error| Error::Usage(format!("--service {service}={}: {error}", command[0])))
}

/// The program that the scenario's law hosts.
fn of_law(scenario: &Scenario) -> Result<Option<Program>, Error> {
    let usage = |problem: Problem| {
        Error::Usage(format!(
            "{}: {}, expected {}",
            problem.path, problem.message, problem.expected
        ))
    };
    laws::program(scenario).map_err(usage)
}

/// True if what `service` does is up to a program of the user's.
pub fn is_foreign(programs: &BTreeMap<Service, Program>, service: Service) -> bool {
    programs.contains_key(&service)
}
