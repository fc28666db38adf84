//! The record of a run: the figures that the verdict needs.

use super::exposure::Struck;
use frame::batch::{Done, Growth};
use messages::level::{Level, LevelChange};
use scenario::faults::{Helper, Kind};
use scenario::{Scenario, Setting};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use supervise::report::Outcome;
use supervise::{
    Error, Evidence, FaultRecord, Recovery, RequirementVerdict, is_avoidable_collision,
};

/// Two kills within this time are a double kill, s.
const DOUBLE_S: f64 = 0.005;

/// One run, in one line of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Its number in the campaign.
    pub run: usize,
    pub scenario: String,
    pub controller: String,
    pub fault: String,
    pub seed: u32,
    /// Parameters of an OpenSCENARIO file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<String>,
    pub outcome: Outcome,
    /// Reason why the outcome is `aborted`.
    pub aborted_because: Option<String>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub requirements: Vec<RequirementVerdict>,
    #[serde(flatten)]
    pub measured: Measured,
}

/// Figures of a run. The default is a run that was aborted before anything was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// It ended in a collision that the reference driver of `no-avoidable-collision` avoids.
    pub avoidable: bool,
    pub duration_s: f64,
    pub min_gap_m: Option<f64>,
    pub min_ttc_s: Option<f64>,
    pub kills: u64,
    /// Pairs of services killed within [`DOUBLE_S`].
    pub double_kills: u64,
    /// Processes killed before they took part.
    pub starting_kills: u64,
    /// Killed processes that are not a service.
    pub helper_kills: u64,
    /// The launcher was killed, and the group ended with it.
    pub launcher_died: bool,
    /// The recording cannot be read, or ends early although the recorder was not killed.
    pub recording_lost: bool,
    /// Times from a process fault until the launcher noticed it, µs.
    pub detection_us: Vec<f64>,
    /// Times from a process fault until the first fresh message of the next process, µs.
    pub recovery_us: Vec<f64>,
    /// Those of them in which a ready standby took over.
    pub take_over_us: Vec<f64>,
    /// Interventions of the emergency brake.
    pub interventions: u64,
    /// Process faults without a recovery in a completed run.
    pub unrecovered: u64,
    /// Time of each service on each degradation level, s.
    pub rungs_s: BTreeMap<String, f64>,
    /// Services below the first level at the end of a completed run.
    pub degraded: Vec<String>,
    /// Longest time that the plant was without the command that was due, ms.
    pub command_overdue_ms: Option<f64>,
    pub messages_lost: u64,
    /// Messages disturbed by faults, over all their receivers.
    pub disturbed: u64,
    /// Messages corrupted by faults.
    pub corrupted: u64,
    /// Corrupted messages that were accepted.
    pub undetected: u64,
    pub faults: u64,
    /// Faults that acted in a critical phase.
    pub critical_faults: u64,
    /// Faults that acted in each phase.
    pub phases: BTreeMap<String, u64>,
    /// Received radio frames by the on-board unit's verdict.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub frames: BTreeMap<String, u64>,
    /// Leftovers of the run.
    pub leaks: Vec<String>,
    /// Growth of memory and descriptors, where it was sampled.
    pub growth: Option<Growth>,
}

impl Record {
    /// The record of a planned run that ended, or that could not be brought up.
    pub fn new(planned: &Planned, scenario: &Scenario, result: &Result<Done, Error>) -> Self {
        let aborted = Self::aborted(planned, scenario);
        match result {
            Ok(done) => Self {
                outcome: done.summary.outcome,
                aborted_because: done.summary.aborted_because.clone(),
                requirements: done.summary.requirements.clone(),
                measured: Measured::of(scenario, done),
                ..aborted
            },
            Err(error) => Self { aborted_because: Some(error.to_string()), ..aborted },
        }
    }

    /// The record of a run that was aborted before anything was measured.
    pub fn aborted(planned: &Planned, scenario: &Scenario) -> Self {
        Self {
            run: planned.run,
            scenario: planned.scenario.clone(),
            controller: scenario.controller.name.as_str().into(),
            fault: planned.fault.clone(),
            seed: planned.seed,
            parameters: planned.parameters.clone(),
            outcome: Outcome::Aborted,
            aborted_because: None,
            requirements: Vec::new(),
            measured: Measured::default(),
        }
    }
}

