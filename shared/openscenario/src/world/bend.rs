//! Curved axes: under the world's straight coordinates, and along which a vehicle drives on a curved road.

use std::sync::Arc;

use road::{Axis, AxisError, Leg, Pose};

use crate::road::{Driven, Ground};
use crate::world::World;
use crate::world::geometry::Motion;

/// Parts of a way for which the curvature of a road is read.
const PARTS: u32 = 32;

impl World {
    /// Lays a curved axis under a straight road: it begins at the place `s`, `t`. From now on entities cover `s` by their
    /// offset from it.
    pub fn bend(&mut self, axis: Axis, (from_m, shift_m): (f64, f64)) {
        let plane = Pose::default();
        let legs = vec![Leg { axis, start: plane, from_m, shift_m }];
        self.grounds = Arc::new(vec![Ground { legs, plane }]);
    }

    /// The way of an entity to a place ahead of it at its present offset, m; negative to a place behind it.
    pub(super) fn way_to(&self, entity: usize, goal_s_m: f64) -> f64 {
        let motion = &self.state.movers[entity].motion;
        let along_m = goal_s_m - motion.s_m;
        let middles = (0..PARTS).map(|part| (f64::from(part) + 0.5) / f64::from(PARTS));
        let stretch = |s_m| self.grounds[motion.row].stretch(s_m, motion.t_m);
        let each = middles.map(|share| stretch(motion.s_m + share * along_m));
        motion.direction() * along_m * each.sum::<f64>() / f64::from(PARTS)
    }
}

/// The axis of the ego's drive in a world.
#[derive(Clone, Debug)]
pub struct Way {
    /// The axis; (0, 0) is the place where the drive begins.
    pub axis: Arc<Axis>,
    /// Its start in the plane of the world.
    pub start: Pose,
}

impl Way {
    /// The way along a line of the ego's row of roads.
    ///
    /// # Errors
    /// When the line makes no axis.
    pub fn of(world: &World, line: &Driven) -> Result<Self, AxisError> {
        let (axis, start) = line.axis()?;
        let row = world.motion(world.script.ego).row;
        Ok(Self { axis: Arc::new(axis), start: start.placed(&world.grounds[row].legs[0].start) })
    }

    /// The motion of an entity in the axis' coordinates. `s` is the place along it, `t` the offset to its left; the
    /// heading counts from its direction. `near_m` is a place of the axis near the entity.
    pub fn along(&self, world: &World, entity: usize, near_m: f64) -> Motion {
        let motion = world.motion(entity);
        let pose = world.pose(&motion).seen_from(&self.start);
        let (p_m, l_m) = match motion.row == world.motion(world.script.ego).row {
            true => self.axis.project(pose.x_m, pose.y_m, near_m),
            false => self.axis.nearest(pose.x_m, pose.y_m),
        };
        let turn = pose.heading_rad - self.axis.pose(p_m).heading_rad;
        let heading_rad = libm::remainder(turn, std::f64::consts::TAU);
        // An action across the road is one across the axis, in its direction.
        let sign = if libm::cos(heading_rad - motion.heading_rad) < 0.0 { -1.0 } else { 1.0 };
        let lateral_mps = sign * motion.lateral_mps;
        Motion { s_m: p_m, t_m: l_m, heading_rad, lateral_mps, ..motion }
    }

    /// The motion on the road of what is in the axis' coordinates. `near_s_m` is a place of the road near it.
    pub fn on_road(&self, world: &World, motion: &Motion, near_s_m: f64) -> Motion {
        let at = self.axis.point(motion.s_m, motion.t_m).placed(&self.start);
        let ground = &world.grounds[motion.row];
        let (s_m, t_m) = ground.project((at.x_m, at.y_m), near_s_m);
        let turn = at.heading_rad + motion.heading_rad - ground.direction_rad(s_m);
        let heading_rad = libm::remainder(turn, std::f64::consts::TAU);
        Motion { s_m, t_m, heading_rad, ..*motion }
    }
}
