//! Each check's value as a share of its threshold, computed by hand, and the place of the
//! threshold.

use super::motion::Motion;
use super::radar::Radar;
use super::{Check, Findings};
use bytemuck::Zeroable;
use messages::{Odometry, RadarTracks};

fn odometry(time_s: f64, position_m: f64, speed_mps: f64) -> Odometry {
    let mut odometry = Odometry::zeroed();
    odometry.header.acquisition_ns = (time_s * 1e9).round() as i64;
    (odometry.position_m, odometry.speed_mps) = (position_m, speed_mps);
    odometry
}

/// A scan whose target has a track of its own.
fn scan(time_s: f64, range_m: f64, rate_mps: f64) -> RadarTracks {
    let mut radar = RadarTracks::zeroed();
    radar.header.acquisition_ns = (time_s * 1e9).round() as i64;
    (radar.target.valid, radar.target.track_id) = (1, 7);
    (radar.target.gap_m, radar.target.relative_speed_mps) = (range_m, rate_mps);
    (radar.count, radar.tracks[0].in_path) = (1, 1);
    (radar.tracks[0].range_m, radar.tracks[0].range_rate_mps) = (range_m, rate_mps);
    radar
}

/// Largest share below the threshold, and cycles above it.
fn found(findings: &Findings, check: Check) -> (f64, u64) {
    let finding = findings.of(check);
    (finding.nearest, finding.cycles)
}

#[track_caller]
fn assert_share(findings: &Findings, check: Check, expected: f64) {
    let (nearest, cycles) = found(findings, check);
    assert!((nearest - expected).abs() < 1e-9, "{check:?}: {nearest}, expected {expected}");
    assert_eq!(cycles, 0, "{check:?}");
}

fn time_s(sample: &Odometry) -> f64 {
    sample.header.acquisition_ns as f64 / 1e9
}

/// Findings of samples, each with the command meanwhile.
fn of_motion(samples: &[(Odometry, f64)]) -> (Vec<bool>, Findings) {
    let (mut motion, mut findings) = (Motion::default(), Findings::default());
    let agrees = samples.iter().map(|(sample, commanded_mps2)| {
        motion.agrees(sample, None, *commanded_mps2, time_s(sample), &mut findings)
    });
    (agrees.collect(), findings)
}

#[test]
fn a_position_may_differ_from_the_speed_by_a_step_and_by_a_sum() {
    for (way, side) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        // 10 and 11 m/s for 0.2 s: 2.1 m, of which 0.04 + 0.021 + 0.08 m may be off.
        let first = [(odometry(0.0, 0.0, way * 10.0), 0.0)];
        let second = [(odometry(0.2, way * 2.1 + side * 0.05, way * 11.0), 0.0)];
        let (_, findings) = of_motion(&[first, second].concat());
        assert_share(&findings, Check::SpeedAgainstPosition, 0.05 / 0.141);
        // Another 0.2 m in a second, of which a step may be 2.15 m. The sum in 2 s is 0.25 + 0.22 m.
        let third = [(odometry(1.2, way * 13.1 + side * 0.25, way * 11.0), 0.0)];
        let (_, findings) = of_motion(&[first, second, third].concat());
        let sum_m = 0.05 * libm::exp(-0.5) + 0.2;
        assert_share(&findings, Check::SpeedAgainstPosition, sum_m / 0.47);
    }
}

#[test]
fn a_jump_of_any_size_is_forgotten_after_the_same_time() {
    for jump_m in [100.0, -100.0, 3.0] {
        let (mut motion, mut findings) = (Motion::default(), Findings::default());
        let agrees = (0..12).map(|k| {
            let now_s = 0.1 * f64::from(k);
            let jumped_m = if k > 0 { jump_m } else { 0.0 };
            let sample = odometry(now_s, 10.0 * now_s + jumped_m, 10.0);
            motion.agrees(&sample, None, 0.0, now_s, &mut findings)
        });
        // 1.5 times the bound decays to the bound in 2 s · ln 1.5 = 0.81 s.
        let expected: Vec<bool> = (0..12).map(|k| k == 0 || k > 9).collect();
        assert_eq!(agrees.collect::<Vec<_>>(), expected, "{jump_m} m");
    }
}

#[test]
fn a_vehicle_changes_its_speed_within_its_limits() {
    for change_mps in [1.0, -1.0] {
        let second = odometry(0.2, 2.0 + 0.1 * change_mps, 10.0 + change_mps);
        let (_, findings) = of_motion(&[(odometry(0.0, 0.0, 10.0), 0.0), (second, 0.0)]);
        assert_share(&findings, Check::VehicleLimits, 1.0 / (0.3 + 12.0 * 0.2));
    }
}

