//! Faults that act on processes, and the record of all that went wrong.

use super::disturbance::Disturbance;
use messages::{Drive, Service};
use scenario::Scenario;
use scenario::faults::{Effect, Fault, Helper, ProcessFault, Target};
use serde::Serialize;

/// One thing that went wrong, asked for or not.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultRecord {
    /// Run time at which it began, s.
    pub t_s: f64,
    /// Kind of the fault, or `died`, `hung` or `flooded` for one that was not asked for.
    pub kind: String,
    /// The service that it acts on.
    pub service: Option<Service>,
    /// The topic whose messages it acts on.
    pub topic: Option<&'static str>,
    /// The process that it acts on, which is no service.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub helper: Option<Helper>,
    /// The process that it killed had not taken part in the run yet.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub while_starting: bool,
    /// Messages that it changed, summed over the topic's ports.
    pub messages: Option<u64>,
    /// Messages that it corrupted and a receiver took for intact.
    #[serde(skip_serializing_if = "is_zero")]
    pub undetected: u64,
    /// Until the launcher knew that the service was gone or hung, µs; null for a death whose instant
    /// is not known.
    pub detected_after_us: Option<f64>,
    /// Until the first fresh message of the service's next process, µs.
    pub recovered_after_us: Option<f64>,
    /// Whose message that was.
    pub recovered_by: Option<Recovery>,
    /// Its number in the run, for the ports' counts.
    #[serde(skip)]
    pub number: u32,
    /// Restart of the service whose first message is the recovery.
    #[serde(skip)]
    pub awaits: Option<u32>,
}

/// The process that took the place of one that is gone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Recovery {
    /// One that was started for it.
    Restart,
    /// The standby.
    TakeOver,
}

impl Recovery {
    /// Name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Restart => "restart",
            Self::TakeOver => "take-over",
        }
    }
}

/// A fault that is due or under way.
#[derive(Debug)]
struct Planned {
    number: u32,
    fault: Fault,
    process_fault: ProcessFault,
    /// When it begins, ns of run time; unknown while it waits for its condition.
    begin_ns: Option<i64>,
    /// Kills left of a storm.
    left: u16,
    /// The process that was killed last, as a restart of its service.
    killed: Option<u32>,
    /// What runs while it lasts, and until when.
    running: Option<(i64, Option<Disturbance>)>,
    done: bool,
}

/// A service's active process that lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Living {
    /// Which process of the service it is.
    pub incarnation: u32,
    /// Since when it starts, run time in ns; none: it takes part in the run.
    pub starting_since_ns: Option<i64>,
}

/// What the supervisor is to do to a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// SIGKILL.
    Kill(Service),
    /// SIGKILL to a process that is no service.
    KillHelper(Helper),
    /// SIGSTOP.
    Stop(Service),
    /// SIGCONT.
    Continue(Service),
    /// Keep a core, or all, busy.
    Hog(Option<u16>),
    /// Take so much memory, MiB.
    Memory(u32),
}

impl Planned {
    /// True if a kill strikes this process at `now_ns`: one that it has not killed yet, and that takes part,
    /// or that a storm leaves out.
    fn is_to_kill(&self, one: Living, now_ns: i64) -> bool {
        let after_ns = match &self.process_fault {
            ProcessFault::RestartStorm { after_start_ms: Some(after), .. }
                if self.killed.is_some() =>
            {
                i64::try_from(after.nanoseconds()).ok()
            }
            _ => None,
        };
        let is_ripe = match (one.starting_since_ns, after_ns) {
            (None, _) => true,
            (Some(since_ns), Some(after_ns)) => now_ns - since_ns >= after_ns,
            (Some(_), None) => false,
        };
        is_ripe && self.killed != Some(one.incarnation)
    }
}

/// The faults of a run that act on processes, and the record of all.
#[derive(Debug)]
pub struct Faults {
    planned: Vec<Planned>,
    /// What went wrong so far.
    pub records: Vec<FaultRecord>,
    next_number: u32,
    /// The newest process of each service that was heard, and the run time of its first message, ns.
    heard: Vec<(Service, u32, i64)>,
}

impl Faults {
    /// Those of the scenario.
    pub fn of(scenario: &Scenario) -> Self {
        let mut faults =
            Self { planned: Vec::new(), records: Vec::new(), next_number: 0, heard: Vec::new() };
        for fault in &scenario.faults {
            faults.plan(fault.clone(), fault.begin.known_ns());
        }
        faults
    }

