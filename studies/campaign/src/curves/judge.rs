//! Figures of a drive, by its ground truth.
//!
//! ```text
//! drive ─ report::targets ─► scans with lead, owner of the target and place ─► sums by place
//!       └ scenes ─► sight of the queue ─► time to the target, avoidable collision
//! ```
//!
//! The queue is in sight if the radar's range and field of view contain the middle of its last vehicle's rear.

use frame::batch::Done;
use group::report::Outcome;
use group::{PlaneScene, RequirementVerdict};
use report::targets::{JudgedScan, Owner, Sums, by_place, judge};
use scenario::Scenario;
use scenario::perception::Radar;
use serde::{Deserialize, Serialize};

use super::event::Event;
use super::limits::{BRAKED_MPS2, FROM_SIGHT_MPS2, SEEN_WITHIN_S};
use super::scene::Scene;

/// Sight of a queue in the lane, and the time at which it became the target.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sight {
    /// Run time at which it came into sight, s.
    pub at_s: f64,
    /// Gap to it along the axis then, m.
    pub gap_m: f64,
    /// Speed of the ego then, m/s.
    pub speed_mps: f64,
    /// Time from then to the first message with it as the target, s; none: never. Negative: before.
    pub seen_after_s: Option<f64>,
}

/// The record of a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// The scene's number, from 1.
    pub number: usize,
    /// Its kind.
    pub scene: Scene,
    /// Sources of the course, by name.
    pub sources: String,
    /// End of the run.
    pub outcome: Outcome,
    /// Reason why it was aborted, if it was.
    pub aborted_because: Option<String>,
    /// Sums by part of a curve, in the order of [`Place::ALL`].
    pub places: [Sums; 4],
    /// Lost leads and taken neighbours one by one.
    pub events: Vec<Event>,
    /// Times that the emergency brake braked.
    pub interventions: u64,
    /// Lowest request of the law, m/s².
    pub lowest_request_mps2: Option<f64>,
    /// Sight of a queue in the lane.
    pub sight: Option<Sight>,
    /// Largest lateral acceleration, m/s².
    pub largest_lateral_mps2: f64,
    /// The options that declare a law of the user's own, as words.
    pub law_options: Vec<String>,
    /// Verdicts on the requirements.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub requirements: Vec<RequirementVerdict>,
}

impl Kept {
    /// Judges a drive.
    pub fn of(
        (number, scene, sources): (usize, Scene, &str),
        scenario: &Scenario,
        done: &Done,
    ) -> Self {
        let drive = &done.drive;
        let axis = scenario.road.plan().map(|plan| plan.axis());
        let curvature = |p_m: f64| axis.as_ref().map_or(0.0, |axis| axis.curvature_perm(p_m));
        let scans = judge(drive, &curvature);
        let lateral = drive.plane.iter().map(|scene| scene.ego.lateral_acceleration_mps2.abs());
        let is_in_lane = scene == Scene::InLane;
        let radar = &scenario.perception.radar;
        let speeds = |time_s: f64| {
            let step = drive.steps.partition_point(|step| step.time_s < time_s - 1e-9);
            drive.steps.get(step).map_or(0.0, |step| step.speed_mps)
        };
        Self {
            number,
            scene,
            sources: sources.to_owned(),
            outcome: done.summary.outcome,
            aborted_because: done.summary.aborted_because.clone(),
            places: by_place(&scans),
            events: Event::all(&scans),
            interventions: done.summary.aebs.interventions.unwrap_or(0),
            lowest_request_mps2: drive
                .steps
                .iter()
                .filter_map(|step| step.request_mps2)
                .reduce(f64::min),
            sight: if is_in_lane { sight(&drive.plane, &scans, radar, &speeds) } else { None },
            largest_lateral_mps2: lateral.fold(0.0, f64::max),
            law_options: Vec::new(),
            requirements: done.summary.requirements.clone(),
        }
    }

    /// Sums over all places.
    pub fn sums(&self) -> Sums {
        let mut sums = Sums::default();
        self.places.iter().for_each(|place| sums.add(place));
        sums
    }

    /// The law braked as before a vehicle.
    pub fn is_braked(&self) -> bool {
        self.lowest_request_mps2.is_some_and(|request| request < BRAKED_MPS2)
    }

    /// Interventions that nothing in the lane needed.
    pub fn phantom_interventions(&self) -> u64 {
        if self.scene == Scene::InLane { 0 } else { self.interventions }
    }

    /// The run ended in a collision that braking from sight avoids.
    pub fn is_avoidable(&self) -> bool {
        let stops = |sight: &Sight| sight.speed_mps.powi(2) / (2.0 * FROM_SIGHT_MPS2) < sight.gap_m;
        // A collision without sight of the vehicle is not the queue's: nothing had to be hit.
        self.outcome == Outcome::Collision && self.sight.as_ref().is_none_or(stops)
    }

    /// The queue in the lane became the target too late.
    pub fn is_seen_late(&self) -> bool {
        let late =
            |sight: &Sight| sight.seen_after_s.is_none_or(|after| after > SEEN_WITHIN_S + 1e-9);
        self.scene == Scene::InLane && self.sight.as_ref().is_none_or(late)
    }

