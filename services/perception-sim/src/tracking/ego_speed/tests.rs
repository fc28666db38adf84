//! Votes, measurements, and the choice between them and odometry.

use super::*;
use bytemuck::Zeroable;

/// Detections of posts at 8 m beside the road and of `others` vehicles two lanes over, at `other_mps`.
fn scan(ego_mps: f64, others: usize, other_mps: f64) -> Vec<Detection> {
    let detection = |x_m: f64, y_m: f64, speed_mps: f64, noise: f64| {
        let azimuth_rad = libm::atan2(y_m, x_m);
        Detection {
            range_m: libm::sqrt(x_m * x_m + y_m * y_m),
            range_rate_mps: (speed_mps - ego_mps) * libm::cos(azimuth_rad) + noise,
            azimuth_rad,
            ..Detection::zeroed()
        }
    };
    let posts = (0..6).map(|k| {
        let side = if k % 2 == 0 { 8.0 } else { -9.0 };
        detection(25.0 + 15.0 * f64::from(k), side, 0.0, 0.1 * f64::from(k - 3))
    });
    posts
        .chain((0..others).map(|k| detection(30.0 + 0.5 * k as f64, 7.0, other_mps, 0.0)))
        .collect()
}

fn told(speed_mps: f64) -> Option<Ego> {
    Some(Ego { speed_mps, ..Ego::default() })
}

#[test]
fn it_follows_braking_and_a_pack_of_vehicles_does_not_pull_it_away() {
    let mut speed = EgoSpeed::new(&Numbers::DEFAULT);
    let mut ego_mps: f64 = 25.0;
    for k in 0..60 {
        let chosen = speed.take_scan(
            &Course::STRAIGHT,
            k * 50_000_000,
            told(ego_mps),
            &scan(ego_mps, 12, 20.0),
        );
        let (measured, points) = speed.measured.expect("six posts");
        assert!((measured - ego_mps).abs() < 0.5 && points >= 3, "{measured} for {ego_mps}");
        assert_eq!(chosen.speed_mps, ego_mps, "odometry agrees");
        ego_mps = (ego_mps - 9.0 * 0.05).max(0.0);
    }
}

#[test]
fn odometry_that_is_off_or_missing_gives_way_to_the_measurement() {
    let mut speed = EgoSpeed::new(&Numbers::DEFAULT);
    speed.take_scan(&Course::STRAIGHT, 0, told(20.0), &scan(20.0, 0, 0.0));
    speed.take_scan(&Course::STRAIGHT, 50_000_000, told(24.0), &scan(20.0, 0, 0.0));
    let chosen = speed.take_scan(&Course::STRAIGHT, 100_000_000, told(24.0), &scan(20.0, 0, 0.0));
    assert!((chosen.speed_mps - 20.0).abs() < 0.3, "{chosen:?}");
    let chosen = speed.take_scan(&Course::STRAIGHT, 150_000_000, None, &scan(20.0, 0, 0.0));
    assert!((chosen.speed_mps - 20.0).abs() < 0.3, "{chosen:?}");
    let chosen = speed.take_scan(&Course::STRAIGHT, 200_000_000, told(20.0), &scan(20.0, 0, 0.0));
    assert_eq!(chosen.speed_mps, 20.0, "it agrees again");
}

/// Points of a queue in the next lane whose azimuth is off, nearer to the last estimate than any post.
#[test]
fn a_queue_that_crawls_in_the_next_lane_does_not_stand() {
    let mut speed = EgoSpeed::new(&Numbers::DEFAULT);
    let ego_mps = 15.0;
    for k in 0..40 {
        let mut detections = scan(ego_mps, 0, 0.0);
        detections.extend((0..20).map(|place| {
            let (x_m, noise_rad) = (30.0 + 4.0 * f64::from(place), f64::from(k % 3) * 0.005);
            let azimuth_rad = libm::atan2(4.4, x_m) + noise_rad;
            Detection {
                range_m: libm::hypot(x_m, 4.4),
                range_rate_mps: (1.0 - ego_mps) * libm::cos(azimuth_rad),
                azimuth_rad,
                ..Detection::zeroed()
            }
        }));
        speed.take_scan(&Course::STRAIGHT, i64::from(k) * 50_000_000, told(ego_mps), &detections);
        let (measured, _) = speed.measured.expect("six posts");
        assert!((measured - ego_mps).abs() < 0.4, "{measured}");
    }
}

