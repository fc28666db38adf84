//! `[road.plan]`: the course of the road in the plane.
//!
//! One of three sources. The road's axis is the middle of the ego's lane:
//!
//! ```toml
//! [road.plan]
//! pieces = [{ line_m = 300 }, { spiral_m = 80 }, { arc_m = 400, radius_m = 500, turn = "left" }, { line_m = 100 }]
//! generated = { seed = 1, length_km = 10, min_radius_m = 250, max_radius_m = 2000, spiral_m = [30, 200] }
//! opendrive = { file = "a.xodr", road = "1", lane = -1, s_m = 0 }
//! ```
//!
//! A spiral joins the curvatures of its neighbours. So no curvature is written twice, and none can contradict another.

mod opendrive;
mod piece;

pub use opendrive::OpendriveRoad;
pub use piece::{PlanPiece, Turn};
pub use road::offset_at;

use scenario_derive::tables;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use crate::Problem;
use crate::quantity::{Coordinate, CurveRadius, HeadingDeg, LaneCount, Length, PieceLength};
use crate::quantity::{RoadLength, Seed};
use crate::reading::refuse;
use crate::schema::Schema;

tables! {
    /// The road in the plane. Outside its ends it goes on straight.
    pub struct Plan {
        /// The pieces in order: `{ line_m }`, `{ arc_m, radius_m, turn }`, `{ spiral_m }`.
        pub pieces: Vec<PlanPiece> = sparse,
        /// A road made by a random generator.
        pub generated: Option<GeneratedPlan>,
        /// A lane of an OpenDRIVE file.
        pub opendrive: Option<OpendriveRoad>,
        /// Place and heading of the road's beginning in the plane.
        pub start: Start = sparse,
        /// The lanes.
        pub lanes: Lanes = default,
        #[serde(skip)]
        axis: Laid = default,
    }

    /// A random road of curves.
    #[derive(Copy)]
    pub struct GeneratedPlan {
        /// Seed; each has its own road.
        pub seed: Seed,
        /// Least length, km: the last curve is completed.
        pub length_km: RoadLength,
        /// Smallest radius of its arcs, m.
        pub min_radius_m: CurveRadius = 250.0,
        /// Largest radius of its arcs, m.
        pub max_radius_m: CurveRadius = 2000.0,
        /// Shortest and longest spiral, m.
        pub spiral_m: SpiralLengths = SpiralLengths(PieceLength::of(30.0), PieceLength::of(200.0)),
    }

    /// Beginning of the road in the plane.
    #[derive(Copy)]
    pub struct Start {
        /// East of the plane's origin, m.
        pub x_m: Coordinate = 0.0,
        /// North of the plane's origin, m.
        pub y_m: Coordinate = 0.0,
        /// Heading of the road, degrees counter-clockwise from x.
        pub heading_deg: HeadingDeg = 0.0,
    }

    /// Lanes of the ego's direction.
    pub struct Lanes {
        /// Lanes to the left of the ego's.
        pub left: LaneCount = 1,
        /// Lanes to the right of the ego's.
        pub right: LaneCount = 1,
        /// Width of each, m.
        pub width_m: Length = 3.5,
        /// Lines of all lanes along the road, where lanes begin, end or change their width. Stations are `[p_m, l_m,
        /// ..]`: the place along the ego's lane, and the lines there from right to left, m from its middle. Filled from
        /// an OpenDRIVE file.
        pub along: road::LaneLines = sparse,
    }
}

/// Shortest and longest spiral of a generated road: `[shortest_m, longest_m]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(expecting = "two lengths [shortest_m, longest_m]")]
pub struct SpiralLengths(pub PieceLength, pub PieceLength);

/// The axis of a plan, once it was asked for, or the one of a route in SUMO's net, which `[traffic]` has.
#[derive(Clone, Debug, Default)]
struct Laid(OnceLock<road::Axis>);

/// Plans with the same keys are the same road.
impl PartialEq for Laid {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Lanes {
    /// Offset of the road's left edge from the axis, m, where nothing is said along the road.
    pub fn left_edge_m(&self) -> f64 {
        (f64::from(self.left.value()) + 0.5) * self.width_m.value()
    }

