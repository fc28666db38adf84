//! Targets of actions, resolved on the road.

use crate::model::action::{LaneTarget, SpeedTarget};
use crate::model::position::{From, Heading, Position};
use crate::world::World;
use crate::world::motion::MAX_SPEED_MPS;

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
    pub(super) fn lane_goal(&self, _actor: usize, target: &LaneTarget) -> Option<f64> {
        let road = &self.script.road;
        match *target {
            LaneTarget::Lane(id) => road.lane(id).map(|lane| lane.center_m),
            LaneTarget::Lateral(t_m) => Some(t_m),
            LaneTarget::Beside { entity, lanes_left } => {
                let other = self.motion(entity);
                let left = if other.direction() > 0.0 { lanes_left } else { -lanes_left };
                road.lane_beside(other.t_m, left).map(|lane| lane.center_m)
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
            From::Entity { entity, ahead_m, left_m } => {
                let other = other(entity)?;
                let (sin, cos) = (libm::sin(other.heading_rad), libm::cos(other.heading_rad));
                (other.s_m + ahead_m * cos - left_m * sin, other.t_m + ahead_m * sin + left_m * cos)
            }
            From::EntityLane { entity, lanes_left, ds_m, offset_m } => {
                let other = other(entity)?;
                let direction = other.direction();
                let left = if direction > 0.0 { lanes_left } else { -lanes_left };
                let lane = self.script.road.lane_beside(other.t_m, left)?;
                (other.s_m + direction * ds_m, lane.center_m + offset_m)
            }
        };
        let heading_rad = match position.heading {
            Heading::Road(heading_rad) => heading_rad,
            Heading::Entity(heading_rad) => {
                heading_rad + reference(position).map_or(0.0, |e| self.motion(e).heading_rad)
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
        | From::Entity { entity, .. }
        | From::EntityLane { entity, .. } => Some(entity),
    }
}
