//! One trip: the plant and a driver, from the road's start to its end.

use super::Road;
use truck_model::{Demand, FUEL_DENSITY_GPL, Ledger, Motion, Truck};

/// Time between two decisions of a driver, s.
pub const CONTROL_PERIOD_S: f64 = 0.1;
/// Integration steps in one control period.
pub(super) const SUBSTEPS: usize = 5;
/// Speed at which a trip counts as stuck, m/s.
const STUCK_MPS: f64 = 1.0;

/// Knowledge of a driver at a decision.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Time since the start, s.
    pub time_s: f64,
    /// The truck.
    pub motion: &'a Motion,
    /// Grade under it.
    pub grade: f64,
}

/// Driver of the truck: a law, a baseline or a driver model.
pub trait Driver {
    /// The demand for the next control period.
    fn demand(&mut self, seen: &Seen<'_>) -> Demand;
}

/// One control period of a trip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the start, s.
    pub time_s: f64,
    /// Distance, m.
    pub position_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Torque at the crankshaft, N m.
    pub engine_torque_nm: f64,
    /// Gear, counted from 0.
    pub gear: usize,
    /// Fuel burnt since the start, g.
    pub fuel_g: f64,
}

/// Result of a trip.
#[derive(Clone, Debug, PartialEq)]
pub struct Trip {
    /// Length of the road, m.
    pub length_m: f64,
    /// Time, s.
    pub time_s: f64,
    /// Fuel burnt, g.
    pub fuel_g: f64,
    /// Kinetic energy at the end less that at the start, J.
    pub gained_j: f64,
    /// Use of the energy.
    pub ledger: Ledger,
    /// Number of shifts.
    pub shifts: u32,
    /// Lowest and highest speed, m/s.
    pub speed_range_mps: (f64, f64),
    /// Control periods, in order.
    pub samples: Vec<Sample>,
}

impl Trip {
    /// Fuel at equal kinetic energy at both ends, L/100 km, with the price of energy in g/J.
    #[must_use]
    pub fn corrected_l_per_100_km(&self, energy_gpj: f64) -> f64 {
        1e5 * (self.fuel_g - energy_gpj * self.gained_j) / FUEL_DENSITY_GPL / self.length_m
    }
}

/// Drives a truck over a road; `None` when it got stuck.
#[must_use]
pub fn drive(truck: &Truck, road: &Road, start_mps: f64, driver: &mut dyn Driver) -> Option<Trip> {
    let length_m = road.length_m();
    let mut motion = Motion::new(truck, 0.0, start_mps, road.grade(0.0));
    let dt_s = CONTROL_PERIOD_S / SUBSTEPS as f64;
    let mut samples = Vec::with_capacity((2.0 * length_m / start_mps / CONTROL_PERIOD_S) as usize);
    let mut speed_range_mps = (start_mps, start_mps);
    for period in 0_u64.. {
        let time_s = period as f64 * CONTROL_PERIOD_S;
        let grade = road.grade(motion.position_m);
        samples.push(Sample {
            time_s,
            position_m: motion.position_m,
            speed_mps: motion.speed_mps,
            engine_torque_nm: motion.engine_torque_nm,
            gear: motion.gear,
            fuel_g: motion.fuel_g,
        });
        let demand = driver.demand(&Seen { time_s, motion: &motion, grade });
        for substep in 0..SUBSTEPS {
            let before = motion;
            motion.step(truck, dt_s, &demand, road.grade(motion.position_m));
            if motion.position_m >= length_m {
                let share =
                    (length_m - before.position_m) / (motion.position_m - before.position_m);
                let at_end = |from: f64, to: f64| from + share * (to - from);
                let end_mps = at_end(before.speed_mps, motion.speed_mps);
                return Some(Trip {
                    length_m,
                    time_s: time_s + (substep as f64 + share) * dt_s,
                    fuel_g: at_end(before.fuel_g, motion.fuel_g),
                    gained_j: truck.kinetic_energy_j(end_mps) - truck.kinetic_energy_j(start_mps),
                    ledger: motion.ledger,
                    shifts: motion.shifts,
                    speed_range_mps,
                    samples,
                });
            }
        }
        speed_range_mps.0 = speed_range_mps.0.min(motion.speed_mps);
        speed_range_mps.1 = speed_range_mps.1.max(motion.speed_mps);
        if motion.speed_mps < STUCK_MPS {
            return None;
        }
    }
    None
}
