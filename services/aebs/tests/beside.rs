//! Vehicles beside the lane: what crawls turns slowly, and two abreast are not one between them.

use aebs::filter::Lateral;
use aebs::object::Object;
use aebs::objects::Objects;
use messages::Detection;

const PERIOD_NS: i64 = 50_000_000;
const EGO_MPS: f64 = 30.0;

/// Probability of a lateral speed above 0.3 m/s, one scan after a vehicle surely kept its lane.
fn turns(speed_mps: f64) -> f64 {
    let mut lateral = Lateral::known(3.5, 0.0);
    lateral.predict(0.05, speed_mps);
    let fast = lateral.hypotheses().filter(|h| h.rate_mps.abs() > 0.3);
    fast.map(|h| h.probability).sum()
}

#[test]
fn a_crawling_object_does_not_turn_at_once() {
    assert!(turns(1.7) < 1e-6, "{}", turns(1.7));
    assert!(turns(10.0) > 1e-3, "{}", turns(10.0));
}

/// The object that is left of echoes at these places across the lanes, 110 m ahead with 5 m/s.
fn seen_at(places_m: &[f64]) -> Object {
    let mut objects = Objects::new(0.5).resolving(3f64.to_radians());
    let mut range_m = 110.0;
    for (scan, place_m) in places_m.iter().enumerate() {
        let echo = Detection {
            range_m,
            range_rate_mps: 5.0 - EGO_MPS,
            azimuth_rad: libm::atan(place_m / range_m),
            snr_db: 22.0,
            rcs_dbsm: 10.0,
            flags: 0,
            ambiguity_group: 0,
        };
        objects.take_scan(None, (scan as i64 + 1) * PERIOD_NS, EGO_MPS, &[echo]);
        range_m -= 0.05 * (EGO_MPS - 5.0);
    }
    *objects.confirmed().next().expect("an object")
}

#[test]
fn two_abreast_are_not_surely_one_between_them() {
    let one = seen_at(&[0.2, -0.3, 0.1, 0.3, -0.1, 0.0]);
    assert!(one.probability > 0.8, "{}", one.probability);
    let two = seen_at(&[-1.2, 0.6, -1.7, 0.1, -1.0, 0.9, -1.5, 0.4]);
    assert!(two.probability < 0.5, "{}", two.probability);
}