#[test]
fn an_ego_that_ignores_its_commands_for_a_while_is_not_used() {
    let still = |k: u32| odometry(0.1 * f64::from(k), 5.0, 0.0);
    for command_mps2 in [0.5, -0.5] {
        let commanded = |k: u32| (still(k), if k > 3 { command_mps2 } else { 0.0 });
        // The command changes after the sample of 0.3 s: 0.1 s less in a row than samples.
        let (agrees, findings) = of_motion(&(0..12).map(commanded).collect::<Vec<_>>());
        assert!(agrees.iter().all(|agrees| *agrees));
        assert_share(&findings, Check::SpeedAgainstCommand, 1.0);
        let (agrees, findings) = of_motion(&(0..14).map(commanded).collect::<Vec<_>>());
        assert_eq!(agrees.iter().filter(|agrees| !**agrees).count(), 2);
        assert_eq!(found(&findings, Check::SpeedAgainstCommand).1, 2);
    }
    // A smaller change of the command has no effect that must be seen.
    let gentle = |k: u32| (still(k), if k > 3 { 0.29 } else { 0.0 });
    assert_share(
        &of_motion(&(0..40).map(gentle).collect::<Vec<_>>()).1,
        Check::SpeedAgainstCommand,
        0.0,
    );
    // Each figure that changes shows that odometry lives.
    for figure in 0..4 {
        let alive = |k: u32| {
            let mut sample = still(k);
            let figures = [
                &mut sample.position_m,
                &mut sample.speed_mps,
                &mut sample.acceleration_mps2,
                &mut sample.request_mps2,
            ];
            *figures.into_iter().nth(figure).expect("one of four") += 1e-6 * f64::from(k);
            (sample, if k > 3 { 0.5 } else { 0.0 })
        };
        let findings = of_motion(&(0..40).map(alive).collect::<Vec<_>>()).1;
        assert_share(&findings, Check::SpeedAgainstCommand, 0.0);
    }
}

/// The ego at 20 m/s and 1 m/s², and scans `early_s` before it.
fn by_radar(scans: &[(f64, f64)]) -> (Vec<bool>, Findings) {
    let (mut motion, mut findings) = (Motion::default(), Findings::default());
    let agrees = scans.iter().enumerate().map(|(k, (early_s, measured_mps))| {
        let now_s = 0.1 * k as f64;
        let speed_mps = 20.0 + now_s;
        let mut sample = odometry(now_s, 20.0 * now_s + 0.5 * now_s * now_s, speed_mps);
        sample.acceleration_mps2 = 1.0;
        let mut radar = RadarTracks::zeroed();
        radar.header.acquisition_ns = ((now_s - early_s) * 1e9).round() as i64;
        (radar.ego_speed_mps, radar.ego_speed_points) = (*measured_mps, 5);
        motion.agrees(&sample, Some(&radar), 0.0, now_s, &mut findings)
    });
    (agrees.collect(), findings)
}

#[test]
fn a_speed_is_compared_with_the_radars_at_the_time_of_the_scan() {
    for early_s in [0.05, -0.05] {
        // The second sample has 20.1 m/s.
        let then_mps = 20.1 - early_s;
        for differs_mps in [0.5, -0.5] {
            let measured_mps = then_mps + differs_mps;
            let (_, findings) = by_radar(&[(early_s, 20.0 - early_s), (early_s, measured_mps)]);
            let bound_mps = 1.0 + 0.02 * measured_mps + 2.0 * 0.05;
            assert_share(&findings, Check::SpeedAgainstRadar, 0.5 / bound_mps);
        }
    }
}

#[test]
fn three_scans_in_a_row_must_contradict_a_speed() {
    let wrong = |k: u32| (0.05, if k > 0 { 10.0 } else { 20.0 });
    let (agrees, findings) = by_radar(&(0..5).map(wrong).collect::<Vec<_>>());
    assert_eq!(agrees, [true, true, true, false, false]);
    assert_eq!(found(&findings, Check::SpeedAgainstRadar), (1.0, 2));
    // One that agrees in between begins the row anew.
    let mixed =
        [wrong(0), wrong(1), wrong(2), (0.05, 20.25), wrong(4), wrong(5), wrong(6), wrong(7)];
    assert_eq!(by_radar(&mixed).0, [true, true, true, true, true, true, false, false]);
    // The same scan is counted once: its age grows with the samples.
    let old = [(0.0, 20.0), (0.0, 10.0), (0.1, 10.0), (0.2, 10.0), (0.3, 10.0), (0.4, 10.0)];
    assert_eq!(by_radar(&old).0, [true; 6]);
}

