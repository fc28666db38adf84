//! Vehicles beside the lane: what crawls turns slowly.

use aebs::filter::Lateral;

/// Probability of a lateral speed above 0.3 m/s, one scan after a vehicle surely kept its lane.
fn turns(speed_mps: f64) -> f64 {
    let mut lateral = Lateral::still(3.5);
    lateral.predict(0.05, speed_mps);
    let fast = lateral.states().iter().filter(|h| h.rate_mps.abs() > 0.3);
    fast.map(|h| h.probability).sum()
}

#[test]
fn a_crawling_object_does_not_turn_at_once() {
    assert!(turns(1.7) < 1e-6, "{}", turns(1.7));
    assert!(turns(10.0) > 1e-3, "{}", turns(10.0));
}
