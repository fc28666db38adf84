//! Targets of actions, resolved on the road.

use crate::model::action::{LaneTarget, SpeedTarget};
use crate::model::position::{From, Heading, Position};
use crate::world::World;
use crate::world::shape::MAX_SPEED_MPS;
use crate::world::state::Motion;

impl World {
    /// The present speed of a target, m/s.
    pub(super) fn target_speed(&self, target: &SpeedTarget) -> f64 {
        let speed = match *target {
            SpeedTarget::Absolute(mps) => mps,
            SpeedTarget::Delta { entity, mps, .. } => self.motion(entity).speed_mps + mps,
            SpeedTarget::Factor { entity, factor, .. } => self.motion(entity).speed_mps * factor,
        };
        speed.clamp(0.0, MAX_SPEED_MPS)
    }

    /// The lateral position at which a lane change ends, if there is such a lane.
    pub(super) fn lane_goal(&self, actor: usize, target: &LaneTarget) -> Option<f64> {
        let (road, s_m) = (&self.script.road, self.motion(actor).s_m);
        match *target {
            LaneTarget::Lane(id) => road.lane(s_m, id).map(|lane| lane.center_m),
            LaneTarget::Lateral(t_m) => Some(t_m),
            LaneTarget::Beside { entity, lanes_left } => {
                let other = self.motion(entity);
                let left = if other.direction() > 0.0 { lanes_left } else { -lanes_left };
                let lane = road.lane_beside(other.s_m, other.t_m, left)?;
                Some(lane.center_m + road.drift(other.s_m, lane.center_m, s_m))
            }
        }
    }

    /// `s`, `t` and heading of a position, if the entity that it refers to is on the road.
    pub(super) fn resolve(&self, position: &Position) -> Option<(f64, f64, f64)> {
        let other = |entity: usize| Some(self.motion(entity)).filter(|motion| motion.present);
        let (s_m, t_m) = match position.from {
            From::Road { s_m, t_m } => (s_m, t_m),
            From::EntityOnRoad { entity, ds_m, dt_m } => {
                let other = other(entity)?;
                (other.s_m + ds_m, other.t_m + dt_m)
            }
            From::EntityInPlane { entity, dx_m, dy_m } => {
                let other = other(entity)?;
                let (x_m, y_m) = self.ground.point(other.s_m, other.t_m);
                self.ground.project((x_m + dx_m, y_m + dy_m), other.s_m)
            }
            From::Entity { entity, ahead_m, left_m } if !self.ground.is_straight() => {
                let other = other(entity)?;
                let point = self.ground.pose(&other).to_world(ahead_m, left_m);
                self.ground.project(point, other.s_m)
            }
            From::Entity { entity, ahead_m, left_m } => {
                let other = other(entity)?;
                let (sin, cos) = (libm::sin(other.heading_rad), libm::cos(other.heading_rad));
                (other.s_m + ahead_m * cos - left_m * sin, other.t_m + ahead_m * sin + left_m * cos)
            }
            From::EntityLane { entity, lanes_left, ds_m, offset_m } => {
                let other = other(entity)?;
                let direction = other.direction();
                let left = if direction > 0.0 { lanes_left } else { -lanes_left };
                let road = &self.script.road;
                let lane = road.lane_beside(other.s_m, other.t_m, left)?;
                let s_m = other.s_m + direction * ds_m;
                let center_m = lane.center_m + road.drift(other.s_m, lane.center_m, s_m);
                (s_m, center_m + offset_m)
            }
        };
        let heading_rad = match position.heading {
            Heading::Road(heading_rad) => heading_rad,
            Heading::Plane(heading_rad) => heading_rad - self.ground.direction_rad(s_m),
            Heading::Entity(heading_rad) => {
                let other = reference(position).map(|entity| self.motion(entity));
                let turn = |other: Motion| match self.ground.is_straight() {
                    true => other.heading_rad,
                    false => self.ground.pose(&other).heading_rad - self.ground.direction_rad(s_m),
                };
                heading_rad + other.map_or(0.0, turn)
            }
        };
        Some((s_m, t_m, heading_rad))
    }
}

/// The entity that a position refers to.
pub(super) fn reference(position: &Position) -> Option<usize> {
    match position.from {
        From::Road { .. } => None,
        From::EntityOnRoad { entity, .. }
        | From::EntityInPlane { entity, .. }
        | From::Entity { entity, .. }
        | From::EntityLane { entity, .. } => Some(entity),
    }
}
