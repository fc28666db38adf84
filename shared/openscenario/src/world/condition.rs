//! Conditions: tests, edges, delays.

use std::collections::VecDeque;

use road::Strip;
use serde::{Deserialize, Serialize};

use crate::model::condition::{
    Along, Clearance, CollisionWith, Condition, Edge, EntityTest, Measured, Target, Test,
};
use crate::world::World;
use crate::world::geometry::{Extent, Motion, POINT, distance, overlap};
use crate::world::plan::Numbered;
use crate::world::shape::seconds;

/// Memory of a condition between steps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ConditionMemory {
    /// The test's outcome in the previous step.
    last: Option<bool>,
    /// Delayed outcomes, each with the time at which its delay has passed.
    waiting: VecDeque<(u64, bool)>,
    delayed: bool,
    /// The step, the test's outcome and the result of the last evaluation. A step may have several.
    seen: Option<(u64, bool, bool)>,
}

impl ConditionMemory {
    /// The outcome after edge and delay.
    fn take(&mut self, condition: &Condition, outcome: bool, (step, now_ns): (u64, u64)) -> bool {
        match self.seen {
            Some((seen, of, result)) if (seen, of) == (step, outcome) => result,
            _ => {
                let result = self.change(condition, outcome, now_ns);
                self.seen = Some((step, outcome, result));
                result
            }
        }
    }

    fn change(&mut self, condition: &Condition, outcome: bool, now_ns: u64) -> bool {
        let rises = self.last == Some(false) && outcome;
        let falls = self.last == Some(true) && !outcome;
        let changed = self.last != Some(outcome);
        self.last = Some(outcome);
        let edge = match condition.edge {
            Edge::None => outcome,
            Edge::Rising => rises,
            Edge::Falling => falls,
            Edge::RisingOrFalling => rises || falls,
        };
        if condition.delay_ns == 0 {
            return edge;
        }
        let pulse = condition.edge != Edge::None;
        if edge && pulse || changed && !pulse {
            self.waiting.push_back((now_ns + condition.delay_ns, edge));
        }
        self.delayed &= !pulse;
        while let Some(&(due_ns, outcome)) = self.waiting.front()
            && due_ns <= now_ns
        {
            self.delayed = if pulse { true } else { outcome };
            self.waiting.pop_front();
        }
        self.delayed
    }
}

impl World {
    /// Evaluates every condition of a trigger. Returns whether one of its groups holds; without a trigger, none.
    pub(super) fn fires(&mut self, numbered: &Numbered) -> Option<bool> {
        let now = (self.state.step, self.state.time_ns);
        let mut number = numbered.first;
        let mut fires = false;
        for group in &numbered.trigger.as_ref()?.0 {
            let mut holds = !group.is_empty();
            for condition in group {
                let outcome = self.test(&condition.test, number);
                let memory = &mut self.state.conditions[number];
                holds &= memory.take(condition, outcome, now);
                number += 1;
            }
            fires |= holds;
        }
        Some(fires)
    }

    pub(super) fn forget(&mut self, numbered: &Numbered) {
        let count = numbered.trigger.iter().flat_map(|trigger| trigger.0.iter().flatten()).count();
        for memory in &mut self.state.conditions[numbered.first..numbered.first + count] {
            *memory = ConditionMemory::default();
        }
    }

    fn test(&self, test: &Test, number: usize) -> bool {
        match test {
            Test::Time { rule, value } => rule.holds(seconds(self.state.time_ns), *value),
            Test::Value { of, rule, value } => rule.compares(&self.state.values[*of], value),
            Test::Element { state, .. } => {
                let watched = self.plan.watched[number];
                watched.is_some_and(|part| self.state.progress[part].is(*state, self.state.step))
            }
            Test::Entity { entities, all, is } => {
                let mut each = entities.iter().map(|entity| self.entity_test(*entity, is));
                if *all { each.all(|holds| holds) } else { each.any(|holds| holds) }
            }
        }
    }

