//! Checks across keys: each value by itself is in its range already.

mod actors;
mod laws;
mod plan;
mod storyboard;

use crate::Problem;
use crate::Scenario;
use crate::aebs::LEAST_DECELERATION_MPS2;
use crate::controller::Release;
use crate::faults::{Fault, Target};
use crate::perception::MAX_LATENCY_SCANS;
use crate::plant::Integrator;
use crate::quantity::Acceleration;
use crate::schema::is_default;
use crate::supervision::Restart;
use crate::v2x::{MAX_PROGRAM_PHASES, MAX_SIGNALS, Signal};
use messages::{Service, Topic};

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
    laws::check(scenario)?;
    actors::actors(&scenario.actors)?;
    storyboard::check(scenario)?;
    crate::traffic::event_script::check(&scenario.actors)
}

fn fail<T>(
    path: impl Into<String>,
    message: impl Into<String>,
    expected: impl Into<String>,
) -> Result<T, Problem> {
    Err(Problem::new(path, message, expected))
}

fn multiple(path: &str, value_ms: u32, base: &str, base_ms: u32) -> Result<(), Problem> {
    if value_ms.is_multiple_of(base_ms) {
        return Ok(());
    }
    Err(Problem::new(
        path,
        format!("{path} = {value_ms} is not a whole multiple of {base} = {base_ms}"),
        format!("{path} to be a multiple of {base}"),
    )
    .against(base))
}

fn periods(scenario: &Scenario) -> Result<(), Problem> {
    let plant = scenario.plant.period_ms.value();
    let perception = scenario.perception.period_ms.value();
    let controller = scenario.controller.period_ms.value();
    multiple("perception.period_ms", perception, "plant.period_ms", plant)?;
    multiple("v2x.period_ms", scenario.v2x.period_ms.value(), "plant.period_ms", plant)?;
    if let Some(poll_ms) = scenario.v2x.poll_ms {
        multiple("v2x.poll_ms", poll_ms.value(), "plant.period_ms", plant)?;
    }
    multiple("controller.period_ms", controller, "plant.period_ms", plant)?;
    if scenario.controller.release == Release::Radar {
        multiple("controller.period_ms", controller, "perception.period_ms", perception)?;
    }
    let runtime = &scenario.runtime;
    multiple("runtime.extra_delay_ms", runtime.extra_delay_ms.value(), "plant.period_ms", plant)?;
    multiple("runtime.extra_jitter_ms", runtime.extra_jitter_ms.value(), "plant.period_ms", plant)
}

fn plant(scenario: &Scenario) -> Result<(), Problem> {
    let plant = &scenario.plant;
    let (period, step) = (plant.period_ms.value(), plant.integration_step_ms.value());
    match plant.integrator {
        Integrator::Fine if !period.is_multiple_of(step) => {
            return Err(Problem::new(
                "plant.integration_step_ms",
                format!("a step of {step} ms does not divide plant.period_ms = {period}"),
                "a divisor of the period",
            )
            .against("plant.period_ms"));
        }
        Integrator::PaperEuler => {
            multiple("plant.integration_step_ms", step, "plant.period_ms", period)?;
            let lag_ms = 1e3 * plant.actuator_time_constant_s.value();
            if f64::from(step) > lag_ms {
                return Err(Problem::new(
                    "plant.integration_step_ms",
                    format!("a step of {step} ms is longer than the actuator's time constant"),
                    format!("at most {lag_ms} ms, or the Euler step oscillates"),
                )
                .against("plant.actuator_time_constant_s"));
            }
        }
        Integrator::Fine => {}
    }
    let bounds = (plant.min_acceleration_mps2, plant.max_acceleration_mps2);
    around_zero("plant.min_acceleration_mps2", "plant.max_acceleration_mps2", bounds)?;
    let gateway = &plant.gateway;
    let bounds = (gateway.min_request_mps2, gateway.max_request_mps2);
    around_zero("plant.gateway.min_request_mps2", "plant.gateway.max_request_mps2", bounds)?;
    Ok(())
}