#[test]
fn without_a_scan_the_row_begins_anew_and_without_a_measurement_it_stays() {
    let (mut motion, mut findings) = (Motion::default(), Findings::default());
    let mut agrees = |k: u32, is_there: bool, points: u64| {
        let now_s = 0.1 * f64::from(k);
        let mut radar = RadarTracks::zeroed();
        radar.header.acquisition_ns = (now_s * 1e9).round() as i64;
        (radar.ego_speed_mps, radar.ego_speed_points) = (10.0, points);
        let sample = odometry(now_s, 20.0 * now_s, 20.0);
        motion.agrees(&sample, is_there.then_some(&radar), 0.0, now_s, &mut findings)
    };
    assert!((0..3).all(|k| agrees(k, true, 5)), "the first sample is compared with nothing");
    assert!(agrees(3, true, 0), "nothing was measured");
    assert!(!agrees(4, true, 5));
    assert!(agrees(5, false, 5));
    assert_eq!([6, 7, 8].map(|k| agrees(k, true, 5)), [true, true, false]);
}

#[test]
fn a_queue_explains_a_slower_measurement_within_its_bound() {
    // The ego drives 20 m/s, the radar measures 10: a tracked vehicle of 10 m/s explains it.
    let explains = |azimuth_rad: f64, rate_mps: f64, count: u64, measured_mps: f64| {
        let (mut motion, mut findings) = (Motion::default(), Findings::default());
        (0..8).all(|k| {
            let now_s = 0.1 * f64::from(k);
            let mut radar = RadarTracks::zeroed();
            radar.header.acquisition_ns = (now_s * 1e9).round() as i64;
            (radar.ego_speed_mps, radar.ego_speed_points) = (measured_mps, 5);
            (radar.count, radar.tracks[1].azimuth_rad) = (count, azimuth_rad);
            (radar.tracks[0].range_rate_mps, radar.tracks[1].range_rate_mps) = (5.0, rate_mps);
            let sample = odometry(now_s, 20.0 * now_s, 20.0);
            motion.agrees(&sample, Some(&radar), 0.0, now_s, &mut findings)
        })
    };
    assert!(explains(0.0, -9.41, 2, 10.0) && explains(0.0, -10.59, 2, 10.0));
    assert!(!explains(0.0, -9.39, 2, 10.0) && !explains(0.0, -10.61, 2, 10.0));
    assert!(!explains(0.0, -10.0, 1, 10.0), "the second track is not in the list");
    assert!(explains(0.0, -10.0, 8, 10.0) && explains(0.0, -10.0, u64::MAX, 10.0));
    assert!(explains(1.0, -10.0 * libm::cos(1.0), 2, 10.0) && !explains(1.0, -10.0, 2, 10.0));
    assert!(explains(1.4, -5.0, 2, 10.0), "far to the side the cosine counts as a half");
    assert!(!explains(0.0, -30.0, 2, 30.0), "a queue does not drive backwards");
}

#[test]
fn an_older_or_the_same_sample_changes_nothing() {
    let honest = [odometry(0.0, 0.0, 10.0), odometry(0.1, 1.0, 10.0)].map(|sample| (sample, 0.0));
    let wrong = (odometry(0.2, 50.0, 10.0), 0.0);
    let again = [wrong, (odometry(0.1, 1.0, 10.0), 0.0)];
    assert_eq!(
        of_motion(&[&honest[..], &[wrong], &again].concat()).0,
        [true, true, false, false, false]
    );
    let old = [(odometry(0.0, 77.0, 10.0), 0.0), (odometry(0.0, 77.0, 10.0), 0.0)];
    assert_eq!(of_motion(&[&honest[..], &old].concat()).0, [true; 4]);
}

/// Findings of scans of a radar with noise or without, each with the ego's odometry.
fn of_radar(is_noisy: bool, scans: &[(RadarTracks, Odometry)]) -> (Vec<bool>, Findings) {
    let (mut radar, mut findings) = (Radar::new(is_noisy, 0.0), Findings::default());
    let believed =
        scans.iter().map(|(scan, ego)| radar.look(scan, Some(ego), 0.0, &mut findings).is_some());
    (believed.collect(), findings)
}

