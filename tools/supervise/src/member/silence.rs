//! The time since a process's last sign of life, and what it means.
//!
//! ```text
//! sign of life ── half the limit: what had it of the processor so far? ── the limit: what has it had since?
//!                                                                           nothing, and it waits: starved
//!                                                                           else: hung
//! ```
//!
//! A service that hangs and one that does not get the processor give no sign of life both. The kernel's own account of a
//! process shows which it is. A process that hangs sleeps, is stopped, or has had the processor for longer than any cycle
//! takes. A starved process waits in the run queue and has had hardly any of it. It is not its fault, and the next process
//! would not get the processor either.

use std::path::PathBuf;

#[derive(Clone, Copy, Debug, Default)]
pub struct Silence {
    /// Run time of the last sign of life, ns.
    heard_ns: i64,
    /// Cycles done then.
    cycles: u64,
    /// Run time from which it counts as silent, ns. It is later than `heard_ns` if the silence was the machine's or the
    /// launcher's.
    since_ns: i64,
    /// Its processor time at a run time within the silence, ns.
    suspect: Option<(i64, Share)>,
}

/// Meaning of a process's silence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// The silence is too short for a verdict.
    Lives,
    /// It had the processor, or needs none: it is to be replaced.
    Hung,
    /// It waits for the processor, and did so for this time, ns: another process would wait as well.
    Starved(i64),
}

impl Silence {
    /// The silence of a process that begins at this run time.
    pub fn from(now_ns: i64) -> Self {
        Self { heard_ns: now_ns, since_ns: now_ns, ..Self::default() }
    }

    /// Run time of the last sign of life, ns.
    pub fn heard_ns(&self) -> i64 {
        self.heard_ns
    }

    /// Notes a sign of life at `now_ns` with `cycles` done; it counts only with progress.
    pub fn broken(&mut self, cycles: u64, now_ns: i64) {
        if cycles > self.cycles {
            *self = Self { heard_ns: now_ns, cycles, since_ns: now_ns, suspect: None };
        }
    }

    /// Counts the time without a sign of life from `now_ns` on.
    pub fn reset(&mut self, now_ns: i64) {
        self.since_ns = self.since_ns.max(now_ns);
        self.suspect = None;
    }

    /// Meaning of the silence at `now_ns` with a limit of `limit_ns`. `share` reads the process's processor time from
    /// the kernel. Without it a silent process counts as hung. A starved one is silent from now
    /// on.
    pub fn meaning(
        &mut self,
        now_ns: i64,
        limit_ns: i64,
        share: impl Fn() -> Option<Share>,
    ) -> Meaning {
        let silent_ns = now_ns - self.since_ns;
        if 2 * silent_ns > limit_ns && self.suspect.is_none() {
            self.suspect = share().map(|share| (now_ns, share));
        }
        if silent_ns <= limit_ns {
            return Meaning::Lives;
        }
        let Some((then_ns, before)) = self.suspect else { return Meaning::Hung };
        let starved =
            share().is_some_and(|share| before.is_starved(share, (now_ns - then_ns).max(1)));
        if !starved {
            return Meaning::Hung;
        }
        self.reset(now_ns);
        Meaning::Starved(silent_ns)
    }
}

/// Largest part of the time without a sign of life for which a starved process had the processor. Cycles take far less.
const MOST_OF_IT: i64 = 4;

/// Processor time of a process so far, by its main thread, which runs the loop.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// It runs or waits for the processor at this moment.
    runnable: bool,
    stopped: bool,
    /// Time on the processor, ns.
    ran_ns: i64,
    /// Time in the run queue, up to the last time that it left it, ns.
    queued_ns: i64,
}

impl Share {
    /// Asks the kernel; `None` if the process is gone, or the kernel keeps no such account.
    pub fn of(pid: i32) -> Option<Self> {
        let read = |name: &str| {
            std::fs::read_to_string(PathBuf::from("/proc").join(pid.to_string()).join(name)).ok()
        };
        Self::parse(&read("stat")?, &read("schedstat")?)
    }

