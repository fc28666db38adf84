//! The services: one row each, with all that is known of a service before its code.
//!
//! ```
//! use messages::Service;
//!
//! let service: Service = "v2x-sim".parse()?;
//! assert_eq!(service, Service::V2xSim);
//! assert_eq!(service.descriptor().priority, 80);
//! # Ok::<(), messages::UnknownService>(())
//! ```

use crate::numbered;
use serde::{Deserialize, Serialize};

/// Key whose period a service has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// `plant.period_ms`: each simulation step.
    Plant,
    /// `perception.period_ms`.
    Radar,
    /// `v2x.period_ms`; `v2x.poll_ms` while frames come from another host.
    Signals,
    /// `controller.period_ms`.
    Control,
}

/// Condition for a service to be part of the group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// In every group.
    Always,
    EmergencyBrake,
    /// In groups whose signals come as frames.
    Frames,
}

/// Properties of a service that are known without its code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Descriptor {
    pub pace: Pace,
    pub presence: Presence,
    /// Usual priority under `SCHED_FIFO`.
    pub priority: u8,
    /// Place of its track in a trace, along the data's way.
    pub track: u8,
    /// True if it can have a standby.
    pub can_stand_by: bool,
}

/// Declares the services: see the rows. `$d` is a dollar sign, for the macro that this one declares.
macro_rules! services {
    ($d:tt $(#[doc = $doc:literal] $variant:ident = $number:literal $name:literal, $krate:ident:
       $descriptor:expr;)+) => {
        numbered! {
            /// A process of the group. Its name stands on the command line, in `ps` (behind `timegap-`) and in results.
            #[derive(PartialOrd, Ord, Serialize, Deserialize)]
            #[serde(rename_all = "kebab-case")]
            pub enum Service {
                $(#[doc = $doc] $variant = $number $name,)+
            }
        }

        impl Service {
            /// Its properties that are known without its code.
            pub const fn descriptor(self) -> &'static Descriptor {
                match self {
                    $(Self::$variant => &$descriptor,)+
                }
            }
        }

        /// Calls the macro `$callback` with `[Variant crate "doc comment"]` of all services.
        ///
        /// ```
        /// macro_rules! crates {
        ///     ($([$service:ident $krate:ident $about:literal])+) => { [$(stringify!($krate)),+] };
        /// }
        /// assert_eq!(messages::each_service!(crates)[0], "plant");
        /// ```
        #[macro_export]
        macro_rules! each_service {
            ($d callback:ident) => {
                $d callback! { $([$variant $krate $doc])+ }
            };
        }
    };
}

services! { $
    /// The ego vehicle, its actuator gateway and the referee.
    Plant = 1 "plant", plant: Descriptor {
        pace: Pace::Plant, presence: Presence::Always, priority: 82, track: 5,
        can_stand_by: false,
    };
    /// The other vehicles and the radar.
    PerceptionSim = 2 "perception-sim", perception_sim: Descriptor {
        pace: Pace::Radar, presence: Presence::Always, priority: 81, track: 0,
        can_stand_by: true,
    };
    /// The roadside unit.
    V2xSim = 3 "v2x-sim", v2x_sim: Descriptor {
        pace: Pace::Signals, presence: Presence::Always, priority: 80, track: 1,
        can_stand_by: true,
    };
    /// The control law and its loop.
    Controller = 4 "controller", controller: Descriptor {
        pace: Pace::Control, presence: Presence::Always, priority: 79, track: 3,
        can_stand_by: true,
    };
    /// The emergency brake.
    Aebs = 5 "aebs", aebs: Descriptor {
        pace: Pace::Radar, presence: Presence::EmergencyBrake, priority: 80, track: 4,
        can_stand_by: true,
    };
    /// The on-board unit: decodes and checks frames on air.
    Obu = 6 "obu", obu: Descriptor {
        pace: Pace::Signals, presence: Presence::Frames, priority: 80, track: 2,
        can_stand_by: false,
    };
}

impl Service {
    /// Position in [`Service::ALL`].
    pub const fn index(self) -> usize {
        self as usize - 1
    }

    /// Number in message headers.
    pub const fn to_wire(self) -> u32 {
        self as u32
    }
}

impl std::fmt::Display for Service {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// A text that names no service.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_count_from_one_and_files_have_the_names() {
        for (index, service) in Service::ALL.into_iter().enumerate() {
            assert_eq!(service.index(), index);
            assert_eq!(service.name().parse(), Ok(service));
            assert_eq!(serde_json::json!(service), service.name());
            assert_eq!(Service::by_number(service.to_wire()), Some(service));
        }
        let tracks: std::collections::BTreeSet<_> =
            Service::ALL.map(|service| service.descriptor().track).into();
        assert_eq!(tracks.len(), Service::ALL.len(), "each service has a track of its own");
    }

    #[test]
    fn crates_have_the_names_of_their_services() {
        macro_rules! crates {
            ($([$service:ident $krate:ident $about:literal])+) => {
                [$((Service::$service, stringify!($krate))),+]
            };
        }
        for (service, name) in each_service!(crates) {
            assert_eq!(service.name(), name.replace('_', "-"));
        }
    }
}
