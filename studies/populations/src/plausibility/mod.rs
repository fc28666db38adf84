//! `plausibility`: false alarms of the controller's checks of its inputs, and the time until they find a false sender.
//!
//! ```text
//! number ─ drives ─► random drive without faults ─► false alarms per hour, by check and by kind
//! scenario, fault ─► 20 drives ─► found or not, after how long
//! ```
//!
//! A law that the user names drives all cars. Trucks keep their own.

mod drives;

use std::ops::Range;

use frame::batch::Done;
use report::results::{count, number, word};
use scenario::faults::{self, Fault};
use scenario::plant::Vehicle;
use scenario::{Scenario, Setting, table};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use supervise::report::CheckReport;
use supervise::{Error, ScenarioOptions};

use crate::figures::{Drives, Figure, Group, figures};
use crate::population::{Drive, DriveOptions, Finding, Planned, Population, only_law};
use crate::scene::fixed;

/// Probability outside the interval of a rate.
const TAILS: f64 = 0.05;
/// Drives with each false sender.
const DRIVES: usize = 20;

/// A false sender, for 10 s.
struct Sender {
    fault: &'static str,
    size: &'static str,
    scenario: &'static str,
    /// Topic, and for a bias field and amount.
    topic: &'static str,
    bias: Option<(&'static str, f64)>,
    /// Earliest and latest start, s.
    from_s: (f64, f64),
}

/// Declares [`SENDERS`]: `fault, size, scenario, topic [field amount], from..to;`.
macro_rules! senders {
    ($($fault:literal $size:literal $scenario:literal $topic:literal [$($field:literal $amount:literal)?]
        $from:literal to $to:literal;)+) => {
        const SENDERS: &[Sender] = &[$(Sender {
            fault: $fault, size: $size, scenario: $scenario, topic: $topic,
            bias: senders!(@ $($field $amount)?), from_s: ($from, $to),
        },)+];
    };
    (@) => { None };
    (@ $field:literal $amount:literal) => { Some(($field, $amount)) };
}

senders! {
    "odometry frozen" "driving" "following" "vehicle/odometry" [] 5.0 to 40.0;
    "odometry frozen" "standing" "stop-and-go" "vehicle/odometry" [] 13.0 to 17.0;
    "speed biased" "+0.3 m/s" "following" "vehicle/odometry" ["speed_mps" 0.3] 5.0 to 40.0;
    "speed biased" "+1 m/s" "following" "vehicle/odometry" ["speed_mps" 1.0] 5.0 to 40.0;
    "speed biased" "+3 m/s" "following" "vehicle/odometry" ["speed_mps" 3.0] 5.0 to 40.0;
    "speed biased" "-3 m/s" "following" "vehicle/odometry" ["speed_mps" -3.0] 5.0 to 40.0;
    "speed biased" "-5 m/s" "corridor" "vehicle/odometry" ["speed_mps" -5.0] 5.0 to 40.0;
    "speed biased" "+5 m/s, truck" "truck-follow" "vehicle/odometry" ["speed_mps" 5.0] 5.0 to 40.0;
    "radar frozen" "following" "following" "radar/tracks" [] 5.0 to 40.0;
    "radar frozen" "stop-and-go" "stop-and-go" "radar/tracks" [] 5.0 to 80.0;
    "radar frozen" "object list" "truck-follow" "radar/tracks" [] 5.0 to 80.0;
    "gap biased" "+2 m" "stop-and-go" "radar/tracks" ["gap_m" 2.0] 5.0 to 80.0;
    "gap biased" "+5 m" "stop-and-go" "radar/tracks" ["gap_m" 5.0] 5.0 to 80.0;
    "gap biased" "-5 m" "following" "radar/tracks" ["gap_m" -5.0] 5.0 to 40.0;
    "relative speed biased" "+1 m/s" "stop-and-go" "radar/tracks" ["relative_speed_mps" 1.0] 5.0 to 80.0;
    "relative speed biased" "+3 m/s" "stop-and-go" "radar/tracks" ["relative_speed_mps" 3.0] 5.0 to 80.0;
    "countdown biased" "-0.5 s" "corridor" "v2x/spat" ["end_s" -0.5] 5.0 to 90.0;
    "countdown biased" "-2 s" "corridor" "v2x/spat" ["end_s" -2.0] 5.0 to 90.0;
    "countdown biased" "+2 s" "corridor" "v2x/spat" ["end_s" 2.0] 5.0 to 90.0;
    "countdown frozen" "" "corridor" "v2x/spat" [] 5.0 to 90.0;
}

impl Sender {
    fn find(keys: &[String]) -> Option<&'static Self> {
        let is = |sender: &&Self| [sender.scenario, sender.fault, sender.size] == *keys;
        SENDERS.iter().find(is)
    }

