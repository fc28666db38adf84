//! Motion of the entities.

use serde::{Deserialize, Serialize};

use crate::model::action::{Distance, Shape};
use crate::model::timed::Meeting;
use crate::model::{Category, Drive, MAX_ENTITIES};
use crate::world::World;
use crate::world::geometry::Motion;
use crate::world::profile::Profile;
use crate::world::shape::{MAX_SPEED_MPS, SpeedShape, seconds};

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Mover {
    pub motion: Motion,
    /// Motion from the caller, for an entity that it moves.
    pub observed: Option<Motion>,
    /// Distance covered since the start, m.
    pub odometer_m: f64,
    pub pace: Pace,
    /// Without one the lateral position stays.
    pub steer: Option<LateralShape>,
    pub path: Option<Path>,
    /// The storyboard's actions that these [`Part`]s belong to.
    pub owners: [Option<usize>; 3],
    /// Times since which it stands, is at the road's end, is off the road, ns.
    pub stands_since: Option<u64>,
    pub at_end_since: Option<u64>,
    pub off_since: Option<u64>,
}

/// A part of an entity's motion that one action at a time has.
#[derive(Clone, Copy, Debug)]
pub(super) enum Part {
    Pace,
    Steer,
    Path,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) enum Pace {
    /// None: the speed stays.
    #[default]
    Free,
    /// From one speed to another.
    Shape(SpeedShape),
    /// The speed of another entity, without end.
    Match { entity: usize, factor: f64, offset_mps: f64, rate_mps2: f64 },
    /// At a distance to another entity.
    Keep(Distance),
    /// Through a row of speeds.
    Profile(Profile),
    /// To a goal, together with another entity.
    Meet(Box<Meeting>),
}

impl Pace {
    fn is_over(&self, time_ns: u64) -> bool {
        match self {
            Self::Shape(shape) => shape.is_over(time_ns),
            Self::Profile(profile) => profile.is_over(time_ns),
            Self::Free | Self::Match { .. } | Self::Keep(_) | Self::Meet(_) => false,
        }
    }
}

/// A lateral action: from one lateral position to another.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LateralShape {
    pub from_t_m: f64,
    pub to_t_m: f64,
    pub by: Course,
    pub shape: Shape,
    /// Does not end, and follows this entity's lateral position at a distance.
    pub endless: Option<Option<(usize, f64)>>,
}

/// The argument of a lateral shape: time or distance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Course {
    Time { start_ns: u64, duration_s: f64 },
    Way { start_m: f64, length_m: f64 },
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Path {
    /// Corners: time since the start of the run in s, or distance in m; then a point of the plane, m.
    pub corners: Vec<(f64, f64, f64)>,
    /// Odometer at its start, m, if the corners count by distance.
    pub by_way_from_m: Option<f64>,
}

impl Path {
    pub(super) fn is_timed(&self) -> bool {
        self.by_way_from_m.is_none()
    }
}

impl World {
    /// Moves every entity to `time_ns`; actions that end on the way end.
    pub(super) fn advance(&mut self, time_ns: u64) {
        let from_ns = self.state.time_ns;
        let mut before_s_m = [0.0; MAX_ENTITIES + 1];
        for (before_m, mover) in before_s_m.iter_mut().zip(&self.state.movers) {
            *before_m = mover.motion.s_m;
        }
        for entity in 0..self.state.movers.len() {
            if self.is_external(entity) {
                self.take_observed(entity, time_ns);
            } else if !matches!(self.state.movers[entity].pace, Pace::Keep(_) | Pace::Meet(_)) {
                self.drive(entity, from_ns, time_ns);
            }
        }
        // These need the other entity's place after the step.
        for entity in 0..self.state.movers.len() {
            match self.state.movers[entity].pace {
                _ if self.is_external(entity) => {}
                Pace::Keep(distance) => self.keep(entity, &distance, from_ns, time_ns),
                Pace::Meet(ref meeting) => {
                    let meeting = **meeting;
                    self.meet(entity, &meeting, from_ns, time_ns);
                }
                _ => {}
            }
        }
        let count = self.state.movers.len();
        for (entity, &before_m) in before_s_m.iter().enumerate().take(count) {
            if !self.is_uniform {
                self.keep_lane(entity, before_m, seconds(time_ns - from_ns));
            }
            self.steer(entity, from_ns, time_ns);
            self.follow(entity, time_ns);
            self.note_standing(entity, time_ns);
        }
    }

