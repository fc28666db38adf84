//! The tracker of an object list, on measurements written by hand.

use super::*;

/// The tracker of one vehicle whose measurements have deviations of 0.4 m, 0.15 m/s and 0.01 rad.
struct Objects {
    tracker: Tracker,
    time_ns: i64,
}

impl Objects {
    fn new() -> Self {
        let text = format!(
            "schema_version = 1\nname = \"by-hand\"\n[perception.radar]\nmodel = \"object-list\"\n\
             range_sigma_m = 0.4\nrange_rate_sigma_mps = 0.15\nazimuth_sigma_deg = {}\n\
             [[actors]]\nname = \"lead\"\ngap_m = 50\ninitial_speed_mps = 20\n",
            0.01_f64.to_degrees(),
        );
        let scenario = Scenario::parse("by-hand", &text).unwrap_or_else(|error| panic!("{error}"));
        let receiver = *ObjectListRadar::new(&scenario).receiver();
        Self { tracker: Tracker::new(&scenario, &receiver, &Numbers::DEFAULT), time_ns: 0 }
    }

    fn scan(&mut self, seen: Option<Detection>) -> TrackList {
        self.scan_all(&seen.map(|seen| (0, seen)).into_iter().collect::<Vec<_>>())
    }

    fn scan_all(&mut self, seen: &[(usize, Detection)]) -> TrackList {
        let ego = Ego { speed_mps: 20.0, ..Ego::default() };
        let (vehicles, detections): (Vec<_>, Vec<_>) = seen.iter().copied().unzip();
        let scan = Scan { detections: &detections, vehicles: &vehicles };
        let list = self.tracker.step(self.time_ns, &ego, None, None, scan);
        self.time_ns += PERIOD_NS;
        list
    }
}

fn at(x_m: f64, y_m: f64, range_rate_mps: f64) -> Detection {
    let (range_m, azimuth_rad) = (libm::hypot(x_m, y_m), libm::atan2(y_m, x_m));
    Detection { azimuth_rad, ..echo(range_m, range_rate_mps, 0.0) }
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} for {expected}");
}

#[test]
fn a_vehicle_is_a_track_at_once_and_in_the_path_after_a_tenth_of_a_second() {
    let mut watch = Objects::new();
    let list = watch.scan(Some(at(50.0, 1.0, -2.0)));
    let track = list.tracks()[0];
    assert!(!track.in_path && track.measured && track.id == 1);
    assert_near(track.gap_m, 50.0);
    assert_near(track.lateral_m, 1.0);
    assert_near(track.range_m, libm::hypot(50.0, 1.0));
    assert_eq!(track.range_rate_mps, -2.0);
    assert!(!watch.scan(Some(at(50.0, 1.0, 0.0))).tracks()[0].in_path);
    assert!(watch.scan(Some(at(50.0, 1.0, 0.0))).tracks()[0].in_path, "after 0.1 s");
}

#[test]
fn a_place_is_as_sure_as_the_radar_says() {
    let mut watch = Objects::new();
    watch.scan(Some(at(40.0, 3.0, 0.0)));
    let point = &watch.tracker.points[0];
    // The azimuth's deviation, over the line of sight and square to the road.
    let across_m = 0.01 * (40.0 * 40.0 + 3.0 * 3.0) / 40.0;
    assert_near(point.lateral_variance, across_m * across_m);
    assert_near(point.range_variance, 0.16);
    assert_near(point.range_rate_variance, 0.0225);
    // It is the middle of the rear: nothing of the rear is hidden.
    let track = &watch.tracker.tracks[0];
    assert_near(track.across.position_m(), 3.0);
    assert_near(track.across.position().variance, point.lateral_variance);
}

#[test]
fn an_unseen_vehicle_goes_on_for_half_a_second() {
    let mut watch = Objects::new();
    watch.scan(Some(at(50.0, 0.0, -2.0)));
    for scan in 1..=10 {
        let list = watch.scan(None);
        assert_eq!((list.count, list.tracks()[0].measured), (1, false), "{scan}");
        assert_near(list.tracks()[0].gap_m, 50.0 - 0.1 * f64::from(scan));
    }
    assert_eq!(watch.scan(None).count, 0);
    assert_eq!(watch.scan(Some(at(49.0, 0.0, -2.0))).tracks()[0].id, 2);
}

#[test]
fn the_share_is_what_came_of_the_measurements_of_known_vehicles_in_view() {
    let mut watch = Objects::new();
    let (mut seen, mut expected) = (4.0, 4.0);
    for scan in 0..20 {
        let is_there = scan % 3 != 2;
        watch.scan(is_there.then(|| at(50.0, 0.0, 0.0)));
        if scan > 0 {
            let fades = libm::exp(-0.05);
            (seen, expected) =
                (seen * fades + f64::from(u8::from(is_there)), expected * fades + 0.95);
        }
        assert_near(watch.tracker.sight.share(), f64::min(seen / expected, 1.0));
    }
    // One whose outer side is at the edge of the view is not expected, and no map promises posts.
    let mut aside = Objects::new();
    aside.scan(Some(at(20.0, 9.5, 0.0)));
    aside.scan(None);
    assert_eq!(aside.tracker.sight.share(), 1.0);
    for _ in 0..100 {
        aside.scan(None);
    }
    assert_eq!(aside.tracker.sight.share(), 1.0);
}

#[test]
fn a_range_that_contradicts_the_track_three_times_begins_its_motion_anew() {
    let mut watch = Objects::new();
    for _ in 0..20 {
        watch.scan(Some(at(50.0, 0.0, 0.0)));
    }
    for gap_m in [50.0, 50.0, 70.0] {
        let track = watch.scan(Some(at(70.0, 0.0, 0.0))).tracks()[0];
        assert_eq!(track.id, 1, "the radar knows the vehicle");
        assert!((track.gap_m - gap_m).abs() < 0.1, "{track:?}");
    }
    // One that agrees in between counts anew.
    let mut watch = Objects::new();
    for scan in 0..20 {
        let gap_m = if scan > 10 && scan % 3 != 0 { 70.0 } else { 50.0 };
        let track = watch.scan(Some(at(gap_m, 0.0, 0.0))).tracks()[0];
        assert!((track.gap_m - 50.0).abs() < 0.1, "{scan}");
    }
}

/// Two vehicles at one place, and two of which one could be the image of the other, with their order changed.
#[test]
fn vehicles_stay_apart_wherever_they_are() {
    let mut watch = Objects::new();
    let places = [(50.0, 0.0), (50.0, 0.3), (50.0, 14.0), (50.0, -20.0)];
    let mut seen: Vec<_> =
        places.map(|(x_m, y_m)| at(x_m, y_m, 0.0)).into_iter().enumerate().collect();
    for _ in 0..20 {
        seen.rotate_left(1);
        assert_eq!(watch.scan_all(&seen).count, 4);
    }
    for track in &watch.tracker.tracks {
        let vehicle = track.vehicle.expect("the radar knows it");
        assert!((track.across.position_m() - places[vehicle].1).abs() < 1e-6, "{vehicle}");
    }
}