    /// Start of the fault in drive `number`, s: spread over the time that is allowed.
    fn begins_s(&self, number: usize) -> f64 {
        let (from_s, to_s) = self.from_s;
        fixed(from_s + (to_s - from_s) * (number - 1) as f64 / (DRIVES - 1) as f64, 2)
    }

    fn fault(&self, at_s: f64) -> Fault {
        let mut keys = table! { kind: "freeze", for_s: 10, topic: self.topic, at_s: at_s };
        if let Some((field, amount)) = self.bias {
            keys.extend(table! { kind: "bias", field: field, amount: amount });
        }
        faults::read(keys).expect("the table has faults")
    }
}

#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Facts {
    checks: Vec<CheckReport>,
    /// Start of the fault, s; none without one.
    at_s: Option<f64>,
}

/// The drives, with the law that the user names for the cars.
#[derive(Debug)]
pub struct Plausibility {
    law: String,
}

impl Population for Plausibility {
    type Facts = Facts;

    const NAME: &'static str = "plausibility";
    const TITLE: &'static str =
        "False alarms of the controller's checks, and the false senders that they find";
    /// About three hours.
    const NUMBERS: usize = 110;
    const KEYS: &'static [&'static str] = &["kind", "fault", "size"];

    fn new(laws: Vec<String>) -> Result<Self, Error> {
        Ok(Self { law: only_law(laws, "", Self::NAME)? })
    }

    fn drives(&self, number: usize) -> Vec<(String, Vec<String>)> {
        let keys = vec![drives::kind(number).to_owned(), String::new(), String::new()];
        vec![(self.law.clone(), keys)]
    }

    /// The random drives of these numbers, then all false senders.
    fn plan(&self, numbers: Range<usize>) -> Vec<Planned> {
        let planned = |number, keys| Planned { number, law: self.law.clone(), keys };
        let quiet = numbers.map(|number| planned(number, self.drives(number).remove(0).1));
        let of_sender = |sender: &Sender| {
            let keys = [sender.scenario, sender.fault, sender.size].map(str::to_owned).to_vec();
            (1..=DRIVES).map(move |number| planned(number, keys.clone()))
        };
        quiet.chain(SENDERS.iter().flat_map(of_sender)).collect()
    }

    fn scenario(&self, planned: &Planned, options: &DriveOptions) -> Result<Scenario, Error> {
        let Planned { number, law, keys } = planned;
        let open = |options: &DriveOptions| match Sender::find(keys) {
            None => options.scenario(&drives::settings(*number)),
            Some(sender) => {
                let at_s = sender.begins_s(*number);
                let own = [
                    Setting::new("duration_s", fixed(at_s + 12.0, 2)),
                    Setting::faults(&[sender.fault(at_s)]),
                ];
                let DriveOptions { laws, set, require, .. } = options.clone();
                let seed = Some((*number as i64).into());
                let options = ScenarioOptions { seed, laws, set, require, ..Default::default() };
                supervise::open_with(sender.scenario, &options, "set", &own)
            }
        };
        let own = DriveOptions { laws: supervise::LawOptions::default(), ..options.clone() };
        let scenario = open(&own)?;
        if law.is_empty() || scenario.plant.vehicle != Vehicle::Car {
            return Ok(scenario);
        }
        let mut named = options.clone();
        named.set.push(Setting::new("controller.name", law.as_str()));
        open(&named)
    }

    fn judge(&self, planned: &Planned, _: &Scenario, done: &Done) -> Facts {
        let sender = Sender::find(&planned.keys);
        let at_s = sender.map(|sender| sender.begins_s(planned.number));
        Facts { checks: done.summary.checks.clone(), at_s }
    }

    fn counts(drive: &Drive<Facts>) -> bool {
        drive.facts.at_s.is_none()
    }

    fn finding(drive: &Drive<Facts>) -> Option<Finding> {
        let alarms = drive.facts.checks.iter().filter(|check| check.cycles > 0);
        let names: Vec<&str> = alarms.map(|check| check.check.as_str()).collect();
        let is_false = drive.facts.at_s.is_none() && !names.is_empty();
        is_false.then(|| Finding::Counts(format!("false alarm of {}", names.join(", "))))
    }

    fn figures() -> Vec<Figure<Facts>> {
        figures! {
            count("random_drives", "drives", "Drives without faults").weight(1) => |all| json!(all.all.len());
            number("hours", "time", "h", 2, "Simulated time").weight(2) => |all| json!(hours(all));
            count("alarmed", "alarmed", "Drives with at least one false alarm").less() =>
                |all| json!(alarmed(all).len());
            number("per_hour", "rate", "1/h", 2, "Drives with a false alarm per hour") => |all| per_hour(all)[0].clone();
            number("per_hour_low", "from", "1/h", 2, "Lower end of its exact 95 % interval (Garwood, 1936)") =>
                |all| per_hour(all)[1].clone();
            number("per_hour_high", "to", "1/h", 2, "Upper end of it") => |all| per_hour(all)[2].clone();
        }
    }

    fn groups() -> Vec<Group<Facts>> {
        let nearest = figures! {
            count("false_alarms", "", "Cycles with a false alarm").hidden() =>
                |all| json!(checks(all).map(|(_, check)| check.cycles).sum::<u64>());
            number("nearest", "nearest", "", 2, "Largest value without an alarm, as a share of the threshold") =>
                |all| json!(nearest(all).map(|(_, check)| check.nearest));
            word("example", "in", "A drive with a false alarm, else the one with the nearest value") =>
                |all| json!(alarmed(all).first().copied().or(nearest(all).map(|(drive, _)| drive)).map(|d| d.planned.name()));
        };
        vec![
            Group {
                name: "checks",
                title: "Checks, in drives without faults",
                labels: vec![word("check", "check", "Check of the inputs")],
                rows_of: |drive| {
                    let checks = drive.facts.checks.iter().filter(|_| drive.facts.at_s.is_none());
                    checks.map(|check| vec![check.check.clone()]).collect()
                },
                figures: Self::figures().into_iter().chain(nearest).collect(),
            },
            Group {
                name: "kinds",
                title: "Kinds of drives, without faults",
                labels: vec![word("kind", "kind", "Kind of the drive")],
                rows_of: |drive| match drive.facts.at_s {
                    None => vec![vec![drive.planned.keys[0].clone()]],
                    Some(_) => Vec::new(),
                },
                figures: Self::figures(),
            },
            Group {
                name: "faults",
                title: "False senders, for 10 s",
                labels: vec![
                    word("fault", "fault", "Fault of the sender"),
                    word("size", "size", "Size of the fault"),
                    word("scenario", "scenario", "Scenario"),
                ],
                rows_of: |drive| {
                    let [scenario, fault, size] = drive.planned.keys.as_slice() else {
                        return Vec::new();
                    };
                    let labels = [fault, size, scenario].map(Clone::clone).to_vec();
                    if drive.facts.at_s.is_some() { vec![labels] } else { Vec::new() }
                },
                figures: figures! {
                    count("drives", "drives", "Drives with the fault") => |all| json!(all.all.len());
                    count("found", "found", "Drives in which a check found it") =>
                        |all| json!(all.count(|drive| found(drive).is_some()));
                    number("median_s", "median", "s", 2, "Median time until a check found it") =>
                        |all| json!(all.quantile(0.5, found_s));
                    number("longest_s", "longest", "s", 2, "Longest time until a check found it") =>
                        |all| json!(all.quantile(1.0, found_s));
                    word("by", "first found by", "Checks that found it first, with the number of drives").weight(2) =>
                        |all| json!(by(all));
                },
            },
        ]
    }
}

