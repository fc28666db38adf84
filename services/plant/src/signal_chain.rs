//! The chain from a signal's change to the first actuation with the new phase behind it.
//!
//! The change is that of the ground truth. The stamp of the signal timing behind a command shows whether its
//! actuation includes the change. Only the next signal ahead counts: it is the one that the vehicle drives by.

use crate::referee::shown;
use crate::report::SignalHops;
use messages::{Command, SignalTruth};
use runtime::statistics::Latencies;
use runtime::{Figures, RuntimeError};
use std::collections::BTreeMap;

/// Stamps on air are whole milliseconds, rounded down, ns.
const STAMP_NS: i64 = 1_000_000;

/// Names of the parts, in order of time.
const NAMES: [&str; 4] = ["signal_announce", "signal_receive", "signal_control", "signal_actuate"];

/// Histograms of all changes of a run.
#[derive(Debug)]
pub(crate) struct SignalChain {
    /// The next signal ahead, what it shows, and until when, ns of run time.
    shown: Option<(u64, u32, i64)>,
    /// A change without an actuation yet, ns of run time.
    changed_ns: Option<i64>,
    pub(crate) whole: Latencies,
    parts: [Latencies; NAMES.len()],
}

impl SignalChain {
    /// The changes that `figures` has, none before the run.
    pub(crate) fn open(figures: &Figures) -> Result<Self, RuntimeError> {
        let mut parts: [Latencies; NAMES.len()] = Default::default();
        for (part, name) in parts.iter_mut().zip(NAMES) {
            *part = figures.latencies(name)?;
        }
        let whole = figures.latencies("signal_reaction")?;
        Ok(Self { shown: None, changed_ns: None, whole, parts })
    }

    /// Looks at the signals as they are; called in every cycle of the plant.
    pub(crate) fn look(&mut self, truth: &SignalTruth, ego_m: f64) {
        let next = shown(truth).find(|(lane, _)| lane.stop_line_m > ego_m);
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
    pub(crate) fn actuated(&mut self, command: &Command, now_ns: i64) {
        let spat = command.header.origins.spat;
        let Some(changed_ns) = self.changed_ns else { return };
        if !spat.is_some() || spat.acquisition_ns + STAMP_NS <= changed_ns {
            return;
        }
        self.changed_ns = None;
        let made_ns = spat.acquisition_ns.max(changed_ns);
        self.whole.record_ns(now_ns - changed_ns);
        let ends = [made_ns, spat.publish_ns, command.header.publish_ns, now_ns];
        let mut begin_ns = changed_ns;
        for (part, end_ns) in self.parts.iter_mut().zip(ends) {
            part.record_ns(end_ns - begin_ns);
            begin_ns = end_ns;
        }
    }

    pub(crate) fn hops_us(&self) -> SignalHops {
        let [announce, receive, control, actuate] =
            self.parts.each_ref().map(Latencies::percentiles_us);
        SignalHops { announce, receive, control, actuate }
    }

    /// All histograms by the names of their figures; none where no signal changed.
    pub(crate) fn histograms(&self) -> BTreeMap<String, Latencies> {
        if self.whole.percentiles_us().is_none() {
            return BTreeMap::new();
        }
        let parts = NAMES.into_iter().zip(&self.parts);
        let named = parts.chain([("signal_reaction", &self.whole)]);
        named.map(|(name, h)| (name.to_owned(), h.clone())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::Origin;
    use runtime::statistics::Percentiles;

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
        assert_eq!(chain.whole.percentiles_us(), None, "nothing has changed");
        chain.look(&truth(8, 8.0), 0.0);
        chain.actuated(&command(5_000), 5_090 * MS);
        assert_eq!(chain.whole.percentiles_us(), None, "of before the change");
        chain.actuated(&command(5_100), 5_130 * MS);
        chain.actuated(&command(5_200), 5_230 * MS);
        let max = |p: Option<Percentiles>| p.map(|p| (p.count, (p.max / 1e3).round()));
        assert_eq!(max(chain.whole.percentiles_us()), Some((1, 80.0)));
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
        assert_eq!(chain.whole.percentiles_us(), None);
    }
}
