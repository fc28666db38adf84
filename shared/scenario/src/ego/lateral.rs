//! `[plant.lateral]`: how the ego moves across a road with a plan.

use scenario_derive::tables;

use crate::quantity::{
    AngularFrequency, Damping, DelayMs, Inertia, InnerShare, Length, Sigma, SlipCompliance, Time,
    TimeConstant, Understeer,
};

tables! {
    /// The ego's motion across the road, its driver's steering and its yaw-rate sensor.
    #[derive(Copy)]
    pub struct Lateral {
        /// Model of the motion.
        pub model: LateralModel = default,
        /// Distance of the axles, m; a truck's: 5.8 when absent.
        pub wheelbase_m: Length = 2.7,
        /// Distance of the centre of gravity behind the front axle, as a share of the wheelbase.
        pub cg_share: InnerShare = 0.5,
        /// Moment of inertia about the vertical axis, kg m². For a truck it is its mass times the square of half its
        /// wheelbase if absent.
        pub yaw_inertia_kgm2: Inertia = 2500.0,
        /// Slip angle of the rear axle by lateral acceleration, rad per m/s².
        pub slip_rad_per_mps2: SlipCompliance = 0.0055,
        /// Slip angle of the front axle minus that of the rear axle by lateral acceleration, rad per m/s².
        pub understeer_rad_per_mps2: Understeer = 0.0035,
        /// The driver who steers.
        pub driver: Driver = default,
        /// The yaw-rate sensor.
        pub yaw_rate: YawRateSensor = default,
    }

    /// Model of the motion across the road.
    pub enum LateralModel {
        /// The linear single track, steered by a driver.
        #[default]
        SingleTrack,
        /// The middle of the front bumper follows the axis exactly; the body has the tangent's heading.
        OnAxis,
    }

    /// A driver who keeps the lane: a second-order law on the offset from a place in the lane that wanders.
    #[derive(Copy)]
    pub struct Driver {
        /// Time by which the driver sees the curvature ahead, s.
        pub lead_s: Time = 0.15,
        /// Natural frequency of the correction of an offset, rad/s.
        pub frequency_radps: AngularFrequency = 1.0,
        /// Damping of that correction.
        pub damping: Damping = 0.9,
        /// Standard deviation of the place in the lane that the driver aims at, m; 0: none.
        pub wander_m: Sigma = 0.2,
        /// Correlation time of that place, s.
        pub wander_s: TimeConstant = 3.0,
    }

    /// Errors of the yaw-rate sensor.
    #[derive(Copy)]
    pub struct YawRateSensor {
        /// Standard deviation of the offset, which is drawn once a run, degrees per second.
        pub offset_sigma_dps: Sigma = 0.1,
        /// Standard deviation of the noise of each sample, degrees per second.
        pub noise_dps: Sigma = 0.1,
        /// Time constant of its lag, ms.
        pub lag_ms: DelayMs = 20,
    }
}

impl Lateral {
    /// Gives a truck's values to keys that were not written. They are 5.8 m from the front axle to the middle of the
    /// rear ones, and an inertia of `mass_kg` half a wheelbase away.
    pub(crate) fn follow_truck(&mut self, mass_kg: f64, is_written: impl Fn(&str) -> bool) {
        if !is_written("plant.lateral.wheelbase_m") {
            self.wheelbase_m = Length::of(5.8);
        }
        if !is_written("plant.lateral.yaw_inertia_kgm2") {
            let arm_m = 0.5 * self.wheelbase_m.value();
            self.yaw_inertia_kgm2 =
                Inertia::try_from(mass_kg * arm_m * arm_m).unwrap_or(self.yaw_inertia_kgm2);
        }
    }
}
