//! The gap from which braking is still enough, whatever the vehicle ahead does.
//!
//! A request acts for one period. Full braking follows it, with a deceleration that the vehicle surely
//! reaches. The margin of a request is the least gap on the way to standstill, less the smallest accepted
//! gap. The vehicle ahead brakes to standstill at a constant rate:
//!
//! ```text
//! margin(u) = min over t of x_lead(t) - x_ego(t; u) - gap_min
//! x_lead(t) = gap + v_l t - b t²/2 until v_l / b,   b = max(b_worst, what it does now and may add)
//! ```
//!
//! A request with a margin of 0 or more is safe. From a safe state full braking is safe, so a safe request always
//! exists. The state stays safe while the vehicle ahead brakes with at most `b`. A state can be unsafe without the
//! law's doing: a vehicle cuts in, or a lead brakes harder than is assumed. Behind a lead that brakes, the request is
//! then the full braking. Behind one that does not brake, the gap opens comfortably, and more firmly if more is
//! missing. It opens harder than comfortably where the state would otherwise still be unsafe when the reference driver of
//! UN R157 has taken off the closing speed: a slower vehicle that cuts in closely may brake soon.
//!
//! A worst case is not a reason for hard braking while gentle braking is enough for what the lead does. Let `e` be the
//! smallest constant braking that keeps `gap_min`, or most of a gap that is already smaller. It counts as if it began now:
//! harder braking that is under way would make itself look needless. Meanwhile the lead goes on as it does, and may add to
//! its braking. While `e` is at most 1.5 m/s², no request is below the comfortable one or
//! `-2 e`, whichever is harder:
//!
//! ```text
//! u >= min(comfort, -2 e)     while e <= 1.5 m/s²
//! ```
//!
//! | symbol | field | unit |
//! |---|---|---|
//! | `gap_min` | [`SafeGap::min_gap_m`] | m |
//! | `b_worst` | [`SafeGap::lead_deceleration_mps2`] | m/s² |
//! | full braking | [`SafeGap::min_mps2`] | m/s² |

use super::driver::Obstacle;
use super::kinematics::{Lag, LagStep, Motion};
use super::parameters::FOLLOWING;

/// Step in which ego and lead are compared, s.
pub const CHECK_S: f64 = 0.1;
/// Longest comparison, steps: well over the stop from 70 m/s.
const CHECKS: usize = 250;
/// Halvings of the interval of requests: to a thousandth of a m/s².
pub const HALVINGS: usize = 13;
/// Reaction of the reference driver of UN R157, s, and the braking that follows, m/s². An unsafe state is left within the
/// time in which this driver takes off the closing speed.
const REFERENCE_S: f64 = 0.35;
const REFERENCE_MPS2: f64 = 6.0;
/// Halvings of the interval of gentle braking: to a hundredth of a m/s².
const GENTLE_HALVINGS: usize = 7;

/// The vehicle ahead, in the ego's frame: position 0 is the ego's front bumper now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeadNow {
    pub gap_m: f64,
    pub speed_mps: f64,
    pub acceleration_mps2: f64,
}

impl LeadNow {
    /// Its deceleration, m/s², 0 when it does not brake.
    pub fn braking_mps2(&self) -> f64 {
        (-self.acceleration_mps2).max(0.0)
    }

    /// The way to the place where it stands if it goes on braking as it does, less `min_gap_m`.
    pub fn room_m(&self, min_gap_m: f64) -> f64 {
        let braking = self.braking_mps2();
        if braking <= 0.0 && self.speed_mps > 0.1 {
            return f64::INFINITY;
        }
        let stops_m = 0.5 * self.speed_mps * self.speed_mps / braking.max(0.1);
        self.gap_m + stops_m - min_gap_m
    }

    /// The same for a driver who keeps a time headway and a gap at standstill to it.
    pub fn obstacle(&self, headway_s: f64, standstill_m: f64) -> Obstacle {
        let Self { gap_m, speed_mps, acceleration_mps2 } = *self;
        Obstacle { gap_m, speed_mps, acceleration_mps2, headway_s, standstill_m }
    }

    /// Its rear bumper after `time_s` of a constant deceleration.
    pub fn position_m(&self, deceleration_mps2: f64, time_s: f64) -> f64 {
        let v = self.speed_mps.max(0.0);
        let b = deceleration_mps2;
        let moving_s = if b > 0.0 { time_s.min(v / b) } else { time_s };
        self.gap_m + v * moving_s - 0.5 * b * moving_s * moving_s
    }
}