    /// Adds a fault; returns its number in the run.
    pub fn plan(&mut self, fault: Fault, begin_ns: Option<i64>) -> u32 {
        let number = self.next_number;
        self.next_number += 1;
        match &fault.effect {
            Effect::Process(process_fault) => {
                let process_fault = process_fault.clone();
                let left = match process_fault {
                    ProcessFault::RestartStorm { times, .. } => times.value(),
                    ProcessFault::Kill { .. }
                    | ProcessFault::Stop { .. }
                    | ProcessFault::KillHelper { .. }
                    | ProcessFault::Hog { .. }
                    | ProcessFault::Memory { .. } => 1,
                };
                self.planned.push(Planned {
                    number,
                    fault,
                    process_fault,
                    begin_ns,
                    left,
                    killed: None,
                    running: None,
                    done: false,
                });
            }
            Effect::Channel(_) | Effect::Sender(_) => self.records.push(FaultRecord {
                t_s: begin_ns.map_or(f64::NAN, |begin| begin as f64 / 1e9),
                ..record(&fault, number)
            }),
        }
        number
    }

    /// What is due at `now_ns`, with the ego driving so. `living` tells of a service's active process; a
    /// storm waits for the next one.
    pub fn due(
        &mut self,
        now_ns: i64,
        ego: Option<Drive>,
        living: impl Fn(Service) -> Option<Living>,
    ) -> Vec<(usize, Act)> {
        let up = |service| living(service).filter(|one| one.starting_since_ns.is_none());
        let mut acts = Vec::new();
        for (index, planned) in self.planned.iter_mut().enumerate() {
            if let (None, Some(drive)) = (planned.begin_ns, &ego)
                && planned.fault.begin.is_met(drive)
            {
                planned.begin_ns = Some(now_ns);
            }
            if let Some((until_ns, disturbance)) = &mut planned.running
                && now_ns >= *until_ns
            {
                // Hogs end with their handle.
                disturbance.take();
                planned.running = None;
                if let ProcessFault::Stop { service, .. } = planned.process_fault {
                    acts.push((index, Act::Continue(service)));
                }
            }
            if planned.done || planned.begin_ns.is_none_or(|begin| now_ns < begin) {
                continue;
            }
            let act = match planned.process_fault {
                ProcessFault::Kill { service } | ProcessFault::RestartStorm { service, .. } => {
                    match living(service) {
                        Some(one) if planned.is_to_kill(one, now_ns) => {
                            planned.killed = Some(one.incarnation);
                            Act::Kill(service)
                        }
                        Some(_) | None => continue,
                    }
                }
                ProcessFault::KillHelper { helper } => Act::KillHelper(helper),
                ProcessFault::Stop { service, .. } if up(service).is_none() => continue,
                ProcessFault::Stop { service, .. } => Act::Stop(service),
                ProcessFault::Hog { core, .. } => Act::Hog(core.map(|core| core.value())),
                ProcessFault::Memory { megabytes, .. } => Act::Memory(megabytes.value()),
            };
            planned.left -= 1;
            planned.done = planned.left == 0;
            acts.push((index, act));
        }
        acts
    }

    /// True while a service is to recover from a fault.
    pub fn is_recovery_awaited(&self) -> bool {
        self.records
            .iter()
            .any(|record| record.awaits.is_some() && record.recovered_after_us.is_none())
    }

    /// Run time after `now_ns` at which something is due next, ns, as far as it is known. What is overdue waits
    /// for its service, which may never come: it is looked at as often as the run is.
    pub fn next_ns(&self, now_ns: i64) -> Option<i64> {
        let next = |planned: &Planned| {
            let begin_ns = planned.begin_ns.filter(|_| !planned.done);
            let until_ns = planned.running.as_ref().map(|(until_ns, _)| *until_ns);
            begin_ns.into_iter().chain(until_ns).filter(|&ns| ns > now_ns).min()
        };
        self.planned.iter().filter_map(next).min()
    }

    /// Notes that the act on fault `index` was done at `now_ns`; `disturbance` is what runs for it, and
    /// `while_starting` says that it killed a process that was not in the run yet.
    pub fn done(
        &mut self,
        index: usize,
        now_ns: i64,
        disturbance: Option<Disturbance>,
        while_starting: bool,
    ) {
        let planned = &mut self.planned[index];
        match planned.process_fault {
            ProcessFault::Stop { .. } | ProcessFault::Hog { .. } | ProcessFault::Memory { .. } => {
                planned.running = Some((planned.fault.effect.end_ns(now_ns), disturbance));
            }
            ProcessFault::Kill { .. }
            | ProcessFault::RestartStorm { .. }
            | ProcessFault::KillHelper { .. } => {}
        }
        let t_s = now_ns as f64 / 1e9;
        let record = FaultRecord { t_s, while_starting, ..record(&planned.fault, planned.number) };
        self.records.push(record);
    }

