//! Between the road's coordinates and those of an axis that a vehicle drives along.

use std::sync::Arc;

use road::{Axis, Pose};

use crate::world::World;
use crate::world::state::Motion;

/// The axis of a drive on the curved road of a world.
#[derive(Clone, Debug)]
pub struct Way {
    /// The axis; (0, 0) is the place where the drive begins.
    pub axis: Arc<Axis>,
    /// Its start, as seen from the start of the road's reference line.
    pub start: Pose,
}

impl Way {
    /// The motion of an entity in the axis' coordinates. `s` is the place along it, `t` the offset to its left; the
    /// heading counts from its direction. `near_m` is a place of the axis near the entity.
    #[must_use]
    pub fn along(&self, world: &World, entity: usize, near_m: f64) -> Motion {
        let motion = world.motion(entity);
        let pose = world.ground.pose(&motion).seen_from(&self.start);
        let (p_m, l_m) = self.axis.project(pose.x_m, pose.y_m, near_m);
        let turn = pose.heading_rad - self.axis.pose(p_m).heading_rad;
        let heading_rad = libm::remainder(turn, std::f64::consts::TAU);
        // An action across the road is one across the axis, in its direction.
        let sign = if libm::cos(heading_rad - motion.heading_rad) < 0.0 { -1.0 } else { 1.0 };
        let lateral_mps = sign * motion.lateral_mps;
        Motion { s_m: p_m, t_m: l_m, heading_rad, lateral_mps, ..motion }
    }

    /// The motion on the road of what is in the axis' coordinates. `near_s_m` is a place of the road near it.
    #[must_use]
    pub fn on_road(&self, world: &World, motion: &Motion, near_s_m: f64) -> Motion {
        let at = self.axis.point(motion.s_m, motion.t_m).placed(&self.start);
        let (s_m, t_m) = world.ground.project((at.x_m, at.y_m), near_s_m);
        let turn = at.heading_rad + motion.heading_rad - world.ground.direction_rad(s_m);
        let heading_rad = libm::remainder(turn, std::f64::consts::TAU);
        Motion { s_m, t_m, heading_rad, ..*motion }
    }
}
