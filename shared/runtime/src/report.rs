//! What a service tells the launcher when it ends.

mod chains;

pub use chains::{HopTimes, Hops, SignalHops, WorstChain};

use crate::FaultStatistics;
use crate::machine::scheduling::Granted;
use crate::statistics::{Latencies, Percentiles};
use messages::Service;
use messages::e2e::Outcomes;
use messages::level::Levels;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Messages sent on a topic by one service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SentTopic {
    /// Topic name.
    pub topic: String,
    /// Messages sent.
    pub sent: u64,
    /// XXH3 over the bytes of all messages in order, in lockstep.
    pub digest: Option<String>,
}

/// Messages received from a topic by one service.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ReceivedTopic {
    /// Topic name.
    pub topic: String,
    /// Messages received.
    pub received: u64,
    /// Gaps in the sequence numbers.
    pub lost: u64,
    /// Outcomes of the end-to-end check.
    pub e2e: Outcomes,
}

/// The account of one service's life.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ServiceReport {
    /// The service.
    pub service: Service,
    /// Cycles run.
    pub cycles: u64,
    /// Releases that were left out because the service was busy or stopped.
    pub skipped: u64,
    /// Actual minus scheduled begin of the cycles, realtime only.
    pub release_jitter_us: Option<Percentiles>,
    /// Topics published.
    pub sent: Vec<SentTopic>,
    /// Topics received.
    pub received: Vec<ReceivedTopic>,
    /// Allocations of the loop's thread between the start and the last cycle, where they are counted.
    /// Services that share a thread count each other's.
    pub allocations_in_loop: Option<u64>,
    /// Peak resident set of its process, KiB; none if it has no process of its own.
    pub peak_rss_kib: Option<u64>,
    /// What the kernel granted.
    pub scheduling: Granted,
    /// What faults did to the service's messages.
    pub fault_statistics: Vec<FaultStatistics>,
    /// What only this service can tell.
    pub details: Details,
}

/// What only one service can tell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Details {
    /// Nothing more.
    None,
    /// From the controller.
    Controller(Box<ControllerReport>),
    /// From the plant.
    Plant(Box<PlantReport>),
    /// From the emergency brake.
    Aebs(Box<AebsReport>),
    /// From perception-sim.
    Perception(Box<PerceptionReport>),
    /// From the on-board unit.
    Obu(Box<ObuReport>),
    /// From v2x-sim, where the roadside units are on other hosts or in a capture.
    Link(Box<LinkReport>),
}

/// What came of the frames between the vehicle and other hosts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinkReport {
    /// The carrier's address.
    pub carrier: String,
    /// The vehicle's frames that were handed to the network.
    pub sent: u64,
    /// Those that could not be handed over.
    pub not_sent: u64,
    /// Frames received, without repeats.
    pub received: u64,
    /// Of these, frames that came before the run began.
    pub before_start: u64,
    /// Frames that were not read in time: the queue was full.
    pub dropped: u64,
    /// Packets that are no frames.
    pub malformed: u64,
    /// Whether it is known what the signals really show: the unit runs the same scenario and says when it
    /// began. Else the referee does not judge red lights.
    pub truth_known: bool,
    /// Each sender that was heard and says who it is, vehicles too.
    pub stations: Vec<StationReport>,
}

/// What came of the frames of one sender.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StationReport {
    /// Its number, in hexadecimal digits; drawn anew at each start.
    pub sender: String,
    /// Frames received.
    pub received: u64,
    /// Frames between the first and the last received that never came.
    pub lost: u64,
    /// Frames that came again.
    pub duplicates: u64,
    /// Frames that another overtook.
    pub reordered: u64,
    /// Frames that were not taken because their number was far from all others.
    #[serde(default)]
    pub implausible: u64,
    /// Its clock minus the vehicle's, µs; null: a vehicle's, or not known.
    pub clock_offset_us: Option<f64>,
    /// The true difference is at most this far from that, µs.
    pub clock_uncertainty_us: Option<f64>,
    /// Shortest round trip of a question about the clock and its answer, µs.
    pub shortest_round_trip_us: Option<f64>,
}

/// What the on-board unit made of the frames on air.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObuReport {
    /// Frames that arrived.
    pub frames: u64,
    /// Frames that arrived and for which a batch had no room.
    pub left_out: u64,
    /// Frames by what was made of them.
    pub verdicts: BTreeMap<String, u64>,
    /// CAMs that it sent.
    pub cams_sent: u64,
    /// Time from the sending of a frame to its arrival.
    pub air_us: Option<Percentiles>,
    /// Time to decode and check a frame, on the wall clock in both modes.
    pub decode_us: Option<Percentiles>,
    /// Age of the oldest timing of the signals ahead when it is handed on.
    pub age_us: Option<Percentiles>,
}

