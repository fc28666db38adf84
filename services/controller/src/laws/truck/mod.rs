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
//! | a car under this law | | `car` |

mod beyond;
mod bounds;
mod car;
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
    BoundKeys, Brakes, CarGap, FilterKeys, FollowKeys, GapKeys, Keys, PlanKeys, PlannerKind,
    RoadKeys, Settings, TruckKeys,
};
pub use spacing::Spacing;
pub use speed_band::SpeedBand;

use crate::law::reader::key;
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
    build,
};

/// The law's model of the truck; a car is driven like the heavier truck.
fn build(reader: &Reader<'_>) -> Result<Box<dyn Law>, Problem> {
    let keys: Keys = reader.table(TABLE.name)?;
    let vehicle = reader.plant().vehicle;
    let preset = Preset::named(vehicle.as_str()).unwrap_or(Preset::Jh6At49T);
    reader.without(TABLE.name, keys.planner.unused());
    // A car brakes by its own driver model, not by the truck's estimates of risk.
    let of_the_other_vehicle: &[&str] = match vehicle.is_truck() {
        true => &["lead_deceleration_mps2"],
        false => &["gap.stopping_mps2", "gap.drag_mps2"],
    };
    reader.without(TABLE.name, of_the_other_vehicle);
    let car = (!vehicle.is_truck()).then(|| {
        let lag_s = key!(reader, model_time_constant_s).value();
        let headway_s = key!(reader, time_headway_s).value();
        let standstill_m = key!(reader, standstill_distance_m).value();
        CarGap {
            lag_s,
            headway_s,
            standstill_m,
            lead_deceleration_mps2: keys.lead_deceleration_mps2,
        }
    });
    let settings = Settings::of_keys(&Truck::preset(preset), &keys);
    Ok(Box::new(Predictive::new(&Settings { car, ..settings })))
}
