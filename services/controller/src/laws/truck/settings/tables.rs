//! The symbols of the paper's equations as keys, by the part of the law that reads them.
//!
//! The published text lost its formulas and its table of parameters; it defines every symbol in words. The numbers
//! of the equations are those of its method. Values and the keys marked (inferred) are this project's; a mark on a
//! table holds for all its keys.
//!
//! The comment beside a number is its effect on 120 s of the built-in scenarios `truck-traffic`, `truck-hills`,
//! `truck-follow` and `truck-brake`. "No change" means less than 2 % of four figures: least gap, hardest braking, rms
//! jerk, and time of the service brakes. It also means less than 0.1 % of the fuel, and no collision. Whole numbers and
//! absent ones were not varied.
//!
//! ```sh
//! timegap test plausibility --effects predictive --seeds 104 --only truck
//! timegap sweep truck-hills --vary controller.predictive.KEY=A,B
//! ```
//!
//! The base: least gap 28.3 m, hardest braking 1.08 m/s², rms jerk 0.174 m/s³, fuel 37.6 L/100 km, service brakes for
//! 27.5 s. These are means of the four; there is no collision.

use super::numbers::numbers;

numbers! { "gap",
    /// The gap that is kept, and the mode that it puts the law in: equations (14) to (16).
    pub struct GapKeys {
        /// Time headway tau behind the target, s (14).
        // At 0.9: least gap -20 %, hardest braking +4 %, rms jerk +15 %, fuel +1.9 %. At 3.6: least gap +11 %, hardest
        // braking -9 %, fuel -0.2 %.
        pub time_headway_s: f64 = 1.8, 0.3 to 5.0;
        /// Least gap d_0 when both stand, m (14).
        // At 2.5: rms jerk +36 %, fuel +0.2 %, service brake -3 %; at 10: hardest braking -4 %, fuel -2.1 %.
        pub standstill_distance_m: f64 = 5.0, 1.0 to 20.0;
        /// Offset d_s of the desired gap, m (14).
        // At 5: fuel +0.3 %; at 20: least gap +3 %, hardest braking -10 %, fuel -1.8 %.
        pub offset_m: f64 = 10.0, 0.0 to 50.0;
        /// Slope coefficient k_u: what the desired gap loses per uphill grade of 1, m (14).
        // At 125: no change; at 500: fuel -0.5 %.
        pub uphill_m: f64 = 250.0, 0.0 to 2000.0;
        /// Slope coefficient k_d: what the desired gap gains per downhill grade of 1, m (14).
        // At 250: fuel +0.2 %; at 1000: hardest braking -4 %, rms jerk -2 %, fuel -1.0 %.
        pub downhill_m: f64 = 500.0, 0.0 to 2000.0;
        /// Length from the target on over which its grade is averaged, m (inferred: the paper takes the target's place).
        // At 150: no change; at 600: fuel -0.2 %.
        pub slope_length_m: f64 = 300.0, 10.0 to 1500.0;
        /// Buffer above the desired gap, up to d_max, m (15).
        // At 7.5: fuel -0.8 %; at 30: fuel -1.5 %.
        pub above_m: f64 = 15.0, 0.0 to 100.0;
        /// Buffer below the desired gap, down to d_min, m (15).
        // At 6: hardest braking -5 %, fuel -0.9 %; at 24: no change.
        pub below_m: f64 = 12.0, 0.0 to 100.0;
        /// Least time headway of d_min, s (inferred).
        // No change at 0.4 and 1.6.
        pub least_headway_s: f64 = 0.8, 0.0 to 3.0;
        /// Time headway of d_stop, and least one of the desired gap, s (inferred).
        // No change at 0.5 and 2.
        pub stop_headway_s: f64 = 1.0, 0.0 to 3.0;
        /// Deceleration of both in d_stop, the least gap when both brake to a standstill, m/s² (inferred).
        // No change at 2 and 8.
        pub stopping_mps2: f64 = 4.0, 0.5 to 8.0;
        /// Deceleration with drag alone, by which a collision is at risk, m/s² (inferred).
        // At 0.04: fuel +0.5 %; at 0.16: no change.
        pub drag_mps2: f64 = 0.08, 0.01 to 0.5;
        /// A target is let go this far beyond d_max, m (inferred).
        // At 1.5: no change; at 6: fuel -0.1 %.
        pub hysteresis_m: f64 = 3.0, 0.0 to 30.0;
        /// Gap that stands for no target, m. A target farther away by more than its noise does not count (16).
        // At 100: rms jerk -11 %, fuel -1.0 %; at 400: no change.
        pub no_target_m: f64 = 200.0, 50.0 to 1000.0;
    }
}

