//! The programs of the user's in a run: those of `--service`, and the one that a foreign law consists of.

use crate::Failure;
use controller::laws;
use messages::Service;
use runtime::{Program, ProgramError};
use scenario::{Problem, Scenario};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// It does not cover a program of the user's.
#[derive(Debug, thiserror::Error)]
pub enum NoProgram {
    #[error("--service {service}={}: {reason}", path.display())]
    OfService {
        service: Service,
        path: PathBuf,
        #[source]
        reason: ProgramError,
    },
    /// Program of the scenario's law.
    #[error(transparent)]
    OfLaw(#[from] Problem),
}

impl Failure for NoProgram {}

/// Programs that replace services, or compute for them.
pub fn programs(
    services: &BTreeMap<Service, PathBuf>,
    scenario: &Scenario,
) -> Result<BTreeMap<Service, Program>, NoProgram> {
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

/// The program that replaces `service`.
pub fn of_service(service: Service, path: &Path, here: &Path) -> Result<Program, NoProgram> {
    let command = [path.to_string_lossy().into_owned()];
    Program::of(&command, here).map_err(|reason| NoProgram::OfService {
        service,
        path: path.to_owned(),
        reason,
    })
}

/// True if what `service` does is up to a program of the user's.
pub fn is_foreign(programs: &BTreeMap<Service, Program>, service: Service) -> bool {
    programs.contains_key(&service)
}
