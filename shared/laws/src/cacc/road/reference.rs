//! The reference: a comfortable driver, rolled out over the horizon.
//!
//! The driver heads for the desired speed behind the predicted lead and in front of closed lines. It has the time when
//! a line opens. Let `D` be the time left and `d` the distance. Any speed up to `v*` leaves it able to stop with
//! deceleration `b` and lag `h` when the line opens,
//!
//! ```text
//! d = v* (D + h) + v*² / (2 b)    ->    v* = b (sqrt((D + h)² + 2 d / b) - (D + h))
//! ```
//!
//! so that it glides to a light about to turn green instead of braking for it. It slows down to that speed early:
//! then it is still rolling when the light opens. Here `b` is the comfort deceleration, which is needed only where
//! the light does not open as announced. Behind a lead that waits at the line, that lead's place counts.

use super::lead::Prediction;
use super::signals::Line;
use crate::cacc::config::Config;
use law::following::driver::{Driver, Obstacle};
use law::following::kinematics::{LagStep, Motion};
use law::following::safe_gap::{LeadNow, SafeGap};
use law::{MAX_PLAN, SpeedProfile};

/// Lag `h` that it assumes when it glides, s.
const GLIDE_LAG_S: f64 = 0.5;
/// Band of speed above `v*` over which gliding fades into braking, m/s.
const GLIDE_BAND_MPS: f64 = 1.0;
/// A lead slower than this in front of a closed line waits there, m/s.
const WAITS_MPS: f64 = 0.5;
/// Share of its acceleration that the driver has on average on the way to its speed.
const LATER_SHARE: f64 = 0.7;
/// Slowest speed at which a later line's arrival is estimated, m/s.
const CREEP_MPS: f64 = 1.0;

/// Intended treatment of the nearest line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Gate {
    Open,
    ClosedUntil(f64),
    Closed,
}

/// Constants of a roll-out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scene<'a> {
    pub(super) config: &'a Config,
    pub(super) driver: Driver,
    pub(super) lag: LagStep,
    pub(super) now_s: f64,
    pub(super) desired_mps: f64,
    /// The same along the road.
    pub(super) profile: Option<&'a SpeedProfile>,
    /// Distance on the odometer of the roll-out's origin, m.
    pub(super) origin_m: f64,
    pub(super) safe: &'a SafeGap,
    pub(super) lead: &'a Prediction,
    pub(super) lines: &'a [Line],
}

/// The driver's trajectory from the ego's state; position 0 is the ego's front bumper now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reference {
    pub(super) motion: [Motion; MAX_PLAN + 1],
    /// The driver's request, and zero while it stands: so the programs' linear model stays at the reference. Braking
    /// would move the model backwards, so each stage of the horizon would press on its row `v >= 0`. The plan would be
    /// the same, at forty times the solver's time.
    pub(super) request_mps2: [f64; MAX_PLAN],
    /// Farthest position allowed at each stage by lead and closed lines, never behind the driver,
    /// m.
    pub(super) ceiling_m: [f64; MAX_PLAN + 1],
    /// Speed that the road allows at each stage, m/s.
    pub(super) fastest_mps: [f64; MAX_PLAN + 1],
    pub(super) hardest_mps2: f64,
}

impl Reference {
    pub(super) const EMPTY: Self = Self {
        motion: [Motion { position_m: 0.0, speed_mps: 0.0, acceleration_mps2: 0.0 }; MAX_PLAN + 1],
        request_mps2: [0.0; MAX_PLAN],
        ceiling_m: [f64::INFINITY; MAX_PLAN + 1],
        fastest_mps: [f64::INFINITY; MAX_PLAN + 1],
        hardest_mps2: 0.0,
    };