    /// An entity that its caller moves: its actions take their time and move nothing.
    fn take_observed(&mut self, entity: usize, time_ns: u64) {
        let mover = &mut self.state.movers[entity];
        if let Some(observed) = mover.observed.take() {
            mover.odometer_m += (observed.s_m - mover.motion.s_m).abs();
            mover.motion = observed;
        }
        let over = match &self.state.movers[entity].pace {
            Pace::Keep(distance) => !distance.continuous,
            Pace::Meet(meeting) => self.has_met(entity, meeting),
            pace => pace.is_over(time_ns),
        };
        if over {
            self.end(entity, Part::Pace);
        }
    }

    /// Drives by the entity's own pace. Where that depends on another entity, the speed stays.
    pub(super) fn drive(&mut self, entity: usize, from_ns: u64, time_ns: u64) {
        let elapsed_s = seconds(time_ns - from_ns);
        let of = |other: usize| self.state.movers[other].motion.speed_mps;
        let reference = match &self.state.movers[entity].pace {
            Pace::Match { entity: other, factor, offset_mps, .. } => {
                factor * of(*other) + offset_mps
            }
            Pace::Profile(profile) => profile.relative_to.map_or(0.0, of) + profile.speed(time_ns),
            _ => 0.0,
        };
        let reference = reference.clamp(0.0, MAX_SPEED_MPS);
        let mover = &self.state.movers[entity];
        let before = mover.motion.speed_mps;
        let over = mover.pace.is_over(time_ns);
        let (way_m, speed_mps, acceleration) = match &mover.pace {
            Pace::Free | Pace::Keep(_) | Pace::Meet(_) => (before * elapsed_s, before, 0.0),
            Pace::Profile(profile) if profile.relative_to.is_none() => {
                (profile.way(from_ns, time_ns), reference, profile.acceleration(time_ns))
            }
            Pace::Profile(_) => evenly(before, reference, elapsed_s),
            Pace::Shape(shape) => {
                (shape.way(from_ns, time_ns), shape.speed(time_ns), shape.acceleration(time_ns))
            }
            Pace::Match { rate_mps2, .. } => {
                // An infinite rate times zero seconds would be NaN.
                let most = rate_mps2 * elapsed_s;
                let speed = match rate_mps2.is_finite() {
                    true => before + (reference - before).clamp(-most, most),
                    false => reference,
                };
                evenly(before, speed, elapsed_s)
            }
        };
        self.roll(entity, way_m, speed_mps, acceleration);
        if over {
            self.end(entity, Part::Pace);
        }
    }

    /// Covers a distance along the heading. A timed trajectory moves the entity by itself.
    pub(super) fn roll(&mut self, entity: usize, way_m: f64, speed_mps: f64, mps2: f64) {
        let mover = &mut self.state.movers[entity];
        if mover.path.as_ref().is_some_and(Path::is_timed) || !mover.motion.present {
            return;
        }
        let motion = &mut mover.motion;
        if mover.path.is_none() {
            let stretch = self.grounds[motion.row].stretch(motion.s_m, motion.t_m);
            motion.s_m += way_m * libm::cos(motion.heading_rad) / stretch;
            motion.t_m += way_m * libm::sin(motion.heading_rad);
        }
        motion.speed_mps = speed_mps;
        motion.acceleration_mps2 = mps2;
        motion.lateral_mps = 0.0;
        mover.odometer_m += way_m.abs();
    }

    /// Moves a vehicle across with its lane, or with the lane that it changes to.
    fn keep_lane(&mut self, entity: usize, from_s_m: f64, elapsed_s: f64) {
        let moves =
            !self.is_external(entity) && self.script.entities[entity].category == Category::Vehicle;
        let mover = &mut self.state.movers[entity];
        if !moves || !mover.motion.present || mover.path.is_some() {
            return;
        }
        let (road, to_s_m) = (&self.script.roads[mover.motion.row], mover.motion.s_m);
        match &mut mover.steer {
            None => {
                let drift_m = road.drift(from_s_m, mover.motion.t_m, to_s_m);
                mover.motion.t_m += drift_m;
                mover.motion.lateral_mps = rate(0.0, drift_m, elapsed_s);
            }
            Some(shape) => {
                let drift_m = road.drift(from_s_m, shape.to_t_m, to_s_m);
                shape.from_t_m += drift_m;
                shape.to_t_m += drift_m;
            }
        }
    }

