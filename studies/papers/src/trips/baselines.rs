//! Drivers without a plan, which the law is compared with.

use super::{CONTROL_PERIOD_S, Driver, Seen};
use controller::laws::truck::limiter;
use controller::laws::truck::speed_keeper::SpeedKeeper;
use controller::laws::truck::target_filter::{Estimate, TargetFilter};
use truck_model::{Demand, Truck};

/// PI cruise at constant speed: the baseline of all savings. It brakes above its limit only.
#[derive(Clone, Debug)]
pub struct Cruise {
    truck: Truck,
    set_speed_mps: f64,
    limit_mps: f64,
    keeper: SpeedKeeper,
}

impl Cruise {
    /// A cruise control with a set speed and a limit.
    #[must_use]
    pub fn new(truck: &Truck, set_speed_mps: f64, limit_mps: f64) -> Self {
        Self { truck: *truck, set_speed_mps, limit_mps, keeper: SpeedKeeper::default() }
    }
}

impl Driver for Cruise {
    fn demand(&mut self, seen: &Seen<'_>) -> Demand {
        let (speed_mps, gear) = (seen.motion.speed_mps, seen.motion.gear);
        let speeds_mps = (self.set_speed_mps, speed_mps);
        let torque_nm =
            self.keeper.torque_nm(&self.truck, speeds_mps, gear, seen.grade, CONTROL_PERIOD_S);
        let demand = Demand::torque(torque_nm);
        limiter::limited(&self.truck, demand, speed_mps, gear, seen.grade, self.limit_mps)
    }
}

/// Gap at standstill, m, and time headway, s.
const STANDSTILL_M: f64 = 15.0;
const HEADWAY_S: f64 = 1.8;
/// Per metre of gap error, 1/s²; per relative speed, 1/s; of the lead's acceleration; per speed error, 1/s.
const GAP_PER_S2: f64 = 0.02;
const SPEED_PER_S: f64 = 0.3;
const LEAD_SHARE: f64 = 0.5;
const CRUISE_PER_S: f64 = 0.3;
/// Range, m/s².
const RANGE_MPS2: (f64, f64) = (-3.5, 0.5);
/// Jerk, m/s³.
const JERK_MPS3: f64 = 1.5;

/// A well-tuned ordinary ACC: the baseline behind a lead.
///
/// It has the same headway, the same filter and the same truck. It is linear in gap, relative speed and the lead's
/// acceleration. It brakes when the engine is not enough, and uses no slope ahead.
#[derive(Clone, Debug)]
pub struct OrdinaryAcc {
    truck: Truck,
    set_speed_mps: f64,
    limit_mps: f64,
    filter: TargetFilter,
    wanted_mps2: f64,
}

impl OrdinaryAcc {
    /// An ACC with a set speed, and a limit that holds downhill.
    #[must_use]
    pub fn new(truck: &Truck, set_speed_mps: f64, limit_mps: f64) -> Self {
        let filter = TargetFilter::default();
        Self { truck: *truck, set_speed_mps, limit_mps, filter, wanted_mps2: 0.0 }
    }

    fn wanted_mps2(&self, speed_mps: f64, target: Option<Estimate>) -> f64 {
        let cruise_mps2 = CRUISE_PER_S * (self.set_speed_mps - speed_mps);
        let behind_mps2 = target.map_or(f64::INFINITY, |target| {
            let target_mps = (speed_mps + target.relative_speed_mps).max(0.0);
            let error_m = target.gap_m - (STANDSTILL_M + HEADWAY_S * target_mps);
            GAP_PER_S2 * error_m
                + SPEED_PER_S * target.relative_speed_mps
                + LEAD_SHARE * target.acceleration_mps2
        });
        behind_mps2.min(cruise_mps2).clamp(RANGE_MPS2.0, RANGE_MPS2.1)
    }
}

impl Driver for OrdinaryAcc {
    fn demand(&mut self, seen: &Seen<'_>) -> Demand {
        let motion = seen.motion;
        let (speed_mps, gear) = (motion.speed_mps, motion.gear);
        let target =
            self.filter.update(seen.target.as_ref(), motion.acceleration_mps2, CONTROL_PERIOD_S);
        let step = JERK_MPS3 * CONTROL_PERIOD_S;
        let wanted = self.wanted_mps2(speed_mps, target);
        self.wanted_mps2 = wanted.clamp(self.wanted_mps2 - step, self.wanted_mps2 + step);
        let demand =
            Demand::for_acceleration(&self.truck, self.wanted_mps2, speed_mps, gear, seen.grade);
        limiter::limited(&self.truck, demand, speed_mps, gear, seen.grade, self.limit_mps)
    }
}
