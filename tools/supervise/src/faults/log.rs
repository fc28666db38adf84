//! The log of all that went wrong in a run: when it began, was noticed and was over.

use drive::{FaultRecord, Recovery};
use messages::Service;
use scenario::faults::{Fault, Target};

/// Errors so far.
#[derive(Debug)]
pub struct FaultLog<R = Service> {
    /// In order of their beginning, as far as it is known.
    pub records: Vec<FaultRecord<R>>,
    /// The newest process of each member that has sent, and the run time of its first message, ns.
    heard: Vec<(R, u32, i64)>,
}

impl<R> Default for FaultLog<R> {
    fn default() -> Self {
        Self { records: Vec::new(), heard: Vec::new() }
    }
}

impl<R: Copy + PartialEq> FaultLog<R> {
    /// Notes a fault of `kind` that was asked for and begins at `now_ns`.
    pub fn asked(&mut self, kind: &str, service: Option<R>, now_ns: i64) {
        self.records.push(record(now_ns as f64 / 1e9, kind, service));
    }

    /// True while a service is to recover from a fault.
    pub fn is_recovery_awaited(&self) -> bool {
        self.records
            .iter()
            .any(|record| record.awaits.is_some() && record.recovered_after_us.is_none())
    }

    /// Notes that the launcher found `service` gone or hung at `now_ns`; its restart `awaits` will show its recovery.
    /// An unplanned fault gets a record of its own. It has that kind, and the run time `since_ns` of its start if
    /// that is known.
    pub fn detected(
        &mut self,
        service: R,
        kind: &str,
        awaits: u32,
        since_ns: Option<i64>,
        now_ns: i64,
    ) {
        let asked = self.records.iter_mut().rev().find(|record| {
            record.service == Some(service)
                && record.detected_after_us.is_none()
                && is_asked(record)
        });
        if let Some(record) = asked {
            record.detected_after_us = Some((now_ns as f64 - record.t_s * 1e9) / 1e3);
            record.awaits = Some(awaits);
            self.recovered_before(service, awaits);
            return;
        }
        // A hung service that was killed for it dies once.
        if self.records.iter().any(|r| r.service == Some(service) && r.awaits == Some(awaits)) {
            return;
        }
        let t_s = since_ns.unwrap_or(now_ns) as f64 / 1e9;
        self.records.push(FaultRecord {
            detected_after_us: since_ns.map(|since_ns| (now_ns - since_ns) as f64 / 1e3),
            awaits: Some(awaits),
            ..record(t_s, kind, Some(service))
        });
        self.recovered_before(service, awaits);
    }

    /// The first message of a standby may arrive before the news of the end that it follows.
    fn recovered_before(&mut self, service: R, awaits: u32) {
        let heard = self.heard.iter().find(|(of, process, _)| *of == service && *process >= awaits);
        if let Some(&(_, incarnation, ns)) = heard {
            self.recovered(service, incarnation, ns);
        }
    }

    /// Notes that the standby of `service` has taken over from process `old`. It noticed the end or silence of that
    /// process at `noticed_ns`.
    pub fn taken_over(&mut self, service: R, old: u32, kind: &str, noticed_ns: i64) {
        self.detected(service, kind, old + 1, None, noticed_ns);
        let record = self
            .records
            .iter_mut()
            .rev()
            .find(|record| record.service == Some(service) && record.awaits == Some(old + 1));
        if let Some(record) = record {
            let earlier_us = (record.t_s * 1e9 - noticed_ns as f64) / 1e3;
            if is_asked(record) {
                record.detected_after_us = Some(-earlier_us);
            } else if earlier_us > 0.0 {
                // The launcher noticed it after the standby.
                record.t_s = noticed_ns as f64 / 1e9;
                record.recovered_after_us = record.recovered_after_us.map(|us| us + earlier_us);
            }
            if record.kind == "died" {
                // The news of its end may have come first.
                record.kind = kind.into();
            }
            record.recovered_by = Some(Recovery::TakeOver);
        }
    }

    /// Notes the first fresh message of restart `incarnation` of `service`, published at `ns`.
    pub fn recovered(&mut self, service: R, incarnation: u32, ns: i64) {
        if !self.heard.contains(&(service, incarnation, ns)) {
            self.heard.retain(|(of, ..)| *of != service);
            self.heard.push((service, incarnation, ns));
        }
        for record in &mut self.records {
            // A process that died before it recovered leaves the recovery to the next one.
            if record.service == Some(service)
                && record.awaits.is_some_and(|awaits| awaits <= incarnation)
                && record.recovered_after_us.is_none()
            {
                record.recovered_after_us = Some((ns as f64 - record.t_s * 1e9) / 1e3);
                record.recovered_by.get_or_insert(Recovery::Restart);
            }
        }
    }
}

impl FaultLog {
    /// Notes the start of a fault at `t_s`, NaN if unknown yet. With `while_starting` it killed a process that was
    /// not in the run yet.
    pub fn begin(&mut self, fault: &Fault, number: u32, t_s: f64, while_starting: bool) {
        let target = fault.effect.target();
        let service = if let Target::Service(service) = target { Some(service) } else { None };
        let name = fault.effect.kind().name();
        let mut record = record(t_s, name, service);
        match target {
            Target::Topic(topic) => record.topic = Some(topic.name()),
            Target::Helper(helper) => record.helper = Some(helper),
            _ => {}
        }
        let messages = fault.effect.extent().map(|_| 0);
        self.records.push(FaultRecord { while_starting, messages, number, ..record });
    }

    /// Adds what the ports counted.
    pub fn count_messages(&mut self, counts: impl Iterator<Item = runtime::FaultStatistics>) {
        for count in counts {
            for record in self.records.iter_mut().filter(|record| record.number == count.fault) {
                let begun_s = count.begun_ns as f64 / 1e9;
                // A process that came later began to count later.
                let is_first = record.messages.is_none_or(|messages| messages == 0);
                record.t_s = if is_first { begun_s } else { record.t_s.min(begun_s) };
                record.messages = Some(record.messages.unwrap_or(0) + count.messages);
                record.undetected += count.undetected;
            }
        }
        // A fault that never began does not belong to the run.
        self.records.retain(|record| record.t_s.is_finite());
        self.records.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    }
}

/// The record of what began at `t_s`, before anything is known of its effect.
fn record<R>(t_s: f64, kind: &str, service: Option<R>) -> FaultRecord<R> {
    FaultRecord {
        t_s,
        kind: kind.to_owned(),
        service,
        topic: None,
        helper: None,
        while_starting: false,
        messages: None,
        undetected: 0,
        detected_after_us: None,
        recovered_after_us: None,
        recovered_by: None,
        number: u32::MAX,
        awaits: None,
    }
}

/// True if the record is of a fault that was asked for and ends or stops a process.
fn is_asked<R>(record: &FaultRecord<R>) -> bool {
    matches!(record.kind.as_str(), "kill" | "stop" | "restart-storm")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_death_that_was_not_asked_for_is_recorded_once_with_what_was_measured() {
        let mut log = FaultLog::default();
        log.detected(Service::Plant, "hung", 1, Some(5_000), 6_000);
        log.detected(Service::Plant, "died", 1, None, 7_000);
        log.detected(Service::Controller, "died", 1, None, 8_000);
        let [hung, died] = log.records.as_slice() else { panic!("two records") };
        assert_eq!((hung.kind.as_str(), hung.detected_after_us), ("hung", Some(1.0)));
        assert_eq!((died.t_s, died.detected_after_us), (8e-6, None), "its instant is not known");
    }
}
