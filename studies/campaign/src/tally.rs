//! Runs added up, and the figures that a campaign can require something of.

use super::record::Record;
use group::report::Outcome;
use runtime::statistics::{Latencies, Percentiles};
use serde::Serialize;
use std::collections::BTreeMap;

/// Some runs added up.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tally {
    pub runs: u64,
    pub completed: u64,
    pub collisions: u64,
    /// Collisions that a reference which brakes perfectly would have avoided.
    pub avoidable_collisions: u64,
    pub red_lights: u64,
    pub safe_stops: u64,
    /// Runs in which the law's backup drove more than the scenario allows.
    pub driven_by_backup: u64,
    pub aborted: u64,
    pub kills: u64,
    /// Pairs of services killed within 5 ms, processes killed before they took part, and recorders, janitors
    /// and launchers killed.
    pub double_kills: u64,
    pub starting_kills: u64,
    pub helper_kills: u64,
    /// Runs that ended with their launcher.
    pub launcher_kills: u64,
    pub recordings_lost: u64,
    /// Times that the emergency brake braked.
    pub interventions: u64,
    pub unrecovered: u64,
    /// Services that ended a completed run below the first level.
    pub degraded: u64,
    pub leaks: u64,
    pub messages_lost: u64,
    pub disturbed: u64,
    pub corrupted: u64,
    pub undetected_corruptions: u64,
    /// Faults that acted, those that acted in a critical phase, and how many in each phase.
    #[serde(rename = "faults")]
    pub faults_struck: u64,
    pub critical_faults: u64,
    pub phases: BTreeMap<String, u64>,
    pub min_gap_m: Option<f64>,
    pub min_ttc_s: Option<f64>,
    pub detection_us: Option<Percentiles>,
    pub recovery_us: Option<Percentiles>,
    /// Of these, where a standby that was ready took over.
    pub take_over_us: Option<Percentiles>,
    /// Longest time that the plant was without the command that was due, ms.
    pub command_overdue_ms: Option<f64>,
    /// Time of each service on each level of the ladder in all runs, s.
    pub rungs_s: BTreeMap<String, f64>,
    /// Largest sums over a run's services, and largest growth within a run, where it was sampled.
    pub all_memory_kib: Option<f64>,
    pub all_descriptors: Option<f64>,
    pub all_shared_memory_kib: Option<f64>,
    pub memory_growth_kib: Option<f64>,
    /// Whose memory grew most, by its name in `ps`.
    pub memory_growth_of: String,
    pub descriptor_growth: Option<f64>,
    pub shared_memory_growth_kib: Option<f64>,
    pub shared_memory_object_growth: Option<f64>,
}

/// Runs that are being added up.
#[derive(Debug, Default)]
pub struct Sum {
    tally: Tally,
    /// Made when the first time comes: most campaigns have none.
    detection: Option<Latencies>,
    recovery: Option<Latencies>,
    take_over: Option<Latencies>,
}

