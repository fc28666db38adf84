//! `summary.json`: stable names for what a run measured. A figure that does not apply is null.

mod aebs;
mod host;
mod radio;

pub use aebs::{Aebs, braked};
pub use host::Host;

use crate::following::Following;
use crate::trip::Trip;
use group::{Drive, Ended, FaultRecord, GroupOutcome, Heartbeats, RecordingSummary, StandbyCost};
use messages::Service;
use messages::e2e::Outcomes;
use messages::level::Levels;
use runtime::report::{
    CheckReport, ControlFigures, ControllerReport, Details, Hops, LinkReport, ModeChange,
    ObuReport, Outcome, PerceptionReport, PlanningReport, PlantReport, ProgramReport,
    ReceivedTopic, ServiceReport, SignalHops, WorstChain,
};
use runtime::scheduling::Granted;
use runtime::statistics::{Latencies, Percentiles};
use runtime::{Carrier, Mode, Program};
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::Duration;

/// The summary of one run.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Version of these keys: it goes up when one changes its name or meaning.
    pub schema_version: u32,
    /// Name of the scenario.
    pub scenario: String,
    /// Name of the control law.
    pub controller: String,
    /// A word of caution about the law, such as "uncertified"; left out where none is needed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub caution: Option<&'static str>,
    /// Clock: `realtime` or `lockstep`.
    pub mode: &'static str,
    /// What carried the messages.
    pub carrier: Carrier,
    /// Seed of every random draw of the run.
    pub seed: u64,
    /// How the run ended.
    pub outcome: Outcome,
    /// Why the outcome is `aborted`.
    pub aborted_because: Option<String>,
    /// Run time reached, s: simulated time in lockstep.
    pub duration_s: f64,
    /// Time on the wall clock from the first spawn until all processes were gone, s.
    pub wall_s: f64,
    /// From the first spawn until all services were ready, ms.
    pub ready_ms: f64,
    /// Simulated time over the wall time since the start instant.
    pub simulated_per_wall: Option<f64>,
    /// Figures of the drive, from ground truth.
    pub control: Control,
    /// Latencies, jitter and deadlines.
    pub timing: Timing,
    /// Counts of each topic, by its name.
    pub messages: BTreeMap<String, TopicCounts>,
    /// What the emergency brake did.
    pub aebs: Aebs,
    /// How well the radar's tracks matched the traffic.
    pub perception: Option<PerceptionReport>,
    /// What the on-board unit made of the frames on air; null where signals come as structs.
    pub radio: Option<ObuReport>,
    /// What came of the frames between the vehicle and other hosts; null where all units were simulated.
    pub link: Option<LinkReport>,
    /// What became of the recording; null if none was asked for.
    pub recording: Option<RecordingSummary>,
    /// Faults in order of time, with what became of each.
    pub faults: Vec<FaultRecord>,
    /// The ways of controller and plant on the degradation ladder.
    pub rungs: BTreeMap<&'static str, Levels>,
    /// What the checks of the controller's inputs found.
    pub checks: Vec<CheckReport>,
    /// The processes of the group.
    pub services: Vec<ServiceSummary>,
    /// The machine.
    pub host: Host,
}

/// Figures of the drive.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Control {
    /// What the referee measured on ground truth.
    #[serde(flatten)]
    pub figures: ControlFigures,
    /// Time gaps behind the vehicle ahead.
    #[serde(flatten)]
    pub following: Following,
    /// The way through the signals.
    #[serde(flatten)]
    pub trip: Trip,
    /// Changes of the law's mode; null if the controller made no report.
    pub mode_changes: Option<Vec<ModeChange>>,
}

