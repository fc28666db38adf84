//! Cause-effect chains that end in the plant: from radar acquisition to actuation.
//!
//! *Reaction time*: radar acquisition to the first actuation that uses it, once per radar sample
//! that reaches the actuators. *Data age*: every actuation back to the radar sample behind it. The
//! parts of a reaction time add up to it exactly, since each begins where the last one ended:
//!
//! ```text
//! acquired ─► published ─► controller idle ─► started ─► published ─► plant due ─► awake ─► actuated
//!     radar_publish  controller_queue  radar_transport  controller_compute   │        │        │
//!                                                            command_wait ───┘        │        │
//!                                                            command_transport ───────┘        │
//!                                                            actuate ──────────────────────────┘
//! ```
//!
//! Three waits are designed. The radar has a modelled latency. The controller waits for a release of its own timer. The
//! command waits for the plant's next release, with the scenario's extra delay. They end at *scheduled* instants:
//! lateness is not part of the design. The rest, the *net* reaction time, is the cost of the deployment.

use crate::parts::{Actuated, Chain, PARTS};
use crate::report::Hops;
use crate::worst::Worst;
use bytemuck::Zeroable;
use messages::{Brake, Command, Origin};
use runtime::chain::ChainTimes;
use runtime::statistics::Latencies;
use runtime::{Figures, RuntimeError};
use std::collections::BTreeMap;

pub(crate) const CONTROL_PATH: &str = "control";
pub(crate) const BRAKE_PATH: &str = "brake";

/// Names of the parts, in order of time.
const NAMES: [&str; PARTS] = [
    "radar_publish",
    "controller_queue",
    "radar_transport",
    "controller_compute",
    "command_wait",
    "command_transport",
    "actuate",
];

/// Histograms of all chains of a run.
#[derive(Debug)]
pub(crate) struct Chains {
    /// The times that every chain has; the parts are [`NAMES`].
    pub(crate) times: ChainTimes,
    radar_to_controller: Latencies,
    controller_to_plant: Latencies,
    pub(crate) worst: Worst,
    /// The radar sample of the last reaction. The next process goes on from it: a command that it finds held has acted
    /// before.
    pub(crate) last_radar: Option<Origin>,
    /// A reaction that is not counted yet, and the designed waits in it, ns.
    ended: Option<(Chain, i64)>,
}

impl Chains {
    /// The chains of `path` that `figures` has, none before the run. A control cycle is late if its command comes
    /// `deadline_ns` after its release.
    pub(crate) fn open(
        deadline_ns: i64,
        path: &str,
        figures: &Figures,
    ) -> Result<Self, RuntimeError> {
        let open = |name: &str| figures.latencies(&format!("{path}.{name}"));
        let late = figures.count(&format!("{path}.late"))?;
        Ok(Self {
            times: ChainTimes::open(NAMES, deadline_ns, late, open)?,
            radar_to_controller: open("radar_to_controller")?,
            controller_to_plant: open("controller_to_plant")?,
            worst: Worst::new(deadline_ns),
            last_radar: None,
            ended: None,
        })
    }

    /// Records that `command` acts at `actuated`; called in every cycle of the plant.
    pub(crate) fn actuated(&mut self, command: &Command, actuated: &Actuated) {
        if let Some(parts) = self.record(command, actuated) {
            self.worst.offer(command, &parts, actuated.now_ns);
        }
    }

    /// The same for a request of the emergency brake.
    pub(crate) fn braked(&mut self, brake: &Brake, actuated: &Actuated) {
        let Brake { header, radar_release_ns, idle_ns, start_ns, .. } = *brake;
        let stamps = Command { header, radar_release_ns, idle_ns, start_ns, ..Command::zeroed() };
        self.record(&stamps, actuated);
    }

    /// The parts of a chain that ends here for the first time. [`Self::count`] counts them.
    fn record(&mut self, command: &Command, actuated: &Actuated) -> Option<Chain> {
        let radar = command.header.origins.radar;
        if !radar.is_some() {
            return None;
        }
        self.times.age.record_ns(actuated.now_ns - radar.acquisition_ns);
        if self.last_radar == Some(radar) {
            return None;
        }
        self.last_radar = Some(radar);
        let parts = Chain::of(command, actuated);
        self.ended = Some((parts, parts.designed_wait_ns(command)));
        Some(parts)
    }

    /// Counts the reaction that has just ended, if any. Called when [`Self::last_radar`] is kept: a process that dies
    /// before or after leaves no reaction that the next one counts again.
    pub(crate) fn count(&mut self) {
        let Some((parts, designed)) = self.ended.take() else { return };
        self.times.count(&parts.0, designed);
        // From the acquisition to the control cycle, and from the command to the actuation.
        self.radar_to_controller.record_ns(parts.0[..3].iter().sum());
        self.controller_to_plant.record_ns(parts.0[4..].iter().sum());
    }

    pub(crate) fn hops_us(&self) -> Hops {
        let parts: [_; PARTS] = std::array::from_fn(|part| self.times.parts[part].percentiles_us());
        Hops {
            radar_to_controller: self.radar_to_controller.percentiles_us(),
            controller_to_plant: self.controller_to_plant.percentiles_us(),
            parts: parts.into(),
        }
    }