/// How well perception's tracks matched the traffic. The crate `perception-sim` says in its module
/// `quality` how each figure is made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PerceptionReport {
    /// Scans judged.
    pub scans: u64,
    /// GOSPA (c = 10 m, p = 2), root mean square over the scans, m. Its square is the sum of the squares
    /// of the next three.
    pub gospa_m: f64,
    /// Part of the distance between tracks and their vehicles.
    pub localisation_m: f64,
    /// Part of vehicles without a track.
    pub missed_m: f64,
    /// Part of tracks without a vehicle.
    pub false_m: f64,
    /// Tracks for which the message had no room.
    pub tracks_left_out: u64,
    /// Vehicles that came into the ego's lane from beside it and got a track in the path.
    pub cut_ins: u64,
    /// Mean time from the overlap with the lane to the track in the path, s; negative: before.
    pub cut_in_mean_s: Option<f64>,
    /// The longest such time, s.
    pub cut_in_worst_s: Option<f64>,
    /// Vehicles that came into the lane and have no track in the path yet.
    pub cut_ins_unconfirmed: u64,
    /// Times that a target was selected that is no vehicle in or on its way into the path.
    pub false_targets: u64,
    /// Time for which there was one, s.
    pub false_target_s: f64,
    /// Detections handed out, by a radar that has detections.
    pub detections: Option<u64>,
    /// Detections for which the message had no room.
    pub detections_left_out: Option<u64>,
    /// Acts of an OpenSCENARIO file that never started.
    #[serde(default)]
    pub unstarted_acts: Vec<String>,
}

/// What the controller tells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControllerReport {
    /// Deadline after each scheduled release, µs.
    pub deadline_us: f64,
    /// Cycles that finished late, and releases left out.
    pub deadline_misses: u64,
    /// Time inside the law, on the wall clock in both modes.
    pub solve_us: Option<Percentiles>,
    /// Cycles whose command was relaxed.
    pub relaxed: u64,
    /// Cycles whose command came from the law's backup.
    pub backup: u64,
    /// Cycles in which the degradation ladder braked in the law's place.
    #[serde(default)]
    pub braked: u64,
    /// Planning beside the loop, of laws that do.
    pub planning: Option<PlanningReport>,
    /// Name of the law that drove; empty where only the launcher tells.
    #[serde(default)]
    pub law: String,
    /// How the program of a foreign law fared.
    #[serde(default)]
    pub program: Option<ProgramReport>,
    /// Changes of the law's mode.
    pub mode_changes: Vec<ModeChange>,
    /// The controller's way on the degradation ladder.
    pub rungs: Levels,
    /// What the checks of its inputs found.
    #[serde(default)]
    pub checks: Vec<CheckReport>,
}

/// What a check of the controller's inputs found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CheckReport {
    /// The check.
    pub check: String,
    /// Cycles in which it found a contradiction.
    pub cycles: u64,
    /// Release of the first of them, s.
    pub first_s: Option<f64>,
    /// Largest value in a cycle without a contradiction, as a share of the threshold.
    pub nearest: f64,
}

/// How the program of a foreign law fared, as its host counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ProgramReport {
    /// Times that it was started.
    pub starts: u64,
    /// Questions that it answered in time.
    pub answers: u64,
    /// Releases at which its answer was not there in time: the law's backup drove.
    pub late: u64,
    /// Answers that no vehicle could follow: the law's backup drove.
    pub refused: u64,
    /// Releases at which there was no program to ask: the law's backup drove.
    pub absent: u64,
    /// What it did wrong, as far as [`MAX_FAILURES`] of them.
    pub failures: Vec<String>,
    /// It failed too often and was not started again.
    pub given_up: bool,
}

/// Failures of a program that are kept.
pub const MAX_FAILURES: usize = 8;

/// How the planning beside a control loop kept up with it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanningReport {
    /// Plans asked for.
    pub asked: u64,
    /// Plans that were not there when they were due; the loop drove on by the one before.
    pub late: u64,
    /// Time after which a plan is due, µs.
    pub deadline_us: f64,
    /// Time that a plan took, on the wall clock in both modes.
    pub plan_us: Option<Percentiles>,
}

/// A change of the law's mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModeChange {
    /// Run time, s.
    pub t_s: f64,
    /// Mode left.
    pub from: String,
    /// Mode entered.
    pub to: String,
    /// Why.
    pub reason: String,
    /// The law's figures in the cycle of the change, by name.
    pub figures: BTreeMap<String, f64>,
}

/// What the emergency brake tells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AebsReport {
    /// Deadline after each scheduled release, µs.
    pub deadline_us: f64,
    /// Cycles that finished late, and releases left out.
    pub deadline_misses: u64,
    /// Time for objects and decision, on the wall clock in both modes.
    pub decide_us: Option<Percentiles>,
}

/// What the emergency brake did, as the plant counts it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BrakeFigures {
    /// Times that it warned the driver.
    pub warnings: u64,
    /// Times that it braked.
    pub interventions: u64,
    /// Time for which it braked or held the brakes, s.
    pub braking_s: f64,
    /// Time without a fresh message of it, or with one that says that it sees nothing, s.
    pub unavailable_s: f64,
}

