//! The services by name.

use serde::{Deserialize, Serialize};

/// A process of the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Service {
    /// The ego vehicle, its actuator gateway and the referee.
    Plant = 1,
    /// The other vehicles and the radar.
    PerceptionSim = 2,
    /// The roadside unit.
    V2xSim = 3,
    /// The control law and its loop.
    Controller = 4,
    /// The emergency brake.
    Aebs = 5,
    /// The on-board unit: decodes and checks what is on air.
    Obu = 6,
}

impl Service {
    /// All services, in the order of their numbers.
    pub const ALL: [Self; 6] =
        [Self::Plant, Self::PerceptionSim, Self::V2xSim, Self::Controller, Self::Aebs, Self::Obu];

    /// The services of a group with or without the emergency brake and the on-board unit.
    #[must_use]
    pub const fn of_group(aebs: bool, obu: bool) -> &'static [Self] {
        const CORE: [Service; 4] =
            [Service::Plant, Service::PerceptionSim, Service::V2xSim, Service::Controller];
        const WITH_AEBS: [Service; 5] = [CORE[0], CORE[1], CORE[2], CORE[3], Service::Aebs];
        const WITH_OBU: [Service; 5] = [CORE[0], CORE[1], CORE[2], CORE[3], Service::Obu];
        match (aebs, obu) {
            (false, false) => &CORE,
            (true, false) => &WITH_AEBS,
            (false, true) => &WITH_OBU,
            (true, true) => &Self::ALL,
        }
    }

    /// Name on the command line, in `ps` (behind `timegap-`) and in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plant => "plant",
            Self::PerceptionSim => "perception-sim",
            Self::V2xSim => "v2x-sim",
            Self::Controller => "controller",
            Self::Aebs => "aebs",
            Self::Obu => "obu",
        }
    }

    /// Position in [`Service::ALL`].
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize - 1
    }

    /// Number in message headers.
    #[must_use]
    pub const fn to_wire(self) -> u32 {
        self as u32
    }
}

impl std::fmt::Display for Service {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// A name of no service.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown service `{0}`, expected one of {names}",
    names = Service::ALL.map(Service::name).join(", ")
)]
pub struct UnknownService(String);

impl std::str::FromStr for Service {
    type Err = UnknownService;

    fn from_str(name: &str) -> Result<Self, UnknownService> {
        let found = Self::ALL.into_iter().find(|service| service.name() == name);
        found.ok_or_else(|| UnknownService(name.to_owned()))
    }
}
