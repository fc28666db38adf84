//! `[supervision]`: what becomes of services that die or hang, in realtime.
//!
//! In simulated time a restart could not repeat exactly: there the end of a service ends the run.

use serde::{Deserialize, Serialize};

use messages::Service;

use super::quantity::{Count, DelayMs, Duration};

/// Restart policy and heartbeats.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Supervision {
    /// When a service is started again.
    pub restart: Restart,
    /// What holds for one service instead.
    pub services: Services,
    /// Restarts of one service allowed in `window_s`; the next death leads to the safe state.
    pub budget: Count,
    /// Window of the budget, s.
    pub window_s: Duration,
    /// Wait before the second restart in a row, ms, doubled for each further one; the first restart
    /// does not wait. In a row are restarts within `window_s`.
    pub backoff_ms: DelayMs,
    /// Longest wait before a restart, ms.
    pub max_backoff_ms: DelayMs,
    /// A service that has not given a sign of life for so long, beside its own period, hangs: it is
    /// killed and replaced, ms.
    pub heartbeat_timeout_ms: DelayMs,
    /// For each service without a standby the next process is started ahead: it has read the scenario and waits
    /// to open its ports. In realtime only.
    pub prepared: bool,
    /// Services with a standby: a second process that computes, sends nothing, and takes the service over
    /// when the active one ends or hangs. In realtime only.
    pub standby: Standbys,
    /// A standby takes over from an active process that has completed no cycle for so long, beside its own
    /// period, ms.
    pub standby_timeout_ms: DelayMs,
}

impl Default for Supervision {
    fn default() -> Self {
        Self {
            restart: Restart::OnFailure,
            services: Services::default(),
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
    /// When `service` is started again.
    #[must_use]
    pub fn restart_of(&self, service: Service) -> Restart {
        let own = match service {
            Service::Plant => self.services.plant,
            Service::PerceptionSim => self.services.perception_sim,
            Service::V2xSim => self.services.v2x_sim,
            Service::Controller => self.services.controller,
            Service::Aebs => self.services.aebs,
            Service::Obu => self.services.obu,
        };
        own.unwrap_or(self.restart)
    }
}

/// A service that can have a standby. The plant cannot: the vehicle is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StandbyService {
    /// Traffic and radar.
    PerceptionSim,
    /// The roadside unit.
    V2xSim,
    /// The control loop.
    Controller,
    /// The emergency brake.
    Aebs,
}

impl StandbyService {
    const ALL: [Self; 4] = [Self::PerceptionSim, Self::V2xSim, Self::Controller, Self::Aebs];

    /// The service.
    #[must_use]
    pub const fn service(self) -> Service {
        match self {
            Self::PerceptionSim => Service::PerceptionSim,
            Self::V2xSim => Service::V2xSim,
            Self::Controller => Service::Controller,
            Self::Aebs => Service::Aebs,
        }
    }
}

/// Services with a standby.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(from = "Vec<StandbyService>", into = "Vec<StandbyService>")]
pub struct Standbys([bool; StandbyService::ALL.len()]);

impl Standbys {
    /// The services.
    #[must_use]
    pub fn services(self) -> Vec<Service> {
        Vec::from(self).into_iter().map(StandbyService::service).collect()
    }

    /// True if `service` has a standby.
    #[must_use]
    pub fn contains(self, service: Service) -> bool {
        StandbyService::ALL.iter().zip(self.0).any(|(of, has)| has && of.service() == service)
    }
}

impl From<Vec<StandbyService>> for Standbys {
    fn from(list: Vec<StandbyService>) -> Self {
        Self(StandbyService::ALL.map(|service| list.contains(&service)))
    }
}

impl From<Standbys> for Vec<StandbyService> {
    fn from(standbys: Standbys) -> Self {
        let all = StandbyService::ALL.into_iter().zip(standbys.0);
        all.filter(|(_, has)| *has).map(|(service, _)| service).collect()
    }
}

/// Restart policies of single services.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, rename_all = "kebab-case")]
pub struct Services {
    /// The ego vehicle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plant: Option<Restart>,
    /// Traffic and radar.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub perception_sim: Option<Restart>,
    /// The roadside unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub v2x_sim: Option<Restart>,
    /// The control loop.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub controller: Option<Restart>,
    /// The emergency brake.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aebs: Option<Restart>,
    /// The on-board unit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub obu: Option<Restart>,
}

/// When a service is started again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Restart {
    /// Never: its end ends the run.
    Never,
    /// When it died, hung or failed.
    OnFailure,
    /// Whenever it ends before the run does.
    Always,
}
