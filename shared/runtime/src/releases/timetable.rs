//! Services that are due in a step.

use messages::{Pace, Service, Topic};
use scenario::Scenario;
use serde::{Deserialize, Serialize};

/// Periods of all services in simulation steps; the plant is due in every step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Timetable {
    /// Length of a step, ns: the plant's period.
    pub step_ns: i64,
    /// Steps between two releases of each service, in the order of [`Service::ALL`].
    pub strides: [u64; Service::ALL.len()],
    pub last_step: u64,
}

impl Timetable {
    /// The timetable of a checked scenario.
    ///
    /// # Panics
    /// If a period is not a multiple of the plant's, which the scenario's check rules out.
    pub fn of(scenario: &Scenario) -> Self {
        let step_ms = scenario.plant.period_ms.value();
        let strides = Service::ALL.map(|service| {
            let period_ms = match service.descriptor().pace {
                Pace::Plant => step_ms,
                Pace::Radar => scenario.perception.period_ms.value(),
                // Frames of other hosts do not come in step: they are looked for more often.
                Pace::Signals if scenario.v2x.radio.is_live() => {
                    scenario.v2x.poll_ms.map_or(step_ms, |poll_ms| poll_ms.value())
                }
                Pace::Signals => scenario.v2x.period_ms.value(),
                Pace::Control => scenario.controller.period_ms.value(),
            };
            assert!(period_ms.is_multiple_of(step_ms), "{service}: {period_ms} ms of {step_ms} ms");
            u64::from(period_ms / step_ms)
        });
        let last_step = scenario.duration_s.value() * 1e3 / f64::from(step_ms);
        Self {
            step_ns: i64::from(step_ms) * 1_000_000,
            strides,
            last_step: (last_step + 1e-6).floor() as u64,
        }
    }

    /// Steps between two releases of `service`.
    pub fn stride(&self, service: Service) -> u64 {
        self.strides[service.index()]
    }

    pub fn is_due(&self, service: Service, step: u64) -> bool {
        step.is_multiple_of(self.stride(service))
    }

    /// Newest step up to `step` in which `service` was released.
    pub fn latest_release(&self, service: Service, step: u64) -> u64 {
        step - step % self.stride(service)
    }

    /// True if some consumer of `topic` is released in `step`, and so waits for its sample.
    pub fn is_awaited(&self, topic: Topic, step: u64) -> bool {
        topic.consumers().iter().any(|&consumer| self.is_due(consumer, step))
    }

    pub fn period_ns(&self, service: Service) -> i64 {
        let stride = i64::try_from(self.stride(service)).expect("strides are small");
        self.step_ns * stride
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_other_hosts_are_looked_for_in_each_step_or_as_the_scenario_says() {
        let period_ms = |keys: &str| {
            let text = format!("schema_version = 1\nname = \"poll\"\n[v2x]\n{keys}");
            let table = Timetable::of(&Scenario::parse("poll", &text).expect("right"));
            assert_eq!(table.period_ns(Service::V2xSim), table.period_ns(Service::Obu));
            table.period_ns(Service::Obu) / 1_000_000
        };
        assert_eq!(period_ms("radio = \"frames\""), 100);
        assert_eq!(period_ms("radio = \"udp://239.255.3.1:5520\""), 10);
        assert_eq!(period_ms("radio = \"udp://239.255.3.1:5520\"\npoll_ms = 40"), 40);
        assert_eq!(period_ms("radio = \"pcap:drive.pcap\""), 100, "of the run's own time");
    }

    #[test]
    fn releases_and_waits() {
        let table =
            Timetable { step_ns: 10_000_000, strides: [1, 5, 10, 10, 5, 10], last_step: 1000 };
        assert!(table.is_due(Service::PerceptionSim, 5) && !table.is_due(Service::V2xSim, 5));
        assert_eq!(table.latest_release(Service::PerceptionSim, 9), 5);
        assert_eq!(table.period_ns(Service::Controller), 100_000_000);
        assert!(table.is_awaited(Topic::Odometry, 5), "perception-sim is due");
        assert!(!table.is_awaited(Topic::Odometry, 4), "the plant alone is due");
        assert!(!table.is_awaited(Topic::RadarTracks, 5), "the controller is not due");
        assert!(table.is_awaited(Topic::VehicleTruth, 5), "the plant is always due");
    }
}
