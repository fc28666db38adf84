//! `[aebs]`: the advanced emergency braking system and the brakes that it acts on.

use scenario_derive::tables;

use crate::quantity::{AccelerationMagnitude, DelayMs, Distance, JerkMagnitude, Time};

/// Least deceleration that an emergency brake must have, m/s² (UN R152, paragraph 5.2.1.4).
pub const LEAST_DECELERATION_MPS2: f64 = 5.0;

tables! {
    /// The emergency brake: a process of its own that reads the radar's detections, and its brake path in the plant. A
    /// truck's air brakes have other defaults than a car's.
    #[derive(Copy)]
    pub struct Aebs {
        /// True if it is on; absent: on where the radar gives detections.
        pub enabled: Option<bool>,
        /// Time from its request until the deceleration begins to grow, ms; absent on a truck: 300.
        pub dead_time_ms: DelayMs = 100,
        /// Growth of the deceleration, m/s³; absent on a truck: 10.
        pub jerk_mps3: JerkMagnitude = 12.65,
        /// Largest deceleration, m/s²; absent on a truck: 5.5.
        pub deceleration_mps2: AccelerationMagnitude = 8.34,
        /// Distance to be left to what it brakes for, m; absent on a truck: 3.
        pub margin_m: Distance = 0.8,
        /// Time by which the warning comes before the braking, where there is time, s.
        pub warning_s: Time = 0.8,
        /// Longest time over which a vehicle's lateral motion is carried on, s.
        pub lateral_horizon_s: Time = 3.0,
        /// Deadline of its cycle after the scheduled release, ms.
        pub deadline_ms: DelayMs = 50,
    }
}

impl Aebs {
    /// Takes a loaded truck's values for the keys that are not written.
    ///
    /// Chosen: air brakes answer later than hydraulic ones. UN R13 (annex 6) allows 0.6 s from the pedal to 75 % of the
    /// pressure. With these values 75 % of the deceleration is reached after 0.71 s.
    pub(crate) fn follow_truck(&mut self, is_written: impl Fn(&str) -> bool) {
        if !is_written("aebs.dead_time_ms") {
            self.dead_time_ms = DelayMs::of(300);
        }
        if !is_written("aebs.jerk_mps3") {
            self.jerk_mps3 = JerkMagnitude::of(10.0);
        }
        if !is_written("aebs.deceleration_mps2") {
            self.deceleration_mps2 = AccelerationMagnitude::of(5.5);
        }
        if !is_written("aebs.margin_m") {
            self.margin_m = Distance::of(3.0);
        }
    }
}
