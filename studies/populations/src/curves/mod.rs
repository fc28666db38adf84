//! `curves`: whom the ego follows on curved roads, by ground truth.
//!
//! Perception has to find the vehicle in the ego's lane, and on a curve the lane is not straight ahead. Each scene
//! is driven with five sets of sources of the course. The first is empty (a straight path), and the second has the yaw
//! rate. The other three add standing objects, trails and the map one after the other. `docs/tests.md` explains the
//! figures.

mod judge;
pub mod scenes;

use frame::batch::Done;
use report::results::{Column, count, number, word};
use report::targets::{Place, Sums};
use scenario::{Scenario, Setting};
use serde_json::{Value, json};
use supervise::Error;
use supervise::report::Outcome;

use crate::figures::{Drives, Figure, Group, figures};
use crate::limits::LOST_SHARE;
use crate::population::{Drive, DriveOptions, Finding, Planned, Population, only_law};
use judge::{Facts, is_avoidable};

/// Kinds of scenes: a random road with a lead and two neighbours, and a queue beside the lane or in it.
const SCENES: [&str; 3] = [ROAD, BESIDE, IN_LANE];
const ROAD: &str = "road";
const BESIDE: &str = "beside";
const IN_LANE: &str = "in-lane";
/// The sources that drive by default. Limits hold for them.
const COUNTED: &str = "+ trails";
/// Sources of a course by name, each with all of the earlier ones.
const SOURCES: [(&str, &[&str]); 5] = [
    ("straight", &[]),
    ("yaw rate", &["yaw-rate"]),
    ("+ standing", &["yaw-rate", "standing"]),
    (COUNTED, &["yaw-rate", "standing", "trails"]),
    ("+ map", &["yaw-rate", "standing", "trails", "map"]),
];

/// Curved roads with the law that drives them.
#[derive(Debug)]
pub struct Curves {
    law: String,
}

impl Population for Curves {
    type Facts = Facts;

    const NAME: &'static str = "curves";
    const TITLE: &'static str = "Random curved roads, and curve entries and exits with queues";
    const NUMBERS: usize = 1_000;
    const KEYS: &'static [&'static str] = &["scene", "sources"];

    fn new(laws: Vec<String>) -> Result<Self, Error> {
        Ok(Self { law: only_law(laws, "acc-mpc", Self::NAME)? })
    }

    fn drives(&self, _: usize) -> Vec<(String, Vec<String>)> {
        let of_scene = |scene: &'static str| {
            let keys = move |sources: &str| vec![scene.to_owned(), sources.to_owned()];
            SOURCES.iter().map(move |(sources, _)| (self.law.clone(), keys(sources)))
        };
        SCENES.into_iter().flat_map(of_scene).collect()
    }

    fn scenario(&self, planned: &Planned, options: &DriveOptions) -> Result<Scenario, Error> {
        let (number, kind) = (planned.number as u64, planned.keys[0].as_str());
        let mut scene = match kind {
            ROAD => scenes::road(number),
            _ => scenes::queue(number, kind == IN_LANE),
        };
        let sources = SOURCES.iter().find(|(name, _)| *name == planned.keys[1]);
        let sources = sources.map_or(Vec::new(), |(_, sources)| sources.to_vec());
        scene.keys.push(Setting::new("perception.course.sources", sources));
        scene.law.clone_from(&planned.law);
        options.scenario(&scene.settings(&format!("curves-{kind}-{number}"), number))
    }

    fn judge(&self, planned: &Planned, scenario: &Scenario, done: &Done) -> Facts {
        Facts::of(scenario, done, planned.keys[0] == IN_LANE)
    }

    fn counts(drive: &Drive<Facts>) -> bool {
        drive.planned.keys[1] == COUNTED
    }

    fn is_judged(drive: &Drive<Facts>) -> bool {
        Self::counts(drive)
    }

    fn finding(drive: &Drive<Facts>) -> Option<Finding> {
        let mut findings = Vec::new();
        if drive.outcome != Outcome::Completed {
            findings.push(drive.outcome_words());
        }
        if phantoms(drive) > 0 {
            findings.push("the emergency brake braked for nothing in the lane".to_owned());
        }
        if is_seen_late(drive) {
            findings.push("the queue became the target too late".to_owned());
        }
        let finding = findings.join("; ");
        match drive.outcome {
            Outcome::Completed | Outcome::Collision if finding.is_empty() => None,
            // Collisions are judged by their limit.
            Outcome::Completed | Outcome::Collision => Some(Finding::Counts(finding)),
            _ => Some(Finding::Breaks(finding)),
        }
    }

    /// The first five also have a row for each part of a curve.
    fn figures() -> Vec<Figure<Facts>> {
        figures! {
            number("km", "way", "km", 1, "Way on the random roads") => |all| json!(sums(all).km);
            share("lead_lost.share", "lead lost", LOST) => |all| part(sums(all).lost_s, sums(all).lead_s);
            number("lead_lost.per_km", "lost per km", "", 3, LOST_PER_KM).less() =>
                |all| part(sums(all).losses as f64, sums(all).km);
            share("neighbour_taken.share", "neighbour taken", TAKEN) => |all| part(sums(all).taken_s, sums(all).time_s);
            number("neighbour_taken.per_km", "taken per km", "", 3, TAKEN_PER_KM).less() =>
                |all| part(sums(all).takings as f64, sums(all).km);
            share("nothing_taken_share", "nothing taken", NOTHING).weight(1) =>
                |all| part(sums(all).nothing_s, sums(all).time_s);
            count("phantom_interventions", "phantom brakings", PHANTOMS).less() =>
                |all| json!(all.all.iter().map(|drive| phantoms(drive)).sum::<u64>());
            count("beside", "", "Drives beside a queue").hidden() => |all| json!(all.count(|drive| drive.is(BESIDE)));
            share("lead_lost.roads_share", "roads with losses", ROADS).weight(2) =>
                |all| json!(all.share(is_lost_often, |drive| drive.is(ROAD)));
            share("braked_share", "braked beside", BRAKED) =>
                |all| json!(all.share(|drive| drive.facts.is_braked(), |drive| drive.is(BESIDE)));
            count("in_lane", "", "Drives with a queue in the lane").hidden() =>
                |all| json!(all.count(|drive| drive.is(IN_LANE)));
            count("collisions", "collisions", "Collisions of all scenes").less() =>
                |all| json!(all.count(|drive| drive.outcome == Outcome::Collision));
            count("avoidable_collisions", "avoidable", "Collisions that 6 m/s² from sight avoids").less() =>
                |all| json!(all.count(is_avoidable));
            share("beyond_comfort_share", "beyond comfort", BEYOND_COMFORT) =>
                |all| json!(all.share(|drive| drive.facts.is_beyond_comfort(), |drive| drive.is(IN_LANE)));
            count("seen_late", "seen late", LATE).less() => |all| json!(all.count(is_seen_late));
            number("largest_lateral_mps2", "lateral", "m/s²", 2, "Largest lateral acceleration").weight(2) =>
                |all| json!(all.most(|drive| Some(drive.facts.largest_lateral_mps2)));
        }
    }

    fn groups() -> Vec<Group<Facts>> {
        let sources = word("sources", "course from", "Sources of the course, with those above");
        let place = word("place", "part", "Part of a curve: straight, entry, arc or exit");
        vec![
            Group {
                name: "sources",
                title: "Sources of the course",
                labels: vec![sources.clone()],
                rows_of: |drive| vec![vec![drive.planned.keys[1].clone()]],
                figures: Self::figures(),
            },
            Group {
                name: "places",
                title: "Parts of a curve on the random roads",
                labels: vec![place, sources],
                rows_of: |drive| {
                    let places = Place::ALL.iter().filter(|_| drive.is(ROAD));
                    places.map(|place| vec![name(*place), drive.planned.keys[1].clone()]).collect()
                },
                figures: Self::figures().into_iter().take(5).collect(),
            },
        ]
    }
}

