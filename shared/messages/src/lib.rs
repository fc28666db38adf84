//! The messages and topics that all services agree on, and their end-to-end protection.
//!
//! Every message is `repr(C)` plain data without padding, in SI units, x forward and y left. It
//! starts with a [`Header`]. [`message!`](self) checks the layout at compile time: a type with
//! implicit padding, a `bool` or a pointer does not compile (`bytemuck::Pod`), and neither does one
//! whose header is not its first field or whose size is not a multiple of eight.
//!
//! | topic | message | published by | read by |
//! | --- | --- | --- | --- |
//! | `vehicle/odometry` | [`Odometry`] | plant | perception-sim, controller, aebs, obu |
//! | `vehicle/powertrain` | [`Powertrain`] | plant, of a truck | controller |
//! | `radar/detections` | [`RadarDetections`] | perception-sim | aebs |
//! | `radar/tracks` | [`RadarTracks`] | perception-sim | controller |
//! | `radio/frames` | [`RadioFrames`] | v2x-sim, with frames | obu |
//! | `v2x/spat` | [`Spat`] | obu; v2x-sim without frames | controller |
//! | `v2x/map` | [`Map`] | obu; v2x-sim without frames | controller |
//! | `v2x/preview` | [`Preview`] | v2x-sim, for a truck | controller |
//! | `radio/sent` | [`RadioSent`] | obu | v2x-sim, to send it on to another host |
//! | `control/command` | [`Command`] | controller | plant |
//! | `control/diagnostics` | [`Diagnostics`] | controller | (observers) |
//! | `safety/brake` | [`Brake`] | aebs | plant |
//! | `truth/ego` | [`EgoTruth`] | plant | perception-sim, v2x-sim |
//! | `truth/vehicles` | [`VehicleTruth`] | perception-sim | plant (referee) |
//! | `truth/signals` | [`SignalTruth`] | v2x-sim | plant (referee) |
//! | `health/heartbeat` | [`Heartbeat`] | every service | launcher |
//!
//! The `truth/` topics carry what the simulators know and no fault distorts: the simulated sensors
//! measure from them, and the referee in the plant judges by them. No actuation depends on them.

mod brake;
mod control;
mod drive;
pub mod e2e;
mod header;
mod health;
mod law;
mod layout;
pub mod level;
pub mod names;
pub mod notes;
mod perception;
mod radio;
mod service;
mod topic;
mod v2x;
mod vehicle;

pub use brake::{Brake, BrakeState};
pub use control::{Command, Diagnostics, FIGURES, PLAN_LEN};
pub use drive::Drive;
pub use header::{Header, Origin, Origins};
pub use health::{Heartbeat, ServiceState};
pub use law::{
    LAW_CELLS, LAW_FIGURES, LAW_INTERVALS, LAW_MODES, LAW_PLAN, LAW_RECORDS, LAW_SIGNALS,
    LawAnswer, LawInput, LawInterval, LawSignal,
};
pub use layout::{Element, Field, Laid, Layout, Place, SMALL_BYTES, Scalar, Shape, Value};
pub use perception::{
    Detection, MAX_DETECTIONS, MAX_TRACKS, RadarDetections, RadarTracks, Track, TrackedTarget,
    VehicleTruth, VehicleTruthItem,
};
pub use radio::{MAX_FRAME_BYTES, MAX_FRAMES, RadioFrame, RadioFrames, RadioSent};
pub use service::{Service, UnknownService};
pub use topic::{LAYOUT_VERSION, Message, TOPICS, Topic};
pub use v2x::{
    Interval, Lane, MAX_INTERVALS, MAX_LANES, MAX_PREVIEW_CELLS, MAX_SIGNALS, Map, PhaseState,
    Preview, Signal, SignalTruth, Spat,
};
pub use vehicle::{EgoTruth, Odometry, Powertrain};

/// Declares `$type` to be the message of `$topic`, after checking its layout at compile time.
macro_rules! message {
    ($type:ty, $topic:expr $(, $($hook:tt)+)?) => {
        impl crate::Message for $type {
            const TOPIC: crate::Topic = $topic;

            fn header(&self) -> &crate::Header {
                &self.header
            }

            fn header_mut(&mut self) -> &mut crate::Header {
                &mut self.header
            }

            $($($hook)+)?
        }

        const _: () = {
            assert!(core::mem::offset_of!($type, header) == 0, "the header comes first");
            assert!(core::mem::size_of::<$type>() % 8 == 0, "whole words");
            assert!(core::mem::align_of::<$type>() == 8, "natural alignment");
        };
    };
}
pub(crate) use layout::{layout, shape_of};
use message;
