//! The way of a command from the topic to the actuators, with the delays and misses that a scenario
//! adds to it.
//!
//! A command arrives `extra_delay_ms` after its publication, plus a time drawn uniformly from the
//! whole periods of the plant up to `extra_jitter_ms`; with `miss_probability` it never does, as if
//! its control cycle had missed. One that a newer one overtook is dropped. Each command takes two
//! numbers of the random stream, so that the jitter does not depend on the misses, nor they on it.

use messages::{Command, Origins};
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use scenario::Scenario;
use std::collections::VecDeque;

/// Keeps this stream apart from those of other components with the same seed.
const STREAM: u64 = 0x5851_f42d_4c95_7f2d;

/// A command that has arrived.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// The command.
    pub command: Command,
    /// By how much it was delayed, ns.
    pub delay_ns: i64,
}

impl Arrival {
    /// Release of the cycle that made the command, ns of run time.
    ///
    /// It is the command's stamp, unless that is wrong: a cycle of before the next one's release does not know
    /// what was measured after that. Where the stamp says otherwise, the sender's clock is behind, and the
    /// newest sample tells when the cycle was. Else a plan that says what to do from now on would be
    /// followed from its middle on. Samples of after `now_ns` tell nothing: there are none.
    #[must_use]
    pub fn released_ns(&self, now_ns: i64) -> i64 {
        let Command { header, plan_period_ns, .. } = &self.command;
        let Origins { odometry, radar, spat, map, powertrain, preview } = header.origins;
        let samples = [odometry, radar, spat, map, powertrain, preview];
        let stamps = samples.into_iter().map(|sample| sample.acquisition_ns);
        let newest_ns = stamps.filter(|stamp_ns| *stamp_ns <= now_ns).max();
        match newest_ns {
            Some(newest_ns) if newest_ns > header.acquisition_ns + plan_period_ns => newest_ns,
            _ => header.acquisition_ns,
        }
    }
}

/// Commands on their way.
#[derive(Debug)]
pub struct Delivery {
    delay_ns: i64,
    period_ns: i64,
    /// Longest jitter, in periods of the plant.
    jitter_periods: u64,
    miss_probability: f64,
    random: Pcg64,
    /// Oldest first, with room for all that can be on their way at once.
    on_their_way: VecDeque<Arrival>,
    /// Incarnation and sequence number of the last command taken.
    taken: Option<(u32, u64)>,
    undelivered: u64,
}

