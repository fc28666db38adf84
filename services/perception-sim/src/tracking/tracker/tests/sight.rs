//! The seen share of tracked vehicles, scan by scan.

use super::*;

/// A vehicle at a place of its own that is as fast as the ego, and the scans that show it.
type Vehicle = ((f64, f64), fn(u32) -> bool);

const ALWAYS: fn(u32) -> bool = |_| true;
const THREE_OF_FOUR: fn(u32) -> bool = |scan| scan % 4 != 3;

/// The tracker after vehicles that all scans show for 2 s, and then for 2 s the scans that they name. The share after
/// each scan is compared with its definition: the vehicles that count, with the numbers that are told.
fn drive(vehicles: &[Vehicle], counts: &[usize]) -> f64 {
    let mut watch = Watch::new();
    let (mut seen, mut expected) = (4.0, 4.0);
    let mut confirmed = false;
    for scan in 0..80 {
        let shows = |shown: fn(u32) -> bool| scan < 40 || shown(scan);
        let detections: Vec<Detection> = (vehicles.iter())
            .filter(|(_, shown)| shows(*shown))
            .map(|((x_m, y_m), _)| Detection {
                range_m: libm::hypot(*x_m, *y_m),
                snr_db: 40.0,
                ..aside(*x_m, 0.0, *y_m)
            })
            .collect();
        let list = watch.scan(&detections);
        let fades = if scan == 0 { 1.0 } else { libm::exp(-0.05) };
        (seen, expected) = (seen * fades, expected * fades);
        if confirmed {
            for &place in counts {
                expected += 0.95;
                seen += f64::from(u8::from(shows(vehicles[place].1)));
            }
        }
        confirmed = list.count == vehicles.len();
        assert!(confirmed || scan < 20, "scan {scan}: {} tracks", list.count);
        let (found, share) = (watch.tracker.sight.share(), f64::min(seen / expected, 1.0));
        assert!((found - share).abs() < 1e-9, "scan {scan}: {found} for {share}");
    }
    watch.tracker.sight.share()
}

#[test]
fn a_near_vehicle_that_three_of_four_scans_show_is_the_share() {
    let share = drive(&[((40.0, 0.0), THREE_OF_FOUR)], &[0]);
    assert!((0.7..0.85).contains(&share), "{share}");
    assert!(drive(&[((79.0, 0.0), THREE_OF_FOUR)], &[0]) < 0.85);
    assert!(drive(&[((40.0, -9.0), THREE_OF_FOUR)], &[0]) < 0.85);
}

#[test]
fn a_far_one_and_one_at_the_edge_of_the_view_are_not_expected() {
    assert_eq!(drive(&[((81.0, 0.0), THREE_OF_FOUR)], &[]), 1.0);
    // The outer side is within the view of ±30° less its margin of 0.05 rad: 0.4736 rad.
    let (x_m, inner_m, outer_m) = (20.0, 20.0 * libm::tan(0.41), 20.0 * libm::tan(0.44));
    assert!(drive(&[((x_m, inner_m), THREE_OF_FOUR)], &[0]) < 0.85);
    assert_eq!(drive(&[((x_m, outer_m), THREE_OF_FOUR)], &[]), 1.0);
}

#[test]
fn a_vehicle_that_a_nearer_one_hides_is_not_expected() {
    let (nearer, hidden) = (((30.0, 0.0), ALWAYS), ((60.0, 2.4), THREE_OF_FOUR));
    assert_eq!(drive(&[nearer, hidden], &[0]), 1.0);
    // The nearer one is expected itself, and does not hide what is 2.5 m beside it.
    let beside = ((60.0, 2.6), THREE_OF_FOUR);
    assert!(drive(&[nearer, beside], &[0, 1]) < 0.95);
    assert!(drive(&[((30.0, 0.0), THREE_OF_FOUR), ((60.0, 2.4), ALWAYS)], &[0]) < 0.85);
}

#[test]
fn two_that_may_have_merged_hide_each_other() {
    assert_eq!(drive(&[((30.0, 0.0), THREE_OF_FOUR), ((34.4, 2.4), ALWAYS)], &[]), 1.0);
    assert!(drive(&[((30.0, 0.0), THREE_OF_FOUR), ((34.6, 2.4), ALWAYS)], &[0]) < 0.85);
}

/// The map promises 50 posts a kilometre, of which none is seen: a vehicle may hide them.
#[test]
fn a_radar_that_shows_a_vehicle_is_not_blind_and_one_that_loses_it_is() {
    let mut watch = Watch::after_a_lead();
    assert!(watch.tracker.sight.share() > 0.99);
    for _ in 0..9 {
        watch.scan(&[]);
    }
    assert!(watch.tracker.sight.share() > 0.3, "0.45 s without a detection");
    watch.scan(&[]);
    watch.scan(&[]);
    assert_eq!(watch.tracker.sight.share(), 0.0, "0.55 s without one");
    watch.scan(&[lead(0)]);
    assert!(watch.tracker.sight.share() > 0.3, "it is back");
}
