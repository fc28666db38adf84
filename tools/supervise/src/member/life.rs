//! A service's whole life: what all its processes counted, as one report.
//!
//! A process that dies leaves its account in shared memory ([`LastAccount`]). Its histograms go on over all
//! processes of a service ([`Figures`]). The launcher has received its messages on the topics.

use controller::laws;
use drive::log::{CycleHistory, DriveLog};
use drive::report::{
    ControllerReport, ModeChange, ObuReport, Outcome, Payload, PlantReport, ServiceReport,
};
use messages::Service;
use runtime::scheduling::Granted;
use runtime::statistics::Percentiles;
use runtime::{Figures, Group, LastAccount, RELEASE_JITTER};
use scenario::Scenario;
use std::collections::BTreeMap;

/// Remains of process `incarnation` of `service`, which is gone without a report: no counts, if it kept no account.
pub fn left_by(
    group: &Group,
    service: Service,
    incarnation: u32,
    scheduling: Granted,
) -> ServiceReport {
    let account = LastAccount::take(group, service, incarnation).unwrap_or_default();
    ServiceReport {
        service,
        cycles: account.cycles,
        skipped: account.skipped,
        release_jitter_us: None,
        sent: account.sent,
        received: account.received,
        allocations_in_loop: None,
        peak_rss_kib: None,
        scheduling,
        fault_statistics: account.faults,
        details: Payload::default(),
    }
}

/// One report of all processes of a service, in order; `None` without any.
pub fn whole(reports: Vec<ServiceReport>) -> Option<ServiceReport> {
    let mut reports = reports.into_iter().rev();
    // A figure that cannot be added is the last one's, which includes the earlier ones.
    let mut whole = reports.next()?;
    for earlier in reports {
        whole.cycles += earlier.cycles;
        whole.skipped += earlier.skipped;
        whole.peak_rss_kib = whole.peak_rss_kib.max(earlier.peak_rss_kib);
        whole.fault_statistics.extend(earlier.fault_statistics);
        for sent in earlier.sent {
            match whole.sent.iter_mut().find(|known| known.topic == sent.topic) {
                Some(known) => known.sent += sent.sent,
                None => whole.sent.push(sent),
            }
        }
        for received in earlier.received {
            match whole.received.iter_mut().find(|known| known.topic == received.topic) {
                Some(known) => {
                    known.received += received.received;
                    known.lost += received.lost;
                    known.e2e.add(&received.e2e);
                }
                None => whole.received.push(received),
            }
        }
    }
    Some(whole)
}

/// Lateness of the releases over all processes of `service`; none if they kept none.
pub fn release_jitter_us(group: &Group, service: Service) -> Option<Percentiles> {
    Figures::of(group, service).latencies(RELEASE_JITTER).ok()?.percentiles_us()
}

/// Work of all the controller's processes, as the launcher received it on `control/diagnostics` and
/// `control/command`. `last` is the report of the last one, if it made one.
pub fn of_controller(
    group: &Group,
    scenario: &Scenario,
    log: &DriveLog,
    last: Option<&ControllerReport>,
) -> ControllerReport {
    let history = log.history();
    let deadline_us = f64::from(scenario.controller.deadline().value()) * 1e3;
    ControllerReport {
        deadline_us,
        deadline_misses: log.late_commands() + history.left_out,
        solve_us: controller::last_law_times(group).or(last.and_then(|last| last.solve_us)),
        relaxed: history.of_quality(1),
        backup: history.by_backup,
        braked: history.by_ladder,
        planning: last.and_then(|last| last.planning),
        law: last.map(|last| last.law.clone()).unwrap_or_default(),
        program: last.and_then(|last| last.program.clone()),
        mode_changes: mode_changes(scenario, history),
        rungs: history.levels.report(),
        checks: last.map(|last| last.checks.clone()).unwrap_or_default(),
    }
}

fn mode_changes(scenario: &Scenario, history: &CycleHistory) -> Vec<ModeChange> {
    let (modes, figures) = (laws::mode_names(scenario), laws::figure_names(scenario));
    let reasons = laws::formulation(scenario).map_or(&[][..], |law| law.reasons);
    let name = |names: &[&str], index: u32| {
        names.get(index as usize).map_or_else(|| index.to_string(), ToString::to_string)
    };
    let changes = history.changes.iter();
    changes
        .map(|(before, cycle)| ModeChange {
            t_s: cycle.header.acquisition_ns as f64 / 1e9,
            from: name(modes, *before),
            to: name(modes, cycle.mode),
            reason: name(reasons, cycle.mode_reason),
            figures: figures
                .iter()
                .zip(cycle.figures)
                .filter(|(_, value)| value.is_finite())
                .map(|(name, value)| ((*name).to_owned(), value))
                .collect::<BTreeMap<_, _>>(),
        })
        .collect()
}

/// Adds figures of processes that could not report them.
pub fn complete(whole: &mut ServiceReport, group: &Group, scenario: &Scenario, log: &DriveLog) {
    whole.release_jitter_us = release_jitter_us(group, whole.service).or(whole.release_jitter_us);
    let details = &whole.details;
    let known = match whole.service {
        Service::Controller => {
            let report = of_controller(group, scenario, log, details.read().as_ref());
            // A program of the user's keeps no account; its cycles were counted by its messages.
            whole.cycles = whole.cycles.max(log.history().count);
            Some(Payload::of(&report))
        }
        Service::Plant if details.read::<PlantReport>().is_none() => {
            let report = plant::last_known(group).unwrap_or_else(|| PlantReport {
                duration_s: log.reached_s(),
                control: log.figures(),
                outcome: Outcome::Aborted,
                ..PlantReport::default()
            });
            Some(Payload::of(&report))
        }
        Service::Aebs => Some(Payload::of(&aebs::last_known(group, scenario, whole.skipped))),
        Service::Obu if details.read::<ObuReport>().is_none() => {
            obu::last_known(group).map(|report| Payload::of(&report))
        }
        // The counts in shared memory are all that is known.
        _ => None,
    };
    if let Some(known) = known {
        whole.details = known;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drive::report::{ReceivedTopic, SentTopic};

    fn report(cycles: u64, odometry: u64) -> ServiceReport {
        let topic = || "vehicle/odometry".to_owned();
        ServiceReport {
            service: Service::Controller,
            cycles,
            skipped: 1,
            release_jitter_us: None,
            sent: vec![SentTopic { topic: topic(), sent: odometry, digest: None }],
            received: vec![ReceivedTopic {
                topic: topic(),
                received: odometry,
                lost: 2,
                e2e: messages::e2e::Outcomes { ok: odometry, ..Default::default() },
            }],
            allocations_in_loop: None,
            peak_rss_kib: Some(cycles),
            scheduling: Granted {
                requested: "other".into(),
                granted: "other".into(),
                core: None,
                memory_locked: false,
                refused: Vec::new(),
            },
            fault_statistics: Vec::new(),
            details: Payload::default(),
        }
    }

    #[test]
    fn the_counts_of_all_processes_add_up() {
        let whole = whole(vec![report(5, 50), report(7, 70), report(1, 10)]).expect("three");
        assert_eq!((whole.cycles, whole.skipped, whole.peak_rss_kib), (13, 3, Some(7)));
        assert_eq!(whole.sent[0].sent, 130);
        assert_eq!((whole.received[0].received, whole.received[0].lost), (130, 6));
        assert_eq!(whole.received[0].e2e.ok, 130);
        assert!(super::whole(Vec::new()).is_none());
    }
}