#[test]
fn a_scan_that_repeats_itself_is_frozen_after_its_number() {
    let same = |count: u32| {
        (0..count).map(|k| (scan(0.1 * f64::from(k), 30.0, 0.0), odometry(0.0, 0.0, 20.0)))
    };
    let (believed, findings) = of_radar(true, &same(2).collect::<Vec<_>>());
    assert_eq!(believed, [true; 2]);
    assert_share(&findings, Check::RadarFrozen, 1.0 / 1.5);
    assert_eq!(of_radar(true, &same(4).collect::<Vec<_>>()).0, [true, true, false, false]);
}

#[test]
fn exact_figures_are_frozen_once_the_ego_has_changed_its_speed() {
    let of_change = |change_mps: f64, count: u32| {
        let scans = (0..count).map(|k| {
            let ego_mps = if k > 0 { 20.0 + change_mps } else { 20.0 };
            let now_s = 0.1 * f64::from(k);
            (scan(now_s, 30.0, 0.0), odometry(now_s, 0.0, ego_mps))
        });
        of_radar(false, &scans.collect::<Vec<_>>())
    };
    for change_mps in [0.11, -0.11] {
        let (believed, findings) = of_change(change_mps, 10);
        assert!(believed.iter().all(|believed| *believed));
        assert_share(&findings, Check::RadarFrozen, 9.0 / 9.5);
        assert_eq!(of_change(change_mps, 12).0[9..], [true, false, false]);
    }
    assert_share(&of_change(0.09, 40).1, Check::RadarFrozen, 0.0);
    // The ego's speed counts at the time of the scan: odometry is 0.5 s newer, and the ego accelerates.
    let accelerating = (0..40).map(|k| {
        let now_s = 0.1 * f64::from(k);
        let ahead_s = if k > 0 { 0.5 } else { 0.0 };
        let mut ego = odometry(now_s + ahead_s, 0.0, 20.0 + 2.0 * ahead_s);
        ego.acceleration_mps2 = 2.0;
        (scan(now_s, 30.0, 0.0), ego)
    });
    let findings = of_radar(false, &accelerating.collect::<Vec<_>>()).1;
    assert_share(&findings, Check::RadarFrozen, 0.0);
}

/// Scans of a steady lead at 50 m, the last of which are as given: time, range, rate.
fn after_a_steady_lead(scans: u32, then: &[(f64, f64, f64)]) -> (Vec<bool>, Findings) {
    let steady = (0..scans).map(|k| (0.1 * f64::from(k), 50.0, 0.0));
    let all = steady.chain(then.iter().copied());
    let ego = odometry(0.0, 0.0, 20.0);
    let scans = all.map(|(time_s, range_m, rate_mps)| (scan(time_s, range_m, rate_mps), ego));
    let (mut believed, findings) = of_radar(false, &scans.collect::<Vec<_>>());
    (believed.split_off(believed.len() - then.len()), findings)
}

#[test]
fn a_ranges_differences_from_its_rate_add_up_and_fade() {
    let check = Check::RangeRateAgainstRange;
    // -4 m/s for the half of 0.1 s: 0.2 m nearer; it is 0.8 m nearer.
    let first = (1.1, 49.2, -4.0);
    let bound = |range_m: f64| 3.0 + 0.03 * range_m;
    assert_share(&after_a_steady_lead(11, &[first]).1, check, 0.6 / bound(49.2));
    // 0.4 m nearer is expected, it is 1 m.
    let second = (1.2, 48.2, -4.0);
    let sum_m = 0.6 * libm::exp(-0.1) + 0.6;
    assert_share(&after_a_steady_lead(11, &[first, second]).1, check, sum_m / bound(48.2));
    // A jump counts with half of the bound, to either side.
    assert_share(&after_a_steady_lead(11, &[(1.1, 90.0, 0.0)]).1, check, 0.5);
    assert_share(&after_a_steady_lead(11, &[(1.1, 10.0, 0.0)]).1, check, 0.5);
    // No track has settled before its tenth difference, no pair of scans too far apart is compared.
    assert_share(&after_a_steady_lead(10, &[(1.0, 49.0, 0.0)]).1, check, 0.0);
    assert_share(&after_a_steady_lead(11, &[(2.01, 49.0, 0.0)]).1, check, 0.0);
    assert_share(&after_a_steady_lead(11, &[(2.0, 49.0, 0.0)]).1, check, 1.0 / bound(49.0));
    assert_share(&after_a_steady_lead(11, &[(1.0, 49.0, 0.0)]).1, check, 0.0);
}

