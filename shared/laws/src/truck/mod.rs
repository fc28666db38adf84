//! Predictive cruise for a heavy truck (Li, Zheng, Wang, Wang; FAW Jiefang JH6).
//!
//! Planning and driving are apart, so that planning can run in the background, at any latency:
//!
//! ```text
//!   Input ──► Predictive::step ──► Output
//!                ▲       │ Planning::request
//!                │       ▼
//!                │   PlanRequest ──► Planner::plan ──► Plan
//!                │                                      │
//!                └──────── Planning::accept ◄───────────┘
//! ```
//!
//! The law commands engine torque ([`Output::torque`](::law::Output::torque)). The output also has the
//! accelerations that belong to it, so the gateway has a future to follow.
//!
//! | part | of the paper | module |
//! |---|---|---|
//! | every symbol as a key | | `settings` |
//! | road classes, reconstruction | steps 1, 2 | `road_classes` |
//! | bounds | step 3 | `bounds` |
//! | rolling optimisation, n = 2 | steps 3 to 6 | `paper_n2` |
//! | dynamic programming | the better planner | `dynamic_programming`, `energy_grid`, `gear_curve` |
//! | prices, servo of the mean speed | beta, gamma | `prices` |
//! | gap, modes, accelerations, brakes | (14) to (18) | `following` |
//! | radar filter | | `target_filter` |

mod bounds;
mod dynamic_programming;
pub mod energy_grid;
mod following;
mod gear_curve;
mod law;
mod paper_n2;
mod prices;
mod road_classes;
mod settings;
mod target_filter;
mod tracking;

pub use bounds::{Moment, SpeedKeeper, max_speed_mps, min_speed_mps, speed_band_mps};
pub use dynamic_programming::DynamicProgramming;
pub use following::Spacing;
pub use law::Predictive;
pub use paper_n2::PaperN2;
pub use prices::{Prices, Reference, Speeds};
pub use road_classes::{LimitGrades, Reconstruction};
pub use settings::{
    BoundKeys, Brakes, FilterKeys, FollowKeys, GapKeys, Keys, PlanKeys, PlannerKind, RoadKeys,
    Settings, TruckKeys,
};

use ::law::settings::Table;
use ::law::{Descriptor, Figure, Formulation, GapPolicy, Law, Plan, PlanRequest, Planner, Reader};
use scenario::Problem;
use truck_model::{Preset, Truck};

const TABLE: Table = Table::of::<Keys>("predictive");

pub static PREDICTIVE: Descriptor = Descriptor {
    name: "predictive",
    description: "predictive cruise of a heavy truck over hills (Li, Zheng, Wang, Wang)",
    source: "Li, Zheng, Wang, Wang (FAW Jiefang JH6)",
    table: Some(TABLE),
    formulations: &[&FORMULATION],
    formulation: |_| &FORMULATION,
    gap: GapPolicy::Internal,
    measured_target: true,
    trucks_alone: true,
    build,
};

static FORMULATION: Formulation = Formulation {
    name: "truck",
    caution: None,
    modes: &["cruise", "predictive", "follow", "warn"],
    reasons: &[
        "none",
        "plan",
        "no_plan",
        "map_contradicts",
        "target",
        "target_gone",
        "too_close",
        "bad_input",
    ],
    figures: &[
        Figure::new("economic_speed_mps", "m/s"),
        Figure::new("engine_torque_nm", "N m"),
        Figure::new("gear", "1"),
        Figure::new("time_price", "1"),
        Figure::new("lag_s", "s"),
        Figure::new("filtered_gap_m", "m"),
        Figure::new("service_brake_n", "N"),
        Figure::new("plan_ahead_m", "m"),
    ],
};

const CRUISE: u32 = 0;
const PREDICTIVE_MODE: u32 = 1;
const FOLLOW: u32 = 2;
const WARN: u32 = 3;
const PLAN: u32 = 1;
const NO_PLAN: u32 = 2;
const MAP_CONTRADICTS: u32 = 3;
const TARGET: u32 = 4;
const TARGET_GONE: u32 = 5;
const TOO_CLOSE: u32 = 6;
const BAD_INPUT: u32 = 7;

fn build(reader: &Reader<'_>) -> Result<Box<dyn Law>, Problem> {
    let keys: Keys = reader.table(TABLE.name)?;
    let vehicle = reader.scenario.plant.vehicle;
    let Some(preset) = Preset::named(vehicle.name()) else {
        let message = format!("the law `{}` drives trucks alone", PREDICTIVE.name);
        let trucks = Preset::ALL.map(|truck| format!("`{}`", truck.name())).join(" or ");
        let expected = format!("another law, or {trucks} as plant.vehicle");
        return Err(Problem::new("controller.name", message, expected));
    };
    reader.without(TABLE.name, keys.planner.unused());
    Ok(Box::new(Predictive::new(&Settings::of_keys(&Truck::preset(preset), &keys))))
}

/// The planner of the settings; one that never has a plan for constant speed.
pub fn create(settings: &Settings) -> Box<dyn Planner> {
    match settings.keys.planner {
        PlannerKind::DynamicProgramming => Box::new(DynamicProgramming::new(settings)),
        PlannerKind::PaperN2 => Box::new(PaperN2::new(settings)),
        PlannerKind::ConstantSpeed => Box::new(NoPlan),
    }
}

struct NoPlan;

impl Planner for NoPlan {
    fn plan(&mut self, request: &PlanRequest, plan: &mut Plan) -> bool {
        plan.begin(request);
        false
    }
}