    /// All histograms by the names of their figures.
    pub(crate) fn histograms(&self) -> BTreeMap<String, Latencies> {
        let whole = [
            ("reaction_time", &self.times.reaction),
            ("data_age", &self.times.age),
            ("designed_wait", &self.times.designed_wait),
            ("net_reaction", &self.times.net_reaction),
        ];
        let parts = NAMES.into_iter().zip(&self.times.parts);
        whole.into_iter().chain(parts).map(|(name, h)| (name.to_owned(), h.clone())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use runtime::statistics::Percentiles;

    fn command(radar: Origin, released: i64, idle: i64, start: i64, published: i64) -> Command {
        let mut command = Command::zeroed();
        command.header.origins.radar = radar;
        command.header.acquisition_ns = released;
        command.header.publish_ns = published;
        command.radar_release_ns = radar.acquisition_ns;
        (command.idle_ns, command.start_ns) = (idle, start);
        command
    }

    fn radar(sequence: u64, acquisition_ns: i64, publish_ns: i64) -> Origin {
        Origin { sequence, acquisition_ns, publish_ns }
    }

    fn at(scheduled_ns: i64, start_ns: i64, now_ns: i64) -> Actuated {
        Actuated { scheduled_ns, start_ns, now_ns }
    }

    #[test]
    fn parts_of_a_quiet_chain() {
        let quiet = command(radar(1, 100, 130), 100, 20, 142, 175);
        let parts = Chain::of(&quiet, &at(200, 208, 220));
        assert_eq!(parts.0, [30, 0, 12, 33, 25, 8, 12]);
        assert_eq!((parts.sum_ns(), parts.designed_wait_ns(&quiet)), (120, 25));
    }

    #[test]
    fn a_busy_controller_queues_by_accident_and_a_timer_by_design() {
        // Idle 40 after the sample was published: no designed wait.
        let busy = command(radar(1, 100, 130), 100, 170, 174, 190);
        let parts = Chain::of(&busy, &at(200, 200, 200));
        assert_eq!((parts.0[1], parts.0[2]), (40, 4));
        assert_eq!(parts.designed_wait_ns(&busy), 10);
        // Released by its timer 20 after the publication, awake 5 later.
        let timer = command(radar(1, 100, 130), 150, 90, 155, 180);
        let parts = Chain::of(&timer, &at(200, 200, 200));
        assert_eq!((parts.0[1], parts.0[2]), (20, 5));
        assert_eq!(parts.designed_wait_ns(&timer), 20 + 20);
    }

    #[test]
    fn a_radar_with_latency_waits_by_design_and_a_late_plant_does_not() {
        let mut late = command(radar(1, 100, 163), 150, 90, 170, 180);
        late.radar_release_ns = 150;
        // The plant was due at 160, before the command was there, and awoke at 230.
        let parts = Chain::of(&late, &at(160, 230, 240));
        assert_eq!((parts.0[4], parts.0[5]), (0, 50));
        assert_eq!((parts.sum_ns(), parts.designed_wait_ns(&late)), (140, 50));
    }

    #[test]
    fn parts_add_up_whatever_the_stamps() {
        let mut state = 1_u64;
        let mut random = |span: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            i64::try_from((state >> 33) % span).expect("small")
        };
        for _ in 0..10_000 {
            let origin = radar(1, random(50), random(100));
            let command = command(origin, random(200), random(200), random(200), random(200));
            let now = 250 + random(100);
            let parts = Chain::of(&command, &at(random(250), random(250), now));
            assert_eq!(parts.sum_ns(), now - origin.acquisition_ns, "{command:?}");
            let designed = parts.designed_wait_ns(&command);
            assert!((0..=parts.sum_ns()).contains(&designed));
        }
    }

    #[test]
    fn a_radar_sample_reacts_once_and_ages_on() {
        let mut chains = Chains::open(100_000, "control", &Figures::default()).expect("memory");
        let none = command(radar(0, -1, -1), 0, 0, 0, 0);
        chains.actuated(&none, &at(10, 10, 10));
        assert_eq!(
            chains.times.age.percentiles_us(),
            None,
            "a command without a radar sample is not a chain"
        );
        let first = command(radar(1, 0, 500), 0, 0, 1_000, 2_000);
        chains.actuated(&first, &at(3_000, 3_000, 3_000));
        chains.count();
        chains.actuated(&first, &at(13_000, 13_000, 13_000));
        chains.count();
        let second = command(radar(2, 10_000, 10_500), 10_000, 3_000, 11_000, 12_000);
        chains.actuated(&second, &at(23_000, 23_000, 23_000));
        chains.count();
        let count = |p: Option<Percentiles>| p.map_or(0, |p| p.count);
        assert_eq!(
            (
                count(chains.times.reaction.percentiles_us()),
                count(chains.times.age.percentiles_us())
            ),
            (2, 3)
        );
        let hops = chains.hops_us();
        for part in [hops.radar_to_controller, hops.parts.radar_transport, hops.parts.actuate] {
            assert_eq!(count(part), 2);
        }
        assert_eq!(chains.times.reaction.percentiles_us().map(|p| p.max), Some(13.0));
        let longest = &chains.worst.chains;
        assert_eq!(longest.iter().map(|w| w.radar_sequence).collect::<Vec<_>>(), [2, 1]);
    }

    #[test]
    fn a_process_that_dies_at_any_point_counts_no_sample_twice() {
        for is_kept in [false, true] {
            let open = || Chains::open(100_000, "control", &Figures::default()).expect("memory");
            let (mut reactions, mut kept) = (0, None);
            // Six processes, one after the other; each finds the held command and takes one more.
            for sample in 1..=6 {
                let mut chains = open();
                chains.last_radar = kept;
                for sequence in [sample, sample + 1] {
                    let next = command(radar(sequence, 0, 500), 0, 0, 1_000, 2_000);
                    chains.actuated(&next, &at(3_000, 3_000, 3_000));
                    if sequence == sample || is_kept {
                        kept = chains.last_radar;
                        chains.count();
                    }
                }
                reactions += chains.times.reaction.percentiles_us().map_or(0, |p| p.count);
            }
            assert_eq!(reactions, if is_kept { 7 } else { 6 });
        }
    }
}
