//! `summary.json`: stable names for the measurements of a run. A figure that does not apply is null.

mod following;
mod law;
pub mod targets;
mod topics;
mod trip;

pub use following::Following;
pub use law::{Aebs, LawAccount, braked};
pub use topics::{Host, TopicCounts};
pub use trip::{Passing, Trip};

use crate::report::{
    CheckReport, ControlFigures, ControllerReport, Hops, LinkReport, ModeChange, ObuReport,
    Outcome, PerceptionReport, PlanningReport, PlantReport, ProgramReport, SignalHops, WorstChain,
};
use crate::{
    Ended, Evidence, FaultRecord, GroupOutcome, Heartbeats, RecordingSummary, RequirementVerdict,
    StandbyCost,
};
use following::GapErrors;
use messages::Service;
use messages::level::Levels;
use runtime::scheduling::Granted;
use runtime::statistics::{Latencies, Percentiles};
use runtime::{Carrier, Mode, Program};
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::Duration;
use targets::PlaceSums;

#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Version of these keys; it rises when a key changes its name or meaning.
    pub schema_version: u32,
    pub scenario: String,
    /// Name of the control law.
    pub controller: String,
    /// A caution about the law, such as "uncertified"; omitted if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub caution: Option<&'static str>,
    /// Clock: `realtime` or `lockstep`.
    pub mode: &'static str,
    pub carrier: Carrier,
    /// Seed of every random draw of the run.
    pub seed: u64,
    pub outcome: Outcome,
    /// Reason of the outcome `aborted`.
    pub aborted_because: Option<String>,
    /// Run time reached, s; simulated time in lockstep.
    pub duration_s: f64,
    /// Wall-clock time from the first spawn until all processes had ended, s.
    pub wall_s: f64,
    /// Time from the first spawn until all services were ready, ms.
    pub ready_ms: f64,
    /// Simulated time over the wall time since the start instant.
    pub simulated_per_wall: Option<f64>,
    /// Figures of the drive, from ground truth.
    pub control: Control,
    /// Cycles by who commanded; null without the controller's report.
    pub law: Option<LawAccount>,
    pub requirements: Vec<RequirementVerdict>,
    /// Latencies, jitter and deadlines.
    pub timing: Timing,
    pub messages: BTreeMap<String, TopicCounts>,
    /// Figures of the emergency brake.
    pub aebs: Aebs,
    /// Match of the radar's tracks with the traffic.
    pub perception: Option<PerceptionReport>,
    /// Lost and false targets by part of a curve, by ground truth; on a road with a plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub targets: Option<Vec<PlaceSums>>,
    /// Counts of the on-board unit; null where signals come as structs.
    pub radio: Option<ObuReport>,
    /// Counts of the frames between the vehicle and other hosts; null where all units were simulated.
    pub link: Option<LinkReport>,
    /// The recording; null if none was requested.
    pub recording: Option<RecordingSummary>,
    /// Faults in order of time, with their effects.
    pub faults: Vec<FaultRecord>,
    /// Degradation levels of controller and plant.
    pub rungs: BTreeMap<&'static str, Levels>,
    /// Findings of the controller's plausibility checks.
    pub checks: Vec<CheckReport>,
    /// The processes of the group.
    pub services: Vec<ServiceSummary>,
    pub host: Host,
}

/// Figures of the drive.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Control {
    /// Measurements of the referee on ground truth.
    #[serde(flatten)]
    pub figures: ControlFigures,
    /// Time gaps behind the vehicle ahead.
    #[serde(flatten)]
    pub following: Following,
    /// The trip through the signals.
    #[serde(flatten)]
    pub trip: Trip,
    /// Changes of the law's mode; null without the controller's report.
    pub mode_changes: Option<Vec<ModeChange>>,
}

