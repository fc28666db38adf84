//! Messages of a road with a plan: steering, poses in the plane, the course ahead.
//!
//! The plane has x east and y north where the road begins without another `start`, headings counter-clockwise from x.
//! The axis is the middle of the ego's lane: `position_m` and `lateral_m` of all messages count along and across it.

use super::MAX_TRACKS;
use crate::layout::declare::*;

layout! {
    /// Motion across the road as the ego's sensors measure it.
    ///
    /// At a stand the yaw rate is the sensor's offset and noise.
    pub message LateralMotion "timegap_msgs/msg/LateralMotion" {
        /// Yaw rate, rad/s, positive to the left.
        pub yaw_rate_radps: f64,
        /// Lateral acceleration at the centre of gravity, m/s², positive to the left.
        pub lateral_acceleration_mps2: f64,
        /// Angle of the front wheels, rad, positive to the left.
        pub steering_rad: f64,
    }

    /// Pose of the ego as it really is, and its motion across the road.
    pub message EgoPose "timegap_msgs/msg/EgoPose" {
        /// Middle of the front bumper in the plane, m.
        pub x_m: f64,
        /// Middle of the front bumper in the plane, m.
        pub y_m: f64,
        /// Heading of the body in the plane, rad.
        pub heading_rad: f64,
        /// Distance of the front bumper's middle from the axis, m, positive to the left.
        pub lateral_m: f64,
        /// Yaw rate, rad/s.
        pub yaw_rate_radps: f64,
        /// Angle from the body to its motion at the centre of gravity, rad. It is positive if the body moves to the
        /// left of its heading.
        pub side_slip_rad: f64,
        /// Curvature of the axis at the front bumper, 1/m, positive to the left.
        pub curvature_perm: f64,
        /// Lateral acceleration at the centre of gravity, m/s².
        pub lateral_acceleration_mps2: f64,
    }

    /// The body of a vehicle in the plane.
    #[derive(Default)]
    pub struct VehiclePose "timegap_msgs/msg/VehiclePose" {
        /// Middle of the body, m.
        pub x_m: f64,
        /// Middle of the body, m.
        pub y_m: f64,
        /// Heading of the body, rad.
        pub heading_rad: f64,
        /// Length, m.
        pub length_m: f64,
        /// Width, m.
        pub width_m: f64,
    }

    /// Bodies of all simulated vehicles at the header's step.
    pub message VehiclePoses "timegap_msgs/msg/VehiclePoses" lists poses: VehiclePose {
        /// Valid entries of `poses`.
        pub count: u64,
        /// The bodies in the order of `truth/vehicles`; unused entries are 0.
        pub poses: [VehiclePose; MAX_TRACKS],
    }

    /// The course: the axis ahead as perception estimates it, seen from the ego's body at the scan.
    pub message Course "timegap_msgs/msg/Course" {
        /// Heading of the axis at the front bumper against the body, rad, positive to the left.
        pub heading_rad: f64,
        /// Curvature there, 1/m, positive to the left.
        pub curvature_perm: f64,
        /// Change of the curvature with the way, 1/m².
        pub curvature_rate_perm2: f64,
        /// Curvature in the middle of each cell ahead, the first one from the bumper on, positive to the left.
        pub curvatures_perm: [f64; COURSE_CELLS],
        /// Standard deviation of the course's lateral place 50 m ahead, m.
        pub sigma_50_m: f64,
        /// Standard deviation of the course's lateral place 100 m ahead, m.
        pub sigma_100_m: f64,
        /// Distance ahead to which the course is of use, m; 0: there is none.
        pub valid_m: f64,
    }
}

/// Cells of the course ahead, and their length, m.
pub const COURSE_CELLS: usize = 15;
pub const COURSE_CELL_M: f64 = 10.0;

/// Most cells of a map of curves: 2 km in cells of 25 m.
pub const MAX_CURVE_CELLS: usize = 80;

layout! {
    /// Curvature of the road ahead by the map.
    pub message Curves "timegap_msgs/msg/Curves" lists curvatures: f64 {
        /// Valid entries of `curvatures`: beyond them the map is empty.
        pub count: u64,
        /// Beginning of the first cell on the ego's axis, m: at the ego or behind it.
        pub first_cell_m: f64,
        /// Length of a cell, m.
        pub cell_m: f64,
        /// Mean curvature of each cell, positive to the left; unused entries are 0.
        pub curvatures: [f64; MAX_CURVE_CELLS],
    }
}
