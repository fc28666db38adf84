//! Phases of the drive that a fault can wait for.

/// Drive of the ego at one instant: faults can wait for a phase of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Position of the front bumper, m.
    pub position_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s².
    pub acceleration_mps2: f64,
    /// Time to collision with the vehicle ahead, s, or infinite.
    pub time_to_collision_s: f64,
    /// Distance to the next stop line if its signal shows red, m, else infinite.
    pub red_line_m: f64,
    /// A vehicle ahead moves sideways towards the ego's lane.
    pub cut_in: bool,
}

impl Drive {
    /// An ego there, so fast, that meets nothing.
    #[must_use]
    pub fn free(position_m: f64, speed_mps: f64) -> Self {
        Self {
            position_m,
            speed_mps,
            acceleration_mps2: 0.0,
            time_to_collision_s: f64::INFINITY,
            red_line_m: f64::INFINITY,
            cut_in: false,
        }
    }
}
