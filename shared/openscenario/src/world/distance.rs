//! Distances that an entity keeps to another one.

use crate::model::action::{Aside, Distance, Gap, LateralSide, Side};
use crate::model::timed::Bounds;
use crate::world::World;
use crate::world::geometry::Extent;
use crate::world::motion::{Part, Steer, rate};
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
        let stretch = self.stretch(entity);
        let Some(goal) = self.gap_goal(entity, distance) else {
            self.drive_free(entity, elapsed_s);
            return;
        };
        let other = self.state.movers[distance.entity].motion.speed_mps;
        let Some(limits) = distance.limits else {
            let mover = &mut self.state.movers[entity];
            let here = mover.motion.s_m;
            let way_m = (goal - here) * mover.motion.direction();
            mover.roll(way_m, stretch, other, rate(before, other, elapsed_s));
            mover.motion.s_m = goal;
            return;
        };
        // The error ahead of the entity, m. The closing speed stays within what the limits can brake.
        let mover = &mut self.state.movers[entity];
        let error_m = (goal - mover.motion.s_m) * mover.motion.direction();
        let range = (0.0, limits.speed_mps);
        let speed = limits.chase(error_m, (before, other), range, elapsed_s);
        let way_m = 0.5 * (before + speed) * elapsed_s;
        mover.roll(way_m, stretch, speed, rate(before, speed, elapsed_s));
        let reached = error_m.abs() < REACHED_M && (speed - other).abs() < REACHED_MPS;
        if reached && !distance.continuous {
            mover.motion.speed_mps = other;
            self.end(entity, Part::Pace);
        }
    }

    /// The action with the side on which the entity is now, and with the distance of now where none is given.
    pub(super) fn with_side(&self, entity: usize, aside: &Aside) -> Aside {
        let (own, other) = (self.motion(entity), self.motion(aside.entity));
        let left_m = (own.t_m - other.t_m) * other.direction();
        let side = match aside.side {
            LateralSide::Any if left_m < 0.0 => LateralSide::Right,
            LateralSide::Any => LateralSide::Left,
            side => side,
        };
        let bodies_m = if aside.freespace { self.half_widths_m(entity, aside.entity) } else { 0.0 };
        let distance_m = aside.distance_m.unwrap_or((left_m.abs() - bodies_m).max(0.0));
        Aside { side, distance_m: Some(distance_m), ..*aside }
    }

    /// The distance of two origins at which the bodies touch side by side, m.
    fn half_widths_m(&self, entity: usize, other: usize) -> f64 {
        let (near, far) = (self.extent(entity), self.extent(other));
        let half = |extent: &Extent| 0.5 * (extent.to_t_m - extent.from_t_m);
        half(&near) + half(&far)
    }

    /// Moves beside another entity.
    pub(super) fn keep_aside(&mut self, entity: usize, from_ns: u64, time_ns: u64) {
        let Some(Steer::Aside { of, mps, goal_m: last_m }) = self.state.movers[entity].steer else {
            return;
        };
        let (own, other) = (self.motion(entity), self.motion(of.entity));
        if self.is_external(entity) || !own.present || !other.present {
            if !of.continuous {
                self.end(entity, Part::Steer);
            }
            return;
        }
        let elapsed_s = seconds(time_ns - from_ns);
        let bodies_m = if of.freespace { self.half_widths_m(entity, of.entity) } else { 0.0 };
        let apart_m = (of.distance_m.unwrap_or(0.0) + bodies_m) * other.direction();
        let goal_m = match of.side {
            LateralSide::Right => other.t_m - apart_m,
            LateralSide::Left | LateralSide::Any => other.t_m + apart_m,
        };
        let goal_mps = rate(last_m.unwrap_or(goal_m), goal_m, elapsed_s);
        let (mps, t_m) = match of.limits {
            None => (goal_mps, goal_m),
            Some(limits) => {
                let (error_m, range) = (goal_m - own.t_m, (-limits.speed_mps, limits.speed_mps));
                let next = limits.chase(error_m, (mps, goal_mps), range, elapsed_s);
                (next, own.t_m + 0.5 * (mps + next) * elapsed_s)
            }
        };
        let mover = &mut self.state.movers[entity];
        (mover.motion.lateral_mps, mover.motion.t_m) = (mps, t_m);
        mover.steer = Some(Steer::Aside { of, mps, goal_m: Some(goal_m) });
        let is_there = (goal_m - t_m).abs() < REACHED_M && (mps - goal_mps).abs() < REACHED_MPS;
        if !of.continuous && is_there {
            mover.motion.lateral_mps = 0.0;
            self.end(entity, Part::Steer);
        }
    }

    /// The coordinate `s` at which the entity has its distance from another, m.
    pub(super) fn gap_goal(&self, entity: usize, distance: &Distance) -> Option<f64> {
        let (own, other) = (self.motion(entity), self.motion(distance.entity));
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
        let (near, far) = (self.extent(entity), self.extent(distance.entity));
        Some(match forward {
            true => far.to_s_m + gap_m + (own.s_m - near.from_s_m),
            false => far.from_s_m - gap_m - (near.to_s_m - own.s_m),
        })
    }
}

impl Bounds {
    /// The speed after a time towards a place `error_m` ahead that moves itself. The closing speed stays within what the
    /// bounds can brake.
    fn chase(
        &self,
        error_m: f64,
        (before, other): (f64, f64),
        (least, most): (f64, f64),
        elapsed_s: f64,
    ) -> f64 {
        let Self { acceleration_mps2, deceleration_mps2, .. } = *self;
        let brake = if error_m > 0.0 { deceleration_mps2 } else { acceleration_mps2 };
        let closing = libm::sqrt(2.0 * brake * error_m.abs()).min(APPROACH_PER_S * error_m.abs());
        let wanted = (other + closing * error_m.signum()).clamp(least, most);
        let (up, down) = (acceleration_mps2 * elapsed_s, deceleration_mps2 * elapsed_s);
        before + (wanted - before).max(-down).min(up)
    }
}
