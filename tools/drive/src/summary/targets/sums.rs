//! Sums of judged scans by part of a curve.

use scenario::Scenario;
use serde::{Deserialize, Serialize};

use super::{JudgedScan, Place, REACH_M, judge, spans};
use crate::Drive;

/// Sums of the scans in one part of a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sums {
    pub time_s: f64,
    pub km: f64,
    /// Time with a lead within reach, s.
    pub lead_s: f64,
    /// Time of these in which it was lost, s.
    pub lost_s: f64,
    /// Number of times that it was lost.
    pub losses: u64,
    /// Time with a neighbour as the target, s.
    pub taken_s: f64,
    /// Number of times that a neighbour became the target.
    pub takings: u64,
    /// Time with a target that is not a vehicle, s.
    pub nothing_s: f64,
}

impl Sums {
    pub fn add(&mut self, other: &Self) {
        self.time_s += other.time_s;
        self.km += other.km;
        self.lead_s += other.lead_s;
        self.lost_s += other.lost_s;
        self.losses += other.losses;
        self.taken_s += other.taken_s;
        self.takings += other.takings;
        self.nothing_s += other.nothing_s;
    }
}

/// Sums of one part of a curve, with its name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaceSums {
    /// Part of a curve.
    pub place: Place,
    #[serde(flatten)]
    pub sums: Sums,
}

impl PlaceSums {
    /// The sums of a drive; none where the road has no plan.
    pub fn of(scenario: &Scenario, drive: &Drive) -> Option<Vec<Self>> {
        let axis = scenario.road.plan()?.axis();
        let scans = judge(drive, &|p_m| axis.curvature_perm(p_m));
        let all = Place::ALL.into_iter().zip(by_place(&scans));
        Some(all.map(|(place, sums)| Self { place, sums }).collect())
    }
}

/// Sums of the scans by part of a curve, in the order of [`Place::ALL`]. A loss counts in the part in which it begins.
pub fn by_place(scans: &[JudgedScan]) -> [Sums; 4] {
    Place::ALL.map(|place| {
        let mut sums = Sums::default();
        for pair in scans.windows(2).filter(|pair| pair[0].place == place) {
            let [scan, next] = [&pair[0], &pair[1]];
            let dt_s = next.time_s - scan.time_s;
            let while_true = |is: bool| if is { dt_s } else { 0.0 };
            sums.time_s += dt_s;
            sums.km += (next.position_m - scan.position_m) / 1e3;
            sums.lead_s += while_true(scan.lead_within(REACH_M).is_some());
            sums.lost_s += while_true(scan.is_lead_lost());
            sums.taken_s += while_true(scan.is_neighbour_taken());
            sums.nothing_s += while_true(scan.is_nothing_taken());
        }
        let begins_here = |finding: fn(&JudgedScan) -> bool| {
            let begins = spans(scans, finding).into_iter().filter(|(from_s, _)| {
                let scan = scans.iter().find(|scan| scan.time_s >= *from_s);
                scan.is_some_and(|scan| scan.place == place)
            });
            begins.count() as u64
        };
        sums.losses = begins_here(JudgedScan::is_lead_lost);
        sums.takings = begins_here(JudgedScan::is_neighbour_taken);
        sums
    })
}

#[cfg(test)]
mod tests {
    use super::super::{Lead, Owner};
    use super::*;

    fn scan(time_s: f64, place: Place, owner: Option<Owner>) -> JudgedScan {
        let lead = Some(Lead { vehicle: 0, gap_m: 60.0 });
        let is_beside = owner == Some(Owner::Vehicle(1));
        JudgedScan { time_s, position_m: 20.0 * time_s, place, lead, owner, is_beside }
    }

    #[test]
    fn a_loss_counts_where_it_begins_and_its_time_where_it_passes() {
        let (right, beside) = (Some(Owner::Vehicle(0)), Some(Owner::Vehicle(1)));
        let scans = [
            scan(0.0, Place::Straight, right),
            scan(1.0, Place::Entry, None),
            scan(2.0, Place::Arc, beside),
            scan(3.0, Place::Arc, right),
            scan(4.0, Place::Exit, right),
        ];
        let [straight, entry, arc, exit] = by_place(&scans);
        assert_eq!((straight.lost_s, straight.losses), (0.0, 0));
        assert_eq!((entry.lost_s, entry.losses), (1.0, 1));
        assert_eq!((arc.lost_s, arc.losses, arc.taken_s, arc.takings), (1.0, 0, 1.0, 1));
        assert_eq!((exit.time_s, arc.time_s, entry.km), (0.0, 2.0, 0.02));
    }
}