impl Drive<Facts> {
    fn is(&self, scene: &str) -> bool {
        self.planned.keys[0] == scene
    }
}

/// Name of a part of a curve in results.
fn name(place: Place) -> String {
    serde_json::to_value(place)
        .ok()
        .and_then(|name| Some(name.as_str()?.to_owned()))
        .unwrap_or_default()
}

/// Interventions that nothing in the lane needed.
fn phantoms(drive: &Drive<Facts>) -> u64 {
    if drive.is(IN_LANE) { 0 } else { drive.interventions() }
}

fn is_seen_late(drive: &Drive<Facts>) -> bool {
    drive.is(IN_LANE) && drive.facts.is_seen_late()
}

/// The lead was lost for a larger share of the time on this road than is accepted over all roads.
fn is_lost_often(drive: &Drive<Facts>) -> bool {
    let sums = drive.facts.sums(None);
    sums.lost_s > LOST_SHARE * sums.lead_s
}

/// Sums over the random roads, of the part of the curves that the row names.
fn sums(drives: &Drives<'_, Facts>) -> Sums {
    let place = Place::ALL.iter().position(|place| drives.label("place") == Some(&name(*place)));
    let mut sums = Sums::default();
    let roads = drives.all.iter().filter(|drive| drive.is(ROAD));
    roads.for_each(|drive| sums.add(&drive.facts.sums(place)));
    sums
}

/// A part of a whole; 0 without a whole.
fn part(part: f64, whole: f64) -> Value {
    json!(if whole > 0.0 { part / whole } else { 0.0 })
}

/// A share from 0 to 1.
const fn share(path: &'static str, title: &'static str, meaning: &'static str) -> Column<Value> {
    number(path, title, "", 4, meaning).less()
}

