//! Whether the map describes the road that the truck feels.
//!
//! The difference between the map's grade under the truck and the vehicle's own estimate is averaged
//! over some seconds. Noise and a map shifted by some tens of metres stay far below the limit; another
//! road does not.

/// Time constant of the average, s.
const AVERAGING_S: f64 = 10.0;
/// The mean difference at which the map is given up, and at which it is used again.
const LIMITS: (f64, f64) = (0.012, 0.006);

/// Trust in the map.
#[derive(Clone, Copy, Debug, Default)]
pub struct MapTrust {
    difference: f64,
    lost: bool,
}

impl MapTrust {
    /// Compares for `dt_s`; without a map's grade there is nothing to compare.
    pub fn update(&mut self, map: Option<f64>, own: f64, dt_s: f64) {
        let Some(map) = map else { return };
        let share = 1.0 - libm::exp(-dt_s / AVERAGING_S);
        self.difference += share * (map - own - self.difference);
        let limit = if self.lost { LIMITS.1 } else { LIMITS.0 };
        self.lost = self.difference.abs() > limit;
    }

    /// True if the map contradicts the vehicle.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.lost
    }
}
