//! Mode 5 with [`Spacing::TimeGap`]: as hard as needed, and no harder.
//!
//! The paper brakes fully below R_b. There full braking after the reaction time t1 is just enough against the target's
//! hardest braking. That is much too hard there. The law takes the request that keeps a gap if full braking follows it.
//! The request is held for the part of t1 that the actuator's lag leaves. It grows from R_b down to where full braking
//! at once is needed:
//!
//! ```text
//! u = max { u <= -a_c : least gap of (u for t1 - tau, then -a_h) >= R_s, the target brakes with b }
//! b = max(a_p, what the target does now and may add)
//! ```
//!
//! While gentle braking is enough for what the target does, the request is tempered: see
//! [`SafeGap`](law::following::safe_gap). A car that cuts in and pulls away is so met with little braking.
//!
//! The request follows with a comfortable jerk (ISO 15622). If full braking after it would not keep R0, it follows as
//! fast as the emergency limit allows.
//!
//! | symbol | field | unit |
//! | --- | --- | --- |
//! | a_c | `approach_limit_mps2` | m/s² |
//! | R_s | gap at which mode 4 ends at standstill | m |
//! | tau | [`LAG_S`] | s |
//!
//! [`Spacing::TimeGap`]: super::Spacing::TimeGap

use super::modes::Situation;
use super::parameters::Parameters;
use law::Ego;
use law::following::comfortable_jerk_mps3;
use law::following::kinematics::{Lag, Motion};
use law::following::safe_gap::{LeadNow, SafeGap};

/// Lag of the vehicle's acceleration that the law assumes, s.
pub(super) const LAG_S: f64 = 0.5;
/// Way beyond R0 that gentle braking must leave, m. Chosen: gentle stops behind a lead that brakes with 2.5 m/s² end
/// 0.1 m nearer than they are planned.
const GENTLE_RESERVE_M: f64 = 0.5;

/// The ego behind its target at one release.
pub(super) struct Behind<'a> {
    p: &'a Parameters,
    lead: LeadNow,
    own: Motion,
    period_s: f64,
}

impl<'a> Behind<'a> {
    /// Behind a target that accelerates with `target_mps2`.
    pub(super) fn new(
        p: &'a Parameters,
        s: &Situation,
        ego: &Ego,
        target_mps2: f64,
        period_s: f64,
    ) -> Self {
        let lead = LeadNow {
            gap_m: s.gap_m,
            speed_mps: (s.speed_mps + s.relative_mps).max(0.0),
            acceleration_mps2: target_mps2,
        };
        let acceleration_mps2 = ego.acceleration_mps2.clamp(-p.braking_mps2, p.acceleration_mps2);
        let own = Motion { acceleration_mps2, ..ego.motion() };
        Self { p, lead, own, period_s }
    }

    /// The request, m/s², after one of `request` a period ago.
    pub(super) fn graded(&self, request: f64) -> f64 {
        let nearest = |safe: &SafeGap, request: f64| {
            let worst_mps2 = safe.worst_mps2(&self.lead);
            safe.lower(request, |u| safe.stays_behind(u, self.own, &self.lead, worst_mps2))
        };
        let wanted = nearest(&self.patient(), -self.p.approach_limit_mps2);
        let softest = request - comfortable_jerk_mps3(self.own.speed_mps) * self.period_s;
        let safe = self.held(self.late_s(), self.p.standstill_gap_m);
        let demand = nearest(&safe, wanted.max(softest));
        match self.enough_mps2() {
            Some(enough) => demand.max(enough).max(softest),
            None => demand,
        }
    }

    /// The hardest request while gentle braking is enough for what the target does, m/s².
    pub(super) fn enough_mps2(&self) -> Option<f64> {
        let safe = self.held(self.late_s(), self.p.standstill_gap_m + GENTLE_RESERVE_M);
        let enough = safe.enough_mps2(self.own, &self.lead)?;
        Some((-2.0 * enough).min(-self.p.approach_limit_mps2))
    }

