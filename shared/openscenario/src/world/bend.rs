//! A curved axis under the world's straight coordinates.

use std::sync::Arc;

use crate::world::World;
use crate::world::state::Motion;

/// The axis of a road in the plane, and where it lies in the world's coordinates.
///
/// An entity at the offset l from an axis of the curvature κ covers (1 − κ l) m of way for each metre of the axis.
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
    fn stretch(&self, motion: &Motion) -> f64 {
        let along_m = self.direction * (motion.s_m - self.at_s_m);
        let aside_m = self.direction * (motion.t_m - self.at_t_m);
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
        let motion = &self.state.movers[entity].motion;
        match &self.bend {
            Some(bend) => bend.stretch(motion),
            None if self.ground.is_straight() => 1.0,
            None => self.ground.stretch(motion.s_m, motion.t_m),
        }
    }
}
