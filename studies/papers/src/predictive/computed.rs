//! Figures computed without processes: the full-route plan, human driver models, generated roads.

use super::SET_SPEED_MPS;
use crate::trips::{Assisted, Bound, Cruise, Driver, Human, Map, Road, Trip, at_equal_time, drive};
use controller::laws::truck::{Keys, Prices, Settings};
use scenario::grade::{Alignment, GradeProfile, generate};
use truck_model::{Preset, Truck};

/// Length of a road's cells, m.
const CELL_M: f64 = 50.0;
/// Nodes of the full-route plan's grid over kinetic energy.
const FULL_ROUTE_NODES: usize = 400;
/// Seeds over which a driver's fuel is averaged.
const HUMAN_SEEDS: u64 = 4;
/// Standard deviations of the drivers' aim, m/s.
const HUMAN_SIGMAS_MPS: [f64; 2] = [2.5 / 3.6, 4.0 / 3.6];
/// Excess over the set speed that a driver accepts, m/s.
const ABOVE_SET_MPS: f64 = 5.0 / 3.6;
/// Prices of time around the one at which the full-route plan takes the baseline's trip time.
const PRICES: (f64, f64) = (0.3, 4.0);
/// Aims, as parts of the set speed, around the one at which a driver takes the baseline's trip time.
const AIMS: (f64, f64) = (0.95, 1.06);
/// Mean speeds, as parts of the set speed, around the one at which the law takes the baseline's trip time.
const MEANS: (f64, f64) = (0.97, 1.04);

/// Roads on which the planner is compared with the full-route plan.
pub const GENERATED: u64 = 10;

/// A truck on a road at constant speed: the baseline.
pub struct Baseline {
    truck: Truck,
    road: Road,
    energy_gpj: f64,
    trip: Trip,
}

impl Baseline {
    /// Drives it; `None` when the truck gets stuck.
    pub fn drive(preset: Preset, profile: &GradeProfile) -> Option<Self> {
        let truck = Truck::preset(preset);
        let count = (profile.end_m() / CELL_M).round() as u32;
        let cell = |index: u32| {
            let from_m = f64::from(index) * CELL_M;
            profile.mean_grade(from_m, from_m + CELL_M)
        };
        let road = Road::new(CELL_M, (0..count).map(cell).collect());
        let mut cruise = Cruise::new(&truck, SET_SPEED_MPS, limit_mps());
        let trip = drive(&truck, &road, SET_SPEED_MPS, &mut cruise)?;
        let energy_gpj = Prices::new(&truck, SET_SPEED_MPS).energy_gpj;
        Some(Self { truck, road, energy_gpj, trip })
    }

    /// Fuel, L/100 km.
    pub fn litres(&self) -> f64 {
        self.trip.corrected_l_per_100_km(self.energy_gpj)
    }

    /// Fuel of the dynamic program over the full route, percent. On its grid of kinetic energies that is the best plan.
    /// On the road another plan can be a little better, so it is not a lower bound.
    pub fn full_route_percent(&self) -> Option<f64> {
        self.change(PRICES, |price| {
            let (truck, nodes) = (&self.truck, FULL_ROUTE_NODES);
            Bound::solve(truck, &self.road, SET_SPEED_MPS, limit_mps(), price, nodes)
        })
    }

    /// Fuel of the law with the dynamic program over two kilometres, percent.
    pub fn planned_percent(&self) -> Option<f64> {
        self.change(MEANS, |mean_speed| {
            let map = Map { road: self.road.clone(), shift_m: 0.0 };
            let keys = Keys { mean_speed, ..Keys::default() };
            Assisted::new(&Settings::of_keys(&self.truck, &keys), SET_SPEED_MPS, map)
        })
    }

    /// Mean fuel of human driver models with each of the two deviations of the aim, and with another deviation, m/s,
    /// percent.
    pub fn human_percent(&self, other_mps: f64) -> [Option<f64>; 3] {
        let [calm, restless] = HUMAN_SIGMAS_MPS;
        let of = |sigma_mps: f64| {
            let changes = (1..=HUMAN_SEEDS).map(|seed| {
                self.change(AIMS, |part| {
                    let aim_mps = part * SET_SPEED_MPS;
                    Human::new(&self.truck, aim_mps, limit_mps(), sigma_mps, seed)
                })
            });
            let changes = changes.collect::<Option<Vec<f64>>>()?;
            Some(changes.iter().sum::<f64>() / changes.len() as f64)
        };
        let calm_percent = of(calm);
        let other = if other_mps == calm { calm_percent } else { of(other_mps) };
        [calm_percent, of(restless), other]
    }

    /// Fuel at equal trip time, percent; `driver` is faster for larger numbers.
    fn change<D: Driver>(&self, range: (f64, f64), driver: impl Fn(f64) -> D) -> Option<f64> {
        let trip = at_equal_time(self.trip.time_s, range, |x| {
            drive(&self.truck, &self.road, SET_SPEED_MPS, &mut driver(x))
        })?;
        let litres = trip.corrected_l_per_100_km(self.energy_gpj);
        Some(100.0 * (litres / self.litres() - 1.0))
    }
}

/// The road of a seed, like the given one.
pub fn generated(seed: u64) -> GradeProfile {
    let alignment = Alignment {
        length_m: 60e3,
        grade_sigma: 0.0138,
        max_grade: 0.03,
        tangent_m: [300.0, 1500.0],
        curve_m: 300.0,
        closed: true,
    };
    generate(&alignment, seed)
}

fn limit_mps() -> f64 {
    SET_SPEED_MPS + ABOVE_SET_MPS
}
