//! The plant's loop: publish the motion, take the newest command, move on.

use crate::brake::Braking;
use crate::ego::Ego;
use crate::gateway::Source;
use crate::unit_car::{Moment, UnitCar};
use messages::level::{Level, LevelLog};
use messages::{BrakeState, EgoTruth, Odometry, Powertrain, ServiceState};
use runtime::{Checkpoint, Cycle, Mode, Overrun, Publisher, Release, Runtime, RuntimeError};
use scenario::Scenario;
use std::time::Duration;

mod control;
mod plane;
mod survival;
mod world;

use control::Control;
use plane::Plane;
use survival::Snapshot;
pub use survival::last_known;
use world::World;

/// Runs the plant in its group to the end of the run or its storyboard, or to the first violation.
///
/// # Errors
/// If the group's shared memory is not usable.
pub fn run(mut runtime: Runtime) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let mut plant = Plant::open(&mut runtime, &scenario)?;
    runtime.begin(&scenario)?;
    if let (Mode::Realtime, Some(unit)) = (runtime.clock().mode, plant.ego.unit()) {
        unit.program.lend(&scenario);
    }
    if runtime.is_restarted() {
        plant.restore(&mut runtime);
    }
    runtime.run_cycles(|runtime| plant.cycle(runtime))?;
    if let Some(note) = plant.ego.unit().and_then(UnitCar::note) {
        // The launcher reads it in front of the report, and prints it.
        println!("{note}");
    }
    let report = plant.report();
    runtime.finish(report)
}

struct Plant {
    ego: Ego,
    control: Control,
    world: World,
    braking: Option<Braking>,
    /// On a road with a plan.
    plane: Option<Plane>,
    odometry: Publisher<Odometry>,
    truth: Publisher<EgoTruth>,
    /// From a truck alone.
    powertrain: Option<Publisher<Powertrain>>,
    request_mps2: f64,
    time_s: f64,
    /// Longest wait for the answer of a unit in real time.
    half_period: Duration,
    stopped_for_want_of_commands: bool,
    levels: LevelLog,
    /// State from which a restarted plant continues, in realtime.
    checkpoint: Option<Checkpoint<Snapshot>>,
}

impl Plant {
    fn open(runtime: &mut Runtime, scenario: &Scenario) -> Result<Self, RuntimeError> {
        let is_truck = scenario.plant.vehicle.is_truck();
        Ok(Self {
            ego: Ego::new(scenario)?,
            control: Control::open(runtime, scenario)?,
            world: World::open(runtime, scenario)?,
            braking: Braking::open(runtime, scenario)?,
            plane: Plane::open(runtime, scenario)?,
            odometry: runtime.publisher()?,
            truth: runtime.publisher()?,
            powertrain: is_truck.then(|| runtime.publisher()).transpose()?,
            request_mps2: scenario.plant.initial_acceleration_mps2.value(),
            time_s: 0.0,
            half_period: Duration::from_millis(scenario.plant.period_ms.value().into()) / 2,
            stopped_for_want_of_commands: false,
            levels: LevelLog::default(),
            checkpoint: match runtime.clock().mode {
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
        runtime.update(&mut self.control.command)?;
        self.world.update(runtime)?;
        if let Some(braking) = &mut self.braking {
            runtime.update(&mut braking.topic)?;
        }
        if let Some(plane) = &mut self.plane {
            plane.update(runtime)?;
        }
        self.time_s = release.time_s;
        let before = self.ego.state();
        if let Some(signals) = self.world.signals() {
            self.control.signal_chain.look(signals, before.position_m);
        }

        let violation = self.world.judge(&release, &before, self.plane.as_ref());
        let clear = self.world.is_clear(&release, &before);
        let now_ns = runtime.clock().now_ns();
        let actuation = self.control.actuate(&release, now_ns);
        let stops = actuation.source == Source::StopInLane;
        self.stopped_for_want_of_commands = stops && before.speed_mps == 0.0;
        self.request_mps2 = actuation.request_mps2;
        let ceiling = (self.braking.as_mut())
            .and_then(|braking| braking.act(&release, now_ns, before.acceleration_mps2));
        let left = match runtime.clock().mode {
            Mode::Lockstep => None,
            Mode::Realtime => Some(self.half_period),
        };
        self.ego.step(&actuation, ceiling, Moment { time_s: release.time_s, left })?;
        if let Some(plane) = &mut self.plane {
            plane.step(&before, &mut self.ego);
        }
        self.keep(release.step)?;
        self.control.chains.count();
        if let Some(braking) = &mut self.braking {
            braking.chains.count();
        }
        self.levels.observe(release.time_s, self.level(&release, actuation.source));
        if runtime.is_to_stop() {
            self.control.gateway.stop();
        }

        let state = if stops { ServiceState::Degraded } else { ServiceState::Running };
        runtime.end_cycle(state)?;
        let brought_to_a_stop = runtime.is_to_stop() && self.stopped_for_want_of_commands;
        let ended = self.world.vehicles().is_some_and(|others| others.ended);
        if violation.is_some() || brought_to_a_stop || ended || clear {
            runtime.end_run()?;
        }
        Ok(Cycle::Next)
    }

    fn level(&self, release: &Release, source: Source) -> Level {
        let commanded = self.control.gateway.is_commanded(release.scheduled_ns.unsigned_abs());
        match (self.braking.as_ref().map(|braking| braking.account.state), source) {
            (Some(BrakeState::Braking | BrakeState::Holding), _) => Level::Emergency,
            (_, Source::StopInLane) => Level::StopInLane,
            (_, Source::Plan) if !commanded => Level::PlanFollowed,
            (Some(BrakeState::Blind), _) => Level::AebsLost,
            (_, Source::None | Source::Command | Source::Plan) => Level::Full,
        }
    }

    fn publish(&mut self, release: &Release) -> Result<(), RuntimeError> {
        let state = self.ego.state();
        let header = self.control.header(release);
        if let (Some(publisher), Some(truck)) = (&mut self.powertrain, self.ego.truck()) {
            let powertrain = truck.powertrain();
            self.control.gateway.engine_gives(powertrain.engine_torque_nm);
            publisher.send_with(|message: &mut Powertrain| {
                *message = Powertrain { header, ..powertrain };
            })?;
        }
        let request_mps2 = self.request_mps2;
        let truth = EgoTruth { header, request_mps2, ..self.world.around(release, &state) };
        self.truth.send_with(|message: &mut EgoTruth| *message = truth)?;
        self.odometry.send_with(|message: &mut Odometry| {
            message.header = header;
            message.position_m = state.position_m;
            message.speed_mps = state.speed_mps;
            message.acceleration_mps2 = state.acceleration_mps2;
            message.request_mps2 = request_mps2;
        })?;
        self.plane.as_mut().map_or(Ok(()), |plane| plane.publish(header, &state))
    }
}
