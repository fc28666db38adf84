//! The truck as the plant drives it: the model, the road under it, brakes with a lag, and the inner loop. That loop
//! turns an acceleration into torque.
//!
//! The brakes hold a truck that is about to stand, as "stop and hold" does (ISO 15622, full speed range). Below
//! [`HOLD_MPS`], and while the request is not positive, their force grows steadily. At its end it holds the
//! truck on any road, whatever the errors of the inner loop. A positive request releases them. A car needs no such
//! rule: its model has no grade.

use crate::gateway::Actuation;
use crate::longitudinal::State;
use bytemuck::Zeroable;
use messages::{Header, Powertrain};
use scenario::grade::GradeProfile;
use scenario::{Problem, Scenario};
use serde::{Deserialize, Serialize};
use truck_model::{Demand, FUEL_DENSITY_GPL, GRAVITY_MPS2, Motion, Preset, Truck as Model};

/// Speed below which the brakes hold, m/s: 1 km/h. Chosen: a pole wheel of 100 teeth (assumed) on a wheel of 0.51 m
/// gives less than one pulse in 100 ms there.
const HOLD_MPS: f64 = 1.0 / 3.6;
/// Grade on which the brakes hold the truck: UN R13, the test of a parking brake.
const HOLD_GRADE: f64 = 0.18;
/// Growth of the holding force over the truck's mass, m/s³. Chosen: a standing passenger does not mind it.
const HOLD_JERK_MPS3: f64 = 0.5;

#[derive(Clone, Debug)]
pub struct Truck {
    model: Model,
    /// The model in its own inner loop.
    believed: Model,
    road: GradeProfile,
    substeps: u32,
    step_s: f64,
    brake_share: f64,
    most_brake_n: f64,
    /// Force that holds the truck, and its growth in a step, N.
    hold_n: f64,
    hold_growth_n: f64,
    pub kept: Kept,
}

/// State of a truck that outlives the plant's process.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    motion: Motion,
    brake_n: f64,
    braked_s: f64,
}

impl Truck {
    /// The truck of a scenario at its start; `None` when the ego is a car.
    ///
    /// # Errors
    /// If the scenario's road is not valid.
    pub fn new(scenario: &Scenario) -> Result<Option<Self>, Problem> {
        let plant = &scenario.plant;
        let Some(preset) = Preset::named(plant.vehicle.name()) else { return Ok(None) };
        let road = scenario.road.profile()?;
        let believed = Model::preset(preset);
        let mass_kg = believed.parameters().mass_kg * plant.mass_factor.value();
        let model = believed.with_mass_kg(mass_kg);
        let motion = Motion::new(&model, 0.0, plant.initial_speed_mps.value(), road.grade(0.0));
        let (period_ms, step_ms) = (plant.period_ms.value(), plant.integration_step_ms.value());
        let step_s = 1e-3 * f64::from(step_ms);
        let brake_share = 1.0 - libm::exp(-step_s / plant.actuator_time_constant_s.value());
        let most_brake_n = -mass_kg * plant.min_acceleration_mps2.value();
        let hold_n =
            (mass_kg * GRAVITY_MPS2 * HOLD_GRADE / HOLD_GRADE.hypot(1.0)).min(most_brake_n);
        // One that begins at a stand is held already.
        let brake_n = if motion.speed_mps > 0.0 { 0.0 } else { hold_n };
        Ok(Some(Self {
            model,
            believed,
            road,
            substeps: period_ms / step_ms,
            step_s,
            brake_share,
            most_brake_n,
            hold_n,
            hold_growth_n: mass_kg * HOLD_JERK_MPS3 * step_s,
            kept: Kept { motion, brake_n, braked_s: 0.0 },
        }))
    }

    /// Moves on by one period of the plant, with the emergency brake's ceiling on the acceleration,
    /// m/s².
    pub fn step(&mut self, actuation: &Actuation, ceiling_mps2: Option<f64>) {
        for _ in 0..self.substeps {
            let (speed_mps, gear) = (self.kept.motion.speed_mps, self.kept.motion.gear);
            let grade = self.road.grade(self.kept.motion.position_m);
            let demand =
                |mps2| Demand::for_acceleration(&self.believed, mps2, speed_mps, gear, grade);
            // The emergency brake overrules engine and brakes where it asks for less acceleration.
            let most_mps2 = actuation.request_mps2.max(self.kept.motion.acceleration_mps2);
            let emergency = ceiling_mps2.filter(|ceiling| *ceiling < most_mps2).map(demand);
            let planned = || actuation.engine.unwrap_or_else(|| demand(actuation.request_mps2));
            let wanted = emergency.unwrap_or_else(planned);
            let wanted_n = wanted.service_brake_n.min(self.most_brake_n);
            // Its ceiling has the brakes' own growth already.
            let share = if emergency.is_some() { 1.0 } else { self.brake_share };
            let held_n = (self.kept.brake_n + self.hold_growth_n).min(self.hold_n);
            self.kept.brake_n += share * (wanted_n - self.kept.brake_n);
            let goes = actuation.request_mps2.min(ceiling_mps2.unwrap_or(f64::INFINITY)) > 0.0;
            let holds = speed_mps < HOLD_MPS && !goes;
            if holds {
                self.kept.brake_n = self.kept.brake_n.max(held_n);
            }
            if wanted_n > 0.0 || holds {
                self.kept.braked_s += self.step_s;
            }
            let demand = Demand { service_brake_n: self.kept.brake_n, ..wanted };
            self.kept.motion.step(&self.model, self.step_s, &demand, grade);
        }
    }

