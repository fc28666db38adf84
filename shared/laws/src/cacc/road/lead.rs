//! Prediction of the lead, whose acceleration is a known disturbance that decays, and the fastest drive behind it.
//!
//! ```text
//! a_l(t) = a_l(0) exp(-t / tau_l),   v_l' = a_l,   v_l never negative
//! ```

use law::MAX_PLAN;
use law::following::kinematics::{LagStep, Motion};
use law::following::safe_gap::{LeadNow, SafeGap};

/// The lead over the horizon, in the frame of the ego's front bumper now. Without a lead, a point that rests at zero
/// takes its place: the error coordinates only need some known motion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prediction {
    pub(super) present: bool,
    pub(super) stages: [LeadNow; MAX_PLAN + 1],
}

impl Prediction {
    pub(super) const ABSENT: Self = Self {
        present: false,
        stages: [LeadNow { gap_m: 0.0, speed_mps: 0.0, acceleration_mps2: 0.0 }; MAX_PLAN + 1],
    };

    /// The lead at a stage, before an ego at `position_m`.
    pub(super) fn at(&self, stage: usize, position_m: f64) -> Option<LeadNow> {
        let lead = self.stages[stage];
        self.present.then_some(LeadNow { gap_m: lead.gap_m - position_m, ..lead })
    }

    /// Predicts in steps of `step_s`; `decay` is `exp(-step / tau_l)`.
    pub(super) fn update(&mut self, lead: Option<&LeadNow>, step_s: f64, decay: f64) {
        let Some(lead) = lead else {
            *self = Self::ABSENT;
            return;
        };
        self.present = true;
        let (mut x, mut v, mut a) = (lead.gap_m, lead.speed_mps.max(0.0), lead.acceleration_mps2);
        for stage in &mut self.stages {
            let acceleration_mps2 = if v > 0.0 || a > 0.0 { a } else { 0.0 };
            *stage = LeadNow { gap_m: x, speed_mps: v, acceleration_mps2 };
            // The mean acceleration over a step of the exponential, to second order.
            let next = (v + step_s * 0.5 * (a + a * decay)).max(0.0);
            x += step_s * 0.5 * (v + next);
            v = next;
            a *= decay;
        }
    }
}

/// Speeds over the horizon of the fastest drive behind the lead that the safety filter lets through.
///
/// It has the law's largest acceleration, the set speed, the actuator's lag, and the speed from which full braking is
/// enough behind the predicted lead. Let `w` be the speed that is left once the present acceleration has died away. It
/// follows the request without a lag:
///
/// ```text
/// w = v + tau a,   w' = u exactly
/// u = the largest request with  w <= set speed  and  w <= w_safe
/// ```
///
/// A pass is planned within these speeds. The filter would take away whatever is faster, and the pass with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fastest {
    pub(super) speed_mps: [f64; MAX_PLAN + 1],
}

impl Fastest {
    /// Limits nothing.
    pub(super) const FREE: Self = Self { speed_mps: [f64::INFINITY; MAX_PLAN + 1] };

    /// Rolls the drive out from `start` over `horizon` stages, with at most `acceleration_mps2`.
    pub(super) fn roll_out(
        &mut self,
        (start, horizon): (Motion, usize),
        (desired_mps, acceleration_mps2): (f64, f64),
        (lag, tau_s): (&LagStep, f64),
        safe: &SafeGap,
        lead: &Prediction,
    ) {
        let mut here = start;
        self.speed_mps[0] = here.speed_mps;
        for k in 1..=horizon {
            let left_mps = here.speed_mps + tau_s * here.acceleration_mps2;
            let mut most_mps = desired_mps.max(left_mps);
            if let Some(next) = lead.at(k, here.position_m + lag.step_s * here.speed_mps) {
                most_mps = most_mps.min(safe.safe_speed_mps(&next));
            }
            let request = (most_mps - left_mps) / lag.step_s;
            here = lag.advance(here, request.clamp(safe.comfort_mps2, acceleration_mps2));
            self.speed_mps[k] = here.speed_mps;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_braking_lead_settles_or_stops_but_never_reverses() {
        let mut prediction = Prediction::ABSENT;
        let decay = libm::exp(-0.1 / 1.5);
        let lead = LeadNow { gap_m: 20.0, speed_mps: 10.0, acceleration_mps2: -2.0 };
        prediction.update(Some(&lead), 0.1, decay);
        // All of the deceleration: a tau_l = 3 m/s.
        assert!((prediction.stages[MAX_PLAN].speed_mps - 7.0).abs() < 0.01);
        let lead = LeadNow { speed_mps: 2.0, ..lead };
        prediction.update(Some(&lead), 0.1, decay);
        assert_eq!(prediction.stages[MAX_PLAN].speed_mps, 0.0);
        assert!(prediction.stages.windows(2).all(|pair| pair[1].gap_m >= pair[0].gap_m));
    }
}