numbers! { "follow",
    /// Speed and acceleration behind a target: equations (17) and (18), whose control law is inferred.
    pub struct FollowKeys {
        /// A target that is farther than this beyond d_max may be approached, m (inferred; 17).
        // At 30: rms jerk -11 %, fuel -0.3 %; at 120: fuel -1.6 %.
        pub approach_from_m: f64 = 60.0, 0.0 to 1000.0;
        /// Speed at which it may be approached, m/s (inferred; 0: the paper's minimum of both speeds; 17).
        // At 0.5: fuel -0.7 %; at 2: fuel +0.6 %.
        pub approach_mps: f64 = 1.0, 0.0 to 5.0;
        /// Mode 1: acceleration per speed error, 1/s.
        // At 0.06: fuel +0.7 %; at 0.24: fuel -0.9 %.
        pub free_per_s: f64 = 0.12, 0.01 to 2.0;
        /// Mode 1: least acceleration, m/s².
        // At -0.15: fuel +0.5 %; at -0.6: no change.
        pub free_min_mps2: f64 = -0.3, -3.0 to 0.0;
        /// Mode 1: largest acceleration, m/s².
        // No change at 0.125 and 0.5.
        pub free_max_mps2: f64 = 0.25, 0.0 to 1.5;
        /// Mode 2 inside the band: acceleration per speed error, 1/s.
        // At 0.075: least gap -4 %, fuel -0.4 %; at 0.3: fuel +0.2 %.
        pub inside_per_s: f64 = 0.15, 0.01 to 2.0;
        /// Mode 2: the slight pull towards the desired gap, 1/s².
        // At 0.0006: fuel +0.4 %; at 0.0024: fuel -1.3 %.
        pub pull_per_s2: f64 = 0.0012, 0.0 to 0.1;
        /// Mode 2 outside the band: acceleration per speed error, 1/s.
        // At 0.175: fuel -0.2 %; at 0.7: fuel -0.1 %.
        pub outside_per_s: f64 = 0.35, 0.01 to 2.0;
        /// Mode 2 outside the band: acceleration per metre outside, 1/s².
        // At 0.01: no change; at 0.04: fuel -0.2 %.
        pub outside_per_s2: f64 = 0.02, 0.0 to 0.5;
        /// Mode 2: least acceleration, m/s².
        // No change at -0.4 and -1.6.
        pub follow_min_mps2: f64 = -0.8, -3.0 to 0.0;
        /// Mode 2: largest acceleration, m/s².
        // No change at 0.15 and 0.6.
        pub follow_max_mps2: f64 = 0.3, 0.0 to 1.5;
        /// Mode 3: acceleration behind a target that is at least as fast, m/s².
        // No change at -0.4 and -1.6.
        pub warn_mps2: f64 = -0.8, -3.0 to 0.0;
        /// Mode 3: more of it per closing speed, 1/s.
        // No change at 0.15 and 0.6.
        pub warn_per_s: f64 = 0.3, 0.0 to 2.0;
        /// Mode 3: least acceleration, m/s².
        // No change at -1.25 and -5.
        pub warn_min_mps2: f64 = -2.5, -6.0 to 0.0;
        /// Jerk while the request rises, m/s³.
        // No change at 0.5 and 2.
        pub jerk_up_mps3: f64 = 1.0, 0.1 to 10.0;
        /// Jerk while the request falls, m/s³.
        // No change at 0.75 and 3.
        pub jerk_down_mps3: f64 = 1.5, 0.1 to 10.0;
        /// Needed deceleration from which the service brakes are used, m/s².
        // At 0.3: no change; at 1.2: hardest braking +2 %, rms jerk +6 %.
        pub brake_from_mps2: f64 = 0.6, 0.0 to 6.0;
        /// Needed deceleration below which they are let go, m/s².
        // No change at 0.1 and 0.4.
        pub brake_to_mps2: f64 = 0.2, 0.0 to 6.0;
    }
}

