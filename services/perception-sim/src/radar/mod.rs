//! The radar at the middle of the ego's front bumper, in three depths.
//!
//! * [`object_list`]: one noisy measurement for each vehicle, with its identity.
//! * detections: the output of a radar's receiver, several for some vehicles and none for others. [`bodies`] and
//!   [`roadside`] turn the scene into echoes, [`receiver`] turns echoes into detections, and [`detections`] holds the
//!   three together.
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

use messages::Detection;

/// Output of a radar in one scan.
#[derive(Clone, Copy, Debug)]
pub struct Scan<'a> {
    /// Its detections, in the order of their ranges if their vehicles are not known.
    pub detections: &'a [Detection],
    /// The vehicle of each, by its place in the scenario; empty if they are not known.
    pub vehicles: &'a [usize],
}

impl<'a> Scan<'a> {
    /// Detections whose vehicles are not known.
    pub fn of_echoes(detections: &'a [Detection]) -> Self {
        Self { detections, vehicles: &[] }
    }
}
