//! Cause-effect chains as the plant sees them end: from radar acquisition to actuation.
//!
//! *Reaction time*: radar acquisition to the first actuation that uses it, once per radar sample
//! that reaches the actuators. *Data age*: every actuation back to the radar sample behind it. The
//! parts of a reaction time add up to it exactly, since each begins where the last one ended:
//!
//! ```text
//! acquisition ──► controller starts ──► command published ──► actuated
//!    radar_to_controller   controller_compute   controller_to_plant
//! ```

use shared::messages::{Command, Origin};
use shared::report::{ChainCurves, Hops};
use shared::statistics::{Latencies, Percentiles};

/// Histograms of all chains of a run.
#[derive(Debug, Default)]
pub struct Chains {
    reaction: Latencies,
    age: Latencies,
    radar_to_controller: Latencies,
    controller_compute: Latencies,
    controller_to_plant: Latencies,
    last_radar: Option<Origin>,
}

/// The parts of one reaction time, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Radar acquisition to the start of the control cycle.
    pub radar_to_controller_ns: i64,
    /// Start of the control cycle to the command's publication.
    pub controller_compute_ns: i64,
    /// Publication to actuation.
    pub controller_to_plant_ns: i64,
}

impl Parts {
    /// The parts of the chain that ends with `command` actuated at `now_ns`.
    #[must_use]
    pub fn of(command: &Command, now_ns: i64) -> Self {
        let acquired_ns = command.header.origins.radar.acquisition_ns;
        Self {
            radar_to_controller_ns: command.start_ns - acquired_ns,
            controller_compute_ns: command.header.publish_ns - command.start_ns,
            controller_to_plant_ns: now_ns - command.header.publish_ns,
        }
    }

    /// Their sum: the reaction time.
    #[must_use]
    pub fn sum_ns(&self) -> i64 {
        self.radar_to_controller_ns + self.controller_compute_ns + self.controller_to_plant_ns
    }
}

impl Chains {
    /// Records that `command` acts at `now_ns`; called in every cycle of the plant.
    pub fn actuated(&mut self, command: &Command, now_ns: i64) {
        let radar = command.header.origins.radar;
        if !radar.is_some() {
            return;
        }
        self.age.record_ns(now_ns - radar.acquisition_ns);
        if self.last_radar == Some(radar) {
            return;
        }
        self.last_radar = Some(radar);
        let parts = Parts::of(command, now_ns);
        self.reaction.record_ns(parts.sum_ns());
        self.radar_to_controller.record_ns(parts.radar_to_controller_ns);
        self.controller_compute.record_ns(parts.controller_compute_ns);
        self.controller_to_plant.record_ns(parts.controller_to_plant_ns);
    }

    /// Percentiles of the reaction time.
    #[must_use]
    pub fn reaction_us(&self) -> Option<Percentiles> {
        self.reaction.percentiles_us()
    }

    /// Percentiles of the data age.
    #[must_use]
    pub fn age_us(&self) -> Option<Percentiles> {
        self.age.percentiles_us()
    }

    /// Percentiles of the reaction time's parts.
    #[must_use]
    pub fn hops_us(&self) -> Hops {
        Hops {
            radar_to_controller: self.radar_to_controller.percentiles_us(),
            controller_compute: self.controller_compute.percentiles_us(),
            controller_to_plant: self.controller_to_plant.percentiles_us(),
        }
    }

    /// Whole distributions of the reaction time and its parts.
    #[must_use]
    pub fn curves(&self) -> ChainCurves {
        ChainCurves {
            reaction_time: self.reaction.quantile_curve(),
            radar_to_controller: self.radar_to_controller.quantile_curve(),
            controller_compute: self.controller_compute.quantile_curve(),
            controller_to_plant: self.controller_to_plant.quantile_curve(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    fn command(radar_sequence: u64, acquired: i64, start: i64, published: i64) -> Command {
        let mut command = Command::zeroed();
        let origin =
            Origin { sequence: radar_sequence, acquisition_ns: acquired, publish_ns: acquired + 5 };
        command.header.origins.radar = origin;
        command.header.publish_ns = published;
        command.start_ns = start;
        command
    }

    #[test]
    fn parts_add_up_to_the_reaction_time() {
        let parts = Parts::of(&command(1, 100, 130, 175), 220);
        assert_eq!(parts.sum_ns(), 220 - 100);
        assert_eq!((parts.radar_to_controller_ns, parts.controller_compute_ns), (30, 45));
    }

    #[test]
    fn a_radar_sample_reacts_once_and_ages_on() {
        let mut chains = Chains::default();
        chains.actuated(&command(0, -1, 0, 0), 10);
        assert_eq!(chains.age_us(), None, "a command without a radar sample is no chain");
        let first = command(1, 0, 1_000, 2_000);
        chains.actuated(&first, 3_000);
        chains.actuated(&first, 13_000);
        chains.actuated(&command(2, 10_000, 11_000, 12_000), 23_000);
        let count = |p: Option<Percentiles>| p.map_or(0, |p| p.count);
        assert_eq!((count(chains.reaction_us()), count(chains.age_us())), (2, 3));
        let hops = chains.hops_us();
        assert_eq!(count(hops.radar_to_controller), 2);
        assert_eq!(chains.reaction_us().map(|p| p.max.round()), Some(13.0));
    }
}
