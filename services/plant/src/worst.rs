//! The chains with the longest reaction times, kept whole.

use crate::parts::Chain;
use crate::report::WorstChain;
use messages::{Command, Origin};

const KEPT: usize = 10;

/// The longest chains so far, longest first; of two equal ones the earlier. Keeping one allocates nothing.
#[derive(Debug)]
pub(crate) struct Worst {
    deadline_ns: i64,
    pub(crate) chains: Vec<WorstChain>,
}

impl Worst {
    /// A control cycle is late if its command comes `deadline_ns` after its release.
    pub(crate) fn new(deadline_ns: i64) -> Self {
        Self { deadline_ns, chains: Vec::with_capacity(KEPT) }
    }

    /// Keeps the chain that ended with `command` at `now_ns` if it is among the longest.
    pub(crate) fn offer(&mut self, command: &Command, parts: &Chain, now_ns: i64) {
        let us = |ns: i64| ns as f64 / 1e3;
        let reaction_time_us = us(parts.sum_ns());
        let place = self.chains.partition_point(|kept| kept.reaction_time_us >= reaction_time_us);
        if place == KEPT {
            return;
        }
        let age =
            |origin: Origin| origin.is_some().then(|| us(command.start_ns - origin.acquisition_ns));
        let header = &command.header;
        let chain = WorstChain {
            t_s: now_ns as f64 / 1e9,
            radar_sequence: header.origins.radar.sequence,
            command_sequence: header.sequence,
            reaction_time_us,
            designed_wait_us: us(parts.designed_wait_ns(command)),
            hops_us: parts.0.map(us).into(),
            deadline_missed: header.publish_ns - header.acquisition_ns > self.deadline_ns,
            odometry_age_us: age(header.origins.odometry),
            radar_age_us: age(header.origins.radar),
            spat_age_us: age(header.origins.spat),
            solver_iterations: command.solver_iterations,
            mode: command.mode,
            voluntary_switches: command.voluntary_switches,
            involuntary_switches: command.involuntary_switches,
            minor_faults: command.minor_faults,
            major_faults: command.major_faults,
        };
        self.chains.truncate(KEPT - 1);
        self.chains.insert(place, chain);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    #[test]
    fn the_ten_longest_are_kept_in_order_with_their_cycle() {
        let mut worst = Worst::new(60);
        for k in 1..=100_u64 {
            let mut command = Command::zeroed();
            command.header.sequence = k;
            command.header.origins.radar = Origin { sequence: k, acquisition_ns: 0, publish_ns: 0 };
            command.minor_faults = 7;
            // Each length occurs twice, in no order.
            let length = i64::try_from(k * 37 % 50).expect("small");
            command.header.publish_ns = length * 2;
            let parts = Chain([0, 0, 0, length, 0, 0, 0]);
            worst.offer(&command, &parts, 0);
        }
        let report = worst.chains;
        let lengths: Vec<_> =
            report.iter().map(|c| (c.reaction_time_us * 1e3).round() as i64).collect();
        assert_eq!(lengths, [49, 49, 48, 48, 47, 47, 46, 46, 45, 45]);
        assert!(report[0].command_sequence < report[1].command_sequence, "the earlier one first");
        assert!(report.iter().all(|c| c.deadline_missed && c.minor_faults == 7));
        assert_eq!(report[0].odometry_age_us, None);
    }
}
