//! `everyday`: random scenes of everyday driving, judged by an oracle that has the motion of all vehicles.
//!
//! Each scene is driven by every law of cars, with the emergency brake (`braked`) and without it (`alone`).

mod draw;
mod oracle;

use controller::laws;
use frame::batch::Done;
use report::results::{count, number, word};
use scenario::{Scenario, Setting, table};
use serde::{Deserialize, Serialize};
use serde_json::json;
use supervise::Error;
use supervise::report::Outcome;

use crate::curves::scenes::queue;
use crate::figures::{Figure, Group, figures};
use crate::population::{Drive, DriveOptions, Finding, Planned, Population};
use crate::scene::{CAR_LENGTH_M, Draws, Scene};
use oracle::{Brakes, Oracle};

/// Selects the draws; each kind has the stream of its place behind it.
const STREAM: u128 = 0x1501;
const BRAKED: &str = "braked";
const ALONE: &str = "alone";

pub type Kind = (&'static str, fn(&mut Draws) -> Scene);

/// The kinds; a new one comes last.
pub const KINDS: [Kind; 22] = [
    ("cut-in", draw::cut_in),
    ("cut-in-that-brakes", draw::cut_in_that_brakes),
    ("pulls-away", draw::pulls_away),
    ("slower", draw::slower),
    ("standing", draw::standing),
    ("fast-closing", draw::fast_closing),
    ("stop", draw::stop),
    ("stop-and-go", draw::stop_and_go),
    ("braking-lead", draw::braking_lead),
    ("pass", draw::pass),
    ("queue", draw::queue),
    ("crawling-queue", draw::crawling_queue),
    ("led-queue", draw::led_queue),
    ("two-wheeler", draw::two_wheeler),
    ("cut-out", draw::cut_out),
    ("half-blind", draw::half_blind),
    ("false-detections", draw::false_detections),
    ("lost-tracks", draw::lost_tracks),
    ("clock-ahead", draw::clock_ahead),
    ("curve-queue", |draws| queue(draws.number, false)),
    ("curve-queue-ahead", |draws| queue(draws.number, true)),
    ("brakes-beside", draw::brakes_beside),
];

fn scene(kind: &str, number: usize) -> Scene {
    let place = KINDS.iter().position(|(name, _)| *name == kind).unwrap_or_default();
    let mut draws = Draws::of(number as u64, number as u128, STREAM + place as u128);
    let mut scene = KINDS[place].1(&mut draws);
    scene.plant.extend(table! { length_m: CAR_LENGTH_M });
    scene
}

/// Facts of a drive, by the oracle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Facts {
    /// The ego touched another vehicle.
    touched: bool,
    /// Brakes that take over 0.35 s after the need would have avoided it. They are those of the emergency brake if it
    /// is on, else those of the law.
    avoidable: bool,
    /// Times of the interventions where 1.5 m/s² was enough, s.
    needless_s: Vec<f64>,
    /// Times that the ego's target was not a vehicle in its path, where the radar is judged.
    false_targets: u64,
}

/// Everyday scenes with the laws that drive them.
#[derive(Debug)]
pub struct Everyday {
    laws: Vec<String>,
}

impl Population for Everyday {
    type Facts = Facts;

