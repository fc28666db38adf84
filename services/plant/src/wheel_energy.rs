//! The energy that a car's drive takes at the wheels.
//!
//! ```text
//! F = m (a + g f + g i) + rho c_d A v² / 2        E = integral of max(F, 0) over the way
//! ```
//!
//! | symbol | value | unit |
//! |---|---|---|
//! | m | `mass_kg` of `[plant]`'s powertrain, else [`Numbers::car_mass_kg`] | kg |
//! | f | [`Numbers::rolling`] | |
//! | i | mean grade of the way: rise over way | |
//! | rho c_d A | [`Numbers::drag_kgpm`] | kg/m |
//!
//! Source: Mitschke and Wallentowitz, Dynamik der Kraftfahrzeuge (5th ed.), chapter 5; the coefficients are
//! those of a saloon car.

use scenario::Scenario;
use scenario::grade::GradeProfile;
use scenario::plant::Vehicle;
use serde::{Deserialize, Serialize};

use crate::longitudinal::State;
use crate::numbers::Numbers;

const GRAVITY_MPS2: f64 = 9.81;
/// Way up to which a consumption is not stated, m. Chosen: on a shorter one a single start decides the figure.
const LEAST_WAY_M: f64 = 100.0;
const KWH_J: f64 = 3.6e6;

/// The energy so far.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct WheelEnergy {
    rolling: f64,
    drag_kgpm: f64,
    mass_kg: f64,
    energy_j: f64,
    way_m: f64,
}

impl WheelEnergy {
    /// A car before its drive; `None` for a truck, whose fuel is known.
    pub(crate) fn of(scenario: &Scenario, numbers: &Numbers) -> Option<Self> {
        let plant = &scenario.plant;
        let own_kg = plant.powertrain.map(|powertrain| powertrain.mass_kg.value());
        let mass_kg = own_kg.unwrap_or(numbers.car_mass_kg);
        let Numbers { rolling, drag_kgpm, .. } = *numbers;
        let still = Self { rolling, drag_kgpm, mass_kg, energy_j: 0.0, way_m: 0.0 };
        (plant.vehicle == Vehicle::Car).then_some(still)
    }

    /// Adds the drive from one state to the next; `heights` are those of a road that is not level.
    pub(crate) fn add(&mut self, from: &State, to: &State, heights: Option<&GradeProfile>) {
        let way_m = to.position_m - from.position_m;
        let speed_mps = 0.5 * (from.speed_mps + to.speed_mps);
        let acceleration_mps2 = 0.5 * (from.acceleration_mps2 + to.acceleration_mps2);
        let Self { rolling, drag_kgpm, .. } = *self;
        let slope_mps2 = heights.map_or(0.0, |heights| {
            GRAVITY_MPS2 * heights.mean_grade(from.position_m, to.position_m)
        });
        let force_n = self.mass_kg * (acceleration_mps2 + rolling * GRAVITY_MPS2 + slope_mps2)
            + 0.5 * drag_kgpm * speed_mps * speed_mps;
        self.energy_j += force_n.max(0.0) * way_m;
        self.way_m += way_m;
    }

    pub(crate) fn kwh_per_100km(&self) -> Option<f64> {
        (self.way_m > LEAST_WAY_M).then(|| self.energy_j / KWH_J / (self.way_m / 1e5))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_speed_costs_its_resistance() {
        let scenario = Scenario::parse("x", "schema_version = 1\nname = \"x\"\n");
        let mut energy =
            WheelEnergy::of(&scenario.expect("it is right"), &Numbers::DEFAULT).expect("a car");
        let at = |position_m| State { position_m, speed_mps: 30.0, acceleration_mps2: 0.0 };
        assert_eq!(energy.kwh_per_100km(), None);
        for k in 0..1000 {
            energy.add(&at(f64::from(k)), &at(f64::from(k + 1)), None);
        }
        // 172.7 N of rolling resistance and 344.7 N of drag over 100 km.
        let found = energy.kwh_per_100km().expect("1 km");
        assert!((found - 517.4 * 1e5 / 3.6e6).abs() < 0.01, "{found}");
    }
    #[test]
    fn a_climb_costs_its_height() {
        let text = "schema_version = 1\nname = \"x\"\nroad.points = [[0, 0], [400, 8]]\n";
        let scenario = Scenario::parse("x", text).expect("it is right");
        let mut energy = WheelEnergy::of(&scenario, &Numbers::DEFAULT).expect("a car");
        let heights = scenario.road.profile().expect("it is right");
        let at = |position_m| State { position_m, speed_mps: 30.0, acceleration_mps2: 0.0 };
        for k in 0..400 {
            energy.add(&at(f64::from(k)), &at(f64::from(k + 1)), Some(&heights));
        }
        // 517.4 N as on a level road, and the weight of 1600 kg on 2 %.
        let found = energy.kwh_per_100km().expect("400 m");
        assert!((found - (517.4 + 0.02 * 1600.0 * 9.81) * 1e5 / 3.6e6).abs() < 0.01, "{found}");
    }
}