/// Vehicle and margin that the gap is kept safe against.
#[derive(Clone, Copy, Debug)]
pub struct SafeGap {
    pub lag: Lag,
    /// A control period, and a step of the comparison.
    pub period: LagStep,
    pub check: LagStep,
    /// Full braking, m/s² (negative).
    pub min_mps2: f64,
    /// Comfortable braking, m/s² (negative).
    pub comfort_mps2: f64,
    pub min_gap_m: f64,
    /// Hardest assumed deceleration of the vehicle ahead, m/s².
    pub lead_deceleration_mps2: f64,
}

impl SafeGap {
    /// Makes it for an actuator's lag and a control period.
    pub fn new(
        lag: Lag,
        period_s: f64,
        (min_mps2, comfort_mps2): (f64, f64),
        min_gap_m: f64,
        lead_deceleration_mps2: f64,
    ) -> Self {
        let (period, check) = (lag.discretise(period_s), lag.discretise(CHECK_S));
        Self { lag, period, check, min_mps2, comfort_mps2, min_gap_m, lead_deceleration_mps2 }
    }

    /// The safe request nearest to `request`. Where gentle braking is enough, it is no harder than the comfortable one and
    /// twice what is enough.
    pub fn apply(&self, request: f64, ego: Motion, lead: &LeadNow) -> f64 {
        let safe = self.nearest(request, ego, lead);
        // A harder request has other reasons, as a stop line.
        let tempered = |enough| safe.max(self.comfort_mps2.min(-2.0 * enough)).min(request);
        match safe < self.comfort_mps2 {
            true => self.enough_mps2(ego, lead).map_or(safe, tempered),
            false => safe,
        }
    }

    /// The smallest constant braking from now on that keeps the gap while the lead goes on as it does, m/s². `None` if
    /// gentle braking does not.
    pub fn enough_mps2(&self, ego: Motion, lead: &LeadNow) -> Option<f64> {
        let acceleration_mps2 = ego.acceleration_mps2.max(0.0);
        let ego = Motion { position_m: 0.0, acceleration_mps2, ..ego };
        let expected = expected_mps2(lead);
        let least_m = (FOLLOWING.kept_share * lead.gap_m - self.min_gap_m).min(0.0);
        let is_enough =
            |braking: f64| self.margin_m(ego, 0.0, |_| -braking, lead, expected) >= least_m;
        let gentle_mps2 = FOLLOWING.gentle_mps2;
        is_enough(gentle_mps2).then(|| bisect(GENTLE_HALVINGS, gentle_mps2, 0.0, is_enough))
    }

    fn nearest(&self, request: f64, ego: Motion, lead: &LeadNow) -> f64 {
        let expected = expected_mps2(lead);
        let worst = self.worst_mps2(lead);
        if self.stays_behind(self.min_mps2, ego, lead, worst) {
            return self.lower(request, |u| self.stays_behind(u, ego, lead, worst));
        }
        let next = self.after_period(self.min_mps2, ego);
        let missing_m = -self.margin_m(next, self.period.step_s, self.full(), lead, worst);
        let share = (missing_m / FOLLOWING.missing_m).clamp(0.0, 1.0);
        let opening = request.min(share * self.comfort_mps2);
        let opening = match opening > self.comfort_mps2 {
            true => opening,
            false => self.lower(opening, |u| self.recovers(u, ego, lead, expected)),
        };
        self.lower(opening, |u| self.stays_behind(u, ego, lead, expected))
    }

    /// True if the state is safe after the reference driver's time of a request, while the lead goes on as expected.
    fn recovers(&self, u: f64, ego: Motion, lead: &LeadNow, expected: f64) -> bool {
        let closing_mps = (ego.speed_mps - lead.speed_mps).max(0.0);
        let steps = ((REFERENCE_S + closing_mps / REFERENCE_MPS2) / CHECK_S).ceil();
        let start = Motion { position_m: 0.0, ..ego };
        let then = (0..steps as u32).fold(start, |ego, _| self.check.advance(ego, u));
        let time_s = CHECK_S * steps;
        let lead = LeadNow {
            gap_m: lead.position_m(expected, time_s) - then.position_m,
            speed_mps: (lead.speed_mps - expected * time_s).max(0.0),
            ..*lead
        };
        self.stays_behind(self.min_mps2, then, &lead, self.worst_mps2(&lead))
    }

