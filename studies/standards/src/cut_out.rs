//! Cut-out: the vehicle ahead leaves the lane in front of a standing one.

use crate::contact::{Travel, contact};
use crate::{
    Driver, Model, Outcome, STEP_S, VEHICLE_LENGTH_M, VEHICLE_WIDTH_M, Verdict, View, mps,
};

/// Offset of the lead's centre from the lane's at which a driver behind sees past it \[m\].
const VISIBLE_OFFSET_M: f64 = 0.375;

/// The slowest lead needs 19 s to be out of the way.
const LONGEST_S: f64 = 100.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Case {
    pub speed_kmh: u32,
    /// Distance from the lead's front bumper to the standing vehicle's rear bumper \[m\].
    pub standing_distance_m: u32,
    /// Lateral speed of the lead in tenths \[0.1 m/s\].
    pub lateral_tenths_mps: u32,
}

impl Case {
    pub fn lateral_mps(&self) -> f64 {
        f64::from(self.lateral_tenths_mps) * 0.1
    }

    /// True if the lead hits the standing vehicle and stands there: whether they touch at the end of a step.
    pub fn lead_hits(&self) -> bool {
        let mut lead = Lead::new(self, 0.0);
        let standing = self.standing_from(0.0);
        while !lead.stands && lead.clearance_m() < 0.0 {
            lead.step(&standing);
        }
        lead.stands
    }

    /// The standing vehicle of an ego that begins at 0, `distance_m` behind the lead.
    fn standing_from(&self, distance_m: f64) -> Travel {
        Travel::from_m(distance_m + f64::from(self.standing_distance_m) + 2.0 * VEHICLE_LENGTH_M)
    }

    /// End of the case if `model` drives the ego from the distance that it keeps behind the lead. `None` if the model
    /// keeps no distance.
    pub fn drive(&self, model: Model) -> Option<Verdict> {
        let distance_m = model.following_distance_m(mps(self.speed_kmh))?;
        Some(self.drive_from(model, distance_m))
    }

    /// End of the case when `model` drives the ego from `distance_m` behind the lead.
    ///
    /// The model drives on until it sees the standing vehicle, or that the lead has hit it.
    pub fn drive_from(&self, model: Model, distance_m: f64) -> Verdict {
        let mut speed_mps = mps(self.speed_kmh);
        let mut ego = Travel::from_m(0.0);
        let mut lead = Lead::new(self, distance_m);
        let standing = self.standing_from(distance_m);
        let mut driver = Driver::in_lane(model);
        for _ in 0..(LONGEST_S / STEP_S) as u32 {
            let obstacle = if lead.known_to_stand && lead.clearance_m() < 0.0 {
                Some(&lead.travel)
            } else {
                (lead.offset.position_m() >= VISIBLE_OFFSET_M).then_some(&standing)
            };
            let view = obstacle.map(|obstacle| View::in_lane(obstacle.gap_to_m(&ego), 0.0));
            speed_mps = driver.step(speed_mps, view.as_ref());
            ego.step(speed_mps);
            lead.step(&standing);
            let outcome = lead
                .contact_with(&ego)
                .unwrap_or_else(|| contact(standing.gap_to_m(&ego), -VEHICLE_WIDTH_M));
            if outcome.is_collision() {
                return Verdict { outcome, impact_speed_mps: speed_mps };
            }
            if speed_mps == 0.0 {
                break;
            }
        }
        Verdict::NONE
    }
}

/// The cases, in the order of the tables: 5,850.
pub fn matrix() -> impl Iterator<Item = Case> {
    (10..=130).step_by(10).flat_map(|speed_kmh| {
        (2..=147).step_by(5).flat_map(move |standing_distance_m| {
            (1..=29).step_by(2).map(move |lateral_tenths_mps| Case {
                speed_kmh,
                standing_distance_m,
                lateral_tenths_mps,
            })
        })
    })
}

/// The vehicle that leaves the lane, or stops where it hits the standing one.
struct Lead {
    speed_mps: f64,
    lateral_mps: f64,
    travel: Travel,
    offset: Travel,
    stands: bool,
    /// True if it already stood a step ago: only then can a driver behind see it.
    known_to_stand: bool,
}

impl Lead {
    fn new(case: &Case, distance_m: f64) -> Lead {
        Lead {
            speed_mps: mps(case.speed_kmh),
            lateral_mps: case.lateral_mps(),
            travel: Travel::from_m(distance_m + VEHICLE_LENGTH_M),
            offset: Travel::from_m(0.0),
            stands: false,
            known_to_stand: false,
        }
    }

    fn step(&mut self, standing: &Travel) {
        self.known_to_stand = self.stands;
        if !self.stands {
            self.travel.step(self.speed_mps);
            self.offset.step(self.lateral_mps);
            self.stands =
                contact(standing.gap_to_m(&self.travel), self.clearance_m()).is_collision();
        }
    }

    /// Clearance between its side and the side of a vehicle in the middle of the lane \[m\].
    fn clearance_m(&self) -> f64 {
        self.offset.position_m() - VEHICLE_WIDTH_M
    }

    /// The ego's contact with it where it stands; `None` without one.
    fn contact_with(&self, ego: &Travel) -> Option<Outcome> {
        let outcome = contact(self.travel.gap_to_m(ego), self.clearance_m());
        (self.stands && outcome.is_collision()).then_some(outcome)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lead_hits_if_it_touches_at_the_end_of_a_step() {
        let hits = |speed_kmh, standing_distance_m, lateral_tenths_mps| {
            Case { speed_kmh, standing_distance_m, lateral_tenths_mps }.lead_hits()
        };
        // 3.74 s to the standing vehicle and 3.8 s to be clear of it: no step ends in between.
        assert!(!hits(50, 52, 5));
        // 3.6 s: the step that ends at 3.7 s does.
        assert!(hits(70, 70, 5));
        assert!(!hits(100, 147, 29), "it is clear long before");
        assert_eq!(matrix().filter(Case::lead_hits).count(), 1595);
    }
}
