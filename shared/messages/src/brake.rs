//! What the emergency brake asks of the vehicle.

use super::{Header, Topic, layout, message};
use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// State of the emergency brake, by its number in messages.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BrakeState {
    /// No threat.
    #[default]
    Monitoring = 0,
    /// The driver is warned.
    Warning = 1,
    /// It brakes.
    Braking = 2,
    /// The ego stands; the brakes are held.
    Holding = 3,
    /// It sees nothing: no detections, or no odometry.
    Blind = 4,
}

impl BrakeState {
    /// All states.
    pub const ALL: [Self; 5] =
        [Self::Monitoring, Self::Warning, Self::Braking, Self::Holding, Self::Blind];

    /// Name in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Monitoring => "monitoring",
            Self::Warning => "warning",
            Self::Braking => "braking",
            Self::Holding => "holding",
            Self::Blind => "blind",
        }
    }

    /// The state with this number in a message; an unknown one is [`BrakeState::Blind`].
    #[must_use]
    pub fn from_wire(number: u32) -> Self {
        Self::ALL.get(number as usize).copied().unwrap_or(Self::Blind)
    }
}

/// Request of the emergency brake, sent in each of its cycles.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("timegap_msgs/msg/Brake")]
pub struct Brake {
    /// Common header; its acquisition time is that of the release.
    pub header: Header,
    /// Scheduled release of the radar's cycle that published the detections, ns of run time; −1
    /// without any.
    pub radar_release_ns: i64,
    /// Since when the service waited for its release, ns of run time.
    pub idle_ns: i64,
    /// When the cycle began to work on its inputs, ns of run time.
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

message!(Brake, Topic::Brake);
layout!(Brake {
    header,
    radar_release_ns,
    idle_ns,
    start_ns,
    state,
    objects,
    deceleration_mps2,
    gap_m,
    relative_speed_mps,
    lateral_m
});
