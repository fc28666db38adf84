//! Curved axes: under the world's straight coordinates, and along which a vehicle drives on a curved road.

use std::sync::Arc;

use road::{Axis, Pose};

use crate::world::World;
use crate::world::geometry::Motion;

/// Parts of a way for which the curvature of a road is read.
const PARTS: u32 = 32;

/// The axis of a road in the plane, and where it lies in the world's coordinates.
///
/// Let an entity be at the offset l from an axis of the curvature κ. It covers (1 − κ l) m of way for each metre of the
/// axis.
#[derive(Clone, Debug)]
pub struct Bend {
    /// The axis; it begins where `s` is `at_s_m`.
    pub axis: Arc<Axis>,
    /// 1 where it leads along `s`, -1 where it leads against it.
    pub direction: f64,
    pub at_s_m: f64,
    /// Its offset from the reference line, m.
    pub at_t_m: f64,
}

impl Bend {
    /// Way of an entity by the way on the axis: 1 on a straight road.
    fn stretch(&self, s_m: f64, t_m: f64) -> f64 {
        let along_m = self.direction * (s_m - self.at_s_m);
        let aside_m = self.direction * (t_m - self.at_t_m);
        1.0 - self.axis.curvature_perm(along_m) * aside_m
    }
}

impl World {
    /// Lays a curved axis under the world: from now on entities cover `s` by their offset from it.
    pub fn bend(&mut self, bend: Bend) {
        self.bend = Some(bend);
    }

    /// Way of an entity by the way on the axis, or on the reference line: 1 where it is straight.
    pub(super) fn stretch(&self, entity: usize) -> f64 {
        let Motion { s_m, t_m, .. } = self.state.movers[entity].motion;
        self.stretch_at(s_m, t_m)
    }

    fn stretch_at(&self, s_m: f64, t_m: f64) -> f64 {
        self.bend.as_ref().map_or_else(|| self.ground.stretch(s_m, t_m), |it| it.stretch(s_m, t_m))
    }

    /// The way of an entity to a place ahead of it at its present offset, m; negative to a place behind it.
    pub(super) fn way_to(&self, entity: usize, goal_s_m: f64) -> f64 {
        let motion = &self.state.movers[entity].motion;
        let along_m = goal_s_m - motion.s_m;
        let middles = (0..PARTS).map(|part| (f64::from(part) + 0.5) / f64::from(PARTS));
        let each = middles.map(|share| self.stretch_at(motion.s_m + share * along_m, motion.t_m));
        motion.direction() * along_m * each.sum::<f64>() / f64::from(PARTS)
    }
}

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
    pub fn along(&self, world: &World, entity: usize, near_m: f64) -> Motion {
        let motion = world.motion(entity);
        let pose = world.pose(&motion).seen_from(&self.start);
        let (p_m, l_m) = self.axis.project(pose.x_m, pose.y_m, near_m);
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
        let (s_m, t_m) = world.ground.project((at.x_m, at.y_m), near_s_m);
        let turn = at.heading_rad + motion.heading_rad - world.ground.direction_rad(s_m);
        let heading_rad = libm::remainder(turn, std::f64::consts::TAU);
        Motion { s_m, t_m, heading_rad, ..*motion }
    }
}