    const NAME: &'static str = "everyday";
    const TITLE: &'static str = "Everyday driving";
    const NUMBERS: usize = 53;
    const KEYS: &'static [&'static str] = &["kind", "brake"];

    fn new(laws: Vec<String>) -> Result<Self, Error> {
        let own = || laws::driving(false).map(|law| law.name.to_owned()).collect();
        Ok(Self { laws: if laws.is_empty() { own() } else { laws } })
    }

    fn drives(&self, _: usize) -> Vec<(String, Vec<String>)> {
        let of_law = |kind: &'static str, law: &String| {
            let keys = |brake: &str| vec![kind.to_owned(), brake.to_owned()];
            [BRAKED, ALONE].map(|brake| (law.clone(), keys(brake)))
        };
        let of_kind = |(kind, _): Kind| self.laws.iter().flat_map(move |law| of_law(kind, law));
        KINDS.into_iter().flat_map(of_kind).collect()
    }

    fn scenario(&self, planned: &Planned, options: &DriveOptions) -> Result<Scenario, Error> {
        let Planned { number, law, keys } = planned;
        let mut scene = scene(&keys[0], *number);
        scene.keys.push(Setting::new("aebs.enabled", keys[1] == BRAKED));
        scene.law.clone_from(law);
        options.scenario(&scene.settings(Self::NAME, *number as u64))
    }

    fn judge(&self, planned: &Planned, scenario: &Scenario, done: &Done) -> Facts {
        let (scene, drive) = (scene(&planned.keys[0], planned.number), &done.drive);
        let oracle = Oracle::new(&scene.actors, &drive.steps);
        let touched = oracle.has_contact();
        let needless = drive.interventions_s.iter().filter(|time_s| oracle.is_needless(**time_s));
        let seen = done.summary.perception.as_ref();
        Facts {
            touched,
            avoidable: touched && oracle.is_avoidable(&brakes(scenario)),
            needless_s: needless.copied().collect(),
            false_targets: seen.map_or(0, |perception| perception.false_targets),
        }
    }

    fn finding(drive: &Drive<Facts>) -> Option<Finding> {
        let Facts { touched, avoidable, needless_s, .. } = &drive.facts;
        if *touched != (drive.outcome == Outcome::Collision) {
            let (oracle, referee) = (if *touched { "a" } else { "no" }, drive.outcome_words());
            return Some(Finding::Breaks(format!("{oracle} contact by the oracle, and {referee}")));
        }
        let contact = avoidable.then(|| "an avoidable contact".to_owned());
        let times: Vec<String> = needless_s.iter().map(|time_s| format!("{time_s:.2} s")).collect();
        let needless =
            (!times.is_empty()).then(|| format!("needless braking at {}", times.join(", ")));
        let all: Vec<String> = contact.into_iter().chain(needless).collect();
        (!all.is_empty()).then(|| Finding::Counts(all.join("; ")))
    }

    fn figures() -> Vec<Figure<Facts>> {
        figures! {
            count("drives", "drives", "Drives with the emergency brake") => |all| json!(all.count(is_braked));
            count("avoidable", "avoidable contacts", "Contacts that the reference avoids").less() =>
                |all| json!(all.count(|drive| is_braked(drive) && drive.facts.avoidable));
            count("needless", "needless", "Drives with an intervention that was not needed").less() =>
                |all| json!(all.count(|drive| !drive.facts.needless_s.is_empty()));
            count("alone.drives", "alone", "Drives without the emergency brake") =>
                |all| json!(all.count(|drive| !is_braked(drive)));
            count("alone.avoidable", "avoidable alone", "Contacts that the law's own brakes avoid").less() =>
                |all| json!(all.count(|drive| !is_braked(drive) && drive.facts.avoidable));
            number("alone.avoidable_share", "share alone", "", 4, "Share of the drives without the brake").less() =>
                |all| json!(all.share(|drive| drive.facts.avoidable, |drive| !is_braked(drive)));
        }
    }

    fn groups() -> Vec<Group<Facts>> {
        vec![
            Group {
                name: "kinds",
                title: "Kinds of scenes",
                labels: vec![word("kind", "kind", "Kind of scene")],
                rows_of: |drive| vec![vec![drive.planned.keys[0].clone()]],
                figures: Self::figures(),
            },
            Group {
                name: "by_law",
                title: "Laws",
                labels: vec![word("law", "law", "Control law")],
                rows_of: |drive| vec![vec![drive.planned.law.clone()]],
                figures: Self::figures(),
            },
        ]
    }
}

fn is_braked(drive: &Drive<Facts>) -> bool {
    drive.planned.keys[1] == BRAKED
}