    /// The drive had no finding that no drive may have.
    pub fn holds(&self) -> bool {
        self.outcome == Outcome::Completed
            && self.phantom_interventions() == 0
            && !self.is_seen_late()
    }

    /// The command that repeats all drives of its number.
    pub fn repeat(&self) -> String {
        let number = self.number.to_string();
        let words = ["timegap", "campaign", "curves", "--first", &number, "--seeds", "1"];
        let laws = self.law_options.iter().map(String::as_str);
        let formulas =
            self.requirements.iter().flat_map(|one| ["--require", one.requirement.as_str()]);
        runtime::command_line(&words.into_iter().chain(laws).chain(formulas).collect::<Vec<_>>())
    }

    /// Its finding, in words.
    pub fn finding(&self) -> String {
        let mut findings = Vec::new();
        if self.outcome != Outcome::Completed {
            let word = report::print::outcome_word(self.outcome).to_lowercase();
            let why =
                self.aborted_because.as_ref().map_or_else(String::new, |why| format!(": {why}"));
            findings.push(word + &why);
        }
        if self.phantom_interventions() > 0 {
            findings.push("the emergency brake braked for nothing in the lane".to_owned());
        }
        if self.is_seen_late() {
            findings.push("the queue became the target too late".to_owned());
        }
        findings.join("; ")
    }
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
    let seen = scans.iter().find(target).and_then(|judged| {
        let scene = scenes.iter().find(|scene| scene.time_s == judged.time_s)?;
        Some(scene.seen?.published_s - scan.time_s)
    });
    let speed_mps = speed_mps(scan.time_s);
    Some(Sight { at_s: scan.time_s, gap_m: lead.gap_m, speed_mps, seen_after_s: seen })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use group::{Body, EgoPlace, Seen};
    use report::targets::{Lead, Place};

    /// A drive without a finding.
    pub fn example(scene: Scene, sources: &str) -> Kept {
        let road = Sums { time_s: 200.0, km: 5.0, lead_s: 150.0, ..Sums::default() };
        let sight = Sight { at_s: 3.0, gap_m: 150.0, speed_mps: 20.0, seen_after_s: Some(0.4) };
        Kept {
            number: 1,
            scene,
            sources: sources.to_owned(),
            outcome: Outcome::Completed,
            aborted_because: None,
            places: [road, Sums::default(), Sums::default(), Sums::default()],
            events: Vec::new(),
            interventions: 0,
            lowest_request_mps2: Some(-0.4),
            sight: (scene == Scene::InLane).then_some(sight),
            largest_lateral_mps2: 1.9,
            law_options: Vec::new(),
            requirements: Vec::new(),
        }
    }

    fn scan(time_s: f64, place: Place, owner: Option<Owner>) -> JudgedScan {
        let lead = Some(Lead { vehicle: 0, gap_m: 60.0 });
        let is_beside = owner == Some(Owner::Vehicle(1));
        JudgedScan { time_s, position_m: 20.0 * time_s, place, lead, owner, is_beside }
    }

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
        let owner = |time_s: f64| (time_s >= 3.0).then_some(Owner::Vehicle(0));
        let scans: Vec<_> = scenes
            .iter()
            .map(|scene| scan(scene.time_s, Place::Arc, owner(scene.time_s)))
            .collect();
        let found = sight(&scenes, &scans, &Radar::default(), &|_| 15.0).expect("it is in sight");
        assert_eq!((found.at_s, found.speed_mps), (2.0, 15.0));
        assert!((found.seen_after_s.expect("it is seen") - 1.05).abs() < 1e-9);
    }

    #[test]
    fn a_collision_is_avoidable_where_braking_from_sight_stops_before_it() {
        let hit = Kept { outcome: Outcome::Collision, ..example(Scene::InLane, "x") };
        assert!(hit.is_avoidable(), "33 m of 150 m");
        let near = Sight { at_s: 0.0, gap_m: 30.0, speed_mps: 20.0, seen_after_s: Some(0.0) };
        assert!(!Kept { sight: Some(near), ..hit }.is_avoidable(), "30 m are too few");
        let beside = Kept { outcome: Outcome::Collision, ..example(Scene::Beside, "x") };
        assert!(beside.is_avoidable(), "nothing is in the lane");
    }

    #[test]
    fn a_queue_that_is_seen_late_or_never_is_a_finding() {
        let seen = |seen_after_s| {
            let sight = Sight { at_s: 0.0, gap_m: 150.0, speed_mps: 20.0, seen_after_s };
            Kept { sight: Some(sight), ..example(Scene::InLane, "x") }
        };
        assert!(seen(Some(0.5)).holds() && seen(Some(-1.0)).holds());
        assert!(!seen(Some(0.55)).holds() && !seen(None).holds());
        assert!(!Kept { sight: None, ..seen(None) }.holds());
        assert!(example(Scene::Road, "x").holds());
    }
}
