//! Facts of a drive on curves, by its ground truth.
//!
//! ```text
//! drive ─ report::targets ─► scans with lead, owner of the target and place ─► sums by place
//!       └ scenes ─► sight of the queue ─► braking left when it becomes the target, avoidable collision
//! ```
//!
//! The queue is in sight if the radar's range and field of view contain the middle of its last vehicle's rear.

use frame::batch::Done;
use report::targets::{JudgedScan, Owner, Sums, by_place, judge};
use scenario::Scenario;
use scenario::perception::Radar;
use serde::{Deserialize, Serialize};
use supervise::PlaneScene;
use supervise::report::Outcome;

use crate::limits::{BRAKED_MPS2, COMFORT_MPS2, FROM_SIGHT_MPS2, HARD_MPS2};
use crate::population::Drive;

/// Sight of a queue in the lane, and the time at which it became the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sight {
    /// Run time at which it came into sight, s.
    pub at_s: f64,
    /// Gap to it along the axis then, m.
    pub gap_m: f64,
    /// Speed of the ego then, m/s.
    pub speed_mps: f64,
    /// Braking that stops the ego before it when it becomes the target, m/s²; none: it never did.
    pub needed_mps2: Option<f64>,
}

impl Sight {
    /// Braking that stops the ego before it, from the sight on, m/s².
    pub fn needed_from_sight_mps2(&self) -> f64 {
        stopping_mps2(self.speed_mps, self.gap_m)
    }
}

/// Braking that stops within a gap, m/s².
fn stopping_mps2(speed_mps: f64, gap_m: f64) -> f64 {
    speed_mps.powi(2) / (2.0 * gap_m.max(f64::MIN_POSITIVE))
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// Sums by part of a curve, in the order of [`report::targets::Place::ALL`].
    pub places: [Sums; 4],
    pub lowest_request_mps2: Option<f64>,
    pub sight: Option<Sight>,
    pub largest_lateral_mps2: f64,
}

impl Facts {
    /// Judges a drive; only a queue in the lane has to come into sight.
    pub fn of(scenario: &Scenario, done: &Done, is_in_lane: bool) -> Self {
        let drive = &done.drive;
        let axis = scenario.road.plan().map(|plan| plan.axis());
        let curvature = |p_m: f64| axis.as_ref().map_or(0.0, |axis| axis.curvature_perm(p_m));
        let scans = judge(drive, &curvature);
        let lateral = drive.plane.iter().map(|scene| scene.ego.lateral_acceleration_mps2.abs());
        let speed_mps = |time_s: f64| {
            let step = drive.steps.partition_point(|step| step.time_s < time_s - 1e-9);
            drive.steps.get(step).map_or(0.0, |step| step.speed_mps)
        };
        let radar = &scenario.perception.radar;
        let requests = drive.steps.iter().filter_map(|step| step.request_mps2);
        Self {
            places: by_place(&scans),
            lowest_request_mps2: requests.reduce(f64::min),
            sight: is_in_lane.then(|| sight(&drive.plane, &scans, radar, &speed_mps)).flatten(),
            largest_lateral_mps2: lateral.fold(0.0, f64::max),
        }
    }

    /// Sums over a part of the curves, or over all places.
    pub fn sums(&self, place: Option<usize>) -> Sums {
        let mut sums = Sums::default();
        let places = self.places.iter().enumerate();
        let wanted = places.filter(|(index, _)| place.is_none_or(|place| place == *index));
        wanted.for_each(|(_, place)| sums.add(place));
        sums
    }

    /// The law braked as before a vehicle.
    pub fn is_braked(&self) -> bool {
        self.lowest_request_mps2.is_some_and(|request| request < BRAKED_MPS2)
    }

    /// A queue in the lane became the target when comfortable braking no longer sufficed, or never.
    pub fn is_beyond_comfort(&self) -> bool {
        self.needs_more_than(COMFORT_MPS2)
    }

