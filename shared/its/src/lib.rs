//! Radio messages between roadside units and vehicles: SPATEM, MAPEM and CAM, as bytes.
//!
//! ```text
//! Message (plain data)  ── Frame::encode ──►  GeoNetworking 40 B │ BTP-B 4 B │ message in unaligned PER
//!                       ◄── Frame::decode ──
//! ```
//!
//! | part | standard | module |
//! |---|---|---|
//! | GeoNetworking, single-hop broadcast, not signed | ETSI EN 302 636-4-1 V1.4.1, clause 9 | [`geonetworking`] |
//! | the envelope of signed packets, not verified | ETSI TS 103 097 V2.1.1, IEEE 1609.2 | [`signed`] |
//! | BTP-B | ETSI EN 302 636-5-1 V2.2.1, clause 7 | [`geonetworking`] |
//! | SPATEM, MAPEM | ETSI TS 103 301 V2.2.1, ISO TS 19091, SAE J2735 | [`spatem`], [`mapem`] |
//! | CAM | ETSI EN 302 637-2 V1.4.1 | [`cam`], [`triggers`] |
//!
//! Encoders write the parts in this crate's types. Decoders accept all parts of the standards, and additions of later
//! versions. They check and skip the parts without a type.
//!
//! The crate is pure: time is an argument, and it opens no port. [`Frame::decode`] checks all of its bytes. It returns
//! an error for other frames, does not panic, and needs memory in proportion to the frame.
//!
//! A roadside unit announces that signal group 1 is red for 12 s more, and a vehicle reads it:
//!
//! ```
//! use its::spatem::{IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing};
//! use its::geodesy::Position;
//! use its::geonetworking::{Source, StationType};
//! use its::time::{TimeMark, its_timestamp};
//! use its::{Frame, Message};
//!
//! let now_ms = 1_780_315_170_000;
//! let timing = Timing {
//!     start: None,
//!     min_end: TimeMark::of(now_ms + 12_000, now_ms),
//!     max_end: None,
//!     likely_end: None,
//!     confidence: None,
//!     next: None,
//! };
//! let red = MovementEvent { state: MovementPhase::StopAndRemain, timing: Some(timing) };
//! let spatem = Spatem {
//!     station_id: 501,
//!     intersections: vec![IntersectionState {
//!         region: None,
//!         id: 1,
//!         revision: 0,
//!         status: 0,
//!         stamp: None,
//!         movements: vec![MovementState { signal_group: 1, events: vec![red] }],
//!     }],
//! };
//! let source = Source {
//!     station_type: StationType::RoadsideUnit,
//!     address: 501,
//!     timestamp: its_timestamp(now_ms) as u32,
//!     position: Position { latitude: 487_000_000, longitude: 91_000_000 },
//!     accurate: true,
//!     speed: 0,
//!     heading: 0,
//! };
//! let frame = Frame { source, message: Message::Spatem(spatem) };
//!
//! let bytes = frame.encode()?;
//! let received = Frame::decode(&bytes)?;
//! assert_eq!(received, frame);
//! let Message::Spatem(spatem) = received.message else { unreachable!() };
//! let end = spatem.intersections[0].movements[0].events[0].timing.expect("announced").min_end;
//! assert_eq!(end.utc(now_ms), Some(now_ms + 12_000));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod cam;
mod codec;
mod error;
mod frame;
pub mod geodesy;
pub mod geonetworking;
pub mod mapem;
mod message;
pub mod pcap;
pub mod signed;
pub mod spatem;
pub mod time;
pub mod triggers;

pub use error::{DecodeError, EncodeError, PayloadError};
pub use frame::{Frame, MAX_FRAME_BYTES};
pub use message::{Message, MessageKind};
