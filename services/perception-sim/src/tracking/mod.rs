//! From the radar's measurements to tracks.
//!
//! [`interacting`] is a bank of Kalman filters. [`longitudinal`] and [`lateral`] are the vehicles' models, and [`path`]
//! selects those in the ego's way. [`detection_tracker`] works on detections on the [`course`] that [`belief`] finds. Its
//! parts are [`association`], [`birth`], [`mirror`] and [`track`]. [`object_tracker`] works on measurements whose vehicle
//! is known. Both hand out a [`TrackList`].

pub mod abreast;
pub mod association;
pub mod belief;
pub mod birth;
pub mod course;
pub mod detection_tracker;
pub mod ego_speed;
mod entry;
pub mod exact_tracker;
pub mod interacting;
pub mod lateral;
pub mod list;
pub mod longitudinal;
pub mod lost;
pub mod mirror;
pub mod motion;
pub mod numbers;
pub mod object_tracker;
pub mod path;
pub mod road_ahead;
pub mod sight;
pub mod sighting;
pub mod slip;
pub mod sources;
pub mod track;
pub mod trail;
mod unite;

pub use list::{Track, TrackList};
