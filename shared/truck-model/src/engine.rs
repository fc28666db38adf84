//! Torque limits and fuel of the engine.
//!
//! The limits are those of VECTO's generic 12.7 L, 325 kW engine. The fuel is a fit to its map, in
//! mg per crank radian. n is in 1000 rpm and T in kN m:
//!
//! ```text
//! (5) q(n, T) = 19.549 - 20.373 n + 8.035 n² + 39.892 T + 4.7 T²     T >= 0
//! ```
//!
//! Fuel falls linearly from q(n, 0) to zero at the drag torque, where the injection is cut. The fit
//! holds from 1000 rpm on; below, q keeps its value at 1000 rpm. A smaller engine has torque, drag
//! and fuel scaled by one factor.

pub(crate) const IDLE_RPM: f64 = 600.0;
/// First entry and step of the tables of limits \[rpm\].
const TABLE_START_RPM: f64 = 600.0;
const TABLE_STEP_RPM: f64 = 200.0;
/// Full load, drag with the injection cut, and engine brake \[N m\] at 600, 800 ... 2200 rpm. The
/// first two are VECTO's; the brake is an assumption for the compression-release kind.
const FULL_LOAD_NM: [f64; 9] =
    [1188.0, 1661.0, 2134.0, 2134.0, 2134.0, 1928.0, 1722.0, 1253.0, 0.0];
const DRAG_NM: [f64; 9] = [-138.0, -143.0, -152.0, -165.0, -187.0, -217.0, -244.0, -278.0, -314.0];
const BRAKE_NM: [f64; 9] =
    [-138.0, -400.0, -650.0, -850.0, -1050.0, -1250.0, -1400.0, -1500.0, -1500.0];

/// Factor from revolutions per minute to radians per second.
pub(crate) const RADPS_PER_RPM: f64 = core::f64::consts::PI / 30.0;

/// Generic engine, scaled.
///
/// ```
/// use truck_model::Engine;
///
/// let engine = Engine::new(1.0);
/// let rpm = 1200.0;
/// assert_eq!(engine.max_torque_nm(rpm), 2134.0);
/// // The injection is cut at the drag torque and below.
/// assert_eq!(engine.fuel_gps(rpm, engine.drag_torque_nm(rpm)), 0.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Engine {
    scale: f64,
}

impl Engine {
    /// Returns an engine with `scale` times the torque, drag and fuel of the generic one.
    pub fn new(scale: f64) -> Self {
        Self { scale }
    }

    /// Returns the highest torque at the crankshaft \[N m\].
    pub fn max_torque_nm(&self, speed_rpm: f64) -> f64 {
        self.scale * interpolated(&FULL_LOAD_NM, speed_rpm)
    }

    /// Returns the torque with the injection cut \[N m\], negative.
    pub fn drag_torque_nm(&self, speed_rpm: f64) -> f64 {
        self.scale * interpolated(&DRAG_NM, speed_rpm)
    }

    /// Returns the torque with the injection cut and the full engine brake \[N m\], negative.
    pub fn brake_torque_nm(&self, speed_rpm: f64) -> f64 {
        self.scale * interpolated(&BRAKE_NM, speed_rpm)
    }

    /// Returns the fuel flow at a crankshaft torque \[g/s\] (equation 5).
    pub fn fuel_gps(&self, speed_rpm: f64, torque_nm: f64) -> f64 {
        1e-3 * speed_rpm * RADPS_PER_RPM * self.fuel_mg_per_rad(speed_rpm, torque_nm)
    }

    fn fuel_mg_per_rad(&self, speed_rpm: f64, torque_nm: f64) -> f64 {
        let n = (1e-3 * speed_rpm).max(1.0);
        let idle = 19.549 - 20.373 * n + 8.035 * n * n;
        if torque_nm >= 0.0 {
            let t = 1e-3 * torque_nm / self.scale;
            self.scale * (idle + 39.892 * t + 4.7 * t * t)
        } else {
            let share = 1.0 - torque_nm / self.drag_torque_nm(speed_rpm);
            self.scale * idle * share.max(0.0)
        }
    }
}

fn interpolated(table: &[f64; 9], speed_rpm: f64) -> f64 {
    let place = ((speed_rpm - TABLE_START_RPM) / TABLE_STEP_RPM).clamp(0.0, 8.0);
    let index = (place as usize).min(7);
    table[index] + (place - index as f64) * (table[index + 1] - table[index])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_table() {
        let engine = Engine::new(1.0);
        assert_eq!(engine.max_torque_nm(1400.0), 2134.0);
        assert_eq!(engine.max_torque_nm(1600.0), 1928.0);
        assert_eq!(engine.drag_torque_nm(1800.0), -244.0);
        assert_eq!(Engine::new(0.68).max_torque_nm(1000.0), 0.68 * 2134.0);
        assert_eq!(engine.max_torque_nm(5000.0), 0.0);
    }

    #[test]
    fn fuel_is_near_the_map_it_was_fitted_to() {
        // VECTO's map: rpm, N m, g/h.
        let map = [
            (1000.0, 371.0, 8540.0),
            (1000.0, 1857.0, 36545.0),
            (1200.0, 0.0, 3070.0),
            (1200.0, 1114.0, 26164.0),
            (1200.0, 2043.0, 48079.0),
            (1400.0, 928.0, 25155.0),
            (1600.0, 1671.0, 52942.0),
            (1800.0, 743.0, 28319.0),
        ];
        let engine = Engine::new(1.0);
        for (rpm, torque, gph) in map {
            let fit = 3600.0 * engine.fuel_gps(rpm, torque);
            assert!((fit / gph - 1.0).abs() < 0.05, "{rpm} rpm, {torque} N m: {fit}, map {gph}");
        }
    }

    #[test]
    fn injection_is_cut_at_drag_and_below() {
        let engine = Engine::new(0.68);
        let drag = engine.drag_torque_nm(1200.0);
        assert_eq!(engine.fuel_gps(1200.0, drag), 0.0);
        assert_eq!(engine.fuel_gps(1200.0, 3.0 * drag), 0.0);
        let half = engine.fuel_gps(1200.0, 0.5 * drag);
        assert!((half / engine.fuel_gps(1200.0, 0.0) - 0.5).abs() < 1e-12);
    }
}
