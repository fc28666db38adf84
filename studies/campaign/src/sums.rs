//! Sums over all runs, and over runs with something in common.

use super::measured::{self, Histograms, MeasuredFigure, Measures};
use super::record::Record;
use Shown::{Column as Shows, Total, Unlimited, UnlimitedTotal};
use report::results::{Column, count};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use supervise::report::Outcome;

/// Runs of the same scenario, controller and fault.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Combination {
    pub scenario: String,
    pub controller: String,
    pub fault: String,
    #[serde(flatten)]
    pub tally: Tally,
}

/// Runs with one thing in common.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Shared {
    /// The common scenario, controller or fault.
    pub of: String,
    #[serde(flatten)]
    pub tally: Tally,
}

/// Sums over the runs: over all, and by what they have in common.
#[derive(Debug, Default)]
pub struct Sums {
    pub all: Sum,
    combinations: Grouped<3>,
    scenarios: Grouped<1>,
    controllers: Grouped<1>,
    faults: Grouped<1>,
}

/// Sums by names, in the order in which the names appear first.
#[derive(Debug)]
struct Grouped<const N: usize>(Vec<([String; N], Sum)>);

impl<const N: usize> Default for Grouped<N> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<const N: usize> Grouped<N> {
    fn add(&mut self, names: [&str; N], record: &Record) {
        let known = self.0.iter().position(|(known, _)| known.each_ref() == names.each_ref());
        let place = known.unwrap_or_else(|| {
            self.0.push((names.map(str::to_owned), Sum::default()));
            self.0.len() - 1
        });
        self.0[place].1.add(record);
    }
}

impl Grouped<1> {
    fn shared(&self) -> Vec<Shared> {
        self.0.iter().map(|([of], sum)| Shared { of: of.clone(), tally: sum.tally() }).collect()
    }
}

impl Sums {
    /// Adds a run; they come in the order of their numbers.
    pub fn add(&mut self, record: &Record) {
        let Record { scenario, controller, fault, .. } = record;
        self.all.add(record);
        self.combinations.add([scenario, controller, fault], record);
        self.scenarios.add([scenario], record);
        self.controllers.add([controller], record);
        self.faults.add([fault], record);
    }

    /// By scenario, controller and fault.
    pub fn combinations(&self) -> Vec<Combination> {
        let combination = |([scenario, controller, fault], sum): &([String; 3], Sum)| {
            let [scenario, controller, fault] = [scenario, controller, fault].map(Clone::clone);
            Combination { scenario, controller, fault, tally: sum.tally() }
        };
        self.combinations.0.iter().map(combination).collect()
    }

    pub fn scenarios(&self) -> Vec<Shared> {
        self.scenarios.shared()
    }

    pub fn controllers(&self) -> Vec<Shared> {
        self.controllers.shared()
    }

    pub fn faults(&self) -> Vec<Shared> {
        self.faults.shared()
    }
}

/// Sums over some runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Tally {
    #[serde(flatten)]
    pub counts: Counts,
    #[serde(flatten)]
    pub measures: Measures,
    /// Faults that acted in each phase.
    pub phases: BTreeMap<String, u64>,
    /// Received radio frames by the on-board unit's verdict.
    pub frames: BTreeMap<String, u64>,
    /// Time of each service on each degradation level, s.
    pub rungs_s: BTreeMap<String, f64>,
    /// The service whose memory grew most.
    pub memory_growth_of: String,
}

/// Sums while runs are added.
#[derive(Debug, Default)]
pub struct Sum {
    tally: Tally,
    pub histograms: Histograms,
}

impl Sum {
    /// Adds a run. In another order the times on the levels may differ in their last digits.
    pub fn add(&mut self, record: &Record) {
        let (tally, found) = (&mut self.tally, &record.measured);
        for (sum, found) in [(&mut tally.phases, &found.phases), (&mut tally.frames, &found.frames)]
        {
            for (name, count) in found {
                *sum.entry(name.clone()).or_insert(0) += count;
            }
        }
        for (rung, time_s) in &found.rungs_s {
            *tally.rungs_s.entry(rung.clone()).or_insert(0.0) += time_s;
        }
        let most_kib = tally.measures.extremes.memory_growth_kib;
        if let Some(growth) = &found.growth
            && most_kib.is_none_or(|most| growth.memory_kib > most)
        {
            tally.memory_growth_of.clone_from(&growth.memory_of);
        }
        tally.counts.add(record);
        tally.measures.extremes.add(record);
        self.histograms.add(record);
    }

