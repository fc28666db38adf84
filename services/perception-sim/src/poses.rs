//! The other vehicles' bodies in the plane, for the referee and for pictures.

use messages::{Header, MAX_TRACKS, MorePoses, VehiclePose, VehiclePoses};
use runtime::{Publisher, Runtime, RuntimeError};
use scenario::Scenario;

use crate::vehicle::Vehicle;

/// The bodies' sender; on a road with a plan alone.
pub(crate) struct Poses {
    axis: road::Axis,
    start: road::Pose,
    port: Publisher<VehiclePoses>,
    /// With more vehicles than the first message has room for.
    more: Option<Publisher<MorePoses>>,
}

impl Poses {
    /// Opens the topic; `None` without a plan of the road.
    pub(crate) fn open(
        runtime: &mut Runtime,
        scenario: &Scenario,
    ) -> Result<Option<Self>, RuntimeError> {
        let Some(plan) = scenario.road.plan() else { return Ok(None) };
        let (axis, start) = (plan.axis().clone(), plan.start.pose());
        let has_more = scenario.actors.len() > MAX_TRACKS;
        let more = has_more.then(|| runtime.publisher()).transpose()?;
        Ok(Some(Self { axis, start, port: runtime.publisher()?, more }))
    }

    /// Sends the vehicles that are present, in the order of `truth/vehicles`. A reader with the first message has both.
    pub(crate) fn send(
        &mut self,
        header: Header,
        vehicles: &[Vehicle],
    ) -> Result<(), RuntimeError> {
        let Self { axis, start, port, more } = self;
        let mut present = vehicles.iter().filter(|vehicle| vehicle.present);
        let mut first = [VehiclePose::default(); MAX_TRACKS];
        let first_count = fill(&mut first, &mut present, axis, start);
        if let Some(more) = more {
            more.send_with(|message| {
                message.header = header;
                message.count = fill(&mut message.poses, &mut present, axis, start);
            })?;
        }
        port.send_with(|message| {
            (message.header, message.count, message.poses) = (header, first_count, first);
        })
        .map(|_| ())
    }
}

/// Fills room with the bodies of vehicles; returns how many there were.
fn fill<'a>(
    room: &mut [VehiclePose],
    vehicles: &mut impl Iterator<Item = &'a Vehicle>,
    axis: &road::Axis,
    start: &road::Pose,
) -> u64 {
    let mut count = 0;
    for place in room {
        let Some(vehicle) = vehicles.next() else { break };
        let pose = vehicle.pose(axis).placed(start);
        *place = VehiclePose {
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: pose.heading_rad,
            length_m: vehicle.length_m,
            width_m: vehicle.width_m,
        };
        count += 1;
    }
    count
}
