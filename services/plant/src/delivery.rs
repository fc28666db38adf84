//! The path of a command from the topic to the actuators, with the scenario's delays and misses.
//!
//! A command arrives `extra_delay_ms` after its publication, plus a jitter. The jitter is drawn uniformly from the
//! whole periods of the plant up to `extra_jitter_ms`. With `miss_probability` it never arrives, as if its control
//! cycle had missed. A command that a newer one overtook is dropped. Each command takes two numbers of the random
//! stream, so that jitter and misses do not depend on each other.
//!
//! The stamps of a command are of its sender's clock, which may differ from the plant's. The plant corrects an
//! impossible stamp: no command was sent after its arrival.

use messages::{Command, Origins};
use rand_core::SeedableRng;
use rand_pcg::Pcg64;
use scenario::Scenario;
use std::collections::VecDeque;

/// Keeps this stream apart from those of other components with the same seed.
const STREAM: u64 = 0x5851_f42d_4c95_7f2d;

#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrival {
    pub(crate) command: Command,
    pub(crate) delay_ns: i64,
    /// True if it has the content of the command before it, under new stamps.
    pub(crate) is_repeated: bool,
    /// Time when the plant found it on the topic, ns of run time.
    taken_ns: i64,
}

impl Arrival {
    /// Release of the cycle that made the command, ns of run time.
    ///
    /// It is the command's stamp, unless the sender's clock differs from the plant's. Two observations show that:
    ///
    /// * The stamp is later than the arrival. The clock is ahead; the release was at the arrival or before it.
    /// * A sample that the cycle used is newer than the end of the stamp's period. The clock is behind, and the
    ///   newest sample shows when the cycle was. Otherwise the gateway would follow the plan from its middle on.
    ///   A sample stamped after `now_ns` shows nothing.
    pub(crate) fn released_ns(&self, now_ns: i64) -> i64 {
        let Command { header, plan_period_ns, .. } = &self.command;
        let Origins { odometry, radar, spat, map, powertrain, preview } = header.origins;
        let samples = [odometry, radar, spat, map, powertrain, preview];
        let stamps = samples.into_iter().map(|sample| sample.acquisition_ns);
        let newest_ns = stamps.filter(|stamp_ns| *stamp_ns <= now_ns).max();
        let stamp_ns = header.acquisition_ns.min(self.taken_ns);
        match newest_ns {
            Some(newest_ns) if newest_ns > stamp_ns + plan_period_ns => newest_ns,
            _ => stamp_ns,
        }
    }

    /// Time when it reaches the actuators, ns of run time.
    fn due_ns(&self) -> i64 {
        self.command.header.publish_ns.min(self.taken_ns) + self.delay_ns
    }
}

/// Commands on their way.
#[derive(Debug)]
pub(crate) struct Delivery {
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
    /// Start of the cycle that made it, by its own account, ns of run time.
    started_ns: Option<i64>,
    /// Commands that never arrived: missed, or overtaken by a newer one.
    pub(crate) undelivered: u64,
}

