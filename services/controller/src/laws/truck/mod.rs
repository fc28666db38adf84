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
//! The law commands engine torque ([`Output::torque`](crate::law::Output::torque)). The output also has the
//! accelerations that belong to it, so the gateway has a future to follow.
//!
//! | part | of the paper | module |
//! |---|---|---|
//! | every symbol as a key | | `settings` |
//! | road classes, reconstruction | steps 1, 2 | `road_classes` |
//! | bounds | step 3 | `speed_band`, `torque_bounds` |
//! | rolling optimisation, n = 2 | steps 3 to 6 | `paper_n2` |
//! | dynamic programming | the better planner | `dynamic_programming`, `plan_steps`, `energy_grid`, `beyond` |
//! | servo of the mean speed | beta | `time_price`, `reference` |
//! | gap, modes | (14) to (16) | `spacing` |
//! | accelerations, brakes | (17), (18) | `following` |
//! | radar filter | | `target_filter` |

mod beyond;
mod bounds;
mod dynamic_programming;
pub mod energy_grid;
mod following;
mod formulation;
mod gear_curve;
mod law;
pub mod limiter;
mod map_trust;
mod paper_n2;
mod plan_steps;
mod planners;
pub mod prices;
pub mod reference;
mod road_classes;
mod settings;
mod spacing;
pub mod speed_band;
pub mod speed_keeper;
pub mod target_filter;
mod time_price;
mod torque_bounds;
mod tracking;

pub use dynamic_programming::DynamicProgramming;
pub use law::Predictive;
pub use paper_n2::PaperN2;
pub use planners::create;
pub use prices::Prices;
pub use road_classes::{LimitGrades, Reconstruction};
pub use settings::{
    BoundKeys, Brakes, FilterKeys, FollowKeys, GapKeys, Keys, PlanKeys, PlannerKind, RoadKeys,
    Settings, TruckKeys,
};
pub use spacing::Spacing;
pub use speed_band::SpeedBand;

use crate::law::{Descriptor, GapPolicy, Law, Reader, TargetSource};
use crate::settings::Table;
use scenario::Problem;
use truck_model::{Preset, Truck};

const TABLE: Table = Table::of::<Keys>("predictive");

/// The law as data.
pub static PREDICTIVE: Descriptor = Descriptor {
    name: "predictive",
    description: "predictive cruise of a heavy truck over hills (Li, Zheng, Wang, Wang)",
    source: "Li, Zheng, Wang, Wang (FAW Jiefang JH6)",
    table: Some(TABLE),
    formulations: &[&formulation::FORMULATION],
    formulation: |_| &formulation::FORMULATION,
    gap: GapPolicy::Internal,
    target: TargetSource::Measured,
    trucks_alone: true,
    build,
};

fn build(reader: &Reader<'_>) -> Result<Box<dyn Law>, Problem> {
    let keys: Keys = reader.table(TABLE.name)?;
    let vehicle = reader.plant().vehicle;
    let Some(preset) = Preset::named(vehicle.name()) else {
        let message = format!("the law `{}` drives trucks alone", PREDICTIVE.name);
        let trucks = Preset::ALL.map(|truck| format!("`{}`", truck.name())).join(" or ");
        let expected = format!("another law, or {trucks} as plant.vehicle");
        return Err(Problem::new("controller.name", message, expected));
    };
    reader.without(TABLE.name, keys.planner.unused());
    Ok(Box::new(Predictive::new(&Settings::of_keys(&Truck::preset(preset), &keys))))
}
