//! From the radar's measurements to tracks.
//!
//! [`interacting`] is a bank of Kalman filters. [`longitudinal`] and [`lateral`] are the vehicles' models, and [`path`]
//! selects those in the ego's way. [`tracker`] works on the detections of either radar, on the [`course`] that [`belief`]
//! finds. Its parts are [`association`], [`birth`] and [`track`]. It hands out a [`TrackList`].

pub mod abreast;
pub mod association;
pub mod belief;
pub mod birth;
pub mod course;
pub mod ego_speed;
mod entry;
pub mod exact_tracker;
pub mod interacting;
pub mod lateral;
pub mod list;
pub mod longitudinal;
pub mod motion;
pub mod numbers;
pub mod path;
pub mod road_ahead;
pub mod sight;
pub mod sighting;
pub mod sources;
pub mod track;
pub mod tracker;
pub mod trail;
mod unite;

pub use list::{Track, TrackList};
