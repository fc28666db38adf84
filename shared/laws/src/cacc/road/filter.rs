//! The last word on every request: pure kinematics with the actuator's lag.
//!
//! A request acts for one period. Emergency braking follows it, with a deceleration that the vehicle surely
//! reaches. The request is safe when the vehicle then stops
//!
//! * before each closed line, and
//! * behind the lead at all times: see [`safe_gap`](law::following::safe_gap).
//!
//! From a safe state emergency braking is safe, so a safe request always exists, and the state stays safe. The vehicle
//! reaches neither a line nor the lead, whatever the law above requests. At a line that is to be passed, the request
//! must leave one way open. The vehicle can still stop, or it crosses before red. A request above 0 then goes on, up to
//! the speed that is safe behind the lead at the line; a deceleration dies away.

use super::reference::SPARE_M;
use crate::cacc::config::Config;
use law::following::comfortable_jerk_mps3;
use law::following::kinematics::{Lag, Motion};
use law::following::parameters::FOLLOWING;
use law::following::safe_gap::{CHECK_S, HALVINGS, LeadNow, SafeGap, bisect};

/// Distance kept to a closed line, m.
const LINE_MARGIN_M: f64 = 0.2;
/// Way that a soft stop may take beyond the safe gap, as a share of the smallest gap. Chosen: the way of the last
/// 0.3 s from 3 m/s.
pub(super) const SOFT_SHARE: f64 = 0.5;
/// Shares of the hardest braking with which a crossing behind a slower lead is tried.
const BRAKING_SHARES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Shortest time for which a request is taken to act, s: with less the filter would switch between
/// its extremes.
const SHORTEST_PERIOD_S: f64 = 0.05;

/// A line ahead, and how it may be passed; without that the vehicle stops before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gate {
    pub(super) distance_m: f64,
    pub(super) pass: Option<Pass>,
}

/// Cross a line before red, or stay able to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pass {
    pub(super) red_in_s: f64,
    /// Fastest speed on the way, m/s.
    pub(super) most_mps: f64,
}