/// The checks of the row: of the one that it names, or of all.
fn checks<'a>(
    all: &'a Drives<'_, Facts>,
) -> impl Iterator<Item = (&'a Drive<Facts>, &'a CheckReport)> {
    let of =
        |drive: &'a &'a Drive<Facts>| drive.facts.checks.iter().map(move |check| (*drive, check));
    let name = all.label("check");
    all.all
        .iter()
        .flat_map(of)
        .filter(move |(_, check)| name.is_none_or(|name| name == check.check))
}

/// Drives with a false alarm of these checks.
fn alarmed<'a>(all: &'a Drives<'_, Facts>) -> Vec<&'a Drive<Facts>> {
    let mut alarmed: Vec<&Drive<Facts>> =
        checks(all).filter(|(_, check)| check.cycles > 0).map(|(drive, _)| drive).collect();
    alarmed.dedup_by(|a, b| std::ptr::eq(*a, *b));
    alarmed
}

/// The largest value without an alarm, with its drive.
fn nearest<'a>(all: &'a Drives<'_, Facts>) -> Option<(&'a Drive<Facts>, &'a CheckReport)> {
    checks(all)
        .filter(|(_, check)| check.nearest > 0.0)
        .reduce(|a, b| if b.1.nearest > a.1.nearest { b } else { a })
}

