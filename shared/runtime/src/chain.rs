//! Times of a cause-effect chain: those of the car, and of each chain of a user's graph.
//!
//! *Reaction time*: acquisition of a sample to the first act that uses it. *Data age*: every act back to the sample
//! behind it. The parts of a reaction time add up to it exactly, since each begins where the last one ended.

use crate::statistics::Latencies;
use crate::{Count, RuntimeError};

/// The part of a chain that ends at `stamp_ns`; `reached_ns`, the end of the part before, moves there. Time never goes
/// back: a part that was over before the last one ended took none.
///
/// ```
/// let mut reached_ns = 100;
/// let parts = [130, 120, 145].map(|stamp_ns| runtime::chain::part(&mut reached_ns, stamp_ns));
/// assert_eq!((parts, reached_ns), ([30, 0, 15], 145));
/// ```
pub fn part(reached_ns: &mut i64, stamp_ns: i64) -> i64 {
    let part = (stamp_ns - *reached_ns).max(0);
    *reached_ns += part;
    part
}

#[derive(Debug)]
pub struct ChainTimes {
    /// Acquisition to the first act, once for each sample that reaches the end.
    pub reaction: Latencies,
    /// Every act back to its sample.
    pub age: Latencies,
    /// Waits in a reaction that the design asks for.
    pub designed_wait: Latencies,
    /// The reaction without them.
    pub net_reaction: Latencies,
    /// The parts of a reaction, in order of time.
    pub parts: Vec<Latencies>,
    /// Reactions that were longer than the deadline.
    pub late: Count,
    deadline_ns: i64,
}

impl ChainTimes {
    /// The times of a chain whose parts have these names. `latencies` opens a histogram by its name.
    ///
    /// # Errors
    /// Those of `latencies`.
    pub fn open<'a>(
        parts: impl IntoIterator<Item = &'a str>,
        deadline_ns: i64,
        late: Count,
        mut latencies: impl FnMut(&str) -> Result<Latencies, RuntimeError>,
    ) -> Result<Self, RuntimeError> {
        Ok(Self {
            reaction: latencies("reaction_time")?,
            age: latencies("data_age")?,
            designed_wait: latencies("designed_wait")?,
            net_reaction: latencies("net_reaction")?,
            parts: parts.into_iter().map(&mut latencies).collect::<Result<_, _>>()?,
            late,
            deadline_ns,
        })
    }

    /// Counts a reaction that consists of these parts, `designed_ns` of which the design asks for.
    pub fn count(&mut self, parts: &[i64], designed_ns: i64) {
        let sum_ns = parts.iter().sum::<i64>();
        self.reaction.record_ns(sum_ns);
        self.late.add(u64::from(sum_ns > self.deadline_ns));
        self.designed_wait.record_ns(designed_ns);
        self.net_reaction.record_ns(sum_ns - designed_ns);
        for (histogram, part) in self.parts.iter_mut().zip(parts) {
            histogram.record_ns(*part);
        }
    }
}