/// Latencies, jitter and deadlines. Durations are in µs; a figure without samples is null.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Timing {
    /// Cycles of the controller.
    pub cycles: Option<u64>,
    /// Deadline of a control cycle after its scheduled release, µs.
    pub deadline_us: Option<f64>,
    /// Control cycles that ended after their deadline, and releases left out; null in lockstep.
    pub deadline_misses: Option<u64>,
    /// Radar acquisition to the first actuation that uses it, µs.
    pub reaction_time_us: Option<Percentiles>,
    /// Age of the radar data behind every actuation, µs.
    pub data_age_us: Option<Percentiles>,
    /// Age of the signal timing (`v2x/spat`) behind the control cycles, µs; null where there was none.
    pub signal_age_us: Option<Percentiles>,
    /// Actual minus scheduled begin of the control cycles, µs.
    pub release_jitter_us: Option<Percentiles>,
    /// Time inside the control law, µs, on the wall clock in both modes.
    pub solve_us: Option<Percentiles>,
    /// The designed waits of the reaction time, µs.
    pub designed_wait_us: Option<Percentiles>,
    /// The reaction time without its designed waits, µs.
    pub net_reaction_us: Option<Percentiles>,
    /// The parts of the reaction time, µs.
    pub hops_us: Hops,
    /// The chains with the longest reaction times, longest first.
    pub worst_chains: Vec<WorstChain>,
    /// A signal's change to the first actuation that knows of it, µs; null where no signal ahead changed.
    pub signal_reaction_us: Option<Percentiles>,
    /// The parts of that, µs.
    pub signal_hops_us: SignalHops,
    /// Longest time between two commands that the actuator gateway accepted, µs.
    pub max_command_gap_us: Option<f64>,
    /// Cycles whose command had to be relaxed.
    pub relaxed_cycles: Option<u64>,
    /// Cycles whose command came from the law's backup.
    pub backup_cycles: Option<u64>,
    /// Planning beside the control loop, of laws that do.
    pub planning: Option<PlanningReport>,
    /// How the program of a foreign law fared; null for the others.
    pub law_program: Option<ProgramReport>,
    /// Commands that the scenario's misses and jitter kept from the actuators.
    pub undelivered_commands: Option<u64>,
    /// Control periods in which no command was at the plant in time, by the plant's own schedule.
    pub missed_at_plant: Option<u64>,
    /// Control periods that were judged for it.
    pub due_at_plant: Option<u64>,
    /// The worse of `deadline_misses` and `missed_at_plant`.
    pub worst_deadline_misses: Option<u64>,
    /// Reaction times, end to end, that were longer than the deadline.
    pub late_reactions: Option<u64>,
}

/// Messages of one topic.
#[derive(Clone, Debug, Default, Serialize)]
pub struct TopicCounts {
    /// Messages sent by all of the topic's senders.
    pub sent: u64,
    /// Fewest messages that one of the topic's readers received; null if it has no readers.
    pub received: Option<u64>,
    /// Most messages that one of the topic's readers missed.
    pub lost: Option<u64>,
    /// Messages that each reader missed since it read too late, for those that did.
    pub lost_by: BTreeMap<&'static str, u64>,
    /// Messages that the topic's readers refused; null if it has no readers.
    pub e2e_errors: Option<u64>,
    /// Outcomes of the end-to-end check, summed over the topic's readers.
    pub e2e: Outcomes,
    /// XXH3 over the bytes of all messages of each sender, in lockstep.
    pub digests: BTreeMap<String, String>,
}

/// One process of the group.
#[derive(Clone, Debug, Serialize)]
pub struct ServiceSummary {
    /// Name of the service.
    pub name: &'static str,
    /// Times that another process took its place: one that the supervisor started for it, or its standby.
    pub restarts: u32,
    /// In how many of these the standby took over; null without one.
    pub take_overs: Option<u32>,
    /// What its standby costs that stood by at the end; null without one.
    pub standby_cost: Option<StandbyCost>,
    /// Heartbeats that the supervisor received; null in lockstep.
    pub heartbeats: Option<Heartbeats>,
    /// How its process ended; null if that is not known.
    pub exit: Option<String>,
    /// Largest resident set, KiB; null without a report.
    pub peak_rss_kib: Option<u64>,
    /// Allocations of the loop, in programs whose allocator counts; null elsewhere.
    pub allocations_in_loop: Option<u64>,
    /// Scheduling asked for and granted; null without a report.
    pub scheduling: Option<Granted>,
    /// The program of the user's that was the service, or computed for it; null where it was timegap's own.
    pub program: Option<Program>,
}

