//! Checks across keys: each value by itself is in its range already.

mod actors;
mod plan;

use messages::{Service, Topic};

use crate::aebs::LEAST_DECELERATION_MPS2;
use crate::controller::Release;
use crate::faults::{Fault, Target};
use crate::name::Name;
use crate::perception::MAX_LATENCY_SCANS;
use crate::plant::Integrator;
use crate::quantity::{Acceleration, PeriodMs};
use crate::reading::refuse;
use crate::schema::is_default;
use crate::supervision::Restart;
use crate::v2x::{MAX_PROGRAM_PHASES, MAX_SIGNALS, Signal};
use crate::{Problem, Scenario};

/// Runs every check; the first problem ends it.
pub(super) fn all(scenario: &Scenario) -> Result<(), Problem> {
    periods(scenario)?;
    plant(scenario)?;
    vehicle(scenario)?;
    plan::check(scenario)?;
    perception(scenario)?;
    aebs(scenario)?;
    standby(scenario)?;
    signals(&scenario.v2x.signals)?;
    radio(scenario)?;
    controller(scenario)?;
    laws(scenario)?;
    actors::actors(&scenario.actors)?;
    actors::storyboard(scenario)?;
    actors::events(&scenario.actors)
}

fn multiple(path: &str, value_ms: u32, (base, base_ms): (&str, u32)) -> Result<(), Problem> {
    refuse!(if !value_ms.is_multiple_of(base_ms),
        "{path}": "{path} = {value_ms} is not a whole multiple of {base} = {base_ms}",
        "{path} to be a multiple of {base}", against "{base}");
    Ok(())
}

fn periods(scenario: &Scenario) -> Result<(), Problem> {
    let Scenario { plant, perception, v2x, controller, runtime, .. } = scenario;
    let plant = ("plant.period_ms", plant.period_ms.value());
    let perception = ("perception.period_ms", perception.period_ms.value());
    multiple(perception.0, perception.1, plant)?;
    multiple("v2x.period_ms", v2x.period_ms.value(), plant)?;
    multiple("v2x.poll_ms", v2x.poll_ms.map_or(0, PeriodMs::value), plant)?;
    let period_ms = controller.period_ms.value();
    multiple("controller.period_ms", period_ms, plant)?;
    if controller.release == Release::Radar {
        multiple("controller.period_ms", period_ms, perception)?;
    }
    multiple("runtime.extra_delay_ms", runtime.extra_delay_ms.value(), plant)?;
    multiple("runtime.extra_jitter_ms", runtime.extra_jitter_ms.value(), plant)
}

fn plant(scenario: &Scenario) -> Result<(), Problem> {
    let plant = &scenario.plant;
    let (period, step) = (plant.period_ms.value(), plant.integration_step_ms.value());
    match plant.integrator {
        Integrator::Fine => {
            refuse!(if !period.is_multiple_of(step), "plant.integration_step_ms":
                "a step of {step} ms does not divide plant.period_ms = {period}",
                "a divisor of the period", against "plant.period_ms");
        }
        Integrator::PaperEuler => {
            multiple("plant.integration_step_ms", step, ("plant.period_ms", period))?;
            let lag_ms = 1e3 * plant.actuator_time_constant_s.value();
            refuse!(if f64::from(step) > lag_ms, "plant.integration_step_ms":
                "a step of {step} ms is longer than the actuator's time constant",
                "at most {lag_ms} ms, or the Euler step oscillates",
                against "plant.actuator_time_constant_s");
        }
    }
    let bounds = (plant.min_acceleration_mps2, plant.max_acceleration_mps2);
    around_zero("plant.", "acceleration_mps2", bounds)?;
    let bounds = (plant.gateway.min_request_mps2, plant.gateway.max_request_mps2);
    around_zero("plant.gateway.", "request_mps2", bounds)
}

/// The emergency brake needs brakes that deserve the name, and detections to brake for.
fn aebs(scenario: &Scenario) -> Result<(), Problem> {
    let deceleration = scenario.aebs.deceleration_mps2.value();
    refuse!(if scenario.has_aebs() && deceleration < LEAST_DECELERATION_MPS2,
        "aebs.deceleration_mps2": "an emergency brake of {deceleration} m/s² has no authority",
        "at least {LEAST_DECELERATION_MPS2} m/s² (UN R152)");
    let other = match scenario.perception.ideal {
        true => "perception.ideal = false",
        false => "perception.radar.model = \"detections\"",
    };
    refuse!(if scenario.aebs.enabled == Some(true) && !scenario.perception.gives_detections(),
        "aebs.enabled": "the emergency brake reads the radar's detections, and this radar gives none",
        "{other}, or aebs.enabled = false");
    Ok(())
}