numbers! { "bounds",
    /// The bounds of a plan: step 3.
    pub struct BoundKeys {
        /// Highest speed v_max above the set speed, km/h; the road's limit holds as well.
        // At 2.5: hardest braking +2 %, rms jerk +4 %, fuel -3.5 %; at 10: fuel +1.6 %.
        pub above_set_kmh: f64 = 5.0, 0.0 to 30.0;
        /// Lowest speed v_min below the set speed, km/h, where the truck can hold it.
        // At 6.5: fuel -0.9 %; at 26: no change.
        pub below_set_kmh: f64 = 13.0, 0.0 to 40.0;
        /// Least acceleration a_min that a plan's torque may give, m/s², where the engine can.
        // No change at -0.25 and -1.
        pub min_acceleration_mps2: f64 = -0.5, -3.0 to 0.0;
        /// Largest acceleration a_max that a plan's torque may give, m/s², where the engine can.
        // At 0.15: fuel +0.2 %; at 0.6: no change.
        pub max_acceleration_mps2: f64 = 0.3, 0.0 to 3.0;
        /// Least torque T_min as a share of the drag torque.
        // No change at 0.5.
        pub drag_share: f64 = 1.0, 0.0 to 1.0;
        /// Largest torque T_max as a share of full load.
        // At 0.5: hardest braking +4 %, rms jerk +21 %, fuel -7.1 %.
        pub full_load_share: f64 = 1.0, 0.1 to 1.0;
    }
}

numbers! { "road",
    /// The road ahead and its reconstruction by `paper-n2`: steps 1 and 2.
    pub struct RoadKeys {
        /// Road ahead that is planned with, m; the map shows no more than 64 of its cells.
        // At 1000: rms jerk +4 %, fuel -0.6 %; at 2500: rms jerk +3 %, fuel -2.6 %.
        pub horizon_m: f64 = 2000.0, 400.0 to 3200.0;
        /// Grade from which a cell is uphill; absent: that which full load holds at the set speed.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub uphill_grade: Option<f64> = None, 0.0 to 0.2;
        /// Grade to which a cell is downhill; absent: that which drag holds at the set speed.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub downhill_grade: Option<f64> = None, -0.2 to 0.0;
        /// Stretches shorter than this join a neighbour, m (inferred).
        // No change at 75 and 300.
        pub shortest_m: f64 = 150.0, 50.0 to 1000.0;
        /// Length of the segment of its own before a change of class, m (inferred).
        // No change at 225 and 900.
        pub lead_in_m: f64 = 450.0, 50.0 to 2000.0;
        /// Longest segment before it, m (inferred).
        // No change at 300 and 1200.
        pub longest_m: f64 = 600.0, 100.0 to 3200.0;
    }
}

