//! Prediction of the lead, whose acceleration is a known disturbance that decays.
//!
//! ```text
//! a_l(t) = a_l(0) exp(-t / tau_l),   v_l' = a_l,   v_l never negative
//! ```

use law::MAX_PLAN;
use law::following::safe_gap::LeadNow;

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
