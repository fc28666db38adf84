//! `[plant.lateral]`: how the ego moves across a road with a plan.

use serde::{Deserialize, Serialize};

use super::quantity::{
    AngularFrequency, Damping, DelayMs, Inertia, InnerShare, Length, Sigma, SlipCompliance, Time,
    TimeConstant, Understeer,
};
use super::schema::Schema;

/// The ego's motion across the road, its driver's steering and its yaw-rate sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Lateral {
    /// Model of the motion.
    pub model: LateralModel,
    /// Distance of the axles, m; a truck's: 5.8 when absent.
    pub wheelbase_m: Length,
    /// Distance of the centre of gravity behind the front axle, as a share of the wheelbase.
    pub cg_share: InnerShare,
    /// Moment of inertia about the vertical axis, kg m². For a truck it is its mass times the square of half its
    /// wheelbase if absent.
    pub yaw_inertia_kgm2: Inertia,
    /// Slip angle of the rear axle by lateral acceleration, rad per m/s².
    pub slip_rad_per_mps2: SlipCompliance,
    /// Slip angle of the front axle minus that of the rear axle by lateral acceleration, rad per m/s².
    pub understeer_rad_per_mps2: Understeer,
    /// The driver who steers.
    pub driver: Driver,
    /// The yaw-rate sensor.
    pub yaw_rate: YawRateSensor,
}

/// Model of the motion across the road.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum LateralModel {
    /// The linear single track, steered by a driver.
    #[default]
    SingleTrack,
    /// The middle of the front bumper follows the axis exactly; the body has the tangent's heading.
    OnAxis,
}

/// A driver who keeps the lane: a second-order law on the offset from a place in the lane that wanders.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Driver {
    /// Time by which the driver sees the curvature ahead, s.
    pub lead_s: Time,
    /// Natural frequency of the correction of an offset, rad/s.
    pub frequency_radps: AngularFrequency,
    /// Damping of that correction.
    pub damping: Damping,
    /// Standard deviation of the place in the lane that the driver aims at, m; 0: none.
    pub wander_m: Sigma,
    /// Correlation time of that place, s.
    pub wander_s: TimeConstant,
}

/// Errors of the yaw-rate sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct YawRateSensor {
    /// Standard deviation of the offset, which is drawn once a run, degrees per second.
    pub offset_sigma_dps: Sigma,
    /// Standard deviation of the noise of each sample, degrees per second.
    pub noise_dps: Sigma,
    /// Time constant of its lag, ms.
    pub lag_ms: DelayMs,
}

impl Default for Lateral {
    fn default() -> Self {
        Self {
            model: LateralModel::default(),
            wheelbase_m: Length::of(2.7),
            cg_share: InnerShare::of(0.5),
            yaw_inertia_kgm2: Inertia::of(2500.0),
            slip_rad_per_mps2: SlipCompliance::of(0.0055),
            understeer_rad_per_mps2: Understeer::of(0.0035),
            driver: Driver::default(),
            yaw_rate: YawRateSensor::default(),
        }
    }
}

impl Default for Driver {
    fn default() -> Self {
        Self {
            lead_s: Time::of(0.15),
            frequency_radps: AngularFrequency::of(1.0),
            damping: Damping::of(0.9),
            wander_m: Sigma::of(0.2),
            wander_s: TimeConstant::of(3.0),
        }
    }
}

impl Default for YawRateSensor {
    fn default() -> Self {
        Self {
            offset_sigma_dps: Sigma::of(0.1),
            noise_dps: Sigma::of(0.1),
            lag_ms: DelayMs::of(20),
        }
    }
}

impl Lateral {
    /// True if all keys have their defaults.
    #[must_use]
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    /// Gives a truck's values to keys that were not written. They are 5.8 m from the front axle to the middle of the
    /// rear ones, and an inertia of `mass_kg` half a wheelbase away.
    pub(super) fn follow_truck(&mut self, mass_kg: f64, is_written: impl Fn(&str) -> bool) {
        if !is_written("plant.lateral.wheelbase_m") {
            self.wheelbase_m = Length::of(5.8);
        }
        if !is_written("plant.lateral.yaw_inertia_kgm2") {
            let arm_m = 0.5 * self.wheelbase_m.value();
            self.yaw_inertia_kgm2 =
                Inertia::try_from(mass_kg * arm_m * arm_m).unwrap_or(self.yaw_inertia_kgm2);
        }
    }
}
