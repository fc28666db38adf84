//! The last word on every request: pure kinematics with the actuator's lag.
//!
//! A request acts for one period. Emergency braking follows it, with a deceleration that the vehicle surely
//! reaches. The request is safe when the vehicle then stops
//!
//! * before each closed line, and
//! * behind the lead at all times: see [`safe_gap`](crate::following::safe_gap).
//!
//! From a safe state emergency braking is safe, so a safe request always exists, and the state stays safe. The vehicle
//! reaches neither a line nor the lead, whatever the law above requests. At a line that is to be passed, the request
//! must leave one way open. The vehicle can still stop, or it crosses before red at its present speed.

use crate::following::kinematics::{Lag, LagStep, Motion};
use crate::following::parameters::FOLLOWING;
use crate::following::safe_gap::{LeadNow, SafeGap};
use crate::laws::cacc::config::Config;

/// Distance kept to a closed line, m.
const LINE_MARGIN_M: f64 = 0.2;
/// Way that a soft stop may take beyond the safe gap, as a share of the smallest gap. Chosen: the way of the last
/// 0.3 s from 3 m/s.
pub(super) const SOFT_SHARE: f64 = 0.5;
/// Halvings of the interval of requests: to a thousandth of a m/s².
const HALVINGS: usize = 13;
/// Step in which ego and lead are compared, s.
const CHECK_S: f64 = 0.1;
/// Shares of the hardest braking with which a crossing behind a slower lead is tried.
const BRAKING_SHARES: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// Shortest time for which a request is taken to act, s: with less the filter would switch between
/// its extremes.
const SHORTEST_PERIOD_S: f64 = 0.05;

/// Treatment of a line by the filter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Rule {
    /// Stop before it.
    Stop,
    /// Cross it before red, which comes after this time in s, or stay able to stop.
    Pass {
        /// s.
        red_in_s: f64,
    },
}

/// A line ahead and its rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Gate {
    /// Distance to the line, m.
    pub(super) distance_m: f64,
    /// Treatment of the line.
    pub(super) rule: Rule,
}

/// The filter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Filter {
    lag: Lag,
    period: LagStep,
    check: LagStep,
    min_mps2: f64,
    max_mps2: f64,
    safe: SafeGap,
}

impl Filter {
    /// A filter for a control period of `period_s`.
    pub(super) fn new(config: &Config, period_s: f64) -> Self {
        let lag = Lag { tau_s: config.actuator_lag_s };
        let period_s = period_s.max(SHORTEST_PERIOD_S);
        Self {
            lag,
            period: lag.discretise(period_s),
            check: lag.discretise(CHECK_S),
            min_mps2: config.min_request_mps2,
            max_mps2: config.max_request_mps2,
            safe: safe_gap(config, period_s),
        }
    }

