//! The servo that keeps the mean speed: it makes time dearer while the truck is late.
//!
//! ```text
//! lag' = 1 - v / v_mean        beta / beta_0 = p_0 + k_p lag + k_i ∫ lag dt
//! ```
//!
//! It is slow on purpose: the lag that a hill makes and the dip after it takes back is no reason to hurry.

/// k_p, 1/s.
const PROPORTIONAL_PER_S: f64 = 0.015;
/// k_i, 1/s².
const INTEGRAL_PER_S2: f64 = PROPORTIONAL_PER_S / 2000.0;
/// Range of beta / beta_0.
const RANGE: (f64, f64) = (0.5, 5.0);

/// The servo.
#[derive(Clone, Copy, Debug)]
pub struct TimePrice {
    initial: f64,
    lag_s: f64,
    integral: f64,
}

impl TimePrice {
    /// A servo whose truck is in time at the price p_0, relative to beta_0.
    #[must_use]
    pub fn new(initial: f64) -> Self {
        Self { initial, lag_s: 0.0, integral: 0.0 }
    }

    /// Accounts for `dt_s` at a speed, when `mean_mps` is to be kept.
    pub fn update(&mut self, speed_mps: f64, mean_mps: f64, dt_s: f64) {
        self.lag_s += dt_s * (1.0 - speed_mps / mean_mps);
        let free = self.initial + PROPORTIONAL_PER_S * self.lag_s + self.integral;
        let saturated =
            (free > RANGE.1 && self.lag_s > 0.0) || (free < RANGE.0 && self.lag_s < 0.0);
        if !saturated {
            self.integral += INTEGRAL_PER_S2 * self.lag_s * dt_s;
        }
    }

    /// beta / beta_0.
    #[must_use]
    pub fn value(&self) -> f64 {
        (self.initial + PROPORTIONAL_PER_S * self.lag_s + self.integral).clamp(RANGE.0, RANGE.1)
    }

    /// How late the truck is, s.
    #[must_use]
    pub fn lag_s(&self) -> f64 {
        self.lag_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_truck_pays_more_for_time_until_it_is_in_time() {
        let mut price = TimePrice::new(1.3);
        // A truck whose speed answers to the price: 20 m/s at 1.6.
        let mut speed_mps = 19.8;
        for _ in 0..600_000 {
            price.update(speed_mps, 20.0, 0.1);
            speed_mps = 20.0 + 0.5 * (price.value() - 1.6);
        }
        assert!(price.lag_s().abs() < 1.0, "{price:?}");
        assert!((price.value() - 1.6).abs() < 0.01, "{price:?}");
    }

    #[test]
    fn a_truck_that_cannot_go_faster_winds_nothing_up() {
        let mut price = TimePrice::new(1.3);
        for _ in 0..100_000 {
            price.update(10.0, 20.0, 0.1);
        }
        assert_eq!(price.value(), RANGE.1);
        assert!(price.integral < 1.0, "{price:?}");
    }
}
