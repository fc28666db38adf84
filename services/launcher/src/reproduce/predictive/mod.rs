//! Predictive adaptive cruise of a heavy truck (Li, Zheng, Wang, Wang): what it saves on sixty
//! kilometres of hills, and how it follows.
//!
//! Savings count against a baseline that each row names, at equal trip time: the mean speed of the one
//! that is compared is moved until both need the same time within 0.1 %. Fuel is taken where the road
//! ends and corrected for the kinetic energy there. Rows marked `driven` come from the process group in
//! lockstep, rows marked `computed` from the same truck and road without processes.

use super::row::Row;
use super::{Driven, Runner};
use crate::error::Error;
use crate::group::DriveStep;
use controller::predictive::Prices;
use truck_model::{FUEL_DENSITY_GPL, Preset, Truck};

mod computed;
mod following;
mod pictures;
mod savings;

/// Scenarios driven, at most.
pub const RUNS: usize =
    2 * (1 + 2 * savings::MAX_ATTEMPTS) + savings::ROBUSTNESS_RUNS + following::RUNS;

/// Length of the trip, m.
const ROAD_M: f64 = 60e3;
/// Set speed of the trip, m/s.
const SET_SPEED_MPS: f64 = 75.0 / 3.6;

pub fn reproduce(runner: &mut Runner<'_>) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    savings::reproduce(runner, &mut rows)?;
    following::reproduce(runner, &mut rows)?;
    // Its own pictures show them, over distance.
    runner.drives.clear();
    Ok(rows)
}

/// What came of a trip to the road's end.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Trip {
    time_s: f64,
    /// Fuel at equal kinetic energy at both ends, L/100 km.
    corrected_l_per_100km: f64,
    /// Part of it that the correction made, L/100 km.
    correction_l_per_100km: f64,
}

impl Trip {
    /// The trip that was driven; `None` when it did not reach the road's end.
    fn of(preset: Preset, driven: &Driven) -> Option<Self> {
        let truck = Truck::preset(preset);
        let steps: Vec<&DriveStep> = driven.drive.steps.iter().collect();
        let first = steps.first()?;
        let after = steps.partition_point(|step| step.position_m < ROAD_M);
        let (a, b) = (steps.get(after.checked_sub(1)?)?, steps.get(after)?);
        let share = (ROAD_M - a.position_m) / (b.position_m - a.position_m);
        let between = |from: f64, to: f64| from + share * (to - from);
        let fuel_g = between(a.powertrain?.fuel_g, b.powertrain?.fuel_g);
        let end_mps = between(a.speed_mps, b.speed_mps);
        let gained_j = truck.kinetic_energy_j(end_mps) - truck.kinetic_energy_j(first.speed_mps);
        let price_gpj = Prices::new(&truck, SET_SPEED_MPS).energy_gpj;
        let litres = |grams: f64| 1e5 * grams / FUEL_DENSITY_GPL / ROAD_M;
        Some(Self {
            time_s: between(a.time_s, b.time_s),
            corrected_l_per_100km: litres(fuel_g - price_gpj * gained_j),
            correction_l_per_100km: -litres(price_gpj * gained_j),
        })
    }

    /// Fuel against a baseline, percent.
    fn against(&self, baseline: &Self) -> f64 {
        100.0 * (self.corrected_l_per_100km / baseline.corrected_l_per_100km - 1.0)
    }

    /// Trip time against a baseline, percent.
    fn slower_than(&self, baseline: &Self) -> f64 {
        100.0 * (self.time_s / baseline.time_s - 1.0)
    }
}
