//! Car following: the vehicle ahead brakes to a stop.

use crate::contact::{Travel, contact};
use crate::{Driver, GRAVITY_MPS2, Model, STEP_S, VEHICLE_WIDTH_M, Verdict, View, mps};

/// From 128 km/h at 0.05 g a vehicle needs 73 s to stop.
const LONGEST_S: f64 = 120.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Case {
    pub speed_kmh: u32,
    pub lead_hundredths_g: u32,
}

impl Case {
    pub fn lead_deceleration_mps2(&self) -> f64 {
        f64::from(self.lead_hundredths_g) / 100.0 * GRAVITY_MPS2
    }

    /// End of the case if `model` drives the ego from the distance that it keeps. `None` if the
    /// model keeps no distance.
    pub fn drive(&self, model: Model) -> Option<Verdict> {
        let mut speed_mps = mps(self.speed_kmh);
        let mut lead_mps = speed_mps;
        let mut gap = Travel::from_m(model.following_distance_m(speed_mps)?);
        let mut driver = Driver::in_lane(model);
        for _ in 0..(LONGEST_S / STEP_S) as u32 {
            let view = View::in_lane(gap.position_m(), lead_mps);
            speed_mps = driver.step(speed_mps, Some(&view));
            lead_mps = (lead_mps - self.lead_deceleration_mps2() * STEP_S).max(0.0);
            gap.step(lead_mps - speed_mps);
            let outcome = contact(gap.position_m(), -VEHICLE_WIDTH_M);
            if outcome.is_collision() {
                return Some(Verdict { outcome, impact_speed_mps: speed_mps - lead_mps });
            }
            if speed_mps == 0.0 && lead_mps == 0.0 {
                break;
            }
        }
        Some(Verdict::NONE)
    }
}

/// The cases, in the order of the tables: 1,121.
pub fn matrix() -> impl Iterator<Item = Case> {
    (12..=128).step_by(2).flat_map(|speed_kmh| {
        (5..=95).step_by(5).map(move |lead_hundredths_g| Case { speed_kmh, lead_hundredths_g })
    })
}
