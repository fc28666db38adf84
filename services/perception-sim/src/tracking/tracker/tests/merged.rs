//! Tracks that the receiver may not resolve.

use super::*;
use crate::tracking::abreast::Abreast;
use crate::tracking::association::tests::point;

/// A track that one echo begins.
fn track(tracker: &Tracker, id: u32, gap_m: f64, lateral_m: f64) -> DetectedTrack {
    moving(tracker, id, (gap_m, lateral_m), 0.0)
}

fn moving(
    tracker: &Tracker,
    id: u32,
    (gap_m, lateral_m): (f64, f64),
    relative_mps: f64,
) -> DetectedTrack {
    let points = [point(gap_m, lateral_m, relative_mps)];
    let sighting = Sighting::of(points.iter(), 0.0, &Numbers::DEFAULT).expect("a point");
    let mut track = DetectedTrack::begin(&tracker.model, &sighting, true);
    track.id = id;
    track
}

/// A track in the middle whose echoes wander between 3.4 m on the right and 3.5 m on the left.
fn wandering(tracker: &Tracker) -> DetectedTrack {
    let mut abreast = Abreast::default();
    for scan in 0..24 {
        let at = |value: f64| Measured::new(value, 0.3);
        let place_m = if scan % 2 == 0 { 3.5 } else { -3.4 };
        abreast.observe(at(place_m), at(0.0), 6.3, &Numbers::DEFAULT);
    }
    let mut track = track(tracker, 1, 120.0, 0.0);
    track.abreast = abreast;
    track
}

/// The nearest body that the wandering track may stand for beside other tracks.
fn nearest_m(others: &[(u32, f64, f64)]) -> Option<f64> {
    let mut tracker = Watch::new().tracker;
    let middle = wandering(&tracker);
    tracker.tracks.push(middle);
    for &(id, gap_m, lateral_m) in others {
        let other = track(&tracker, id, gap_m, lateral_m);
        tracker.tracks.push(other);
    }
    tracker.nearest_of_several_m(&middle)
}

#[test]
fn the_nearest_of_several_is_the_one_without_a_track_of_its_own() {
    let (left, right) = ((2, 120.0, 3.0), (3, 120.0, -3.0));
    assert_eq!(nearest_m(&[]), Some(-3.4));
    assert_eq!(nearest_m(&[right]), Some(3.5));
    assert_eq!(nearest_m(&[left]), Some(-3.4));
    assert_eq!(nearest_m(&[left, right]), None);
    // A track that is not confirmed, the track itself, one elsewhere and one at its very place do not count.
    for other in [(0, 120.0, -3.0), (1, 120.0, -3.0), (3, 150.0, -3.0), (3, 120.0, 0.0)] {
        assert_eq!(nearest_m(&[other]), Some(-3.4), "{other:?}");
    }
}

/// The variance of a new track's gap is 0.1² of its echo and 0.1² of the rear, that of its speed 0.1² and 0.02².
#[test]
fn tracks_are_merged_within_the_resolution_and_three_deviations() {
    let tracker = Watch::new().tracker;
    let receiver = &tracker.radar.receiver;
    let along_m = receiver.range.resolution + 3.0 * f64::sqrt(4.0 * 0.01);
    let rate_mps = receiver.range_rate.resolution + 3.0 * f64::sqrt(2.0 * 0.0104);
    let across_m = 120.0 * receiver.azimuth.resolution + 1.8;
    let middle = track(&tracker, 1, 120.0, 0.0);
    let is_merged = |along_m: f64, rate_mps: f64, across_m: f64| {
        let other = moving(&tracker, 2, (120.0 + along_m, across_m), rate_mps);
        tracker.is_merged(&middle, &other)
    };
    for share in [0.99, -0.99] {
        assert!(is_merged(share * along_m, 0.0, 0.0), "{share}");
        assert!(is_merged(0.0, share * rate_mps, 0.0), "{share}");
        assert!(is_merged(0.0, 0.0, share * across_m), "{share}");
    }
    for share in [1.01, -1.01] {
        assert!(!is_merged(share * along_m, 0.0, 0.0), "{share}");
        assert!(!is_merged(0.0, share * rate_mps, 0.0), "{share}");
        assert!(!is_merged(0.0, 0.0, share * across_m), "{share}");
    }
}

/// An unseen track takes the echo of a seen one in its cell as evidence of two bodies, or of one.
#[test]
fn an_unseen_track_shares_the_echo_of_its_cell() {
    let mut tracker = Watch::new().tracker;
    let (seen, unseen) = (track(&tracker, 1, 120.0, 2.0), track(&tracker, 2, 120.0, -2.0));
    let elsewhere = track(&tracker, 3, 150.0, -2.0);
    tracker.tracks.extend([seen, unseen, elsewhere]);
    let mut sightings = [None; MAX_KEPT];
    sightings[0] = Some(Measured::new(1.0, 0.3));
    tracker.share(&sightings);
    let mut expected = Abreast::default();
    let cell_m = 120.0 * tracker.view.resolution_rad;
    let predicted = unseen.across.position();
    expected.observe(Measured::new(1.0, 0.3), predicted, cell_m, &Numbers::DEFAULT);
    assert_ne!(expected, Abreast::default());
    let found: Vec<Abreast> = tracker.tracks.iter().map(|track| track.abreast).collect();
    assert_eq!(found, [Abreast::default(), expected, Abreast::default()]);
}
