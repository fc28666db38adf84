//! The speed in curves: a cap on the set speed, and on the acceleration.
//!
//! Passengers accept a lateral acceleration a, which falls with the speed. So the speed on a road of curvature κ(s) is
//! at most v(s). The ego comes down to it with a braking b:
//!
//! ```text
//! v(s)² |κ(s)| = a(v)                       a: 2.3 m/s² up to 17 m/s, 2.0 from 32 m/s on, linear between
//! v_i² = min(v(s_i)², v_(i+1)² + 2 b Δs)    backwards from what is known; v_0 is the cap
//! ```
//!
//! The cap depends on the curvature alone. A cap from the present lateral acceleration falls as the ego slows down, and
//! then allows what it forbade before.
//!
//! | change | rate |
//! | --- | --- |
//! | falls | at most b, from the ego's speed on |
//! | rises | to the set speed within [`FREED_S`] |
//! | a target was lost in a curve | the present speed for [`HELD_S`] |
//!
//! [`RoadAhead`] is what is known: the map, the course that perception estimates, or the ego's own yaw rate. In a curve
//! the acceleration a_x is at most √(a_tot² - a_y²).
//!
//! The laws get a lower set speed, and come down to it late. So their request is bounded as well: from the place on
//! where a curve needs the braking b, the request is at most what this curve needs:
//!
//! ```text
//! a_x ≤ (v(s)² - v²) / (2 max(s - τ v, ϑ v))          τ = 0.4 s, ϑ = 0.5 s; at least -2.5 m/s²
//! ```
//!
//! A curve that shows too late for 2.5 m/s² is braked for with up to 3.5 m/s².
//!
//! Sources: ISO 15622 (design values of a, from secondary sources). a_tot is openpilot's: 1.7 m/s² at 20 m/s, 3.2 at 40
//! m/s.
//!
//! ```
//! use controller::curve_speed::comfortable_mps;
//!
//! let comfort = scenario::controller::Comfort::default();
//! assert!((comfortable_mps(&comfort, 1.0 / 125.0) - 17.0).abs() < 0.1);
//! assert_eq!(comfortable_mps(&comfort, 0.0), f64::INFINITY);
//! ```

mod own_way;
mod road;

pub use own_way::OwnWay;
pub use road::{Cells, Clothoid, RoadAhead};

use crate::law::Input;
use scenario::controller::{Comfort, CurveSpeed as Keys};

/// Speeds between which the accepted lateral acceleration falls, m/s.
const SLOW_MPS: f64 = 17.0;
const FAST_MPS: f64 = 32.0;
/// Time after which a curve that ended holds nothing back, s.
pub const FREED_S: f64 = 1.0;
/// Time for which the speed is held after a target was lost in a curve, s.
pub const HELD_S: f64 = 2.0;
/// The road is a curve from this curvature on, 1/m. Chosen: a path that goes straight on leaves half of a lane after
/// 72 m.
const CURVE_PERM: f64 = 1.0 / 1500.0;
/// Time by which the cap precedes the curve, s. Chosen: the laws follow a falling set speed 1 to 2 s late.
const LEAD_S: f64 = 2.0;
/// Time until a request acts, s: a control period, the links and half of the brake's rise.
const RESPONSE_S: f64 = 0.4;
/// Time within which a speed above the comfortable one is braked off in the curve itself, s. Chosen: five periods, so
/// that noise of the curvature makes no jerk.
const SETTLE_S: f64 = 0.5;
/// Hardest braking for a curve that shows in time, and for another one, m/s². The first is a comfortable driver's
/// limit; the second is ISO 15622's limit of braking above 20 m/s.
const HARD_MPS2: f64 = 2.5;
const HARDEST_MPS2: f64 = 3.5;
/// Total acceleration, m/s², at these speeds, m/s.
const TOTAL_MPS2: (f64, f64) = (1.7, 3.2);
const TOTAL_MPS: (f64, f64) = (20.0, 40.0);
/// Lateral acceleration from which the total one is bounded, m/s². Chosen: less is not a curve for a passenger.
const LATERAL_MPS2: f64 = 1.0;
/// Change of that bound, m/s³: the least jerk limit of ISO 15622.
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

/// Speed held after a target was lost.
#[derive(Clone, Copy, Debug)]
struct Held {
    until_s: f64,
    speed_mps: f64,
}

/// The caps and their memory.
#[derive(Clone, Debug)]
pub struct CurveSpeed {
    comfort: Comfort,
    /// Braking before a curve, m/s².
    braking_mps2: f64,
    /// The cap; `None` while it is the set speed.
    cap_mps: Option<f64>,
    held: Option<Held>,
    /// A target was there at the last release, at this distance, m.
    target_m: Option<f64>,
    /// Bound on the acceleration, m/s².
    most_mps2: f64,
    /// The ego is braked down to the speed of a curve.
    comes_down: bool,
}

impl CurveSpeed {
    /// No curve yet.
    pub fn new(keys: &Keys) -> Self {
        Self {
            comfort: keys.comfort_mps2,
            braking_mps2: keys.braking_mps2.value(),
            cap_mps: None,
            held: None,
            target_m: None,
            most_mps2: FREE_MPS2,
            comes_down: false,
        }
    }