impl Delivery {
    pub(crate) fn new(scenario: &Scenario) -> Self {
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
            started_ns: None,
            undelivered: 0,
        }
    }

    /// Takes the topic's newest command at `now_ns`, unless it has been taken before.
    pub(crate) fn take(&mut self, newest: &Command, now_ns: i64) {
        let identity = (newest.header.incarnation, newest.header.sequence);
        if self.taken == Some(identity) || self.on_their_way.len() == self.on_their_way.capacity() {
            return;
        }
        self.taken = Some(identity);
        // No two cycles begin at one instant, whatever the sender's clock shows.
        let is_repeated = self.started_ns.replace(newest.start_ns) == Some(newest.start_ns);
        let [miss, jitter] = [(); 2].map(|()| random::uniform(&mut self.random));
        if miss < self.miss_probability {
            self.undelivered += 1;
            return;
        }
        let periods = (jitter * (self.jitter_periods + 1) as f64) as i64;
        let delay_ns = self.delay_ns + periods * self.period_ns;
        let arrival = Arrival { command: *newest, delay_ns, is_repeated, taken_ns: now_ns };
        self.on_their_way.push_back(arrival);
    }

    /// The newest command that has arrived by `now_ns`, once.
    pub(crate) fn arrived(&mut self, now_ns: i64) -> Option<Arrival> {
        let newest = self.on_their_way.iter().rposition(|way| now_ns >= way.due_ns())?;
        let overtaken = self.on_their_way.drain(..newest).count() as u64;
        self.undelivered += overtaken;
        self.on_their_way.pop_front()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    const PERIOD_NS: i64 = 10_000_000;

    #[test]
    fn a_clock_that_differs_from_the_plants_is_corrected() {
        let released_ms = |stamp_ms: i64, odometry_ms: i64, spat_ms: i64| {
            let mut command = Command::zeroed();
            command.plan_period_ns = 100_000_000;
            command.header.acquisition_ns = stamp_ms * 1_000_000;
            command.header.origins = Origins::NONE;
            command.header.origins.odometry.acquisition_ns = odometry_ms * 1_000_000;
            command.header.origins.spat.acquisition_ns = spat_ms * 1_000_000;
            let taken_ns = 5_050_000_000;
            let arrival = Arrival { command, delay_ns: 0, is_repeated: false, taken_ns };
            arrival.released_ns(taken_ns) / 1_000_000
        };
        assert_eq!(released_ms(5_052, 5_000, 4_900), 5_050, "the clock is ahead");
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
                newest.start_ns = now_ns;
            }
            delivery.take(&newest, now_ns);
            if let Some(arrival) = delivery.arrived(now_ns) {
                arrivals.push((arrival.command.header.sequence, now_ns));
            }
        }
        (arrivals, delivery.undelivered)
    }

    #[test]
    fn without_delay_each_command_arrives_at_once() {
        let (arrivals, undelivered) = drive(delivery(""), 3);
        assert_eq!(arrivals, [(0, 0), (1, 10 * PERIOD_NS), (2, 20 * PERIOD_NS)]);
        assert_eq!(undelivered, 0);
    }

    #[test]
    fn a_clock_that_is_ahead_delays_no_command_and_repeats_no_command() {
        for ahead_ns in [0, 100_000, 2_000_000, 20_000_000] {
            let mut delivery = delivery("");
            let mut command = Command::zeroed();
            command.plan_period_ns = 100_000_000;
            for cycle in 0..20 {
                let now_ns = cycle * 10 * PERIOD_NS;
                command.header.sequence += 1;
                command.start_ns = now_ns;
                command.header.acquisition_ns = now_ns + ahead_ns;
                command.header.publish_ns = now_ns + ahead_ns;
                delivery.take(&command, now_ns);
                let arrival = delivery.arrived(now_ns).expect("it is here");
                assert!(!arrival.is_repeated, "{ahead_ns}");
                assert_eq!(arrival.released_ns(now_ns), now_ns, "{ahead_ns}");
            }
        }
    }

    #[test]
    fn frozen_content_under_new_stamps_is_a_repetition() {
        let mut delivery = delivery("");
        let mut command = Command::zeroed();
        let repeated = [0, 100, 100, 100, 400].map(|start_ms| {
            command.header.sequence += 1;
            command.start_ns = start_ms * 1_000_000;
            delivery.take(&command, 0);
            delivery.arrived(0).expect("it is here").is_repeated
        });
        assert_eq!(repeated, [false, false, true, true, false]);
    }

    #[test]
    fn a_constant_delay_moves_all_and_loses_nothing() {
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

    #[test]
    fn the_count_of_undelivered_commands_goes_on_in_the_next_process() {
        let mut delivery = delivery("miss_probability = 1");
        delivery.undelivered = 7;
        assert_eq!(delivery.undelivered, 7);
        assert_eq!(drive(delivery, 3).1, 10);
    }
}
