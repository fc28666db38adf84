//! More than eight other vehicles. The rest of a step's vehicles and poses, and both messages of a step as one.
//!
//! The first eight vehicles are in `truth/vehicles`, the others in `truth/more_vehicles`. Only scenarios with more than
//! eight send the second topic, so that a usual run does not pay for it.

use super::{Header, MAX_TRACKS, VehiclePose, VehiclePoses, VehicleTruth, VehicleTruthItem};
use crate::layout::declare::*;

/// Most vehicles beside the ego: those around a radar of 250 m range on a dense road of three lanes.
pub const MAX_VEHICLES: usize = 64;

/// Most vehicles of the second message of a step.
pub const MORE_VEHICLES: usize = MAX_VEHICLES - MAX_TRACKS;

layout! {
    /// The vehicles for which `truth/vehicles` of the same step has no room.
    pub message MoreVehicles "timegap_msgs/msg/MoreVehicles" lists vehicles: VehicleTruthItem {
        /// Valid entries of `vehicles`.
        pub count: u64,
        /// The vehicles that follow in the scenario's order; unused entries are 0.
        pub vehicles: [VehicleTruthItem; MORE_VEHICLES],
    }

    /// The bodies for which `truth/poses` of the same step has no room.
    pub message MorePoses "timegap_msgs/msg/MorePoses" lists poses: VehiclePose {
        /// Valid entries of `poses`.
        pub count: u64,
        /// The bodies that follow in the order of the vehicles; unused entries are 0.
        pub poses: [VehiclePose; MORE_VEHICLES],
    }
}

/// All vehicles beside the ego at one step, from one message or two.
///
/// ```
/// use bytemuck::Zeroable;
/// use messages::{AllVehicles, MoreVehicles, VehicleTruth};
///
/// let mut first = VehicleTruth { count: 8, ..VehicleTruth::zeroed() };
/// let more = MoreVehicles { count: 3, ..MoreVehicles::zeroed() };
/// let mut all = AllVehicles::with_room(11);
/// assert!(all.take(&first, Some(&more)));
/// assert_eq!(all.vehicles.len(), 11);
/// // Two messages of different steps are not one.
/// first.header.step = 5;
/// assert!(!all.take(&first, Some(&more)));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct AllVehicles {
    /// Header of the first message.
    pub header: Header,
    /// The scenario's storyboard has come to its end, and with it the run.
    pub ended: bool,
    /// The vehicles in the scenario's order.
    pub vehicles: Vec<VehicleTruthItem>,
}

impl AllVehicles {
    /// No vehicles yet, with room for `count`.
    pub fn with_room(count: usize) -> Self {
        Self { header: Header::zeroed(), ended: false, vehicles: Vec::with_capacity(count) }
    }

    /// The vehicles of a step that has one message.
    pub fn of(first: &VehicleTruth) -> Self {
        let mut all = Self::with_room(first.vehicles().len());
        all.take(first, None);
        all
    }

    /// Takes the messages of a step. Messages of different steps change nothing, and the result is false.
    pub fn take(&mut self, first: &VehicleTruth, more: Option<&MoreVehicles>) -> bool {
        if more.is_some_and(|more| more.header.step != first.header.step) {
            return false;
        }
        (self.header, self.ended) = (first.header, first.ended != 0);
        self.vehicles.clear();
        self.vehicles.extend_from_slice(first.vehicles());
        self.vehicles.extend_from_slice(more.map_or(&[], MoreVehicles::vehicles));
        true
    }

    /// Gap to the nearest vehicle in lane, m, and its speed, m/s. Its rear may be behind the ego's front at `ego_m` by
    /// at most a car's length.
    pub fn nearest_ahead(&self, ego_m: f64) -> Option<(f64, f64)> {
        self.vehicles
            .iter()
            .filter(|vehicle| vehicle.in_lane != 0)
            .map(|vehicle| (vehicle.rear_position_m - ego_m, vehicle.speed_mps))
            .filter(|(gap_m, _)| *gap_m > -5.0)
            .min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

/// All bodies of a step, from one message or two; `None` if they are of different steps.
pub fn all_poses<'a>(
    first: &'a VehiclePoses,
    more: Option<&'a MorePoses>,
) -> Option<impl Iterator<Item = &'a VehiclePose>> {
    let is_one = more.is_none_or(|more| more.header.step == first.header.step);
    is_one.then(|| first.poses().iter().chain(more.map_or(&[][..], MorePoses::poses)))
}