/// Two vehicles beside the lane, at 30 and 50 m, that go with `other_mps`.
fn traffic(ego_mps: f64, other_mps: f64) -> Vec<Detection> {
    let at = |x_m: f64| {
        let azimuth_rad = libm::atan2(7.0, x_m);
        let range_rate_mps = (other_mps - ego_mps) * libm::cos(azimuth_rad);
        let range_m = libm::hypot(x_m, 7.0);
        Detection { range_m, azimuth_rad, range_rate_mps, ..Detection::zeroed() }
    };
    (0..12).map(|k| at(if k < 6 { 30.0 } else { 50.0 } + 0.5 * f64::from(k % 6))).collect()
}

#[test]
fn vehicles_at_two_places_do_not_contradict_odometry() {
    let mut speed = EgoSpeed::new(&Numbers::DEFAULT);
    for k in 0..60 {
        let posts = if k < 10 { scan(9.0, 0, 0.0) } else { Vec::new() };
        let seen = [posts, traffic(9.0, 8.0)].concat();
        assert_eq!(
            speed.take_scan(&Course::STRAIGHT, k * 50_000_000, told(9.0), &seen).speed_mps,
            9.0
        );
        assert_eq!(speed.measured.is_some(), k < 10, "scan {k}");
    }
    let mut along = scan(9.0, 0, 0.0);
    along.iter_mut().for_each(|post| post.range_rate_mps = 0.1);
    assert_eq!(speed.take_scan(&Course::STRAIGHT, 3_000_000_000, told(9.0), &along).speed_mps, 9.0);
    assert_eq!(speed.measured, None);
    let chosen = (61..65).map(|k| {
        speed.take_scan(&Course::STRAIGHT, k * 50_000_000, told(9.0), &scan(14.0, 0, 0.0)).speed_mps
    });
    assert!((chosen.last().expect("four scans") - 14.0).abs() < 0.3);
}

#[test]
fn nothing_beside_the_road_is_no_measurement() {
    let mut speed = EgoSpeed::new(&Numbers::DEFAULT);
    assert_eq!(speed.take_scan(&Course::STRAIGHT, 0, told(20.0), &[]).speed_mps, 20.0);
    assert_eq!(speed.measured, None);
    assert_eq!(speed.take_scan(&Course::STRAIGHT, 50_000_000, told(26.0), &[]).speed_mps, 26.0);
}

