//! A car under the truck's law: a safe gap and a soft stop.

use super::settings::{CarGap, REQUESTS_MPS2};
use crate::following::kinematics::{Lag, Motion};
use crate::following::safe_gap::{LeadNow, SafeGap};
use crate::following::soft_stop::{Room, soften};
use crate::law::{Input, Output};

/// Comfortable braking of a car, m/s², and the gap that it never gives up knowingly, m.
const COMFORT_MPS2: f64 = -2.0;
const CAR_GAP_M: f64 = 2.0;

/// The last word on a car's request: a safe gap and a soft stop.
pub fn keep_car_safe(car: &CarGap, input: &Input, output: &mut Output) {
    let (speed_mps, acceleration_mps2) = (input.ego.speed_mps, input.ego.acceleration_mps2);
    let ego = Motion { position_m: 0.0, speed_mps, acceleration_mps2 };
    let lead = input.target.filter(|t| t.gap_m.is_finite() && t.relative_speed_mps.is_finite());
    let lead = lead.map(|t| LeadNow {
        gap_m: t.gap_m,
        speed_mps: (speed_mps + t.relative_speed_mps).max(0.0),
        acceleration_mps2: t.acceleration_mps2.clamp(-15.0, 15.0),
    });
    let lag = Lag { tau_s: car.lag_s };
    let bounds = (REQUESTS_MPS2.0, COMFORT_MPS2);
    let wanted = output.request_mps2();
    let mut request = wanted;
    let mut room = Room::FREE;
    if let Some(lead) = &lead {
        let period_s = input.period_s.clamp(0.05, 1.0);
        let safe = SafeGap::new(lag, period_s, bounds, CAR_GAP_M, car.lead_deceleration_mps2);
        request = safe.apply(request, ego, lead);
        room = Room { wanted_m: lead.room_m(CAR_GAP_M), spare_m: 0.5 * CAR_GAP_M };
    }
    request = soften(request, ego, lag.tau_s, room);
    if request != wanted {
        output.plan_mps2[0] = request;
        for later in &mut output.plan_mps2[1..output.plan_len] {
            *later = later.min(request.max(COMFORT_MPS2));
        }
    }
}
