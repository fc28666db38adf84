//! The road in the plane: between `s`, `t` and coordinates.
//!
//! The plane here has its origin at the start of the reference line, and its x axis along it there.

use road::{Axis, AxisError, Pose};

use super::Road;

/// The axis of a road's reference line, with its place.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    axis: Axis,
    /// The start of the reference line in the coordinates of the file.
    start: Pose,
}

impl Ground {
    pub fn of(road: &Road) -> Result<Self, AxisError> {
        Ok(Self { axis: road.axis()?, start: road.start() })
    }

    /// One straight line: `s` and `t` are coordinates of the plane.
    pub fn is_straight(&self) -> bool {
        self.axis.is_straight()
    }

    /// `s` and `t` of a point in the coordinates of the file, m.
    pub fn locate(&self, x_m: f64, y_m: f64) -> (f64, f64) {
        let (x_m, y_m) = self.start.to_local(x_m, y_m);
        self.axis.nearest(x_m, y_m)
    }

    /// A direction of the file's coordinates from the direction of the reference line at its start, rad.
    pub fn heading_rad(&self, heading_rad: f64) -> f64 {
        heading_rad - self.start.heading_rad
    }

    /// A vector of the file's coordinates in this plane, m.
    pub fn turned(&self, dx_m: f64, dy_m: f64) -> (f64, f64) {
        Pose { x_m: 0.0, y_m: 0.0, ..self.start }.to_local(dx_m, dy_m)
    }

    /// The direction of the reference line, rad.
    pub fn direction_rad(&self, s_m: f64) -> f64 {
        self.axis.pose(s_m).heading_rad
    }

    /// A point of the road with the direction of the reference line.
    pub fn point(&self, s_m: f64, t_m: f64) -> Pose {
        self.axis.point(s_m, t_m)
    }

    /// `s` and `t` of a point of the plane near a place, m.
    pub fn project(&self, (x_m, y_m): (f64, f64), near_s_m: f64) -> (f64, f64) {
        self.axis.project(x_m, y_m, near_s_m)
    }

    /// Metres of way for one metre of `s` at a distance from the reference line; not less than a tenth.
    pub fn stretch(&self, s_m: f64, t_m: f64) -> f64 {
        (1.0 - self.axis.curvature_perm(s_m) * t_m).max(0.1)
    }
}
