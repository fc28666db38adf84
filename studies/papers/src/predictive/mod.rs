//! Predictive adaptive cruise of a heavy truck (Li, Zheng, Wang, Wang): its saving on sixty kilometres of hills, and
//! its following.
//!
//! Savings count against a baseline that each row names, at equal trip time. The mean speed of the compared drive is
//! changed until both need the same time within 0.1 %. Fuel is taken where the road ends and corrected for the kinetic
//! energy there. Rows marked `driven` come from a run in lockstep, rows marked `computed` from the same truck and road
//! without services.
//!
//! The paper prints its headline: about 20 L/100 km against about 22 of a skilled driver. It describes the points of
//! the following figure. It prints no table of savings and no parameters: the other savings are compared with the
//! savings of the reconstruction.

use super::runner::Piece;
use super::trips::Trip;
use controller::laws::truck::Prices;
use supervise::DriveStep;
use truck_model::{Preset, Truck};

mod computed;
mod following;
mod savings;

/// Length of the trip, m.
const ROAD_M: f64 = 60e3;
const SET_SPEED_MPS: f64 = 75.0 / 3.6;

/// The pieces of the saving table and of the following figure.
pub fn pieces() -> Vec<Piece> {
    [savings::pieces(), following::pieces()].concat()
}

/// The trip of a drive to the road's end; `None` when it did not reach it.
fn trip(preset: Preset, steps: &[DriveStep]) -> Option<Trip> {
    let truck = Truck::preset(preset);
    let first = steps.first()?;
    let after = steps.partition_point(|step| step.position_m < ROAD_M);
    let (a, b) = (steps.get(after.checked_sub(1)?)?, steps.get(after)?);
    let share = (ROAD_M - a.position_m) / (b.position_m - a.position_m);
    let between = |from: f64, to: f64| from + share * (to - from);
    let end_mps = between(a.speed_mps, b.speed_mps);
    Some(Trip {
        length_m: ROAD_M,
        time_s: between(a.time_s, b.time_s),
        fuel_g: between(a.powertrain?.fuel_g, b.powertrain?.fuel_g),
        gained_j: truck.kinetic_energy_j(end_mps) - truck.kinetic_energy_j(first.speed_mps),
        ..Trip::default()
    })
}

/// Fuel at equal kinetic energy at both ends, L/100 km.
fn litres(preset: Preset, trip: &Trip) -> f64 {
    let energy_gpj = Prices::new(&Truck::preset(preset), SET_SPEED_MPS).energy_gpj;
    trip.corrected_l_per_100_km(energy_gpj)
}

/// Trip time against a baseline, percent.
fn slower_percent(trip: &Trip, baseline: &Trip) -> f64 {
    100.0 * (trip.time_s / baseline.time_s - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use supervise::PowertrainStep;
    use truck_model::FUEL_DENSITY_GPL;

    #[test]
    fn a_trip_ends_where_the_road_does_and_speed_gained_is_fuel_to_be_given_back() {
        let step = |time_s, position_m, speed_mps, fuel_g| DriveStep {
            time_s,
            position_m,
            speed_mps,
            powertrain: Some(PowertrainStep { fuel_g, ..PowertrainStep::default() }),
            ..DriveStep::default()
        };
        let preset = Preset::Jh6At25T;
        let end = |speed_mps| {
            let before = step(2999.0, 59_990.0, speed_mps, 9000.0);
            let after = step(3000.0, 60_010.0, speed_mps, 9010.0);
            [step(0.0, 0.0, 20.0, 0.0), before, after]
        };
        let even = trip(preset, &end(20.0)).expect("it got there");
        assert_eq!((even.time_s, even.gained_j), (2999.5, 0.0));
        assert!((litres(preset, &even) - 9005.0 / FUEL_DENSITY_GPL / 0.6).abs() < 1e-9);
        let faster = trip(preset, &end(21.0)).expect("it got there");
        assert!(litres(preset, &faster) < litres(preset, &even));
        assert_eq!(trip(preset, &end(20.0)[..2]), None, "it did not get there");
    }
}