impl Measured {
    fn of(scenario: &Scenario, done: &Done) -> Self {
        let summary = &done.summary;
        let impact_speed_mps = summary.control.figures.impact_speed_mps;
        let evidence = Evidence { scenario, drive: &done.drive, impact_speed_mps };
        let collided = summary.outcome == Outcome::Collision;
        let kills = [Kind::Kill, Kind::RestartStorm, Kind::KillHelper].map(Kind::name);
        let faults = &summary.faults;
        let killed = faults.iter().filter(|fault| kills.contains(&fault.kind.as_str()));
        let recorder_killed = faults.iter().any(|fault| fault.helper == Some(Helper::Recorder));
        let corrupted = faults.iter().filter(|fault| fault.kind == Kind::Corrupt.name());
        let corrupted = corrupted.filter_map(|fault| fault.messages).sum();
        let unrecovered = faults.iter().filter(|fault| {
            fault.detected_after_us.is_some() && fault.recovered_after_us.is_none()
        });
        let struck = Struck::of(scenario, faults, &done.drive.steps);
        Self {
            faults: struck.faults,
            critical_faults: struck.critical,
            phases: struck.phases,
            avoidable: collided && is_avoidable_collision(&evidence),
            duration_s: summary.duration_s,
            min_gap_m: summary.control.figures.min_gap_m,
            min_ttc_s: summary.control.figures.min_ttc_s,
            kills: killed.clone().count() as u64,
            double_kills: double_kills(killed.clone()),
            starting_kills: killed.clone().filter(|fault| fault.while_starting).count() as u64,
            helper_kills: killed.filter(|fault| fault.helper.is_some()).count() as u64,
            recording_lost: summary.recording.as_ref().is_some_and(|recording| {
                recording.messages == 0 || (recording.failed.is_some() && !recorder_killed)
            }),
            detection_us: faults.iter().filter_map(|fault| fault.detected_after_us).collect(),
            recovery_us: faults.iter().filter_map(|fault| fault.recovered_after_us).collect(),
            take_over_us: (faults.iter())
                .filter(|fault| fault.recovered_by == Some(Recovery::TakeOver))
                .filter_map(|fault| fault.recovered_after_us)
                .collect(),
            interventions: summary.aebs.interventions.unwrap_or(0),
            unrecovered: match summary.outcome {
                Outcome::Completed => unrecovered.count() as u64,
                // Services are restarted neither after the end nor in the safe state.
                _ => 0,
            },
            rungs_s: (summary.rungs.iter())
                .flat_map(|(service, rungs)| rungs.time_s.iter().map(move |r| (service, r)))
                .map(|(service, (rung, time_s))| (format!("{service} {rung}"), *time_s))
                .collect(),
            degraded: match summary.outcome {
                Outcome::Completed => (summary.rungs.iter())
                    .filter_map(|(service, rungs)| Some((service, rungs.changes.last()?.to)))
                    .filter(|(_, last)| *last != Level::Full)
                    .map(|(service, last)| format!("{service} ended on {}", last.name()))
                    .collect(),
                _ => Vec::new(),
            },
            command_overdue_ms: (summary.rungs.get("plant"))
                .map(|rungs| overdue_ms(&rungs.changes, summary.duration_s)),
            messages_lost: summary.messages.values().filter_map(|topic| topic.lost).sum(),
            disturbed: faults.iter().filter_map(|fault| fault.messages).sum(),
            corrupted,
            undetected: faults.iter().map(|fault| fault.undetected).sum(),
            frames: summary.radio.as_ref().map(|radio| radio.verdicts.clone()).unwrap_or_default(),
            leaks: done.leftovers.clone(),
            growth: Growth::over(&done.samples),
            launcher_died: false,
        }
    }
}

