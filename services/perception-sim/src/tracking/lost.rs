//! A vehicle in the ego's path that is not seen any more is assumed to continue its motion.
//!
//! A filter loses an acceleration within seconds. Behind a lead that braked when it was lost, that would be a
//! prediction on the unsafe side. So the last motion is carried on. It brakes on if it braked, and keeps its speed
//! otherwise, until it stands.
//!
//! ```
//! use perception_sim::radar::scene::Ego;
//! use perception_sim::tracking::lost::Lost;
//!
//! let ego = Ego { speed_mps: 20.0, ..Ego::default() };
//! let mut lost = Lost { gap_m: 30.0, speed_mps: 10.0, acceleration_mps2: -5.0 };
//! for _ in 0..60 {
//!     lost.carry_on(0.05, &ego);
//! }
//! // It stood after 2 s and 10 m; the ego drove 60 m.
//! assert!((lost.gap_m + 20.0).abs() < 1e-9 && lost.speed_mps == 0.0);
//! ```

use crate::radar::scene::Ego;

/// The motion of a lost vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lost {
    /// Bumper-to-bumper distance, m.
    pub gap_m: f64,
    /// Speed over ground, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s², at most 0.
    pub acceleration_mps2: f64,
}

impl Lost {
    /// Moves on by `dt_s` ahead of `ego`.
    pub fn carry_on(&mut self, dt_s: f64, ego: &Ego) {
        let braking = -self.acceleration_mps2;
        let moving_s = if braking > 0.0 { (self.speed_mps / braking).min(dt_s) } else { dt_s };
        let driven_m = self.speed_mps * moving_s - 0.5 * braking * moving_s * moving_s;
        let stops = braking > 0.0 && moving_s < dt_s;
        self.speed_mps = if stops { 0.0 } else { self.speed_mps - braking * moving_s };
        if stops {
            self.acceleration_mps2 = 0.0;
        }
        self.gap_m += driven_m - ego.speed_mps * dt_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_keeps_its_speed_or_brakes_on() {
        let ego = Ego { speed_mps: 15.0, ..Ego::default() };
        let mut steady = Lost { gap_m: 40.0, speed_mps: 12.0, acceleration_mps2: 0.0 };
        steady.carry_on(1.0, &ego);
        assert_eq!(steady, Lost { gap_m: 37.0, ..steady });
        assert_eq!(steady.speed_mps, 12.0);
        let mut braking = Lost { gap_m: 40.0, speed_mps: 12.0, acceleration_mps2: -4.0 };
        braking.carry_on(1.0, &ego);
        assert_eq!((braking.gap_m, braking.speed_mps), (35.0, 8.0));
        braking.carry_on(4.0, &ego);
        assert_eq!((braking.gap_m, braking.speed_mps), (35.0 + 8.0 - 60.0, 0.0));
        braking.carry_on(1.0, &ego);
        assert_eq!((braking.gap_m, braking.acceleration_mps2), (-32.0, 0.0), "it stands");
    }
}