/// What the plant tells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlantReport {
    /// How the run ended.
    pub outcome: Outcome,
    /// Run time reached, s.
    pub duration_s: f64,
    /// Figures of the drive.
    pub control: ControlFigures,
    /// The plant's way on the degradation ladder.
    pub rungs: Levels,
    /// Longest time between two commands that the gateway accepted, µs.
    pub max_command_gap_us: Option<f64>,
    /// Radar acquisition to the first actuation that uses it.
    pub reaction_time_us: Option<Percentiles>,
    /// Every actuation back to the radar acquisition behind it.
    pub data_age_us: Option<Percentiles>,
    /// The waits of the reaction time that are designed.
    pub designed_wait_us: Option<Percentiles>,
    /// The reaction time without them.
    pub net_reaction_us: Option<Percentiles>,
    /// The parts of the reaction time, which add up to it sample by sample.
    pub hops_us: Hops,
    /// The chains with the longest reaction times, longest first.
    pub worst_chains: Vec<WorstChain>,
    /// Commands that the scenario's misses and jitter kept from the actuators.
    pub undelivered_commands: u64,
    /// What the emergency brake did; none where there is none.
    pub aebs: Option<BrakeFigures>,
    /// Radar acquisition to the first cycle of the brake path that uses it.
    pub brake_reaction_time_us: Option<Percentiles>,
    /// The parts of that, the emergency brake in the place of the controller.
    pub brake_hops_us: Hops,
    /// A signal's change to the first actuation that knows of it.
    pub signal_reaction_us: Option<Percentiles>,
    /// The parts of that.
    pub signal_hops_us: SignalHops,
    /// Control periods whose deadline passed, by the plant's own schedule.
    pub commands_due: u64,
    /// Those without a command in time.
    pub commands_missed: u64,
    /// Chains whose reaction time was longer than the deadline.
    pub late_reactions: u64,
    /// Histograms of the reaction time, the data age and the parts, by their names.
    pub histograms: BTreeMap<String, Latencies>,
}

impl PlantReport {
    /// A report of a plant that ended so, without a figure.
    #[must_use]
    pub fn empty(outcome: Outcome) -> Self {
        Self {
            outcome,
            duration_s: 0.0,
            control: ControlFigures::default(),
            rungs: Levels::default(),
            max_command_gap_us: None,
            reaction_time_us: None,
            data_age_us: None,
            designed_wait_us: None,
            net_reaction_us: None,
            hops_us: Hops::default(),
            worst_chains: Vec::new(),
            undelivered_commands: 0,
            aebs: None,
            brake_reaction_time_us: None,
            brake_hops_us: Hops::default(),
            signal_reaction_us: None,
            signal_hops_us: SignalHops::default(),
            commands_due: 0,
            commands_missed: 0,
            late_reactions: 0,
            histograms: BTreeMap::new(),
        }
    }
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The scenario's end was reached.
    Completed,
    /// The ego touched another vehicle.
    Collision,
    /// The ego crossed a stop line at red.
    RedLight,
    /// The plant stopped in lane for want of valid commands.
    SafeStop,
    /// The law's backup drove more than the scenario allows: the drive says little about the law.
    DrivenByBackup,
    /// Something ended the run before its time.
    Aborted,
}

/// Figures of the drive, from ground truth.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ControlFigures {
    /// Smallest gap to a vehicle in lane, m.
    pub min_gap_m: Option<f64>,
    /// Root mean square over time of the gap's distance from the desired one, m; in results while following.
    pub rms_gap_error_m: Option<f64>,
    /// Largest magnitude of that distance, m.
    pub max_abs_gap_error_m: Option<f64>,
    /// Smallest time to collision, s.
    pub min_ttc_s: Option<f64>,
    /// Real minus desired gap at the end, m: negative where the ego is too close.
    pub final_gap_error_m: Option<f64>,
    /// Ego minus lead speed at the end, or minus the set speed without a lead, m/s.
    pub final_speed_error_mps: Option<f64>,
    /// Largest magnitude of the jerk, m/s³; without the step of the acceleration at which the ego comes to a
    /// stand.
    pub max_abs_jerk_mps3: Option<f64>,
    /// Root mean square of the jerk over time, m/s³; without that step.
    pub rms_jerk_mps3: Option<f64>,
    /// Smallest acceleration, m/s².
    pub min_accel_mps2: Option<f64>,
    /// Largest acceleration, m/s².
    pub max_accel_mps2: Option<f64>,
    /// When the first stop line was crossed, s.
    pub stop_line_crossing_s: Option<f64>,
    /// Distance past the first stop line when its light first changed, m; negative before it.
    pub past_stop_line_at_switch_m: Option<f64>,
    /// Times that the ego came to a stand.
    pub stops: Option<u64>,
    /// Energy that driving took at the wheels, without what braking gives back, kWh/100 km; cars only.
    pub wheel_energy_kwh_per_100km: Option<f64>,
    /// Fuel, L/100 km; trucks only, as what follows.
    pub fuel_l_per_100km: Option<f64>,
    /// Shifts of the gearbox.
    pub gear_shifts: Option<u64>,
    /// Time with the service brakes applied, s.
    pub service_brake_s: Option<f64>,
}
