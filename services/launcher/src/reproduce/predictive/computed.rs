//! What is computed without processes: the bound, and drivers of flesh and blood.

use super::SET_SPEED_MPS;
use controller::predictive::Prices;
use controller::predictive::route::{Bound, Cruise, Driver, Human, Road, Trip, drive};
use shared::road::GradeProfile;
use truck_model::{Preset, Truck};

/// Length of a road's cells, m.
const CELL_M: f64 = 50.0;
/// Nodes of the bound's grid over kinetic energy.
const BOUND_NODES: usize = 400;
/// Seeds over which a driver's fuel is averaged.
const HUMAN_SEEDS: u64 = 8;
/// Standard deviations of the drivers' aim, m/s.
const HUMAN_SIGMAS_MPS: [f64; 2] = [2.5 / 3.6, 4.0 / 3.6];
/// Trips until the trip time is that of the baseline.
const ATTEMPTS: usize = 12;
/// Largest difference of trip times that counts as none, as a fraction.
const EQUAL_TIME: f64 = 1e-3;
/// How far a driver lets the truck exceed the set speed, m/s.
const ABOVE_SET_MPS: f64 = 5.0 / 3.6;

/// Fuel of a truck on a road; changes are in percent against constant speed at equal trip time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Computed {
    pub constant_speed_l_per_100km: Option<f64>,
    pub bound_percent: Option<f64>,
    pub human_percent: [Option<f64>; 2],
}

/// Computes all of it.
pub fn on(preset: Preset, profile: &GradeProfile) -> Computed {
    let truck = Truck::preset(preset);
    let count = (profile.end_m() / CELL_M).round() as u32;
    let cell = |index: u32| {
        let from_m = f64::from(index) * CELL_M;
        profile.mean_grade(from_m, from_m + CELL_M)
    };
    let road = Road::new(CELL_M, (0..count).map(cell).collect());
    let limit_mps = SET_SPEED_MPS + ABOVE_SET_MPS;
    let energy_gpj = Prices::new(&truck, SET_SPEED_MPS).energy_gpj;
    let litres = |trip: &Trip| trip.corrected_l_per_100_km(energy_gpj);
    let mut cruise = Cruise::new(&truck, SET_SPEED_MPS, limit_mps);
    let Some(baseline) = drive(&truck, &road, SET_SPEED_MPS, &mut cruise) else {
        let none = [None; 2];
        return Computed {
            constant_speed_l_per_100km: None,
            bound_percent: None,
            human_percent: none,
        };
    };
    let change = |trip: &Trip| 100.0 * (litres(trip) / litres(&baseline) - 1.0);
    // A higher price of time makes the bound faster: the exponent is an elasticity.
    let bound = at_equal_time(&truck, &road, &baseline, 12.0, &|price| {
        Box::new(Bound::solve(&truck, &road, SET_SPEED_MPS, limit_mps, price, BOUND_NODES))
    });
    let human_percent = HUMAN_SIGMAS_MPS.map(|sigma_mps| {
        let changes = (1..=HUMAN_SEEDS).map(|seed| {
            let trip = at_equal_time(&truck, &road, &baseline, 1.0, &|factor| {
                let aim_mps = SET_SPEED_MPS * factor;
                Box::new(Human::new(&truck, aim_mps, limit_mps, sigma_mps, seed))
            });
            trip.map(|trip| change(&trip))
        });
        let changes: Option<Vec<f64>> = changes.collect();
        changes.map(|changes| changes.iter().sum::<f64>() / changes.len() as f64)
    });
    Computed {
        constant_speed_l_per_100km: Some(litres(&baseline)),
        bound_percent: bound.map(|trip| change(&trip)),
        human_percent,
    }
}

/// The trip of a driver whose factor was moved until its time is the baseline's; `None` when that
/// does not come about. Time falls about as the factor to the power of one over `elasticity`.
fn at_equal_time(
    truck: &Truck,
    road: &Road,
    baseline: &Trip,
    elasticity: f64,
    driver: &dyn Fn(f64) -> Box<dyn Driver>,
) -> Option<Trip> {
    let mut factor = 1.0;
    for _ in 0..ATTEMPTS {
        let trip = drive(truck, road, SET_SPEED_MPS, driver(factor).as_mut())?;
        let slower = trip.time_s / baseline.time_s;
        if (slower - 1.0).abs() <= EQUAL_TIME {
            return Some(trip);
        }
        factor *= libm::pow(slower, elasticity);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scratch() {
        let road = shared::scenario::Scenario::open(
            "truck-hills",
            &shared::scenario::Overrides::new(),
            &|_| Ok(()),
        )
        .expect("built in")
        .road
        .profile()
        .expect("a road");
        for preset in Preset::ALL {
            let begun = std::time::Instant::now();
            println!("{:?} {:?} {:?}", preset, on(preset, &road), begun.elapsed());
        }
    }
}
