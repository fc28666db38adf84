//! `[plant]`: the ego vehicle and its actuator gateway.

use serde::{Deserialize, Serialize};

use super::lateral::Lateral;
use super::quantity::{
    Acceleration, AccelerationMagnitude, Duration, JerkMagnitude, Length, Mass, MassFactor,
    PeriodMs, Power, Speed, TimeConstant, Torque, TorqueRate,
};
use super::schema::Schema;

/// The ego vehicle. It stands or moves forward, never back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Plant {
    /// Kind of the ego vehicle.
    pub vehicle: Vehicle,
    /// True mass over the one that vehicle and law assume; trucks only.
    pub mass_factor: MassFactor,
    /// Period of the plant's loop and of `vehicle/odometry`, ms. Every other period is a multiple.
    pub period_ms: PeriodMs,
    /// Integration of the ego and of the actors.
    pub integrator: Integrator,
    /// Step of the integration, ms. `fine`: divides the plant's period. `paper-euler`: a multiple
    /// of it, at most the actuator's time constant. Samples inside a step are the step's own
    /// straight lines.
    pub integration_step_ms: PeriodMs,
    /// Time constant of the first-order lag from request to acceleration, s.
    pub actuator_time_constant_s: TimeConstant,
    /// Strongest deceleration that the brakes and tyres give, m/s² (negative).
    pub min_acceleration_mps2: Acceleration,
    /// Strongest acceleration that the driveline and tyres give, m/s².
    pub max_acceleration_mps2: Acceleration,
    /// Speed at the start, m/s.
    pub initial_speed_mps: Speed,
    /// Acceleration at the start, m/s².
    pub initial_acceleration_mps2: Acceleration,
    /// Length of the ego, m.
    pub length_m: Length,
    /// Limits the acceleration by the engine's power; absent: unlimited, as in the papers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub powertrain: Option<Powertrain>,
    /// Bounds that no request passes, whatever its source.
    pub gateway: Gateway,
    /// Reaction of the gateway when no newer valid command arrives.
    pub fallback: Fallback,
    /// Motion across the road, on a road with a plan.
    #[serde(skip_serializing_if = "Lateral::is_usual")]
    pub lateral: Lateral,
}

impl Default for Plant {
    fn default() -> Self {
        Self {
            vehicle: Vehicle::Car,
            mass_factor: MassFactor::of(1.0),
            period_ms: PeriodMs::of(10),
            integrator: Integrator::Fine,
            integration_step_ms: PeriodMs::of(1),
            actuator_time_constant_s: TimeConstant::of(0.5),
            min_acceleration_mps2: Acceleration::of(-9.0),
            max_acceleration_mps2: Acceleration::of(5.0),
            initial_speed_mps: Speed::of(0.0),
            initial_acceleration_mps2: Acceleration::of(0.0),
            length_m: Length::of(4.5),
            powertrain: None,
            gateway: Gateway::default(),
            fallback: Fallback::default(),
            lateral: Lateral::default(),
        }
    }
}

/// Kind of the ego vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
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

impl Vehicle {
    /// True if it has engine, gears and a road with grade.
    #[must_use]
    pub const fn is_truck(self) -> bool {
        !matches!(self, Self::Car)
    }

    /// Mass of a truck that vehicle and law assume, kg; `None` for a car.
    #[must_use]
    pub const fn truck_kg(self) -> Option<f64> {
        match self {
            Self::Car => None,
            Self::Jh6At49T => Some(49_000.0),
            Self::Jh6At25T => Some(25_000.0),
        }
    }

    /// The name as scenario files spell it.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Car => "car",
            Self::Jh6At49T => "jh6-49t",
            Self::Jh6At25T => "jh6-25t",
        }
    }
}

/// Integration of motion, the same for the ego and the actors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum Integrator {
    /// The lag exactly, in short steps with constant request.
    #[default]
    Fine,
    /// x += T v, v += T a, a += T/tau (u - a), all from the start of the step. It is the model's
    /// own Euler step, in which the CACC paper integrates its plant (T = 100 ms there).
    PaperEuler,
}

/// A limit on traction: acceleration <= power / (mass * speed).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields)]
pub struct Powertrain {
    /// Mass of the ego, kg.
    pub mass_kg: Mass,
    /// Largest power at the wheels, kW.
    pub max_power_kw: Power,
}

/// Bounds of the actuator gateway.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Gateway {
    /// Smallest request let through, m/s² (negative).
    pub min_request_mps2: Acceleration,
    /// Largest request let through, m/s².
    pub max_request_mps2: Acceleration,
    /// Fastest rise of the request, m/s³.
    pub max_rise_mps3: JerkMagnitude,
    /// Fastest fall of the request (braking harder), m/s³.
    pub max_fall_mps3: JerkMagnitude,
    /// Smallest engine torque let through, N m (negative).
    pub min_torque_nm: Torque,
    /// Largest engine torque let through, N m.
    pub max_torque_nm: Torque,
    /// Fastest change of the engine torque, N m/s.
    pub max_torque_rate_nmps: TorqueRate,
}

impl Default for Gateway {
    fn default() -> Self {
        Self {
            min_request_mps2: Acceleration::of(-8.0),
            max_request_mps2: Acceleration::of(5.0),
            max_rise_mps3: JerkMagnitude::of(20.0),
            max_fall_mps3: JerkMagnitude::of(50.0),
            min_torque_nm: Torque::of(-1500.0),
            max_torque_nm: Torque::of(2200.0),
            max_torque_rate_nmps: TorqueRate::of(5000.0),
        }
    }
}

/// The plant's answer to silence: first the rest of the last plan, then a stop in lane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Fallback {
    /// Longest time for which the last plan is followed after its command was due to be replaced, s.
    pub follow_plan_s: Duration,
    /// Deceleration of the stop in lane, m/s².
    pub stop_deceleration_mps2: AccelerationMagnitude,
    /// A successor overdue by this time, s, means that a command is lost. The rest of the plan is
    /// then a level of degradation.
    pub overdue_s: Duration,
}

impl Default for Fallback {
    fn default() -> Self {
        Self {
            follow_plan_s: Duration::of(1.0),
            stop_deceleration_mps2: AccelerationMagnitude::of(2.5),
            overdue_s: Duration::of(0.1),
        }
    }
}
