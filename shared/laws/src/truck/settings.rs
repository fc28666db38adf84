//! Keys of the law in a scenario: the symbols of the paper's equations, by the part of the law that reads them.
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

use law::settings::{self, Number};
use scenario::schema::tables;
use truck_model::{Parameters, Truck};

/// Least and largest request of the law, m/s².
pub(super) const REQUESTS_MPS2: (f64, f64) = (-6.5, 1.5);

tables! {
    /// Planner that drives.
    pub enum PlannerKind {
        /// Receding-horizon dynamic programming.
        #[default]
        DynamicProgramming,
        /// The published scheme.
        PaperN2,
        /// None: a PI control of the set speed, the baseline of all savings.
        ConstantSpeed,
    }

    /// Brakes that may slow the truck down beside its engine's drag.
    pub enum Brakes {
        /// Nothing, as published: the law commands engine torque, from drag to full load.
        None,
        /// The engine brake.
        Engine,
        /// The service brakes as well.
        #[default]
        Service,
    }
}

impl PlannerKind {
    /// Keys of the law's table that this planner does not use.
    pub(super) fn unused(self) -> &'static [&'static str] {
        // Those of every planner first, then those of `paper-n2` alone.
        const OF_PLANS: [&str; 5] = [
            "road.horizon_m",
            "plan.terminal_square",
            "plan.time_price",
            "plan.segments",
            "plan.torque_levels",
        ];
        match self {
            Self::DynamicProgramming => &OF_PLANS[3..],
            Self::PaperN2 => &[],
            Self::ConstantSpeed => &OF_PLANS,
        }
    }

    /// Price of time, relative to the flat's, at which a truck keeps its mean speed over hills. The servo corrects its
    /// error.
    pub(super) fn usual_time_price(self) -> f64 {
        match self {
            Self::DynamicProgramming | Self::ConstantSpeed => 1.3,
            Self::PaperN2 => 1.6,
        }
    }
}

law::settings! {
    /// The law's table, `[controller.predictive]`.
    #[derive(Copy)]
    pub struct Keys {
        /// Mean speed to keep on a free road, relative to the set speed.
        mean_speed: f64 = 1.0, "1", 0.8..=1.2, "At 0.8: rms jerk -6 %, fuel -15.7 %.";
        others {
            /// Planner that drives.
            planner: PlannerKind = PlannerKind::default();
            /// Brakes that the law may use; `none` is the paper's: torque from drag to full load alone.
            brakes: Brakes = Brakes::default();
            /// Gap and modes (14) to (16).
            gap: GapKeys = GapKeys::DEFAULT;
            /// Speed and acceleration behind a target (17), (18).
            follow: FollowKeys = FollowKeys::DEFAULT;
            /// Bounds of a plan (step 3).
            bounds: BoundKeys = BoundKeys::DEFAULT;
            /// Road ahead and its reconstruction (steps 1, 2).
            road: RoadKeys = RoadKeys::DEFAULT;
            /// Rolling optimisation (steps 4 to 6).
            plan: PlanKeys = PlanKeys::DEFAULT;
            /// Filter of the radar's target.
            filter: FilterKeys = FilterKeys::DEFAULT;
            /// The truck as the law assumes it (19) to (22).
            truck: TruckKeys = TruckKeys::DEFAULT;
        }
    }
}

impl settings::Settings for Keys {
    fn numbers(&self) -> Vec<Number> {
        [
            Number::of("", self),
            Number::of("gap.", &self.gap),
            Number::of("follow.", &self.follow),
            Number::of("bounds.", &self.bounds),
            Number::of("road.", &self.road),
            Number::of("plan.", &self.plan),
            Number::of("filter.", &self.filter),
            Number::of("truck.", &self.truck),
        ]
        .concat()
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    pub truck: Truck,
    pub keys: Keys,
}

impl Settings {
    /// Settings for a truck whose mean speed is to be its set speed.
    pub fn new(truck: &Truck, planner: PlannerKind) -> Self {
        Self { truck: *truck, keys: Keys { planner, ..Keys::default() } }
    }

