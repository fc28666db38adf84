//! Faults that act on processes: what is due when.

pub mod disturbance;
pub mod log;

use crate::faults::disturbance::Disturbance;
use crate::faults::log::FaultLog;
use messages::{EgoTruth, Service};
use scenario::Scenario;
use scenario::faults::{Effect, Fault, Helper, ProcessFault, Target};

/// A fault that is due or under way.
#[derive(Debug)]
struct Planned {
    number: u32,
    fault: Fault,
    process_fault: ProcessFault,
    /// Time when it begins, ns of run time; unknown while it waits for its condition.
    begin_ns: Option<i64>,
    /// Kills left of a storm.
    left: u16,
    /// The process that was killed last, as a restart of its service.
    killed: Option<u32>,
    /// Disturbance that runs while it lasts, and its end.
    running: Option<(i64, Option<Disturbance>)>,
    done: bool,
}

/// A service's active process that lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LiveProcess {
    /// Index of the process in its service.
    pub incarnation: u32,
    /// Time of its start, run time in ns; `None`: it takes part in the run.
    pub starting_since_ns: Option<i64>,
}

/// Act of the supervisor on a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    Kill(Service),
    /// SIGKILL to a process other than a service.
    KillHelper(Helper),
    Stop(Service),
    Continue(Service),
    /// Keep a core, or all, busy.
    Hog(Option<u16>),
    /// Take this amount of memory, MiB.
    Memory(u32),
}

impl Planned {
    /// True if a kill strikes this process at `now_ns`. The kill has not struck it yet, and the process takes part, or
    /// a storm leaves it out.
    fn is_to_kill(&self, one: LiveProcess, now_ns: i64) -> bool {
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

/// The faults of a run that act on processes, and the log of all.
#[derive(Debug)]
pub struct Faults {
    planned: Vec<Planned>,
    next_number: u32,
    /// Errors so far.
    pub log: FaultLog,
}

impl Faults {
    pub fn of(scenario: &Scenario) -> Self {
        let mut faults = Self { planned: Vec::new(), next_number: 0, log: FaultLog::default() };
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
                    _ => 1,
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
            Effect::Channel(_) | Effect::Sender(_) => {
                let t_s = begin_ns.map_or(f64::NAN, |begin| begin as f64 / 1e9);
                self.log.begin(&fault, number, t_s, false);
            }
        }
        number
    }

    /// Acts that are due at `now_ns` with this drive of the ego. `living` gives a service's active process; a storm
    /// waits for the next one.
    pub fn due(
        &mut self,
        now_ns: i64,
        ego: Option<EgoTruth>,
        living: impl Fn(Service) -> Option<LiveProcess>,
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

    /// Run time after `now_ns` at which something is due next, ns, as far as it is known. An overdue act waits for its
    /// service, which may never come. It is looked at as often as the run is.
    pub fn next_ns(&self, now_ns: i64) -> Option<i64> {
        let next = |planned: &Planned| {
            let begin_ns = planned.begin_ns.filter(|_| !planned.done);
            let until_ns = planned.running.as_ref().map(|(until_ns, _)| *until_ns);
            begin_ns.into_iter().chain(until_ns).filter(|&ns| ns > now_ns).min()
        };
        self.planned.iter().filter_map(next).min()
    }

    /// Notes the act on fault `index` at `now_ns`; `disturbance` runs for it. With `while_starting` it killed a
    /// process that was not in the run yet.
    pub fn done(
        &mut self,
        index: usize,
        now_ns: i64,
        disturbance: Option<Disturbance>,
        while_starting: bool,
    ) {
        let planned = &mut self.planned[index];
        use ProcessFault::{Hog, Memory, Stop};
        if matches!(planned.process_fault, Stop { .. } | Hog { .. } | Memory { .. }) {
            planned.running = Some((planned.fault.effect.end_ns(now_ns), disturbance));
        }
        self.log.begin(&planned.fault, planned.number, now_ns as f64 / 1e9, while_starting);
    }

    /// Ends what runs for a fault of `service` that was replaced meanwhile.
    pub fn replaced(&mut self, service: Service) {
        for planned in &mut self.planned {
            if planned.fault.effect.target() == Target::Service(service) {
                planned.running = None;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn faults(text: &str) -> Faults {
        let text = format!("schema_version = 1\nname = \"faulty\"\n{text}");
        Faults::of(&Scenario::parse("faults", &text).expect("a scenario"))
    }

    fn running(incarnation: u32) -> Option<LiveProcess> {
        Some(LiveProcess { incarnation, starting_since_ns: None })
    }

    #[test]
    fn a_kill_is_done_once_and_its_detection_and_recovery_are_counted_from_it() {
        let mut faults = faults("[[faults]]\nkind = \"kill\"\nservice = \"controller\"\nat_s = 1");
        assert_eq!(faults.due(999_999_999, None, |_| running(0)), []);
        let due = faults.due(1_000_500_000, None, |_| running(0));
        assert_eq!(due, [(0, Act::Kill(Service::Controller))]);
        faults.done(0, 1_000_500_000, None, false);
        assert_eq!(faults.due(2_000_000_000, None, |_| running(0)), []);
        faults.log.detected(Service::Controller, "died", 1, None, 1_001_000_000);
        faults.log.recovered(Service::Controller, 1, 1_012_500_000);
        let [record] = faults.log.records.as_slice() else { panic!("one record") };
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
        let starting = |incarnation, since_ns| {
            Some(LiveProcess { incarnation, starting_since_ns: Some(since_ns) })
        };
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
    fn a_condition_that_never_came_true_leaves_no_record() {
        let mut faults = faults(
            "[[faults]]\nkind = \"drop\"\ntopic = \"v2x/spat\"\nwhen = { speed_below_mps = 1 }\n\
             [[faults]]\nkind = \"drop\"\ntopic = \"v2x/spat\"\nat_s = 2",
        );
        let begun_ns = 2_000_000_000;
        let count = runtime::FaultStatistics { fault: 1, begun_ns, messages: 7, undetected: 0 };
        faults.log.count_messages([count, count].into_iter());
        let kept: Vec<_> = faults.log.records.iter().map(|r| (r.number, r.messages)).collect();
        assert_eq!(kept, [(1, Some(14))]);
    }
}
