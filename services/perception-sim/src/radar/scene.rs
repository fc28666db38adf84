//! The scene before the radar at one instant.

use messages::MAX_TRACKS;

use crate::vehicle::Vehicle;

/// The ego as the radar's platform.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ego {
    /// Position of the front bumper along the road, m.
    pub position_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
}

/// The ego and the other vehicles at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Scene {
    /// When, ns since the start of the run; before it: negative.
    pub time_ns: i64,
    /// The ego as it truly is.
    pub ego: Ego,
    /// The ego as its odometry says; `None` without odometry of use.
    pub told: Option<Ego>,
    /// The other vehicles, in the scenario's order; the rest are not present.
    pub vehicles: [Vehicle; MAX_TRACKS],
}

impl Scene {
    /// The scene of some vehicles, at most [`MAX_TRACKS`].
    #[must_use]
    pub fn new(time_ns: i64, ego: Ego, vehicles: &[Vehicle]) -> Self {
        let mut scene = Self { time_ns, ego, told: Some(ego), ..Self::default() };
        for (place, vehicle) in scene.vehicles.iter_mut().zip(vehicles) {
            *place = *vehicle;
        }
        scene
    }

    /// The scene `back_ns` earlier, if until then all had kept the present speed.
    #[must_use]
    pub fn earlier(&self, back_ns: i64) -> Self {
        let back_s = back_ns as f64 * 1e-9;
        let earlier = |ego: Ego| Ego {
            position_m: ego.position_m - ego.speed_mps * back_s,
            acceleration_mps2: 0.0,
            ..ego
        };
        let (ego, told) = (earlier(self.ego), self.told.map(earlier));
        let vehicles = self.vehicles.map(|vehicle| Vehicle {
            rear_position_m: vehicle.rear_position_m - vehicle.speed_mps * back_s,
            acceleration_mps2: 0.0,
            lateral_speed_mps: 0.0,
            ..vehicle
        });
        Self { time_ns: self.time_ns - back_ns, ego, told, vehicles }
    }
}
