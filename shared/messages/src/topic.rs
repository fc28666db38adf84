//! The topics: who publishes what for whom.

use super::{Drive, Header, Laid, Layout};
use crate::Service;
use bytemuck::Pod;
use core::fmt::Debug;
use iceoryx2::prelude::ZeroCopySend;

/// Version of all message layouts, an attribute of every topic: a process built with another
/// version cannot open it.
pub const LAYOUT_VERSION: &str = "3";

/// A message type with its topic.
pub trait Message: Pod + ZeroCopySend + Debug + PartialEq + Laid {
    /// Topic that carries the type.
    const TOPIC: Topic;

    /// The common header.
    fn header(&self) -> &Header;

    /// The common header, to be stamped.
    fn header_mut(&mut self) -> &mut Header;

    /// What the ego does and meets, of a message that says so: conditions of faults refer to it.
    fn drive(&self) -> Option<Drive> {
        None
    }
}

/// Every topic of the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Topic {
    /// `vehicle/odometry`
    Odometry,
    /// `vehicle/powertrain`
    Powertrain,
    /// `radar/tracks`
    RadarTracks,
    /// `v2x/spat`
    Spat,
    /// `v2x/map`
    Map,
    /// `v2x/preview`
    Preview,
    /// `control/command`
    Command,
    /// `control/diagnostics`
    Diagnostics,
    /// `truth/vehicles`
    VehicleTruth,
    /// `truth/signals`
    SignalTruth,
    /// `health/heartbeat`
    Heartbeat,
    /// `radar/detections`; behind the others, because a topic's number is part of its data ID.
    RadarDetections,
    /// `safety/brake`
    Brake,
    /// `truth/ego`
    EgoTruth,
    /// `radio/frames`
    RadioFrames,
    /// `radio/sent`
    RadioSent,
}

/// All topics, in the order of the data's way.
pub const TOPICS: [Topic; 16] = [
    Topic::Odometry,
    Topic::Powertrain,
    Topic::RadarDetections,
    Topic::RadarTracks,
    Topic::RadioFrames,
    Topic::Spat,
    Topic::Map,
    Topic::Preview,
    Topic::RadioSent,
    Topic::Command,
    Topic::Diagnostics,
    Topic::Brake,
    Topic::EgoTruth,
    Topic::VehicleTruth,
    Topic::SignalTruth,
    Topic::Heartbeat,
];

impl Topic {
    /// Name on the wire.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Odometry => "vehicle/odometry",
            Self::Powertrain => "vehicle/powertrain",
            Self::RadarDetections => "radar/detections",
            Self::Brake => "safety/brake",
            Self::RadarTracks => "radar/tracks",
            Self::Spat => "v2x/spat",
            Self::Map => "v2x/map",
            Self::Preview => "v2x/preview",
            Self::Command => "control/command",
            Self::Diagnostics => "control/diagnostics",
            Self::EgoTruth => "truth/ego",
            Self::VehicleTruth => "truth/vehicles",
            Self::SignalTruth => "truth/signals",
            Self::Heartbeat => "health/heartbeat",
            Self::RadioFrames => "radio/frames",
            Self::RadioSent => "radio/sent",
        }
    }

    /// Size of its message, bytes.
    #[must_use]
    pub const fn message_bytes(self) -> usize {
        self.layout().bytes
    }

    /// Layout of its message.
    #[must_use]
    pub const fn layout(self) -> &'static Layout {
        match self {
            Self::Odometry => super::Odometry::LAYOUT,
            Self::Powertrain => super::Powertrain::LAYOUT,
            Self::RadarDetections => super::RadarDetections::LAYOUT,
            Self::Brake => super::Brake::LAYOUT,
            Self::RadarTracks => super::RadarTracks::LAYOUT,
            Self::Spat => super::Spat::LAYOUT,
            Self::Map => super::Map::LAYOUT,
            Self::Preview => super::Preview::LAYOUT,
            Self::Command => super::Command::LAYOUT,
            Self::Diagnostics => super::Diagnostics::LAYOUT,
            Self::EgoTruth => super::EgoTruth::LAYOUT,
            Self::VehicleTruth => super::VehicleTruth::LAYOUT,
            Self::SignalTruth => super::SignalTruth::LAYOUT,
            Self::Heartbeat => super::Heartbeat::LAYOUT,
            Self::RadioFrames => super::RadioFrames::LAYOUT,
            Self::RadioSent => super::RadioSent::LAYOUT,
        }
    }

    /// The topic of that name.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        TOPICS.into_iter().find(|topic| topic.name() == name)
    }

    /// Data ID of the end-to-end protection of what `source` sends on it.
    #[must_use]
    pub const fn data_id(self, source: u32) -> u32 {
        (self as u32 + 1) << 16 | source
    }

    /// Services that may publish it, of which a group has one; none where every service does. The signals
    /// come from the on-board unit where there is one, else as structs from the roadside unit.
    #[must_use]
    pub const fn sources(self) -> &'static [Service] {
        match self {
            Self::Odometry | Self::Powertrain | Self::EgoTruth => &[Service::Plant],
            Self::RadarDetections | Self::RadarTracks | Self::VehicleTruth => {
                &[Service::PerceptionSim]
            }
            Self::Spat | Self::Map => &[Service::Obu, Service::V2xSim],
            Self::Preview | Self::SignalTruth | Self::RadioFrames => &[Service::V2xSim],
            Self::Command | Self::Diagnostics => &[Service::Controller],
            Self::Brake => &[Service::Aebs],
            Self::RadioSent => &[Service::Obu],
            Self::Heartbeat => &[],
        }
    }

    /// Service that publishes it in a group of `services`; `None` where every service does, or none.
    #[must_use]
    pub fn source(self, services: &[Service]) -> Option<Service> {
        self.sources().iter().copied().find(|source| services.contains(source))
    }

    /// True of what the simulators know and no fault falsifies.
    #[must_use]
    pub const fn is_truth(self) -> bool {
        matches!(self, Self::EgoTruth | Self::VehicleTruth | Self::SignalTruth)
    }

    /// Services whose cycles are computed from it: those that a lockstep run makes wait for it.
    #[must_use]
    pub const fn consumers(self) -> &'static [Service] {
        match self {
            Self::Odometry => {
                &[Service::PerceptionSim, Service::Controller, Service::Aebs, Service::Obu]
            }
            // The controller, the emergency brake and the on-board unit hear it for faults that wait for a
            // phase, and for nothing else.
            Self::EgoTruth => &[
                Service::PerceptionSim,
                Service::V2xSim,
                Service::Controller,
                Service::Aebs,
                Service::Obu,
            ],
            Self::RadarDetections => &[Service::Aebs],
            Self::RadioFrames => &[Service::Obu],
            Self::Powertrain | Self::RadarTracks | Self::Spat | Self::Map | Self::Preview => {
                &[Service::Controller]
            }
            Self::Command | Self::Brake | Self::VehicleTruth | Self::SignalTruth => {
                &[Service::Plant]
            }
            // To send them on, where the radio leads to another host.
            Self::RadioSent => &[Service::V2xSim],
            Self::Diagnostics | Self::Heartbeat => &[],
        }
    }
}