/// The emergency brake needs brakes that deserve the name, and detections to brake for.
fn aebs(scenario: &Scenario) -> Result<(), Problem> {
    let deceleration = scenario.aebs.deceleration_mps2.value();
    if scenario.has_aebs() && deceleration < LEAST_DECELERATION_MPS2 {
        return fail(
            "aebs.deceleration_mps2",
            format!("an emergency brake of {deceleration} m/s² has no authority"),
            format!("at least {LEAST_DECELERATION_MPS2} m/s² (UN R152)"),
        );
    }
    if scenario.aebs.enabled == Some(true) && !scenario.perception.gives_detections() {
        return Err(Problem::new(
            "aebs.enabled",
            "the emergency brake reads the radar's detections, and this radar gives none",
            if scenario.perception.ideal {
                "perception.ideal = false, or aebs.enabled = false"
            } else {
                "perception.radar.model = \"detections\", or aebs.enabled = false"
            },
        ));
    }
    Ok(())
}

/// A standby needs a service, and one that may go on after its process ended.
fn standby(scenario: &Scenario) -> Result<(), Problem> {
    let supervision = &scenario.supervision;
    for service in supervision.standby.services() {
        if !scenario.services().contains(&service) {
            let message = format!("a standby for {service}, which the scenario does not have");
            return fail("supervision.standby", message, "services of the scenario");
        }
        if supervision.restart_of(service) == Restart::Never {
            let message = format!("a standby for {service}, whose end is to end the run");
            let expected = "a restart policy other than \"never\"";
            return fail("supervision.standby", message, expected);
        }
    }
    Ok(())
}

/// The papers' Euler step is that of a car on a level road. Only a truck has a mass of its own.
fn vehicle(scenario: &Scenario) -> Result<(), Problem> {
    let plant = &scenario.plant;
    scenario.road.profile()?;
    if plant.gateway.min_torque_nm >= plant.gateway.max_torque_nm {
        return Err(Problem::new(
            "plant.gateway.min_torque_nm",
            "the smallest torque is not below the largest",
            format!("less than {}", plant.gateway.max_torque_nm.value()),
        )
        .against("plant.gateway.max_torque_nm"));
    }
    if plant.vehicle.is_truck() {
        if plant.integrator == Integrator::PaperEuler {
            return Err(Problem::new(
                "plant.integrator",
                "a truck has no paper's Euler step",
                "`fine`",
            )
            .against("plant.vehicle"));
        }
        return Ok(());
    }
    if !scenario.road.is_level() && plant.integrator == Integrator::PaperEuler {
        let problem = Problem::new("road", "the paper's Euler step has no grade", "no heights");
        return Err(problem.against("plant.integrator"));
    }
    if plant.mass_factor.value() != 1.0 {
        let expected = "plant.vehicle = \"jh6-49t\" or \"jh6-25t\"";
        return fail("plant.mass_factor", "a car has no mass here", expected);
    }
    Ok(())
}

fn around_zero(
    min_path: &str,
    max_path: &str,
    (min, max): (Acceleration, Acceleration),
) -> Result<(), Problem> {
    if min.value() >= 0.0 {
        return fail(min_path, "this bound leaves no way to brake", "a negative number");
    }
    if max.value() <= 0.0 {
        return fail(max_path, "this bound leaves no way to drive", "a positive number");
    }
    Ok(())
}

fn perception(scenario: &Scenario) -> Result<(), Problem> {
    let perception = &scenario.perception;
    let (latency, period) = (perception.radar.latency_ms.value(), perception.period_ms.value());
    multiple("perception.radar.latency_ms", latency, "perception.period_ms", period)?;
    if latency / period > MAX_LATENCY_SCANS {
        return fail(
            "perception.radar.latency_ms",
            format!("{latency} ms are more than {MAX_LATENCY_SCANS} scans"),
            format!("at most {} ms", MAX_LATENCY_SCANS * period),
        );
    }
    let tracker = &perception.tracker;
    if tracker.confirm_hits > tracker.confirm_scans || tracker.confirm_scans.value() > 32 {
        return Err(Problem::new(
            "perception.tracker.confirm_hits",
            format!(
                "{} hits in {} scans",
                tracker.confirm_hits.value(),
                tracker.confirm_scans.value()
            ),
            "at most as many hits as scans, and at most 32 scans",
        )
        .against("perception.tracker.confirm_scans"));
    }
    let selection = &perception.target_selection;
    if selection.leave_half_width_m < selection.enter_half_width_m {
        return Err(Problem::new(
            "perception.target_selection.leave_half_width_m",
            "the path is narrower for leaving than for entering",
            format!("at least {}", selection.enter_half_width_m.value()),
        )
        .against("perception.target_selection.enter_half_width_m"));
    }
    Ok(())
}