numbers! { "plan",
    /// The rolling optimisation: steps 4 to 6.
    pub struct PlanKeys {
        /// Segments n that `paper-n2` plans.
        pub segments: u32 = 2, 1.0 to 3.0;
        /// Torques that it tries in each, beside those that hold a speed (inferred).
        pub torque_levels: u32 = 21, 3.0 to 101.0;
        /// Weight q of the square in the terminal cost; absent: 1 for `paper-n2`, 0.5 for `dynamic-programming` (inferred).
        #[serde(skip_serializing_if = "Option::is_none")]
        pub terminal_square: Option<f64> = None, 0.0 to 10.0;
        /// Price of time in the first plan, over the flat's; absent: 1.6 for `paper-n2`, 1.3 else (inferred).
        #[serde(skip_serializing_if = "Option::is_none")]
        pub time_price: Option<f64> = None, 0.5 to 5.0;
        /// Share of full load that `paper-n2` takes uphill at least (inferred).
        // No change at 0.125 and 0.5.
        pub uphill_share: f64 = 0.25, 0.0 to 1.0;
        /// Speed above the set speed from which a coming hill asks for no more torque, m/s (inferred).
        // No change at 0.25 and 1.
        pub before_uphill_mps: f64 = 0.5, 0.0 to 5.0;
        /// Speed below the set speed from which a coming dip asks for no less torque, m/s (inferred).
        // No change at 1 and 4.
        pub before_downhill_mps: f64 = 2.0, 0.0 to 5.0;
        /// Deviation from the plan's speed that asks for a new plan, m/s (inferred).
        // No change at 0.3 and 1.2.
        pub replan_mps: f64 = 0.6, 0.1 to 5.0;
    }
}

numbers! { "filter",
    /// The Kalman filter of the radar's target (inferred: the paper says that there is one).
    pub struct FilterKeys {
        /// Time constant of the target's acceleration, s.
        // At 1.25: rms jerk -3 %; at 5: rms jerk +6 %.
        pub time_constant_s: f64 = 2.5, 0.1 to 60.0;
        /// Standard deviation of the target's acceleration, m/s².
        // At 0.25: rms jerk +5 %; at 1: rms jerk +2 %.
        pub acceleration_sigma_mps2: f64 = 0.5, 0.01 to 5.0;
        /// Standard deviation of the measured gap, m.
        // No change at 0.2 and 0.8.
        pub gap_sigma_m: f64 = 0.4, 0.01 to 5.0;
        /// Standard deviation of the measured relative speed, m/s.
        // At 0.075: rms jerk +11 %, fuel +0.2 %; at 0.3: hardest braking +6 %, rms jerk -6 %.
        pub speed_sigma_mps: f64 = 0.15, 0.01 to 5.0;
        /// Standard deviations beyond which a measurement is not used.
        // At 2.5: hardest braking -3 %, rms jerk +3 %; at 10: rms jerk -6 %.
        pub gate: f64 = 5.0, 1.0 to 100.0;
    }
}

numbers! { "truck",
    /// The truck as the law assumes it: equations (19) to (22). Absent values are those of `plant.vehicle`.
    pub struct TruckKeys {
        /// Mass m, kg.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub mass_kg: Option<f64> = None, 3000.0 to 100000.0;
        /// Rolling resistance coefficient f.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub rolling_resistance: Option<f64> = None, 0.001 to 0.05;
        /// Air drag area C_D A, m².
        #[serde(skip_serializing_if = "Option::is_none")]
        pub drag_area_m2: Option<f64> = None, 0.5 to 20.0;
        /// Ratio of the axle i_0.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub final_drive: Option<f64> = None, 1.0 to 8.0;
        /// Efficiency eta of gearbox and axle.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub driveline_efficiency: Option<f64> = None, 0.5 to 1.0;
        /// Dynamic wheel radius r, m.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub wheel_radius_m: Option<f64> = None, 0.2 to 1.0;
        /// Inertia of all wheels, kg m², which with the engine's gives the rotating-mass factor delta.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub wheel_inertia_kgm2: Option<f64> = None, 0.0 to 2000.0;
        /// Power of the auxiliaries, W (inferred).
        #[serde(skip_serializing_if = "Option::is_none")]
        pub auxiliary_power_w: Option<f64> = None, 0.0 to 20000.0;
        /// Torque and fuel over those of the 12.7 L, 325 kW engine (inferred).
        #[serde(skip_serializing_if = "Option::is_none")]
        pub engine_scale: Option<f64> = None, 0.1 to 3.0;
    }
}
