//! Scenarios that a group of processes cannot run, refused before anything is started.

use crate::Failure;
use messages::{Service, Topic};
use radio::{Carrier, OpenError, Role};
use runtime::Mode;
use runtime::scheduling::usable_cores;
use scenario::carrier::CarrierAddress;
use scenario::faults::{Effect, Fault, Helper, Kind, ProcessFault, Target};
use scenario::{Problem, Scenario};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Reason why a scenario is not run in this way.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// In simulated time all services wait for each other: a process fault shows nothing.
    #[error(
        "faults.{index}: `{kind}` acts on a process and needs --mode realtime; in lockstep, where all \
         services wait for each other, silence a topic with `drop` instead"
    )]
    FaultInLockstep {
        /// Name of the fault.
        index: usize,
        kind: Kind,
    },
    /// All services share one process.
    #[error(
        "faults.{index}: `{kind}` acts on a process, and here all services share one: leave out the \
         fault (--set faults=[]), or run with --mode realtime and without --in-process"
    )]
    FaultInProcess {
        /// Name of the fault.
        index: usize,
        kind: Kind,
    },
    /// In simulated time the end of a process ends the run.
    #[error(
        "supervision.standby: a standby for {0} needs --mode realtime; in lockstep the end of a process \
         ends the run"
    )]
    StandbyInLockstep(Service),
    /// A standby and a program of the user's for the same service.
    #[error(
        "--service {0}=PROGRAM: a standby is a process of timegap's own, expected no program in the \
         place of a service with a standby"
    )]
    StandbyOfProgram(Service),
    /// A run without a recording has no recorder.
    #[error("faults.{index}: there is no recorder to kill, expected a run that is recorded")]
    NoRecorder {
        /// Name of the fault.
        index: usize,
    },
    /// A fault that could never show.
    #[error("faults.{index}: {absent}")]
    NothingToFault {
        /// Name of the fault.
        index: usize,
        /// The missing part.
        absent: Absent,
    },
    /// Frames of other hosts come when they come.
    #[error(
        "radio {0}: other hosts do not follow simulated time, expected --mode realtime, or pcap:FILE, whose \
         frames have a clock of their own"
    )]
    LiveRadioInLockstep(CarrierAddress),
    /// The carrier of radio frames cannot be opened.
    #[error("radio: {0}")]
    Radio(#[from] OpenError),
}

impl Failure for Refusal {}

/// Target of a fault that the run does not have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Absent {
    #[error("there is no {0} in this run, expected a service that takes part")]
    Service(Service),
    #[error("nothing receives {} in this run, expected a topic that is received", .0.name())]
    Topic(Topic),
    #[error("core {core} cannot be used here, expected one of {}", list(.usable))]
    Core {
        core: usize,
        /// Those that the launcher may run on.
        usable: Vec<usize>,
    },
}

fn list(cores: &[usize]) -> String {
    cores.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

/// Target of `fault`, if it does not take part in the scenario.
pub fn absent(fault: &Fault, scenario: &Scenario) -> Option<Absent> {
    let takes_part = |service: &Service| scenario.services().contains(service);
    if let Effect::Process(ProcessFault::Hog { core: Some(core), .. }) = &fault.effect {
        let (core, usable) = (usize::from(core.value()), usable_cores());
        return (!usable.contains(&core)).then_some(Absent::Core { core, usable });
    }
    match fault.effect.target() {
        Target::Service(service) if !takes_part(&service) => Some(Absent::Service(service)),
        Target::Topic(topic) if !topic.consumers().iter().any(takes_part) => {
            Some(Absent::Topic(topic))
        }
        Target::Service(_) | Target::Topic(_) | Target::Helper(_) | Target::Machine => None,
    }
}

/// Checks that each fault of a single run has something to act on. The faults of a campaign are drawn for
/// scenarios of all kinds, and need not.
pub fn check_targets(scenario: &Scenario) -> Result<(), Refusal> {
    let mut absent = scenario.faults.iter().map(|fault| absent(fault, scenario)).enumerate();
    match absent.find_map(|(index, absent)| Some((index, absent?))) {
        Some((index, absent)) => Err(Refusal::NothingToFault { index, absent }),
        None => Ok(()),
    }
}

/// Checks that a group of processes can run what is asked for.
pub fn check_processes(
    mode: Mode,
    scenario: &Scenario,
    programs: &BTreeMap<Service, PathBuf>,
) -> Result<(), Refusal> {
    check_radio(scenario, mode)?;
    if mode == Mode::Lockstep {
        if let Some((index, kind)) = fault_of_processes(scenario) {
            return Err(Refusal::FaultInLockstep { index, kind });
        }
        return check_standbys(scenario);
    }
    let services = scenario.supervision.standby.services();
    match services.into_iter().find(|service| programs.contains_key(service)) {
        Some(service) => Err(Refusal::StandbyOfProgram(service)),
        None => Ok(()),
    }
}

/// Checks that there is a recorder where one is to be killed.
pub fn check_recorder(scenario: &Scenario, is_recorded: bool) -> Result<(), Refusal> {
    let of_recorder = |fault: &Fault| fault.effect.target() == Target::Helper(Helper::Recorder);
    match scenario.faults.iter().position(of_recorder).filter(|_| !is_recorded) {
        Some(index) => Err(Refusal::NoRecorder { index }),
        None => Ok(()),
    }
}

/// Checks that one process can run the scenario.
pub fn check_in_process(scenario: &Scenario) -> Result<(), Refusal> {
    check_radio(scenario, Mode::Lockstep)?;
    match fault_of_processes(scenario) {
        Some((index, kind)) => Err(Refusal::FaultInProcess { index, kind }),
        None => check_standbys(scenario),
    }
}

/// A carrier is opened and closed again, so that what is wrong is said before anything was started.
fn check_radio(scenario: &Scenario, mode: Mode) -> Result<(), Refusal> {
    let Some(address) = scenario.v2x.radio.carrier() else { return Ok(()) };
    if mode == Mode::Lockstep && address.is_live() {
        return Err(Refusal::LiveRadioInLockstep(address.clone()));
    }
    Ok(Carrier::open(address, Role::Vehicle).map(drop)?)
}

fn check_standbys(scenario: &Scenario) -> Result<(), Refusal> {
    match scenario.supervision.standby.services().first() {
        Some(&service) => Err(Refusal::StandbyInLockstep(service)),
        None => Ok(()),
    }
}

/// Checks that no fault acts on a process, for a run in simulated time.
///
/// # Errors
/// The place of the first one.
pub fn check_faults_in_lockstep(scenario: &Scenario) -> Result<(), Problem> {
    let Some((index, kind)) = fault_of_processes(scenario) else { return Ok(()) };
    let message =
        format!("`{kind}` acts on a process: in lockstep all services wait for each other");
    let expected = "--mode realtime and without --in-process, or `drop` to silence a topic";
    Err(Problem::new(format!("faults.{index}.kind"), message, expected))
}

/// The first fault that acts on processes, and its index.
fn fault_of_processes(scenario: &Scenario) -> Option<(usize, Kind)> {
    let mut faults = scenario.faults.iter().map(|fault| &fault.effect).enumerate();
    let found = faults.find(|(_, effect)| effect.of_processes().is_some());
    found.map(|(index, effect)| (index, effect.kind()))
}
