//! The plant's loop: publish the motion, take the newest command, move on.

use crate::chains::{Actuated, Chains};
use crate::ego::Ego;
use crate::gateway::{Actuation, EngineRequest, Gateway, Source};
use crate::referee::{MAX_SIGNALS, Referee, SignalTruth, Violation};
use crate::truck::Truck;
use crate::truth;
use shared::messages::{
    self, Command, Header, Odometry, Origins, PLAN_LEN, Powertrain, ServiceState, VehicleTruth,
};
use shared::report::{ControlFigures, Details, Outcome, PlantReport};
use shared::runtime::{Cycle, Overrun, Publisher, Release, Runtime, RuntimeError, Subscriber};
use shared::scenario::Scenario;
use shared::scenario::v2x::Phase;
use std::collections::VecDeque;

/// Runs the plant in its group, to the end of the run or the first violation.
///
/// # Errors
/// If the group's shared memory is not usable.
pub fn run(mut runtime: Runtime) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let mut plant = Plant::open(&mut runtime, &scenario)?;
    runtime.begin(&scenario)?;
    runtime.run_cycles(|runtime| plant.cycle(runtime))?;
    let report = plant.report();
    runtime.finish(Details::Plant(Box::new(report)))
}

struct Plant {
    ego: Ego,
    gateway: Gateway,
    referee: Referee,
    chains: Chains,
    odometry: Publisher<Odometry>,
    /// From a truck alone.
    powertrain: Option<Publisher<Powertrain>>,
    command: Subscriber<Command>,
    vehicles: Subscriber<VehicleTruth>,
    signals: Subscriber<messages::SignalTruth>,
    extra_delay_ns: i64,
    /// Commands on their way through the extra delay, oldest first.
    delayed: VecDeque<Command>,
    /// Incarnation and sequence number of the last command taken from the topic.
    taken: Option<(u32, u64)>,
    active: Option<Command>,
    request_mps2: f64,
    time_s: f64,
    stopped_for_want_of_commands: bool,
}

