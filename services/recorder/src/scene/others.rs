//! The other vehicles as they are drawn.

use super::draw::Color;
use super::ground::Place;
use super::{Body, Scene, USUAL_LENGTH_M};
use messages::{VehicleTruthItem, all_poses};
use scenario::event::VEHICLE_WIDTH_M;

impl Scene {
    /// The vehicles of the newest step, those of its second message included.
    fn listed(&self) -> impl Iterator<Item = &VehicleTruthItem> {
        let first = self.vehicles.iter().flat_map(|truth| truth.vehicles());
        let step = self.vehicles.as_ref().map(|truth| truth.header.step);
        let more = self.more_vehicles.iter().filter(move |more| Some(more.header.step) == step);
        first.chain(more.flat_map(|more| more.vehicles()))
    }

    /// The vehicles of a straight road.
    pub(super) fn along(&self) -> Vec<Body> {
        let bodies = self.listed().enumerate().map(|(index, vehicle)| Body {
            frame: format!("vehicle_{index}"),
            rear: self.ground.place(vehicle.rear_position_m, vehicle.lateral_m),
            length_m: self.lengths_m.get(index).copied().unwrap_or(USUAL_LENGTH_M),
            width_m: VEHICLE_WIDTH_M,
            color: self.color(index),
        });
        bodies.filter(|body| body.rear.is_finite()).collect()
    }

    /// The vehicles of a road with a plan.
    pub(super) fn posed(&self) -> Vec<Body> {
        let more = self.more_poses.as_deref();
        let poses = self.poses.iter().flat_map(|first| {
            let more = more.filter(|more| more.header.step == first.header.step);
            all_poses(first, more).into_iter().flatten()
        });
        let bodies = poses.enumerate().map(|(index, pose)| {
            let middle = Place { at_m: [pose.x_m, pose.y_m], heading_rad: pose.heading_rad };
            Body {
                frame: format!("vehicle_{index}"),
                rear: Place { at_m: middle.point(-0.5 * pose.length_m, 0.0), ..middle },
                length_m: pose.length_m,
                width_m: pose.width_m,
                color: self.color(index),
            }
        });
        bodies.filter(|body| body.rear.is_finite()).collect()
    }

    /// Colour of a vehicle: orange in the ego's lane.
    fn color(&self, index: usize) -> Color {
        let vehicle = self.listed().nth(index);
        if vehicle.is_some_and(|vehicle| vehicle.in_lane != 0) {
            Color::ORANGE
        } else {
            Color::GREY
        }
    }
}
