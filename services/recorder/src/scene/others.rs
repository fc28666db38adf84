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

    /// The vehicles as bodies, by their places on a straight road or by their poses on one with a plan.
    pub(super) fn others(&self) -> impl Iterator<Item = Body> {
        let placed = if self.ground.has_plan() { self.posed() } else { self.along() };
        let body = |(index, (rear, length_m, width_m)): (usize, (Place, f64, f64))| Body {
            frame: format!("vehicle_{index}"),
            rear,
            length_m,
            width_m,
            color: self.color(index),
        };
        placed.into_iter().enumerate().map(body).filter(|body| body.rear.is_finite())
    }

    /// The middle of the rear bumper, length and width of each vehicle of a straight road.
    fn along(&self) -> Vec<(Place, f64, f64)> {
        let lengths_m = self.lengths_m.iter().copied().chain(std::iter::repeat(USUAL_LENGTH_M));
        let placed = self.listed().zip(lengths_m).map(|(vehicle, length_m)| {
            let rear = self.ground.place(vehicle.rear_position_m, vehicle.lateral_m);
            (rear, length_m, VEHICLE_WIDTH_M)
        });
        placed.collect()
    }

    /// The same on a road with a plan.
    fn posed(&self) -> Vec<(Place, f64, f64)> {
        let more = self.more_poses.as_deref();
        let poses = self.poses.iter().flat_map(|first| {
            let more = more.filter(|more| more.header.step == first.header.step);
            all_poses(first, more).into_iter().flatten()
        });
        let placed = poses.map(|pose| {
            let middle = Place { at_m: [pose.x_m, pose.y_m], heading_rad: pose.heading_rad };
            let rear = Place { at_m: middle.point(-0.5 * pose.length_m, 0.0), ..middle };
            (rear, pose.length_m, pose.width_m)
        });
        placed.collect()
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