    /// True if a target that brakes harder than the law's comfortable braking asks for this mode already. The boundaries
    /// go by the target's speed alone. Here `demand` is held for the rest of t1 beside the actuator's lag, and must leave
    /// room for full braking. Behind a target that was faster, the speeds show nothing until it is nearly too late.
    pub(super) fn is_needed(&self, demand: f64) -> bool {
        let patient = self.patient();
        self.lead.acceleration_mps2 < -self.p.approach_limit_mps2
            && !patient.stays_behind(demand, self.own, &self.lead, patient.worst_mps2(&self.lead))
    }

    /// Shortest delay before full braking, s: the filter delays the measured values.
    fn late_s(&self) -> f64 {
        self.period_s + self.p.filter_time_s
    }

    /// Full braking once t1 has passed, to where mode 4 ends at standstill.
    fn patient(&self) -> SafeGap {
        let p = self.p;
        let stop_m = p.standstill_gap_m + p.least_band_m + p.warning_hysteresis_m;
        self.held((p.reaction_time_s - LAG_S).max(self.late_s()), stop_m)
    }

    /// Full braking after a request that is held for `time_s`, to a gap of `least_m`.
    fn held(&self, time_s: f64, least_m: f64) -> SafeGap {
        let bounds = (-self.p.braking_mps2, -self.p.approach_limit_mps2);
        SafeGap::new(Lag { tau_s: LAG_S }, time_s, bounds, least_m, self.p.lead_braking_mps2)
    }
}

#[cfg(test)]
mod tests {
    use super::super::boundaries::Boundaries;
    use super::*;

    const PERIOD_S: f64 = 0.1;

    /// The request at `gap_m` behind a target at 18 of the ego's 20 m/s, once the jerk is over.
    fn settled(gap_m: f64, target_mps2: f64) -> f64 {
        let p = Parameters::default();
        let s = Situation { gap_m, speed_mps: 20.0, relative_mps: -2.0 };
        let ego = Ego { speed_mps: 20.0, ..Ego::default() };
        Behind::new(&p, &s, &ego, target_mps2, PERIOD_S).graded(-p.braking_mps2)
    }

    #[test]
    fn the_request_grows_from_the_boundary_to_full_braking() {
        let p = Parameters::default();
        let braking_m = Boundaries::robust(&p, 20.0, -2.0).braking_m;
        let at_boundary = settled(braking_m, 0.0);
        assert!((-3.5..=-1.0).contains(&at_boundary), "{at_boundary} m/s² at {braking_m} m");
        let requests: Vec<f64> = (0..40).map(|k| settled(braking_m - f64::from(k), -4.0)).collect();
        assert!(requests.windows(2).all(|pair| pair[1] <= pair[0]), "{requests:?}");
        assert_eq!(settled(10.0, -4.0), -p.braking_mps2);
    }

    #[test]
    fn while_gentle_braking_is_enough_the_request_is_no_harder_than_twice_that() {
        // 2 m/s are lost over 30 m less R0 with 0.08 m/s².
        assert_eq!(settled(30.0, 0.0), -Parameters::default().approach_limit_mps2);
    }

    #[test]
    fn a_target_that_brakes_harder_than_assumed_is_braked_for_at_once() {
        let gap_m = 38.0;
        assert!(settled(gap_m, -9.0) < settled(gap_m, 0.0) - 1.0);
    }

    #[test]
    fn the_jerk_is_comfortable_while_there_is_time() {
        let p = Parameters::default();
        let s = Situation { gap_m: 38.0, speed_mps: 20.0, relative_mps: -2.0 };
        let ego = Ego { speed_mps: 20.0, ..Ego::default() };
        let first = Behind::new(&p, &s, &ego, 0.0, PERIOD_S).graded(0.0);
        assert!((first + 0.9 * 2.5 * PERIOD_S).abs() < 1e-9, "{first}");
        let near = Situation { gap_m: 12.0, ..s };
        assert_eq!(Behind::new(&p, &near, &ego, -8.0, PERIOD_S).graded(0.0), -p.braking_mps2);
    }
}