    fn entity_test(&self, entity: usize, test: &EntityTest) -> bool {
        let mover = &self.state.movers[entity];
        let motion = &mover.motion;
        if !motion.present {
            return false;
        }
        let lasts = |since: Option<u64>, duration_s: f64| {
            since.is_some_and(|since| seconds(self.state.time_ns - since) >= duration_s)
        };
        match test {
            EntityTest::EndOfRoad(duration_s) => lasts(mover.at_end_since, *duration_s),
            EntityTest::Offroad(duration_s) => lasts(mover.off_since, *duration_s),
            EntityTest::StandStill(duration_s) => lasts(mover.stands_since, *duration_s),
            EntityTest::TraveledDistance(metres) => mover.odometer_m >= *metres,
            EntityTest::Acceleration { rule, value } => {
                rule.holds(motion.acceleration_mps2, *value)
            }
            EntityTest::Speed { rule, value } => rule.holds(motion.speed_mps, *value),
            EntityTest::RelativeSpeed { entity, rule, value } => {
                rule.holds(motion.speed_mps - self.motion(*entity).speed_mps, *value)
            }
            EntityTest::Collision(with) => self.collides(entity, *with),
            EntityTest::ReachPosition { position, tolerance_m } => {
                self.resolve(position).is_some_and(|at| self.apart(motion, &at) <= *tolerance_m)
            }
            EntityTest::Distance { to, rule, value } => {
                self.measure(entity, to).is_some_and(|(metres, ..)| rule.holds(metres, *value))
            }
            EntityTest::Headway { to, rule, value } => {
                self.measure(entity, to).is_some_and(|(metres, _, is_behind)| {
                    !is_behind && rule.holds(quotient(metres, motion.speed_mps), *value)
                })
            }
            EntityTest::Clearance(clearance) => self.is_clear(entity, clearance),
            EntityTest::TimeToCollision { to, rule, value } => {
                self.measure(entity, to).is_some_and(|(metres, closing_mps, _)| {
                    rule.holds(quotient(metres, closing_mps), *value)
                })
            }
        }
    }

    fn collides(&self, entity: usize, with: CollisionWith) -> bool {
        let touches = |other: usize| {
            other != entity && self.motion(other).present && self.touch(entity, other)
        };
        match with {
            CollisionWith::Entity(other) => touches(other),
            CollisionWith::Category(category) => (0..self.script.entities.len())
                .any(|other| self.script.entities[other].category == category && touches(other)),
        }
    }

    /// True if none of the others is in a part of the road around an entity.
    fn is_clear(&self, entity: usize, clearance: &Clearance) -> bool {
        let own = self.motion(entity);
        let (road, forward) = (&self.script.roads[own.row], own.direction());
        let Some(lane) = road.lane_at(own.s_m, own.t_m) else { return true };
        clearance.entities.iter().filter(|other| **other != entity).all(|&other| {
            let there = self.on_row(&self.motion(other), own.row).filter(|it| it.present);
            let Some(there) = there else { return true };
            let whole = &self.script.entities[other].body;
            let body = Extent::of(if clearance.freespace { whole } else { &POINT }, &there);
            let ends_m = [body.from_s_m, body.to_s_m].map(|s_m| forward * (s_m - own.s_m));
            let is_far = ends_m.iter().all(|end_m| *end_m > clearance.ahead_m)
                || ends_m.iter().all(|end_m| *end_m < -clearance.behind_m);
            // The own lane, where the other one is.
            let center_m = lane.center_m + road.drift(own.s_m, lane.center_m, there.s_m);
            let index = road.lane_at(there.s_m, center_m).map_or(lane.index, |lane| lane.index);
            let is_free = |strip: Strip| {
                let left = forward as i32 * (strip.index as i32 - index as i32);
                let is_meant = |(from, to): &(i32, i32)| (*from..=*to).contains(&left);
                let half_m = 0.5 * strip.width_m;
                !clearance.lanes.iter().any(is_meant)
                    || !(clearance.opposite || road.direction(&strip) == road.direction(&lane))
                    || body.from_t_m > strip.center_m + half_m
                    || body.to_t_m < strip.center_m - half_m
            };
            is_far || road.lanes.strips(there.s_m).all(is_free)
        })
    }

