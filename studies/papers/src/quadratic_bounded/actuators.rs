//! Throttle opening and brake pressure behind a course of speed and acceleration. They come from the inverse
//! longitudinal model between the paper's law and CarSim's car (figures 3c, 4c, 5c).
//!
//! ```text
//! m a = F_engine - F_brake - m g f - rho c_d A v²/2
//! F_engine = i (T_closed(n) + throttle (T_full(n) - T_closed(n))) / r,    n = i v / r
//! F_brake  = K p / r
//! ```
//!
//! The car of the paper is not described. Ours is a mid-size saloon in its top gear: the scenes stay
//! between 79 and 110 km/h. Its values are usual ones of textbooks (Mitschke, Wallentowitz: Dynamik der
//! Kraftfahrzeuge), chosen once and fitted to nothing.

const MASS_KG: f64 = 1500.0;
/// Rolling resistance, as a share of the weight.
const ROLLING: f64 = 0.012;
/// Half the density of air times drag coefficient times frontal area, kg/m: 0.5 · 1.2 · 0.31 · 2.2.
const DRAG_KG_PER_M: f64 = 0.409;
/// Engine turns per turn of a wheel in top gear.
const RATIO: f64 = 3.2;
/// Dynamic radius of a wheel, m.
const RADIUS_M: f64 = 0.31;
/// Torque at full throttle where it is largest, N m, and that engine speed, rad/s (4,000 rpm).
const FULL_TORQUE: (f64, f64) = (180.0, 419.0);
/// Drag torque of the engine with closed throttle: N m, and N m s/rad.
const CLOSED_TORQUE: (f64, f64) = (-12.0, -0.07);
/// Brake torque of all wheels per pressure, N m/MPa.
const BRAKE_NM_PER_MPA: f64 = 1200.0;
/// Half width of the band around coasting in which neither pedal is pressed, m/s².
const BAND_MPS2: f64 = 0.05;
const GRAVITY_MPS2: f64 = 9.81;

/// Requests of the two pedals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pedals {
    pub throttle_percent: f64,
    pub pressure_mpa: f64,
}

/// The acceleration of the coasting car, its throttle closed, m/s².
pub fn coasting_mps2(speed_mps: f64) -> f64 {
    let (constant, slope) = CLOSED_TORQUE;
    let closed_nm = constant + slope * engine_radps(speed_mps);
    (closed_nm * RATIO / RADIUS_M - resistance_n(speed_mps)) / MASS_KG
}

pub fn pedals(speed_mps: f64, acceleration_mps2: f64) -> Pedals {
    let beyond_mps2 = acceleration_mps2 - coasting_mps2(speed_mps);
    if beyond_mps2 > BAND_MPS2 {
        let (constant, slope) = CLOSED_TORQUE;
        let turns = engine_radps(speed_mps);
        let span_nm = full_nm(turns) - (constant + slope * turns);
        let wanted_nm = MASS_KG * beyond_mps2 * RADIUS_M / RATIO;
        let throttle_percent = (100.0 * wanted_nm / span_nm).min(100.0);
        return Pedals { throttle_percent, pressure_mpa: 0.0 };
    }
    if beyond_mps2 < -BAND_MPS2 {
        let pressure_mpa = -MASS_KG * beyond_mps2 * RADIUS_M / BRAKE_NM_PER_MPA;
        return Pedals { throttle_percent: 0.0, pressure_mpa };
    }
    Pedals::default()
}

fn engine_radps(speed_mps: f64) -> f64 {
    RATIO * speed_mps / RADIUS_M
}

fn full_nm(turns: f64) -> f64 {
    let (most, at) = FULL_TORQUE;
    let off = (turns - at) / at;
    most * (1.0 - 0.6 * off * off)
}

fn resistance_n(speed_mps: f64) -> f64 {
    MASS_KG * GRAVITY_MPS2 * ROLLING + DRAG_KG_PER_M * speed_mps * speed_mps
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The acceleration that the pedals give: the model forwards.
    fn acceleration_mps2(speed_mps: f64, pedals: Pedals) -> f64 {
        let turns = engine_radps(speed_mps);
        let closed = CLOSED_TORQUE.0 + CLOSED_TORQUE.1 * turns;
        let torque = closed + pedals.throttle_percent / 100.0 * (full_nm(turns) - closed);
        let brake = BRAKE_NM_PER_MPA * pedals.pressure_mpa / RADIUS_M;
        (torque * RATIO / RADIUS_M - brake - resistance_n(speed_mps)) / MASS_KG
    }

    #[test]
    fn the_pedals_give_the_acceleration_back() {
        for speed in [22.0, 26.0, 30.5] {
            for wanted in [-2.0, -1.0, -0.3, 0.0, 0.3] {
                let pedals = pedals(speed, wanted);
                assert!((acceleration_mps2(speed, pedals) - wanted).abs() <= BAND_MPS2 + 1e-9);
                assert!(pedals.throttle_percent == 0.0 || pedals.pressure_mpa == 0.0);
            }
        }
    }

    #[test]
    fn a_coasting_car_slows_down_gently() {
        let coasting = coasting_mps2(110.0 / 3.6);
        assert!((-0.8..-0.4).contains(&coasting), "{coasting}");
        assert_eq!(pedals(30.0, coasting_mps2(30.0)), Pedals::default());
    }
}