#[test]
fn a_median_is_of_the_votes_within_reach_and_the_densest_window_has_most() {
    let voted = |speeds_mps: &[f64]| -> Vec<Vote> {
        speeds_mps.iter().map(|&speed_mps| Vote { speed_mps, range_m: 40.0 }).collect()
    };
    let found = |near: &[Vote]| median_mps(near).map(|mps| (mps, near.len()));
    let votes = voted(&[1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(found(near(&votes, 3.0, 1.0)), Some((3.0, 3)), "both ends count");
    assert_eq!(found(near(&votes, 3.0, 0.9)), Some((3.0, 1)));
    assert_eq!(found(near(&votes, 2.5, 0.5)), Some((3.0, 2)), "the upper one of two");
    assert_eq!(found(near(&votes, 8.0, 2.9)), None);
    let votes = voted(&[1.0, 5.0, 5.1, 5.3, 9.0, 9.1]);
    assert_eq!(found(densest(&votes, 0.5)), Some((5.1, 3)));
    assert_eq!(found(densest(&[], 0.5)), None);
}

#[test]
fn a_place_ends_where_a_vehicle_would() {
    let count = |ranges_m: &[f64]| {
        let vote = |&range_m: &f64| Vote { speed_mps: 0.0, range_m };
        let votes: Vec<Vote> = ranges_m.iter().map(vote).collect();
        places(&votes, &mut Vec::new(), &Numbers::DEFAULT)
    };
    assert_eq!(count(&[30.0, 20.0, 26.0, 20.5]), 2, "20 to 26 m is one vehicle");
    assert_eq!(count(&[20.0, 26.1, 32.2, 38.3]), 4);
    assert_eq!(count(&[]), 0);
}

/// A detection at a place of the body's axes that stands, for an ego with 20 m/s.
fn stands(x_m: f64, y_m: f64) -> Detection {
    let (range_m, azimuth_rad) = (libm::hypot(x_m, y_m), libm::atan2(y_m, x_m));
    let range_rate_mps = -20.0 * libm::cos(azimuth_rad);
    Detection { range_m, azimuth_rad, range_rate_mps, ..Detection::zeroed() }
}

#[test]
fn an_echo_off_the_lane_and_ahead_votes() {
    let votes = |detection: Detection| {
        let mut speed = EgoSpeed::new(&Numbers::DEFAULT);
        speed.vote(&Course::STRAIGHT, None, &[detection]);
        speed.votes
    };
    let vote = votes(stands(40.0, 8.0));
    assert!(vote.len() == 1 && (vote[0].speed_mps - 20.0).abs() < 1e-12, "{vote:?}");
    // 4.5 m and 0.015 rad: 5.25 m at a range of 50 m.
    let at = |off_m: f64| stands(libm::sqrt(2500.0 - off_m * off_m), off_m);
    for (off_m, count) in [(5.24, 0), (5.26, 1), (-5.24, 0), (-5.26, 1)] {
        assert_eq!(votes(at(off_m)).len(), count, "{off_m}");
    }
    // Up to 60° from the axis.
    assert_eq!(votes(stands(10.0, 17.2)).len(), 1);
    assert_eq!(votes(stands(10.0, 17.4)).len(), 0);
    let ambiguous = Detection { ambiguity_group: 1, ..stands(40.0, 8.0) };
    assert!(votes(ambiguous).is_empty());
    // On a left curve of 100 m radius what is straight ahead is beside the road.
    let mut speed = EgoSpeed::new(&Numbers::DEFAULT);
    speed.vote(&Course::bent(0.0, |_| 0.01), None, &[stands(40.0, 0.0)]);
    assert_eq!(speed.votes.len(), 1);
}

/// Detections that vote for these speeds.
fn votes(speeds_mps: &[f64]) -> Vec<Detection> {
    let vote = |(place, mps): (usize, &f64)| {
        let there = stands(40.0 + 7.0 * place as f64, 8.0);
        Detection { range_rate_mps: there.range_rate_mps * mps / 20.0, ..there }
    };
    speeds_mps.iter().enumerate().map(vote).collect()
}

/// Measurement `after_ns` after one of 20 m/s.
fn measured_after(after_ns: i64, speeds_mps: &[f64]) -> Option<f64> {
    let mut speed = EgoSpeed { last: Some((20.0, 0)), ..EgoSpeed::new(&Numbers::DEFAULT) };
    speed.take_scan(&Course::STRAIGHT, after_ns, None, &votes(speeds_mps));
    speed.measured.map(|(mps, points)| {
        assert!(points >= 3);
        (mps * 1e6).round() / 1e6
    })
}

#[test]
fn three_votes_within_reach_are_a_measurement() {
    // After 50 ms the reach is 0.6 and 0.6 m/s.
    let scan_ns = 50_000_000;
    assert_eq!(measured_after(scan_ns, &[21.19; 3]), Some(21.19));
    assert_eq!(measured_after(scan_ns, &[18.81; 3]), Some(18.81));
    assert_eq!(measured_after(scan_ns, &[21.21; 3]), None);
    assert_eq!(measured_after(scan_ns, &[21.19; 2]), None);
    assert_eq!(measured_after(scan_ns, &[19.5, 19.9, 20.4, 25.0, 25.0]), Some(19.9));
    // The reach grows with the time: no vehicle accelerates harder than 12 m/s².
    assert_eq!(measured_after(1_000_000_000, &[32.5; 3]), Some(32.5));
    assert_eq!(measured_after(1_000_000_000, &[32.7; 9]), None);
    assert_eq!(measured_after(2_000_000_000, &[44.5; 3]), Some(44.5));
    assert_eq!(measured_after(scan_ns, &[-0.5; 3]), None, "out of reach");
    let mut slow = EgoSpeed { last: Some((0.0, 0)), ..EgoSpeed::new(&Numbers::DEFAULT) };
    slow.take_scan(&Course::STRAIGHT, scan_ns, None, &votes(&[-0.5; 3]));
    assert_eq!(slow.measured, Some((0.0, 3)), "no vehicle drives backwards");
}

#[test]
fn odometry_gives_way_after_two_scans_of_more_than_a_metre_a_second() {
    let mut speed = EgoSpeed { last: Some((20.0, 0)), ..EgoSpeed::new(&Numbers::DEFAULT) };
    let mut chosen = |scan: i64, told_mps: f64, speeds_mps: &[f64]| {
        speed
            .take_scan(&Course::STRAIGHT, scan * 50_000_000, told(told_mps), &votes(speeds_mps))
            .speed_mps
    };
    assert_eq!(chosen(1, 20.9, &[20.0; 4]), 20.9);
    assert_eq!(chosen(2, 20.9, &[20.0; 4]), 20.9);
    assert_eq!(chosen(3, 21.1, &[20.0; 4]), 21.1, "the first one");
    assert_eq!(chosen(4, 18.9, &[]), 18.9, "no measurement");
    assert!((chosen(5, 18.9, &[20.0; 4]) - 20.0).abs() < 1e-12, "the second one");
    assert_eq!(chosen(6, 19.1, &[20.0; 4]), 19.1, "it agrees again");
    assert_eq!(chosen(7, 18.9, &[20.0; 4]), 18.9, "the first one again");
}