impl Plant {
    fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        let extra_ms = scenario.runtime.extra_delay_ms.value();
        let in_flight = extra_ms / scenario.plant.period_ms.value() + 2;
        Ok(Self {
            ego: Ego::new(scenario).map_err(|problem| RuntimeError::Setup(problem.message))?,
            gateway: Gateway::new(&scenario.plant),
            referee: Referee::new(scenario),
            chains: Chains::new(i64::from(scenario.controller.deadline().value()) * 1_000_000),
            odometry: runtime.publisher()?,
            powertrain: (scenario.plant.vehicle.is_truck())
                .then(|| runtime.publisher())
                .transpose()?,
            command: runtime.subscriber()?,
            vehicles: runtime.subscriber()?,
            signals: runtime.subscriber()?,
            extra_delay_ns: i64::from(extra_ms) * 1_000_000,
            delayed: VecDeque::with_capacity(in_flight as usize),
            taken: None,
            active: None,
            request_mps2: scenario.plant.initial_acceleration_mps2.value(),
            time_s: 0.0,
            stopped_for_want_of_commands: false,
        })
    }

    fn cycle(&mut self, runtime: &mut Runtime) -> Result<Cycle, RuntimeError> {
        let Some(release) = runtime.next_release(Overrun::CatchUp) else {
            return Ok(Cycle::Last);
        };
        self.publish(&release)?;
        // The command comes last of all that a step makes wait for.
        runtime.update(&mut self.command)?;
        runtime.update(&mut self.vehicles)?;
        runtime.update(&mut self.signals)?;
        self.time_s = release.time_s;

        let violation = self.judge(&release);
        let actuation = self.actuate(&release, runtime.clock().now_ns());
        self.request_mps2 = actuation.request_mps2;
        self.ego.step(&actuation);

        let state = match actuation.source {
            Source::None | Source::Command | Source::Plan => ServiceState::Running,
            Source::StopInLane | Source::Emergency => ServiceState::Degraded,
        };
        runtime.end_cycle(state)?;
        if violation.is_some() {
            runtime.end_run()?;
        }
        Ok(Cycle::Next)
    }

    fn publish(&mut self, release: &Release) -> Result<(), RuntimeError> {
        let state = self.ego.state();
        let origins = self.active.map_or(Origins::NONE, |command| command.header.origins);
        let header = Header::new(release.step, release.scheduled_ns, origins);
        if let (Some(publisher), Some(truck)) = (&mut self.powertrain, self.ego.truck()) {
            let powertrain = truck.powertrain();
            self.gateway.engine_gives(powertrain.engine_torque_nm);
            publisher.send(Powertrain {
                header,
                gear: powertrain.gear as u32 + 1,
                shifts: powertrain.shifts,
                since_shift_s: powertrain.since_shift_s,
                engine_speed_rpm: powertrain.engine_speed_rpm,
                engine_torque_nm: powertrain.engine_torque_nm,
                service_brake_n: powertrain.service_brake_n,
                fuel_gps: powertrain.fuel_gps,
                fuel_g: powertrain.fuel_g,
                specific_force_mps2: powertrain.specific_force_mps2,
            })?;
        }
        self.odometry.send(Odometry {
            header,
            position_m: state.position_m,
            speed_mps: state.speed_mps,
            acceleration_mps2: state.acceleration_mps2,
            request_mps2: self.request_mps2,
        })
    }

    /// What the referee makes of the state at the release.
    fn judge(&mut self, release: &Release) -> Option<Violation> {
        const DARK: SignalTruth = SignalTruth {
            id: 0,
            stop_line_m: 0.0,
            phase: Phase::Red,
            ends_ns: None,
            next_phase: Phase::Red,
        };
        let mut signals = [DARK; MAX_SIGNALS];
        let count = self.signals.newest().map_or(0, |newest| truth::signals(newest, &mut signals));
        let state = self.ego.state();
        let ahead = (self.vehicles.newest())
            .and_then(|newest| truth::ahead(newest, state.position_m, release.time_s));
        let now_ns = release.scheduled_ns.unsigned_abs();
        self.referee.observe(now_ns, &state, ahead.as_ref(), &signals[..count])
    }

    /// Lets the newest due command act on the actuators.
    fn actuate(&mut self, release: &Release, now_ns: i64) -> Actuation {
        if let Some(command) = self.command.newest() {
            let identity = (command.header.incarnation, command.header.sequence);
            if self.taken != Some(identity) && self.delayed.len() < self.delayed.capacity() {
                self.taken = Some(identity);
                self.delayed.push_back(*command);
            }
        }
        let delay_ns = self.extra_delay_ns;
        let due = |command: &Command| now_ns >= command.header.publish_ns + delay_ns;
        while self.delayed.front().is_some_and(due) {
            let command = self.delayed.pop_front().expect("the front was just seen");
            let plan_len = usize::try_from(command.plan_len).map_or(0, |len| len.min(PLAN_LEN));
            // The plan is moved by the delay with the rest of the command.
            let start_ns = command.header.acquisition_ns + delay_ns;
            let engine = (command.has_torque != 0).then(|| EngineRequest {
                torque_nm: command.engine_torque_nm,
                service_brake_n: command.service_brake_n,
                gear: (command.gear as usize).checked_sub(1),
            });
            let accepted = self.gateway.accept_with_engine(
                release.scheduled_ns.unsigned_abs(),
                start_ns.unsigned_abs(),
                command.plan_period_ns.unsigned_abs(),
                &command.plan_mps2[..plan_len],
                engine,
            );
            if accepted.is_ok() {
                self.active = Some(command);
            }
        }
        if let Some(active) = &self.active {
            let (scheduled_ns, start_ns) = (release.scheduled_ns, release.start_ns);
            self.chains.actuated(active, &Actuated { scheduled_ns, start_ns, now_ns });
        }
        let state = self.ego.state();
        let ahead = (self.vehicles.newest())
            .and_then(|newest| truth::ahead(newest, state.position_m, release.time_s));
        let now_ns = release.scheduled_ns.unsigned_abs();
        let actuation = self.gateway.actuate(now_ns, state.speed_mps, ahead.as_ref());
        let stopping = matches!(actuation.source, Source::StopInLane | Source::Emergency);
        self.stopped_for_want_of_commands = stopping && state.speed_mps == 0.0;
        actuation
    }

    fn report(&self) -> PlantReport {
        let outcome = match self.referee.violation() {
            Some(Violation::Collision { .. }) => Outcome::Collision,
            Some(Violation::RedLight { .. }) => Outcome::RedLight,
            None if self.stopped_for_want_of_commands => Outcome::SafeStop,
            None => Outcome::Completed,
        };
        let truck = self.ego.truck();
        let control = ControlFigures {
            fuel_l_per_100km: truck.and_then(Truck::fuel_l_per_100km),
            gear_shifts: truck.map(Truck::shifts),
            service_brake_s: truck.map(Truck::service_brake_s),
            ..self.referee.figures().clone()
        };
        PlantReport {
            outcome,
            duration_s: self.time_s,
            control,
            reaction_time_us: self.chains.reaction_us(),
            data_age_us: self.chains.age_us(),
            designed_wait_us: self.chains.designed_wait_us(),
            net_reaction_us: self.chains.net_reaction_us(),
            hops_us: self.chains.hops_us(),
            worst_chains: self.chains.worst().report(),
        }
    }
}
