//! Targets of actions, resolved on the road.

use road::Pose;

use crate::model::action::LaneTarget;
use crate::model::position::{From, Heading, Offset, Position};
use crate::model::timed::SpeedTarget;
use crate::world::World;
use crate::world::geometry::Motion;
use crate::world::shape::MAX_SPEED_MPS;

impl World {
    pub(super) fn target_speed(&self, target: &SpeedTarget) -> f64 {
        let speed = match *target {
            SpeedTarget::Absolute(mps) => mps,
            SpeedTarget::Relative { entity, factor, offset_mps, .. } => {
                self.motion(entity).speed_mps * factor + offset_mps
            }
        };
        speed.clamp(0.0, MAX_SPEED_MPS)
    }

    /// The lateral position at which a lane change ends, if there is such a lane.
    pub(super) fn lane_goal(&self, actor: usize, target: &LaneTarget) -> Option<f64> {
        let Motion { row, s_m, .. } = self.motion(actor);
        let road = &self.script.roads[row];
        match *target {
            LaneTarget::Lane(id) => road.lane(s_m, id).map(|lane| lane.center_m),
            LaneTarget::Lateral(t_m) => Some(t_m),
            LaneTarget::Beside { entity, lanes_left } => {
                self.lane_beside(&self.on_row(&self.motion(entity), row)?, lanes_left, s_m)
            }
        }
    }

    /// The middle of a lane to the left of another entity's, where that is at `s_m`.
    fn lane_beside(&self, other: &Motion, lanes_left: i32, s_m: f64) -> Option<f64> {
        let road = &self.script.roads[other.row];
        let left = if other.direction() > 0.0 { lanes_left } else { -lanes_left };
        let lane = road.lane_beside(other.s_m, other.t_m, left)?;
        Some(lane.center_m + road.drift(other.s_m, lane.center_m, s_m))
    }

    /// The place and the heading of a position, if the entity that it refers to is on the road.
    pub(super) fn resolve(&self, position: &Position) -> Option<Motion> {
        let (row, s_m, t_m) = match position.from {
            From::Road { row, s_m, t_m } => (row, s_m, t_m),
            From::Entity { entity, offset } => {
                let other = self.motion(entity);
                let (s_m, t_m) = self.beside(&other, offset)?;
                (other.row, s_m, t_m)
            }
        };
        let ground = self.grounds.get(row)?;
        let heading_rad = match position.heading {
            Heading::Road(heading_rad) => heading_rad,
            Heading::Plane(heading_rad) => heading_rad - ground.direction_rad(s_m),
            Heading::Entity(heading_rad) => {
                let turn = |entity: usize| {
                    self.pose(&self.motion(entity)).heading_rad - ground.direction_rad(s_m)
                };
                heading_rad + position.entity().map_or(0.0, turn)
            }
        };
        Some(Motion { present: true, row, s_m, t_m, heading_rad, ..Motion::default() })
    }

    /// A motion on another row of roads, if that has the road under it.
    pub(super) fn on_row(&self, motion: &Motion, row: usize) -> Option<Motion> {
        if motion.row == row {
            return Some(*motion);
        }
        let roads = &self.script.roads;
        let (s_m, t_m, turned) = roads[row].place_of(&roads[motion.row], motion.s_m, motion.t_m)?;
        let (turn, sign) = if turned { (std::f64::consts::PI, -1.0) } else { (0.0, 1.0) };
        let (heading_rad, lateral_mps) = (motion.heading_rad + turn, sign * motion.lateral_mps);
        Some(Motion { row, s_m, t_m, heading_rad, lateral_mps, ..*motion })
    }

    /// `s` and `t` of a place seen from an entity that is on the road.
    fn beside(&self, other: &Motion, offset: Offset) -> Option<(f64, f64)> {
        if !other.present {
            return None;
        }
        let ground = &self.grounds[other.row];
        Some(match offset {
            Offset::Road { ds_m, dt_m } => (other.s_m + ds_m, other.t_m + dt_m),
            Offset::Plane { dx_m, dy_m } => {
                let at = ground.point(other.s_m, other.t_m);
                ground.project((at.x_m + dx_m, at.y_m + dy_m), other.s_m)
            }
            Offset::Own { ahead_m, left_m } => {
                ground.project(self.pose(other).to_world(ahead_m, left_m), other.s_m)
            }
            Offset::Lane { lanes_left, ds_m, offset_m } => {
                let s_m = other.s_m + other.direction() * ds_m;
                (s_m, self.lane_beside(other, lanes_left, s_m)? + offset_m)
            }
        })
    }

    /// The pose of an entity in the plane, its heading included.
    pub(super) fn pose(&self, motion: &Motion) -> Pose {
        let pose = self.grounds[motion.row].point(motion.s_m, motion.t_m);
        Pose { heading_rad: pose.heading_rad + motion.heading_rad, ..pose }
    }
}