/// A standby needs a service, and one that may go on after its process ended.
fn standby(scenario: &Scenario) -> Result<(), Problem> {
    let supervision = &scenario.supervision;
    for &service in &supervision.standby {
        refuse!(if !scenario.services().contains(&service), "supervision.standby":
            "a standby for {service}, which the scenario does not have", "services of the scenario");
        refuse!(if supervision.restart_of(service) == Restart::Never, "supervision.standby":
            "a standby for {service}, whose end is to end the run",
            "a restart policy other than \"never\"");
    }
    Ok(())
}

/// The papers' Euler step is that of a car on a level road. Only a truck has a mass of its own.
fn vehicle(scenario: &Scenario) -> Result<(), Problem> {
    let plant = &scenario.plant;
    scenario.road.profile()?;
    let (least, most) = (plant.gateway.min_torque_nm.value(), plant.gateway.max_torque_nm.value());
    refuse!(if least >= most, "plant.gateway.min_torque_nm":
        "the smallest torque is not below the largest", "less than {most}",
        against "plant.gateway.max_torque_nm");
    let is_paper = plant.integrator == Integrator::PaperEuler;
    if let Some(unit) = &plant.fmu {
        refuse!(if plant.vehicle.is_truck(), "plant.fmu": "a truck is not a unit", "none",
            against "plant.vehicle");
        fmi::check_vehicle(unit, &plant.unit_words()).map_err(|error| {
            Problem::new("plant.fmu", format!("{}: {}", error.place, error.fault), error.expected)
        })?;
    } else {
        refuse!(if !(plant.fmu_map.is_empty() && plant.fmu_start.is_empty()), "plant.fmu_map":
            "there is no unit", "plant.fmu = \"car.fmu\"");
    }
    if plant.vehicle.is_truck() {
        refuse!(if is_paper, "plant.integrator": "a truck has no paper's Euler step", "`fine`",
            against "plant.vehicle");
        return Ok(());
    }
    refuse!(if !scenario.road.is_level() && is_paper, "road":
        "the paper's Euler step has no grade", "no heights", against "plant.integrator");
    refuse!(if plant.mass_factor.value() != 1.0, "plant.mass_factor":
        "a car has no mass here", "plant.vehicle = \"jh6-49t\" or \"jh6-25t\"");
    Ok(())
}

/// The keys `min_…` and `max_…` of a table leave room on both sides of 0.
fn around_zero(
    table: &str,
    key: &str,
    (min, max): (Acceleration, Acceleration),
) -> Result<(), Problem> {
    refuse!(if min.value() >= 0.0,
        "{table}min_{key}": "this bound leaves no way to brake", "a negative number");
    refuse!(if max.value() <= 0.0,
        "{table}max_{key}": "this bound leaves no way to drive", "a positive number");
    Ok(())
}

fn perception(scenario: &Scenario) -> Result<(), Problem> {
    let perception = &scenario.perception;
    let (latency, period) = (perception.radar.latency_ms.value(), perception.period_ms.value());
    multiple("perception.radar.latency_ms", latency, ("perception.period_ms", period))?;
    let most = MAX_LATENCY_SCANS * period;
    refuse!(if latency > most, "perception.radar.latency_ms":
        "{latency} ms are more than {MAX_LATENCY_SCANS} scans", "at most {most} ms");
    let tracker = &perception.tracker;
    let (hits, scans) = (tracker.confirm_hits.value(), tracker.confirm_scans.value());
    refuse!(if hits > scans || scans > 32, "perception.tracker.confirm_hits":
        "{hits} hits in {scans} scans", "at most as many hits as scans, and at most 32 scans",
        against "perception.tracker.confirm_scans");
    let selection = &perception.target_selection;
    let enter = selection.enter_half_width_m.value();
    refuse!(if selection.leave_half_width_m.value() < enter,
        "perception.target_selection.leave_half_width_m":
        "the path is narrower for leaving than for entering", "at least {enter}",
        against "perception.target_selection.enter_half_width_m");
    Ok(())
}

fn controller(scenario: &Scenario) -> Result<(), Problem> {
    let controller = &scenario.controller;
    let bounds = (controller.min_request_mps2, controller.max_request_mps2);
    around_zero("controller.", "request_mps2", bounds)?;
    let period_ms = controller.period_ms.value();
    refuse!(if controller.deadline().value() > period_ms, "controller.deadline_ms":
        "the deadline is longer than the period", "at most {period_ms} ms",
        against "controller.period_ms");
    Ok(())
}

