//! One trip: the plant and a driver, from the road's start to its end, on a free road or behind a lead.

use super::Road;
use controller::law::Target;
use rand_pcg::Pcg64;
use truck_model::{Demand, FUEL_DENSITY_GPL, Ledger, Motion, Truck};

/// Time between two decisions of a driver, s.
pub const CONTROL_PERIOD_S: f64 = 0.1;
/// Integration steps in one control period.
const SUBSTEPS: usize = 5;
/// Speed at which a trip on a free road counts as stuck, m/s.
const STUCK_MPS: f64 = 1.0;
/// Farthest that the radar sees, m.
const RANGE_M: f64 = 200.0;

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

/// Driver of the truck: a law, a baseline or a driver model.
pub trait Driver {
    /// The demand for the next control period.
    fn demand(&mut self, seen: &Seen<'_>) -> Demand;

    /// Mode of the law; 0 for one without modes.
    fn mode(&self) -> u32 {
        0
    }
}

/// The vehicle ahead: a speed at the start and accelerations that end at the given times.
#[derive(Clone, Debug, PartialEq)]
pub struct Lead {
    pub gap_m: f64,
    pub speed_mps: f64,
    /// (until, acceleration) in s and m/s², in order of time; it keeps its speed afterwards.
    pub accelerations: Vec<(f64, f64)>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Standard deviation of the gap, m.
    pub gap_m: f64,
    /// Standard deviation of the relative speed, m/s.
    pub relative_speed_mps: f64,
    pub seed: u64,
}

/// One control period behind a lead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    pub position_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
    pub lead_mps: f64,
    pub gap_m: f64,
    pub mode: u32,
    pub engine_torque_nm: f64,
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
    /// Control periods behind a lead, in order.
    pub moments: Vec<Moment>,
}

impl Trip {
    /// Fuel at equal kinetic energy at both ends, L/100 km, with the price of energy in g/J.
    pub fn corrected_l_per_100_km(&self, energy_gpj: f64) -> f64 {
        1e5 * (self.fuel_g - energy_gpj * self.gained_j) / FUEL_DENSITY_GPL / self.length_m
    }

    /// Least time headway while the truck moves faster than 5 m/s, s.
    pub fn least_headway_s(&self) -> f64 {
        let moving = self.moments.iter().filter(|moment| moment.speed_mps > 5.0);
        moving.map(|moment| moment.gap_m / moment.speed_mps).fold(f64::INFINITY, f64::min)
    }

    pub fn least_gap_m(&self) -> f64 {
        self.moments.iter().map(|moment| moment.gap_m).fold(f64::INFINITY, f64::min)
    }
}

/// Drives a truck over a free road; `None` when it got stuck.
pub fn drive(truck: &Truck, road: &Road, start_mps: f64, driver: &mut dyn Driver) -> Option<Trip> {
    go(truck, road, start_mps, None, f64::INFINITY, driver)
}

/// Drives behind a lead for `duration_s`, or to the road's end.
pub fn chase(
    truck: &Truck,
    road: &Road,
    start_mps: f64,
    lead: &Lead,
    noise: Option<Noise>,
    duration_s: f64,
    driver: &mut dyn Driver,
) -> Trip {
    let traffic = Traffic {
        lead,
        place_m: lead.gap_m,
        speed_mps: lead.speed_mps,
        radar: noise.map(|noise| (noise, Pcg64::new(u128::from(noise.seed), 3))),
    };
    let trip = go(truck, road, start_mps, Some(traffic), duration_s, driver);
    trip.expect("behind a lead a truck may stand")
}

/// The lead on its way, and the radar.
struct Traffic<'a> {
    lead: &'a Lead,
    place_m: f64,
    speed_mps: f64,
    radar: Option<(Noise, Pcg64)>,
}

impl Traffic<'_> {
    fn acceleration_mps2(&self, time_s: f64) -> f64 {
        let part = self.lead.accelerations.iter().find(|(until_s, _)| time_s < *until_s);
        part.map_or(0.0, |part| part.1)
    }

    fn target(&mut self, time_s: f64, motion: &Motion) -> Option<Target> {
        let gap_m = self.place_m - motion.position_m;
        let (off_m, off_mps) = self.radar.as_mut().map_or((0.0, 0.0), |(noise, random)| {
            (noise.gap_m * normal(random), noise.relative_speed_mps * normal(random))
        });
        (gap_m < RANGE_M).then_some(Target {
            track_id: 1,
            gap_m: gap_m + off_m,
            relative_speed_mps: self.speed_mps - motion.speed_mps + off_mps,
            acceleration_mps2: self.acceleration_mps2(time_s),
            age_s: 0.0,
        })
    }

    fn step(&mut self, dt_s: f64, acceleration_mps2: f64) {
        let end_mps = (self.speed_mps + dt_s * acceleration_mps2).max(0.0);
        self.place_m += 0.5 * dt_s * (self.speed_mps + end_mps);
        self.speed_mps = end_mps;
    }
}

/// A normal deviate (Box and Muller).
pub(super) fn normal(random: &mut Pcg64) -> f64 {
    let (u, angle) = (random::open_uniform(random), random::open_uniform(random));
    random::box_muller(u, angle)
}

fn go(
    truck: &Truck,
    road: &Road,
    start_mps: f64,
    mut traffic: Option<Traffic<'_>>,
    until_s: f64,
    driver: &mut dyn Driver,
) -> Option<Trip> {
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
        if time_s >= until_s {
            return Some(end(trip, &motion, &motion, 1.0, time_s));
        }
        let grade = road.grade(motion.position_m);
        let target = traffic.as_mut().and_then(|traffic| traffic.target(time_s, &motion));
        let demand = driver.demand(&Seen { time_s, motion: &motion, grade, target });
        let lead_mps2 = traffic.as_ref().map_or(0.0, |traffic| traffic.acceleration_mps2(time_s));
        trip.moments.extend(traffic.as_ref().map(|traffic| Moment {
            position_m: motion.position_m,
            speed_mps: motion.speed_mps,
            acceleration_mps2: motion.acceleration_mps2,
            lead_mps: traffic.speed_mps,
            gap_m: traffic.place_m - motion.position_m,
            mode: driver.mode(),
            engine_torque_nm: motion.engine_torque_nm,
        }));
        for substep in 0..SUBSTEPS {
            let before = motion;
            motion.step(truck, dt_s, &demand, road.grade(motion.position_m));
            if let Some(traffic) = &mut traffic {
                traffic.step(dt_s, lead_mps2);
            }
            if motion.position_m >= length_m {
                let share =
                    (length_m - before.position_m) / (motion.position_m - before.position_m);
                let time_s = time_s + (substep as f64 + share) * dt_s;
                return Some(Trip { length_m, ..end(trip, &motion, &before, share, time_s) });
            }
        }
        let (low_mps, high_mps) = trip.speed_range_mps;
        trip.speed_range_mps = (low_mps.min(motion.speed_mps), high_mps.max(motion.speed_mps));
        if traffic.is_none() && motion.speed_mps < STUCK_MPS {
            return None;
        }
    }
    None
}
