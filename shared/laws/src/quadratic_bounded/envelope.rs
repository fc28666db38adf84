//! Region in which the certificate holds, and the fall-back that drives elsewhere.
//!
//! | the law drives while | it hands over when |
//! |---|---|
//! | V of the lead that it follows is at most 1; with printed gains, the urgency | it is above 1.05 |
//! | the speed is between those of the two rules, and the lead's not below | it is not |
//! | the lead brakes within the design's bound | it brakes harder by 0.1 m/s² |
//!
//! The fall-back is an explicit follower of the parts in [`law::following`], with the design's desired gap and brakes of its own.
//! The certificate's bound on the request is one of comfort only. The law takes over again when all of
//! it has held for a second with a margin. Its controller state is reset.

use super::model::Parameters;
use law::following::driver::Driver;
use law::following::kinematics::{Lag, Motion};
use law::following::safe_gap::{LeadNow, SafeGap};
use law::following::soft_stop::{Room, soften, within_set_speed};

/// Excess at which the law hands over.
const LEAVES_AT: f64 = 1.05;
/// Excess below which it may take over again.
const RETURNS_AT: f64 = 0.9;
/// Margin on the speeds before it takes over again, m/s.
const SPEED_MARGIN_MPS: f64 = 0.5;
/// Braking of the lead beyond the bound at which the law hands over, m/s²: the tracker's noise.
const LEAD_MARGIN_MPS2: f64 = 0.1;
/// Time for which all must hold before the law takes over again, s.
const PROOF_S: f64 = 1.0;
/// Comfortable acceleration and deceleration of the fall-back, m/s².
const COMFORT_MPS2: (f64, f64) = (1.5, 2.0);
/// Gap that the fall-back never gives up knowingly, m.
const MIN_GAP_M: f64 = 2.0;

/// State that decides between law and fall-back.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    /// V of the state on which the law would act, or the urgency of the printed gains. The range ends at 1.
    pub(super) excess: f64,
    /// The same from a reset controller state.
    pub(super) excess_after_reset: f64,
    pub(super) speed_mps: f64,
    /// Speed of the lead, m/s, infinite without one.
    pub(super) lead_mps: f64,
    /// Acceleration of the lead, m/s², 0 without one.
    pub(super) lead_mps2: f64,
}

/// Driver: law or fall-back.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Envelope {
    outside: bool,
    /// Time for which all has held since, s.
    inside_s: f64,
}

impl Envelope {
    /// Takes the state of one sample of `period_s`; true while the fall-back drives.
    pub(super) fn is_left(&mut self, p: &Parameters, state: &State, period_s: f64) -> bool {
        let (low, high) = (p.least_speed_mps, p.greatest_speed_mps);
        let braking = -state.lead_mps2;
        if !self.outside {
            let holds = state.excess <= LEAVES_AT
                && (low..=high).contains(&state.speed_mps)
                && state.lead_mps >= low
                && braking <= p.lead_acceleration_mps2 + LEAD_MARGIN_MPS2;
            *self = Self { outside: !holds, inside_s: 0.0 };
            return self.outside;
        }
        let holds = state.excess_after_reset <= RETURNS_AT
            && (low + SPEED_MARGIN_MPS..=high - SPEED_MARGIN_MPS).contains(&state.speed_mps)
            && state.lead_mps >= low + SPEED_MARGIN_MPS
            && braking <= p.lead_acceleration_mps2;
        self.inside_s = if holds { self.inside_s + period_s } else { 0.0 };
        // Sums of periods are not exact.
        self.outside = self.inside_s < PROOF_S - 1e-9;
        self.outside
    }
}

/// The fall-back's request, m/s²: a comfortable driver, kept at a safe gap, that stops softly. It has an answer for every
/// state. `braking_mps2` are its own hardest braking and the one that is assumed of the lead.
pub(super) fn fall_back_mps2(
    p: &Parameters,
    braking_mps2: (f64, f64),
    ego: Motion,
    lead: Option<&LeadNow>,
    desired_mps: f64,
) -> f64 {
    let driver = Driver {
        acceleration_mps2: COMFORT_MPS2.0,
        deceleration_mps2: COMFORT_MPS2.1,
        hardest_mps2: braking_mps2.0,
    };
    let Some(lead) = lead else {
        let free = driver.free_mps2(ego.speed_mps, desired_mps);
        return soften(within_set_speed(free, desired_mps), ego, p.actuator_lag_s, Room::FREE);
    };
    let headway_s = p.gap_slope_s + p.gap_curvature_s2pm * ego.speed_mps;
    let obstacle = lead.obstacle(headway_s, p.gap_constant_m);
    let wanted = driver.follow_mps2(ego.speed_mps, desired_mps, &obstacle);
    let lag = Lag { tau_s: p.actuator_lag_s };
    let bounds = (-braking_mps2.0, -COMFORT_MPS2.1);
    let safe = SafeGap::new(lag, p.sample_time_s, bounds, MIN_GAP_M, braking_mps2.1);
    let request = safe.apply(within_set_speed(wanted, desired_mps), ego, lead);
    let room = Room { wanted_m: lead.room_m(MIN_GAP_M), spare_m: 0.5 * MIN_GAP_M };
    soften(request, ego, lag.tau_s, room)
}

#[cfg(test)]
mod tests {
    use super::*;

    const INSIDE: State = State {
        excess: 0.5,
        excess_after_reset: 0.4,
        speed_mps: 20.0,
        lead_mps: 20.0,
        lead_mps2: 0.0,
    };

    #[test]
    fn each_condition_ends_the_laws_range_at_once() {
        let p = Parameters::default();
        let outside = [
            State { excess: 1.1, ..INSIDE },
            State { speed_mps: 4.9, ..INSIDE },
            State { speed_mps: 36.1, ..INSIDE },
            State { lead_mps: 4.9, ..INSIDE },
            State { lead_mps2: -2.1, ..INSIDE },
        ];
        for state in outside {
            let mut envelope = Envelope::default();
            assert!(!envelope.is_left(&p, &INSIDE, 0.1));
            assert!(envelope.is_left(&p, &state, 0.1), "{state:?}");
        }
    }

    #[test]
    fn the_law_returns_after_a_second_within_its_range() {
        let p = Parameters::default();
        let mut envelope = Envelope::default();
        assert!(envelope.is_left(&p, &State { lead_mps2: -6.0, ..INSIDE }, 0.1));
        let returns = (1..50).find(|_| !envelope.is_left(&p, &INSIDE, 0.1));
        assert_eq!(returns, Some(10));
    }
}
