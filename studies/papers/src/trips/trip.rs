//! One trip: the plant and a driver, from the road's start to its end.

use super::Road;
use controller::law::Target;
use controller::laws::truck::Moment;
use rand_pcg::Pcg64;
use truck_model::{Demand, FUEL_DENSITY_GPL, Ledger, Motion, Truck};

/// Time between two decisions of a driver, s.
pub const CONTROL_PERIOD_S: f64 = 0.1;
/// Integration steps in one control period.
const SUBSTEPS: usize = 5;
/// Speed at which a trip on a free road counts as stuck, m/s.
const STUCK_MPS: f64 = 1.0;

/// Knowledge of a driver at a decision.
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// Time since the start, s.
    pub time_s: f64,
    pub motion: &'a Motion,
    pub grade: f64,
    /// Content of the radar.
    pub target: Option<Target>,
}

impl Seen<'_> {
    /// The truck at this moment.
    pub(super) fn moment<'a>(&self, truck: &'a Truck) -> Moment<'a> {
        let Motion { speed_mps, gear, .. } = *self.motion;
        Moment { truck, speed_mps, gear, grade: self.grade }
    }
}

/// Driver of the truck: a law, a baseline or a driver model.
pub trait Driver {
    /// The demand for the next control period.
    fn demand(&mut self, seen: &Seen<'_>) -> Demand;
}

#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trip {
    pub length_m: f64,
    pub time_s: f64,
    pub fuel_g: f64,
    /// Kinetic energy at the end less that at the start, J.
    pub gained_j: f64,
    /// Use of the energy.
    pub ledger: Ledger,
    pub shifts: u32,
    /// Lowest and highest speed, m/s.
    pub speed_range_mps: (f64, f64),
}

impl Trip {
    /// Fuel at equal kinetic energy at both ends, L/100 km, with the price of energy in g/J.
    pub fn corrected_l_per_100_km(&self, energy_gpj: f64) -> f64 {
        1e5 * (self.fuel_g - energy_gpj * self.gained_j) / FUEL_DENSITY_GPL / self.length_m
    }
}

/// Drives a truck over a free road; `None` when it got stuck.
pub fn drive(truck: &Truck, road: &Road, start_mps: f64, driver: &mut dyn Driver) -> Option<Trip> {
    let length_m = road.length_m();
    let dt_s = CONTROL_PERIOD_S / SUBSTEPS as f64;
    let mut motion = Motion::new(truck, 0.0, start_mps, road.grade(0.0));
    let mut trip = Trip { speed_range_mps: (start_mps, start_mps), ..Trip::default() };
    let end = |trip: Trip, motion: &Motion, before: &Motion, share: f64, time_s: f64| {
        let between = |from: f64, to: f64| from + share * (to - from);
        let end_mps = between(before.speed_mps, motion.speed_mps);
        Trip {
            length_m: between(before.position_m, motion.position_m),
            time_s,
            fuel_g: between(before.fuel_g, motion.fuel_g),
            gained_j: truck.kinetic_energy_j(end_mps) - truck.kinetic_energy_j(start_mps),
            ledger: motion.ledger,
            shifts: motion.shifts,
            ..trip
        }
    };
    for period in 0_u64.. {
        let time_s = period as f64 * CONTROL_PERIOD_S;
        let grade = road.grade(motion.position_m);
        let demand = driver.demand(&Seen { time_s, motion: &motion, grade, target: None });
        for substep in 0..SUBSTEPS {
            let before = motion;
            motion.step(truck, dt_s, &demand, road.grade(motion.position_m));
            if motion.position_m >= length_m {
                let share =
                    (length_m - before.position_m) / (motion.position_m - before.position_m);
                let time_s = time_s + (substep as f64 + share) * dt_s;
                return Some(Trip { length_m, ..end(trip, &motion, &before, share, time_s) });
            }
        }
        let (low_mps, high_mps) = trip.speed_range_mps;
        trip.speed_range_mps = (low_mps.min(motion.speed_mps), high_mps.max(motion.speed_mps));
        if motion.speed_mps < STUCK_MPS {
            return None;
        }
    }
    None
}

/// A normal deviate (Box and Muller).
pub(super) fn normal(random: &mut Pcg64) -> f64 {
    let (u, angle) = (random::open_uniform(random), random::open_uniform(random));
    random::box_muller(u, angle)
}