impl Sum {
    /// Adds a run. In another order the times on the levels may differ in their last digits.
    pub fn add(&mut self, record: &Record) {
        let tally = &mut self.tally;
        tally.runs += 1;
        // A group whose launcher is killed ends in no other way than aborted.
        *match record.outcome {
            Outcome::Completed => &mut tally.completed,
            Outcome::Collision => &mut tally.collisions,
            Outcome::RedLight => &mut tally.red_lights,
            Outcome::SafeStop => &mut tally.safe_stops,
            Outcome::DrivenByBackup => &mut tally.driven_by_backup,
            Outcome::Aborted if record.launcher_died => &mut tally.launcher_kills,
            Outcome::Aborted => &mut tally.aborted,
        } += 1;
        tally.avoidable_collisions += u64::from(record.avoidable);
        tally.kills += record.kills;
        tally.double_kills += record.double_kills;
        tally.starting_kills += record.starting_kills;
        tally.helper_kills += record.helper_kills;
        tally.recordings_lost += u64::from(record.recording_lost);
        tally.interventions += record.interventions;
        tally.unrecovered += record.unrecovered;
        tally.degraded += record.degraded.len() as u64;
        tally.leaks += record.leaks.len() as u64;
        tally.messages_lost += record.messages_lost;
        tally.disturbed += record.disturbed;
        tally.corrupted += record.corrupted;
        tally.undetected_corruptions += record.undetected;
        tally.faults_struck += record.faults;
        tally.critical_faults += record.critical_faults;
        for (phase, count) in &record.phases {
            *tally.phases.entry(phase.clone()).or_insert(0) += count;
        }
        for (rung, time_s) in &record.rungs_s {
            *tally.rungs_s.entry(rung.clone()).or_insert(0.0) += time_s;
        }
        keep(&mut tally.min_gap_m, record.min_gap_m, f64::min);
        keep(&mut tally.min_ttc_s, record.min_ttc_s, f64::min);
        keep(&mut tally.command_overdue_ms, record.command_overdue_ms, f64::max);
        if let Some(growth) = &record.growth {
            if tally.memory_growth_kib.is_none_or(|most| growth.memory_kib > most) {
                tally.memory_growth_of.clone_from(&growth.memory_of);
            }
            for (most, found) in [
                (&mut tally.all_memory_kib, growth.all_memory_kib),
                (&mut tally.all_descriptors, growth.all_descriptors),
                (&mut tally.all_shared_memory_kib, growth.all_shared_memory_kib),
                (&mut tally.memory_growth_kib, growth.memory_kib),
                (&mut tally.descriptor_growth, growth.descriptors),
                (&mut tally.shared_memory_growth_kib, growth.shared_memory_kib),
                (&mut tally.shared_memory_object_growth, growth.shared_memory_objects),
            ] {
                keep(most, Some(found), f64::max);
            }
        }
        for us in &record.detection_us {
            self.detection.get_or_insert_default().record_ns((us * 1e3) as i64);
        }
        for us in &record.recovery_us {
            self.recovery.get_or_insert_default().record_ns((us * 1e3) as i64);
        }
        for us in &record.take_over_us {
            self.take_over.get_or_insert_default().record_ns((us * 1e3) as i64);
        }
    }

    /// What the runs come to.
    pub fn tally(self) -> Tally {
        let percentiles = |latencies: Option<Latencies>| {
            latencies.and_then(|latencies| latencies.percentiles_us())
        };
        Tally {
            detection_us: percentiles(self.detection),
            recovery_us: percentiles(self.recovery),
            take_over_us: percentiles(self.take_over),
            ..self.tally
        }
    }
}

/// Keeps the lesser or the greater of what was kept and what was found.
fn keep(kept: &mut Option<f64>, found: Option<f64>, of: fn(f64, f64) -> f64) {
    *kept = kept.zip(found).map(|(kept, found)| of(kept, found)).or(*kept).or(found);
}

/// True if `value` is at most `limit`, or at least, if that is the `least` it may be.
pub fn within(value: f64, limit: f64, least: bool) -> bool {
    if least { value >= limit } else { value <= limit }
}

/// A figure that a campaign can require something of.
pub struct Figure {
    /// Name behind `max_` or `min_`.
    pub name: &'static str,
    of: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    /// A number of runs or events: a run is to blame as soon as it has one.
    Count(fn(&Tally) -> u64),
    /// Something measured, or not.
    Measure(fn(&Tally) -> Option<f64>),
    /// The middle of something measured: no single run is to blame for it.
    Median(fn(&Tally) -> Option<f64>),
}