    /// The same of the right edge, m; negative.
    pub fn right_edge_m(&self) -> f64 {
        -(f64::from(self.right.value()) + 0.5) * self.width_m.value()
    }

    /// Offsets of the right and the left edge from the axis at a place, m.
    pub fn edges_m(&self, p_m: f64) -> [f64; 2] {
        self.along.edges_m(p_m).unwrap_or_else(|| [self.right_edge_m(), self.left_edge_m()])
    }

    /// The lines of the lanes between two places as points `[p, l]` along and across the axis, m. A line may have two
    /// points only: between them it is as far from the axis.
    ///
    /// ```
    /// let lanes = scenario::plan::Lanes::default();
    /// let lines = lanes.lines(0.0, 90.0);
    /// assert_eq!(lines[0], [[0.0, -5.25], [90.0, -5.25]]);
    /// assert_eq!(lines.len(), 4);
    /// ```
    pub fn lines(&self, from_m: f64, to_m: f64) -> Vec<Vec<[f64; 2]>> {
        if !self.along.is_empty() {
            return self.along.between(from_m, to_m);
        }
        let count = self.left.value() + self.right.value() + 1;
        let offset = |line| self.right_edge_m() + f64::from(line) * self.width_m.value();
        (0..=count).map(|line| [from_m, to_m].map(|p_m| [p_m, offset(line)]).to_vec()).collect()
    }
}

impl Start {
    /// The pose that places the road in the plane.
    pub fn pose(&self) -> road::Pose {
        road::Pose {
            x_m: self.x_m.value(),
            y_m: self.y_m.value(),
            heading_rad: self.heading_deg.value().to_radians(),
        }
    }
}

impl Plan {
    /// The middle of the ego's lane; begins at (0, 0) along x. [`Start::pose`] places it in the plane.
    ///
    /// # Panics
    /// If the plan has not been checked: the scenario refuses a plan without an axis.
    pub fn axis(&self) -> &road::Axis {
        self.axis.0.get_or_init(|| self.built().expect("the scenario has been checked"))
    }

    /// The pieces as the road's geometry takes them. `None` for a lane of a file, which has no pieces of its own.
    ///
    /// # Errors
    /// The place of what is not a road.
    pub fn geometry(&self) -> Result<Vec<road::Piece>, Problem> {
        if let Some(generated) = &self.generated {
            return generated.geometry();
        }
        piece::geometry(&self.pieces)
    }

    /// Gives the plan an axis that does not come from its own keys.
    pub(crate) fn lay(&mut self, axis: road::Axis) {
        self.axis = Laid(axis.into());
    }

    pub(crate) fn built(&self) -> Result<road::Axis, Problem> {
        if let Some(axis) = self.axis.0.get() {
            return Ok(axis.clone());
        }
        if let Some(opendrive) = &self.opendrive {
            return opendrive.axis();
        }
        road::Axis::new(&self.geometry()?).map_err(|error| {
            let path = match self.pieces.is_empty() {
                true => "road.plan".to_owned(),
                false => format!("road.plan.pieces.{}", error.piece),
            };
            Problem::of_axis(&path, &error)
        })
    }
}

impl GeneratedPlan {
    fn geometry(&self) -> Result<Vec<road::Piece>, Problem> {
        let (least, most) = (self.min_radius_m.value(), self.max_radius_m.value());
        refuse!(if least > most, "road.plan.generated.max_radius_m":
            "the largest radius is below the smallest", "at least {least} m",
            against "road.plan.generated.min_radius_m");
        let (shortest, longest) = (self.spiral_m.0.value(), self.spiral_m.1.value());
        refuse!(if shortest > longest, "road.plan.generated.spiral_m":
            "the longest spiral is shorter than the shortest", "at least {shortest} m");
        let recipe = road::random::Recipe {
            length_m: 1e3 * self.length_km.value(),
            min_radius_m: least,
            max_radius_m: most,
            spiral_m: [shortest, longest],
        };
        Ok(road::random::pieces(&recipe, self.seed.value()))
    }
}

#[cfg(test)]
mod tests;