impl Summary {
    /// Puts together what the group brought back.
    pub fn new(scenario: &Scenario, mode: Mode, group: &GroupOutcome, wall: Duration) -> Self {
        let report = |service| group.reports.get(&service);
        let plant = report(Service::Plant).and_then(plant_details);
        let controller = report(Service::Controller).and_then(controller_details);
        let deadline_misses = controller
            .filter(|_| mode == Mode::Realtime)
            .map(|controller| controller.deadline_misses);
        // Without the plant's word what was heard of it counts.
        let heard_s = group.drive.steps.last().map_or(0.0, |step| step.time_s);
        let duration_s = plant.map_or(heard_s, |plant| plant.duration_s);
        let ran_s = group.ran_for.as_secs_f64();
        let (outcome, aborted_because) = outcome(&group.ended, plant);
        Self {
            schema_version: 1,
            scenario: scenario.name.as_str().into(),
            controller: law_that_drove(scenario, group, controller),
            caution: group.formulation(scenario).and_then(|formulation| formulation.caution),
            mode: mode.name(),
            carrier: group.carrier,
            seed: scenario.seed.value(),
            outcome,
            aborted_because,
            duration_s,
            wall_s: wall.as_secs_f64(),
            ready_ms: group.ready_after.as_secs_f64() * 1e3,
            simulated_per_wall: (ran_s > 0.0 && duration_s > 0.0).then(|| duration_s / ran_s),
            control: Control {
                figures: plant.map(|plant| plant.control.clone()).unwrap_or_default(),
                following: Following::of(&group.drive.steps),
                trip: Trip::of(scenario, &group.drive.steps),
                mode_changes: controller.map(|controller| controller.mode_changes.clone()),
            },
            timing: Timing {
                cycles: report(Service::Controller).map(|report| report.cycles),
                deadline_us: controller.map(|controller| controller.deadline_us),
                deadline_misses,
                reaction_time_us: plant.and_then(|plant| plant.reaction_time_us),
                data_age_us: plant.and_then(|plant| plant.data_age_us),
                signal_age_us: group.drive.signal_age_us,
                release_jitter_us: report(Service::Controller)
                    .and_then(|report| report.release_jitter_us),
                solve_us: controller.and_then(|controller| controller.solve_us),
                designed_wait_us: plant.and_then(|plant| plant.designed_wait_us),
                net_reaction_us: plant.and_then(|plant| plant.net_reaction_us),
                hops_us: plant.map(|plant| plant.hops_us).unwrap_or_default(),
                worst_chains: plant.map(|plant| plant.worst_chains.clone()).unwrap_or_default(),
                signal_reaction_us: plant.and_then(|plant| plant.signal_reaction_us),
                signal_hops_us: plant.map(|plant| plant.signal_hops_us).unwrap_or_default(),
                max_command_gap_us: plant.and_then(|plant| plant.max_command_gap_us),
                relaxed_cycles: controller.map(|controller| controller.relaxed),
                backup_cycles: controller.map(|controller| controller.backup),
                planning: controller.and_then(|controller| controller.planning),
                law_program: controller.and_then(|controller| controller.program.clone()),
                undelivered_commands: plant.map(|plant| plant.undelivered_commands),
                missed_at_plant: plant.map(|plant| plant.commands_missed),
                due_at_plant: plant.map(|plant| plant.commands_due),
                worst_deadline_misses: deadline_misses
                    .max(plant.map(|plant| plant.commands_missed)),
                late_reactions: plant
                    .filter(|plant| plant.reaction_time_us.is_some())
                    .map(|plant| plant.late_reactions),
            },
            aebs: Aebs::of(scenario, plant, report(Service::Aebs)),
            perception: report(Service::PerceptionSim).and_then(perception_details),
            radio: radio::unit(group),
            link: radio::link(group),
            messages: messages(&group.reports, &group.drive),
            recording: group.recording.clone(),
            faults: group.faults.clone(),
            rungs: (controller.map(|controller| ("controller", controller.rungs.clone())))
                .into_iter()
                .chain(plant.map(|plant| ("plant", plant.rungs.clone())))
                .collect(),
            checks: controller.map(|controller| controller.checks.clone()).unwrap_or_default(),
            services: (scenario.services().iter().copied())
                .map(|service| ServiceSummary {
                    name: service.name(),
                    restarts: group.restarts.get(&service).copied().unwrap_or(0),
                    take_overs: group.take_overs.get(&service).copied(),
                    standby_cost: group.standby_costs.get(&service).copied(),
                    heartbeats: group.heartbeats.get(&service).copied(),
                    exit: group.exits.get(&service).map(ToString::to_string),
                    peak_rss_kib: report(service).and_then(|report| report.peak_rss_kib),
                    allocations_in_loop: report(service)
                        .and_then(|report| report.allocations_in_loop),
                    scheduling: report(service).map(|report| report.scheduling.clone()),
                    program: group.programs.get(&service).cloned(),
                })
                .collect(),
            host: Host::this(),
        }
    }
}

