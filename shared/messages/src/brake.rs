//! Request of the emergency brake to the vehicle.

use crate::layout::declare::*;
use crate::numbered;

numbered! {
    /// State of the emergency brake, by its number in messages.
    #[derive(Default)]
    pub enum BrakeState {
        /// No threat.
        #[default]
        Monitoring = 0 "monitoring",
        /// The driver is warned.
        Warning = 1 "warning",
        /// The emergency brake brakes.
        Braking = 2 "braking",
        /// The ego stands; the brakes are held.
        Holding = 3 "holding",
        /// Inputs are missing: no detections, or no odometry.
        Blind = 4 "blind",
    }
}

impl BrakeState {
    /// State with this number in a message; an unknown number is [`BrakeState::Blind`].
    pub fn from_wire(number: u32) -> Self {
        Self::by_number(number).unwrap_or(Self::Blind)
    }
}

layout! {
    /// Request of the emergency brake, sent in each of its cycles.
    pub message Brake "timegap_msgs/msg/Brake" {
        /// Scheduled release of the radar's cycle that published the detections, ns of run time; −1
        /// without any.
        pub radar_release_ns: i64,
        /// Since when the service waited for its release, ns of run time.
        pub idle_ns: i64,
        /// Time when the cycle began to work on its inputs, ns of run time.
        pub start_ns: i64,
        /// [`BrakeState`] as a number.
        pub state: u32,
        /// Objects that count.
        pub objects: u32,
        /// Requested deceleration, m/s², 0 for none.
        pub deceleration_mps2: f64,
        /// Distance to the threat, m; 0 without one.
        pub gap_m: f64,
        /// Speed of the threat minus the ego's, m/s; 0 without one.
        pub relative_speed_mps: f64,
        /// Lateral position of the threat, m left of the ego's axis; 0 without one.
        pub lateral_m: f64,
    }
}
