//! What on-board unit and carrier brought back.

use group::GroupOutcome;
use messages::Service;
use runtime::report::{Details, LinkReport, ObuReport};

/// What the on-board unit brought back; none where there is none.
pub(super) fn unit(group: &GroupOutcome) -> Option<ObuReport> {
    match &group.reports.get(&Service::Obu)?.details {
        Details::Obu(report) => Some((**report).clone()),
        _ => None,
    }
}

/// What v2x-sim brought back of its carrier; none where there is none.
pub(super) fn link(group: &GroupOutcome) -> Option<LinkReport> {
    match &group.reports.get(&Service::V2xSim)?.details {
        Details::Link(report) => Some((**report).clone()),
        _ => None,
    }
}