    /// Ends what runs for a fault of `service` that was replaced meanwhile.
    pub fn replaced(&mut self, service: Service) {
        for planned in &mut self.planned {
            if planned.fault.effect.target() == Target::Service(service) {
                planned.running = None;
            }
        }
    }

    /// Notes that the launcher found `service` gone or hung at `now_ns`; its restart `awaits` will
    /// show its recovery. A fault that was not asked for gets a record of its own, of that kind, with
    /// the run time `since_ns` at which it began, where that is known.
    pub fn detected(
        &mut self,
        service: Service,
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
        self.records.push(FaultRecord {
            t_s: since_ns.unwrap_or(now_ns) as f64 / 1e9,
            kind: kind.into(),
            service: Some(service),
            topic: None,
            helper: None,
            while_starting: false,
            messages: None,
            undetected: 0,
            detected_after_us: since_ns.map(|since_ns| (now_ns - since_ns) as f64 / 1e3),
            recovered_after_us: None,
            recovered_by: None,
            number: u32::MAX,
            awaits: Some(awaits),
        });
        self.recovered_before(service, awaits);
    }

    /// The first message of a standby may be heard before the news of the end that it follows.
    fn recovered_before(&mut self, service: Service, awaits: u32) {
        let heard = self.heard.iter().find(|(of, process, _)| *of == service && *process >= awaits);
        if let Some(&(_, incarnation, ns)) = heard {
            self.recovered(service, incarnation, ns);
        }
    }

    /// Notes that process `incarnation` of `service`, its standby, has taken over from process `old`, whose end
    /// or silence it noticed at `noticed_ns`.
    pub fn taken_over(&mut self, service: Service, old: u32, kind: &str, noticed_ns: i64) {
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
                // Its end may have been heard of first.
                record.kind = kind.into();
            }
            record.recovered_by = Some(Recovery::TakeOver);
        }
    }

    /// Notes the first fresh message of restart `incarnation` of `service`, published at `ns`.
    pub fn recovered(&mut self, service: Service, incarnation: u32, ns: i64) {
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

    /// Adds what the ports counted.
    pub fn count_messages(&mut self, counts: impl Iterator<Item = runtime::FaultStatistics>) {
        for count in counts {
            for record in self.records.iter_mut().filter(|record| record.number == count.fault) {
                record.messages = Some(record.messages.unwrap_or(0) + count.messages);
                record.undetected += count.undetected;
                record.t_s = count.begun_ns as f64 / 1e9;
            }
        }
        // What never began is no event of the run.
        self.records.retain(|record| record.t_s.is_finite());
        self.records.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
    }
}

