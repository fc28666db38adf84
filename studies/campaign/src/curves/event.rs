//! Single events of a drive: a lost lead, a taken neighbour.

use report::targets::{JudgedScan, Owner, Place, spans};
use serde::{Deserialize, Serialize};

/// Kind of the event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// The lead was lost.
    Lost,
    /// A neighbour was taken.
    Taken,
}

/// An event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Kind of the event.
    pub kind: Kind,
    /// Run time at which it began, s.
    pub at_s: f64,
    /// Duration, s.
    pub lasts_s: f64,
    /// Part of the curve in which it began.
    pub place: Place,
    /// Gap to the lead then, m; none without a lead.
    pub gap_m: Option<f64>,
    /// There was a target at all when it began.
    pub has_target: bool,
}

impl Event {
    /// The events of a drive, in the order of time.
    pub fn all(scans: &[JudgedScan]) -> Vec<Self> {
        let of_kind = |kind, finding: fn(&JudgedScan) -> bool| {
            spans(scans, finding).into_iter().filter_map(move |(at_s, end_s)| {
                let scan = scans.iter().find(|scan| scan.time_s >= at_s)?;
                let gap_m = scan.lead.map(|lead| lead.gap_m);
                let has_target = scan.owner.is_some_and(|owner| owner != Owner::Nothing);
                Some(Self {
                    kind,
                    at_s,
                    lasts_s: end_s - at_s,
                    place: scan.place,
                    gap_m,
                    has_target,
                })
            })
        };
        let mut events: Vec<Self> = of_kind(Kind::Lost, JudgedScan::is_lead_lost)
            .chain(of_kind(Kind::Taken, JudgedScan::is_neighbour_taken))
            .collect();
        events.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        events
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use report::targets::Lead;

    #[test]
    fn an_event_has_its_begin_its_length_and_its_place() {
        let scan = |time_s: f64, owner: Option<usize>| JudgedScan {
            time_s,
            position_m: 0.0,
            place: if time_s < 1.5 { Place::Entry } else { Place::Arc },
            lead: Some(Lead { vehicle: 0, gap_m: 60.0 - time_s }),
            owner: owner.map(Owner::Vehicle),
            is_beside: owner == Some(1),
        };
        let scans = [
            scan(0.0, Some(0)),
            scan(1.0, None),
            scan(2.0, Some(1)),
            scan(3.0, Some(0)),
            scan(4.0, Some(0)),
        ];
        let lost = Event {
            kind: Kind::Lost,
            at_s: 1.0,
            lasts_s: 2.0,
            place: Place::Entry,
            gap_m: Some(59.0),
            has_target: false,
        };
        let taken = Event {
            kind: Kind::Taken,
            at_s: 2.0,
            lasts_s: 1.0,
            place: Place::Arc,
            gap_m: Some(58.0),
            has_target: true,
        };
        assert_eq!(Event::all(&scans), [lost, taken]);
    }
}
