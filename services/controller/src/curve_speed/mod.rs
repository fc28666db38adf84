//! The speed along the road: a profile for curves and speed limits, and a cap on the acceleration.
//!
//! Passengers accept a lateral acceleration a, which falls with the speed. So the speed on a road of curvature κ(s) is
//! at most v(s). The ego comes down to it with a braking b:
//!
//! ```text
//! v(s)² |κ(s)| = a(v)                       a: 2.3 m/s² up to 17 m/s, 2.0 from 32 m/s on, linear between
//! b = max over s of (v² - v(s)²) / (2 max(s - τ v, ϑ v))        τ = 0.4 s, ϑ = 0.5 s; from 1 to 2.5 m/s²
//! p_i² = min(v(s_i)², p_(i+1)² + 2 b Δs)    the profile, backwards from what is known
//! ```
//!
//! A curve that shows too late for 2.5 m/s² is braked for with up to 3.5 m/s². The profile depends on the curvature
//! alone. One from the present lateral acceleration rises as the ego slows down, and then allows what it forbade before.
//!
//! Laws with a horizon follow the profile; the others have the lowest speed of the next 1.4 s as their set speed. Some
//! come down to a set speed late, or cannot be changed. So the request of every law is at most the acceleration that
//! brings the ego to the profile within a second. This bound moves with a jerk of 2.5 m/s³.
//!
//! [`RoadAhead`] is what is known: the map, the course that perception estimates, or the ego's own yaw rate. Beside them
//! are the speed limits of a route. When a target was lost in a curve, the profile stays at the present speed for
//! [`HELD_S`].
//!
//! Source: ISO 15622 (design values of a, from secondary sources).
//!
//! ```
//! use controller::curve_speed::comfortable_mps;
//!
//! let comfort = scenario::controller::Comfort::default();
//! assert!((comfortable_mps(&comfort, 1.0 / 125.0) - 17.0).abs() < 0.1);
//! assert_eq!(comfortable_mps(&comfort, 0.0), f64::INFINITY);
//! ```

mod road;

pub use road::{Cells, OwnWay, RoadAhead};

use crate::law::{Input, RESPONSE_S, SpeedProfile};
use scenario::controller::{Comfort, CurveSpeed as Keys};

/// Speeds between which the accepted lateral acceleration falls, m/s.
const SLOW_MPS: f64 = 17.0;
const FAST_MPS: f64 = 32.0;
/// Time for which the speed is held after a target was lost in a curve, s.
pub const HELD_S: f64 = 2.0;
/// The road is a curve from this curvature on, 1/m. Chosen: a path that goes straight on leaves half of a lane after
/// 72 m.
const CURVE_PERM: f64 = 1.0 / 1500.0;
/// Time within which a speed above the comfortable one is braked off in the curve itself, s. Chosen: five periods, so
/// that noise of the curvature makes no jerk.
const SETTLE_S: f64 = 0.5;
/// Hardest braking for a curve that shows in time, and for another one, m/s². The first is a comfortable driver's
/// limit; the second is ISO 15622's limit of braking above 20 m/s.
const HARD_MPS2: f64 = 2.5;
const HARDEST_MPS2: f64 = 3.5;
/// Change of the bound on the request, m/s³: the least jerk limit of ISO 15622.
const BOUND_MPS3: f64 = 2.5;
/// Bound that no law reaches, m/s².
const FREE_MPS2: f64 = 10.0;

/// Speed at which a curvature, 1/m, gives the accepted lateral acceleration, m/s.
pub fn comfortable_mps(comfort: &Comfort, curvature_perm: f64) -> f64 {
    let k = curvature_perm.abs();
    let at = |lateral_mps2: f64| (lateral_mps2 / k).sqrt();
    let (slow_mps2, fast_mps2) = (comfort.slow.value(), comfort.fast.value());
    if at(slow_mps2) <= SLOW_MPS {
        return at(slow_mps2);
    }
    if at(fast_mps2) >= FAST_MPS {
        return at(fast_mps2);
    }
    // k v² = slow - slope (v - 17): the positive root.
    let slope = (slow_mps2 - fast_mps2) / (FAST_MPS - SLOW_MPS);
    let constant = slow_mps2 + slope * SLOW_MPS;
    ((slope * slope + 4.0 * k * constant).sqrt() - slope) / (2.0 * k)
}

/// A stretch of the road, m ahead, with the largest speed on it.
#[derive(Clone, Copy, Debug)]
struct Cap {
    from_m: f64,
    to_m: f64,
    speed_mps: f64,
}

