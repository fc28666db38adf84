//! State that outlives the plant's process: the vehicle, the referee's record and the counts. A report of the state
//! ends the run.

use messages::level::LevelLog;
use messages::{Origin, Service};
use runtime::{Checkpoint, Group, Runtime, RuntimeError, ServiceCounts};
use serde::{Deserialize, Serialize};

use super::Plant;
use super::plane::Plane;
use crate::braking::{self, Braking};
use crate::referee::{Referee, Violation};
use crate::report::{ControlFigures, Outcome, PlantReport};
use crate::timeliness::Timeliness;
use crate::truck::Truck;
use crate::{ego, gateway, lateral, times};

/// The state as it is read.
#[derive(Deserialize)]
pub(super) struct Snapshot {
    step: u64,
    ego: ego::Snapshot,
    gateway: gateway::Snapshot,
    referee: Referee,
    request_mps2: f64,
    braking: Option<braking::Snapshot>,
    plane: Option<lateral::State>,
    counted: Counted,
    levels: LevelLog,
}

/// The same by reference, field by field: to write it allocates nothing.
#[derive(Serialize)]
struct Keeping<'a> {
    step: u64,
    ego: ego::Snapshot,
    gateway: gateway::Snapshot,
    referee: &'a Referee,
    request_mps2: f64,
    braking: Option<braking::Snapshot>,
    plane: Option<lateral::State>,
    counted: Counted,
    levels: &'a LevelLog,
}

/// Counts that go on over all processes of the plant.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct Counted {
    time_s: f64,
    timeliness: Timeliness,
    last_radar: Option<Origin>,
    longest_gap_ns: i64,
    undelivered: u64,
}

/// Figures of a plant that ended, up to the last cycle that it kept; `None` if it kept none.
#[must_use]
pub fn last_known(group: &Group) -> Option<PlantReport> {
    let kept: Snapshot = Checkpoint::last(group, Service::Plant)?;
    let outcome = match kept.referee.violation() {
        Some(Violation::Collision { .. }) => Outcome::Collision,
        Some(Violation::RedLight { .. }) => Outcome::RedLight,
        None => Outcome::Aborted,
    };
    let counted = kept.counted;
    let counts = ServiceCounts::of(group, Service::Plant);
    let figures = counts.figures();
    let times = times::last(outcome, figures).unwrap_or_else(|_| PlantReport::empty(outcome));
    Some(PlantReport {
        outcome,
        duration_s: counted.time_s,
        control: kept.referee.figures().clone(),
        rungs: kept.levels.report(),
        max_command_gap_us: (counted.longest_gap_ns > 0)
            .then_some(counted.longest_gap_ns as f64 / 1e3),
        undelivered_commands: counted.undelivered,
        commands_due: counted.timeliness.due(),
        commands_missed: counted.timeliness.missed(),
        aebs: kept.braking.map(|braking| braking.figures),
        ..times
    })
}

impl Plant {
    /// Goes on from where the process before this one was.
    pub(super) fn restore(&mut self, runtime: &mut Runtime) {
        let Some(kept) = self.checkpoint.as_mut().and_then(Checkpoint::restore) else { return };
        runtime.resume_after(kept.step);
        self.ego.restore(kept.ego);
        self.referee.restore(kept.referee);
        self.gateway.restore(&kept.gateway);
        self.request_mps2 = kept.request_mps2;
        if let (Some(braking), Some(kept)) = (&mut self.braking, kept.braking) {
            braking.restore(kept);
        }
        if let (Some(plane), Some(kept)) = (&mut self.plane, kept.plane) {
            plane.restore(&kept);
        }
        self.levels = kept.levels;
        self.time_s = kept.counted.time_s;
        self.timeliness = kept.counted.timeliness;
        self.chains.restore(kept.counted.last_radar);
        self.longest_gap_ns = kept.counted.longest_gap_ns;
        self.delivery.restore(kept.counted.undelivered);
    }

    pub(super) fn keep(&mut self, step: u64) -> Result<(), RuntimeError> {
        let Some(checkpoint) = &mut self.checkpoint else { return Ok(()) };
        checkpoint.save(&Keeping {
            step,
            ego: self.ego.snapshot(),
            gateway: self.gateway.snapshot(),
            referee: &self.referee,
            request_mps2: self.request_mps2,
            braking: self.braking.as_ref().map(Braking::snapshot),
            plane: self.plane.as_ref().map(Plane::state),
            counted: Counted {
                time_s: self.time_s,
                timeliness: self.timeliness,
                last_radar: self.chains.last_radar(),
                longest_gap_ns: self.longest_gap_ns,
                undelivered: self.delivery.undelivered(),
            },
            levels: &self.levels,
        })
    }

    pub(super) fn report(&self) -> PlantReport {
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
        let brake = self.braking.as_ref().map(Braking::chains);
        PlantReport {
            outcome,
            duration_s: self.time_s,
            control,
            rungs: self.levels.report(),
            max_command_gap_us: (self.longest_gap_ns > 0)
                .then_some(self.longest_gap_ns as f64 / 1e3),
            undelivered_commands: self.delivery.undelivered(),
            aebs: self.braking.as_ref().map(|braking| braking.figures().clone()),
            commands_due: self.timeliness.due(),
            commands_missed: self.timeliness.missed(),
            ..times::report(outcome, &self.chains, brake, &self.signal_chain)
        }
    }
}