#[test]
fn a_range_that_drifts_is_not_used_and_is_again_soon_after() {
    let drift = (1..40).map(|k| {
        let moved_m = 0.8 * f64::from(k.min(10));
        (1.0 + 0.1 * f64::from(k), 50.0 + moved_m, 0.0)
    });
    let (believed, _) = after_a_steady_lead(11, &drift.collect::<Vec<_>>());
    let first = believed.iter().position(|believed| !believed).expect("it is found");
    let last = believed.iter().rposition(|believed| !believed).expect("it is found");
    // 0.8 m a scan: the sum is past 4.7 m with the eighth. At most 1.5 times the bound is kept, and fades in 0.41 s.
    assert!((6..9).contains(&first) && (10..15).contains(&last), "{first} to {last}");
}

#[test]
fn a_target_is_compared_with_its_settled_track() {
    let check = Check::TargetAgainstTrack;
    let of_target = |scans: u32, off_m: f64, off_mps: f64| {
        let (mut radar, mut findings) = (Radar::new(false, 0.0), Findings::default());
        let mut last = None;
        for k in 0..scans {
            let mut scan = scan(0.1 * f64::from(k), 50.0, 0.0);
            scan.target.gap_m += off_m;
            scan.target.relative_speed_mps += off_mps;
            last = radar.look(&scan, None, 0.0, &mut findings).map(|scan| scan.target);
        }
        let target = last.expect("it is believed");
        (findings, target.gap_m, target.relative_speed_mps)
    };
    // 2.5 + 0.03 · 50 m, or 2.5 m/s.
    for side in [1.0, -1.0] {
        assert_share(&of_target(6, side * 1.0, 0.0).0, check, 0.25);
        assert_share(&of_target(6, 0.0, side * 1.0).0, check, 0.4);
        assert_share(&of_target(6, side * 1.0, side * 0.5).0, check, 0.25);
    }
    assert_share(&of_target(5, 10.0, 0.0).0, check, 0.0);
    // The nearer and the slower of the two count.
    let (findings, gap_m, mps) = of_target(6, 10.0, -1.0);
    assert_eq!((found(&findings, check).1, gap_m, mps), (1, 50.0, -1.0));
    let (findings, gap_m, mps) = of_target(6, -10.0, 1.0);
    assert_eq!((found(&findings, check).1, gap_m, mps), (1, 40.0, 0.0));
    let (findings, gap_m, mps) = of_target(6, 0.0, 3.0);
    assert_eq!((found(&findings, check).1, gap_m, mps), (1, 50.0, 0.0));
}

#[test]
fn a_target_whose_track_jumps_or_is_missing_is_left_as_it_is() {
    let target_of = |change: &dyn Fn(&mut RadarTracks)| {
        let (mut radar, mut findings) = (Radar::new(false, 0.0), Findings::default());
        let mut gap_m = 0.0;
        for k in 0..8 {
            let mut scan = scan(0.1 * f64::from(k), 50.0, 0.0);
            if k == 7 {
                change(&mut scan);
            }
            let believed = radar.look(&scan, None, 0.0, &mut findings).expect("it is believed");
            gap_m = believed.target.gap_m;
        }
        (gap_m, found(&findings, Check::TargetAgainstTrack).1)
    };
    // A jump of 4.1 m is farther than 2.5 + 0.03 · 45.9 m.
    assert_eq!(target_of(&|scan| scan.tracks[0].range_m = 45.9), (50.0, 0));
    assert_eq!(target_of(&|scan| scan.target.gap_m = 54.1), (50.0, 1));
    assert_eq!(target_of(&|scan| scan.target.gap_m = 53.9), (53.9, 0));
    // Without a track in the path, or with one behind the end of the list, there is nothing to compare.
    assert_eq!(
        target_of(&|scan| (scan.tracks[0].in_path, scan.target.gap_m) = (0, 53.0)),
        (53.0, 0)
    );
    assert_eq!(target_of(&|scan| (scan.count, scan.target.gap_m) = (0, 53.0)), (53.0, 0));
    // The second of two tracks is the one in the path.
    let second = |scan: &mut RadarTracks| {
        (scan.count, scan.tracks[1]) = (2, scan.tracks[0]);
        (scan.tracks[0].in_path, scan.tracks[0].range_m) = (0, 20.0);
        scan.target.gap_m = 60.0;
    };
    assert_eq!(target_of(&second), (50.0, 1));
}