    /// Caps the set speed of `input` by the road ahead. `requested_mps2` is what the last command asked for.
    pub fn cap(&mut self, input: &mut Input, road: &RoadAhead<'_>, requested_mps2: f64) {
        let (time_s, period_s, free_mps) = (input.time_s, input.period_s, input.set_speed_mps);
        let speed_mps = input.ego.speed_mps.max(0.0);
        self.see_target(input, road, speed_mps);
        let held_mps = self.held.filter(|held| time_s < held.until_s);
        let (comfortable_mps, needed_mps2) = self.demand(road, speed_mps);
        let wanted_mps = comfortable_mps.min(held_mps.map_or(free_mps, |h| h.speed_mps));
        let next_mps = match self.cap_mps.map(|cap_mps| cap_mps.min(free_mps)) {
            Some(cap_mps) if cap_mps <= wanted_mps => {
                (cap_mps + free_mps * period_s / FREED_S).min(wanted_mps)
            }
            // A cap above the ego's speed changes nothing: it begins to fall there.
            before => {
                let from_mps = before.unwrap_or(free_mps.min(speed_mps.max(wanted_mps)));
                (from_mps - self.braking_mps2 * period_s).max(wanted_mps)
            }
        };
        self.cap_mps = (next_mps < free_mps).then_some(next_mps);
        input.set_speed_mps = free_mps.min(next_mps);
        self.bound(speed_mps, road.here_perm(), needed_mps2, period_s, requested_mps2);
    }

    /// The law's largest request in a curve, m/s²; infinite elsewhere.
    pub fn most_mps2(&self) -> f64 {
        if self.most_mps2 < FREE_MPS2 { self.most_mps2 } else { f64::INFINITY }
    }

    /// The largest speed from which every curve ahead is reached with its comfortable speed, m/s, and the acceleration
    /// with which the ego reaches it, m/s²; positive infinity if the ego is slow enough.
    fn demand(&self, road: &RoadAhead<'_>, speed_mps: f64) -> (f64, f64) {
        let mut square = f64::INFINITY;
        let (mut needed, mut at_once) = (f64::INFINITY, f64::INFINITY);
        let settle_m = SETTLE_S * speed_mps;
        road.each(|ahead_m, curvature_perm| {
            let there_mps = comfortable_mps(&self.comfort, curvature_perm);
            let way_m = (ahead_m - LEAD_S * speed_mps).max(0.0);
            square = square.min(there_mps * there_mps + 2.0 * self.braking_mps2 * way_m);
            if there_mps < speed_mps {
                let surplus = there_mps * there_mps - speed_mps * speed_mps;
                let way_m = (ahead_m - RESPONSE_S * speed_mps).max(settle_m);
                needed = needed.min(surplus / (2.0 * way_m));
                at_once = at_once.min(surplus / (2.0 * ahead_m.max(settle_m)));
            }
        });
        let hardest = if at_once < -HARD_MPS2 { -HARDEST_MPS2 } else { -HARD_MPS2 };
        (square.sqrt(), needed.max(hardest))
    }

    /// Notes the target; holds the speed where one was lost in a curve.
    fn see_target(&mut self, input: &Input, road: &RoadAhead<'_>, speed_mps: f64) {
        let target_m = input.target.map(|target| target.gap_m);
        match (self.target_m, target_m) {
            (Some(lost_m), None) if road.bends_within(lost_m, CURVE_PERM) => {
                self.held = Some(Held { until_s: input.time_s + HELD_S, speed_mps });
            }
            (_, Some(_)) => self.held = None,
            (_, None) => {}
        }
        self.target_m = target_m;
    }

    /// Moves the bound on the acceleration.
    fn bound(
        &mut self,
        speed_mps: f64,
        here_perm: f64,
        needed_mps2: f64,
        period_s: f64,
        requested_mps2: f64,
    ) {
        // Braking that began goes on until the curve needs half of it: the need stays the same while it is met.
        let share = if self.comes_down { 0.5 } else { 1.0 };
        self.comes_down = needed_mps2 <= -share * self.braking_mps2;
        let share = (speed_mps - TOTAL_MPS.0) / (TOTAL_MPS.1 - TOTAL_MPS.0);
        let total = TOTAL_MPS2.0 + share.clamp(0.0, 1.0) * (TOTAL_MPS2.1 - TOTAL_MPS2.0);
        let lateral = speed_mps * speed_mps * here_perm.abs();
        let step = BOUND_MPS3 * period_s;
        let mut allowed = FREE_MPS2;
        if lateral >= LATERAL_MPS2 {
            allowed = (total * total - lateral * lateral).max(0.0).sqrt();
        }
        if self.comes_down {
            allowed = allowed.min(needed_mps2);
        }
        self.most_mps2 = if allowed < FREE_MPS2 {
            let from = self.most_mps2.min(requested_mps2.max(allowed));
            (from - step).max(allowed).min(self.most_mps2 + step)
        } else {
            (self.most_mps2 + step).min(FREE_MPS2)
        };
    }
}

#[cfg(test)]
mod tests;