    pub(super) fn roll_out(&mut self, scene: &Scene<'_>, start: Motion, nearest: Gate) {
        self.hardest_mps2 = 0.0;
        self.motion[0] = start;
        self.ceiling_m[0] = f64::INFINITY;
        self.fastest_mps[0] = scene.desired_mps;
        for k in 0..scene.config.horizon {
            let here = self.motion[k];
            let (request, ceiling) = scene.request(k, here, nearest);
            self.hardest_mps2 = self.hardest_mps2.max(-request);
            let next = scene.lag.advance(here, request);
            let stands = here.speed_mps == 0.0 && next.speed_mps == 0.0;
            self.request_mps2[k] = if stands { 0.0 } else { request };
            self.motion[k + 1] = next;
            self.fastest_mps[k + 1] =
                scene.profile.map_or(scene.desired_mps, |profile| profile.at_mps(next.position_m));
            let behind_lead = scene
                .lead
                .at(k + 1, scene.config.road.min_gap_m)
                .map_or(f64::INFINITY, |lead| lead.gap_m);
            self.ceiling_m[k + 1] = ceiling.min(behind_lead).max(next.position_m + 0.05);
        }
    }

    /// First stage at which the driver is at or beyond `position_m`.
    pub(super) fn reaches(&self, position_m: f64, horizon: usize) -> Option<usize> {
        (0..=horizon).find(|&k| self.motion[k].position_m >= position_m)
    }
}

/// Gap that is kept beyond the safe one, m: the noise of the radar.
pub(super) const SPARE_M: f64 = 1.0;