/// True if the record is of a fault that was asked for and ends or stops a process.
fn is_asked(record: &FaultRecord) -> bool {
    matches!(record.kind.as_str(), "kill" | "stop" | "restart-storm")
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

fn record(fault: &Fault, number: u32) -> FaultRecord {
    let target = fault.effect.target();
    FaultRecord {
        t_s: f64::NAN,
        kind: fault.effect.kind().name().into(),
        service: match target {
            Target::Service(service) => Some(service),
            _ => None,
        },
        topic: match target {
            Target::Topic(topic) => Some(topic.name()),
            _ => None,
        },
        helper: match target {
            Target::Helper(helper) => Some(helper),
            _ => None,
        },
        while_starting: false,
        messages: fault.effect.extent().map(|_| 0),
        undetected: 0,
        detected_after_us: None,
        recovered_after_us: None,
        recovered_by: None,
        number,
        awaits: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str) -> Faults {
        let text = format!("schema_version = 1\nname = \"faulty\"\n{text}");
        Faults::of(&Scenario::parse("faults", &text).expect("a scenario"))
    }

    fn running(incarnation: u32) -> Option<Living> {
        Some(Living { incarnation, starting_since_ns: None })
    }

    #[test]
    fn a_kill_is_done_once_and_its_detection_and_recovery_are_counted_from_it() {
        let mut faults = faults("[[faults]]\nkind = \"kill\"\nservice = \"controller\"\nat_s = 1");
        assert_eq!(faults.due(999_999_999, None, |_| running(0)), []);
        let due = faults.due(1_000_500_000, None, |_| running(0));
        assert_eq!(due, [(0, Act::Kill(Service::Controller))]);
        faults.done(0, 1_000_500_000, None, false);
        assert_eq!(faults.due(2_000_000_000, None, |_| running(0)), []);
        faults.detected(Service::Controller, "died", 1, None, 1_001_000_000);
        faults.recovered(Service::Controller, 1, 1_012_500_000);
        let [record] = faults.records.as_slice() else { panic!("one record") };
        assert_eq!(record.detected_after_us.map(f64::round), Some(500.0));
        assert_eq!(record.recovered_after_us.map(f64::round), Some(12_000.0));
    }

    #[test]
    fn a_storm_waits_until_its_victim_is_back() {
        let mut faults = faults(
            "[[faults]]\nkind = \"restart-storm\"\nservice = \"plant\"\nat_s = 1\ntimes = 2",
        );
        assert_eq!(faults.due(1_000_000_000, None, |_| running(0)).len(), 1);
        assert_eq!(faults.due(1_100_000_000, None, |_| running(0)), []);
        assert_eq!(faults.due(1_200_000_000, None, |_| running(1)).len(), 1);
        assert_eq!(faults.due(1_300_000_000, None, |_| running(2)), []);
    }

    #[test]
    fn a_kill_of_a_service_that_does_not_take_part_is_not_waited_for() {
        let mut faults = faults("[[faults]]\nkind = \"kill\"\nservice = \"aebs\"\nat_s = 1");
        assert_eq!(faults.next_ns(0), Some(1_000_000_000));
        assert_eq!(faults.due(1_000_000_001, None, |_| None), []);
        assert_eq!(faults.next_ns(1_000_000_001), None);
    }

    #[test]
    fn a_storm_may_strike_what_has_just_been_started() {
        let mut faults = faults(
            "[[faults]]\nkind = \"restart-storm\"\nservice = \"plant\"\nat_s = 1\ntimes = 2\n\
             after_start_ms = 3",
        );
        let starting =
            |incarnation, since_ns| Some(Living { incarnation, starting_since_ns: Some(since_ns) });
        assert_eq!(faults.due(1_000_000_000, None, |_| starting(0, 0)), [], "the first takes part");
        assert_eq!(faults.due(1_000_000_000, None, |_| running(0)).len(), 1);
        assert_eq!(faults.due(1_003_000_000, None, |_| starting(1, 1_001_000_000)), []);
        assert_eq!(faults.due(1_004_000_000, None, |_| starting(1, 1_001_000_000)).len(), 1);
        assert_eq!(faults.due(1_009_000_000, None, |_| starting(2, 1_005_000_000)), []);
    }

    #[test]
    fn a_stopped_service_goes_on_when_its_time_is_over_unless_it_was_replaced() {
        let text = "[[faults]]\nkind = \"stop\"\nservice = \"v2x-sim\"\nat_s = 1\nfor_s = 0.5";
        for (replaced, acts) in [(false, vec![(0, Act::Continue(Service::V2xSim))]), (true, vec![])]
        {
            let mut faults = faults(text);
            assert_eq!(faults.due(1_000_000_000, None, |_| running(0)).len(), 1);
            faults.done(0, 1_000_000_000, None, false);
            if replaced {
                faults.replaced(Service::V2xSim);
            }
            assert_eq!(faults.due(1_400_000_000, None, |_| running(0)), []);
            assert_eq!(faults.due(1_500_000_000, None, |_| running(0)), acts);
        }
    }

    #[test]
    fn a_death_that_was_not_asked_for_is_recorded_once_with_what_was_measured() {
        let mut faults = faults("");
        faults.detected(Service::Plant, "hung", 1, Some(5_000), 6_000);
        faults.detected(Service::Plant, "died", 1, None, 7_000);
        faults.detected(Service::Controller, "died", 1, None, 8_000);
        let [hung, died] = faults.records.as_slice() else { panic!("two records") };
        assert_eq!((hung.kind.as_str(), hung.detected_after_us), ("hung", Some(1.0)));
        assert_eq!((died.t_s, died.detected_after_us), (8e-6, None), "its instant is not known");
    }

    #[test]
    fn a_condition_that_never_came_true_leaves_no_record() {
        let mut faults = faults(
            "[[faults]]\nkind = \"drop\"\ntopic = \"v2x/spat\"\nwhen = { speed_below_mps = 1 }\n\
             [[faults]]\nkind = \"drop\"\ntopic = \"v2x/spat\"\nat_s = 2",
        );
        let begun_ns = 2_000_000_000;
        let count = runtime::FaultStatistics { fault: 1, begun_ns, messages: 7, undetected: 0 };
        faults.count_messages([count, count].into_iter());
        let kept: Vec<_> = faults.records.iter().map(|r| (r.number, r.messages)).collect();
        assert_eq!(kept, [(1, Some(14))]);
    }
}