    fn steer(&mut self, entity: usize, from_ns: u64, time_ns: u64) {
        let Some(shape) = self.state.movers[entity].steer else { return };
        let odometer_m = self.state.movers[entity].odometer_m;
        let x = match shape.by {
            Course::Time { start_ns, duration_s } => {
                ratio(seconds(time_ns.saturating_sub(start_ns)), duration_s)
            }
            Course::Way { start_m, length_m } => ratio(odometer_m - start_m, length_m),
        };
        let over = x >= 1.0;
        let target = match (over, shape.endless) {
            (true, Some(Some((other, offset_m)))) => {
                let own = self.motion(entity);
                let other = self.on_row(&self.motion(other), own.row);
                other.map_or(own.t_m, |other| other.t_m + offset_m)
            }
            (true, _) => shape.to_t_m,
            (false, _) => shape.from_t_m + (shape.to_t_m - shape.from_t_m) * shape.shape.value(x),
        };
        if !self.is_external(entity) {
            let mover = &mut self.state.movers[entity];
            let elapsed_s = seconds(time_ns - from_ns);
            mover.motion.lateral_mps = rate(mover.motion.t_m, target, elapsed_s);
            mover.motion.t_m = target;
        }
        if over && shape.endless.is_none() {
            self.end(entity, Part::Steer);
        }
    }

    fn follow(&mut self, entity: usize, time_ns: u64) {
        let mover = &self.state.movers[entity];
        let Some(path) = &mover.path else { return };
        let at = match path.by_way_from_m {
            Some(start_m) => mover.odometer_m - start_m,
            None => seconds(time_ns),
        };
        let corners = &path.corners;
        let before =
            corners.partition_point(|corner| corner.0 <= at).clamp(1, corners.len() - 1) - 1;
        let (a, b) = (corners[before], corners[before + 1]);
        let share = ((at - a.0) / (b.0 - a.0)).clamp(0.0, 1.0);
        let (dx, dy) = (b.1 - a.1, b.2 - a.2);
        let (is_timed, has_begun) = (path.is_timed(), at >= corners[0].0);
        let over = at >= corners[corners.len() - 1].0;
        if self.script.entities[entity].drive == Drive::Scripted {
            let (ground, here) = (&self.grounds[mover.motion.row], self.pose(&mover.motion));
            let (x_m, y_m) = (a.1 + share * dx, a.2 + share * dy);
            let (s_m, t_m) = ground.project((x_m, y_m), mover.motion.s_m);
            let turn = libm::atan2(dy, dx) - ground.direction_rad(s_m);
            let mover = &mut self.state.movers[entity];
            let motion = &mut mover.motion;
            if is_timed && has_begun {
                motion.speed_mps = (libm::hypot(dx, dy) / (b.0 - a.0)).min(MAX_SPEED_MPS);
                motion.acceleration_mps2 = 0.0;
                mover.odometer_m += libm::hypot(x_m - here.x_m, y_m - here.y_m);
            } else if is_timed {
                motion.speed_mps = 0.0;
            }
            (motion.s_m, motion.t_m, motion.lateral_mps) = (s_m, t_m, 0.0);
            if dx != 0.0 || dy != 0.0 {
                motion.heading_rad = libm::remainder(turn, std::f64::consts::TAU);
            }
        }
        if over {
            self.end(entity, Part::Path);
        }
    }

    fn note_standing(&mut self, entity: usize, time_ns: u64) {
        let mover = &mut self.state.movers[entity];
        let motion = mover.motion;
        let road = &self.script.roads[motion.row];
        let beyond =
            |length_m: f64| motion.s_m >= length_m || motion.s_m <= 0.0 && motion.direction() < 0.0;
        let at_end = road.length_m.is_some_and(beyond);
        for (since, holds) in [
            (&mut mover.stands_since, motion.speed_mps == 0.0),
            (&mut mover.at_end_since, at_end),
            (&mut mover.off_since, !road.holds(motion.s_m, motion.t_m)),
        ] {
            *since = if motion.present && holds { since.or(Some(time_ns)) } else { None };
        }
    }
}

/// Way, speed and acceleration of an even change of the speed.
fn evenly(before: f64, speed: f64, elapsed_s: f64) -> (f64, f64, f64) {
    (0.5 * (before + speed) * elapsed_s, speed, rate(before, speed, elapsed_s))
}

fn ratio(value: f64, whole: f64) -> f64 {
    if whole > 0.0 { value / whole } else { 1.0 }
}

/// Change per second; 0 where no time passes.
pub(super) fn rate(from: f64, to: f64, elapsed_s: f64) -> f64 {
    if elapsed_s > 0.0 { (to - from) / elapsed_s } else { 0.0 }
}
