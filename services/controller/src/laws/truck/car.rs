//! A car under the truck's law: the plan sets the speed, a comfortable driver keeps the distance.
//!
//! A truck's accelerations are not a car's: 0.3 m/s² behind a target leaves a car 9 s behind in town. So the
//! driver model of [`Driver`] follows with the time headway and the gap at standstill of `[controller]`.
//! [`SafeGap`] has the last word.

use super::settings::{CAR_MOST_MPS2, CarGap, REQUESTS_MPS2};
use super::target_filter::Estimate;
use crate::following::driver::{Driver, Obstacle};
use crate::following::kinematics::{Lag, Motion};
use crate::following::safe_gap::{LeadNow, SafeGap};
use crate::following::soft_stop::{Room, soften, within_set_speed};
use crate::law::{Input, Output};

/// Comfortable braking of a car, m/s² (ISO 15622: less than 3.5 at all speeds). Chosen: as the other laws.
const COMFORT_MPS2: f64 = -2.0;
/// Gap that is never given up knowingly, m, and the way beyond it that a soft stop may take.
const CAR_GAP_M: f64 = 2.0;
const SOFT_M: f64 = 1.0;

/// Fall of the request while gentle braking is enough, m/s³ (ISO 15622: at most 5 at low speeds). Chosen: behind the
/// car's lag the jerk stays below 5 m/s³.
const JERK_MPS3: f64 = 5.0;

/// Replaces the truck's request by that of a car that drives at `desired_mps` at most; `before_mps2` is the last one.
pub fn drive(
    car: &CarGap,
    before_mps2: Option<f64>,
    input: &Input,
    target: Option<&Estimate>,
    desired_mps: f64,
    output: &mut Output,
) -> f64 {
    let speed_mps = input.ego.speed_mps;
    let ego = Motion { position_m: 0.0, speed_mps, acceleration_mps2: input.ego.acceleration_mps2 };
    let driver = Driver {
        acceleration_mps2: CAR_MOST_MPS2,
        deceleration_mps2: -COMFORT_MPS2,
        hardest_mps2: -REQUESTS_MPS2.0,
    };
    let wanted = match target {
        None => driver.free_mps2(speed_mps, desired_mps),
        Some(target) => {
            let lead = Obstacle {
                gap_m: target.gap_m,
                speed_mps: (speed_mps + target.relative_speed_mps).max(0.0),
                acceleration_mps2: target.acceleration_mps2,
                headway_s: car.headway_s,
                standstill_m: car.standstill_m,
            };
            driver.follow_mps2(speed_mps, desired_mps, &lead)
        }
    };
    let mut request = within_set_speed(wanted, desired_mps);
    let lag = Lag { tau_s: car.lag_s };
    let mut room = Room::FREE;
    // The filter is late when a lead brakes: what was measured counts for safety.
    let lead = input.target.filter(|t| t.gap_m.is_finite() && t.relative_speed_mps.is_finite());
    if let Some(measured) = lead {
        let lead = LeadNow {
            gap_m: measured.gap_m,
            speed_mps: (speed_mps + measured.relative_speed_mps).max(0.0),
            acceleration_mps2: measured.acceleration_mps2.clamp(-15.0, 15.0),
        };
        let period_s = input.period_s.clamp(0.05, 1.0);
        let bounds = (REQUESTS_MPS2.0, COMFORT_MPS2);
        let kept_m = CAR_GAP_M + SOFT_M;
        let safe = SafeGap::new(lag, period_s, bounds, kept_m, car.lead_deceleration_mps2);
        request = safe.apply(request, ego, &lead);
        if let Some(before_mps2) = before_mps2
            && safe.enough_mps2(ego, &lead).is_some()
        {
            request = request.max(before_mps2 - JERK_MPS3 * period_s);
        }
        room = Room { wanted_m: lead.room_m(kept_m), spare_m: SOFT_M };
    }
    request = soften(request, ego, lag.tau_s, room).clamp(REQUESTS_MPS2.0, CAR_MOST_MPS2);
    output.plan_mps2[0] = request;
    for later in &mut output.plan_mps2[1..output.plan_len] {
        *later = later.min(request.max(COMFORT_MPS2));
    }
    request
}
