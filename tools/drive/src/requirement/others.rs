//! The motion of the other vehicles, as it was recorded and past the record's end.
//!
//! Between two samples a vehicle keeps its acceleration, as for the referee. After the last one it keeps its
//! deceleration until it stands, and one that speeds up keeps its speed.

use super::evidence::Evidence;
use crate::log::Present;
use messages::{AllVehicles, VehicleTruthItem};

/// The other vehicles of a drive.
pub(super) struct Others<'a> {
    truths: &'a [AllVehicles],
    present: Present,
    ego_length_m: f64,
}

/// Another vehicle at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Other {
    /// Distinguishes vehicles.
    pub identity: u32,
    /// Position of the rear bumper along the road, m.
    pub rear_m: f64,
    pub length_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
}

impl<'a> Others<'a> {
    pub(super) fn of(evidence: &Evidence<'a>) -> Self {
        Self {
            truths: &evidence.drive.vehicles,
            present: Present::of(evidence.scenario),
            ego_length_m: evidence.scenario.plant.length_m.value(),
        }
    }

    /// The vehicles whose bodies reach into the ego's lane at `time_s`.
    pub(super) fn in_lane_at(&self, time_s: f64) -> impl Iterator<Item = Other> + '_ {
        let next = self.truths.partition_point(|truth| taken_s(truth) <= time_s + 1e-9);
        let is_last = next == self.truths.len();
        let truth = next.checked_sub(1).map(|index| &self.truths[index]);
        truth.into_iter().flat_map(move |truth| {
            let age_s = (time_s - taken_s(truth)).max(0.0);
            let listed = truth.vehicles.iter().enumerate();
            listed.filter(|(_, vehicle)| vehicle.in_lane != 0).map(move |(place, vehicle)| {
                let moved = moved(vehicle, age_s, is_last);
                Other {
                    identity: self.present.actor(truth, place).unwrap_or(place as u32),
                    length_m: self.present.length_m(truth, place),
                    ..moved
                }
            })
        })
    }

    /// The nearest vehicle in lane that is not wholly behind an ego with its front at `front_m`.
    pub(super) fn nearest(&self, front_m: f64, time_s: f64) -> Option<Other> {
        let is_behind =
            |other: &Other| other.rear_m - front_m <= -(self.ego_length_m + other.length_m);
        let near = self.in_lane_at(time_s).filter(|other| !is_behind(other));
        near.min_by(|a, b| a.rear_m.total_cmp(&b.rear_m))
    }

    /// True if the other's middle is ahead of the middle of an ego with its front at `front_m`.
    pub(super) fn is_ahead(&self, other: &Other, front_m: f64) -> bool {
        other.rear_m - front_m > -0.5 * (self.ego_length_m + other.length_m)
    }
}

fn taken_s(truth: &AllVehicles) -> f64 {
    truth.header.acquisition_ns as f64 / 1e9
}

/// A vehicle `age_s` after its sample; braking ends at standstill.
fn moved(vehicle: &VehicleTruthItem, age_s: f64, is_last: bool) -> Other {
    let v = vehicle.speed_mps;
    let a = vehicle.acceleration_mps2;
    let a = if is_last { a.min(0.0) } else { a };
    let moving_s = if a < 0.0 { age_s.min(v / -a) } else { age_s };
    Other {
        identity: 0,
        rear_m: vehicle.rear_position_m + (v + 0.5 * a * moving_s) * moving_s,
        length_m: 0.0,
        speed_mps: v + a * moving_s,
        acceleration_mps2: if moving_s < age_s { 0.0 } else { a },
    }
}
