//! Limits and fuel of one gear at one speed, over tractive force.
//!
//! The fuel per metre is, exactly above no force and nearly so below,
//!
//! ```text
//! fuel(F) = max(0, p_0 + max(p_- F, p_1 F + p_2 F²))
//! ```
//!
//! which needs neither root nor division, and no branch. Below, the map's kink at no engine torque, between
//! the drag and the auxiliaries' torque, is straightened.

use super::bounds::Moment;
use super::settings::BoundKeys;
use truck_model::Truck;

/// Engine speeds at which a gear may be planned with, rpm: full power is reached before the upper one.
const ENGINE_RPM: (f64, f64) = (800.0, 1600.0);

/// Limits and fuel of one gear at one speed, over tractive force.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GearCurve {
    /// True if the engine can turn in this gear.
    pub(crate) usable: bool,
    /// Least and largest force, N: with the injection cut and at full load, unless a plan's bounds are tighter.
    pub(crate) min_n: f64,
    pub(crate) max_n: f64,
    /// Fuel at no force, g/m.
    p0: f64,
    /// Slope below it, g/(m N).
    below: f64,
    /// Slope and curvature above it.
    p1: f64,
    p2: f64,
}

impl GearCurve {
    pub(crate) fn new(bounds: &BoundKeys, truck: &Truck, speed_mps: f64, gear: usize) -> Self {
        let rpm = truck.engine_rpm(speed_mps, gear);
        let usable = (ENGINE_RPM.0..ENGINE_RPM.1).contains(&rpm);
        let (min_nm, max_nm) = truck.net_torque_limits_nm(speed_mps, gear);
        let (min_n, max_n) = (truck.force_n(min_nm, gear), truck.force_n(max_nm, gear));
        let fuel_gpm = |net_nm: f64| truck.fuel_gps(speed_mps, gear, net_nm) / speed_mps;
        let p0 = fuel_gpm(0.0);
        // The fit is quadratic: two more points give it exactly.
        let (half, full) = (fuel_gpm(0.5 * max_nm) - p0, fuel_gpm(max_nm) - p0);
        let (least_nm, most_nm) = Moment { truck, speed_mps, gear, grade: 0.0 }.limits_nm(bounds);
        let auxiliary_nm = truck.auxiliary_torque_nm(rpm);
        Self {
            usable,
            min_n: truck.force_n(least_nm - auxiliary_nm, gear),
            max_n: truck.force_n(most_nm - auxiliary_nm, gear),
            p0,
            below: -p0 / min_n,
            p1: (4.0 * half - full) / max_n,
            p2: (2.0 * full - 4.0 * half) / (max_n * max_n),
        }
    }

    #[inline]
    pub(crate) fn fuel_gpm(&self, force_n: f64) -> f64 {
        let low = self.below * force_n;
        let high = force_n * (self.p1 + self.p2 * force_n);
        let fuel = self.p0 + if low > high { low } else { high };
        if fuel > 0.0 { fuel } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truck_model::Preset;

    #[test]
    fn the_curve_is_the_trucks_fuel() {
        for preset in Preset::ALL {
            let truck = Truck::preset(preset);
            for (speed_mps, gear) in [(17.0, 4), (20.8, 5), (22.2, 5)] {
                let curve = GearCurve::new(&BoundKeys::default(), &truck, speed_mps, gear);
                let top_gpm = curve.fuel_gpm(curve.max_n);
                for share in 0..=40 {
                    let span_n = curve.max_n - curve.min_n;
                    let force_n = curve.min_n + span_n * f64::from(share) / 40.0;
                    let net_nm = truck.net_torque_nm(force_n, gear);
                    let exact_gpm = truck.fuel_gps(speed_mps, gear, net_nm) / speed_mps;
                    let off = (curve.fuel_gpm(force_n) - exact_gpm).abs();
                    let tolerance = if force_n >= 0.0 { 1e-9 } else { 2e-3 };
                    assert!(off < tolerance * top_gpm, "{force_n} N: {off} g/m off");
                }
                assert_eq!(curve.fuel_gpm(2.0 * curve.min_n), 0.0);
            }
        }
    }
}
