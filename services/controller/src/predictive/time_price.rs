//! The servo that keeps the mean speed: it makes time dearer while the truck is late.
//!
//! ```text
//! lag' = 1 - v / v_mean        beta / beta_0 = 1.3 + k_p lag + k_i ∫ lag dt
//! ```

/// beta / beta_0 of a truck in time: 1 would be right on the flat, hills make it late.
const INITIAL: f64 = 1.3;
/// k_p, 1/s.
const PROPORTIONAL_PER_S: f64 = 0.03;
/// k_i, 1/s².
const INTEGRAL_PER_S2: f64 = PROPORTIONAL_PER_S / 1000.0;
/// Range of beta / beta_0.
const RANGE: (f64, f64) = (0.5, 3.0);

/// The servo.
#[derive(Clone, Copy, Debug, Default)]
pub struct TimePrice {
    lag_s: f64,
    integral: f64,
}

impl TimePrice {
    /// Accounts for `dt_s` at a speed, when `mean_mps` is to be kept.
    pub fn update(&mut self, speed_mps: f64, mean_mps: f64, dt_s: f64) {
        self.lag_s += dt_s * (1.0 - speed_mps / mean_mps);
        let free = INITIAL + PROPORTIONAL_PER_S * self.lag_s + self.integral;
        let saturated =
            (free > RANGE.1 && self.lag_s > 0.0) || (free < RANGE.0 && self.lag_s < 0.0);
        if !saturated {
            self.integral += INTEGRAL_PER_S2 * self.lag_s * dt_s;
        }
    }

    /// beta / beta_0.
    #[must_use]
    pub fn value(&self) -> f64 {
        (INITIAL + PROPORTIONAL_PER_S * self.lag_s + self.integral).clamp(RANGE.0, RANGE.1)
    }

    /// How late the truck is, s.
    #[must_use]
    pub fn lag_s(&self) -> f64 {
        self.lag_s
    }
}
