//! One truck on one road: the fuel of each driver against constant speed, at equal trip time.

use super::{Assisted, Bound, Cruise, Driver, Human, Map, Road, Trip, at_equal_time, drive};
use controller::laws::truck::{BoundKeys, Keys, PlannerKind, Prices, Settings, max_speed_mps};
use truck_model::Truck;

/// Range of the mean speed over the set speed in which equal trip time is looked for.
const MEAN_SPEEDS: (f64, f64) = (0.97, 1.04);
/// Range of the price of time over the flat's.
const TIME_PRICES: (f64, f64) = (0.3, 4.0);
/// Range of a driver's aim over the set speed.
const AIMS: (f64, f64) = (0.95, 1.06);
/// Nodes of the full-route plan's grid over kinetic energy.
const BOUND_NODES: usize = 400;

/// A truck, a road and the trip at constant speed.
#[derive(Clone, Debug)]
pub struct Comparison {
    truck: Truck,
    road: Road,
    set_speed_mps: f64,
    /// Price of energy, g/J.
    pub energy_gpj: f64,
    /// The trip at constant speed.
    pub baseline: Trip,
}

impl Comparison {
    /// Drives the baseline; `None` when the truck gets stuck on this road.
    pub fn new(truck: &Truck, road: &Road, set_speed_mps: f64) -> Option<Self> {
        let mut cruise = Cruise::new(truck, set_speed_mps, limit_mps(set_speed_mps));
        Some(Self {
            truck: *truck,
            road: road.clone(),
            set_speed_mps,
            energy_gpj: Prices::new(truck, set_speed_mps).energy_gpj,
            baseline: drive(truck, road, set_speed_mps, &mut cruise)?,
        })
    }

    /// Fuel of a trip at equal kinetic energy at both ends, L/100 km.
    pub fn l_per_100_km(&self, trip: &Trip) -> f64 {
        trip.corrected_l_per_100_km(self.energy_gpj)
    }

    /// Fuel of a trip against the baseline's, percent; savings are negative.
    pub fn change_percent(&self, trip: &Trip) -> f64 {
        100.0 * (self.l_per_100_km(trip) / self.l_per_100_km(&self.baseline) - 1.0)
    }

    /// The law with a planner; it assumes the truck to be `believed` and the road to be `map`.
    pub fn assisted(&self, planner: PlannerKind, believed: &Truck, map: &Map) -> Option<Trip> {
        self.equal_time(MEAN_SPEEDS, |mean_speed| {
            let keys = Keys { planner, mean_speed, ..Keys::default() };
            Assisted::new(&Settings::of_keys(believed, &keys), self.set_speed_mps, map.clone())
        })
    }

    /// The law with a planner, rightly informed.
    pub fn informed(&self, planner: PlannerKind) -> Option<Trip> {
        let map = Map { road: self.road.clone(), shift_m: 0.0 };
        self.assisted(planner, &self.truck, &map)
    }

    /// The dynamic program over the whole route. On its grid of kinetic energies that is the best plan. On the road
    /// another plan can be a little better, so it is not a lower bound.
    pub fn bound(&self) -> Option<Trip> {
        let (set_mps, limit_mps) = (self.set_speed_mps, limit_mps(self.set_speed_mps));
        self.equal_time(TIME_PRICES, |price| {
            Bound::solve(&self.truck, &self.road, set_mps, limit_mps, price, BOUND_NODES)
        })
    }

    /// A driver whose aim has a standard deviation of `sigma_mps`.
    pub fn human(&self, sigma_mps: f64, seed: u64) -> Option<Trip> {
        let limit_mps = limit_mps(self.set_speed_mps);
        self.equal_time(AIMS, |share| {
            Human::new(&self.truck, share * self.set_speed_mps, limit_mps, sigma_mps, seed)
        })
    }

    /// The trip of equal time; `driver` is faster for larger numbers.
    fn equal_time<D: Driver>(&self, range: (f64, f64), driver: impl Fn(f64) -> D) -> Option<Trip> {
        at_equal_time(self.baseline.time_s, range, |x| {
            drive(&self.truck, &self.road, self.set_speed_mps, &mut driver(x))
        })
    }
}

/// Speed above which all of them brake, m/s.
fn limit_mps(set_speed_mps: f64) -> f64 {
    max_speed_mps(&BoundKeys::default(), set_speed_mps, f64::INFINITY)
}
