//! The value of energy and time in fuel, which both planners use.

use truck_model::{GEARS, Truck};

/// Engine torques between which the price of energy is taken, N m of the generic engine.
const PRICED_NM: (f64, f64) = (300.0, 1200.0);
/// Half width of the difference that prices time, m/s.
const PRICED_MPS: f64 = 0.5;

/// Prices at a set speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prices {
    /// gamma: fuel for one joule more at the wheels, g/J.
    pub energy_gpj: f64,
    /// beta_0: the price of time at which the set speed is the best speed on the flat, g/s.
    pub time_gps: f64,
    /// Cost of one shift: the work that is not done while traction is interrupted, g.
    pub shift_g: f64,
}

impl Prices {
    /// Prices of a truck at a set speed, in its highest gear.
    pub fn new(truck: &Truck, set_speed_mps: f64) -> Self {
        let top = GEARS - 1;
        let scale = truck.parameters().engine_scale;
        let rpm = truck.engine_rpm(set_speed_mps, top);
        let (low_nm, high_nm) = (PRICED_NM.0 * scale, PRICED_NM.1 * scale);
        let fuel_gps = |torque_nm| truck.engine().fuel_gps(rpm, torque_nm);
        let crank_w = truck.crank_radians_per_m(top) * set_speed_mps * (high_nm - low_nm);
        let energy_gpj = (fuel_gps(high_nm) - fuel_gps(low_nm))
            / (crank_w * truck.parameters().driveline_efficiency);

        let fuel_gpm = |speed_mps: f64| {
            let net_nm = truck.net_torque_nm(truck.resistance_n(speed_mps, 0.0), top);
            truck.fuel_gps(speed_mps, top, net_nm) / speed_mps
        };
        let rise = fuel_gpm(set_speed_mps + PRICED_MPS) - fuel_gpm(set_speed_mps - PRICED_MPS);
        Self {
            energy_gpj,
            time_gps: set_speed_mps * set_speed_mps * rise / (2.0 * PRICED_MPS),
            shift_g: energy_gpj
                * truck.resistance_n(set_speed_mps, 0.0)
                * set_speed_mps
                * truck_model::TRACTION_INTERRUPTION_S,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truck_model::Preset;

    /// The page takes the derivative behind the price of time from the engine's raw map, not from its fit.
    #[test]
    fn prices_are_those_of_the_page() {
        for (preset, time_gps) in [(Preset::Jh6At49T, 3.1), (Preset::Jh6At25T, 2.8)] {
            let prices = Prices::new(&Truck::preset(preset), 75.0 / 3.6);
            assert!((prices.energy_gpj - 5.1e-5).abs() < 0.15e-5, "{prices:?}");
            assert!((prices.time_gps - time_gps).abs() < 0.4, "{prices:?}");
        }
    }
}
