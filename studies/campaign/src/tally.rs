//! Sums over runs.

use super::counts::Counts;
use super::record::Record;
use runtime::statistics::{Latencies, Percentiles};
use serde::Serialize;
use std::collections::BTreeMap;

/// Sums over some runs. `columns` describes the measured ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Tally {
    #[serde(flatten)]
    pub counts: Counts,
    pub phases: BTreeMap<String, u64>,
    pub min_gap_m: Option<f64>,
    pub min_ttc_s: Option<f64>,
    pub detection_us: Option<Percentiles>,
    pub recovery_us: Option<Percentiles>,
    pub take_over_us: Option<Percentiles>,
    pub command_overdue_ms: Option<f64>,
    pub rungs_s: BTreeMap<String, f64>,
    pub all_memory_kib: Option<f64>,
    pub all_descriptors: Option<f64>,
    pub all_shared_memory_kib: Option<f64>,
    pub memory_growth_kib: Option<f64>,
    pub memory_growth_of: String,
    pub descriptor_growth: Option<f64>,
    pub shared_memory_growth_kib: Option<f64>,
    pub shared_memory_object_growth: Option<f64>,
}

/// Sums while runs are added.
#[derive(Debug, Default)]
pub struct Sum {
    tally: Tally,
    /// Times after process faults. A histogram is large, and most campaigns have none.
    pub detection: Option<Latencies>,
    /// Times until the first message of the next process.
    pub recovery: Option<Latencies>,
    take_over: Option<Latencies>,
}

impl Sum {
    /// Adds a run. In another order the times on the levels may differ in their last digits.
    pub fn add(&mut self, record: &Record) {
        let (tally, found) = (&mut self.tally, &record.measured);
        tally.counts.add(record);
        for (phase, count) in &found.phases {
            *tally.phases.entry(phase.clone()).or_insert(0) += count;
        }
        for (rung, time_s) in &found.rungs_s {
            *tally.rungs_s.entry(rung.clone()).or_insert(0.0) += time_s;
        }
        keep(&mut tally.min_gap_m, found.min_gap_m, f64::min);
        keep(&mut tally.min_ttc_s, found.min_ttc_s, f64::min);
        keep(&mut tally.command_overdue_ms, found.command_overdue_ms, f64::max);
        if let Some(growth) = &found.growth {
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
        for (latencies, times_us) in [
            (&mut self.detection, &found.detection_us),
            (&mut self.recovery, &found.recovery_us),
            (&mut self.take_over, &found.take_over_us),
        ] {
            for us in times_us {
                latencies.get_or_insert_default().record_ns((us * 1e3) as i64);
            }
        }
    }

    /// The sums over the runs so far.
    pub fn tally(&self) -> Tally {
        let percentiles = |latencies: &Option<Latencies>| latencies.as_ref()?.percentiles_us();
        Tally {
            detection_us: percentiles(&self.detection),
            recovery_us: percentiles(&self.recovery),
            take_over_us: percentiles(&self.take_over),
            ..self.tally.clone()
        }
    }
}

/// Keeps the least or the largest of the found values.
fn keep(kept: &mut Option<f64>, found: Option<f64>, of: fn(f64, f64) -> f64) {
    *kept = kept.zip(found).map(|(kept, found)| of(kept, found)).or(*kept).or(found);
}