fn signals(signals: &[Signal]) -> Result<(), Problem> {
    let count = signals.len();
    refuse!(if count > MAX_SIGNALS, "v2x.signals": "{count} signals", "at most {MAX_SIGNALS}");
    for (i, signal) in signals.iter().enumerate() {
        let phases = signal.program.len();
        refuse!(if !(1..=MAX_PROGRAM_PHASES).contains(&phases), "v2x.signals.{i}.program":
            "a program of {phases} phases", "1 to {MAX_PROGRAM_PHASES} phases");
        let before_m = i
            .checked_sub(1)
            .map_or(f64::NEG_INFINITY, |before| signals[before].stop_line_m.value());
        refuse!(if before_m >= signal.stop_line_m.value(), "v2x.signals.{i}.stop_line_m":
            "this stop line is not ahead of the signal before", "more than {before_m} m");
        let id = |s: &Signal| (s.intersection_id, s.signal_group);
        refuse!(if signals[..i].iter().any(|other| id(other) == id(signal)),
            "v2x.signals.{i}.intersection_id":
            "another signal has the same intersection and signal group",
            "a pair of ids of its own");
    }
    Ok(())
}

/// Without frames there is no air and no on-board unit: a fault of theirs would act on nothing.
fn radio(scenario: &Scenario) -> Result<(), Problem> {
    let v2x = &scenario.v2x;
    refuse!(if v2x.poll_ms.is_some() && !v2x.radio.is_live(), "v2x.poll_ms":
        "v2x.poll_ms has no effect without frames of other hosts",
        "v2x.radio to be the address of a live carrier");
    if v2x.radio.carrier().is_some() {
        return carrier(scenario);
    }
    if scenario.has_obu() {
        return Ok(());
    }
    let tables = [
        ("v2x.origin", is_default(&v2x.origin)),
        ("v2x.air", is_default(&v2x.air)),
        ("v2x.unit", is_default(&v2x.unit)),
        ("v2x.obu", is_default(&v2x.obu)),
    ];
    unused(tables, "frames", "v2x.radio = \"frames\"")?;
    refuse!(if let Some(index) = aimed_at(scenario, Topic::RadioFrames), "faults.{index}.topic":
        "there are no frames on `radio/frames`", "v2x.radio = \"frames\"");
    Ok(())
}

/// Refuses tables that act with a thing alone, which the scenario lacks. Unset ones are usual.
fn unused<const N: usize>(
    tables: [(&str, bool); N],
    thing: &str,
    expected: &str,
) -> Result<(), Problem> {
    let set = tables.into_iter().find(|(_, is_usual)| !is_usual);
    refuse!(if let Some((table, _)) = set,
        "{table}": "{table} has no effect without {thing}", "{expected}");
    Ok(())
}

/// The first fault that acts on a topic.
pub(crate) fn aimed_at(scenario: &Scenario, topic: Topic) -> Option<usize> {
    let aimed = |fault: &Fault| fault.effect.target() == Target::Topic(topic);
    scenario.faults.iter().position(aimed)
}

/// Frames of other hosts come through the air that there is, into one process.
fn carrier(scenario: &Scenario) -> Result<(), Problem> {
    refuse!(if !is_default(&scenario.v2x.air), "v2x.air":
        "the air is simulated for the frames of simulated units alone",
        "v2x.radio = \"frames\"", against "v2x.radio");
    refuse!(if scenario.supervision.standby.contains(&Service::V2xSim), "supervision.standby":
        "two processes of v2x-sim cannot have the radio",
        "v2x.radio = \"frames\"", against "v2x.radio");
    Ok(())
}

/// The user's own laws have names, and each is one thing.
fn laws(scenario: &Scenario) -> Result<(), Problem> {
    for (name, law) in &scenario.laws {
        refuse!(if let Err(error) = Name::try_from(name.clone()),
            "laws.{name}": "`{name}` is {error}", "another name");
        refuse!(if law.command.is_empty() != law.caller, "laws.{name}":
            "the law `{name}` has no program, or more than one",
            "a command, such as [\"python3\", \"law.py\"]");
        refuse!(if law.caller && !(law.env.is_empty() && law.arguments.is_empty()),
            "laws.{name}": "the law `{name}` is not a program of its own",
            "env and arguments with a command alone");
        let is_unit = law.command.first().is_some_and(|name| fmi::is_unit(name));
        refuse!(if !law.map.is_empty() && !is_unit, "laws.{name}.map":
            "the law `{name}` is not a unit, which has variables", "a command of a unit (.fmu)");
        let is_variable = |key: &str| !key.is_empty() && !key.contains(['=', '\0']);
        refuse!(if let Some(key) = law.env.keys().find(|key| !is_variable(key)),
            "laws.{name}.env": "`{key}` cannot be a variable of an environment",
            "a name without `=`");
    }
    Ok(())
}
