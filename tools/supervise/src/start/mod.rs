//! The processes of a group, from their start to their end, and the programs of the user's in it: those
//! of `--service`, and the one that a foreign law consists of.

pub mod attendant;
pub mod live_file;
pub mod processes;

use crate::{Error, UsageError};
use controller::laws;
use messages::Service;
use runtime::Program;
use scenario::Scenario;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Programs that replace services, or compute for them.
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
        && let Some(program) = laws::program(scenario)?
    {
        programs.insert(Service::Controller, program);
    }
    Ok(programs)
}

pub fn of_service(service: Service, path: &Path, here: &Path) -> Result<Program, UsageError> {
    let command = [path.to_string_lossy().into_owned()];
    Program::of(&command, here).map_err(|reason| {
        let place = format_args!("--service {service}={}", path.display());
        UsageError::at(place, reason.message, reason.expected)
    })
}