/// The brakes that a drive is measured by.
fn brakes(scenario: &Scenario) -> Brakes {
    match laws::build(scenario) {
        Ok(law) if !scenario.has_aebs() => Brakes {
            deceleration_mps2: -law.request_bounds_mps2().0,
            lag_s: scenario.plant.actuator_time_constant_s.value(),
        },
        _ => Brakes::EMERGENCY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Actor;
    use report::summary::Summary;
    use supervise::{Drive as Driven, in_process};

    fn planned(kind: &str, number: usize, law: &str, brake: &str) -> Planned {
        Planned { number, law: law.to_owned(), keys: vec![kind.to_owned(), brake.to_owned()] }
    }

    fn scenario_of(planned: &Planned) -> Scenario {
        let everyday = Everyday::new(Vec::new()).expect("its own laws");
        let scenario = everyday.scenario(planned, &DriveOptions::default());
        scenario.unwrap_or_else(|error| panic!("{}: {error}", planned.name()))
    }

    fn drive(scenario: &Scenario) -> (Driven, Summary) {
        let group =
            in_process::run_watched(scenario, runtime::Sealing::Unsealed, &|| false, &mut |_| {})
                .expect("it runs");
        let summary = Summary::new(scenario, runtime::Mode::Lockstep, &group, group.ran_for);
        (group.drive, summary)
    }

    #[test]
    fn every_scene_is_a_scenario_and_a_function_of_its_number() {
        for (kind, _) in KINDS {
            for number in 0..50 {
                assert_eq!(scene(kind, number), scene(kind, number));
                assert_ne!(scene(kind, number), scene(kind, number + 1), "{kind} {number}");
                scenario_of(&planned(kind, number, "acc-mpc", BRAKED));
            }
        }
    }

    /// The oracle's motion and the simulator's are two computations of one description.
    #[test]
    fn the_simulator_moves_the_vehicles_as_the_oracle_expects() {
        for (kind, _) in KINDS {
            let (driven, _) = drive(&scenario_of(&planned(kind, 3, "acc-mpc", BRAKED)));
            assert!(!driven.vehicles.is_empty());
            for truth in &driven.vehicles {
                let time_s = truth.header.acquisition_ns as f64 / 1e9;
                for (actor, vehicle) in scene(kind, 3).actors.iter().zip(&truth.vehicles) {
                    let place = actor.at(time_s);
                    let name = format!("{kind}, {} at {time_s} s", actor.name);
                    assert!((place.rear_m - vehicle.rear_position_m).abs() < 0.05, "{name}");
                    assert!((place.lateral_m - vehicle.lateral_m).abs() < 0.01, "{name}");
                    assert!((place.speed_mps - vehicle.speed_mps).abs() < 0.05, "{name}");
                }
            }
        }
    }

    #[test]
    fn oracle_and_referee_agree_on_contacts() {
        for number in 0..4 {
            let planned = planned("cut-in-that-brakes", number, "quadratic-bounded", ALONE);
            let (driven, summary) = drive(&scenario_of(&planned));
            let scene = scene("cut-in-that-brakes", number);
            let touched = Oracle::new(&scene.actors, &driven.steps).has_contact();
            assert_eq!(touched, summary.outcome == Outcome::Collision, "{number}");
        }
    }

    /// In 9 of these drives the emergency brake braked when points were left out by their own place.
    #[test]
    fn the_emergency_brake_leaves_an_empty_lane_between_queues_alone() {
        let braked = |number: &usize| {
            let (driven, _) = drive(&scenario_of(&planned("queue", *number, "acc-mpc", BRAKED)));
            let scene = scene("queue", *number);
            let oracle = Oracle::new(&scene.actors, &driven.steps);
            assert!(!oracle.has_contact(), "{number}");
            driven.interventions_s.iter().any(|time_s| oracle.is_needless(*time_s))
        };
        let scenes: Vec<usize> = (0..40).filter(braked).collect();
        assert!(scenes.len() <= 3, "{scenes:?}");
    }

    /// Pairs abreast that the radar does not resolve far off, with time to find that out. Each was a target between the
    /// two before.
    #[test]
    fn two_vehicles_abreast_are_not_one_between_them() {
        let mut scene = Scene::new(25.0, 25.0, 9.0);
        scene.law = "acc-mpc".to_owned();
        for number in 0..8 {
            let lateral_m = if number % 2 == 0 { -3.5 } else { 3.5 };
            let gap_m = 120.0 + 20.0 * f64::from(number / 2);
            let car = Actor::car(format!("car-{number}"), gap_m, 8.0);
            scene.actors.push(Actor { lateral_m, ..car });
        }
        let false_targets = |seed| {
            let settings = scene.settings("abreast", seed);
            let scenario = DriveOptions::default().scenario(&settings).expect("a scenario");
            drive(&scenario).1.perception.map_or(0, |perception| perception.false_targets)
        };
        assert!((1..5).map(false_targets).sum::<u64>() < 4, "not one in each drive");
    }
}
