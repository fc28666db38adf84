//! Distances that an entity keeps to another one.

use crate::model::action::{Distance, Gap, Side};
use crate::model::timed::Bounds;
use crate::world::World;
use crate::world::geometry::Extent;
use crate::world::motion::{Part, rate};
use crate::world::shape::seconds;

/// Largest error of a distance that counts as reached, m.
const REACHED_M: f64 = 0.05;
/// Largest error of a speed that counts as reached, m/s.
const REACHED_MPS: f64 = 0.05;
/// Gain on a small error of distance, 1/s.
const APPROACH_PER_S: f64 = 0.5;

impl World {
    /// Drives at a distance to another entity.
    pub(super) fn keep(&mut self, entity: usize, distance: &Distance, from_ns: u64, time_ns: u64) {
        let elapsed_s = seconds(time_ns - from_ns);
        let before = self.state.movers[entity].motion.speed_mps;
        let Some(goal) = self.gap_goal(entity, distance) else {
            self.drive(entity, from_ns, time_ns);
            return;
        };
        let other = self.state.movers[distance.entity].motion.speed_mps;
        let Some(limits) = distance.limits else {
            let own = self.motion(entity);
            let way_m = (goal - own.s_m) * own.direction();
            self.roll(entity, way_m, other, rate(before, other, elapsed_s));
            self.state.movers[entity].motion.s_m = goal;
            return;
        };
        // The error ahead of the entity, m. The closing speed stays within what the limits can brake.
        let own = self.motion(entity);
        let error_m = (goal - own.s_m) * own.direction();
        let Bounds { acceleration_mps2, deceleration_mps2, .. } = limits;
        let brake = if error_m > 0.0 { deceleration_mps2 } else { acceleration_mps2 };
        let closing = libm::sqrt(2.0 * brake * error_m.abs()).min(APPROACH_PER_S * error_m.abs());
        let wanted = (other + closing * error_m.signum()).clamp(0.0, limits.speed_mps);
        let (up, down) = (acceleration_mps2 * elapsed_s, deceleration_mps2 * elapsed_s);
        let speed = before + (wanted - before).max(-down).min(up);
        let way_m = 0.5 * (before + speed) * elapsed_s;
        self.roll(entity, way_m, speed, rate(before, speed, elapsed_s));
        let reached = error_m.abs() < REACHED_M && (speed - other).abs() < REACHED_MPS;
        if reached && !distance.continuous {
            self.state.movers[entity].motion.speed_mps = other;
            self.end(entity, Part::Pace);
        }
    }

    /// The coordinate `s` at which the entity has its distance from another, m.
    pub(super) fn gap_goal(&self, entity: usize, distance: &Distance) -> Option<f64> {
        let own = self.motion(entity);
        let other = self.on_row(&self.motion(distance.entity), own.row)?;
        if !own.present || !other.present {
            return None;
        }
        let direction = other.direction();
        let ahead = match distance.side {
            Side::Ahead => true,
            Side::Behind => false,
            Side::Any => (own.s_m - other.s_m) * direction >= 0.0,
        };
        let gap_m = match distance.gap {
            Gap::Distance(gap_m) => gap_m,
            Gap::Time(gap_s) if ahead => gap_s * other.speed_mps,
            Gap::Time(gap_s) => gap_s * own.speed_mps,
        };
        let forward = ahead == (direction > 0.0);
        if !distance.freespace {
            return Some(if forward { other.s_m + gap_m } else { other.s_m - gap_m });
        }
        let body = &self.script.entities[distance.entity].body;
        let (near, far) = (self.extent(entity), Extent::of(body, &other));
        Some(match forward {
            true => far.to_s_m + gap_m + (own.s_m - near.from_s_m),
            false => far.from_s_m - gap_m - (near.to_s_m - own.s_m),
        })
    }
}
