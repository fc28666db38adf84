//! When a fault begins: at an instant, or by what the ego does and meets.

use messages::EgoTruth;
use scenario_derive::tables;
use serde::{Deserialize, Serialize};

use crate::quantity::{AccelerationMagnitude, Distance, Speed, Time};
use crate::schema::Schema;

/// Start of a fault: a time, or what the ego does and meets.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Begin {
    /// Time of its start, s of run time. Absent: at the start, or by `when`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_s: Option<Time>,
    /// Start by the ego's motion and surroundings. All given conditions must hold at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub when: Option<Condition>,
}

impl Begin {
    /// Run time at which it begins, ns, where that is known beforehand.
    pub fn known_ns(&self) -> Option<i64> {
        let ns = |at_s: Time| i64::try_from(at_s.nanoseconds()).unwrap_or(i64::MAX);
        self.when.is_none().then(|| self.at_s.map_or(0, ns))
    }

    /// True if it begins with the ego driving so.
    pub fn is_met(&self, drive: &EgoTruth) -> bool {
        self.when.is_some_and(|when| when.holds(drive))
    }
}

tables! {
    /// Condition on the drive in which a fault begins.
    #[derive(Copy)]
    pub struct Condition {
        /// The ego is beyond this place, m.
        pub position_above_m: Option<Distance>,
        /// The ego is slower, m/s.
        pub speed_below_mps: Option<Speed>,
        /// The ego is faster, m/s.
        pub speed_above_mps: Option<Speed>,
        /// The ego brakes harder, m/s².
        pub braking_above_mps2: Option<AccelerationMagnitude>,
        /// The time to collision with the vehicle ahead is shorter, s.
        pub ttc_below_s: Option<Time>,
        /// The next stop line is nearer, and its signal shows red, m.
        pub red_line_below_m: Option<Distance>,
        /// A vehicle ahead moves sideways towards the ego's lane, or none does.
        pub cut_in: Option<bool>,
        /// The ego stands, or it does not.
        pub standstill: Option<bool>,
    }
}

/// Below this speed the ego stands, m/s.
pub const STANDSTILL_MPS: f64 = 0.1;

impl Condition {
    /// True if it holds for an ego that drives so.
    pub fn holds(&self, drive: &EgoTruth) -> bool {
        let stands = drive.speed_mps < STANDSTILL_MPS;
        let deceleration_mps2 = -drive.acceleration_mps2;
        self.position_above_m.is_none_or(|limit| drive.position_m > limit.value())
            && self.speed_below_mps.is_none_or(|limit| drive.speed_mps < limit.value())
            && self.speed_above_mps.is_none_or(|limit| drive.speed_mps > limit.value())
            && self.braking_above_mps2.is_none_or(|limit| deceleration_mps2 > limit.value())
            && self.ttc_below_s.is_none_or(|limit| drive.time_to_collision_s < limit.value())
            && self.red_line_below_m.is_none_or(|limit| drive.red_line_m() < limit.value())
            && self.cut_in.is_none_or(|wanted| (drive.cut_in != 0) == wanted)
            && self.standstill.is_none_or(|wanted| stands == wanted)
    }
}