    /// Deceleration of the vehicle ahead that the gap is kept safe against, m/s².
    pub fn worst_mps2(&self, lead: &LeadNow) -> f64 {
        self.lead_deceleration_mps2.max(expected_mps2(lead))
    }

    /// The largest request up to `u` that passes `test`; the smallest there is when none does.
    pub fn lower(&self, u: f64, test: impl Fn(f64) -> bool) -> f64 {
        if test(u) {
            u
        } else if test(self.min_mps2) {
            bisect(HALVINGS, self.min_mps2, u, test)
        } else {
            self.min_mps2
        }
    }

    /// True if full braking after one period of `u` keeps the gap while the lead brakes with `deceleration` from now
    /// on.
    pub fn stays_behind(&self, u: f64, ego: Motion, lead: &LeadNow, deceleration: f64) -> bool {
        let next = self.after_period(u, ego);
        self.margin_m(next, self.period.step_s, self.full(), lead, deceleration) >= 0.0
    }

    /// The ego after one period of `u`, from position 0.
    pub fn after_period(&self, u: f64, ego: Motion) -> Motion {
        self.period.advance(Motion { position_m: 0.0, ..ego }, u)
    }

    /// Full braking, wherever the ego is.
    fn full(&self) -> impl Fn(f64) -> f64 + use<> {
        let request = FOLLOWING.sure_share * self.min_mps2;
        move |_| request
    }

    /// Least gap beyond the smallest accepted one, m, for an ego in state `ego` after `time_s`. The request
    /// depends on its place. Stops looking once the gap is used up by far.
    pub fn margin_m(
        &self,
        mut ego: Motion,
        mut time_s: f64,
        request: impl Fn(f64) -> f64,
        lead: &LeadNow,
        deceleration: f64,
    ) -> f64 {
        let mut least_m = f64::INFINITY;
        for _ in 0..CHECKS {
            let gap_m = lead.position_m(deceleration, time_s) - ego.position_m;
            least_m = least_m.min(gap_m - self.min_gap_m);
            if least_m < -FOLLOWING.missing_m
                || (ego.speed_mps <= 0.0 && ego.acceleration_mps2 <= 0.0)
            {
                break;
            }
            // Opening from here on: a lead that does not brake is only ever approached less.
            if deceleration == 0.0
                && ego.speed_mps + 0.5 * ego.acceleration_mps2.max(0.0) <= lead.speed_mps
            {
                break;
            }
            ego = self.check.advance(ego, request(ego.position_m));
            time_s += CHECK_S;
        }
        least_m
    }

    /// The steady speed from which full braking is enough behind a lead that brakes as hard as is assumed, m/s.
    ///
    /// With `b` the full braking and `h` the lag and one period, it is the root `w` of
    /// `w²/(2b) + h w - b tau²/2 = gap + v_l²/(2 b_worst) - gap_min`.
    pub fn safe_speed_mps(&self, lead: &LeadNow) -> f64 {
        let b = -FOLLOWING.sure_share * self.min_mps2;
        let (tau, h) = (self.lag.tau_s, self.lag.tau_s + self.period.step_s);
        let lead_m = 0.5 * lead.speed_mps.max(0.0).powi(2) / self.worst_mps2(lead);
        let room_m = lead.gap_m + lead_m - self.min_gap_m + 0.5 * b * tau * tau;
        b * ((h * h + 2.0 * room_m.max(0.0) / b).sqrt() - h)
    }

    /// The gap that is safe behind a lead of the same speed, both steady, m. The ego's way is that of
    /// [`Self::safe_speed_mps`].
    pub fn steady_gap_m(&self, speed_mps: f64) -> f64 {
        let (v, tau, b) = (speed_mps, self.lag.tau_s, -FOLLOWING.sure_share * self.min_mps2);
        let own_m = 0.5 * v * v / b + (tau + self.period.step_s) * v - 0.5 * b * tau * tau;
        let lead_m = 0.5 * v * v / self.lead_deceleration_mps2;
        self.min_gap_m + (own_m - lead_m).max(0.0)
    }
}

/// The value next to the limit of `test`, between one that passes and one that fails.
pub fn bisect(halvings: usize, mut passes: f64, mut fails: f64, test: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..halvings {
        let middle = 0.5 * (passes + fails);
        if test(middle) { passes = middle } else { fails = middle }
    }
    passes
}

