//! Distinguishes a service that hangs from one that does not get the processor.
//!
//! Both give no sign of life. The kernel's own account of a process shows which it is. A process that hangs sleeps, is
//! stopped, or has had the processor for longer than any cycle takes. A starved process waits in the run queue and has
//! had hardly any of it. It is not its fault, and the next process would not get the processor either.

use std::path::PathBuf;

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
