//! The other vehicles' bodies in the plane, for the referee and for pictures.

use messages::{Header, MAX_TRACKS, VehiclePose, VehiclePoses};
use runtime::{Publisher, Runtime, RuntimeError};
use scenario::Scenario;

use crate::vehicle::Vehicle;

/// The bodies' sender; on a road with a plan alone.
pub(crate) struct Poses {
    axis: road::Axis,
    start: road::Pose,
    port: Publisher<VehiclePoses>,
}

impl Poses {
    /// Opens the topic; `None` without a plan of the road.
    pub(crate) fn open(
        runtime: &mut Runtime,
        scenario: &Scenario,
    ) -> Result<Option<Self>, RuntimeError> {
        let Some(plan) = scenario.road.plan() else { return Ok(None) };
        let (axis, start) = (plan.axis().clone(), plan.start.pose());
        Ok(Some(Self { axis, start, port: runtime.publisher()? }))
    }

    /// Sends the vehicles that are present, in the order of `truth/vehicles`.
    pub(crate) fn send(
        &mut self,
        header: Header,
        vehicles: &[Vehicle],
    ) -> Result<(), RuntimeError> {
        let Self { axis, start, port } = self;
        port.send_with(|message| {
            message.header = header;
            let present = vehicles.iter().filter(|vehicle| vehicle.present).take(MAX_TRACKS);
            for (place, vehicle) in message.poses.iter_mut().zip(present) {
                let pose = vehicle.pose(axis).placed(start);
                *place = VehiclePose {
                    x_m: pose.x_m,
                    y_m: pose.y_m,
                    heading_rad: pose.heading_rad,
                    length_m: vehicle.length_m,
                    width_m: vehicle.width_m,
                };
                message.count += 1;
            }
        })
        .map(|_| ())
    }
}
