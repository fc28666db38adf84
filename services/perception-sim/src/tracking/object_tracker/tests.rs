//! The tracker on measurements written by hand.

use super::*;

/// A tracker of one vehicle whose measurements have deviations of 0.4 m, 0.15 m/s and 0.01 rad, and a scan's time.
struct Watch {
    tracker: ObjectTracker,
    time_ns: i64,
}

impl Watch {
    fn new() -> Self {
        let text = "schema_version = 1\nname = \"by-hand\"\n[[actors]]\nname = \"lead\"\n\
                    gap_m = 50\ninitial_speed_mps = 20\n";
        let scenario = Scenario::parse("by-hand", text).unwrap_or_else(|error| panic!("{error}"));
        let sigmas = (0.4, 0.15, 0.01);
        let mut tracker = ObjectTracker::new(&scenario);
        (tracker.range_sigma_m, tracker.range_rate_sigma_mps, tracker.azimuth_sigma_rad) = sigmas;
        Self { tracker, time_ns: 0 }
    }

    fn scan(&mut self, seen: Option<Measurement>) -> TrackList {
        let ego = Ego { speed_mps: 20.0, ..Ego::default() };
        let list = self.tracker.step(self.time_ns, &ego, None, None, &[seen]);
        self.time_ns += 50_000_000;
        list
    }
}

fn at(x_m: f64, y_m: f64, range_rate_mps: f64) -> Option<Measurement> {
    let (range_m, azimuth_rad) = (libm::hypot(x_m, y_m), libm::atan2(y_m, x_m));
    Some(Measurement { range_m, range_rate_mps, azimuth_rad })
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
}

#[test]
fn a_vehicle_of_the_first_scan_counts_at_once_and_a_later_one_is_confirmed() {
    let mut watch = Watch::new();
    let list = watch.scan(at(50.0, 1.0, -2.0));
    let track = list.tracks()[0];
    assert!(track.in_path && track.measured && track.id == 1);
    assert_near(track.gap_m, 50.0);
    assert_near(track.lateral_m, 1.0);
    assert_eq!((track.relative_speed_mps, track.range_rate_mps), (-2.0, -2.0));
    assert_near(track.range_m, libm::hypot(50.0, 1.0));
    let mut later = Watch::new();
    later.scan(None);
    assert!(!later.scan(at(50.0, 1.0, 0.0)).tracks()[0].in_path);
    assert!(!later.scan(at(50.0, 1.0, 0.0)).tracks()[0].in_path);
    assert!(later.scan(at(50.0, 1.0, 0.0)).tracks()[0].in_path, "after 0.1 s");
}

#[test]
fn the_lateral_position_is_as_sure_as_the_azimuth_at_its_distance() {
    let watch = Watch::new();
    let seen = at(40.0, 3.0, 0.0).expect("a measurement");
    let lateral = watch.tracker.lateral(&seen);
    assert_near(lateral.value, 3.0);
    assert_near(lateral.variance, 0.4 * 0.4);
    assert_near(watch.tracker.range(&seen).value, 40.0);
    assert_near(watch.tracker.range(&seen).variance, 0.16);
    assert_near(watch.tracker.range_rate(&seen, 20.0).variance, 0.0225);
}

#[test]
fn an_unseen_vehicle_goes_on_for_half_a_second() {
    let mut watch = Watch::new();
    watch.scan(at(50.0, 0.0, -2.0));
    for scan in 1..=10 {
        let list = watch.scan(None);
        assert_eq!((list.count, list.tracks()[0].measured), (1, false), "{scan}");
        assert_near(list.tracks()[0].gap_m, 50.0 - 0.1 * f64::from(scan));
    }
    assert_eq!(watch.scan(None).count, 0);
    assert_eq!(watch.scan(at(49.0, 0.0, -2.0)).tracks()[0].id, 2);
}

#[test]
fn the_share_is_what_came_of_the_measurements_of_known_vehicles_in_view() {
    let mut watch = Watch::new();
    let (mut seen, mut expected) = (4.0, 4.0);
    for scan in 0..20 {
        let is_there = scan % 3 != 2;
        watch.scan(if is_there { at(50.0, 0.0, 0.0) } else { None });
        if scan > 0 {
            let fades = libm::exp(-0.05);
            (seen, expected) =
                (seen * fades + f64::from(u8::from(is_there)), expected * fades + 1.0);
        }
        assert_near(watch.tracker.seen_share(), seen / expected);
    }
    // At the edge of the view nothing is expected.
    let mut aside = Watch::new();
    aside.scan(at(20.0, 9.3, 0.0));
    aside.scan(None);
    assert_eq!(aside.tracker.seen_share(), 1.0);
}

#[test]
fn a_range_that_contradicts_the_track_three_times_begins_it_anew() {
    let mut watch = Watch::new();
    for _ in 0..20 {
        watch.scan(at(50.0, 0.0, 0.0));
    }
    for id in [1, 1, 2] {
        let track = watch.scan(at(70.0, 0.0, 0.0)).tracks()[0];
        assert_eq!(track.id, id);
        let gap_m = if id == 1 { 50.0 } else { 70.0 };
        assert!((track.gap_m - gap_m).abs() < 0.1, "{track:?}");
    }
    // One that agrees in between counts anew.
    let mut watch = Watch::new();
    for scan in 0..20 {
        let gap_m = if scan > 10 && scan % 3 != 0 { 70.0 } else { 50.0 };
        assert_eq!(watch.scan(at(gap_m, 0.0, 0.0)).tracks()[0].id, 1, "{scan}");
    }
}

/// A vehicle 40 m along a left curve of 100 m and 2 m inside of it, at 20 m/s as the ego.
#[test]
fn a_range_rate_on_a_curve_is_that_of_the_motion_along_it() {
    let course = Course::bent(0.0, |_| 0.01);
    let (sine, cosine) = libm::sincos(0.4);
    let (x_m, y_m) = (98.0 * sine, 100.0 - 98.0 * cosine);
    let azimuth = libm::atan2(y_m, x_m);
    let vehicle_mps = 18.0;
    let rate_mps = vehicle_mps * libm::cos(azimuth - 0.4) - 20.0 * libm::cos(azimuth);
    let seen = at(x_m, y_m, rate_mps).expect("a measurement");
    // 0.98 m inside make a metre along the course.
    let along_mps = along_course(&course, &seen, 20.0);
    assert!((along_mps - (vehicle_mps / 0.98 - 20.0)).abs() < 1e-5, "{along_mps}");
}
