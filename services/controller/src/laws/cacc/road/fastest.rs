//! The fastest drive behind the lead that the safety filter lets through.
//!
//! It has the law's largest acceleration, the set speed, the actuator's lag, and the speed from which full braking is
//! enough behind the predicted lead. Let `w` be the speed that is left once the present acceleration has died away. It
//! follows the request without a lag:
//!
//! ```text
//! w = v + tau a,   w' = u exactly
//! u = the largest request with  w <= set speed  and  w <= w_safe
//! ```
//!
//! A pass is planned within these speeds. The filter would take away whatever is faster, and the pass with it.

use super::lead::Prediction;
use crate::following::kinematics::{LagStep, Motion};
use crate::following::safe_gap::SafeGap;
use crate::law::MAX_PLAN;

/// Speeds of the drive over the horizon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fastest {
    /// Speed at each stage, m/s.
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
