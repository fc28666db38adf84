//! Tests of the radar's checks.

use super::radar::Radar;
use super::{Check, Findings};
use bytemuck::Zeroable;
use messages::{Odometry, RadarTracks};

fn scan(k: i64, gap_m: f64, rate_mps: f64) -> RadarTracks {
    let mut radar = RadarTracks::zeroed();
    (radar.header.acquisition_ns, radar.header.sequence) = (k * 100_000_000, k.unsigned_abs());
    radar.target.valid = 1;
    (radar.target.track_id, radar.target.gap_m) = (7, gap_m);
    radar.target.relative_speed_mps = rate_mps;
    radar.count = 1;
    radar.tracks[0].in_path = 1;
    (radar.tracks[0].range_m, radar.tracks[0].range_rate_mps) = (gap_m, rate_mps);
    radar
}

fn ego(k: i64, speed_mps: f64) -> Odometry {
    let mut odometry = Odometry::zeroed();
    (odometry.header.acquisition_ns, odometry.speed_mps) = (k * 100_000_000, speed_mps);
    odometry
}

/// A check with its findings, of an ego of constant speed unless said otherwise.
struct Checked(Radar, Findings);

impl Checked {
    fn new(noisy: bool) -> Self {
        Self(Radar::new(noisy, 0.0), Findings::default())
    }

    fn believes_at(&mut self, scan: &RadarTracks, ego_mps: f64) -> bool {
        let odometry = ego(scan.header.acquisition_ns / 100_000_000, ego_mps);
        self.0.look(scan, Some(&odometry), 0.0, &mut self.1).is_some()
    }

    fn believes(&mut self, scan: &RadarTracks) -> bool {
        self.believes_at(scan, 20.0)
    }

    /// Cycles in which `check` found a contradiction.
    fn found(&self, check: Check) -> u64 {
        self.1.of(check).cycles
    }
}

#[test]
fn a_repeated_scan_is_frozen_where_there_is_noise() {
    let mut radar = Checked::new(true);
    let believed: Vec<bool> = (0..5).map(|k| radar.believes(&scan(k, 30.0, 0.0))).collect();
    assert_eq!(believed, [true, true, false, false, false]);
    assert!(radar.believes(&scan(5, 30.01, 0.0)));
    let none = Odometry::zeroed();
    let again = scan(6, 30.01, 0.0);
    assert!(radar.0.look(&again, Some(&none), 0.0, &mut radar.1).is_some());
    let again = scan(7, 30.01, 0.0);
    assert!(radar.0.look(&again, None, 0.0, &mut radar.1).is_none(), "noise needs no odometry");
}

#[test]
fn an_empty_scan_at_a_stand_may_repeat_itself() {
    for (ego_mps, frozen) in [(0.0, false), (0.01, true)] {
        let mut radar = Checked::new(true);
        let believed = (0..20).all(|k| {
            let mut scan = RadarTracks::zeroed();
            scan.header.acquisition_ns = k * 100_000_000;
            (scan.ego_speed_mps, scan.ego_speed_points) = (ego_mps, 6);
            radar.believes_at(&scan, 0.0)
        });
        assert_eq!(believed, !frozen);
    }
}

#[test]
fn exact_figures_may_repeat_until_the_egos_speed_changes() {
    for (slows_mps2, frozen) in [(0.0, false), (0.09, false), (0.2, true), (-0.2, true)] {
        let mut radar = Checked::new(false);
        let found = (0..12).find(|k| {
            !radar.believes_at(&scan(*k, 30.0, 0.0), 20.0 - 0.1 * slows_mps2 * *k as f64)
        });
        assert_eq!(found, frozen.then_some(10), "{slows_mps2}");
    }
    // Figures that change end the row.
    let mut radar = Checked::new(false);
    let mut believes =
        |k: i64| radar.believes_at(&scan(k, 30.0 + (k / 6) as f64, 0.0), 20.0 - k as f64);
    assert!((0..40).all(&mut believes));
}

#[test]
fn a_range_that_does_not_follow_its_rate_is_not_used() {
    let mut radar = Checked::new(false);
    let mut gap_m = 60.0;
    for k in 0..30 {
        assert!(radar.believes(&scan(k, gap_m, -4.0)));
        gap_m -= 0.4;
    }
    let found = (30..60).find(|k| !radar.believes(&scan(*k, gap_m, -8.0)));
    assert!(found.is_some_and(|k| k < 40), "{found:?}");
    // The same rate with another vehicle's number is another vehicle.
    let mut other = scan(60, gap_m, -8.0);
    other.target.track_id = 8;
    assert!(radar.believes(&other));
}

#[test]
fn a_measurement_that_jumps_and_comes_back_is_no_contradiction() {
    let mut radar = Checked::new(true);
    for k in 0..60 {
        let gap_m = 40.0 - 0.1 * k as f64;
        let mut scan = scan(k, gap_m, -1.0);
        // Every seventh scan shows the front axle of a lorry.
        scan.tracks[0].range_m += if k % 7 == 6 { 9.0 } else { 0.0 };
        assert!(radar.believes(&scan), "{k}");
    }
    assert_eq!(radar.found(Check::TargetAgainstTrack), 0);
    assert_eq!(radar.found(Check::RangeRateAgainstRange), 0);
}

#[test]
fn the_more_careful_figures_of_target_and_track_count_once_the_target_has_settled() {
    for (bias_m, bias_mps, expected) in [
        (5.0, 0.0, (0.0, -1.0)),
        (-5.0, 0.0, (-5.0, -1.0)),
        (1.0, 0.0, (1.0, -1.0)),
        (0.0, 3.0, (0.0, -1.0)),
        (0.0, -3.0, (0.0, -4.0)),
        (0.0, 2.0, (0.0, 1.0)),
    ] {
        let mut radar = Checked::new(true);
        for k in 0..9 {
            let range_m = 40.0 - 0.1 * k as f64;
            let mut scan = scan(k, range_m, -1.0);
            scan.target.gap_m += bias_m;
            scan.target.relative_speed_mps += bias_mps;
            let told = (scan.target.gap_m, scan.target.relative_speed_mps);
            let seen = radar.0.look(&scan, Some(&ego(k, 20.0)), 0.0, &mut radar.1);
            let target = seen.expect("it is believed").target;
            let found = (target.gap_m, target.relative_speed_mps);
            let settled = (range_m + expected.0, expected.1);
            let far = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).abs().max((a.1 - b.1).abs());
            let wanted = if k < 5 { told } else { settled };
            assert!(far(found, wanted) < 1e-9, "{bias_m} {bias_mps} {k}: {found:?}");
        }
    }
}
