//! The topics: one row each, with its message, its senders and its receivers.
//!
//! [`Topic`] shows the rows as a table.
//!
//! ```
//! use messages::{Message, Odometry, Service, Topic};
//!
//! let topic = Topic::by_name("vehicle/odometry").expect("a row");
//! assert_eq!(topic, Odometry::TOPIC);
//! assert_eq!(topic.sources(), [Service::Plant]);
//! assert!(topic.consumers().contains(&Service::Controller));
//! assert_eq!(topic.message_bytes(), size_of::<Odometry>());
//! ```

use super::{Header, Laid, Layout};
use crate::Service;
use bytemuck::Pod;
use core::fmt::Debug;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

/// Version of all message layouts, an attribute of every topic: a process built with another
/// version cannot open it.
pub const LAYOUT_VERSION: &str = "3";

/// A message type with its topic.
pub trait Message: Pod + ZeroCopySend + Debug + PartialEq + Laid {
    const TOPIC: Topic;

    fn header(&self) -> &Header;

    fn header_mut(&mut self) -> &mut Header;
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Carries what a car has. Faults of messages can disturb it.
    Function,
    /// Carries the simulators' truth. No fault changes it.
    Truth,
    /// Informs observers. No fault disturbs it.
    Report,
}

struct Row {
    name: &'static str,
    layout: &'static Layout,
    role: Role,
    sources: &'static [Service],
    consumers: &'static [Service],
    shows: Option<Service>,
}

/// Declares the topics. `number Message "name" Role, [senders] to [receivers];` is a row: the variant has the
/// message's name. `shows Service` at its end marks the topic whose first message shows that a restarted process
/// works. `$d` is a dollar sign, for the macro that this one declares.
macro_rules! topics {
    (@shows) => { None };
    (@shows $service:ident) => { Some(Service::$service) };
    ($d:tt $($(#[$doc:meta])* $number:literal $topic:ident $name:literal $role:ident,
       [$($source:ident),*] to [$($consumer:ident),*] $(shows $shown:ident)?;)+) => {
        /// Every topic of the group; the number is a part of its data ID.
        ///
        /// | topic | message | published by | read by |
        /// | --- | --- | --- | --- |
        $(#[doc = concat!(
            "| `", $name, "` | [`", stringify!($topic), "`](struct@crate::", stringify!($topic), ") | ",
            $("[`", stringify!($source), "`](Service::", stringify!($source), ") ",)* "| ",
            $("[`", stringify!($consumer), "`](Service::", stringify!($consumer), ") ",)* "|"
        )])+
        ///
        /// Every service publishes a topic without a publisher. Observers alone read one without a reader.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Topic {
            $(#[doc = concat!("`", $name, "`")] $(#[$doc])* $topic = $number,)+
        }

        /// All topics, in the order of the data's way.
        pub const TOPICS: [Topic; [$($number),+].len()] = [$(Topic::$topic),+];

        impl Topic {
            const fn row(self) -> &'static Row {
                match self {
                    $(Self::$topic => &Row {
                        name: $name,
                        layout: <crate::$topic as Laid>::LAYOUT,
                        role: Role::$role,
                        sources: &[$(Service::$source),*],
                        consumers: &[$(Service::$consumer),*],
                        shows: topics!(@shows $($shown)?),
                    },)+
                }
            }
        }

        $(impl Message for crate::$topic {
            const TOPIC: Topic = Topic::$topic;

            fn header(&self) -> &Header {
                &self.header
            }

            fn header_mut(&mut self) -> &mut Header {
                &mut self.header
            }
        }

        const _: () = {
            assert!(core::mem::offset_of!(crate::$topic, header) == 0, "the header comes first");
            assert!(align_of::<crate::$topic>() == Layout::ALIGNMENT, "natural alignment");
        };)+

        /// Calls the macro `$callback` with the types of all messages, in the order of [`TOPICS`].
        ///
        /// ```
        /// macro_rules! largest {
        ///     ($($message:ty),+) => { [$(size_of::<$message>()),+].into_iter().max() };
        /// }
        /// assert_eq!(messages::each_message!(largest), Some(size_of::<messages::RadarDetections>()));
        /// ```
        #[macro_export]
        macro_rules! each_message {
            ($d callback:ident) => {
                $d callback! { $($d crate::$topic),+ }
            };
        }
    };
}

