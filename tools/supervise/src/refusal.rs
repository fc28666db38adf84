//! Scenarios that a group of processes cannot run, refused before anything is started.

use crate::UsageError;
use messages::Service;
use radio::{Carrier, Role};
use runtime::Mode;
use runtime::scheduling::usable_cores;
use scenario::faults::{Effect, Fault, Helper, ProcessFault, Target};
use scenario::{Problem, Scenario};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The target of `fault` that does not take part in the scenario, as a mistake at `faults`.
pub fn absent(fault: &Fault, scenario: &Scenario) -> Option<UsageError> {
    let takes_part = |service: &Service| scenario.services().contains(service);
    let refuse = |what, why: &str, expected: &str| {
        Some(UsageError::at("faults", format_args!("{what} {why}"), expected))
    };
    if let Effect::Process(ProcessFault::Hog { core: Some(core), .. }) = &fault.effect {
        let (core, usable) = (usize::from(core.value()), usable_cores());
        let list = usable.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let expected = format!("one of {list}");
        return match usable.contains(&core) {
            true => None,
            false => refuse(format!("core {core}"), "cannot be used here", &expected),
        };
    }
    match fault.effect.target() {
        Target::Service(service) if !takes_part(&service) => {
            refuse(format!("there is no {service}"), "in this run", "a service that takes part")
        }
        Target::Topic(topic) if !topic.consumers().iter().any(takes_part) => {
            let nothing = format!("nothing receives {}", topic.name());
            refuse(nothing, "in this run", "a topic that is received")
        }
        Target::Service(_) | Target::Topic(_) | Target::Helper(_) | Target::Machine => None,
    }
}

/// Checks that each fault of a single run has something to act on. The faults of a campaign are drawn for
/// scenarios of all kinds, and need not.
pub fn check_targets(scenario: &Scenario) -> Result<(), UsageError> {
    let absent = |(index, fault)| {
        let place = format!("faults.{index}");
        Some(UsageError { place, ..absent(fault, scenario)? })
    };
    scenario.faults.iter().enumerate().find_map(absent).map_or(Ok(()), Err)
}

/// Checks that a group of processes can run what is asked for.
pub fn check_processes(
    mode: Mode,
    scenario: &Scenario,
    programs: &BTreeMap<Service, PathBuf>,
) -> Result<(), UsageError> {
    if mode == Mode::Lockstep {
        return check_simulated(scenario);
    }
    check_radio(scenario, mode)?;
    let mut services = scenario.supervision.standby.iter();
    match services.find(|service| programs.contains_key(service)) {
        Some(service) => {
            let why = "a standby is a process of timegap's own";
            let expected = "no program in the place of a service with a standby";
            Err(UsageError::at(format_args!("--service {service}=PROGRAM"), why, expected))
        }
        None => Ok(()),
    }
}

/// Checks that there is a recorder where one is to be killed.
pub fn check_recorder(scenario: &Scenario, is_recorded: bool) -> Result<(), UsageError> {
    let of_recorder = |fault: &Fault| fault.effect.target() == Target::Helper(Helper::Recorder);
    match scenario.faults.iter().position(of_recorder).filter(|_| !is_recorded) {
        Some(index) => {
            let place = format_args!("faults.{index}");
            Err(UsageError::at(place, "there is no recorder to kill", "a run that is recorded"))
        }
        None => Ok(()),
    }
}

/// Checks that the scenario can be driven in simulated time, by one process or by several.
pub fn check_simulated(scenario: &Scenario) -> Result<(), UsageError> {
    check_radio(scenario, Mode::Lockstep)?;
    check_faults_in_lockstep(scenario)
        .map_err(|problem| UsageError::at(problem.path, problem.message, problem.expected))?;
    match scenario.supervision.standby.first() {
        Some(service) => {
            let place =
                format_args!("supervision.standby: a standby for {service} needs --mode realtime");
            let why = "in lockstep the end of a process ends the run";
            Err(UsageError::at(place, why, "no standby"))
        }
        None => Ok(()),
    }
}

/// A carrier is opened and closed again, so that what is wrong is said before anything was started.
fn check_radio(scenario: &Scenario, mode: Mode) -> Result<(), UsageError> {
    let Some(address) = scenario.v2x.radio.carrier() else { return Ok(()) };
    if mode == Mode::Lockstep && address.is_live() {
        let why = "other hosts do not follow simulated time";
        let expected = "--mode realtime, or pcap:FILE, whose frames have a clock of their own";
        return Err(UsageError::at(format_args!("radio {address}"), why, expected));
    }
    let unusable = |why| UsageError::at("radio", why, "an address that can be used");
    Carrier::open(address, Role::Vehicle).map(drop).map_err(unusable)
}

/// Checks that no fault acts on a process, for a run in simulated time.
///
/// # Errors
/// The place of the first one.
pub fn check_faults_in_lockstep(scenario: &Scenario) -> Result<(), Problem> {
    let of_process = |fault: &Fault| matches!(fault.effect, Effect::Process(_));
    let Some(index) = scenario.faults.iter().position(of_process) else { return Ok(()) };
    let kind = scenario.faults[index].effect.kind();
    let message =
        format!("`{kind}` acts on a process: in lockstep all services wait for each other");
    let expected = "no such fault (--set faults=[]), `drop` to silence a topic, or --mode realtime and without \
                    --in-process";
    Err(Problem::new(format!("faults.{index}.kind"), message, expected))
}