    /// Content of the kernel's two files of a process.
    pub(crate) fn parse(stat: &str, schedstat: &str) -> Option<Self> {
        // The name before the state may hold anything, but no more brackets come after it.
        let state = stat.rsplit_once(") ")?.1.chars().next()?;
        let mut numbers = schedstat.split_whitespace().map(|number| number.parse::<i64>().ok());
        let mut next = || numbers.next().flatten();
        let (ran_ns, queued_ns) = (next()?, next()?);
        // A kernel without the account writes zeros, even of a process that has just been running.
        (ran_ns > 0).then_some(Self {
            runnable: state == 'R',
            stopped: matches!(state, 'T' | 't'),
            ran_ns,
            queued_ns,
        })
    }

    /// True if the process waits for an order to continue, or had the processor for most of `elapsed_ns` since
    /// `before`. Others that wait for its messages do neither.
    pub fn holds_up(self, before: Self, elapsed_ns: i64) -> bool {
        self.stopped || 2 * (self.ran_ns - before.ran_ns) > elapsed_ns
    }

    /// True if a process that had `self` some `silent_ns` ago and has `now` was kept from the
    /// processor.
    pub fn is_starved(self, now: Self, silent_ns: i64) -> bool {
        let ran_ns = now.ran_ns - self.ran_ns;
        let queued_ns = now.queued_ns - self.queued_ns;
        ran_ns * MOST_OF_IT < silent_ns && (now.runnable || 2 * queued_ns > silent_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: i64 = 1_000_000;
    /// As the supervisor has it for a heartbeat timeout of 250 ms.
    const LIMIT_NS: i64 = 350 * MS;

    /// Two looks at a process, 350 ms apart, as a kernel of Linux 6 gave them. They are `/proc/<pid>/stat` up to the
    /// state, and `schedstat`.
    type Looks = [(&'static str, &'static str); 2];

    /// In an endless loop as `SCHED_IDLE`, on a core with another one at nice -20.
    const STARVED_LOOP: Looks = [
        ("23584 (python3) R 1", "277907531 123071631 35"),
        ("23584 (python3) R 1", "277907531 123071631 35"),
    ];
    /// A cycle of 0.2 ms every 100 ms, in the same place: asleep at the first look.
    const STARVED_CYCLES: Looks = [
        ("23951 (python3) S 1", "36869863 19961046 21"),
        ("23951 (python3) R 1", "36869863 19961046 21"),
    ];
    /// In an endless loop, on a core that it shares with builds.
    const ENDLESS_LOOP: Looks = [
        ("24096 (python3) R 1", "270248749 124177046 60"),
        ("24096 (python3) R 1", "606333933 139848306 70"),
    ];
    /// Stopped by SIGSTOP, on the core with nice -20.
    const STOPPED: Looks = [
        ("24108 (python3) T 1", "31395808 45371219 12"),
        ("24108 (python3) T 1", "31395808 45371219 12"),
    ];
    /// In a sleep that does not end.
    const ASLEEP: Looks = [
        ("24115 (python3) S 1", "31907701 11413320 6"),
        ("24115 (python3) S 1", "31907701 11413320 6"),
    ];

    fn share(look: (&str, &str)) -> Option<Share> {
        Some(Share::parse(look.0, look.1).expect("the kernel's form"))
    }

    /// Meaning of the silence of a process, checked every 20 ms from its last sign of life on.
    fn meaning(looks: Looks) -> Meaning {
        let mut silence = Silence::from(0);
        for now_ns in (0..LIMIT_NS).step_by(20 * MS as usize) {
            let meaning = silence.meaning(now_ns, LIMIT_NS, || share(looks[0]));
            assert_eq!(meaning, Meaning::Lives, "{now_ns}");
        }
        silence.meaning(LIMIT_NS + 10 * MS, LIMIT_NS, || share(looks[1]))
    }

    #[test]
    fn a_process_that_waits_for_the_processor_is_starved_and_one_that_has_it_or_needs_none_hangs() {
        assert_eq!(meaning(STARVED_LOOP), Meaning::Starved(LIMIT_NS + 10 * MS));
        assert_eq!(meaning(STARVED_CYCLES), Meaning::Starved(LIMIT_NS + 10 * MS));
        assert_eq!(meaning(ENDLESS_LOOP), Meaning::Hung);
        assert_eq!(meaning(STOPPED), Meaning::Hung);
        assert_eq!(meaning(ASLEEP), Meaning::Hung);
    }

    #[test]
    fn without_an_account_of_the_kernel_who_is_silent_hangs() {
        let mut silence = Silence::from(0);
        assert_eq!(silence.meaning(200 * MS, LIMIT_NS, || None), Meaning::Lives);
        assert_eq!(silence.meaning(LIMIT_NS + 1, LIMIT_NS, || None), Meaning::Hung);
    }

    #[test]
    fn the_starved_get_the_whole_time_again_and_a_sign_of_life_ends_it() {
        let mut silence = Silence::from(0);
        let mut look = |now_ns, looks: Looks, second: usize| {
            silence.meaning(now_ns * MS, LIMIT_NS, || share(looks[second]))
        };
        assert_eq!(look(200, STARVED_CYCLES, 0), Meaning::Lives);
        assert_eq!(look(360, STARVED_CYCLES, 1), Meaning::Starved(360 * MS));
        assert_eq!(look(700, STOPPED, 0), Meaning::Lives);
        assert_eq!(look(720, STOPPED, 1), Meaning::Hung, "it was let run, and does not");
        silence.broken(0, 730 * MS);
        assert_eq!(silence.heard_ns(), 0, "no progress");
        silence.broken(1, 730 * MS);
        assert_eq!(silence.heard_ns(), 730 * MS);
        let later = silence.meaning(740 * MS, LIMIT_NS, || share(STOPPED[0]));
        assert_eq!(later, Meaning::Lives);
    }
}

#[cfg(test)]
mod share_tests {
    use super::*;

    const MS: i64 = 1_000_000;

    fn share(state: char, ran_ms: i64, queued_ms: i64) -> Share {
        let stat = format!("17 (a) b) {state} 1 17");
        let schedstat = format!("{} {} 9\n", ran_ms * MS, queued_ms * MS);
        Share::parse(&stat, &schedstat).expect("the kernel's form")
    }

    #[test]
    fn the_starved_wait_for_the_processor_and_the_hung_do_not() {
        let before = share('S', 100, 50);
        let starved = |now| before.is_starved(now, 350 * MS);
        assert!(starved(share('R', 101, 50)), "in the queue since before the silence");
        assert!(starved(share('S', 110, 300)), "it got a little, again and again");
        assert!(!starved(share('S', 100, 50)), "asleep");
        assert!(!starved(share('T', 100, 50)), "stopped");
        assert!(!starved(share('R', 440, 55)), "in an endless loop");
        assert!(!starved(share('R', 250, 200)), "the same on a busy machine");
    }

    #[test]
    fn the_stopped_and_the_spinning_hold_others_up() {
        let before = share('S', 100, 50);
        let holds_up = |now: Share| now.holds_up(before, 50 * MS);
        assert!(holds_up(share('T', 100, 50)), "stopped");
        assert!(holds_up(share('R', 140, 55)), "in an endless loop");
        assert!(!holds_up(share('S', 100, 50)), "waits");
        assert!(!holds_up(share('R', 102, 50)), "tells that it waited");
    }

    #[test]
    fn this_process_has_a_share() {
        let own = i32::try_from(std::process::id()).expect("fits");
        if let Some(share) = Share::of(own) {
            assert!(share.ran_ns > 0);
        }
        assert_eq!(Share::of(-1), None);
    }
}
