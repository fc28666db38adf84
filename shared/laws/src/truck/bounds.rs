//! Bounds of the law's input, of a plan's speeds, and of the brakes: plausible inputs, the torque guard, step 3.

use super::settings::{BoundKeys, Brakes, PlannerKind, Settings};
use super::torque::torque_bounds_nm;
use super::tracking::Guidance;
use law::{Input, PlanRequest, Powertrain};
use truck_model::{Demand, GEARS, Motion as TruckMotion};

/// Largest believable values of an input.
const BELIEVABLE: f64 = 1e7;
const BELIEVABLE_MPS: f64 = 100.0;
/// Guard of the lower bound (step 3): torque above holding, N m, and more per m/s below.
const GUARD_NM: f64 = 200.0;
const GUARD_NM_PER_MPS: f64 = 400.0;

/// The powertrain; without a report the gear that the speed suggests, and the map's grade.
pub(super) fn powertrain(settings: &Settings, input: &Input, map_grade: Option<f64>) -> Powertrain {
    let reported = input.powertrain.filter(|powertrain| {
        powertrain.gear < GEARS
            && powertrain.engine_torque_nm.abs() < BELIEVABLE
            && powertrain.grade.abs() < 1.0
    });
    reported.unwrap_or_else(|| {
        let motion = TruckMotion::new(&settings.truck, 0.0, input.ego.speed_mps, 0.0);
        Powertrain {
            gear: motion.gear,
            since_shift_s: motion.since_shift_s,
            engine_torque_nm: motion.engine_torque_nm,
            grade: map_grade.unwrap_or(0.0),
        }
    })
}

/// Torque of the plan within the bounds of step 3, N m.
pub(super) fn guarded_nm(
    settings: &Settings,
    input: &Input,
    powertrain: &Powertrain,
    guidance: &Guidance,
) -> f64 {
    let truck = &settings.truck;
    let (speed_mps, gear) = (input.ego.speed_mps, powertrain.gear);
    let scale = truck.parameters().engine_scale;
    let hold_nm = truck.engine_torque_nm(0.0, speed_mps, gear, powertrain.grade);
    let bounds = &settings.keys.bounds;
    let (low_nm, high_nm) = torque_bounds_nm(bounds, truck, speed_mps, gear, powertrain.grade);
    let slow_mps = min_speed_mps(bounds, input.set_speed_mps) - speed_mps;
    let mut torque_nm = guidance.engine_torque_nm;
    if settings.keys.planner == PlannerKind::PaperN2 && slow_mps > 0.0 {
        torque_nm = torque_nm.max(hold_nm + scale * (GUARD_NM + GUARD_NM_PER_MPS * slow_mps));
    }
    if speed_mps > max_speed_mps(bounds, input.set_speed_mps, input.speed_limit_mps) {
        torque_nm = torque_nm.min(hold_nm);
    }
    torque_nm.clamp(low_nm, high_nm)
}

/// The demand without the brakes that the law may not use.
pub(super) fn permitted(
    settings: &Settings,
    mut demand: Demand,
    speed_mps: f64,
    gear: usize,
) -> Demand {
    let truck = &settings.truck;
    let brakes = settings.keys.brakes;
    if brakes != Brakes::Service {
        demand.service_brake_n = 0.0;
    }
    if brakes == Brakes::None {
        let drag_nm = truck.engine().drag_torque_nm(truck.engine_rpm(speed_mps, gear));
        demand.engine_torque_nm = demand.engine_torque_nm.max(drag_nm);
    }
    demand
}

/// True if the numbers can be those of a truck on a road.
pub(super) fn believable(input: &Input) -> bool {
    let ego = &input.ego;
    input.time_s.abs() < BELIEVABLE
        && (1e-4..10.0).contains(&input.period_s)
        && ego.position_m.abs() < BELIEVABLE
        && (0.0..BELIEVABLE_MPS).contains(&ego.speed_mps)
        && ego.acceleration_mps2.abs() < BELIEVABLE_MPS
        && (0.0..BELIEVABLE_MPS).contains(&input.set_speed_mps)
        && input.speed_limit_mps > 0.0
}

/// Lowest and highest speed of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedBand {
    /// Lowest speed where the truck can hold it, m/s: 13 km/h below the set speed, if nothing else is set.
    pub min_mps: f64,
    /// Highest speed, m/s: 5 km/h above the set speed, if nothing else is set, and within the limit.
    pub max_mps: f64,
}

impl SpeedBand {
    /// The band of a request.
    pub fn of(keys: &BoundKeys, request: &PlanRequest) -> Self {
        let max_mps = max_speed_mps(keys, request.set_speed_mps, request.speed_limit_mps);
        Self { min_mps: min_speed_mps(keys, request.set_speed_mps).min(max_mps), max_mps }
    }
}

/// Highest speed that is planned, m/s.
pub fn max_speed_mps(keys: &BoundKeys, set_speed_mps: f64, speed_limit_mps: f64) -> f64 {
    (set_speed_mps + keys.above_set_kmh / 3.6).min(speed_limit_mps)
}

/// Lowest speed that is planned where the truck can hold it, m/s.
pub fn min_speed_mps(keys: &BoundKeys, set_speed_mps: f64) -> f64 {
    set_speed_mps - keys.below_set_kmh / 3.6
}