/// Name of the law that drove: as its process says, else by the program in the controller's place, else the
/// scenario's.
fn law_that_drove(
    scenario: &Scenario,
    group: &GroupOutcome,
    controller: Option<&ControllerReport>,
) -> String {
    let told = controller.map(|controller| controller.law.clone()).filter(|law| !law.is_empty());
    let in_its_place = || {
        let hosted = controller::laws::program(scenario).is_ok_and(|program| program.is_some());
        let program = group.programs.get(&Service::Controller).filter(|_| !hosted);
        program.map(|program| program.name.clone())
    };
    told.or_else(in_its_place).unwrap_or_else(|| scenario.controller.name.as_str().to_owned())
}

impl Summary {
    /// The law that drove, with its caution or the command of a program of the user's.
    #[must_use]
    pub fn driver(&self) -> String {
        match (self.program(), self.caution) {
            (Some(program), _) => format!("{} ({})", self.controller, program.command),
            (None, Some(caution)) => format!("{} ({caution})", self.controller),
            (None, None) => self.controller.clone(),
        }
    }

    /// The program of the user's that drove.
    #[must_use]
    pub fn program(&self) -> Option<&Program> {
        let name = Service::Controller.name();
        self.services.iter().find(|service| service.name == name)?.program.as_ref()
    }
}

fn outcome(ended: &Ended, plant: Option<&PlantReport>) -> (Outcome, Option<String>) {
    let reached = plant.map_or(Outcome::Aborted, |plant| plant.outcome);
    match ended {
        Ended::Orderly => (reached, None),
        // What the referee saw before the end still counts.
        _ if matches!(reached, Outcome::Collision | Outcome::RedLight) => (reached, None),
        Ended::Interrupted => (Outcome::Aborted, Some("interrupted".into())),
        Ended::Broken { service, how } => {
            (Outcome::Aborted, Some(format!("{service} ended before its time: {how}")))
        }
        Ended::GivenUp { service, restarts } => {
            let why = format!("{service} ended too often, after {restarts} restarts");
            match reached {
                Outcome::SafeStop => (Outcome::SafeStop, Some(why)),
                _ => (Outcome::Aborted, Some(why + "; the run ended before the vehicle stood")),
            }
        }
    }
}

/// The histograms that the plant brought back, by name; none if it brought no report.
pub fn histograms(group: &GroupOutcome) -> Vec<(String, Latencies)> {
    let plant = group.reports.get(&Service::Plant).and_then(plant_details);
    let histograms = plant.into_iter().flat_map(|plant| &plant.histograms);
    histograms.map(|(name, histogram)| (name.clone(), histogram.clone())).collect()
}

fn plant_details(report: &ServiceReport) -> Option<&PlantReport> {
    match &report.details {
        Details::Plant(plant) => Some(plant),
        _ => None,
    }
}

fn perception_details(report: &ServiceReport) -> Option<PerceptionReport> {
    match &report.details {
        Details::Perception(perception) => Some(**perception),
        _ => None,
    }
}

fn controller_details(report: &ServiceReport) -> Option<&ControllerReport> {
    match &report.details {
        Details::Controller(controller) => Some(controller),
        _ => None,
    }
}

fn messages(
    reports: &BTreeMap<Service, ServiceReport>,
    drive: &Drive,
) -> BTreeMap<String, TopicCounts> {
    let mut topics: BTreeMap<String, TopicCounts> = BTreeMap::new();
    for report in reports.values() {
        for sent in &report.sent {
            let counts = topics.entry(sent.topic.clone()).or_default();
            counts.sent += sent.sent;
            if let Some(digest) = &sent.digest {
                counts.digests.insert(report.service.name().into(), digest.clone());
            }
        }
    }
    let of_services = reports.values().flat_map(|report| {
        report.received.iter().map(|received| (report.service.name(), received))
    });
    let of_launcher = drive.received.iter().map(|received| ("launcher", received));
    for (reader, received) in of_services.chain(of_launcher) {
        let ReceivedTopic { topic, received, lost, e2e, .. } = received;
        let counts = topics.entry(topic.clone()).or_default();
        counts.received = Some(counts.received.map_or(*received, |least| least.min(*received)));
        counts.lost = Some(counts.lost.map_or(*lost, |most| most.max(*lost)));
        if *lost > 0 {
            counts.lost_by.insert(reader, *lost);
        }
        counts.e2e.add(e2e);
        counts.e2e_errors = Some(counts.e2e.refused());
    }
    topics
}