impl Delivery {
    /// The way that a scenario describes.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        let runtime = &scenario.runtime;
        let period_ms = scenario.plant.period_ms.value();
        let jitter_periods = runtime.extra_jitter_ms.value() / period_ms;
        let longest = runtime.extra_delay_ms.value() / period_ms + jitter_periods;
        Self {
            delay_ns: i64::from(runtime.extra_delay_ms.value()) * 1_000_000,
            period_ns: i64::from(period_ms) * 1_000_000,
            jitter_periods: jitter_periods.into(),
            miss_probability: runtime.miss_probability.value(),
            random: Pcg64::seed_from_u64(scenario.seed.value() ^ STREAM),
            on_their_way: VecDeque::with_capacity(longest as usize + 2),
            taken: None,
            undelivered: 0,
        }
    }

    /// Goes on counting from what was counted before this process.
    pub fn restore(&mut self, undelivered: u64) {
        self.undelivered = undelivered;
    }

    /// Takes the topic's newest command, unless it has been taken before.
    pub fn take(&mut self, newest: &Command) {
        let identity = (newest.header.incarnation, newest.header.sequence);
        if self.taken == Some(identity) || self.on_their_way.len() == self.on_their_way.capacity() {
            return;
        }
        self.taken = Some(identity);
        let [miss, jitter] = [(); 2].map(|()| random::uniform(&mut self.random));
        if miss < self.miss_probability {
            self.undelivered += 1;
            return;
        }
        let periods = (jitter * (self.jitter_periods + 1) as f64) as i64;
        let delay_ns = self.delay_ns + periods * self.period_ns;
        self.on_their_way.push_back(Arrival { command: *newest, delay_ns });
    }

    /// The newest command that has arrived by `now_ns`, once.
    pub fn arrived(&mut self, now_ns: i64) -> Option<Arrival> {
        let due = |way: &Arrival| now_ns >= way.command.header.publish_ns + way.delay_ns;
        let newest = self.on_their_way.iter().rposition(due)?;
        let overtaken = self.on_their_way.drain(..newest).count() as u64;
        self.undelivered += overtaken;
        self.on_their_way.pop_front()
    }

    /// Commands that never arrived: missed, or overtaken by a newer one.
    #[must_use]
    pub fn undelivered(&self) -> u64 {
        self.undelivered
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    const PERIOD_NS: i64 = 10_000_000;

    #[test]
    fn a_clock_that_is_behind_is_told_by_what_the_cycle_knew() {
        let released_ms = |stamp_ms: i64, odometry_ms: i64, spat_ms: i64| {
            let mut command = Command::zeroed();
            command.plan_period_ns = 100_000_000;
            command.header.acquisition_ns = stamp_ms * 1_000_000;
            command.header.origins = Origins::NONE;
            command.header.origins.odometry.acquisition_ns = odometry_ms * 1_000_000;
            command.header.origins.spat.acquisition_ns = spat_ms * 1_000_000;
            Arrival { command, delay_ns: 0 }.released_ns(5_050_000_000) / 1_000_000
        };
        assert_eq!(released_ms(5_000, 5_000, 4_900), 5_000);
        assert_eq!(released_ms(5_000, 5_040, 4_900), 5_000, "the cycle began late");
        assert_eq!(
            released_ms(4_200, 4_200, 4_100),
            4_200,
            "on its way for long, with its samples"
        );
        assert_eq!(released_ms(4_200, 5_000, 4_900), 5_000, "the clock was set back");
        assert_eq!(released_ms(4_200, 4_000, 4_900), 4_900, "odometry is missing");
        assert_eq!(released_ms(4_200, 4_200, 9_000), 4_200, "no sample is of the future");
    }

    fn delivery(keys: &str) -> Delivery {
        let text = format!("schema_version = 1\nname = \"x\"\n[runtime]\n{keys}\n");
        Delivery::new(&Scenario::parse("x.toml", &text).unwrap_or_else(|error| panic!("{error}")))
    }

    /// Sends a command every 100 ms and says which arrive when: (sequence number, ns).
    fn drive(mut delivery: Delivery, commands: u64) -> (Vec<(u64, i64)>, u64) {
        let mut arrivals = Vec::new();
        let mut newest = Command::zeroed();
        for step in 0..commands as i64 * 10 {
            let now_ns = step * PERIOD_NS;
            if step % 10 == 0 {
                newest.header.sequence = step as u64 / 10;
                newest.header.publish_ns = now_ns;
            }
            delivery.take(&newest);
            if let Some(arrival) = delivery.arrived(now_ns) {
                arrivals.push((arrival.command.header.sequence, now_ns));
            }
        }
        (arrivals, delivery.undelivered())
    }

    #[test]
    fn without_delay_each_command_arrives_at_once() {
        let (arrivals, undelivered) = drive(delivery(""), 3);
        assert_eq!(arrivals, [(0, 0), (1, 10 * PERIOD_NS), (2, 20 * PERIOD_NS)]);
        assert_eq!(undelivered, 0);
    }

    #[test]
    fn a_constant_delay_moves_all_and_loses_none() {
        let (arrivals, undelivered) = drive(delivery("extra_delay_ms = 250"), 5);
        assert_eq!(arrivals, [(0, 25), (1, 35), (2, 45)].map(|(k, p)| (k, p * PERIOD_NS)));
        assert_eq!(undelivered, 0);
    }

    #[test]
    fn jitter_is_bounded_spread_and_seeded() {
        let keys = "extra_delay_ms = 20\nextra_jitter_ms = 50";
        let (arrivals, undelivered) = drive(delivery(keys), 6000);
        assert_eq!(undelivered, 0, "a jitter shorter than the period overtakes no command");
        let mut counts = [0; 6];
        for (sequence, now_ns) in &arrivals {
            let delay_ns = now_ns - *sequence as i64 * 10 * PERIOD_NS;
            counts[(delay_ns / PERIOD_NS - 2) as usize] += 1;
        }
        // 1000 expected of each; the standard deviation is 29.
        assert!(counts.iter().all(|count| (850..1150).contains(count)), "{counts:?}");
        assert_eq!(drive(delivery(keys), 6000).0, arrivals, "the same seed, the same delays");
    }

    #[test]
    fn an_overtaken_command_never_acts() {
        let (arrivals, undelivered) = drive(delivery("extra_jitter_ms = 500"), 2000);
        assert!(arrivals.windows(2).all(|pair| pair[0].0 < pair[1].0), "newest wins");
        assert!(undelivered > 100, "a long jitter overtakes: {undelivered}");
    }

    #[test]
    fn misses_come_as_often_as_asked_and_leave_the_jitter_alone() {
        let (arrivals, undelivered) =
            drive(delivery("extra_jitter_ms = 50\nmiss_probability = 0.25"), 4000);
        // 1000 expected; the standard deviation is 27.
        assert!((860..1140).contains(&undelivered), "{undelivered}");
        let (all, _) = drive(delivery("extra_jitter_ms = 50"), 4000);
        assert!(arrivals.iter().all(|arrival| all.contains(arrival)));
        let (none, undelivered) = drive(delivery("miss_probability = 1"), 100);
        assert!(none.is_empty() && undelivered == 100);
    }
}
