//! The chain from a signal's change to the first actuation with the new phase behind it.
//!
//! The change is that of the ground truth. The stamp of the signal timing behind a command shows whether its
//! actuation includes the change. Only the next signal ahead counts: it is the one that the vehicle drives by.

use crate::report::SignalHops;
use messages::{Command, SignalTruth};
use runtime::statistics::{Latencies, Percentiles};
use runtime::{Figures, RuntimeError};
use std::collections::BTreeMap;

/// Stamps on air are whole milliseconds, rounded down, ns.
const STAMP_NS: i64 = 1_000_000;

/// Histograms of all changes of a run.
#[derive(Debug)]
pub struct SignalChain {
    /// The next signal ahead, what it shows, and until when, ns of run time.
    shown: Option<(u64, u32, i64)>,
    /// A change without an actuation yet, ns of run time.
    changed_ns: Option<i64>,
    whole: Latencies,
    announce: Latencies,
    receive: Latencies,
    control: Latencies,
    actuate: Latencies,
}

impl SignalChain {
    /// The changes that `figures` has, none before the run.
    ///
    /// # Errors
    /// [`RuntimeError::Setup`] if shared memory has no room for them.
    pub fn open(figures: &Figures) -> Result<Self, RuntimeError> {
        Ok(Self {
            shown: None,
            changed_ns: None,
            whole: figures.latencies("signal_reaction")?,
            announce: figures.latencies("signal_announce")?,
            receive: figures.latencies("signal_receive")?,
            control: figures.latencies("signal_control")?,
            actuate: figures.latencies("signal_actuate")?,
        })
    }

    /// Looks at the signals as they are; called in every cycle of the plant.
    pub fn look(&mut self, truth: &SignalTruth, ego_m: f64) {
        let count = usize::try_from(truth.count).map_or(0, |n| n.min(truth.lanes.len()));
        let pairs = truth.lanes[..count].iter().zip(&truth.signals);
        let next = pairs.into_iter().find(|(lane, _)| lane.stop_line_m > ego_m);
        let Some((lane, signal)) = next.filter(|(_, signal)| signal.count > 0) else {
            (self.shown, self.changed_ns) = (None, None);
            return;
        };
        let id = u64::from(lane.intersection_id) << 32 | u64::from(lane.signal_group);
        let present = &signal.intervals[0];
        match self.shown {
            Some((known, state, end_ns)) if known == id => {
                if state != present.state {
                    self.changed_ns = Some(end_ns);
                }
            }
            _ => self.changed_ns = None,
        }
        // Endless phases saturate.
        self.shown = Some((id, present.state, (1e9 * present.likely_end_s).round() as i64));
    }

    /// Records that `command` acts at `now_ns`; called in every cycle of the plant.
    pub fn actuated(&mut self, command: &Command, now_ns: i64) {
        let spat = command.header.origins.spat;
        let Some(changed_ns) = self.changed_ns else { return };
        if !spat.is_some() || spat.acquisition_ns + STAMP_NS <= changed_ns {
            return;
        }
        self.changed_ns = None;
        let made_ns = spat.acquisition_ns.max(changed_ns);
        self.whole.record_ns(now_ns - changed_ns);
        self.announce.record_ns(made_ns - changed_ns);
        self.receive.record_ns(spat.publish_ns - made_ns);
        self.control.record_ns(command.header.publish_ns - spat.publish_ns);
        self.actuate.record_ns(now_ns - command.header.publish_ns);
    }

    /// Percentiles of the whole.
    #[must_use]
    pub fn reaction_us(&self) -> Option<Percentiles> {
        self.whole.percentiles_us()
    }

    /// Percentiles of the parts.
    #[must_use]
    pub fn hops_us(&self) -> SignalHops {
        SignalHops {
            announce: self.announce.percentiles_us(),
            receive: self.receive.percentiles_us(),
            control: self.control.percentiles_us(),
            actuate: self.actuate.percentiles_us(),
        }
    }

    /// All histograms by the names of their figures; none where no signal changed.
    #[must_use]
    pub fn histograms(&self) -> BTreeMap<String, Latencies> {
        if self.whole.percentiles_us().is_none() {
            return BTreeMap::new();
        }
        let named = [
            ("signal_reaction", &self.whole),
            ("signal_announce", &self.announce),
            ("signal_receive", &self.receive),
            ("signal_control", &self.control),
            ("signal_actuate", &self.actuate),
        ];
        named.into_iter().map(|(name, h)| (name.to_owned(), h.clone())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::Origin;

    const MS: i64 = 1_000_000;

    fn truth(state: u32, end_s: f64) -> SignalTruth {
        let mut truth = SignalTruth::zeroed();
        truth.count = 1;
        truth.lanes[0].stop_line_m = 100.0;
        truth.signals[0].count = 1;
        truth.signals[0].intervals[0].state = state;
        truth.signals[0].intervals[0].likely_end_s = end_s;
        truth
    }

    fn command(made_ms: i64) -> Command {
        let mut command = Command::zeroed();
        command.header.origins.spat =
            Origin { sequence: 1, acquisition_ns: made_ms * MS, publish_ns: (made_ms + 20) * MS };
        command.header.publish_ns = (made_ms + 23) * MS;
        command
    }

    #[test]
    fn a_change_reacts_once_and_its_parts_add_up() {
        let mut chain = SignalChain::open(&Figures::default()).expect("memory");
        chain.look(&truth(6, 5.05), 0.0);
        chain.actuated(&command(5_000), 5_030 * MS);
        assert_eq!(chain.reaction_us(), None, "nothing has changed");
        chain.look(&truth(8, 8.0), 0.0);
        chain.actuated(&command(5_000), 5_090 * MS);
        assert_eq!(chain.reaction_us(), None, "of before the change");
        chain.actuated(&command(5_100), 5_130 * MS);
        chain.actuated(&command(5_200), 5_230 * MS);
        let max = |p: Option<Percentiles>| p.map(|p| (p.count, (p.max / 1e3).round()));
        assert_eq!(max(chain.reaction_us()), Some((1, 80.0)));
        let hops = chain.hops_us();
        let parts = [hops.announce, hops.receive, hops.control, hops.actuate].map(max);
        assert_eq!(parts, [50.0, 20.0, 3.0, 7.0].map(|ms| Some((1, ms))));
    }

    #[test]
    fn a_signal_that_was_passed_does_not_count() {
        let mut chain = SignalChain::open(&Figures::default()).expect("memory");
        chain.look(&truth(6, 5.0), 0.0);
        chain.look(&truth(8, 8.0), 101.0);
        chain.actuated(&command(6_000), 6_100 * MS);
        assert_eq!(chain.reaction_us(), None);
    }
}