topics! { $
    0 Odometry "vehicle/odometry" Function, [Plant] to [PerceptionSim, Controller, Aebs, Obu];
    /// Sent for a truck.
    1 Powertrain "vehicle/powertrain" Function, [Plant] to [Controller];
    11 RadarDetections "radar/detections" Function, [PerceptionSim] to [Aebs];
    2 RadarTracks "radar/tracks" Function, [PerceptionSim] to [Controller] shows PerceptionSim;
    /// Sent where signals come as frames.
    14 RadioFrames "radio/frames" Function, [V2xSim] to [Obu];
    /// Sent by the on-board unit where there is one, else by the roadside unit.
    3 Spat "v2x/spat" Function, [Obu, V2xSim] to [Controller] shows Obu;
    /// Sent as `v2x/spat` is.
    4 Map "v2x/map" Function, [Obu, V2xSim] to [Controller];
    /// Sent for a truck.
    5 Preview "v2x/preview" Function, [V2xSim] to [Controller];
    /// Read where the radio leads to another host, to send it on.
    15 RadioSent "radio/sent" Report, [Obu] to [V2xSim];
    6 Command "control/command" Function, [Controller] to [Plant] shows Controller;
    7 Diagnostics "control/diagnostics" Report, [Controller] to [];
    12 Brake "safety/brake" Function, [Aebs] to [Plant] shows Aebs;
    /// The last three receivers use it only for faults that wait for a phase of the drive.
    13 EgoTruth "truth/ego" Truth, [Plant] to [PerceptionSim, V2xSim, Controller, Aebs, Obu] shows Plant;
    8 VehicleTruth "truth/vehicles" Truth, [PerceptionSim] to [Plant];
    9 SignalTruth "truth/signals" Truth, [V2xSim] to [Plant] shows V2xSim;
    10 Heartbeat "health/heartbeat" Report, [] to [];
    /// Sent on a road with a plan, as the four below.
    16 LateralMotion "vehicle/lateral" Function, [Plant] to [PerceptionSim, Controller, Aebs];
    17 EgoPose "truth/pose" Truth, [Plant] to [PerceptionSim, V2xSim];
    18 VehiclePoses "truth/poses" Truth, [PerceptionSim] to [Plant];
    19 Course "radar/course" Function, [PerceptionSim] to [Controller, Aebs];
    20 Curves "v2x/curves" Function, [V2xSim] to [Controller, PerceptionSim];
    /// Sent where the scenario has more than eight vehicles beside the ego.
    21 MoreVehicles "truth/more_vehicles" Truth, [PerceptionSim] to [Plant];
    /// Sent with the latter on a road with a plan.
    22 MorePoses "truth/more_poses" Truth, [PerceptionSim] to [Plant];
    /// Sent where SUMO has the traffic and the lights.
    23 Lights "truth/lights" Truth, [PerceptionSim] to [V2xSim];
    /// Sent with the latter, as `v2x/spat` is.
    24 AnnouncedMotions "v2x/motions" Function, [Obu, V2xSim] to [Controller];
}

impl Topic {
    pub const fn name(self) -> &'static str {
        self.row().name
    }

    pub const fn message_bytes(self) -> usize {
        self.layout().bytes
    }

    pub const fn layout(self) -> &'static Layout {
        self.row().layout
    }

    pub fn by_name(name: &str) -> Option<Self> {
        TOPICS.into_iter().find(|topic| topic.name() == name)
    }

    /// Data ID of the end-to-end protection of messages from `source`.
    pub const fn data_id(self, source: u32) -> u32 {
        (self as u32 + 1) << 16 | source
    }

    /// Services that may publish it, of which a group has one; empty if every service does.
    pub const fn sources(self) -> &'static [Service] {
        self.row().sources
    }

    /// Service that publishes it in a group of `services`; `None` if every service does, or none.
    pub fn source(self, services: &[Service]) -> Option<Service> {
        self.sources().iter().copied().find(|source| services.contains(source))
    }

    /// Service whose restarted process works as soon as it publishes here.
    pub const fn shows(self) -> Option<Service> {
        self.row().shows
    }

    /// Topic of the same sender whose message of the same step stands for this one in [`Origins`](crate::Origins).
    pub const fn rides_with(self) -> Option<Self> {
        match self {
            Self::LateralMotion => Some(Self::Odometry),
            Self::Course => Some(Self::RadarTracks),
            Self::Curves => Some(Self::Preview),
            Self::AnnouncedMotions => Some(Self::Map),
            _ => None,
        }
    }

    pub const fn role(self) -> Role {
        self.row().role
    }

    /// Services whose cycles use it: a lockstep run makes them wait for it.
    pub const fn consumers(self) -> &'static [Service] {
        self.row().consumers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_names_in_ros_and_in_c() {
        for topic in TOPICS {
            let is_right =
                |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "/_".contains(c);
            assert!(topic.name().chars().all(is_right), "{}", topic.name());
        }
    }

    #[test]
    fn numbers_and_names_are_those_of_recordings() {
        let mut topics = TOPICS.map(|topic| (topic as u32, topic.name()));
        topics.sort_unstable();
        let recorded = [
            "vehicle/odometry",
            "vehicle/powertrain",
            "radar/tracks",
            "v2x/spat",
            "v2x/map",
            "v2x/preview",
            "control/command",
            "control/diagnostics",
            "truth/vehicles",
            "truth/signals",
            "health/heartbeat",
            "radar/detections",
            "safety/brake",
            "truth/ego",
            "radio/frames",
            "radio/sent",
            "vehicle/lateral",
            "truth/pose",
            "truth/poses",
            "radar/course",
            "v2x/curves",
            "truth/more_vehicles",
            "truth/more_poses",
            "truth/lights",
            "v2x/motions",
        ];
        // A later topic gets the next number.
        assert!(topics.into_iter().map(|(number, _)| number).eq(0..TOPICS.len() as u32));
        assert!((0..).zip(recorded).eq(topics.into_iter().take(recorded.len())), "{topics:?}");
        assert_eq!(Topic::Odometry.data_id(1), 0x1_0001);
        assert_eq!(Topic::RadioSent.data_id(6), 0x10_0006);
    }

    #[test]
    fn each_service_publishes_the_topic_that_shows_it() {
        for service in Service::ALL {
            let shows = |topic: &Topic| topic.shows() == Some(service);
            let topic = TOPICS.into_iter().find(shows).expect("each service has one");
            assert!(
                topic.sources().contains(&service),
                "{service} does not publish {}",
                topic.name()
            );
        }
    }
}