const LOST: &str = "Share of the time with a lead within 100 m in which the target is not the lead";
const LOST_PER_KM: &str = "Number of times per km that the lead was lost";
const TAKEN: &str = "Share of the time in which the target is a vehicle beside the lane";
const TAKEN_PER_KM: &str = "Number of times per km that such a vehicle became the target";
const NOTHING: &str = "Share of the time in which the target is not a vehicle";
const PHANTOMS: &str = "Interventions of the emergency brake on random roads and beside queues";
const BRAKED: &str = "Share of the drives beside a queue with a request below -1.5 m/s²";
const ROADS: &str = "Share of the roads with the lead lost for more than 0.5 % of the time";
const BEYOND_COMFORT: &str = "Share of the queues in the lane that became the target when more than 2.5 m/s² was needed, or never";
const LATE: &str = "Queues in the lane that became the target when more than 4.5 m/s² was needed, or never; those that \
     need more from sight do not count";

#[cfg(test)]
mod tests {
    use super::judge::Sight;
    use super::*;
    use report::figures::{INTERVENTIONS, Values};

    /// A drive without a finding.
    fn example(scene: &str, sources: &str) -> Drive<Facts> {
        let road = Sums { time_s: 200.0, km: 5.0, lead_s: 150.0, ..Sums::default() };
        let sight = Sight { at_s: 3.0, gap_m: 150.0, speed_mps: 20.0, needed_mps2: Some(1.4) };
        let facts = Facts {
            places: [road, Sums::default(), Sums::default(), Sums::default()],
            lowest_request_mps2: Some(-0.4),
            sight: (scene == IN_LANE).then_some(sight),
            largest_lateral_mps2: 1.9,
        };
        Drive::example("acc-mpc", &[scene, sources], facts)
    }

    fn figures_of(drives: &[Drive<Facts>]) -> Value {
        let all = Drives { labels: Vec::new(), all: drives.iter().collect() };
        let mut found = serde_json::Map::new();
        crate::figures::values(&Curves::figures(), &all, &mut found);
        Value::Object(found)
    }

    #[test]
    fn shares_are_of_the_time_with_a_lead_and_rates_of_the_way() {
        let mut road = example(ROAD, COUNTED);
        let [all, ..] = &mut road.facts.places;
        *all = Sums { lost_s: 1.5, losses: 2, taken_s: 2.0, takings: 1, ..*all };
        let mut beside = example(BESIDE, COUNTED);
        beside.facts.places[0].takings = 9;
        beside.facts.lowest_request_mps2 = Some(-1.6);
        beside.figures = beside.figures.with(&INTERVENTIONS, 1.0);
        let figures = Values::default().with(&INTERVENTIONS, 5.0);
        let in_lane = Drive { figures, ..example(IN_LANE, COUNTED) };
        let found = figures_of(&[road, beside, in_lane]);
        assert_eq!(found["km"], 5.0, "random roads alone");
        assert_eq!(found["lead_lost"], json!({"share": 0.01, "per_km": 0.4, "roads_share": 1.0}));
        assert_eq!(found["neighbour_taken"], json!({"share": 0.01, "per_km": 0.2}));
        assert_eq!(
            (&found["phantom_interventions"], &found["braked_share"]),
            (&json!(1), &json!(1.0))
        );
        assert_eq!((&found["seen_late"], &found["beyond_comfort_share"]), (&json!(0), &json!(0.0)));
    }

    #[test]
    fn a_collision_is_avoidable_where_braking_from_sight_stops_before_it() {
        let hit = Drive { outcome: Outcome::Collision, ..example(IN_LANE, COUNTED) };
        assert!(is_avoidable(&hit), "33 m of 150 m");
        let mut near = hit;
        near.facts.sight = near.facts.sight.map(|sight| Sight { gap_m: 30.0, ..sight });
        assert!(!is_avoidable(&near), "30 m are too few");
        let beside = Drive { outcome: Outcome::Collision, ..example(BESIDE, COUNTED) };
        assert!(is_avoidable(&beside), "nothing is in the lane");
    }

    #[test]
    fn a_queue_that_is_seen_late_or_never_is_a_finding() {
        let seen = |needed_mps2, gap_m| {
            let mut drive = example(IN_LANE, COUNTED);
            drive.facts.sight =
                drive.facts.sight.map(|sight| Sight { needed_mps2, gap_m, ..sight });
            (Curves::finding(&drive).is_some(), drive.facts.is_beyond_comfort())
        };
        assert_eq!(seen(Some(2.5), 150.0), (false, false));
        assert_eq!(seen(Some(4.5), 150.0), (false, true));
        assert_eq!(seen(Some(4.6), 150.0), (true, true));
        assert_eq!(seen(None, 150.0), (true, true));
        assert_eq!(seen(Some(4.6), 44.0), (false, true), "4.55 m/s² from sight");
        assert_eq!(Curves::finding(&example(ROAD, COUNTED)), None);
    }

    #[test]
    fn every_scene_is_a_scenario_with_all_sources() {
        let curves = Curves::new(Vec::new()).expect("its own law");
        for planned in curves.plan(1..9) {
            let scenario = curves.scenario(&planned, &DriveOptions::default());
            let scenario = scenario.unwrap_or_else(|error| panic!("{}: {error}", planned.name()));
            assert!(scenario.road.plan().is_some());
            assert_eq!(scenario.controller.name.as_str(), "acc-mpc");
        }
    }
}
