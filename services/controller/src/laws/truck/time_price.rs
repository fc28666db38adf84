//! The servo that keeps the mean speed: it makes time dearer while the truck is late.
//!
//! ```text
//! lag' = 1 - v / v_ref        beta / beta_0 = p_0 + k_m (m - 1) + k_p lag + k_i ∫ lag dt
//! ```
//!
//! v_ref is the speed, on the same metre, of another truck. It keeps m times the set speed where its engine can
//! (`reference`). No price makes up for a climb that full load cannot hold. A lag counted from the set speed itself
//! would swing the price with every long wave of the road. The rest is the planner's own lateness. The servo is slow on
//! purpose. A hill makes a lag, and the dip after it takes it back. So the lag is not a reason to hurry. A mean speed m
//! that is asked for moves the price at once, not by a lag that builds up.

/// k_p, 1/s.
const PROPORTIONAL_PER_S: f64 = 0.008;
/// k_i, 1/s²: with the response below a third of the critical damping.
const INTEGRAL_PER_S2: f64 = PROPORTIONAL_PER_S / 4000.0;
/// k_m: price per relative mean speed. On generated hills either planner answers to one more unit of price
/// with 2 to 5 % of mean speed (docs/measurements.md).
const PRICE_PER_MEAN: f64 = 20.0;
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
    /// A servo whose truck is in time at the price p_0, relative to beta_0, at its set speed. Here it must keep
    /// `mean_speed` times it.
    #[must_use]
    pub fn new(usual: f64, mean_speed: f64) -> Self {
        let initial = usual + PRICE_PER_MEAN * (mean_speed - 1.0);
        Self { initial, lag_s: 0.0, integral: 0.0 }
    }

    /// Accounts for `dt_s` on a way that was due in `due_s`.
    pub fn update(&mut self, dt_s: f64, due_s: f64) {
        self.lag_s += dt_s - due_s;
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

    /// Lateness of the truck, s.
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
        let mut price = TimePrice::new(1.3, 1.0);
        // A truck whose speed answers to the price: 20 m/s at 1.6.
        let mut speed_mps = 19.8;
        for _ in 0..1_200_000 {
            price.update(0.1, 0.1 * speed_mps / 20.0);
            speed_mps = 20.0 + 0.5 * (price.value() - 1.6);
        }
        assert!(price.lag_s().abs() < 1.0, "{price:?}");
        assert!((price.value() - 1.6).abs() < 0.01, "{price:?}");
    }

    #[test]
    fn a_truck_that_cannot_go_faster_winds_nothing_up() {
        let mut price = TimePrice::new(1.3, 1.0);
        for _ in 0..100_000 {
            price.update(0.1, 0.05);
        }
        assert_eq!(price.value(), RANGE.1);
        assert!(price.integral < 1.0, "{price:?}");
    }

    #[test]
    fn a_higher_mean_speed_has_its_price_at_once() {
        let (usual, faster) = (TimePrice::new(1.3, 1.0), TimePrice::new(1.3, 1.02));
        assert!((faster.value() - usual.value() - 0.4).abs() < 1e-12);
    }
}
