//! All faults of processes that a scenario can have.
//!
//! | fault | size | from, to |
//! | --- | --- | --- |
//! | `stop` of each service | - | for 0.1 s to the drive's length |
//! | `kill` of each service | - | - |
//! | `restart-storm` of each service | number of kills in a row | 2, 20 |
//!
//! The services come in the order of their weight for the drive. So a small budget tries the controller first.

use messages::Service;

use super::sort::Sort;

/// Kills of a storm: the largest number is beyond what a service that starts would show. Chosen.
const KILLS: (f64, f64) = (2.0, 20.0);

/// The faults, the controller's first.
pub(super) fn sorts() -> Vec<Sort> {
    let mut services = Service::ALL;
    services.sort_by_key(|service| *service != Service::Controller);
    let of = |service: Service, kind: &str, unit, size, is_instant| Sort {
        name: format!("{kind} {}", service.name()),
        unit,
        size,
        is_instant,
        keys: Some(vec![
            ("kind", format!("\"{kind}\"")),
            ("service", format!("\"{}\"", service.name())),
        ]),
    };
    let all = |service| {
        [
            of(service, "stop", "", None, false),
            of(service, "kill", "", None, true),
            of(service, "restart-storm", "kills", Some(("times", KILLS.0, KILLS.1)), true),
        ]
    };
    services.into_iter().flat_map(all).collect()
}