    /// Settings of the keys for a truck that they describe in part.
    pub fn of_keys(truck: &Truck, keys: &Keys) -> Self {
        Self { truck: keys.truck.believed(truck), keys: *keys }
    }
}

impl TruckKeys {
    /// The truck, with the keys laid over it.
    fn believed(&self, truck: &Truck) -> Truck {
        let p = truck.parameters();
        Truck::new(Parameters {
            mass_kg: self.mass_kg.unwrap_or(p.mass_kg),
            rolling_resistance: self.rolling_resistance.unwrap_or(p.rolling_resistance),
            drag_area_m2: self.drag_area_m2.unwrap_or(p.drag_area_m2),
            final_drive: self.final_drive.unwrap_or(p.final_drive),
            driveline_efficiency: self.driveline_efficiency.unwrap_or(p.driveline_efficiency),
            wheel_radius_m: self.wheel_radius_m.unwrap_or(p.wheel_radius_m),
            wheel_inertia_kgm2: self.wheel_inertia_kgm2.unwrap_or(p.wheel_inertia_kgm2),
            ..*p
        })
    }
}

law::settings! {
    /// The gap that is kept, and the mode that it puts the law in: equations (14) to (16).
    pub struct GapKeys {
        /// Time headway tau behind the target, s (14).
        time_headway_s: f64 = 1.8, "s", 0.3..=5.0,
            "At 0.9: least gap -20 %, hardest braking +4 %, rms jerk +15 %, fuel +1.9 %. At 3.6: least gap +11 %, \
             hardest braking -9 %, fuel -0.2 %.";
        /// Least gap d_0 when both stand, m (14).
        standstill_distance_m: f64 = 5.0, "m", 1.0..=20.0,
            "At 2.5: rms jerk +36 %, fuel +0.2 %, service brake -3 %; at 10: hardest braking -4 %, fuel -2.1 %.";
        /// Offset d_s of the desired gap, m (14).
        offset_m: f64 = 10.0, "m", 0.0..=50.0,
            "At 5: fuel +0.3 %; at 20: least gap +3 %, hardest braking -10 %, fuel -1.8 %.";
        /// Slope coefficient k_u: what the desired gap loses per uphill grade of 1, m (14).
        uphill_m: f64 = 250.0, "m", 0.0..=2000.0, "At 125: no change; at 500: fuel -0.5 %.";
        /// Slope coefficient k_d: what the desired gap gains per downhill grade of 1, m (14).
        downhill_m: f64 = 500.0, "m", 0.0..=2000.0,
            "At 250: fuel +0.2 %; at 1000: hardest braking -4 %, rms jerk -2 %, fuel -1.0 %.";
        /// Length from the target on over which its grade is averaged, m (inferred: the paper takes the target's place).
        slope_length_m: f64 = 300.0, "m", 10.0..=1500.0, "At 150: no change; at 600: fuel -0.2 %.";
        /// Buffer above the desired gap, up to d_max, m (15).
        above_m: f64 = 15.0, "m", 0.0..=100.0, "At 7.5: fuel -0.8 %; at 30: fuel -1.5 %.";
        /// Buffer below the desired gap, down to d_min, m (15).
        below_m: f64 = 12.0, "m", 0.0..=100.0, "At 6: hardest braking -5 %, fuel -0.9 %; at 24: no change.";
        /// Deceleration with drag alone, by which a collision is at risk, m/s² (inferred).
        drag_mps2: f64 = 0.08, "m/s²", 0.01..=0.5, "At 0.04: fuel +0.5 %; at 0.16: no change.";
        /// A target is let go this far beyond d_max, m (inferred).
        hysteresis_m: f64 = 3.0, "m", 0.0..=30.0, "At 1.5: no change; at 6: fuel -0.1 %.";
        /// Gap that stands for no target, m. A target farther away by more than its noise does not count (16).
        no_target_m: f64 = 200.0, "m", 50.0..=1000.0, "At 100: rms jerk -11 %, fuel -1.0 %; at 400: no change.";
    }

    /// Speed and acceleration behind a target: equations (17) and (18), whose control law is inferred.
    pub struct FollowKeys {
        /// A target that is farther than this beyond d_max may be approached, m (inferred; 17).
        approach_from_m: f64 = 60.0, "m", 0.0..=1000.0,
            "At 30: rms jerk -11 %, fuel -0.3 %; at 120: fuel -1.6 %.";
        /// Speed at which it may be approached, m/s (inferred; 0: the paper's minimum of both speeds; 17).
        approach_mps: f64 = 1.0, "m/s", 0.0..=5.0, "At 0.5: fuel -0.7 %; at 2: fuel +0.6 %.";
        /// Mode 1: acceleration per speed error, 1/s.
        free_per_s: f64 = 0.12, "1/s", 0.01..=2.0, "At 0.06: fuel +0.7 %; at 0.24: fuel -0.9 %.";
        /// Mode 1: least acceleration, m/s².
        free_min_mps2: f64 = -0.3, "m/s²", -3.0..=0.0, "At -0.15: fuel +0.5 %; at -0.6: no change.";
        /// Mode 2 inside the band: acceleration per speed error, 1/s.
        inside_per_s: f64 = 0.15, "1/s", 0.01..=2.0,
            "At 0.075: least gap -4 %, fuel -0.4 %; at 0.3: fuel +0.2 %.";
        /// Mode 2: the slight pull towards the desired gap, 1/s².
        pull_per_s2: f64 = 0.0012, "1/s²", 0.0..=0.1, "At 0.0006: fuel +0.4 %; at 0.0024: fuel -1.3 %.";
        /// Mode 2 outside the band: acceleration per speed error, 1/s.
        outside_per_s: f64 = 0.35, "1/s", 0.01..=2.0, "At 0.175: fuel -0.2 %; at 0.7: fuel -0.1 %.";
        /// Mode 2 outside the band: acceleration per metre outside, 1/s².
        outside_per_s2: f64 = 0.02, "1/s²", 0.0..=0.5, "At 0.01: no change; at 0.04: fuel -0.2 %.";
        /// Needed deceleration from which the service brakes are used, m/s².
        brake_from_mps2: f64 = 0.6, "m/s²", 0.0..=6.0,
            "At 0.3: no change; at 1.2: hardest braking +2 %, rms jerk +6 %.";
    }

    /// The bounds of a plan: step 3.
    pub struct BoundKeys {
        /// Highest speed v_max above the set speed, km/h; the road's limit holds as well.
        above_set_kmh: f64 = 5.0, "km/h", 0.0..=30.0,
            "At 2.5: hardest braking +2 %, rms jerk +4 %, fuel -3.5 %; at 10: fuel +1.6 %.";
        /// Lowest speed v_min below the set speed, km/h, where the truck can hold it.
        below_set_kmh: f64 = 13.0, "km/h", 0.0..=40.0, "At 6.5: fuel -0.9 %; at 26: no change.";
        /// Least acceleration a_min that a plan's torque may give, m/s², where the engine can.
        min_acceleration_mps2: f64 = -0.5, "m/s²", -3.0..=0.0, "No change at -0.25 and -1.";
        /// Largest acceleration a_max that a plan's torque may give, m/s², where the engine can.
        max_acceleration_mps2: f64 = 0.3, "m/s²", 0.0..=3.0, "At 0.15: fuel +0.2 %; at 0.6: no change.";
        /// Least torque T_min as a share of the drag torque.
        drag_share: f64 = 1.0, "1", 0.0..=1.0, "No change at 0.5.";
        /// Largest torque T_max as a share of full load.
        full_load_share: f64 = 1.0, "1", 0.1..=1.0,
            "At 0.5: hardest braking +4 %, rms jerk +21 %, fuel -7.1 %.";
    }

    /// The road ahead and its reconstruction by `paper-n2`: steps 1 and 2.
    pub struct RoadKeys {
        /// Road ahead that is planned with, m; the map shows no more than 64 of its cells.
        horizon_m: f64 = 2000.0, "m", 400.0..=3200.0,
            "At 1000: rms jerk +4 %, fuel -0.6 %; at 2500: rms jerk +3 %, fuel -2.6 %.";
    }

    /// The rolling optimisation: steps 4 to 6.
    pub struct PlanKeys {
        /// Segments n that `paper-n2` plans.
        segments: u32 = 2, "1", 1.0..=3.0, "Source: the paper plans n = 2.";
        /// Torques that it tries in each, beside those that hold a speed (inferred).
        torque_levels: u32 = 21, "1", 3.0..=101.0, "Inferred.";
        /// Weight q of the square in the terminal cost; absent: 1 for `paper-n2`, 0.5 for `dynamic-programming` (inferred).
        terminal_square: Option<f64> = None, "1", 0.0..=10.0, "Inferred.";
        /// Price of time in the first plan, over the flat's; absent: 1.6 for `paper-n2`, 1.3 else (inferred).
        time_price: Option<f64> = None, "1", 0.5..=5.0, "Inferred.";
    }

    /// The Kalman filter of the radar's target (inferred: the paper says that there is one).
    pub struct FilterKeys {
        /// Time constant of the target's acceleration, s.
        time_constant_s: f64 = 2.5, "s", 0.1..=60.0, "At 1.25: rms jerk -3 %; at 5: rms jerk +6 %.";
        /// Standard deviation of the target's acceleration, m/s².
        acceleration_sigma_mps2: f64 = 0.5, "m/s²", 0.01..=5.0, "At 0.25: rms jerk +5 %; at 1: rms jerk +2 %.";
        /// Standard deviation of the measured gap, m.
        gap_sigma_m: f64 = 0.4, "m", 0.01..=5.0, "No change at 0.2 and 0.8.";
        /// Standard deviation of the measured relative speed, m/s.
        speed_sigma_mps: f64 = 0.15, "m/s", 0.01..=5.0,
            "At 0.075: rms jerk +11 %, fuel +0.2 %; at 0.3: hardest braking +6 %, rms jerk -6 %.";
        /// Standard deviations beyond which a measurement is not used.
        gate: f64 = 5.0, "1", 1.0..=100.0, "At 2.5: hardest braking -3 %, rms jerk +3 %; at 10: rms jerk -6 %.";
    }

    /// The truck as the law assumes it: equations (19) to (22). Absent values are those of `plant.vehicle`.
    pub struct TruckKeys {
        /// Mass m, kg.
        mass_kg: Option<f64> = None, "kg", 3000.0..=100000.0, "Absent: the value of plant.vehicle.";
        /// Rolling resistance coefficient f.
        rolling_resistance: Option<f64> = None, "1", 0.001..=0.05, "Absent: the value of plant.vehicle.";
        /// Air drag area C_D A, m².
        drag_area_m2: Option<f64> = None, "m²", 0.5..=20.0, "Absent: the value of plant.vehicle.";
        /// Ratio of the axle i_0.
        final_drive: Option<f64> = None, "1", 1.0..=8.0, "Absent: the value of plant.vehicle.";
        /// Efficiency eta of gearbox and axle.
        driveline_efficiency: Option<f64> = None, "1", 0.5..=1.0, "Absent: the value of plant.vehicle.";
        /// Dynamic wheel radius r, m.
        wheel_radius_m: Option<f64> = None, "m", 0.2..=1.0, "Absent: the value of plant.vehicle.";
        /// Inertia of all wheels, kg m², which with the engine's gives the rotating-mass factor delta.
        wheel_inertia_kgm2: Option<f64> = None, "kg m²", 0.0..=2000.0, "Absent: the value of plant.vehicle.";
    }
}
