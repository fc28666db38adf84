//! The tracker on detections written by hand.

use super::*;
use crate::radar::detections::DetectionRadar;
use crate::radar::object_list::ObjectListRadar;
use messages::Detection;

mod objects;
mod sight;

const PERIOD_NS: i64 = 50_000_000;
const EGO_MPS: f64 = 10.0;

/// A tracker and the time of its next scan.
struct Watch {
    tracker: Tracker,
    time_ns: i64,
}

impl Watch {
    fn new() -> Self {
        let text = "schema_version = 1\nname = \"by-hand\"\nduration_s = 10\n";
        let scenario = Scenario::parse("by-hand", text).unwrap_or_else(|error| panic!("{error}"));
        let receiver = *DetectionRadar::new(&scenario).receiver();
        Self { tracker: Tracker::new(&scenario, &receiver, &Numbers::DEFAULT), time_ns: 0 }
    }

    fn scan(&mut self, detections: &[Detection]) -> TrackList {
        let ego = Ego { speed_mps: EGO_MPS, ..Ego::default() };
        self.time_ns += PERIOD_NS;
        self.tracker.step(self.time_ns, &ego, None, None, Scan::of_echoes(detections))
    }

    /// A lead at 21.6 m for 3 s.
    fn after_a_lead() -> Self {
        let mut watch = Self::new();
        for scan in 0..60 {
            let list = watch.scan(&[lead(scan)]);
            assert!(list.count == usize::from(list.target.is_some()));
        }
        watch
    }
}

fn echo(range_m: f64, range_rate_mps: f64, snr_db: f64) -> Detection {
    let (azimuth_rad, rcs_dbsm) = (0.0, 10.0);
    Detection {
        range_m,
        range_rate_mps,
        azimuth_rad,
        snr_db,
        rcs_dbsm,
        flags: 0,
        ambiguity_group: 0,
    }
}

/// The same aside.
fn aside(range_m: f64, range_rate_mps: f64, y_m: f64) -> Detection {
    Detection { azimuth_rad: libm::atan(y_m / range_m), ..echo(range_m, range_rate_mps, 20.0) }
}

/// The strong echo of a lead at 21.6 m, with repeatable errors.
fn lead(scan: u32) -> Detection {
    let error_m = 0.04 * (f64::from(scan % 5) - 2.0);
    echo(21.6 + error_m, 0.0, 50.0)
}

#[test]
fn one_weak_echo_before_a_lead_is_not_its_rear() {
    let mut watch = Watch::after_a_lead();
    for scan in 60..90 {
        let false_alarm = echo(19.98, 1.04, 12.3);
        let seen = [false_alarm, lead(scan)];
        let list = watch.scan(if scan == 60 { &seen } else { &seen[1..] });
        let target = list.target().expect("a lead");
        let where_m = target.gap_m;
        assert!((21.4..21.8).contains(&where_m), "scan {scan}: {where_m} m");
        assert!(target.acceleration_mps2.abs() < 1.0, "scan {scan}: {target:?}");
        assert_eq!(list.count, 1, "scan {scan}");
    }
}

#[test]
fn a_rear_that_comes_into_view_is_one_after_some_scans() {
    let mut watch = Watch::after_a_lead();
    let id = |list: &TrackList| list.target().map(|target| target.id);
    let first = watch.scan(&[lead(60)]);
    let mut list = first;
    for scan in 61..68 {
        list = watch.scan(&[echo(19.98, 0.0, 45.0), lead(scan)]);
    }
    assert_eq!((list.count, id(&list)), (1, id(&first)));
    let gap_m = list.target().expect("a lead").gap_m;
    assert!((gap_m - 19.98).abs() < 0.3, "{gap_m} m");
}

/// Its range rate jumps by more than any braking explains: the first track was wrong about its speed.
#[test]
fn a_track_found_in_the_place_of_an_unseen_one_is_the_same_vehicle() {
    let mut watch = Watch::after_a_lead();
    let first = watch.scan(&[lead(60)]);
    let mut range_m = 21.6;
    let mut list = first;
    for _ in 0..6 {
        range_m -= 6.0 * 0.05;
        list = watch.scan(&[echo(range_m, -6.0, 50.0)]);
    }
    let (before, after) = (first.target().expect("a lead"), list.target().expect("a lead"));
    assert_eq!((list.count, after.id), (1, before.id));
    assert!((after.relative_speed_mps + 6.0).abs() < 0.5, "{after:?}");
}

/// Noise that moves, and then a post near its place that stands.
#[test]
fn a_post_is_no_vehicle_although_noise_near_it_moved() {
    let mut watch = Watch::new();
    for scan in 0..40 {
        let range_m = 60.0 - 0.05 * EGO_MPS * f64::from(scan);
        let rate_mps = if scan == 0 { -8.7 } else { -EGO_MPS };
        let list = watch.scan(&[aside(range_m, rate_mps, -8.0)]);
        assert_eq!(list.count, 0, "scan {scan}: {:?}", list.tracks()[0]);
    }
}
