//! A drive, sample by sample.

use crate::log::PlaneScene;
use crate::report::ReceivedTopic;
use messages::{AllVehicles, BrakeState, EgoTruth, PhaseState};
use runtime::statistics::Percentiles;

/// All that the launcher received.
#[derive(Clone, Debug, Default)]
pub struct Drive {
    /// One entry per message on the ego's true motion, in order of time.
    pub steps: Vec<DriveStep>,
    /// Ground truth of the other vehicles, in order of time.
    pub vehicles: Vec<AllVehicles>,
    /// The view from above, in order of time; empty where the road has no plan.
    pub plane: Vec<PlaneScene>,
    /// Times at which the emergency brake began to brake, s.
    pub interventions_s: Vec<f64>,
    /// Counts of received messages, per topic.
    pub received: Vec<ReceivedTopic>,
    /// Age of the signal timing behind the control cycles, µs.
    pub signal_age_us: Option<Percentiles>,
}

/// Slowest speed with a defined time gap, m/s. Below it the quotient grows and no longer describes following.
const SLOWEST_MPS: f64 = 1.0;

/// The drive at one simulation step. Values of slower topics are absent in between.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveStep {
    pub step: u64,
    pub time_s: f64,
    pub position_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
    /// Request that the actuators follow, after the gateway's bounds, m/s².
    pub applied_mps2: f64,
    /// Time to collision with the vehicle ahead, s; infinite without one, or if it does not come closer.
    pub time_to_collision_s: f64,
    /// Distance to the next stop line ahead, m, infinite without one.
    pub stop_line_m: f64,
    pub signal: Option<PhaseState>,
    /// A vehicle ahead moves sideways towards the ego's lane.
    pub cut_in: bool,
    /// Request of the command of this step, m/s².
    pub request_mps2: Option<f64>,
    /// Gap to the nearest vehicle in lane, m.
    pub gap_m: Option<f64>,
    pub lead_speed_mps: Option<f64>,
    pub lead_acceleration_mps2: Option<f64>,
    /// Place of that vehicle in the scenario's list of actors, from 0.
    pub lead: Option<u32>,
    pub brake: Option<BrakeState>,
    pub mode: Option<u32>,
    /// Quality of the command: 0 full, 1 relaxed, 2 backup.
    pub quality: Option<u32>,
    pub figures: Option<[f64; messages::FIGURES]>,
    /// Engine and gearbox of a truck.
    pub powertrain: Option<PowertrainStep>,
}

impl DriveStep {
    /// The step of a ground truth message, without values of other topics.
    pub fn of(ego: &EgoTruth) -> Self {
        Self {
            step: ego.header.step,
            time_s: ego.header.acquisition_ns as f64 / 1e9,
            position_m: ego.position_m,
            speed_mps: ego.speed_mps,
            acceleration_mps2: ego.acceleration_mps2,
            applied_mps2: ego.request_mps2,
            time_to_collision_s: ego.time_to_collision_s,
            stop_line_m: ego.stop_line_m,
            signal: (ego.signal_state != 0).then(|| PhaseState::from_wire(ego.signal_state)),
            cut_in: ego.cut_in != 0,
            ..Self::default()
        }
    }

    /// Time gap to the vehicle ahead, s. It is 0 in a contact, and `None` below 1 m/s or without a gap in this step.
    pub fn time_gap_s(&self) -> Option<f64> {
        let moves = self.speed_mps >= SLOWEST_MPS;
        self.gap_m.filter(|_| moves).map(|gap_m| gap_m.max(0.0) / self.speed_mps)
    }

    /// Jerk since the step `before`, m/s³: the difference of two accelerations over their time. As for the referee, the
    /// step to standstill is not a jerk of the drive: `None` there.
    pub fn jerk_since(&self, before: &Self) -> Option<f64> {
        let felt = |step: &Self| match step.speed_mps <= 0.0 {
            true => step.acceleration_mps2.max(0.0),
            false => step.acceleration_mps2,
        };
        let comes_to_stand = before.speed_mps > 0.0 && self.speed_mps <= 0.0;
        (!comes_to_stand).then(|| (felt(self) - felt(before)) / (self.time_s - before.time_s))
    }
}

/// A truck's engine and gearbox at one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PowertrainStep {
    /// Gear, counted from 1.
    pub gear: u32,
    /// Torque at the crankshaft, N m.
    pub engine_torque_nm: f64,
    pub service_brake_n: f64,
    /// Fuel burnt since the start, g.
    pub fuel_g: f64,
}

/// Time at which the ego's front passed a place, s; it moves evenly between two steps.
pub fn passed_s(steps: &[DriveStep], place_m: f64) -> Option<f64> {
    let pair = steps.windows(2).find(|pair| pair[1].position_m >= place_m)?;
    let way_m = pair[1].position_m - pair[0].position_m;
    let share = if way_m > 0.0 { (place_m - pair[0].position_m) / way_m } else { 0.0 };
    Some(pair[0].time_s + share * (pair[1].time_s - pair[0].time_s))
}