    /// The safe request nearest to `request`.
    pub(super) fn apply(
        &self,
        request: f64,
        ego: Motion,
        lead: Option<&LeadNow>,
        gates: &[Gate],
    ) -> f64 {
        let mut u = request.clamp(self.min_mps2, self.max_mps2);
        for gate in gates {
            if let Rule::Pass { red_in_s } = gate.rule {
                u = self.pass(u, ego, lead, gate.distance_m, red_in_s);
            }
        }
        for gate in gates {
            if gate.rule == Rule::Stop {
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
        self.stops_before(self.min_mps2, ego, distance_m)
    }

    /// True if the speed that is left when the present deceleration has died away crosses a line before red.
    pub(super) fn can_cross(
        &self,
        ego: Motion,
        lead: Option<&LeadNow>,
        distance_m: f64,
        red_in_s: f64,
    ) -> bool {
        self.has_room(0.0, ego, lead, distance_m, red_in_s)
    }

    /// True if braking with a constant `request` from now on is enough. It must stop before each closed line, and
    /// behind a lead that keeps its present motion.
    pub(super) fn suffices(
        &self,
        request: f64,
        ego: Motion,
        lead: Option<&LeadNow>,
        gates: &[Gate],
    ) -> bool {
        let ego = Motion { position_m: 0.0, ..ego };
        let rest = self.lag.stop(ego, request).distance_m;
        let stops = gates
            .iter()
            .all(|gate| gate.rule != Rule::Stop || rest <= gate.distance_m - LINE_MARGIN_M);
        stops
            && lead.is_none_or(|lead| {
                let now = lead.braking_mps2();
                self.safe.margin_m(ego, 0.0, |_| request, lead, now) >= 0.0
            })
    }

    fn pass(
        &self,
        u: f64,
        ego: Motion,
        lead: Option<&LeadNow>,
        distance_m: f64,
        red_in_s: f64,
    ) -> f64 {
        let crosses = |u: f64| self.crosses(u, ego, distance_m, red_in_s);
        let stops = |u: f64| self.stops_before(u, ego, distance_m);
        if stops(u) || self.has_room(u, ego, lead, distance_m, red_in_s) {
            return u;
        }
        if stops(self.min_mps2) {
            return self.safe.lower(u, stops);
        }
        // Too late to stop. Room behind the lead is seen to after this.
        if crosses(u) {
            return u;
        }
        if !crosses(self.max_mps2) {
            // Neither is possible any more: cross as slowly as can be.
            return self.min_mps2;
        }
        let (mut low, mut high) = (u, self.max_mps2);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if crosses(middle) { high = middle } else { low = middle }
        }
        high
    }

    fn stops_before(&self, u: f64, ego: Motion, distance_m: f64) -> bool {
        let next = self.period.advance(Motion { position_m: 0.0, ..ego }, u);
        let rest = self.lag.stop(next, FOLLOWING.sure_share * self.min_mps2).distance_m;
        next.position_m + rest <= distance_m - LINE_MARGIN_M
    }

    fn crosses(&self, u: f64, ego: Motion, distance_m: f64, red_in_s: f64) -> bool {
        let next = self.period.advance(Motion { position_m: 0.0, ..ego }, u);
        let left = (red_in_s - self.period.step_s).max(0.0);
        next.position_m + self.kept_mps(next) * left >= distance_m + LINE_MARGIN_M
    }

    /// Speed once the present deceleration has died away, m/s.
    fn kept_mps(&self, ego: Motion) -> f64 {
        (ego.speed_mps + ego.acceleration_mps2.min(0.0) * self.lag.tau_s).max(0.0)
    }

    /// True if a lead that goes on as it does now leaves room to cross before red. The ego keeps its speed, brakes only
    /// after the line, or brakes for the lead all along.
    fn has_room(
        &self,
        u: f64,
        ego: Motion,
        lead: Option<&LeadNow>,
        distance_m: f64,
        red_in_s: f64,
    ) -> bool {
        let Some(lead) = lead else { return self.crosses(u, ego, distance_m, red_in_s) };
        let next = self.period.advance(Motion { position_m: 0.0, ..ego }, u);
        let hardest = FOLLOWING.sure_share * self.min_mps2;
        let now = lead.braking_mps2();
        let is_safe_there = |time_s: f64, at: Motion| {
            // The gap must be safe there as well: otherwise it brakes for the lead before the line.
            let moved = LeadNow {
                gap_m: lead.position_m(now, time_s) - at.position_m,
                speed_mps: (lead.speed_mps - now * time_s).max(0.0),
                ..*lead
            };
            let at = Motion { position_m: 0.0, ..at };
            self.safe.margin_m(at, 0.0, |_| hardest, &moved, self.safe.worst_mps2(&moved)) >= 0.0
        };
        let kept_mps = self.kept_mps(next);
        let line_m = distance_m + LINE_MARGIN_M;
        let at_kept_speed =
            Motion { position_m: line_m, speed_mps: kept_mps, acceleration_mps2: 0.0 };
        let way_s = (line_m - next.position_m) / kept_mps;
        if self.crosses(u, ego, distance_m, red_in_s)
            && is_safe_there(self.period.step_s + way_s, at_kept_speed)
        {
            return true;
        }
        let left_s = red_in_s - self.period.step_s;
        BRAKING_SHARES.iter().any(|share| {
            let reached = self.reaches(next, share * hardest, distance_m, left_s);
            reached.is_some_and(|(time_s, at)| is_safe_there(self.period.step_s + time_s, at))
        })
    }

    /// Time and state at which a constant request gets beyond a line in the time that is left.
    fn reaches(
        &self,
        mut ego: Motion,
        request: f64,
        distance_m: f64,
        left_s: f64,
    ) -> Option<(f64, Motion)> {
        let mut time = 0.0;
        while time + CHECK_S <= left_s && ego.speed_mps > 0.0 {
            ego = self.check.advance(ego, request);
            time += CHECK_S;
            if ego.position_m >= distance_m + LINE_MARGIN_M {
                return Some((time, ego));
            }
        }
        None
    }
}

/// The gap that a configuration keeps safe: the smallest one, and what a soft stop may use of it.
pub(super) fn safe_gap(config: &Config, period_s: f64) -> SafeGap {
    let road = &config.road;
    SafeGap::new(
        Lag { tau_s: config.actuator_lag_s },
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
                let gate = Gate { distance_m: 120.0 - ego.position_m, rule: Rule::Stop };
                ego = step.advance(ego, filter().apply(4.9, ego, None, &[gate]));
            }
            assert_eq!(ego.speed_mps, 0.0);
            assert!(ego.position_m > 118.0 && ego.position_m < 120.0, "{}", ego.position_m);
        }
    }

    #[test]
    fn past_the_point_of_no_return_it_crosses_before_red() {
        let ego = Motion { position_m: 0.0, speed_mps: 15.0, acceleration_mps2: 0.0 };
        let pass = |red_in_s| Gate { distance_m: 20.0, rule: Rule::Pass { red_in_s } };
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
        assert!(!filter().can_cross(ego, Some(&lead(42.39)), 54.0, 2.54));
        assert!(filter().can_cross(ego, Some(&lead(62.39)), 54.0, 2.54));
    }
}