impl Scene<'_> {
    /// The time headway, or the safe gap if that is larger.
    fn headway_at(&self, v: f64) -> f64 {
        let (headway_s, standstill_m) =
            (self.config.time_headway_s, self.config.standstill_distance_m);
        headway_s.max((SPARE_M + self.safe.steady_gap_m(v) - standstill_m) / v.max(1.0))
    }

    /// The driver's request at stage `k` and the ceiling that closed lines put on the next
    /// position.
    fn request(&self, k: usize, here: Motion, nearest: Gate) -> (f64, f64) {
        let v = here.speed_mps;
        let (desired_mps, free) = self.free(here);
        let mut request = free;
        if let Some(lead) = self.lead.at(k, here.position_m) {
            let lead = lead.obstacle(self.headway_at(v), self.config.standstill_distance_m);
            request = free.min(self.driver.follow_below_mps2(free, v, desired_mps, &lead));
        }
        let time = self.now_s + k as f64 * self.lag.step_s;
        let mut ceiling = f64::INFINITY;
        let mut is_next = true;
        for (j, line) in self.lines.iter().enumerate() {
            let distance = line.at_m - self.origin_m - here.position_m;
            if distance <= 0.0 {
                continue;
            }
            let glides = std::mem::replace(&mut is_next, false);
            let opens = match (j, nearest) {
                (0, Gate::Open) => continue,
                (0, Gate::Closed) => None,
                (0, Gate::ClosedUntil(opens)) if time >= opens => continue,
                (0, Gate::ClosedUntil(opens)) => Some(opens),
                _ => match self.later_line(line, time, distance, v) {
                    Gate::Open => continue,
                    Gate::Closed => None,
                    Gate::ClosedUntil(opens) => Some(opens),
                },
            };
            ceiling = ceiling.min(line.at_m - self.origin_m - self.config.road.stop_margin_m);
            let room = self.queue_room_m(k, here, distance);
            let opens_in_s = opens.map(|at| at - time);
            request =
                request.min(self.before_line(free, v, distance.min(room), opens_in_s, glides));
        }
        (request, ceiling)
    }

    /// The desired speed, m/s, and the driver's request on a free road.
    fn free(&self, here: Motion) -> (f64, f64) {
        let v = here.speed_mps;
        let Some(profile) = self.profile else {
            return (self.desired_mps, self.driver.free_mps2(v, self.desired_mps));
        };
        let desired_mps = profile.lowest_mps(here.position_m, v);
        let braking = profile.most_mps2(here.position_m, v).max(-self.driver.hardest_mps2);
        (desired_mps, self.driver.free_mps2(v, desired_mps).min(braking))
    }

    /// Room before a closed line, m. A lead may wait there.
    fn queue_room_m(&self, k: usize, here: Motion, distance: f64) -> f64 {
        let waits = |lead: &LeadNow| lead.gap_m < distance && lead.speed_mps < WAITS_MPS;
        let Some(lead) = self.lead.at(k, here.position_m).filter(waits) else { return distance };
        lead.gap_m - self.config.standstill_distance_m + self.config.road.stop_margin_m
    }

    /// Request before a closed line that opens after a time in s. The speed is one at which the driver requests `free`
    /// on an open road. Only the next line is glided to: slowing down for a later one could cost a green before it.
    fn before_line(
        &self,
        free: f64,
        v: f64,
        distance: f64,
        opens_in_s: Option<f64>,
        glides: bool,
    ) -> f64 {
        let line = Obstacle::line(distance, self.config.road.stop_margin_m);
        let stop = self.driver.follow_below_mps2(free, v, self.desired_mps, &line);
        let Some(left) = opens_in_s else { return stop };
        let b = self.config.road.comfort_deceleration_mps2;
        let wait = left + GLIDE_LAG_S;
        let room = (distance - self.config.road.stop_margin_m).max(0.0);
        let glide = b * ((wait * wait + 2.0 * room / b).sqrt() - wait);
        let gliding = self.driver.free_mps2(v, glide.min(self.desired_mps));
        // Above the glide speed the ego brakes for a line that stays closed, at least as hard as for the glide.
        let share = (1.0 + (glide - v) / GLIDE_BAND_MPS).clamp(0.0, 1.0);
        let request = stop + share * (gliding - stop).max(0.0);
        if glides { request.min(gliding) } else { request }
    }

    /// A line behind the nearest is open when it is green now and will be on arrival. On the way the driver gains
    /// speed.
    fn later_line(&self, line: &Line, time: f64, distance: f64, v: f64) -> Gate {
        if !line.known {
            return Gate::Closed;
        }
        let (a, top) = (LATER_SHARE * self.driver.acceleration_mps2, self.desired_mps.max(v));
        let gaining_s = (top - v) / a;
        let gained_m = 0.5 * (v + top) * gaining_s;
        let way_s = if gained_m < distance {
            gaining_s + (distance - gained_m) / top.max(CREEP_MPS)
        } else {
            ((v * v + 2.0 * a * distance).sqrt() - v) / a
        };
        let arrival = time + way_s;
        for green in line.greens() {
            if arrival > green.likely_s {
                continue;
            }
            return if green.from_s <= time { Gate::Open } else { Gate::ClosedUntil(green.from_s) };
        }
        Gate::Closed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use law::following::kinematics::Lag;

    #[test]
    fn a_driver_that_stands_leaves_the_linear_model_where_it_stands() {
        let lag = Lag { tau_s: 0.5 };
        let safe = SafeGap::new(lag, 0.1, (-4.9, -3.0), 2.0, 7.0);
        let mut lead = Prediction::ABSENT;
        let standing = LeadNow { gap_m: 4.0, speed_mps: 0.0, acceleration_mps2: 0.0 };
        lead.update(Some(&standing), 0.1, 0.9);
        let scene = Scene {
            config: &Config::default(),
            driver: Driver { acceleration_mps2: 2.0, deceleration_mps2: 1.7, hardest_mps2: 4.9 },
            lag: lag.discretise(0.1),
            now_s: 0.0,
            desired_mps: 20.0,
            profile: None,
            origin_m: 0.0,
            safe: &safe,
            lead: &lead,
            lines: &[],
        };
        let mut reference = Reference::EMPTY;
        reference.roll_out(&scene, Motion::default(), Gate::Open);
        assert!(reference.hardest_mps2 > 0.5, "closer than it wants to stand, it brakes");
        assert!(reference.motion.iter().all(|motion| motion.speed_mps == 0.0));
        assert!(reference.request_mps2.iter().all(|request| *request == 0.0));
    }
}