/// The deceleration that the vehicle ahead has now, with what it may still add, m/s².
fn expected_mps2(lead: &LeadNow) -> f64 {
    let now = lead.braking_mps2();
    if now > FOLLOWING.brakes_mps2 { (1.0 + FOLLOWING.may_add_share) * now } else { now }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAG: Lag = Lag { tau_s: 0.5 };

    fn gap(lead_deceleration_mps2: f64) -> SafeGap {
        SafeGap::new(LAG, 0.1, (-4.9, -3.0), 2.0, lead_deceleration_mps2)
    }

    /// An ego that asks for full acceleration behind a lead that brakes after a while.
    fn least_gap(start_m: f64, speed_mps: f64, lead_mps2: f64, safe: &SafeGap) -> f64 {
        let step = LAG.discretise(0.1);
        let mut ego = Motion { position_m: 0.0, speed_mps, acceleration_mps2: 0.0 };
        let (mut x, mut v, mut least_m) = (start_m, speed_mps, f64::INFINITY);
        for k in 0..600 {
            let a = if k < 100 || v <= 0.0 { 0.0 } else { lead_mps2 };
            let lead = LeadNow { gap_m: x - ego.position_m, speed_mps: v, acceleration_mps2: a };
            ego = step.advance(ego, safe.apply(4.9, ego, &lead));
            let next = (v + 0.1 * a).max(0.0);
            x += 0.05 * (v + next);
            v = next;
            least_m = least_m.min(x - ego.position_m);
        }
        least_m
    }

    #[test]
    fn a_lead_that_brakes_as_hard_as_assumed_is_not_reached() {
        for lead_mps2 in [-2.0, -4.0, -7.0] {
            for speed_mps in [5.0, 15.0, 30.0] {
                let least_m = least_gap(80.0, speed_mps, lead_mps2, &gap(7.0));
                assert!(least_m > 1.5, "{least_m} m behind {lead_mps2} m/s² at {speed_mps} m/s");
            }
        }
    }

    #[test]
    fn gentle_braking_that_is_enough_tempers_the_gaps_request_and_no_other() {
        let ego = Motion { position_m: 0.0, speed_mps: 20.0, acceleration_mps2: 0.0 };
        let lead = LeadNow { gap_m: 14.0, speed_mps: 20.5, acceleration_mps2: 0.0 };
        assert!(gap(7.0).apply(1.0, ego, &lead) >= -3.0);
        assert_eq!(gap(7.0).apply(-4.5, ego, &lead), -4.5, "a stop line asks for it");
        let brakes = LeadNow { acceleration_mps2: -6.0, ..lead };
        assert_eq!(gap(7.0).apply(1.0, ego, &brakes), -4.9);
    }

    #[test]
    fn a_slower_vehicle_that_cuts_in_closely_is_braked_for_harder_than_comfortably() {
        let ego = Motion { position_m: 0.0, speed_mps: 24.0, acceleration_mps2: -2.5 };
        let gap = SafeGap::new(LAG, 0.1, (-6.0, -3.0), 3.0, 7.0);
        let request = |gap_m, speed_mps| {
            gap.apply(-3.0, ego, &LeadNow { gap_m, speed_mps, acceleration_mps2: 0.0 })
        };
        assert!((-5.5..-3.5).contains(&request(18.0, 15.0)), "{}", request(18.0, 15.0));
        assert_eq!(request(18.0, 22.0), -3.0, "it comes closer slowly");
        assert_eq!(request(60.0, 15.0), -3.0, "there is room");
    }

    #[test]
    fn the_steady_gap_is_the_edge_of_the_safe_states() {
        for speed_mps in [8.0, 20.0, 36.0] {
            let safe = gap(7.0);
            let ego = Motion { position_m: 0.0, speed_mps, acceleration_mps2: 0.0 };
            let at = |extra_m: f64| {
                let gap_m = safe.steady_gap_m(speed_mps) + extra_m;
                let lead = LeadNow { gap_m, speed_mps, acceleration_mps2: 0.0 };
                safe.stays_behind(0.0, ego, &lead, 7.0)
            };
            assert!(at(0.3), "{speed_mps}");
            assert!(!at(-0.3) || safe.steady_gap_m(speed_mps) < 2.1, "{speed_mps}");
        }
    }
}