/// The profile's keys and memory.
#[derive(Clone, Debug)]
pub struct CurveSpeed {
    comfort: Comfort,
    /// Caps of this cycle.
    caps: Vec<Cap>,
    /// Least braking before a curve, m/s².
    braking_mps2: f64,
    /// Cap after a target was lost, and the time up to which it holds, s.
    held: Option<(Cap, f64)>,
    /// A target was there at the last release, at this distance, m.
    target_m: Option<f64>,
    /// Bound on the acceleration, m/s².
    most_mps2: f64,
}

impl CurveSpeed {
    /// No curve yet.
    pub fn new(keys: &Keys) -> Self {
        Self {
            comfort: keys.comfort_mps2,
            caps: Vec::new(),
            braking_mps2: keys.braking_mps2.value(),
            held: None,
            target_m: None,
            most_mps2: FREE_MPS2,
        }
    }

    /// Gives `input` the profile of the road ahead. `requested_mps2` is what the last command asked for.
    pub fn cap(&mut self, input: &mut Input, road: &RoadAhead<'_>, requested_mps2: f64) {
        let speed_mps = input.ego.speed_mps.max(0.0);
        let free_mps = input.wanted_speed_mps();
        self.see_caps(input, road, free_mps);
        let (braking_mps2, hardest_mps2) = self.braking(speed_mps);
        let mut profile = SpeedProfile::constant(free_mps);
        for cap in &self.caps {
            profile.cap(cap.from_m, cap.to_m, cap.speed_mps, braking_mps2);
        }
        profile.brake(braking_mps2);
        let capped_mps = profile.lowest_mps(0.0, speed_mps);
        input.profile = Some(profile);
        let mut allowed = FREE_MPS2;
        if capped_mps < free_mps {
            input.set_speed_mps = capped_mps;
            allowed = profile.most_mps2(0.0, speed_mps).clamp(-hardest_mps2, FREE_MPS2);
        }
        let step = BOUND_MPS3 * input.period_s;
        let from = self.most_mps2.min(requested_mps2.max(allowed));
        self.most_mps2 = (from - step).max(allowed).min(self.most_mps2 + step);
    }

    /// The law's largest request in a curve, m/s²; infinite elsewhere.
    pub fn most_mps2(&self) -> f64 {
        if self.most_mps2 < FREE_MPS2 { self.most_mps2 } else { f64::INFINITY }
    }

    /// Lists what caps the speed: curves, limits, and a target that was lost.
    fn see_caps(&mut self, input: &Input, road: &RoadAhead<'_>, free_mps: f64) {
        self.caps.clear();
        road.each(|from_m, to_m, curvature_perm| {
            let speed_mps = comfortable_mps(&self.comfort, curvature_perm);
            self.caps.push(Cap { from_m, to_m, speed_mps });
        });
        self.see_target(input);
        // A standstill farther away is no reason to brake yet.
        let farthest_m = free_mps * free_mps / (2.0 * self.braking_mps2);
        self.caps.extend(road.limits().take_while(|cap| cap.from_m < farthest_m));
        let held = self.held.filter(|(_, until_s)| input.time_s < *until_s);
        self.caps.extend(held.map(|(cap, _)| cap));
    }

    /// The braking with which every cap ahead is met, and the hardest that is allowed, m/s².
    fn braking(&self, speed_mps: f64) -> (f64, f64) {
        let (mut needed, mut at_once) = (self.braking_mps2, 0.0_f64);
        let settle_m = SETTLE_S * speed_mps;
        for cap in self.caps.iter().filter(|cap| cap.speed_mps < speed_mps) {
            let surplus = 0.5 * (speed_mps * speed_mps - cap.speed_mps * cap.speed_mps);
            needed = needed.max(surplus / (cap.from_m - RESPONSE_S * speed_mps).max(settle_m));
            at_once = at_once.max(surplus / cap.from_m.max(settle_m));
        }
        let hardest = if at_once > HARD_MPS2 { HARDEST_MPS2 } else { HARD_MPS2 };
        (needed.min(hardest), hardest)
    }

    /// Notes the target; holds the speed where one was lost in one of the curves that are listed.
    fn see_target(&mut self, input: &Input) {
        let target_m = input.target.map(|target| target.gap_m);
        let bend_mps = comfortable_mps(&self.comfort, CURVE_PERM);
        let bends =
            |way_m| self.caps.iter().any(|cap| cap.from_m <= way_m && cap.speed_mps <= bend_mps);
        match (self.target_m, target_m) {
            (Some(lost_m), None) if bends(lost_m) => {
                let speed_mps = input.ego.speed_mps.max(0.0);
                let cap = Cap { from_m: 0.0, to_m: f64::INFINITY, speed_mps };
                self.held = Some((cap, input.time_s + HELD_S));
            }
            (_, Some(_)) => self.held = None,
            (_, None) => {}
        }
        self.target_m = target_m;
    }
}

#[cfg(test)]
mod tests;
