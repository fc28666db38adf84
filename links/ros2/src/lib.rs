//! A law as a ROS 2 node: `--law NAME=ros2:DOMAIN`.
//!
//! ```text
//!   controller ── question ──► pipe ──► relay ── /timegap/situation ──► node
//!              ◄── answer ──── pipe ◄──       ◄── /timegap/command ────
//! ```
//!
//! The relay is a program that answers a controller's questions, as every law of a user's does. So deadline, backup and
//! budget of restarts are those of a program. It publishes each question as `timegap_msgs/msg/LawInput`, and takes the
//! `timegap_msgs/msg/LawAnswer` that carries the question's number. `timegap print layouts --msg DIR` writes both types.
//! All their fields have eight bytes, so that a record is its own CDR.
//!
//! It speaks DDS (RTPS) on the loopback interface alone.

#[cfg(feature = "dds")]
mod relay;

#[cfg(feature = "dds")]
pub use relay::run;
