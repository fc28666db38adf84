//! An explicit car follower: a comfortable driver, kept at a safe gap, that stops softly.
//!
//! It needs no solver and no certificate, and has an answer for every state. So a law that leaves its own
//! range can hand over to it.

use super::driver::{Driver, Obstacle};
use super::kinematics::{Lag, Motion};
use super::safe_gap::{LeadNow, SafeGap};
use super::soft_stop::{Room, soften, within_set_speed};

/// Parameters of a follower.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Follower {
    pub(crate) driver: Driver,
    pub(crate) lag: Lag,
    /// Time headway, s.
    pub(crate) headway_s: f64,
    /// Gap at standstill, m.
    pub(crate) standstill_m: f64,
    /// Smallest gap that is accepted, m.
    pub(crate) min_gap_m: f64,
    /// Hardest assumed deceleration of the vehicle ahead, m/s².
    pub(crate) lead_deceleration_mps2: f64,
}

impl Follower {
    /// The request for the next period, m/s².
    pub(crate) fn request(
        &self,
        ego: Motion,
        lead: Option<&LeadNow>,
        desired_mps: f64,
        period_s: f64,
    ) -> f64 {
        let driver = &self.driver;
        let Some(lead) = lead else {
            let free = driver.free_mps2(ego.speed_mps, desired_mps);
            let free = within_set_speed(free, desired_mps);
            return soften(free, ego, self.lag.tau_s, Room::FREE);
        };
        let obstacle = Obstacle {
            gap_m: lead.gap_m,
            speed_mps: lead.speed_mps,
            acceleration_mps2: lead.acceleration_mps2,
            headway_s: self.headway_s,
            standstill_m: self.standstill_m,
        };
        let wanted = driver.follow_mps2(ego.speed_mps, desired_mps, &obstacle);
        let bounds = (-driver.hardest_mps2, -driver.deceleration_mps2);
        let reckoned = self.lead_deceleration_mps2;
        let safe = SafeGap::new(self.lag, period_s, bounds, self.min_gap_m, reckoned);
        let request = safe.apply(within_set_speed(wanted, desired_mps), ego, lead);
        let wanted_m = lead.room_m(self.min_gap_m);
        let room = Room { wanted_m, spare_m: 0.5 * self.min_gap_m };
        soften(request, ego, self.lag.tau_s, room)
    }
}