    pub fn place(&mut self, position_m: f64) {
        self.kept.motion.position_m = position_m;
    }

    pub fn state(&self) -> State {
        State {
            position_m: self.kept.motion.position_m,
            speed_mps: self.kept.motion.speed_mps,
            acceleration_mps2: self.kept.motion.acceleration_mps2,
        }
    }

    /// Present state of engine and gearbox, without a header.
    pub fn powertrain(&self) -> Powertrain {
        let motion = &self.kept.motion;
        let grade = self.road.grade(motion.position_m);
        let engine_speed_rpm = self.model.running_rpm(motion.speed_mps, motion.gear);
        Powertrain {
            header: Header::zeroed(),
            gear: motion.gear as u32 + 1,
            shifts: motion.shifts,
            since_shift_s: motion.since_shift_s,
            engine_speed_rpm,
            engine_torque_nm: motion.engine_torque_nm,
            service_brake_n: self.kept.brake_n,
            fuel_gps: self.model.engine().fuel_gps(engine_speed_rpm, motion.engine_torque_nm),
            fuel_g: motion.fuel_g,
            specific_force_mps2: motion.acceleration_mps2
                + GRAVITY_MPS2 * grade / (1.0 + grade * grade).sqrt(),
        }
    }

    /// Fuel over the way so far, L/100 km; `None` before the first metre.
    pub fn fuel_l_per_100km(&self) -> Option<f64> {
        let driven_m = self.kept.motion.position_m;
        let litres = self.kept.motion.fuel_g / FUEL_DENSITY_GPL;
        (driven_m >= 1.0).then(|| litres / driven_m * 1e5)
    }

    pub fn shifts(&self) -> u64 {
        self.kept.motion.shifts.into()
    }