/// The check that found the fault first, and when, s.
fn found(drive: &Drive<Facts>) -> Option<(f64, &str)> {
    let at_s = drive.facts.at_s?;
    let alarms =
        drive.facts.checks.iter().filter_map(|check| Some((check.first_s?, check.check.as_str())));
    alarms.filter(|(first_s, _)| *first_s >= at_s).min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Time from the fault's beginning until a check found it, s.
fn found_s(drive: &Drive<Facts>) -> Option<f64> {
    found(drive).zip(drive.facts.at_s).map(|((first_s, _), at_s)| first_s - at_s)
}

/// The checks that found a fault first, with the number of drives.
fn by(all: &Drives<'_, Facts>) -> String {
    let mut by = std::collections::BTreeMap::<&str, usize>::new();
    for (_, check) in all.all.iter().filter_map(|drive| found(drive)) {
        *by.entry(check).or_default() += 1;
    }
    by.iter().map(|(check, count)| format!("{check} {count}")).collect::<Vec<_>>().join(", ")
}

fn hours(all: &Drives<'_, Facts>) -> f64 {
    all.sum(|drive| drive.duration_s) / 3600.0
}

/// Rate of drives with a false alarm, and the ends of its interval, 1/h.
fn per_hour(all: &Drives<'_, Facts>) -> [Value; 3] {
    let (count, hours) = (alarmed(all).len() as u64, hours(all).max(f64::MIN_POSITIVE));
    let [low, high] = statistics::poisson_interval(count, TAILS);
    [count as f64, low, high].map(|drives| json!(drives / hours))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A drive of half an hour with these cycles of alarms, from `first_s` on.
    fn drive(
        keys: [&str; 3],
        cycles: u64,
        first_s: Option<f64>,
        at_s: Option<f64>,
    ) -> Drive<Facts> {
        let check = CheckReport { check: "motion".to_owned(), cycles, first_s, nearest: 0.4 };
        Drive::example("", &keys, Facts { checks: vec![check], at_s })
    }

    #[test]
    fn a_false_alarm_counts_by_check_and_kind_and_a_false_sender_has_its_time() {
        let quiet = ["free-road", "", ""];
        let sender = ["following", "odometry frozen", "driving"];
        let drives = [
            drive(quiet, 0, None, None),
            drive(quiet, 3, Some(7.0), None),
            drive(sender, 9, Some(5.25), Some(5.0)),
            drive(sender, 2, Some(4.0), Some(5.0)),
        ];
        let rows: Vec<_> = Plausibility::groups().iter().map(|group| group.rows(&drives)).collect();
        let [checks, kinds, faults] = rows.as_slice() else { panic!("{rows:?}") };
        for rows in [checks, kinds] {
            assert_eq!((&rows[0]["alarmed"], &rows[0]["per_hour"]), (&json!(1), &json!(1.0)));
        }
        assert_eq!(checks[0]["example"], "free-road 1");
        assert_eq!((&faults[0]["drives"], &faults[0]["found"]), (&json!(2), &json!(1)));
        assert_eq!((&faults[0]["median_s"], &faults[0]["by"]), (&json!(0.25), &json!("motion 1")));
        assert!(Plausibility::finding(&drives[1]).is_some());
        assert_eq!(
            [0, 2, 3].map(|place| Plausibility::finding(&drives[place])),
            [None, None, None]
        );
    }

    #[test]
    fn every_drive_is_a_scenario_and_a_law_of_the_users_own_drives_every_car() {
        let own = Plausibility::new(vec!["mine".to_owned()]).expect("one law");
        let laws = supervise::LawOptions { laws: vec!["mine=cat".parse().expect("a law")] };
        let options = DriveOptions { laws, ..DriveOptions::default() };
        let mut trucks = 0;
        for planned in own.plan(0..52) {
            let quiet = planned.keys[1].is_empty();
            if !quiet && planned.number > 1 {
                continue;
            }
            let scenario = own.scenario(&planned, &options);
            let scenario = scenario.unwrap_or_else(|error| panic!("{}: {error}", planned.name()));
            let is_truck = scenario.plant.vehicle != Vehicle::Car;
            trucks += usize::from(is_truck);
            assert_eq!(
                scenario.controller.name.as_str() == "mine",
                !is_truck,
                "{}",
                planned.name()
            );
            assert_eq!(scenario.faults.is_empty(), quiet, "{}", planned.name());
        }
        assert_eq!(trucks, 2 + 2, "two of the random drives, and two false senders");
    }

    #[test]
    fn the_number_makes_the_drive() {
        assert_eq!(drives::settings(4), drives::settings(4));
        assert_ne!(drives::settings(4), drives::settings(4 + 26));
    }
}
