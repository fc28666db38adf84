//! Entities that arrive at the same time.
//!
//! An entity has the way D before it, the speed u now and, where the file gives one, w at its goal. Its master needs
//! the time T at its present speed. The entity drives so that the integral of its squared acceleration until then is
//! the least, and never backwards:
//!
//! ```text
//! v(t) = u + a t + b t²
//! with w:      a = 6 D/T² - (4 u + 2 w)/T,   b = (w - u - a T)/T²
//! without it:  a = 3 (D - u T)/T²,           b = -a/(2 T)
//! ```
//!
//! If the way is too short for that, 3 D ≤ T (u - √(u w) + w) or 3 D ≤ T u, it brakes to rest,
//! v(t) = u (1 - t/t₁)² with t₁ = 3 D √u/(u √u + w √w), waits, and leaves in time. Each step makes the plan anew. For a
//! master of constant speed every plan is the rest of the one before.

use road::Pose;

use crate::model::position::Position;
use crate::model::timed::{Meeting, Steady};
use crate::world::motion::{Part, rate};
use crate::world::shape::{MAX_SPEED_MPS, SHORTEST_S, seconds};
use crate::world::{Motion, World};

/// Largest change of the speed, m/s². Just before the arrival a plan answers to the last change of the master's speed,
/// and would ask for any acceleration.
const MOST_MPS2: f64 = 20.0;

/// A speed that counts as none, m/s: powers of a smaller one may vanish.
const SMALLEST_MPS: f64 = 1e-9;

/// A plan until the arrival.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Plan {
    /// The speed is `u + a t + b t²`.
    Drive { mps: f64, mps2: f64, mps3: f64 },
    /// The speed is `u (1 - t/t₁)²`, then 0.
    Stop { mps: f64, duration_s: f64 },
}

impl Plan {
    /// The plan for a way, a time, and the speeds at both ends.
    fn of(way_m: f64, time_s: f64, mps: f64, end_mps: Option<f64>) -> Self {
        let mps = if mps < SMALLEST_MPS { 0.0 } else { mps };
        let roots = libm::sqrt(mps * end_mps.unwrap_or(0.0));
        let least_m = time_s * (mps - roots + end_mps.unwrap_or(0.0)) / 3.0;
        if time_s.is_infinite() || way_m <= least_m {
            let leaves = end_mps.map_or(0.0, |end_mps| end_mps * libm::sqrt(end_mps));
            let duration_s = 3.0 * way_m * libm::sqrt(mps) / (mps * libm::sqrt(mps) + leaves);
            return Self::Stop { mps, duration_s: if mps > 0.0 { duration_s } else { 0.0 } };
        }
        match end_mps {
            Some(end_mps) => {
                let mps2 = (6.0 * way_m / time_s - 4.0 * mps - 2.0 * end_mps) / time_s;
                Self::Drive { mps, mps2, mps3: ((end_mps - mps) / time_s - mps2) / time_s }
            }
            None => {
                let mps2 = 3.0 * (way_m / time_s - mps) / time_s;
                Self::Drive { mps, mps2, mps3: -mps2 / (2.0 * time_s) }
            }
        }
    }

    /// The way and the speed after a time.
    fn after(&self, t: f64) -> (f64, f64) {
        match *self {
            Self::Drive { mps, mps2, mps3 } => {
                let way_m = t * (mps + t * (0.5 * mps2 + t * mps3 / 3.0));
                (way_m.max(0.0), (mps + t * (mps2 + t * mps3)).clamp(0.0, MAX_SPEED_MPS))
            }
            Self::Stop { mps, duration_s } => {
                if !(duration_s >= SHORTEST_S) {
                    return (0.0, 0.0);
                }
                let rest = (1.0 - t / duration_s).max(0.0);
                (mps * duration_s / 3.0 * (1.0 - rest * rest * rest), mps * rest * rest)
            }
        }
    }
}

impl World {
    /// True if both goals lie ahead.
    pub(super) fn can_meet(&self, entity: usize, meeting: &Meeting) -> bool {
        let ahead = |it: (f64, f64)| it.0 > 0.0 && it.1 > 0.0;
        entity != meeting.master && self.ways(entity, meeting).is_some_and(ahead)
    }