    pub fn service_brake_s(&self) -> f64 {
        self.kept.braked_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gateway::Source;

    fn truck(keys: &str) -> Truck {
        let text = format!(
            "schema_version = 1\nname = \"hills\"\nplant.vehicle = \"jh6-49t\"\n\
             plant.initial_speed_mps = 20\n{keys}\n"
        );
        let scenario = Scenario::parse("hills", &text).expect("a right scenario");
        Truck::new(&scenario).expect("a road").expect("a truck")
    }

    fn acceleration(request_mps2: f64) -> Actuation {
        Actuation { request_mps2, source: Source::Command, limited: false, engine: None }
    }

    #[test]
    fn the_inner_loop_gives_what_is_asked_for_on_any_grade() {
        for grade in [-2.0, 0.0, 1.0] {
            let mut truck = truck(&format!(
                "road.points = [[0, 100], [400, {}], [800, {}]]",
                100.0 + 4.0 * grade,
                100.0 + 8.0 * grade
            ));
            for _ in 0..300 {
                truck.step(&acceleration(-0.05), None);
            }
            assert!((truck.state().acceleration_mps2 + 0.05).abs() < 1e-3, "{grade}");
            let felt = truck.powertrain().specific_force_mps2 - truck.state().acceleration_mps2;
            assert!((felt / GRAVITY_MPS2 - grade / 100.0).abs() < 1e-5, "{grade}: {felt}");
        }
    }

    #[test]
    fn a_wrong_mass_is_felt() {
        let mut right = truck("");
        let mut heavy = truck("plant.mass_factor = 1.15");
        for truck in [&mut right, &mut heavy] {
            for _ in 0..300 {
                truck.step(&acceleration(0.1), None);
            }
        }
        assert!(heavy.state().acceleration_mps2 < 0.9 * right.state().acceleration_mps2);
    }

    /// A road of constant grade, percent, with the plant's period of 10 ms.
    fn slope(percent: f64, keys: &str) -> Truck {
        let end_m = 500.0 + 5.0 * percent;
        truck(&format!("road.points = [[0, 500], [500, {end_m}]]\n{keys}"))
    }

    #[test]
    fn a_request_that_is_not_positive_ends_in_standstill_and_holds_on_any_grade() {
        for mass_factor in [0.85, 1.0, 1.15] {
            for percent in [-10.0, -8.0, -1.0, 0.0, 1.0, 8.0, 10.0] {
                let keys = format!("plant.mass_factor = {mass_factor}\n");
                let mut truck = slope(percent, &keys);
                for _ in 0..1500 {
                    // The end of a soft stop: the deceleration fades with the speed.
                    let request = -truck.state().speed_mps.clamp(0.0, 3.0) - 0.03;
                    truck.step(&acceleration(request), None);
                }
                let stands = truck.state();
                assert_eq!(stands.speed_mps, 0.0, "{percent} %, mass x {mass_factor}");
                for _ in 0..3000 {
                    truck.step(&acceleration(0.0), None);
                }
                assert_eq!(truck.state(), State { acceleration_mps2: 0.0, ..stands });
            }
        }
    }

    #[test]
    fn it_begins_with_the_acceleration_that_its_engine_leaves_and_a_stand_is_held() {
        for percent in [-8.0, -1.0, 0.0, 1.0, 8.0] {
            let mut truck = slope(percent, "");
            let began = truck.state().acceleration_mps2;
            truck.step(&acceleration(0.0), None);
            let jerk = (truck.state().acceleration_mps2 - began) / 0.01;
            assert!(jerk.abs() < 5.0, "{percent} %: {jerk} m/s³");
            assert_eq!(began == 0.0, percent.abs() < 2.0, "{percent} %: {began} m/s²");
            let end_m = 500.0 + 5.0 * percent;
            let keys = format!(
                "schema_version = 1\nname = \"x\"\nplant.vehicle = \"jh6-49t\"\n\
                 road.points = [[0, 500], [500, {end_m}]]"
            );
            let scenario = Scenario::parse("x", &keys).expect("a right scenario");
            let mut stands = Truck::new(&scenario).expect("a road").expect("a truck");
            for _ in 0..500 {
                stands.step(&acceleration(0.0), None);
            }
            assert_eq!(stands.state(), State::default(), "{percent} %");
        }
    }

    #[test]
    fn an_engine_idles_at_a_stand_and_its_fuel_flow_is_what_it_burns() {
        let mut truck = truck("");
        for _ in 0..1200 {
            truck.step(&acceleration(-4.0), None);
        }
        assert_eq!(truck.state().speed_mps, 0.0);
        let before = truck.powertrain();
        truck.step(&acceleration(-4.0), None);
        let after = truck.powertrain();
        assert_eq!(before.engine_speed_rpm, 600.0);
        let burnt_gps = (after.fuel_g - before.fuel_g) / 0.01;
        assert!(burnt_gps > 0.1 && (burnt_gps - before.fuel_gps).abs() < 1e-9, "{burnt_gps} g/s");
    }

    #[test]
    fn a_positive_request_releases_the_brakes_at_once_and_an_emergency_does_not() {
        // In the lowest gear that the model has the engine balances 49 t on 3.7 %.
        for percent in [-8.0, 0.0, 2.0] {
            let mut truck = slope(percent, "");
            for _ in 0..1200 {
                truck.step(&acceleration(-4.0), None);
            }
            assert_eq!(truck.state().speed_mps, 0.0);
            for _ in 0..200 {
                truck.step(&acceleration(0.1), Some(-1.0));
            }
            assert_eq!(truck.state().speed_mps, 0.0, "held by the emergency brake");
            for _ in 0..500 {
                truck.step(&acceleration(0.1), None);
            }
            assert!(truck.state().speed_mps > 0.2, "{percent} %: {:?}", truck.state());
        }
    }

    #[test]
    fn a_torque_below_drag_brakes_with_the_engine_alone_and_an_emergency_with_all() {
        let mut truck = truck("");
        let engine = Demand { engine_torque_nm: -1500.0, service_brake_n: 0.0, gear: None };
        for _ in 0..200 {
            truck.step(&Actuation { engine: Some(engine), ..acceleration(0.0) }, None);
        }
        assert_eq!(truck.service_brake_s(), 0.0);
        assert!(truck.state().acceleration_mps2 < -0.1);
        assert_eq!(truck.powertrain().fuel_gps, 0.0);
        let before_mps = truck.state().speed_mps;
        for _ in 0..300 {
            truck.step(&acceleration(-4.0), None);
        }
        let braked_mps = before_mps - truck.state().speed_mps;
        // Three seconds, less the brakes' lag and what shifts take from the engine brake.
        assert!((9.0..12.0).contains(&braked_mps), "{braked_mps}");
        assert!(truck.service_brake_s() > 2.9);
    }

    #[test]
    fn consumption_is_fuel_over_way_and_unknown_before_the_first_metre() {
        let mut truck = truck("");
        assert_eq!(truck.fuel_l_per_100km(), None);
        for _ in 0..500 {
            truck.step(&acceleration(0.0), None);
        }
        let (fuel_g, way_m) = (truck.powertrain().fuel_g, truck.state().position_m);
        let litres_per_100km = fuel_g / FUEL_DENSITY_GPL * 100_000.0 / way_m;
        let found = truck.fuel_l_per_100km().expect("it has driven");
        assert!((found / litres_per_100km - 1.0).abs() < 1e-12 && found > 5.0, "{found}");
    }
}
