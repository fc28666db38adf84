//! The plant's loop: publish the motion, take the newest command, move on.

use crate::braking::Braking;
use crate::chains::Chains;
use crate::clear::ClearWatch;
use crate::delivery::{Arrival, Delivery};
use crate::ego::Ego;
use crate::gateway::{Actuation, EngineRequest, Gateway, Source};
use crate::numbers::Numbers;
use crate::parts::Actuated;
use crate::referee::{MAX_SIGNALS, Referee, SignalTruth, Violation};
use crate::signal_chain::SignalChain;
use crate::surroundings::Surroundings;
use crate::timeliness::Timeliness;
use crate::times::CONTROL_PATH;
use crate::truth;
use messages::level::{Level, LevelLog};
use messages::{
    self, BrakeState, Command, EgoTruth, Header, Odometry, Origins, PLAN_LEN, Powertrain,
    ServiceState,
};
use runtime::{
    Checkpoint, Cycle, Mode, Overrun, Publisher, Release, Runtime, RuntimeError, Subscriber,
};
use scenario::Scenario;
use scenario::v2x::Phase;

mod others;
mod plane;
mod survival;

use others::Others;
use plane::Plane;
use survival::Snapshot;
pub use survival::last_known;

/// Filler for unused signal slots.
const DARK: SignalTruth = SignalTruth {
    id: 0,
    stop_line_m: 0.0,
    phase: Phase::Red,
    ends_ns: None,
    next_phase: Phase::Red,
};

/// Runs the plant in its group to the end of the run or its storyboard, or to the first violation.
///
/// # Errors
/// If the group's shared memory is not usable.
pub fn run(mut runtime: Runtime) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let mut plant = Plant::open(&mut runtime, &scenario)?;
    runtime.begin(&scenario)?;
    if runtime.is_restarted() {
        plant.restore(&mut runtime);
    }
    runtime.run_cycles(|runtime| plant.cycle(runtime))?;
    let report = plant.report();
    runtime.finish(report)
}

struct Plant {
    ego: Ego,
    gateway: Gateway,
    referee: Referee,
    /// Set in a run that ends when the ego is clear of all others.
    clear: Option<ClearWatch>,
    chains: Chains,
    signal_chain: SignalChain,
    odometry: Publisher<Odometry>,
    truth: Publisher<EgoTruth>,
    surroundings: Surroundings,
    /// From a truck alone.
    powertrain: Option<Publisher<Powertrain>>,
    command: Subscriber<Command>,
    others: Others,
    signals: Subscriber<messages::SignalTruth>,
    /// Room for the signals as the referee watches them.
    shown: [SignalTruth; MAX_SIGNALS],
    braking: Option<Braking>,
    /// On a road with a plan.
    plane: Option<Plane>,
    delivery: Delivery,
    timeliness: Timeliness,
    active: Option<Command>,
    request_mps2: f64,
    time_s: f64,
    stopped_for_want_of_commands: bool,
    levels: LevelLog,
    /// Run time at which the last command was accepted, and the longest time between two, ns.
    accepted_ns: Option<i64>,
    longest_gap_ns: i64,
    /// State from which a restarted plant continues, in realtime.
    checkpoint: Option<Checkpoint<Snapshot>>,
}

