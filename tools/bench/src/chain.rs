//! The four services with the 100-step problem in their loop, and a metronome beside them.

use super::peer::Outcome;
use super::plan::Cell;
use super::stage::Stage;
use super::statistics::Events;
use report::summary::{self, Summary, Timing};
use runtime::Mode;
use runtime::statistics::Latencies;
use scenario::Setting;
use std::time::{Duration, Instant};
use supervise::{Ended, Error, GroupOptions, ScenarioOptions};

/// The CACC paper's scenario A: the signal is ahead during its first four seconds.
const SCENARIO: &str = "cacc-a";
/// Prediction step of the paper, ms, for every period of the controller.
const PREDICTION_STEP_MS: u32 = 100;
/// Time in which the group must be ready, s.
const READY_TIMEOUT_S: f64 = 20.0;

/// Measurements of a group and its metronome during the same seconds. Without the cell's conditions the group has
/// no figures.
pub struct Chain {
    pub timing: Timing,
    /// The group's histograms, by name.
    pub histograms: Vec<(String, Latencies)>,
    pub floor: Outcome,
    pub refused: Vec<String>,
    /// True if every process ran under the cell's conditions.
    pub as_asked: bool,
}

impl Chain {
    /// Late releases of a reference process. It sleeps, then computes for the law's median time, on the controller's
    /// core during the same seconds. A release that ends after the controller's deadline is late.
    pub fn floor_events(&self) -> Option<Events> {
        let slack_us = self.timing.deadline_us? - self.timing.solve_us?.p50;
        let slack_ns = (slack_us.max(0.0) * 1e3) as u64;
        let Outcome { latencies, cycles, .. } = &self.floor;
        Some(Events { events: latencies.count_above_ns(slack_ns), cycles: *cycles })
    }
}

/// Runs the group for `seconds` under the cell's conditions.
pub fn run(stage: &Stage, cell: &Cell, seconds: f64) -> Result<Chain, Error> {
    let begun = Instant::now();
    let scenario = supervise::open(SCENARIO, &options(stage, cell, seconds))?;
    let group =
        GroupOptions { programs: Vec::new(), ready_timeout: READY_TIMEOUT_S, processes: true };
    let metronome = stage.metronome(cell.conditions, cell.period_us)?;
    let length_ns = Duration::from_secs_f64(seconds).as_nanos();
    // From the start to the scheduled end, the metronome counts the same conditions as the group.
    let result = supervise::drive(&scenario, Mode::Realtime, &group, None, &mut |moment| {
        let time_ns = moment.time_ns;
        metronome.count(time_ns > 0 && u128::from(time_ns.unsigned_abs()) < length_ns);
    });
    let floor = metronome.finish()?;
    let outcome = result?;
    match &outcome.ended {
        Ended::Interrupted => return Err(Error::Interrupted),
        Ended::Orderly => Ok(()),
        Ended::Broken { service, how: what } => Err((*service, what.clone())),
        Ended::GivenUp { service, .. } => Err((*service, "ended too often".to_owned())),
    }
    .map_err(|(service, what)| Error::NotReady { service, what, foreign: false })?;
    let summary = Summary::new(&scenario, Mode::Realtime, &outcome, begun.elapsed());
    let granted = summary.services.iter().filter_map(|service| service.scheduling.as_ref());
    let as_asked = granted.clone().all(|granted| granted.granted == granted.requested)
        && floor.granted.granted == floor.granted.requested;
    let refused = granted.chain([&floor.granted]).flat_map(|g| &g.refused).cloned().collect();
    let (timing, histograms) = match as_asked {
        true => (summary.timing, summary::histograms(&outcome)),
        false => Default::default(),
    };
    Ok(Chain { timing, histograms, floor, refused, as_asked })
}

fn options(stage: &Stage, cell: &Cell, seconds: f64) -> ScenarioOptions {
    let period_ms = cell.period_us as i64 / 1000;
    let scheduling = cell.conditions.scheduling.name();
    // Radar and plant are released at the same instants: on one core one waits for the other.
    let (radar, controller) = stage.placed(cell.conditions.placement);
    let [radar, controller] = [radar, controller].map(|core| core as i64);
    ScenarioOptions {
        duration: Some(seconds.into()),
        set: vec![
            // The plant must read commands as often as the fastest controller sends them.
            Setting::new("plant.period_ms", 1),
            Setting::new("perception.period_ms", period_ms),
            Setting::new("controller.period_ms", period_ms),
            Setting::new("controller.prediction_step_ms", PREDICTION_STEP_MS),
            // A service without the processor for a while is a figure here, not a fault.
            Setting::new("supervision.restart", "never"),
            Setting::new("supervision.heartbeat_timeout_ms", 10_000),
            Setting::new("runtime.scheduling", scheduling),
            Setting::new("runtime.services.plant.core", controller),
            Setting::new("runtime.services.perception-sim.core", radar),
            Setting::new("runtime.services.v2x-sim.core", radar),
            Setting::new("runtime.services.controller.core", controller),
        ],
        ..ScenarioOptions::default()
    }
}