impl Gate {
    fn crossing(&self) -> Option<Crossing> {
        let line_m = self.distance_m + LINE_MARGIN_M;
        self.pass.map(|Pass { red_in_s, most_mps }| Crossing { line_m, red_in_s, most_mps })
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Filter {
    max_mps2: f64,
    safe: SafeGap,
}

impl Filter {
    pub(super) fn new(config: &Config, period_s: f64) -> Self {
        let safe = safe_gap(config, period_s.max(SHORTEST_PERIOD_S));
        Self { max_mps2: config.max_request_mps2, safe }
    }

    /// The safe request nearest to `request`.
    pub(super) fn apply(
        &self,
        request: f64,
        ego: Motion,
        lead: Option<&LeadNow>,
        gates: &[Gate],
    ) -> f64 {
        let mut u = request.clamp(self.safe.min_mps2, self.max_mps2);
        for gate in gates {
            if let Some(crossing) = gate.crossing() {
                u = self.pass(u, ego, lead, &crossing);
            }
        }
        for gate in gates {
            if gate.pass.is_none() {
                u = self.safe.lower(u, |u| self.stops_before(u, ego, gate.distance_m));
            }
        }
        match lead {
            Some(lead) => self.safe.apply(u, ego, lead),
            None => u,
        }
    }

    /// True if the hardest braking from now on stops before a line.
    pub(super) fn can_stop(&self, ego: Motion, distance_m: f64) -> bool {
        self.stops_before(self.safe.min_mps2, ego, distance_m)
    }

    /// True if a line is crossed before red, at the speed that is left when the present deceleration has died away or
    /// with a `request` above 0 that goes on.
    pub(super) fn can_cross(
        &self,
        request: f64,
        ego: Motion,
        lead: Option<&LeadNow>,
        gate: Gate,
    ) -> bool {
        gate.crossing().is_some_and(|crossing| self.has_room(request, ego, lead, &crossing))
    }

    /// The hardest request from `acceleration_mps2` on while braking with `enough_mps2` is enough, m/s². The jerk is
    /// comfortable while the comfortable braking is enough. The less braking is in reserve, the less comfort counts.
    pub(super) fn hardest_mps2(&self, enough_mps2: f64, ego: Motion) -> f64 {
        let SafeGap { min_mps2, comfort_mps2, lag, .. } = self.safe;
        let jerk_mps3 = comfortable_jerk_mps3(ego.speed_mps);
        let comfortable_mps2 = ego.acceleration_mps2 - lag.tau_s * jerk_mps3;
        let used = (enough_mps2 - comfort_mps2) / (min_mps2 - comfort_mps2);
        let bound_mps2 = comfortable_mps2 + used * (min_mps2 - comfortable_mps2);
        bound_mps2.max(enough_mps2)
    }

    /// The gentlest constant braking from now on that is enough, m/s²; the comfortable one at least, the hardest if none
    /// is. It stops before each closed line, and stays behind a lead that keeps its present motion.
    pub(super) fn enough_mps2(&self, ego: Motion, lead: Option<&LeadNow>, gates: &[Gate]) -> f64 {
        let ego = Motion { position_m: 0.0, ..ego };
        self.safe.lower(self.safe.comfort_mps2, |request| {
            let rest = self.safe.lag.stop(ego, request).distance_m;
            let before = |gate: &Gate| rest <= gate.distance_m - LINE_MARGIN_M;
            gates.iter().all(|gate| gate.pass.is_some() || before(gate))
                && lead.is_none_or(|lead| {
                    // Noise of the gap must not use up the last of it. A closer gap leaves less to keep.
                    let spare_m = SPARE_M.min(0.5 * (lead.gap_m - self.safe.min_gap_m).max(0.0));
                    let now = lead.braking_mps2();
                    self.safe.margin_m(ego, 0.0, |_| request, lead, now) >= spare_m
                })
        })
    }

    fn pass(&self, u: f64, ego: Motion, lead: Option<&LeadNow>, crossing: &Crossing) -> f64 {
        let crosses = |u: f64| self.crosses(u, ego, crossing).is_some();
        let stops = |u: f64| self.stops_before(u, ego, crossing.line_m - LINE_MARGIN_M);
        if stops(u) || self.has_room(u, ego, lead, crossing) {
            return u;
        }
        if stops(self.safe.min_mps2) {
            return self.safe.lower(u, stops);
        }
        // Too late to stop. Room behind the lead is seen to after this.
        if crosses(u) {
            return u;
        }
        if !crosses(self.max_mps2) {
            // Neither is possible any more: cross as slowly as can be.
            return self.safe.min_mps2;
        }
        bisect(HALVINGS, self.max_mps2, u, crosses)
    }

    fn stops_before(&self, u: f64, ego: Motion, distance_m: f64) -> bool {
        let next = self.safe.after_period(u, ego);
        let rest = self.safe.lag.stop(next, FOLLOWING.sure_share * self.safe.min_mps2).distance_m;
        next.position_m + rest <= distance_m - LINE_MARGIN_M
    }

    /// Time and state at the line, if it is crossed before red. A request above 0 goes on; a deceleration dies away.
    fn crosses(&self, u: f64, ego: Motion, crossing: &Crossing) -> Option<(f64, Motion)> {
        let next = self.safe.after_period(u, ego);
        self.goes_on(u, next, crossing).or_else(|| self.goes_on(0.0, next, crossing))
    }

    /// The same from the end of the period on.
    fn goes_on(&self, u: f64, next: Motion, crossing: &Crossing) -> Option<(f64, Motion)> {
        let left_s = crossing.red_in_s - self.safe.period.step_s;
        let mut at = Motion { acceleration_mps2: 0.0, speed_mps: self.kept_mps(next), ..next };
        if u > 0.0 && next.acceleration_mps2 > 0.0 {
            at = next;
        }
        let mut time_s = 0.0;
        loop {
            let way_m = (crossing.line_m - at.position_m).max(0.0);
            let rest_s = left_s - time_s;
            if way_m <= at.speed_mps * CHECK_S.min(rest_s) {
                let way_s = if way_m > 0.0 { way_m / at.speed_mps } else { 0.0 };
                let there = Motion { position_m: at.position_m + way_m, ..at };
                return Some((self.safe.period.step_s + time_s + way_s, there));
            }
            if rest_s < CHECK_S {
                return None;
            }
            let spare_mps =
                crossing.most_mps - at.speed_mps - self.safe.lag.tau_s * at.acceleration_mps2;
            at = self.safe.check.advance(at, u.max(0.0).min((spare_mps / CHECK_S).max(0.0)));
            time_s += CHECK_S;
        }
    }

    /// Speed once the present deceleration has died away, m/s.
    fn kept_mps(&self, ego: Motion) -> f64 {
        (ego.speed_mps + ego.acceleration_mps2.min(0.0) * self.safe.lag.tau_s).max(0.0)
    }

    /// True if a lead that goes on as it does now leaves room to cross before red. The ego goes on, keeps its speed, or
    /// brakes for the lead all along.
    fn has_room(&self, u: f64, ego: Motion, lead: Option<&LeadNow>, crossing: &Crossing) -> bool {
        let Some(lead) = lead else { return self.crosses(u, ego, crossing).is_some() };
        let next = self.safe.after_period(u, ego);
        let hardest = FOLLOWING.sure_share * self.safe.min_mps2;
        let now = lead.braking_mps2();
        let moved = |time_s: f64, at: &Motion| LeadNow {
            gap_m: lead.position_m(now, time_s) - at.position_m,
            speed_mps: (lead.speed_mps - now * time_s).max(0.0),
            ..*lead
        };
        let is_safe_there = |(time_s, at): (f64, Motion)| {
            // The gap must be safe there as well: otherwise it brakes for the lead before the line.
            let lead = moved(time_s, &at);
            let at = Motion { position_m: 0.0, ..at };
            self.safe.margin_m(at, 0.0, |_| hardest, &lead, self.safe.worst_mps2(&lead)) >= 0.0
        };
        // On the way it gains no more speed than is safe at the line.
        let within_safe_speed = |(time_s, at): (f64, Motion)| {
            let most_mps = crossing.most_mps.min(self.safe.safe_speed_mps(&moved(time_s, &at)));
            self.goes_on(u, next, &Crossing { most_mps, ..*crossing })
        };
        let gaining = self.goes_on(u, next, crossing).and_then(within_safe_speed);
        let on = gaining.into_iter().chain(self.goes_on(0.0, next, crossing));
        let braking =
            BRAKING_SHARES.iter().filter_map(|share| self.reaches(next, share * hardest, crossing));
        on.chain(braking).any(is_safe_there)
    }

    /// Time and state at which a constant request gets beyond a line in the time that is left.
    fn reaches(&self, mut ego: Motion, request: f64, crossing: &Crossing) -> Option<(f64, Motion)> {
        let mut time_s = self.safe.period.step_s;
        while time_s + CHECK_S <= crossing.red_in_s && ego.speed_mps > 0.0 {
            ego = self.safe.check.advance(ego, request);
            time_s += CHECK_S;
            if ego.position_m >= crossing.line_m {
                return Some((time_s, ego));
            }
        }
        None
    }
}

/// A line to be crossed before red.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    /// Position that must be reached, m.
    line_m: f64,
    red_in_s: f64,
    most_mps: f64,
}

/// The gap that a configuration keeps safe: the smallest one, and what a soft stop may use of it.
pub(super) fn safe_gap(config: &Config, period_s: f64) -> SafeGap {
    let road = &config.road;
    SafeGap::new(
        Lag { tau_s: config.model_time_constant_s },
        period_s,
        (config.min_request_mps2, -road.comfort_deceleration_mps2),
        (1.0 + SOFT_SHARE) * road.min_gap_m,
        road.lead_deceleration_mps2,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filter() -> Filter {
        let mut config = Config::default();
        config.road.min_gap_m = 1.0;
        Filter::new(&config, 0.1)
    }

    #[test]
    fn whatever_is_asked_the_line_is_not_reached() {
        let step = Lag { tau_s: 0.5 }.discretise(0.1);
        for v in [3.0, 10.0, 25.0] {
            let mut ego = Motion { position_m: 0.0, speed_mps: v, acceleration_mps2: 0.0 };
            for _ in 0..400 {
                let gate = Gate { distance_m: 120.0 - ego.position_m, pass: None };
                ego = step.advance(ego, filter().apply(4.9, ego, None, &[gate]));
            }
            assert_eq!(ego.speed_mps, 0.0);
            assert!(ego.position_m > 118.0 && ego.position_m < 120.0, "{}", ego.position_m);
        }
    }

    #[test]
    fn past_the_point_of_no_return_it_crosses_before_red() {
        let ego = Motion { position_m: 0.0, speed_mps: 15.0, acceleration_mps2: 0.0 };
        let pass =
            |red_in_s| Gate { distance_m: 20.0, pass: Some(Pass { red_in_s, most_mps: 15.0 }) };
        assert!(!filter().can_stop(ego, 20.0));
        assert!(filter().apply(-3.0, ego, None, &[pass(1.35)]) > -0.5);
        assert_eq!(filter().apply(-3.0, ego, None, &[pass(9.0)]), -3.0);
        assert_eq!(filter().apply(1.0, ego, None, &[pass(0.5)]), -4.9);
    }

    #[test]
    fn a_crossing_does_not_count_on_a_speed_that_the_lead_will_take_away() {
        // At 21.4 m/s the line is reached 0.01 s before red. The lead's gap forbids that speed there.
        let ego = Motion { position_m: 0.0, speed_mps: 21.78, acceleration_mps2: -0.79 };
        let lead = |gap_m| LeadNow { gap_m, speed_mps: 17.47, acceleration_mps2: 0.0 };
        let gate = Gate { distance_m: 54.0, pass: Some(Pass { red_in_s: 2.54, most_mps: 33.3 }) };
        assert!(!filter().can_cross(0.0, ego, Some(&lead(42.39)), gate));
        assert!(filter().can_cross(0.0, ego, Some(&lead(62.39)), gate));
    }
}