    /// A queue in the lane became the target too late for hard braking, or never, though it suffices from sight.
    pub fn is_seen_late(&self) -> bool {
        let is_in_time = self.sight.is_none_or(|sight| sight.needed_from_sight_mps2() <= HARD_MPS2);
        is_in_time && self.needs_more_than(HARD_MPS2)
    }

    fn needs_more_than(&self, most_mps2: f64) -> bool {
        let needed = self.sight.and_then(|sight| sight.needed_mps2);
        needed.is_none_or(|needed| needed > most_mps2)
    }
}

/// The run ended in a collision that braking from sight avoids.
pub fn is_avoidable(drive: &Drive<Facts>) -> bool {
    let stops = |sight: &Sight| sight.needed_from_sight_mps2() < FROM_SIGHT_MPS2;
    // A collision without sight of the vehicle is not the queue's: nothing had to be hit.
    drive.outcome == Outcome::Collision && drive.facts.sight.as_ref().is_none_or(stops)
}

/// Sight of the last vehicle of a queue in the lane; none if it never came into sight.
fn sight(
    scenes: &[PlaneScene],
    scans: &[JudgedScan],
    radar: &Radar,
    speed_mps: &dyn Fn(f64) -> f64,
) -> Option<Sight> {
    let range_m = radar.max_range_m.value();
    let half_view_rad = 0.5 * radar.field_of_view_deg.value().to_radians();
    let (scan, lead) = scans.iter().find_map(|scan| {
        let lead = scan.lead?;
        let scene = scenes.iter().find(|scene| scene.time_s == scan.time_s)?;
        let (x_m, y_m) = scene.bodies[lead.vehicle].rear_m();
        let (x, y) = (x_m - scene.ego.x_m, y_m - scene.ego.y_m);
        let (sine, cosine) = libm::sincos(scene.ego.heading_rad);
        let (along, across) = (x * cosine + y * sine, y * cosine - x * sine);
        let is_in_view = libm::hypot(along, across) <= range_m
            && libm::atan2(across, along).abs() <= half_view_rad;
        is_in_view.then_some((scan, lead))
    })?;
    let target = |judged: &&JudgedScan| judged.owner == Some(Owner::Vehicle(lead.vehicle));
    let needed = |judged: &JudgedScan| {
        stopping_mps2(speed_mps(judged.time_s), judged.lead.map_or(0.0, |lead| lead.gap_m))
    };
    Some(Sight {
        at_s: scan.time_s,
        gap_m: lead.gap_m,
        speed_mps: speed_mps(scan.time_s),
        needed_mps2: scans.iter().find(target).map(needed),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use report::targets::{Lead, Place};
    use supervise::{Body, EgoPlace, Seen};

    #[test]
    fn sight_begins_in_range_and_view_and_ends_with_the_target() {
        let body =
            |x_m: f64, y_m: f64| Body { x_m, y_m, length_m: 4.0, in_lane: true, ..Body::default() };
        let scene = |time_s: f64, body: Body| PlaneScene {
            time_s,
            ego: EgoPlace::default(),
            bodies: vec![body],
            seen: Some(Seen { published_s: time_s + 0.05, target: None }),
        };
        // Out of range, out of view, in view twice.
        let scenes = [
            scene(0.0, body(160.0, 0.0)),
            scene(1.0, body(60.0, 60.0)),
            scene(2.0, body(100.0, 20.0)),
            scene(3.0, body(90.0, 20.0)),
        ];
        let scan = |time_s: f64| {
            let owner = (time_s >= 3.0).then_some(Owner::Vehicle(0));
            let lead = Some(Lead { vehicle: 0, gap_m: 60.0 });
            let (position_m, place) = (20.0 * time_s, Place::Arc);
            JudgedScan { time_s, position_m, place, lead, owner, is_beside: false }
        };
        let scans: Vec<_> = scenes.iter().map(|scene| scan(scene.time_s)).collect();
        let found = sight(&scenes, &scans, &Radar::default(), &|_| 15.0).expect("it is in sight");
        assert_eq!((found.at_s, found.speed_mps), (2.0, 15.0));
        assert_eq!((found.needed_mps2, found.needed_from_sight_mps2()), (Some(1.875), 1.875));
    }
}