/// All figures.
pub const FIGURES: [Figure; 36] = [
    count("collisions", |t| t.collisions),
    count("avoidable_collisions", |t| t.avoidable_collisions),
    count("red_lights", |t| t.red_lights),
    count("safe_stops", |t| t.safe_stops),
    count("driven_by_backup", |t| t.driven_by_backup),
    count("aborted", |t| t.aborted),
    count("kills", |t| t.kills),
    count("double_kills", |t| t.double_kills),
    count("starting_kills", |t| t.starting_kills),
    count("helper_kills", |t| t.helper_kills),
    count("launcher_kills", |t| t.launcher_kills),
    count("recordings_lost", |t| t.recordings_lost),
    count("interventions", |t| t.interventions),
    count("unrecovered", |t| t.unrecovered),
    count("degraded", |t| t.degraded),
    count("leaks", |t| t.leaks),
    count("messages_lost", |t| t.messages_lost),
    count("undetected_corruptions", |t| t.undetected_corruptions),
    count("faults_struck", |t| t.faults_struck),
    count("critical_faults", |t| t.critical_faults),
    measure("gap_m", |t| t.min_gap_m),
    measure("ttc_s", |t| t.min_ttc_s),
    median("detection_p50_ms", |t| t.detection_us.map(|p| p.p50 / 1e3)),
    measure("detection_p99_ms", |t| t.detection_us.map(|p| p.p99 / 1e3)),
    measure("detection_max_ms", |t| t.detection_us.map(|p| p.max / 1e3)),
    median("recovery_p50_ms", |t| t.recovery_us.map(|p| p.p50 / 1e3)),
    measure("recovery_p99_ms", |t| t.recovery_us.map(|p| p.p99 / 1e3)),
    measure("recovery_max_ms", |t| t.recovery_us.map(|p| p.max / 1e3)),
    median("take_over_p50_ms", |t| t.take_over_us.map(|p| p.p50 / 1e3)),
    measure("take_over_p99_ms", |t| t.take_over_us.map(|p| p.p99 / 1e3)),
    measure("take_over_max_ms", |t| t.take_over_us.map(|p| p.max / 1e3)),
    measure("command_overdue_ms", |t| t.command_overdue_ms),
    measure("memory_growth_kib", |t| t.memory_growth_kib),
    measure("descriptor_growth", |t| t.descriptor_growth),
    measure("shared_memory_growth_kib", |t| t.shared_memory_growth_kib),
    measure("shared_memory_object_growth", |t| t.shared_memory_object_growth),
];

const fn count(name: &'static str, of: fn(&Tally) -> u64) -> Figure {
    Figure { name, of: Kind::Count(of) }
}

const fn measure(name: &'static str, of: fn(&Tally) -> Option<f64>) -> Figure {
    Figure { name, of: Kind::Measure(of) }
}

const fn median(name: &'static str, of: fn(&Tally) -> Option<f64>) -> Figure {
    Figure { name, of: Kind::Median(of) }
}

impl Figure {
    /// The figure of that name.
    pub fn named(name: &str) -> Option<&'static Self> {
        FIGURES.iter().find(|figure| figure.name == name)
    }

    /// True if it counts runs or events.
    pub fn is_count(&self) -> bool {
        matches!(self.of, Kind::Count(_))
    }

    /// Its value over all runs; none if nothing measured it.
    pub fn value(&self, tally: &Tally) -> Option<f64> {
        match self.of {
            Kind::Count(of) => Some(of(tally) as f64),
            Kind::Measure(of) | Kind::Median(of) => of(tally),
        }
    }

    /// Its value in a single run, if the run is to blame for more than `limit`, or less if `least`.
    pub fn blames(&self, record: &Record, limit: f64, least: bool) -> Option<f64> {
        let mut alone = Sum::default();
        alone.add(record);
        let alone = alone.tally();
        match self.of {
            Kind::Count(of) => Some(of(&alone) as f64).filter(|count| *count > 0.0 && !least),
            Kind::Measure(of) => of(&alone).filter(|value| !within(*value, limit, least)),
            Kind::Median(_) => None,
        }
    }
}

/// The figure of a `max_` or `min_` key, and whether it is the least that it may be.
pub(super) fn figure(key: &str) -> (&'static Figure, bool) {
    let (bound, name) = key.split_at(4);
    let figure = Figure::named(name).expect("the campaign's keys were checked when it was read");
    (figure, bound == "min_")
}

/// True if a requirement asks for so many of a thing in all runs together.
pub(super) fn is_least_number(key: &str) -> bool {
    let (figure, least) = figure(key);
    least && figure.is_count()
}

/// What a requirement asks of a share of the runs: of a least number that share.
pub(super) fn limit_of_part(key: &str, limit: f64, share: f64) -> f64 {
    if is_least_number(key) { (limit * share).floor() } else { limit }
}
