//! Keys of the law in a scenario. `tables` says how the effects in the origins of the numbers were measured.

mod tables;

use law::settings::{self, Number};
use parameters::parameters;
use scenario::schema::Schema;
use serde::{Deserialize, Serialize};
use truck_model::{Parameters, Truck};

pub use tables::{BoundKeys, FilterKeys, FollowKeys, GapKeys, PlanKeys, RoadKeys, TruckKeys};

/// Least and largest request of the law, m/s².
pub(super) const REQUESTS_MPS2: (f64, f64) = (-6.5, 1.5);

/// Planner that drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum PlannerKind {
    /// Receding-horizon dynamic programming.
    #[default]
    DynamicProgramming,
    /// The published scheme.
    PaperN2,
    /// None: a PI control of the set speed, the baseline of all savings.
    ConstantSpeed,
}

impl PlannerKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::DynamicProgramming, Self::PaperN2, Self::ConstantSpeed];

    /// Name in scenarios and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::DynamicProgramming => "dynamic-programming",
            Self::PaperN2 => "paper-n2",
            Self::ConstantSpeed => "constant-speed",
        }
    }

    /// Keys of the law's table that this planner does not use.
    pub(super) fn unused(self) -> &'static [&'static str] {
        // Those of every planner first, then those of `paper-n2` alone.
        const OF_PLANS: [&str; 7] = [
            "road.horizon_m",
            "plan.terminal_square",
            "plan.time_price",
            "road.uphill_grade",
            "road.downhill_grade",
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

/// Brakes that may slow the truck down beside its engine's drag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum Brakes {
    /// Nothing, as published: the law commands engine torque, from drag to full load.
    None,
    /// The engine brake.
    Engine,
    /// The service brakes as well.
    #[default]
    Service,
}

parameters! {
    /// The law's table, `[controller.predictive]`.
    #[derive(Copy, Deserialize, Serialize, Schema)]
    #[serde(deny_unknown_fields, default)]
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

/// Settings of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The law's model of the truck.
    pub truck: Truck,
    /// Settings of a scenario.
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
            auxiliary_power_w: self.auxiliary_power_w.unwrap_or(p.auxiliary_power_w),
            engine_scale: self.engine_scale.unwrap_or(p.engine_scale),
            ..*p
        })
    }
}