    /// A motion with coordinates of the plane in the place of `s` and `t`.
    fn in_plane(&self, motion: &Motion) -> Motion {
        let pose = self.pose(motion);
        Motion { s_m: pose.x_m, t_m: pose.y_m, heading_rad: pose.heading_rad, ..*motion }
    }

    /// True if the bodies of two entities overlap.
    pub fn touch(&self, entity: usize, other: usize) -> bool {
        let body = |entity: usize| {
            (&self.script.entities[entity].body, self.in_plane(&self.motion(entity)))
        };
        overlap(body(entity), body(other))
    }

    /// The distance from an entity to a target, m, if the target is on the road. Roads that do not connect have no distance
    /// along or across them. With it come the rate at which it shrinks, m/s, and true if the target is behind the entity:
    /// there is no headway to it.
    fn measure(&self, entity: usize, to: &Measured) -> Option<(f64, f64, bool)> {
        let own = self.motion(entity);
        let (body, far) = match &to.target {
            Target::Entity(other) => {
                (Some(&self.script.entities[*other].body), self.motion(*other))
            }
            Target::Position(position) => (None, self.resolve(position)?),
        };
        if !far.present {
            return None;
        }
        // On a curved road such a distance differs from that along and across the road.
        let (own, far) = match to.entity_axes || to.along == Along::Euclidean {
            true => (self.in_plane(&own), self.in_plane(&far)),
            false => match self.on_row(&far, own.row) {
                Some(far) => (own, far),
                None => (self.on_row(&own, far.row)?, far),
            },
        };
        let ends = ((&self.script.entities[entity].body, &own), (body, &far));
        let measure = |along| distance(ends.0, ends.1, along, to.entity_axes, to.freespace);
        let base = if to.entity_axes { own.heading_rad } else { 0.0 };
        let forward = libm::cos(own.heading_rad - base).signum();
        let (sin, cos) = (libm::sin(base), libm::cos(base));
        let ahead_m = ((far.s_m - own.s_m) * cos + (far.t_m - own.t_m) * sin) * forward;
        // Bodies that overlap along the road are neither ahead nor behind.
        let is_behind = ahead_m < 0.0 && measure(Along::Longitudinal) > 0.0;
        Some((measure(to.along), closing(&own, &far, to), is_behind))
    }
}

/// The closing speed of two points along a direction, m/s.
fn closing(own: &Motion, far: &Motion, to: &Measured) -> f64 {
    let velocity = |motion: &Motion| {
        let (sin, cos) = (libm::sin(motion.heading_rad), libm::cos(motion.heading_rad));
        (motion.speed_mps * cos, motion.speed_mps * sin + motion.lateral_mps)
    };
    let (own_s, own_t) = velocity(own);
    let (far_s, far_t) = velocity(far);
    let (ds, dt) = (far.s_m - own.s_m, far.t_m - own.t_m);
    let base = if to.entity_axes { own.heading_rad } else { 0.0 };
    let angle = match to.along {
        Along::Longitudinal => base,
        Along::Lateral => base + std::f64::consts::FRAC_PI_2,
        Along::Euclidean => libm::atan2(dt, ds),
    };
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let apart = ds * cos + dt * sin;
    ((own_s - far_s) * cos + (own_t - far_t) * sin) * if apart < 0.0 { -1.0 } else { 1.0 }
}

/// A time, infinite if the distance does not shrink.
fn quotient(metres: f64, mps: f64) -> f64 {
    if mps > 0.0 { metres / mps } else { f64::INFINITY }
}
