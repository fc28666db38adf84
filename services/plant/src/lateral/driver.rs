//! A driver who keeps the lane.
//!
//! ```text
//! κ_wanted = κ(p + v t_lead) − 2 ζ ω l' / v² − ω² (l − l_aim) / v²
//! ```
//!
//! So the offset from the aim obeys l'' = −2 ζ ω l' − ω² (l − l_aim). l' is the front bumper's speed across the axis.
//! It is not the body's heading. On a steady circle the body points aside of its way, but a driver looks at the way.
//! The wheels follow with a lag. The aim is an Ornstein-Uhlenbeck process.

use scenario::lateral::Driver as Keys;

use crate::numbers::Numbers;

/// Speed below which a driver corrects an offset on the way of this speed, m/s: corrections stay finite. Chosen.
const STEERS_FROM_MPS: f64 = 3.0;
/// Largest angle of the front wheels, rad: 34 degrees, a car's full lock. Chosen.
const MOST_STEERING_RAD: f64 = 0.6;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driver {
    lead_s: f64,
    frequency_radps: f64,
    damping: f64,
    /// Share of the way to the desired steering angle in one period.
    steering_share: f64,
    /// Share of the aim that a period keeps, and the deviation that it adds, m.
    aim_decay: f64,
    aim_sigma_m: f64,
}

impl Driver {
    /// The driver of a scenario, who acts once in each period.
    pub fn new(keys: &Keys, period_s: f64, numbers: &Numbers) -> Self {
        let aim_decay = libm::exp(-period_s / keys.wander_s.value());
        Self {
            lead_s: keys.lead_s.value(),
            frequency_radps: keys.frequency_radps.value(),
            damping: keys.damping.value(),
            steering_share: 1.0 - libm::exp(-period_s / numbers.steering_lag_s),
            aim_decay,
            aim_sigma_m: keys.wander_m.value() * libm::sqrt(1.0 - aim_decay * aim_decay),
        }
    }

    /// Distance ahead at which the driver looks at the curvature, m.
    pub fn lead_m(&self, speed_mps: f64) -> f64 {
        self.lead_s * speed_mps
    }

    /// Moves the aim on by one period, with a normal deviate.
    pub fn wander(&self, aim_m: &mut f64, deviate: f64) {
        *aim_m = self.aim_decay * *aim_m + self.aim_sigma_m * deviate;
    }

    /// Desired curvature of the driver, 1/m, at an offset from the aim, m, that changes by `across_mps`.
    pub fn curvature(
        &self,
        ahead_perm: f64,
        speed_mps: f64,
        offset_m: f64,
        across_mps: f64,
    ) -> f64 {
        // Slower driving is steered by the way and not by the time: the wheels turn no faster.
        let v = speed_mps.max(STEERS_FROM_MPS);
        let w = self.frequency_radps;
        ahead_perm - (2.0 * self.damping * w * across_mps + w * w * offset_m) / (v * v)
    }

    /// Moves the wheels towards an angle for one period.
    pub fn steer(&self, steering_rad: &mut f64, wanted_rad: f64) {
        let wanted_rad = wanted_rad.clamp(-MOST_STEERING_RAD, MOST_STEERING_RAD);
        *steering_rad += self.steering_share * (wanted_rad - *steering_rad);
    }
}
