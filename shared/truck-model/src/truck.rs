//! Forces and torques of a truck: equations (1) to (4) and (6).

use crate::engine::{Engine, IDLE_RPM, RADPS_PER_RPM};
use crate::parameters::{GEARS, Parameters, Preset};

pub const GRAVITY_MPS2: f64 = 9.81;
pub const AIR_DENSITY_KGPM3: f64 = 1.188;
pub const FUEL_DENSITY_GPL: f64 = 835.0;

/// Inertia of the generic engine \[kg m²\].
const ENGINE_INERTIA_KGM2: f64 = 5.15;
/// Engine speed below which the auxiliaries' torque stops growing \[rpm\].
const AUXILIARY_FLOOR_RPM: f64 = 300.0;

/// Parameters of a truck with everything derived from them.
///
/// *Engine* torque is at the crankshaft. *Net* torque is at the gearbox, after the auxiliaries: T =
/// T_eng - P_aux / w.
///
/// ```
/// use truck_model::{Preset, Truck};
///
/// let truck = Truck::preset(Preset::Jh6At49T);
/// // Climbing 1 % at 20 m/s needs more torque than the flat.
/// let torque_nm = |grade| truck.net_torque_nm(truck.resistance_n(20.0, grade), 5);
/// assert!(torque_nm(0.01) > 2.0 * torque_nm(0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Truck {
    parameters: Parameters,
    engine: Engine,
    /// m d \[kg\].
    inertial_mass_kg: f64,
    /// c of equation (1) \[1/m\].
    drag_per_m: f64,
    /// k = i_g i_0 / r \[1/m\].
    crank_radians_per_m: [f64; GEARS],
}

impl Truck {
    pub fn new(parameters: Parameters) -> Self {
        let p = parameters;
        let radius2_m2 = p.wheel_radius_m * p.wheel_radius_m;
        let engine_to_wheel = p.gear_ratios[GEARS - 1] * p.final_drive;
        let engine_kgm2 = p.engine_scale * ENGINE_INERTIA_KGM2 * engine_to_wheel * engine_to_wheel;
        let inertial_mass_kg = p.mass_kg + (p.wheel_inertia_kgm2 + engine_kgm2) / radius2_m2;
        Self {
            parameters,
            engine: Engine::new(p.engine_scale),
            inertial_mass_kg,
            drag_per_m: AIR_DENSITY_KGPM3 * p.drag_area_m2 / inertial_mass_kg,
            crank_radians_per_m: p.gear_ratios.map(|i| i * p.final_drive / p.wheel_radius_m),
        }
    }

    pub fn preset(preset: Preset) -> Self {
        Self::new(preset.parameters())
    }

    pub fn with_mass_kg(&self, mass_kg: f64) -> Self {
        Self::new(Parameters { mass_kg, ..self.parameters })
    }

    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Returns the mass with the share of the rotating parts, m d \[kg\] (equation 3).
    pub fn inertial_mass_kg(&self) -> f64 {
        self.inertial_mass_kg
    }

    /// Returns c of equations (1) and (4) \[1/m\]: air drag is c K.
    pub fn drag_per_m(&self) -> f64 {
        self.drag_per_m
    }

    /// Returns the crankshaft radians per metre of road, k = i_g i_0 / r \[1/m\].
    pub fn crank_radians_per_m(&self, gear: usize) -> f64 {
        self.crank_radians_per_m[gear]
    }

    /// Returns the kinetic energy K at a speed \[J\].
    pub fn kinetic_energy_j(&self, speed_mps: f64) -> f64 {
        0.5 * self.inertial_mass_kg * speed_mps * speed_mps
    }

    /// Returns the speed at a kinetic energy \[m/s\].
    pub fn speed_mps(&self, kinetic_energy_j: f64) -> f64 {
        (2.0 * kinetic_energy_j.max(0.0) / self.inertial_mass_kg).sqrt()
    }

    /// Returns the engine speed with the clutch closed \[rpm\].
    pub fn engine_rpm(&self, speed_mps: f64, gear: usize) -> f64 {
        self.crank_radians_per_m[gear] * speed_mps / RADPS_PER_RPM
    }

    /// Returns the engine speed \[rpm\]: below the idle speed the clutch slips or is open.
    pub fn running_rpm(&self, speed_mps: f64, gear: usize) -> f64 {
        self.engine_rpm(speed_mps, gear).max(IDLE_RPM)
    }

    /// Returns the torque of the auxiliaries at an engine speed \[N m\].
    pub fn auxiliary_torque_nm(&self, engine_rpm: f64) -> f64 {
        self.parameters.auxiliary_power_w / (engine_rpm.max(AUXILIARY_FLOOR_RPM) * RADPS_PER_RPM)
    }

    /// Returns rolling resistance plus slope force \[N\]; `grade` is rise over run.
    pub fn road_resistance_n(&self, grade: f64) -> f64 {
        self.rolling_resistance_n(grade) + self.slope_force_n(grade)
    }

    /// Returns the resistance of road and air \[N\].
    pub fn resistance_n(&self, speed_mps: f64, grade: f64) -> f64 {
        self.road_resistance_n(grade) + self.air_drag_n(speed_mps)
    }

    pub(crate) fn rolling_resistance_n(&self, grade: f64) -> f64 {
        self.parameters.mass_kg * GRAVITY_MPS2 * self.parameters.rolling_resistance * cosine(grade)
    }

