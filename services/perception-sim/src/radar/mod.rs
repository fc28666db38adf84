//! The radar at the middle of the ego's front bumper, in three depths.
//!
//! * [`object_list`]: one noisy measurement for each vehicle, with its identity.
//! * detections: what the receiver of a radar hands out, several for each vehicle and some for none.
//!   [`bodies`] and [`roadside`] turn the scene into echoes, [`receiver`] turns echoes into detections,
//!   and [`detections`] holds the three together.
//! * ideal: exact and complete, taken from the scene itself.

pub mod bodies;
mod body;
pub mod detections;
pub mod echo;
pub mod numbers;
pub mod object_list;
pub mod rail;
pub mod receiver;
pub mod roadside;
pub mod scene;
