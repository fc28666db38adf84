//! Late and missing commands, counted where they are missed.
//!
//! A controller counts its own misses, but it may die or count wrongly. So the plant has a schedule of its own. A
//! command for each control period, or for a later one, must arrive within the deadline after the period's start.
//! Otherwise the period is missed, whatever became of the command.

use serde::{Deserialize, Serialize};

/// Counts control periods without a command in time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Timeliness {
    period_ns: i64,
    deadline_ns: i64,
    /// Start of the period to be judged next, run time in ns.
    next_ns: i64,
    /// Release for which the newest command was computed, run time in ns.
    newest_ns: i64,
    /// Control periods judged so far, and those without a command in time.
    pub(crate) due: u64,
    pub(crate) missed: u64,
    /// Longest time between two accepted commands, ns.
    pub(crate) longest_gap_ns: i64,
}

impl Timeliness {
    /// The schedule of a control loop with this period and deadline, ns.
    pub(crate) fn new(period_ns: i64, deadline_ns: i64) -> Self {
        Self { period_ns, deadline_ns, newest_ns: i64::MIN, ..Self::default() }
    }

    /// A command has arrived that was computed for the release at `release_ns`.
    pub(crate) fn arrived(&mut self, release_ns: i64) {
        self.newest_ns = self.newest_ns.max(release_ns);
    }

    pub(crate) fn judge(&mut self, now_ns: i64) {
        while self.next_ns + self.deadline_ns <= now_ns {
            self.due += 1;
            self.missed += u64::from(self.newest_ns < self.next_ns);
            self.next_ns += self.period_ns;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Periods of 100 ns with a deadline of 60; commands as (release, arrival).
    fn missed(commands: &[(i64, i64)], until_ns: i64) -> (u64, u64) {
        let mut timeliness = Timeliness::new(100, 60);
        for now_ns in (0..=until_ns).step_by(10) {
            for (release_ns, _) in commands.iter().filter(|(_, arrival)| *arrival == now_ns) {
                timeliness.arrived(*release_ns);
            }
            timeliness.judge(now_ns);
        }
        (timeliness.due, timeliness.missed)
    }

    #[test]
    fn commands_in_time_do_not_count_as_missed() {
        assert_eq!(missed(&[(0, 10), (100, 160), (200, 210)], 300), (3, 0));
        assert_eq!(missed(&[(0, 10), (130, 140)], 160), (2, 0), "off the grid, after a restart");
    }

    #[test]
    fn late_missing_and_stale_ones_are() {
        assert_eq!(missed(&[(0, 70), (100, 110)], 160), (2, 1), "late");
        assert_eq!(missed(&[(0, 10), (200, 210)], 270), (3, 1), "missing");
        assert_eq!(missed(&[(0, 10), (0, 110), (0, 210)], 260), (3, 2), "the same again");
        assert_eq!(missed(&[], 60), (1, 1), "never any");
    }
}