    pub(crate) fn slope_force_n(&self, grade: f64) -> f64 {
        self.parameters.mass_kg * GRAVITY_MPS2 * grade * cosine(grade)
    }

    pub(crate) fn air_drag_n(&self, speed_mps: f64) -> f64 {
        0.5 * AIR_DENSITY_KGPM3 * self.parameters.drag_area_m2 * speed_mps * speed_mps
    }

    /// Returns the tractive force of a net torque \[N\] (equation 2).
    pub fn force_n(&self, net_torque_nm: f64, gear: usize) -> f64 {
        let force_n = net_torque_nm * self.crank_radians_per_m[gear];
        if net_torque_nm >= 0.0 {
            force_n * self.parameters.driveline_efficiency
        } else {
            force_n / self.parameters.driveline_efficiency
        }
    }

    /// Returns the net torque of a tractive force \[N m\], the inverse of
    /// [`force_n`](Self::force_n).
    pub fn net_torque_nm(&self, force_n: f64, gear: usize) -> f64 {
        let torque_nm = force_n / self.crank_radians_per_m[gear];
        if force_n >= 0.0 {
            torque_nm / self.parameters.driveline_efficiency
        } else {
            torque_nm * self.parameters.driveline_efficiency
        }
    }

    /// Returns the net torques with the injection cut and at full load \[N m\].
    pub fn net_torque_limits_nm(&self, speed_mps: f64, gear: usize) -> (f64, f64) {
        let rpm = self.engine_rpm(speed_mps, gear);
        let auxiliary_nm = self.auxiliary_torque_nm(rpm);
        (
            self.engine.drag_torque_nm(rpm) - auxiliary_nm,
            self.engine.max_torque_nm(rpm) - auxiliary_nm,
        )
    }

    /// Returns the engine torque for an acceleration \[N m\] (inverse dynamics, equation 6),
    /// without limits.
    pub fn engine_torque_nm(
        &self,
        acceleration_mps2: f64,
        speed_mps: f64,
        gear: usize,
        grade: f64,
    ) -> f64 {
        let force_n =
            self.inertial_mass_kg * acceleration_mps2 + self.resistance_n(speed_mps, grade);
        let rpm = self.running_rpm(speed_mps, gear);
        self.net_torque_nm(force_n, gear) + self.auxiliary_torque_nm(rpm)
    }

    /// Returns the fuel flow at a net torque with the clutch closed \[g/s\] (equation 5).
    pub fn fuel_gps(&self, speed_mps: f64, gear: usize, net_torque_nm: f64) -> f64 {
        let rpm = self.running_rpm(speed_mps, gear);
        self.engine.fuel_gps(rpm, net_torque_nm + self.auxiliary_torque_nm(rpm))
    }
}

fn cosine(grade: f64) -> f64 {
    1.0 / (1.0 + grade * grade).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOP: usize = GEARS - 1;

    #[test]
    fn rotating_mass_factors_are_those_of_the_table() {
        for (preset, factor) in [(Preset::Jh6At49T, 1.029), (Preset::Jh6At25T, 1.028)] {
            let truck = Truck::preset(preset);
            let found = truck.inertial_mass_kg() / truck.parameters().mass_kg;
            assert!((found - factor).abs() < 5e-4, "{}: {found}", preset.name());
        }
    }

    #[test]
    fn torque_and_force_are_inverse() {
        let truck = Truck::preset(Preset::Jh6At25T);
        for torque_nm in [-300.0, -1.0, 0.0, 1.0, 1400.0] {
            for gear in 0..GEARS {
                let back = truck.net_torque_nm(truck.force_n(torque_nm, gear), gear);
                assert!((back - torque_nm).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn fuel_on_the_flat_is_about_30_litres_at_49_t() {
        let truck = Truck::preset(Preset::Jh6At49T);
        let speed_mps = 75.0 / 3.6;
        let torque_nm = truck.net_torque_nm(truck.resistance_n(speed_mps, 0.0), TOP);
        let gpm = truck.fuel_gps(speed_mps, TOP, torque_nm) / speed_mps;
        let litres_per_100_km = gpm * 1e5 / FUEL_DENSITY_GPL;
        assert!((litres_per_100_km - 30.0).abs() < 1.0, "{litres_per_100_km}");
    }

    /// The limits that divide the road into classes are the grades that full load and drag hold at
    /// 75 km/h.
    #[test]
    fn limit_grades_are_those_of_the_paper() {
        let speed_mps = 75.0 / 3.6;
        for (preset, up, down) in
            [(Preset::Jh6At49T, 0.0137, -0.0114), (Preset::Jh6At25T, 0.0211, -0.0156)]
        {
            let truck = Truck::preset(preset);
            let (drag_nm, max_nm) = truck.net_torque_limits_nm(speed_mps, TOP);
            let weight_n = truck.parameters().mass_kg * GRAVITY_MPS2;
            let flat_n = truck.resistance_n(speed_mps, 0.0);
            let found_up = (truck.force_n(max_nm, TOP) - flat_n) / weight_n;
            let found_down = (truck.force_n(drag_nm, TOP) - flat_n) / weight_n;
            assert!((found_up - up).abs() < 1e-4, "{found_up}");
            assert!((found_down - down).abs() < 1e-4, "{found_down}");
        }
    }
}
