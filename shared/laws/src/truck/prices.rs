//! The value of energy and time in fuel, which both planners use, and the servo that keeps the mean speed. It makes time
//! dearer while the truck is late.
//!
//! ```text
//! lag' = 1 - v / v_ref        beta / beta_0 = p_0 + k_m (m - 1) + k_p lag + k_i ∫ lag dt
//! ```
//!
//! v_ref is the speed, on the same metre, of another truck ([`Reference`]). It keeps m times the set speed where its
//! engine can. No price makes up for a climb that full load cannot hold. A lag counted from the set speed itself would
//! swing the price with every long wave of the road. The rest is the planner's own lateness. The servo is slow on
//! purpose. A hill makes a lag, and the dip after it takes it back. So the lag is not a reason to hurry. A mean speed m
//! that is asked for moves the price at once, not by a lag that builds up.

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

/// k_p, 1/s.
const PROPORTIONAL_PER_S: f64 = 0.008;
/// k_i, 1/s²: with the response below a third of the critical damping.
const INTEGRAL_PER_S2: f64 = PROPORTIONAL_PER_S / 4000.0;
/// k_m: price per relative mean speed. On generated hills either planner answers to one more unit of price
/// with 2 to 5 % of mean speed (docs/measurements.md).
const PRICE_PER_MEAN: f64 = 20.0;
/// Range of beta / beta_0.
const RANGE: (f64, f64) = (0.5, 5.0);

#[derive(Clone, Copy, Debug, Default)]
pub struct TimePrice {
    initial: f64,
    pub lag_s: f64,
    integral: f64,
}

impl TimePrice {
    /// A servo whose truck is in time at the price p_0, relative to beta_0, at its set speed. Here it must keep
    /// `mean_speed` times it.
    pub fn new(usual: f64, mean_speed: f64) -> Self {
        let initial = usual + PRICE_PER_MEAN * (mean_speed - 1.0);
        Self { initial, lag_s: 0.0, integral: 0.0 }
    }

    /// Accounts for `dt_s` on a way that was due in `due_s`.
    pub fn update(&mut self, dt_s: f64, due_s: f64) {
        self.lag_s += dt_s - due_s;
        let free = self.initial + PROPORTIONAL_PER_S * self.lag_s + self.integral;
        let saturated =
            (free > RANGE.1 && self.lag_s > 0.0) || (free < RANGE.0 && self.lag_s < 0.0);
        if !saturated {
            self.integral += INTEGRAL_PER_S2 * self.lag_s * dt_s;
        }
    }

    /// beta / beta_0.
    pub fn value(&self) -> f64 {
        (self.initial + PROPORTIONAL_PER_S * self.lag_s + self.integral).clamp(RANGE.0, RANGE.1)
    }
}

/// Slowest speed, m/s: starting is not part of a cruise.
const SLOWEST_MPS: f64 = 3.0;
/// Longest step, m: over it forces are constant.
const STEP_M: f64 = 5.0;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Speeds {
    pub set_mps: f64,
    pub limit_mps: f64,
    /// With which it starts: the real truck's.
    pub start_mps: f64,
}

/// The truck that keeps its speed, driven in distance: the time that a road takes without a plan.
///
/// It drives over the same metres as the real truck. It keeps its set speed if engine and drag can hold it. Uphill it is
/// slower at full load, and downhill it goes up to the limit. It is always in its strongest gear and never shifts. On a
/// long climb of 3 % that makes it up to 8 % faster than the plant's truck.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reference {
    speed_mps: Option<f64>,
}

impl Reference {
    /// Drives on for `distance_m` of one grade; the time that it takes, s.
    pub fn advance(&mut self, truck: &Truck, distance_m: f64, grade: f64, speeds: &Speeds) -> f64 {
        let mut speed_mps = self.speed_mps.unwrap_or(speeds.start_mps).max(SLOWEST_MPS);
        let mut time_s = 0.0;
        let steps = (distance_m / STEP_M).ceil().max(1.0);
        let step_m = distance_m / steps;
        for _ in 0..steps as u32 {
            let (low_n, high_n) = forces_n(truck, speed_mps);
            let energy_j = truck.kinetic_energy_j(speed_mps);
            let resistance_n = truck.resistance_n(speed_mps, grade);
            let after =
                |force_n: f64| truck.speed_mps(energy_j + step_m * (force_n - resistance_n));
            let kept_mps = speeds.set_mps.max(after(low_n)).min(after(high_n));
            let end_mps = kept_mps.min(speeds.limit_mps).max(SLOWEST_MPS);
            time_s += 2.0 * step_m / (speed_mps + end_mps);
            speed_mps = end_mps;
        }
        self.speed_mps = Some(speed_mps);
        time_s
    }
}

/// Tractive force with the injection cut, in the highest gear that turns the engine, N. The second is the
/// most that any gear gives.
fn forces_n(truck: &Truck, speed_mps: f64) -> (f64, f64) {
    let gears = (0..GEARS).filter(|&gear| truck.gear_allowed(speed_mps, gear));
    gears.fold((0.0, 0.0), |(_, most_n): (f64, f64), gear| {
        let (drag_nm, full_nm) = truck.net_torque_limits_nm(speed_mps, gear);
        (truck.force_n(drag_nm, gear), most_n.max(truck.force_n(full_nm, gear)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use truck_model::Preset;

    #[test]
    fn a_late_truck_pays_more_for_time_until_it_is_in_time() {
        let mut price = TimePrice::new(1.3, 1.0);
        // A truck whose speed answers to the price: 20 m/s at 1.6.
        let mut speed_mps = 19.8;
        for _ in 0..1_200_000 {
            price.update(0.1, 0.1 * speed_mps / 20.0);
            speed_mps = 20.0 + 0.5 * (price.value() - 1.6);
        }
        assert!(price.lag_s.abs() < 1.0, "{price:?}");
        assert!((price.value() - 1.6).abs() < 0.01, "{price:?}");
    }

    #[test]
    fn a_truck_that_cannot_go_faster_winds_nothing_up() {
        let mut price = TimePrice::new(1.3, 1.0);
        for _ in 0..100_000 {
            price.update(0.1, 0.05);
        }
        assert_eq!(price.value(), RANGE.1);
        assert!(price.integral < 1.0, "{price:?}");
    }

    #[test]
    fn a_higher_mean_speed_has_its_price_at_once() {
        let (usual, faster) = (TimePrice::new(1.3, 1.0), TimePrice::new(1.3, 1.02));
        assert!((faster.value() - usual.value() - 0.4).abs() < 1e-12);
    }

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