/// Pairs of neighbours in time that struck two services within [`DOUBLE_S`].
fn double_kills<'a>(killed: impl Iterator<Item = &'a FaultRecord>) -> u64 {
    let mut killed: Vec<_> = killed.filter(|fault| fault.service.is_some()).collect();
    killed.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    let pairs = killed
        .windows(2)
        .filter(|pair| pair[1].t_s - pair[0].t_s <= DOUBLE_S && pair[0].service != pair[1].service);
    pairs.count() as u64
}

/// Longest time without the command that was due, ms, from the plant's changes of level in a run of `duration_s`.
/// Meanwhile the plant follows the last plan or stops in lane. Such a time may last to the end of the run.
fn overdue_ms(changes: &[LevelChange], duration_s: f64) -> f64 {
    let is_without = |level| matches!(level, Level::PlanFollowed | Level::StopInLane);
    let mut since_s = None;
    let mut longest_s: f64 = 0.0;
    for change in changes {
        if is_without(change.to) {
            since_s.get_or_insert(change.t_s);
        } else if let Some(since_s) = since_s.take() {
            longest_s = longest_s.max(change.t_s - since_s);
        }
    }
    let at_the_end_s = since_s.map_or(0.0, |since_s| duration_s - since_s);
    longest_s.max(at_the_end_s) * 1e3
}

/// A run of a campaign.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Its number, from 0.
    pub run: usize,
    /// Scenario, as the campaign names it.
    pub scenario: String,
    /// Controller, if the campaign names one.
    pub controller: Option<String>,
    pub fault: String,
    pub seed: u32,
    /// Keys set in it; the last ones are its faults.
    pub settings: Vec<Setting>,
    /// Requirements beside the scenario's, as for `--require`.
    pub formulas: Vec<String>,
    /// Parameters of an OpenSCENARIO file, as for `--param`.
    pub parameters: Vec<String>,
}

impl Planned {
    /// The command that repeats the run.
    pub fn repeat(&self, mode: &str) -> String {
        let seed = self.seed.to_string();
        let mut words = vec!["timegap", "run", &self.scenario];
        if let Some(controller) = &self.controller {
            words.extend(["--controller", controller]);
        }
        words.extend(["--mode", mode, "--seed", &seed]);
        let settings: Vec<String> = self.settings.iter().map(Setting::to_string).collect();
        words.extend(settings.iter().flat_map(|setting| ["--set", setting]));
        words.extend(self.parameters.iter().flat_map(|parameter| ["--param", parameter]));
        words.extend(self.formulas.iter().flat_map(|formula| ["--require", formula]));
        runtime::command_line(&words)
    }

    /// The faults of the run in words, each once: kind and target.
    pub fn faults(&self) -> Vec<String> {
        let faults = self.settings.iter().rev().find(|setting| setting.key() == "faults");
        let faults = faults.and_then(|faults| faults.value().as_array());
        let word = |fault: &toml::Value| {
            let of = |key: &str| fault.get(key).and_then(toml::Value::as_str);
            let words = ["kind", "service", "helper", "topic", "field"].into_iter().filter_map(of);
            words.collect::<Vec<_>>().join(" ")
        };
        let mut words: Vec<String> = faults.into_iter().flatten().map(word).collect();
        words.sort();
        words.dedup();
        words
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_time_without_a_command_counts_from_end_to_end() {
        let change = |t_s, from, to| LevelChange { t_s, from, to };
        let changes = [
            change(0.5, Level::Full, Level::Emergency),
            change(0.9, Level::Emergency, Level::Full),
            change(1.0, Level::Full, Level::PlanFollowed),
            change(1.25, Level::PlanFollowed, Level::Full),
            change(2.0, Level::Full, Level::PlanFollowed),
            change(2.25, Level::PlanFollowed, Level::StopInLane),
            change(2.5, Level::StopInLane, Level::Full),
            change(9.0, Level::Full, Level::PlanFollowed),
        ];
        assert_eq!(overdue_ms(&changes, 9.25), 500.0, "the emergency brake's time is not counted");
        assert_eq!(overdue_ms(&changes, 30.0), 21_000.0, "to the end, when commands stay away");
        assert_eq!(overdue_ms(&[], 30.0), 0.0);
    }
}
