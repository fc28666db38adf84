//! Reports of the on-board unit and the carrier.

use crate::GroupOutcome;
use crate::report::{Details, LinkReport, ObuReport};
use messages::Service;

/// The on-board unit's report; `None` without one.
pub(super) fn unit(group: &GroupOutcome) -> Option<ObuReport> {
    match &group.reports.get(&Service::Obu)?.details {
        Details::Obu(report) => Some((**report).clone()),
        _ => None,
    }
}

/// The carrier's report from v2x-sim; `None` without one.
pub(super) fn link(group: &GroupOutcome) -> Option<LinkReport> {
    match &group.reports.get(&Service::V2xSim)?.details {
        Details::Link(report) => Some((**report).clone()),
        _ => None,
    }
}
