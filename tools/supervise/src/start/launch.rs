//! Input of a group's launch, and its result.

use controller::laws;
use messages::Service;
use runtime::Mode;
use scenario::Scenario;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

#[derive(Debug)]
pub struct Launch {
    pub mode: Mode,
    pub scenario: Scenario,
    /// Programs that take the place of built-in services.
    pub programs: BTreeMap<Service, PathBuf>,
    /// Time until all services must be ready.
    pub ready_timeout: Duration,
    /// Time between readiness and the common start instant.
    pub start_delay: Duration,
    /// File that describes to others how to join the group; present while it drives.
    pub live_file: Option<PathBuf>,
    /// File of the run's recording.
    pub recording: Option<PathBuf>,
}

/// The scenario as the services read it. It has the gap at which the law aims. So the referee can measure against it
/// without any law. The aim of a program in the controller's place is known only from the scenario.
pub(crate) fn for_services(scenario: &Scenario, is_replaced: bool) -> Scenario {
    let mut scenario = scenario.clone();
    if !is_replaced {
        scenario.referee.desired_gap = laws::desired_gap(&scenario);
    }
    scenario
}
