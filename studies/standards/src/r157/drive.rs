//! A case driven by a law, and its end by the regulation's rectangles.
//!
//! The emergency brake reaches the plant alone, while it brakes or holds. A drive in which it never did so has the same
//! bytes as the drive without it, so it counts for both.

use frame::batch::Done;
use messages::AllVehicles;
use serde::{Deserialize, Serialize};
use supervise::{Drive, Error};

use super::results::End;
use crate::{VEHICLE_WIDTH_M, Verdict, contact};

/// Ends of a case with a law: the record of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ends {
    braked: End,
    alone: End,
}

impl Ends {
    /// The ends of drives with the emergency brake and without it.
    pub fn of(drive: impl Fn(bool) -> Result<Done, Error>) -> Result<Self, Error> {
        let done = drive(true)?;
        let braked = End::of(&done);
        let alone = match done.summary.aebs.interventions {
            Some(0) => braked,
            _ => End::of(&drive(false)?),
        };
        Ok(Self { braked, alone })
    }

    pub fn end(&self, aebs: bool) -> End {
        if aebs { self.braked } else { self.alone }
    }
}

impl End {
    fn of(done: &Done) -> Self {
        let requirements = &done.summary.requirements;
        let is_broken = || requirements.iter().any(|verdict| !verdict.met);
        let is_broken = (!requirements.is_empty()).then(is_broken);
        Self { verdict: verdict(&done.drive), is_broken }
    }
}

/// End of the drive: the first contact of the ego with any other vehicle. Between two samples of
/// the others they keep their speed, and move evenly from one lateral position to the next.
pub fn verdict(drive: &Drive) -> Verdict {
    let mut truths = drive.vehicles.iter().peekable();
    let mut seen: Option<&AllVehicles> = None;
    for step in &drive.steps {
        while let Some(truth) = truths.next_if(|truth| truth.header.step <= step.step) {
            seen = Some(truth);
        }
        let Some(seen) = seen else { continue };
        let since_s = step.time_s - seen.header.acquisition_ns as f64 * 1e-9;
        let next = truths.peek().filter(|next| next.vehicles.len() == seen.vehicles.len());
        for (index, vehicle) in seen.vehicles.iter().enumerate() {
            let gap_m = vehicle.rear_position_m + vehicle.speed_mps * since_s - step.position_m;
            if gap_m >= 0.0 {
                continue;
            }
            let lateral_m = next.map_or(vehicle.lateral_m, |next| {
                let ns = next.header.acquisition_ns - seen.header.acquisition_ns;
                let share = (since_s / (ns as f64 * 1e-9)).clamp(0.0, 1.0);
                vehicle.lateral_m + share * (next.vehicles[index].lateral_m - vehicle.lateral_m)
            });
            let outcome = contact(gap_m, lateral_m.abs() - VEHICLE_WIDTH_M);
            if outcome.is_collision() {
                return Verdict { outcome, impact_speed_mps: step.speed_mps - vehicle.speed_mps };
            }
        }
    }
    Verdict::NONE
}

#[cfg(test)]
mod tests {
    use crate::Outcome;
    use bytemuck::Zeroable;
    use messages::VehicleTruthItem;
    use supervise::DriveStep;

    use super::*;

    fn truth(step: u64, rear_position_m: f64, lateral_m: f64) -> AllVehicles {
        let mut truth = AllVehicles::with_room(1);
        truth.header.step = step;
        truth.header.acquisition_ns = 10_000_000 * step as i64;
        truth.vehicles.push(VehicleTruthItem::zeroed());
        truth.vehicles[0].rear_position_m = rear_position_m;
        truth.vehicles[0].speed_mps = 10.0;
        truth.vehicles[0].lateral_m = lateral_m;
        truth
    }

    fn drive(vehicles: Vec<AllVehicles>) -> Drive {
        let step = |step: u64| DriveStep {
            step,
            time_s: 0.01 * step as f64,
            position_m: 0.2 * step as f64,
            speed_mps: 20.0,
            ..DriveStep::default()
        };
        Drive { steps: (0..100).map(step).collect(), vehicles, ..Drive::default() }
    }

    #[test]
    fn a_vehicle_that_is_caught_up_with_is_hit_from_behind() {
        let verdict =
            verdict(&drive((0..20).map(|k| truth(5 * k, 1.0 + 0.5 * k as f64, 0.0)).collect()));
        assert_eq!(verdict.outcome, Outcome::RearEnd);
        assert!((verdict.impact_speed_mps - 10.0).abs() < 1e-12);
    }

    #[test]
    fn a_vehicle_that_comes_in_beside_the_ego_is_a_side_contact() {
        let beside = |k: u64| truth(5 * k, k as f64 - 6.0, 3.0 - 0.2 * k as f64);
        assert_eq!(verdict(&drive((0..20).map(beside).collect())).outcome, Outcome::Side);
    }

    #[test]
    fn a_vehicle_that_stays_beside_is_passed() {
        let beside = |k: u64| truth(5 * k, 1.0 + 0.5 * k as f64, 3.5);
        assert_eq!(verdict(&drive((0..20).map(beside).collect())), Verdict::NONE);
        assert_eq!(verdict(&drive(Vec::new())), Verdict::NONE);
    }
}