impl Plant {
    fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        Ok(Self {
            ego: Ego::new(scenario)?,
            gateway: Gateway::new(&scenario.plant),
            referee: Referee::new(scenario),
            clear: ClearWatch::of(scenario),
            chains: Chains::open(
                i64::from(scenario.controller.deadline().value()) * 1_000_000,
                CONTROL_PATH,
                runtime.figures(),
            )?,
            signal_chain: SignalChain::open(runtime.figures())?,
            odometry: runtime.publisher()?,
            truth: runtime.publisher()?,
            surroundings: Surroundings::new(scenario, &Numbers::DEFAULT),
            powertrain: (scenario.plant.vehicle.is_truck())
                .then(|| runtime.publisher())
                .transpose()?,
            command: runtime.subscriber()?,
            others: Others::open(runtime, scenario)?,
            signals: runtime.subscriber()?,
            shown: [DARK; MAX_SIGNALS],
            braking: Braking::open(runtime, scenario)?,
            plane: Plane::open(runtime, scenario)?,
            delivery: Delivery::new(scenario),
            timeliness: Timeliness::new(
                i64::from(scenario.controller.period_ms.value()) * 1_000_000,
                i64::from(scenario.controller.deadline().value()) * 1_000_000,
            ),
            active: None,
            request_mps2: scenario.plant.initial_acceleration_mps2.value(),
            time_s: 0.0,
            stopped_for_want_of_commands: false,
            levels: LevelLog::default(),
            accepted_ns: None,
            longest_gap_ns: 0,
            checkpoint: match runtime.clock().mode() {
                Mode::Realtime => Some(runtime.checkpoint()?),
                Mode::Lockstep => None,
            },
        })
    }

    fn cycle(&mut self, runtime: &mut Runtime) -> Result<Cycle, RuntimeError> {
        let Some(release) = runtime.next_release(Overrun::CatchUp)? else {
            return Ok(Cycle::Last);
        };
        self.publish(&release)?;
        // The command comes last of all that a step makes wait for.
        runtime.update(&mut self.command)?;
        self.others.update(runtime)?;
        runtime.update(&mut self.signals)?;
        if let Some(braking) = &mut self.braking {
            braking.update(runtime)?;
        }
        if let Some(plane) = &mut self.plane {
            plane.update(runtime)?;
        }
        self.time_s = release.time_s;
        if let Some(signals) = self.signals.newest() {
            self.signal_chain.look(signals, self.ego.state().position_m);
        }

        let violation = self.judge(&release);
        let clear = self.is_clear(&release);
        let now_ns = runtime.clock().now_ns();
        let actuation = self.actuate(&release, now_ns);
        self.request_mps2 = actuation.request_mps2;
        let acceleration_mps2 = self.ego.state().acceleration_mps2;
        let ceiling = (self.braking.as_mut())
            .and_then(|braking| braking.act(&release, now_ns, acceleration_mps2));
        let before = self.ego.state();
        self.ego.step(&actuation, ceiling);
        if let Some(plane) = &mut self.plane {
            plane.step(&before, &mut self.ego);
        }
        self.keep(release.step)?;
        self.chains.count();
        if let Some(braking) = &mut self.braking {
            braking.count();
        }
        self.levels.observe(release.time_s, self.level(&release, actuation.source));
        if runtime.is_to_stop() {
            self.gateway.stop();
        }

        let state = match actuation.source {
            Source::None | Source::Command | Source::Plan => ServiceState::Running,
            Source::StopInLane => ServiceState::Degraded,
        };
        runtime.end_cycle(state)?;
        let brought_to_a_stop = runtime.is_to_stop() && self.stopped_for_want_of_commands;
        let ended = self.others.newest().is_some_and(|others| others.ended);
        if violation.is_some() || brought_to_a_stop || ended || clear {
            runtime.end_run()?;
        }
        Ok(Cycle::Next)
    }

    fn level(&self, release: &Release, source: Source) -> Level {
        let commanded = self.gateway.is_commanded(release.scheduled_ns.unsigned_abs());
        match (self.braking.as_ref().map(Braking::state), source) {
            (Some(BrakeState::Braking | BrakeState::Holding), _) => Level::Emergency,
            (_, Source::StopInLane) => Level::StopInLane,
            (_, Source::Plan) if !commanded => Level::PlanFollowed,
            (Some(BrakeState::Blind), _) => Level::AebsLost,
            (_, Source::None | Source::Command | Source::Plan) => Level::Full,
        }
    }

    fn publish(&mut self, release: &Release) -> Result<(), RuntimeError> {
        let state = self.ego.state();
        let origins = self.active.as_ref().map_or(Origins::NONE, |active| active.header.origins);
        let header = Header::new(release.step, release.scheduled_ns, origins);
        if let (Some(publisher), Some(truck)) = (&mut self.powertrain, self.ego.truck()) {
            let powertrain = truck.powertrain();
            self.gateway.engine_gives(powertrain.engine_torque_nm);
            publisher.send_with(|message: &mut Powertrain| {
                message.header = header;
                message.gear = powertrain.gear as u32 + 1;
                message.shifts = powertrain.shifts;
                message.since_shift_s = powertrain.since_shift_s;
                message.engine_speed_rpm = powertrain.engine_speed_rpm;
                message.engine_torque_nm = powertrain.engine_torque_nm;
                message.service_brake_n = powertrain.service_brake_n;
                message.fuel_gps = powertrain.fuel_gps;
                message.fuel_g = powertrain.fuel_g;
                message.specific_force_mps2 = powertrain.specific_force_mps2;
            })?;
        }
        let request_mps2 = self.request_mps2;
        let meets = self.surroundings.of(
            &state,
            release.time_s,
            self.others.newest(),
            self.signals.newest(),
        );
        self.truth.send_with(|message: &mut EgoTruth| {
            message.header = header;
            message.position_m = state.position_m;
            message.speed_mps = state.speed_mps;
            message.acceleration_mps2 = state.acceleration_mps2;
            message.request_mps2 = request_mps2;
            message.time_to_collision_s = meets.time_to_collision_s;
            (message.stop_line_m, message.signal_state) = (meets.stop_line_m, meets.signal_state);
            message.cut_in = meets.cut_in.into();
        })?;
        self.odometry.send_with(|message: &mut Odometry| {
            message.header = header;
            message.position_m = state.position_m;
            message.speed_mps = state.speed_mps;
            message.acceleration_mps2 = state.acceleration_mps2;
            message.request_mps2 = request_mps2;
        })?;
        self.plane.as_mut().map_or(Ok(()), |plane| plane.publish(header, &state))
    }

    /// Verdict of the referee on the state at the release.
    fn judge(&mut self, release: &Release) -> Option<Violation> {
        let newest = self.signals.newest();
        let count = newest.map_or(0, |newest| truth::signals(newest, &mut self.shown));
        let state = self.ego.state();
        let ahead = (self.others.newest())
            .and_then(|newest| self.surroundings.ahead(newest, state.position_m, release.time_s));
        let now_ns = release.scheduled_ns.unsigned_abs();
        let in_plane =
            (self.plane.as_ref()).map(|plane| plane.sample(release, &state, self.others.newest()));
        let shown = &self.shown[..count];
        self.referee.observe_in_plane(now_ns, &state, ahead.as_ref(), shown, in_plane.as_ref())
    }

    /// True if the run ends because the ego is clear of all others.
    fn is_clear(&mut self, release: &Release) -> bool {
        let (Some(clear), Some(others)) = (&mut self.clear, self.others.newest()) else {
            return false;
        };
        clear.observe(release.scheduled_ns, &self.ego.state(), others)
    }

    /// Lets the newest due command act on the actuators.
    fn actuate(&mut self, release: &Release, now_ns: i64) -> Actuation {
        if let Some(command) = self.command.newest() {
            self.delivery.take(command, now_ns);
        }
        if let Some(arrival) = self.delivery.arrived(now_ns) {
            let released_ns = arrival.released_ns(now_ns);
            let Arrival { command, delay_ns, is_repeated, .. } = arrival;
            let plan_len = usize::try_from(command.plan_len).map_or(0, |len| len.min(PLAN_LEN));
            let plan_len = if is_repeated { 0 } else { plan_len };
            if plan_len > 0 {
                self.timeliness.arrived(released_ns);
            }
            // The plan is moved by the delay with the rest of the command.
            let start_ns = released_ns + delay_ns;
            let engine = (command.has_torque != 0).then(|| EngineRequest {
                torque_nm: command.engine_torque_nm,
                service_brake_n: command.service_brake_n,
                gear: (command.gear as usize).checked_sub(1),
            });
            let accepted = self.gateway.accept(
                release.scheduled_ns.unsigned_abs(),
                start_ns.unsigned_abs(),
                command.plan_period_ns.unsigned_abs(),
                &command.plan_mps2[..plan_len],
                engine,
            );
            if accepted.is_ok() {
                if let Some(last_ns) = self.accepted_ns.replace(now_ns) {
                    self.longest_gap_ns = self.longest_gap_ns.max(now_ns - last_ns);
                }
                self.active = Some(command);
            }
        }
        self.timeliness.judge(release.scheduled_ns);
        if let Some(active) = &self.active {
            let (scheduled_ns, start_ns) = (release.scheduled_ns, release.start_ns);
            self.chains.actuated(active, &Actuated { scheduled_ns, start_ns, now_ns });
            self.signal_chain.actuated(active, now_ns);
        }
        let actuation = self.gateway.actuate(release.scheduled_ns.unsigned_abs());
        let stopping = actuation.source == Source::StopInLane;
        self.stopped_for_want_of_commands = stopping && self.ego.state().speed_mps == 0.0;
        actuation
    }
}
