//! State that outlives the plant's process: the vehicle, the referee's record and the counts. A report of the state
//! ends the run.

use messages::level::LevelLog;
use messages::{Origin, Service};
use runtime::{Checkpoint, Figures, Group, Runtime, RuntimeError};
use serde::{Deserialize, Serialize};
use std::borrow::Borrow;

use super::Plant;
use super::control::Control;
use crate::brake::{self, Braking};
use crate::chains::{BRAKE_PATH, CONTROL_PATH, Chains};
use crate::referee::Referee;
use crate::report::{ControlFigures, Hops, Outcome, PlantReport};
use crate::signal_chain::SignalChain;
use crate::timeliness::Timeliness;
use crate::truck::Truck;
use crate::{ego, gateway, lateral};

/// The state. It is written by reference, which allocates nothing, and read as values.
#[derive(Serialize, Deserialize)]
pub(super) struct Snapshot<R = Referee, L = LevelLog> {
    step: u64,
    time_s: f64,
    ego: ego::Snapshot,
    gateway: gateway::Kept,
    referee: R,
    request_mps2: f64,
    braking: Option<brake::Snapshot>,
    plane: Option<lateral::State>,
    timeliness: Timeliness,
    last_radar: Option<Origin>,
    undelivered: u64,
    levels: L,
}

/// Figures of a plant that ended, up to the last cycle that it kept; `None` if it kept none. The longest chains died
/// with it.
pub fn last_known(group: &Group) -> Option<PlantReport> {
    let kept: Snapshot = Checkpoint::last(group, Service::Plant)?;
    let figures = Figures::of(group, Service::Plant);
    // Late chains were counted.
    let chains = |path| Chains::open(i64::MAX, path, &figures).ok();
    let (control, brake) = (chains(CONTROL_PATH)?, chains(BRAKE_PATH)?);
    let signals = SignalChain::open(&figures).ok()?;
    Some(kept.report(Outcome::Aborted, &control, Some(&brake), &signals))
}

impl<R: Borrow<Referee>, L: Borrow<LevelLog>> Snapshot<R, L> {
    /// The figures of this state and of its chains. A run without a violation ended as `undisturbed`.
    fn report(
        &self,
        undisturbed: Outcome,
        control: &Chains,
        brake: Option<&Chains>,
        signals: &SignalChain,
    ) -> PlantReport {
        let (referee, timeliness) = (self.referee.borrow(), &self.timeliness);
        let mut histograms = control.histograms();
        histograms.extend(signals.histograms());
        PlantReport {
            outcome: referee.outcome().unwrap_or(undisturbed),
            duration_s: self.time_s,
            control: referee.figures().clone(),
            rungs: self.levels.borrow().report(),
            max_command_gap_us: (timeliness.longest_gap_ns > 0)
                .then_some(timeliness.longest_gap_ns as f64 / 1e3),
            reaction_time_us: control.times.reaction.percentiles_us(),
            data_age_us: control.times.age.percentiles_us(),
            designed_wait_us: control.times.designed_wait.percentiles_us(),
            net_reaction_us: control.times.net_reaction.percentiles_us(),
            hops_us: control.hops_us(),
            worst_chains: control.worst.chains.clone(),
            undelivered_commands: self.undelivered,
            aebs: self.braking.as_ref().map(|braking| braking.figures.clone()),
            brake_reaction_time_us: brake.and_then(|brake| brake.times.reaction.percentiles_us()),
            brake_hops_us: brake.map_or_else(Hops::default, Chains::hops_us),
            signal_reaction_us: signals.whole.percentiles_us(),
            signal_hops_us: signals.hops_us(),
            commands_due: timeliness.due,
            commands_missed: timeliness.missed,
            late_reactions: control.times.late.get(),
            histograms,
        }
    }
}

impl Plant {
    /// Goes on from where the process before this one was.
    pub(super) fn restore(&mut self, runtime: &mut Runtime) {
        let Some(kept) = self.checkpoint.as_mut().and_then(Checkpoint::restore) else { return };
        runtime.resume_after(kept.step);
        self.ego.restore(kept.ego);
        self.world.referee.restore(kept.referee);
        self.control.gateway.kept = kept.gateway;
        self.request_mps2 = kept.request_mps2;
        if let (Some(braking), Some(kept)) = (&mut self.braking, kept.braking) {
            braking.restore(kept);
        }
        if let (Some(plane), Some(kept)) = (&mut self.plane, kept.plane) {
            plane.lateral.state = kept;
        }
        self.levels = kept.levels;
        self.time_s = kept.time_s;
        self.control.timeliness = kept.timeliness;
        self.control.chains.last_radar = kept.last_radar;
        self.control.delivery.undelivered = kept.undelivered;
    }

    fn snapshot(&self, step: u64) -> Snapshot<&Referee, &LevelLog> {
        Snapshot {
            step,
            time_s: self.time_s,
            ego: self.ego.snapshot(),
            gateway: self.control.gateway.kept,
            referee: &self.world.referee,
            request_mps2: self.request_mps2,
            braking: self.braking.as_ref().map(Braking::snapshot),
            plane: self.plane.as_ref().map(|plane| plane.lateral.state),
            timeliness: self.control.timeliness,
            last_radar: self.control.chains.last_radar,
            undelivered: self.control.delivery.undelivered,
            levels: &self.levels,
        }
    }

    pub(super) fn keep(&mut self, step: u64) -> Result<(), RuntimeError> {
        let Some(mut checkpoint) = self.checkpoint.take() else { return Ok(()) };
        let saved = checkpoint.save(&self.snapshot(step));
        self.checkpoint = Some(checkpoint);
        saved
    }

    pub(super) fn report(&self) -> PlantReport {
        let undisturbed = match self.stopped_for_want_of_commands {
            true => Outcome::SafeStop,
            false => Outcome::Completed,
        };
        let brake = self.braking.as_ref().map(|braking| &braking.chains);
        let Control { chains, signal_chain, .. } = &self.control;
        let report = self.snapshot(0).report(undisturbed, chains, brake, signal_chain);
        let truck = self.ego.truck();
        let control = ControlFigures {
            fuel_l_per_100km: truck.and_then(Truck::fuel_l_per_100km),
            gear_shifts: truck.map(Truck::shifts),
            service_brake_s: truck.map(Truck::service_brake_s),
            ..report.control
        };
        PlantReport { control, ..report }
    }
}