/// Latencies, jitter and deadlines. Durations are in µs; a figure without samples is null.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Timing {
    pub cycles: Option<u64>,
    /// Deadline of a control cycle after its scheduled release, µs.
    pub deadline_us: Option<f64>,
    /// Control cycles that ended after their deadline, and skipped releases; null in lockstep.
    pub deadline_misses: Option<u64>,
    /// Radar acquisition to the first actuation that uses it, µs.
    pub reaction_time_us: Option<Percentiles>,
    /// Age of the radar data behind every actuation, µs.
    pub data_age_us: Option<Percentiles>,
    /// Age of the signal timing (`v2x/spat`) behind the control cycles, µs; null without any.
    pub signal_age_us: Option<Percentiles>,
    /// Actual minus scheduled start of the control cycles, µs.
    pub release_jitter_us: Option<Percentiles>,
    /// Time inside the control law, µs, on the wall clock in both modes.
    pub solve_us: Option<Percentiles>,
    /// Waits of the reaction time that are part of the design, µs.
    pub designed_wait_us: Option<Percentiles>,
    /// Reaction time without these waits, µs.
    pub net_reaction_us: Option<Percentiles>,
    /// Parts of the reaction time, µs.
    pub hops_us: Hops,
    /// The chains with the longest reaction times, longest first.
    pub worst_chains: Vec<WorstChain>,
    /// A signal's change to the first actuation that uses it, µs; null if no signal ahead changed.
    pub signal_reaction_us: Option<Percentiles>,
    /// Parts of the signal reaction, µs.
    pub signal_hops_us: SignalHops,
    /// Longest time between two commands that the actuator gateway accepted, µs.
    pub max_command_gap_us: Option<f64>,
    pub relaxed_cycles: Option<u64>,
    /// Cycles with a command of the law's backup.
    pub backup_cycles: Option<u64>,
    /// Planning beside the control loop; null for laws without it.
    pub planning: Option<PlanningReport>,
    /// Performance of a foreign law's program; null for other laws.
    pub law_program: Option<ProgramReport>,
    /// Commands that simulated misses and jitter kept from the actuators.
    pub undelivered_commands: Option<u64>,
    /// Control periods without a command at the plant in time, by the plant's own schedule.
    pub missed_at_plant: Option<u64>,
    /// Control periods judged for `missed_at_plant`.
    pub due_at_plant: Option<u64>,
    /// The larger of `deadline_misses` and `missed_at_plant`.
    pub worst_deadline_misses: Option<u64>,
    /// Reaction times longer than the deadline.
    pub late_reactions: Option<u64>,
}

/// One process of the group.
#[derive(Clone, Debug, Serialize)]
pub struct ServiceSummary {
    pub name: &'static str,
    /// Number of replacements of its process, by a restart or by its standby.
    pub restarts: u32,
    /// Number of replacements by its standby; null without one.
    pub take_overs: Option<u32>,
    /// Cost of its last standby; null without one.
    pub standby_cost: Option<StandbyCost>,
    /// Heartbeats that the supervisor received; null in lockstep.
    pub heartbeats: Option<Heartbeats>,
    /// Exit status or signal of its process; null if unknown.
    pub exit: Option<String>,
    /// Largest resident set, KiB; null without a report.
    pub peak_rss_kib: Option<u64>,
    /// Allocations of the loop, in programs with a counting allocator; null elsewhere.
    pub allocations_in_loop: Option<u64>,
    /// Requested and granted scheduling; null without a report.
    pub scheduling: Option<Granted>,
    /// The user's program that was the service, or computed for it; null for timegap's own.
    pub program: Option<Program>,
}

