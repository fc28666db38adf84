//! `[controller.curve_speed]`: a cap on the set speed before and in curves.

use scenario_derive::tables;

use crate::quantity::AccelerationMagnitude;

tables! {
    /// Slower driving in curves of a road with a plan.
    #[derive(Copy)]
    pub struct CurveSpeed {
        /// True if the set speed is capped.
        pub enabled: bool = true,
        /// Lateral acceleration that the cap keeps, m/s².
        pub comfort_mps2: Comfort = default,
        /// Deceleration with which the speed falls before a curve, m/s².
        pub braking_mps2: AccelerationMagnitude = 1.0,
    }

    /// Lateral acceleration by speed: `slow` up to 17 m/s, `fast` from 32 m/s on, between them in proportion.
    #[derive(Copy)]
    pub struct Comfort {
        /// Up to 17 m/s, m/s².
        pub slow: AccelerationMagnitude = 2.3,
        /// From 32 m/s on, m/s².
        pub fast: AccelerationMagnitude = 2.0,
    }
}
