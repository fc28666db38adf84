//! `[supervision]`: restarts and standbys of services that die or hang, in realtime.
//!
//! In simulated time a restart could not repeat exactly: there the end of a service ends the run.

use serde::{Deserialize, Serialize};

use messages::Service;

use super::accepted::accepted;
use super::per_service::PerService;
use super::quantity::{Count, DelayMs, Duration};
use super::refusal::{Explained, read_from};
use super::schema::{Schema, Shape};

/// Restart policy and heartbeats.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(deny_unknown_fields, default)]
pub struct Supervision {
    /// Condition for a service to be started again.
    pub restart: Restart,
    /// Policies of single services, in place of `restart`.
    pub services: PerService<Option<Restart>>,
    /// Restarts of one service allowed in `window_s`; the next death leads to the safe state.
    pub budget: Count,
    /// Window of the budget, s.
    pub window_s: Duration,
    /// Wait before the second restart in a row, ms, doubled for each further one; the first restart
    /// does not wait. In a row are restarts within `window_s`.
    pub backoff_ms: DelayMs,
    /// Longest wait before a restart, ms.
    pub max_backoff_ms: DelayMs,
    /// Time without a sign of life, beyond its own period, after which a service is killed and replaced, ms.
    pub heartbeat_timeout_ms: DelayMs,
    /// Without a standby, the service's next process is started ahead. It has read the scenario and waits to open its
    /// ports. In realtime only.
    pub prepared: bool,
    /// Services with a standby. It is a second process that computes and sends nothing. It takes the service over when
    /// the active one ends or hangs. In realtime only.
    pub standby: Standbys,
    /// Time without a completed cycle, beyond its own period, after which a standby takes over, ms.
    pub standby_timeout_ms: DelayMs,
}

impl Default for Supervision {
    fn default() -> Self {
        Self {
            restart: Restart::OnFailure,
            services: PerService::default(),
            budget: Count::of(5),
            window_s: Duration::of(10.0),
            backoff_ms: DelayMs::of(10),
            max_backoff_ms: DelayMs::of(1000),
            heartbeat_timeout_ms: DelayMs::of(250),
            prepared: true,
            standby: Standbys::default(),
            standby_timeout_ms: DelayMs::of(50),
        }
    }
}

impl Supervision {
    /// Condition for `service` to be started again.
    #[must_use]
    pub fn restart_of(&self, service: Service) -> Restart {
        let own = *self.services.of(service);
        own.unwrap_or(self.restart)
    }
}

/// A service that can have a standby: its descriptor says so. The plant cannot have one, because there is one vehicle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(into = "Service")]
pub struct StandbyService(Service);

impl StandbyService {
    fn all() -> impl Iterator<Item = Service> {
        Service::ALL.into_iter().filter(|service| service.descriptor().can_stand_by)
    }
}

/// A service without a standby.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}, expected {}", self.message(), self.expected())]
pub struct NoStandby(Service);

impl Explained for NoStandby {
    fn message(&self) -> String {
        format!("`{}` has no standby", self.0)
    }

    fn expected(&self) -> String {
        accepted(self.0.name(), StandbyService::all().map(Service::name))
    }
}

impl TryFrom<Service> for StandbyService {
    type Error = NoStandby;

    fn try_from(service: Service) -> Result<Self, NoStandby> {
        let can = service.descriptor().can_stand_by;
        can.then_some(Self(service)).ok_or(NoStandby(service))
    }
}

impl From<StandbyService> for Service {
    fn from(standby: StandbyService) -> Self {
        standby.0
    }
}

impl Schema for StandbyService {
    fn shape() -> Shape {
        Shape::Text {
            words: StandbyService::all().map(|service| service.name().to_owned()).collect(),
        }
    }
}

read_from!(StandbyService, Service);

/// Services with a standby.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(from = "Vec<StandbyService>", into = "Vec<StandbyService>")]
pub struct Standbys([bool; Service::ALL.len()]);

impl Standbys {
    /// The services.
    #[must_use]
    pub fn services(self) -> Vec<Service> {
        Service::ALL.into_iter().filter(|service| self.contains(*service)).collect()
    }

    /// True if `service` has a standby.
    #[must_use]
    pub const fn contains(self, service: Service) -> bool {
        self.0[service.index()]
    }
}

impl From<Vec<StandbyService>> for Standbys {
    fn from(list: Vec<StandbyService>) -> Self {
        Self(Service::ALL.map(|service| list.contains(&StandbyService(service))))
    }
}

impl From<Standbys> for Vec<StandbyService> {
    fn from(standbys: Standbys) -> Self {
        standbys.services().into_iter().map(StandbyService).collect()
    }
}

/// Condition for a service to be started again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
#[serde(rename_all = "kebab-case")]
pub enum Restart {
    /// Never: its end ends the run.
    Never,
    /// After it died, hung or failed.
    OnFailure,
    /// Whenever it ends before the run does.
    Always,
}
