//! What is on air between a roadside unit and vehicles: SPATEM, MAPEM and CAM, as bytes.
//!
//! ```text
//! Message (plain data)  ── Frame::encode ──►  GeoNetworking 40 B │ BTP-B 4 B │ message in unaligned PER
//!                       ◄── Frame::decode ──
//! ```
//!
//! | part | standard | module |
//! |---|---|---|
//! | GeoNetworking, single-hop broadcast, not signed | ETSI EN 302 636-4-1 V1.4.1, clause 9 | [`geonetworking`] |
//! | BTP-B | ETSI EN 302 636-5-1 V2.2.1, clause 7 | [`geonetworking`] |
//! | SPATEM, MAPEM | ETSI TS 103 301 V2.2.1, ISO TS 19091, SAE J2735 | [`spatem`], [`mapem`] |
//! | CAM | ETSI EN 302 637-2 V1.4.1 | [`cam`], [`triggers`] |
//!
//! A message is sent with the parts that this crate's types have. Others may send all parts of the standards, and
//! additions of later versions: the decoder checks those and passes over them.
//!
//! The crate is pure: time is an argument, and it opens no port. Bytes from outside are never trusted:
//! [`Frame::decode`] returns an error, which says what is wrong, for whatever is no frame of these kinds;
//! it does not panic and takes no more memory than the frame's own size asks for.

pub mod cam;
mod codec;
mod error;
mod frame;
pub mod geodesy;
pub mod geonetworking;
pub mod mapem;
mod message;
pub mod pcap;
pub mod spatem;
pub mod time;
pub mod triggers;

pub use error::{DecodeError, EncodeError, PayloadError};
pub use frame::{Frame, MAX_FRAME_BYTES};
pub use message::{Message, MessageKind};
