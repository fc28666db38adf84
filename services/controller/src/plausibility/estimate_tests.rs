//! The estimated motion of one step, computed by hand, and how long each source lasts.

use super::estimate::EgoEstimate;
use bytemuck::Zeroable;
use messages::{Odometry, RadarTracks};

/// Believed at 1 s: at 100 m with 20 m/s and 1 m/s².
fn believed() -> EgoEstimate {
    let mut odometry = Odometry::zeroed();
    odometry.header.acquisition_ns = 1_000_000_000;
    (odometry.position_m, odometry.speed_mps, odometry.acceleration_mps2) = (100.0, 20.0, 1.0);
    let mut estimate = EgoEstimate::default();
    estimate.believe(&odometry, 1.0);
    estimate
}

fn scan(time_s: f64, speed_mps: f64) -> RadarTracks {
    let mut scan = RadarTracks::zeroed();
    scan.header.acquisition_ns = (time_s * 1e9).round() as i64;
    (scan.ego_speed_mps, scan.ego_speed_points) = (speed_mps, 5);
    scan
}

#[track_caller]
fn assert_motion(found: Option<&Odometry>, expected: [f64; 3]) {
    let now = found.expect("it is estimated");
    let found = [now.position_m, now.speed_mps, now.acceleration_mps2];
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{now:?}, expected {expected}");
    }
}

#[test]
fn without_a_radar_it_follows_the_command_with_the_lag() {
    // After one time constant, 0.5 s, 63 % of the way from 1 to -2 m/s².
    let next_mps2 = 1.0 - 3.0 * (1.0 - libm::exp(-1.0));
    let next_mps = 20.0 + 0.5 * (1.0 + next_mps2) * 0.5;
    let next_m = 100.0 + 0.5 * (20.0 + next_mps) * 0.5;
    let mut estimate = believed();
    let now = estimate.advance(None, -2.0, 1.5);
    assert_eq!(now.expect("it is estimated").header.acquisition_ns, 1_500_000_000);
    assert_motion(now, [next_m, next_mps, next_mps2]);
    // It goes on from there.
    let later_mps2 = next_mps2 + (-2.0 - next_mps2) * (1.0 - libm::exp(-0.5));
    let later_mps = next_mps + 0.5 * (next_mps2 + later_mps2) * 0.25;
    let later_m = next_m + 0.5 * (next_mps + later_mps) * 0.25;
    assert_motion(estimate.advance(None, -2.0, 1.75), [later_m, later_mps, later_mps2]);
    // A step of more than a second counts as one, a step back as none.
    let long_mps2 = 1.0 - 3.0 * (1.0 - libm::exp(-2.0));
    let long_mps = 20.0 + 0.5 * (1.0 + long_mps2);
    let expected = [100.0 + 0.5 * (20.0 + long_mps), long_mps, long_mps2];
    assert_motion(believed().advance(None, -2.0, 2.25), expected);
    assert_motion(believed().advance(None, -2.0, 0.5), [100.0, 20.0, 1.0]);
}

#[test]
fn with_a_radar_the_speed_is_the_measured_one_moved_on() {
    let next_mps2 = 1.0 - 3.0 * (1.0 - libm::exp(-1.0));
    for age_s in [0.0, 0.2] {
        let next_mps = 15.0 + next_mps2 * age_s;
        let expected = [100.0 + 0.5 * (20.0 + next_mps) * 0.5, next_mps, next_mps2];
        assert_motion(believed().advance(Some(&scan(1.5 - age_s, 15.0)), -2.0, 1.5), expected);
    }
}

#[test]
fn it_does_not_reverse() {
    let mut estimate = believed();
    assert_motion(estimate.advance(Some(&scan(1.5, 0.0)), -9.0, 1.5), [105.0, 0.0, 0.0]);
    assert_motion(estimate.advance(None, -9.0, 1.6), [105.0, 0.0, 0.0]);
    assert_motion(estimate.advance(Some(&scan(1.7, -3.0)), -9.0, 1.7), [105.0, 0.0, 0.0]);
}

#[test]
fn commands_last_for_a_second_and_a_half_and_the_radar_for_ten() {
    let lasts = |period_s: f64, has_radar: bool, steps: u32| {
        let mut estimate = believed();
        (1..=steps).find(|k| {
            let time_s = 1.0 + period_s * f64::from(*k);
            let scan = scan(time_s, 20.0);
            estimate.advance(has_radar.then_some(&scan), 0.0, time_s).is_none()
        })
    };
    assert_eq!(lasts(0.25, false, 20), Some(7), "1.5 s are six steps");
    assert_eq!(lasts(0.25, true, 60), Some(41), "10 s are forty steps");
    // Odometry alone brings the lost speed back.
    let mut estimate = believed();
    assert!(estimate.advance(None, 0.0, 2.6).is_none());
    assert!(estimate.advance(Some(&scan(2.7, 20.0)), 0.0, 2.7).is_none());
}
