//! `[plant]`: the ego vehicle and its actuator gateway.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use scenario_derive::tables;

use crate::lateral::Lateral;
use crate::own_law::{Word, unit_words};
use crate::quantity::{
    Acceleration, AccelerationMagnitude, Duration, JerkMagnitude, Length, Mass, MassFactor,
    PeriodMs, Power, Speed, TimeConstant, Torque, TorqueRate,
};

tables! {
    /// The ego vehicle. It stands or moves forward, never back.
    pub struct Plant {
        /// Kind of the ego vehicle.
        pub vehicle: Vehicle = Car,
        /// Unit of the Functional Mock-up Interface 2 or 3 (.fmu) that moves in the car's place: acceleration, or
        /// throttle and brake, in; speed, position and acceleration out. A relative path is the scenario file's.
        pub fmu: Option<PathBuf>,
        /// Variables of the unit by the quantities that they have: `speed_mps = "v"`.
        pub fmu_map: BTreeMap<String, Word> = sparse,
        /// Values of the unit's parameters and inputs at its start: `mass = 1500`.
        pub fmu_start: BTreeMap<String, Word> = sparse,
        /// True mass over the one that vehicle and law assume; trucks only.
        pub mass_factor: MassFactor = 1.0,
        /// Period of the plant's loop and of `vehicle/odometry`, ms. Every other period is a multiple.
        pub period_ms: PeriodMs = 10,
        /// Integration of the ego and of the actors.
        pub integrator: Integrator = Fine,
        /// Step of the integration, ms. `fine`: divides the plant's period. `paper-euler`: a multiple
        /// of it, at most the actuator's time constant. Samples inside a step are the step's own
        /// straight lines.
        pub integration_step_ms: PeriodMs = 1,
        /// Time constant of the first-order lag from request to acceleration, s.
        pub actuator_time_constant_s: TimeConstant = 0.5,
        /// Strongest deceleration that the brakes and tyres give, m/s² (negative).
        pub min_acceleration_mps2: Acceleration = -9.0,
        /// Strongest acceleration that the driveline and tyres give, m/s².
        pub max_acceleration_mps2: Acceleration = 5.0,
        /// Speed at the start, m/s.
        pub initial_speed_mps: Speed = 0.0,
        /// Acceleration at the start, m/s².
        pub initial_acceleration_mps2: Acceleration = 0.0,
        /// Length of the ego, m.
        pub length_m: Length = 4.5,
        /// Limits the acceleration by the engine's power; absent: unlimited, as in the papers.
        pub powertrain: Option<Powertrain>,
        /// Bounds that no request passes, whatever its source.
        pub gateway: Gateway = default,
        /// Reaction of the gateway when no newer valid command arrives.
        pub fallback: Fallback = default,
        /// Motion across the road, on a road with a plan.
        pub lateral: Lateral = sparse,
    }

    /// Kind of the ego vehicle.
    pub enum Vehicle {
        /// A car that follows requests for acceleration with a lag.
        #[default]
        #[serde(rename = "car")]
        Car,
        /// The heavy truck of the predictive paper at 49 t: engine, gears, fuel, the road's grade.
        #[serde(rename = "jh6-49t")]
        Jh6At49T,
        /// The same at 25 t, with a smaller engine.
        #[serde(rename = "jh6-25t")]
        Jh6At25T,
    }

    /// Integration of motion, the same for the ego and the actors.
    pub enum Integrator {
        /// The lag exactly, in short steps with constant request.
        #[default]
        Fine,
        /// x += T v, v += T a, a += T/tau (u - a), all from the start of the step. It is the model's
        /// own Euler step, in which the CACC paper integrates its plant (T = 100 ms there).
        PaperEuler,
    }

    /// A limit on traction: acceleration <= power / (mass * speed).
    #[derive(Copy)]
    pub struct Powertrain {
        /// Mass of the ego, kg.
        pub mass_kg: Mass,
        /// Largest power at the wheels, kW.
        pub max_power_kw: Power,
    }

    /// Bounds of the actuator gateway.
    #[derive(Copy)]
    pub struct Gateway {
        /// Smallest request let through, m/s² (negative).
        pub min_request_mps2: Acceleration = -8.0,
        /// Largest request let through, m/s².
        pub max_request_mps2: Acceleration = 5.0,
        /// Fastest rise of the request, m/s³.
        pub max_rise_mps3: JerkMagnitude = 20.0,
        /// Fastest fall of the request (braking harder), m/s³.
        pub max_fall_mps3: JerkMagnitude = 50.0,
        /// Smallest engine torque let through, N m (negative).
        pub min_torque_nm: Torque = -1500.0,
        /// Largest engine torque let through, N m.
        pub max_torque_nm: Torque = 2200.0,
        /// Fastest change of the engine torque, N m/s.
        pub max_torque_rate_nmps: TorqueRate = 5000.0,
    }

    /// The plant's answer to silence: first the rest of the last plan, then a stop in lane.
    #[derive(Copy)]
    pub struct Fallback {
        /// Longest time for which the last plan is followed after its command was due to be replaced, s.
        pub follow_plan_s: Duration = 1.0,
        /// Deceleration of the stop in lane, m/s².
        pub stop_deceleration_mps2: AccelerationMagnitude = 2.5,
        /// A successor overdue by this time, s, means that a command is lost. The rest of the plan is
        /// then a level of degradation.
        pub overdue_s: Duration = 0.1,
    }
}

impl Plant {
    /// Words behind the unit: its starts and its map.
    pub fn unit_words(&self) -> Vec<String> {
        unit_words(&self.fmu_start, &self.fmu_map).collect()
    }

    /// Settles where the unit is; `own` is the scenario file's directory.
    pub(crate) fn place_unit(&mut self, own: Option<&Path>) {
        let Some(unit) = &mut self.fmu else { return };
        let here = std::env::current_dir().unwrap_or_default();
        let beside = own.map(|own| here.join(own).join(&*unit)).filter(|path| path.is_file());
        *unit = beside.unwrap_or_else(|| here.join(&*unit));
    }
}

impl Vehicle {
    /// True if it has engine, gears and a road with grade.
    pub const fn is_truck(self) -> bool {
        !matches!(self, Self::Car)
    }

    /// Mass of a truck that vehicle and law assume, kg; `None` for a car.
    pub const fn truck_kg(self) -> Option<f64> {
        match self {
            Self::Car => None,
            Self::Jh6At49T => Some(49_000.0),
            Self::Jh6At25T => Some(25_000.0),
        }
    }
}