    /// The ways of the entity and of its master to their goals, m.
    fn ways(&self, entity: usize, meeting: &Meeting) -> Option<(f64, f64)> {
        let way = |entity: usize, goal: &Position| {
            let Motion { present, row, s_m, .. } = self.motion(entity);
            let goal = self.resolve(goal).filter(|_| present)?;
            let Pose { x_m, y_m, .. } = self.pose(&goal);
            // A goal beside the roads of the row is found in the plane.
            let in_plane = || self.grounds[row].project((x_m, y_m), s_m).0;
            let goal_m = self.on_row(&goal, row).map_or_else(in_plane, |goal| goal.s_m);
            Some(self.way_to(entity, goal_m))
        };
        Some((way(entity, &meeting.goal)?, way(meeting.master, &meeting.master_goal)?))
    }

    /// True if the master is at its goal, or both are within their tolerances.
    pub(super) fn has_met(&self, entity: usize, meeting: &Meeting) -> bool {
        self.ways(entity, meeting).is_none_or(|(way_m, master_m)| {
            let is_near = master_m <= meeting.master_tolerance_m && way_m <= meeting.tolerance_m;
            master_m <= 0.0 || is_near
        })
    }

    /// Drives so that the entity arrives with its master. The master has moved already.
    pub(super) fn meet(&mut self, entity: usize, meeting: &Meeting, from_ns: u64, time_ns: u64) {
        let elapsed_s = seconds(time_ns - from_ns);
        let Some((way_m, master_m)) = self.ways(entity, meeting) else {
            self.drive(entity, from_ns, time_ns);
            self.end(entity, Part::Pace);
            return;
        };
        let master_mps = self.motion(meeting.master).speed_mps;
        let time_s = match master_mps > 0.0 {
            true => (elapsed_s + master_m / master_mps).max(0.0),
            false => f64::INFINITY,
        };
        let final_mps = meeting.final_speed.map(|it| self.target_speed(&it.speed));
        // The last part of the way with the final speed is no part of the plan.
        let steady = meeting.final_speed.and_then(|it| it.steady);
        let (steady_m, steady_s) = match (final_mps, steady) {
            (Some(mps), Some(Steady::Distance(metres))) if mps > 0.0 => (metres, metres / mps),
            (Some(mps), Some(Steady::Time(time_s))) => (mps * time_s, time_s),
            _ => (0.0, 0.0),
        };
        let (way_m, time_s) = match way_m - steady_m {
            planned_m if planned_m <= 0.0 || steady_s < time_s => (planned_m, time_s - steady_s),
            _ => (way_m, time_s),
        };
        let before = self.motion(entity).speed_mps;
        let (way_m, speed_mps) = match final_mps {
            Some(mps) if way_m <= 0.0 || time_s < SHORTEST_S => (mps * elapsed_s, mps),
            None if way_m <= 0.0 => (0.0, 0.0),
            None if time_s < SHORTEST_S => (before * elapsed_s, before),
            _ => {
                let plan = Plan::of(way_m, time_s, before, final_mps);
                let (planned_m, mps) = plan.after(elapsed_s.min(time_s));
                let over_s = (elapsed_s - time_s).max(0.0);
                (planned_m + over_s * mps, mps)
            }
        };
        let most = MOST_MPS2 * elapsed_s;
        let (way_m, speed_mps) = match (speed_mps - before).abs() > most {
            false => (way_m, speed_mps),
            true => {
                let speed_mps = (before + most.copysign(speed_mps - before)).max(0.0);
                (0.5 * (before + speed_mps) * elapsed_s, speed_mps)
            }
        };
        self.roll(entity, way_m, speed_mps, rate(before, speed_mps, elapsed_s));
        if self.has_met(entity, meeting) {
            if let Some(final_mps) = final_mps {
                self.state.movers[entity].motion.speed_mps = final_mps;
            }
            self.end(entity, Part::Pace);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extreme_ways_times_and_speeds_stay_finite() {
        let sizes = [1e-320, 1e-9, 1e-3, 1.0, 1e4];
        for way_m in [1e-320, 1e-9, 1.0, 1e9] {
            for time_s in [SHORTEST_S, 1.0, 1e9, f64::INFINITY] {
                for mps in [0.0].into_iter().chain(sizes) {
                    for end_mps in [None, Some(0.0)].into_iter().chain(sizes.map(Some)) {
                        let plan = Plan::of(way_m, time_s, mps, end_mps);
                        for t in [0.0_f64, 1e-9, 0.01, 1.0] {
                            let (covered_m, speed_mps) = plan.after(t.min(time_s));
                            let is_good = covered_m.is_finite() && speed_mps.is_finite();
                            assert!(
                                is_good && covered_m >= 0.0 && speed_mps >= 0.0,
                                "{way_m} m, {time_s} s, {mps} m/s, {end_mps:?}: {plan:?}"
                            );
                        }
                    }
                }
            }
        }
    }
}