impl Summary {
    /// The summary of a group's run.
    pub fn new(scenario: &Scenario, mode: Mode, group: &GroupOutcome, wall: Duration) -> Self {
        let report = |service| group.reports.get(&service);
        let plant = plant_report(group);
        let plant = plant.as_ref();
        let controller = report(Service::Controller).and_then(|report| report.details.read());
        let controller: Option<&ControllerReport> = controller.as_ref();
        let deadline_misses = controller
            .filter(|_| mode == Mode::Realtime)
            .map(|controller| controller.deadline_misses);
        // Without the plant's report its messages count.
        let heard_s = group.drive.steps.last().map_or(0.0, |step| step.time_s);
        let duration_s = plant.map_or(heard_s, |plant| plant.duration_s);
        let ran_s = group.ran_for.as_secs_f64();
        let (reached, aborted_because) = outcome(&group.ended, plant);
        let driver = law_that_drove(scenario, group, controller);
        let law = controller.zip(report(Service::Controller));
        let law = law.map(|(of, service)| LawAccount::of(driver.clone(), service.cycles, of));
        let outcome = law.as_ref().map_or(reached, |law| law.judge(reached, scenario));
        let impact_speed_mps = plant.and_then(|plant| plant.control.impact_speed_mps);
        let evidence = Evidence { scenario, drive: &group.drive, impact_speed_mps };
        let requirements = judge(&evidence);
        let all_met = requirements.iter().all(|verdict| verdict.met);
        let perception = report(Service::PerceptionSim);
        let perception: Option<PerceptionReport> = perception.and_then(|of| of.details.read());
        let outcome = match outcome {
            Outcome::Completed if !has_begun(scenario, perception.as_ref()) => Outcome::NoStory,
            Outcome::Completed if !all_met => Outcome::RequirementBroken,
            outcome => outcome,
        };
        Self {
            schema_version: 1,
            scenario: scenario.name.as_str().into(),
            controller: driver,
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
                figures: {
                    let mut figures = plant.map(|plant| plant.control.clone()).unwrap_or_default();
                    GapErrors::of(scenario, &group.drive.steps).write(&mut figures);
                    figures
                },
                following: Following::of(&group.drive.steps),
                trip: Trip::of(scenario, &group.drive.steps),
                mode_changes: controller.map(|controller| controller.mode_changes.clone()),
            },
            law,
            requirements,
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
            perception,
            targets: PlaceSums::of(scenario, &group.drive),
            radio: topics::unit(group),
            link: topics::link(group),
            messages: topics::of(&group.reports, &group.drive),
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

/// The verdicts on the scenario's requirements, which were checked when it was opened.
fn judge(evidence: &Evidence<'_>) -> Vec<RequirementVerdict> {
    let requirements = crate::requirements(evidence.scenario).unwrap_or_default();
    requirements.iter().map(|requirement| requirement.judge(evidence)).collect()
}

/// Name of the law that drove. It comes from its process's report, from the program in the controller's place, or from
/// the scenario.
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
    /// The law that drove, with its caution or the command of the user's program.
    pub fn driver(&self) -> String {
        match (self.program(), self.caution) {
            (Some(program), _) => format!("{} ({})", self.controller, program.command),
            (None, Some(caution)) => format!("{} ({caution})", self.controller),
            (None, None) => self.controller.clone(),
        }
    }

    /// The user's program that drove.
    pub fn program(&self) -> Option<&Program> {
        let name = Service::Controller.name();
        self.services.iter().find(|service| service.name == name)?.program.as_ref()
    }
}

/// False if the story of an OpenSCENARIO file could not happen, or no event of its acts has started.
fn has_begun(scenario: &Scenario, perception: Option<&PerceptionReport>) -> bool {
    let (Some(storyboard), Some(report)) = (&scenario.storyboard, perception) else { return true };
    let acts: usize = storyboard.script.stories.iter().map(|story| story.acts.len()).sum();
    scenario.hindrance().is_none() && (acts == 0 || report.unstarted_acts.len() < acts)
}

fn outcome(ended: &Ended, plant: Option<&PlantReport>) -> (Outcome, Option<String>) {
    let reached = plant.map_or(Outcome::Aborted, |plant| plant.outcome);
    match ended {
        Ended::Orderly => (reached, None),
        // The referee's findings before the end still count.
        _ if matches!(reached, Outcome::Collision | Outcome::RedLight) => (reached, None),
        Ended::Interrupted => (Outcome::Aborted, Some("interrupted".into())),
        Ended::Broken { service, how } => {
            (Outcome::Aborted, Some(format!("{service} ended early: {how}")))
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

/// The plant's histograms by name; empty without its report.
pub fn histograms(group: &GroupOutcome) -> Vec<(String, Latencies)> {
    plant_report(group).into_iter().flat_map(|plant| plant.histograms).collect()
}

fn plant_report(group: &GroupOutcome) -> Option<PlantReport> {
    group.reports.get(&Service::Plant)?.details.read()
}
