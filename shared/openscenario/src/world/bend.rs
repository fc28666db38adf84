//! A curved axis under the world's straight coordinates.

use std::sync::Arc;

use crate::world::World;
use crate::world::state::Motion;

/// Parts of a way for which the curvature of a road is read.
const PARTS: u32 = 32;

/// The axis of a road in the plane, and where it lies in the world's coordinates.
///
/// Let an entity be at the offset l from an axis of the curvature κ. It covers (1 − κ l) m of way for each metre of the
/// axis.
#[derive(Clone, Debug)]
pub struct Bend {
    /// The axis; it begins where `s` is `at_s_m`.
    pub axis: Arc<road::Axis>,
    /// 1 where it leads along `s`, -1 where it leads against it.
    pub direction: f64,
    /// Its beginning, m.
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
        match &self.bend {
            Some(bend) => bend.stretch(s_m, t_m),
            None if self.ground.is_straight() => 1.0,
            None => self.ground.stretch(s_m, t_m),
        }
    }

    /// The way of an entity to a place ahead of it at its present offset, m; negative to a place behind it.
    pub(super) fn way_to(&self, entity: usize, goal_s_m: f64) -> f64 {
        let motion = &self.state.movers[entity].motion;
        let along_m = goal_s_m - motion.s_m;
        let is_straight = self.bend.is_none() && self.ground.is_straight();
        let parts = if is_straight { 1 } else { PARTS };
        let middles = (0..parts).map(|part| (f64::from(part) + 0.5) / f64::from(parts));
        let each = middles.map(|share| self.stretch_at(motion.s_m + share * along_m, motion.t_m));
        motion.direction() * along_m * each.sum::<f64>() / f64::from(parts)
    }
}
