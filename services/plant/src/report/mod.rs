//! Figures that the plant reports at its end.

mod chains;

pub use chains::{Hops, Parts, SignalHops, WorstChain};

use messages::level::Levels;
use runtime::statistics::{Latencies, Percentiles};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Figures of the drive, the gateway and the cause-effect chains.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PlantReport {
    pub outcome: Outcome,
    pub duration_s: f64,
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
    /// Actions of the emergency brake; none without one.
    pub aebs: Option<BrakeFigures>,
    /// Radar acquisition to the first cycle of the brake path that uses it.
    pub brake_reaction_time_us: Option<Percentiles>,
    /// Its parts, with the emergency brake instead of the controller.
    pub brake_hops_us: Hops,
    /// A signal's change to the first actuation with the new phase behind it.
    pub signal_reaction_us: Option<Percentiles>,
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

/// End of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The scenario's end was reached.
    Completed,
    /// The ego touched another vehicle.
    Collision,
    /// The ego crossed a stop line at red.
    RedLight,
    /// The plant stopped in lane for lack of valid commands.
    SafeStop,
    /// The law's backup drove more than the scenario allows: the drive shows little of the law.
    DrivenByBackup,
    /// The drive broke a requirement of the scenario, beside the rules that every drive is judged by.
    RequirementBroken,
    /// The story of an OpenSCENARIO file could not happen, so the drive says nothing about it.
    NoStory,
    /// An error ended the run early.
    #[default]
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
    /// Speed difference at the first contact, m/s; only after a collision.
    #[serde(default)]
    pub impact_speed_mps: Option<f64>,
    /// Real minus desired gap at the end, m: negative where the ego is too close.
    pub final_gap_error_m: Option<f64>,
    /// Ego minus lead speed at the end, or minus the set speed without a lead, m/s.
    pub final_speed_error_mps: Option<f64>,
    /// Largest magnitude of the jerk, m/s³; without the step of the acceleration at which the ego comes to a
    /// stand.
    pub max_abs_jerk_mps3: Option<f64>,
    /// Root mean square of the jerk over time, m/s³; without that step.
    pub rms_jerk_mps3: Option<f64>,
    pub min_accel_mps2: Option<f64>,
    pub max_accel_mps2: Option<f64>,
    /// Time when the first stop line was crossed, s.
    pub stop_line_crossing_s: Option<f64>,
    /// Distance past the first stop line when its light first changed, m; negative before it.
    pub past_stop_line_at_switch_m: Option<f64>,
    /// Times that the ego came to a stand.
    pub stops: Option<u64>,
    /// Energy that driving took at the wheels, without what braking gives back, kWh/100 km; cars only.
    pub wheel_energy_kwh_per_100km: Option<f64>,
    /// Fuel, L/100 km; trucks only, as what follows.
    pub fuel_l_per_100km: Option<f64>,
    pub gear_shifts: Option<u64>,
    /// Time with the service brakes applied, s.
    pub service_brake_s: Option<f64>,
    /// Largest magnitude of the lateral acceleration, m/s²; on a road with a plan, as what follows.
    #[serde(default)]
    pub max_abs_lateral_accel_mps2: Option<f64>,
    /// Largest magnitude of the lateral jerk, as a mean of 0.5 s, m/s³.
    #[serde(default)]
    pub max_abs_lateral_jerk_mps3: Option<f64>,
    /// Time with a part of the front bumper outside the lane, s.
    #[serde(default)]
    pub outside_lane_s: Option<f64>,
}

/// Actions of the emergency brake, as the plant counts them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BrakeFigures {
    /// Times that it warned the driver.
    pub warnings: u64,
    /// Times that it braked.
    pub interventions: u64,
    /// Time for which it braked or held the brakes, s.
    pub braking_s: f64,
    /// Time without a fresh message of it, or with one that reports that it sees nothing, s.
    pub unavailable_s: f64,
}