fn controller(scenario: &Scenario) -> Result<(), Problem> {
    let controller = &scenario.controller;
    let bounds = (controller.min_request_mps2, controller.max_request_mps2);
    around_zero("controller.min_request_mps2", "controller.max_request_mps2", bounds)?;
    if controller.deadline() > controller.period_ms {
        return Err(Problem::new(
            "controller.deadline_ms",
            "the deadline is longer than the period",
            format!("at most {} ms", controller.period_ms.value()),
        )
        .against("controller.period_ms"));
    }
    Ok(())
}

fn signals(signals: &[Signal]) -> Result<(), Problem> {
    if signals.len() > MAX_SIGNALS {
        return fail(
            "v2x.signals",
            format!("{} signals", signals.len()),
            format!("at most {MAX_SIGNALS}"),
        );
    }
    for (i, signal) in signals.iter().enumerate() {
        let path = format!("v2x.signals.{i}");
        if !(1..=MAX_PROGRAM_PHASES).contains(&signal.program.len()) {
            return fail(
                format!("{path}.program"),
                format!("a program of {} phases", signal.program.len()),
                format!("1 to {MAX_PROGRAM_PHASES} phases"),
            );
        }
        if i > 0 && signals[i - 1].stop_line_m >= signal.stop_line_m {
            return fail(
                format!("{path}.stop_line_m"),
                "this stop line is not ahead of the signal before",
                format!("more than {} m", signals[i - 1].stop_line_m.value()),
            );
        }
        let id = |s: &Signal| (s.intersection_id, s.signal_group);
        if signals[..i].iter().any(|other| id(other) == id(signal)) {
            return fail(
                format!("{path}.intersection_id"),
                "another signal has the same intersection and signal group",
                "a pair of ids of its own",
            );
        }
    }
    Ok(())
}

/// Without frames there is no air and no on-board unit: a fault of theirs would act on nothing.
fn radio(scenario: &Scenario) -> Result<(), Problem> {
    let v2x = &scenario.v2x;
    if v2x.poll_ms.is_some() && !v2x.radio.is_live() {
        let message = "v2x.poll_ms has no effect without frames of other hosts";
        return fail("v2x.poll_ms", message, "v2x.radio to be the address of a live carrier");
    }
    if v2x.radio.carrier().is_some() {
        return carrier(scenario);
    }
    if scenario.has_obu() {
        return Ok(());
    }
    let (air, unit, obu) = (is_default(&v2x.air), is_default(&v2x.unit), is_default(&v2x.obu));
    let origin = is_default(&v2x.origin);
    let unused = [("v2x.origin", origin), ("v2x.air", air), ("v2x.unit", unit), ("v2x.obu", obu)];
    if let Some((table, _)) = unused.into_iter().find(|(_, usual)| !usual) {
        let message = format!("{table} has no effect without frames");
        return fail(table, message, "v2x.radio = \"frames\"");
    }
    let aimed = |fault: &Fault| fault.effect.target() == Target::Topic(Topic::RadioFrames);
    match scenario.faults.iter().position(aimed) {
        Some(index) => fail(
            format!("faults.{index}.topic"),
            "there are no frames on `radio/frames`",
            "v2x.radio = \"frames\"",
        ),
        None => Ok(()),
    }
}

/// Frames of other hosts come through the air that there is, into one process.
fn carrier(scenario: &Scenario) -> Result<(), Problem> {
    if !is_default(&scenario.v2x.air) {
        let message = "the air is simulated for the frames of simulated units alone";
        return Err(Problem::new("v2x.air", message, "v2x.radio = \"frames\"").against("v2x.radio"));
    }
    if scenario.supervision.standby.services().contains(&Service::V2xSim) {
        let message = "two processes of v2x-sim cannot have the radio";
        let problem = Problem::new("supervision.standby", message, "v2x.radio = \"frames\"");
        return Err(problem.against("v2x.radio"));
    }
    Ok(())
}