    /// The sums over the runs so far.
    pub fn tally(&self) -> Tally {
        let mut tally = self.tally.clone();
        tally.measures.times = self.histograms.times();
        tally
    }
}

/// Appearance and limit of a count.
enum Shown {
    /// A column of the tables of runs with this weight, and a limit of campaigns.
    Column(u8),
    /// The same without a limit.
    Unlimited(u8),
    /// Among the totals of all runs, and a limit of campaigns.
    Total,
    /// The same without a limit.
    UnlimitedTotal,
}

/// Declares the counts: `field "name", "heading", "meaning", shown, record -> its share;`.
macro_rules! counts {
    ($($field:ident $name:literal, $heading:literal, $meaning:literal, $shown:expr, $of:expr;)+) => {
        /// Counts over some runs.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
        pub struct Counts {
            $(#[doc = $meaning] #[serde(rename = $name)] pub $field: u64,)+
        }

        impl Counts {
            pub fn add(&mut self, record: &Record) {
                $(
                    let of: fn(&Record) -> u64 = $of;
                    self.$field += of(record);
                )+
            }
        }

        const NAMED: &[(&str, fn(&Counts) -> u64)] =
            &[$((stringify!($field), |counts| counts.$field)),+];

        const SHOWN: &[Shown] = &[$($shown),+];

        pub fn columns<R>() -> Vec<Column<R>> {
            let all = vec![$(count($name, $heading, $meaning)),+];
            let shown = |(column, shown): (Column<R>, &Shown)| match shown {
                Shows(weight) | Unlimited(weight) => column.weight(*weight),
                Total | UnlimitedTotal => column.hidden(),
            };
            all.into_iter().zip(SHOWN).map(shown).collect()
        }
    };
}

fn ended(record: &Record, outcome: Outcome) -> u64 {
    u64::from(record.outcome == outcome)
}

/// A group whose launcher is killed always ends as aborted.
fn aborted(record: &Record, by_its_launcher: bool) -> u64 {
    u64::from(
        record.outcome == Outcome::Aborted && record.measured.launcher_died == by_its_launcher,
    )
}

counts! {
    runs "runs", "runs", "Runs", Unlimited(0), |_| 1;
    completed "completed", "completed", "Runs that reached their end", Unlimited(0), |r| ended(r, Outcome::Completed);
    safe_stops "safe_stops", "safe stops", "Runs that ended in a safe stop", Shows(2), |r| ended(r, Outcome::SafeStop);
    collisions "collisions", "collisions", "Runs that ended in a collision", Shows(0), |r| ended(r, Outcome::Collision);
    interventions "interventions", "emergency brakings", "Interventions of the emergency brake", Shows(1),
        |r| r.measured.interventions;
    red_lights "red_lights", "red lights", "Runs that ended at a red light", Shows(0), |r| ended(r, Outcome::RedLight);
    driven_by_backup "driven_by_backup", "driven by backup", "Runs that the backup law drove", Shows(3),
        |r| ended(r, Outcome::DrivenByBackup);
    requirements_broken "requirements_broken", "requirement broken", "Runs that broke a requirement of their scenario",
        Shows(4), |r| ended(r, Outcome::RequirementBroken);
    aborted "aborted", "aborted", "Runs that were aborted", Shows(2), |r| aborted(r, false);
    avoidable_collisions "avoidable_collisions", "avoidable collisions", "That a braking reference avoids", Total,
        |r| u64::from(r.measured.avoidable);
    faults_struck "faults", "faults that acted", "Faults that acted", Total, |r| r.measured.faults;
    critical_faults "critical_faults", "faults in critical phases", "Faults that acted in a critical phase", Total,
        |r| r.measured.critical_faults;
    kills "kills", "processes killed", "Killed processes", Total, |r| r.measured.kills;
    double_kills "double_kills", "pairs killed within 5 ms", "Pairs of services killed within 5 ms", Total,
        |r| r.measured.double_kills;
    starting_kills "starting_kills", "killed while starting", "Killed before they took part", Total,
        |r| r.measured.starting_kills;
    helper_kills "helper_kills", "helpers killed", "Killed recorders, janitors and launchers", Total,
        |r| r.measured.helper_kills;
    launcher_kills "launcher_kills", "launchers killed", "Runs that ended with their launcher", Total,
        |r| aborted(r, true);
    recordings_lost "recordings_lost", "recordings lost", "Recordings that cannot be read or end early", Total,
        |r| u64::from(r.measured.recording_lost);
    unrecovered "unrecovered", "unrecovered", "Process faults without a recovery", Total, |r| r.measured.unrecovered;
    degraded "degraded", "services degraded at the end", "Services below the first level at the end", Total,
        |r| r.measured.degraded.len() as u64;
    leaks "leaks", "leftovers", "Objects and processes left behind", Total, |r| r.measured.leaks.len() as u64;
    messages_lost "messages_lost", "messages lost", "Lost messages", Total, |r| r.measured.messages_lost;
    disturbed "disturbed", "messages disturbed", "Disturbed by faults, over all receivers", UnlimitedTotal,
        |r| r.measured.disturbed;
    corrupted "corrupted", "messages corrupted", "Corrupted by faults", UnlimitedTotal, |r| r.measured.corrupted;
    undetected_corruptions "undetected_corruptions", "corruptions accepted", "Accepted corrupted messages", Total,
        |r| r.measured.undetected;
}

/// The counts that a campaign can limit, by the names behind `max_` and `min_`.
pub fn limited() -> impl Iterator<Item = (&'static str, fn(&Counts) -> u64)> {
    let all = NAMED.iter().zip(SHOWN);
    all.filter(|(_, shown)| matches!(shown, Shows(_) | Total)).map(|(named, _)| *named)
}

/// A figure over all runs.
#[derive(Clone, Copy)]
pub struct Figure {
    /// Name behind `max_` or `min_`.
    pub name: &'static str,
    of: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    /// A number of runs or events. Each run that has one is to blame.
    Count(fn(&Counts) -> u64),
    Measure(MeasuredFigure),
}

pub fn figures() -> impl Iterator<Item = Figure> {
    let counts = limited().map(|(name, of)| Figure { name, of: Kind::Count(of) });
    let measured =
        measured::limited().map(|figure| Figure { name: figure.name, of: Kind::Measure(figure) });
    counts.chain(measured)
}

impl Figure {
    pub fn named(name: &str) -> Option<Self> {
        figures().find(|figure| figure.name == name)
    }

    /// True if it counts runs or events.
    pub fn is_count(&self) -> bool {
        matches!(self.of, Kind::Count(_))
    }

    /// Its value over all runs; none if no run measured it.
    pub fn value(&self, tally: &Tally) -> Option<f64> {
        match self.of {
            Kind::Count(of) => Some(of(&tally.counts) as f64),
            Kind::Measure(figure) => (figure.of)(&tally.measures),
        }
    }
}

/// A limit of a figure: a `max_` or `min_` key and its value.
#[derive(Clone, Copy)]
pub struct Limit {
    pub figure: Figure,
    /// True for `min_`: the figure must be at least the value.
    is_least: bool,
    pub value: f64,
}

impl Limit {
    /// The limit of a key in a campaign that was checked.
    pub fn of(key: &str, value: f64) -> Self {
        let (bound, name) = key.split_at(4);
        let figure = Figure::named(name).expect("a campaign's keys are checked when it is read");
        Self { figure, is_least: bound == "min_", value }
    }

    /// True if it asks for a least number of things in all runs together.
    pub fn is_least_number(&self) -> bool {
        self.is_least && self.figure.is_count()
    }

    /// The limit for a share of the runs: least numbers shrink in proportion.
    pub fn for_share(self, share: f64) -> Self {
        let value = if self.is_least_number() { (self.value * share).floor() } else { self.value };
        Self { value, ..self }
    }

    /// True if a value keeps it.
    pub fn holds(&self, found: f64) -> bool {
        if self.is_least { found >= self.value } else { found <= self.value }
    }

    /// The figure of a single run, if that run is to blame for a broken limit.
    pub fn blames(&self, record: &Record) -> Option<f64> {
        let mut alone = Sum::default();
        alone.add(record);
        let alone = alone.tally();
        match self.figure.of {
            Kind::Count(of) => {
                Some(of(&alone.counts) as f64).filter(|count| *count > 0.0 && !self.is_least)
            }
            Kind::Measure(figure) if figure.is_median => None,
            Kind::Measure(figure) => {
                (figure.of)(&alone.measures).filter(|value| !self.holds(*value))
            }
        }
    }
}
