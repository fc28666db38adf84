//! Single steps of the plant's models against their equations.

use bytemuck::Zeroable;
use messages::{VehiclePose, VehicleTruthItem};
use plant::contact::{Rectangle, closing_at_contact};
use plant::gateway::{Actuation, Source};
use plant::lateral::{SingleTrack, Slip};
use plant::truck::Truck;
use scenario::Scenario;
use scenario::lateral::Lateral as Keys;

const MASS_KG: f64 = 1600.0;

/// Derivatives of lateral speed and yaw rate, as the page of the single track has them.
fn derivatives(keys: &Keys, [lateral, yaw]: [f64; 2], steering_rad: f64, speed: f64) -> [f64; 2] {
    let wheelbase = keys.wheelbase_m.value();
    let a = keys.cg_share.value() * wheelbase;
    let b = wheelbase - a;
    let (slip, understeer) = (keys.slip_rad_per_mps2.value(), keys.understeer_rad_per_mps2.value());
    // At 1 m/s² each axle carries its share, with its slip angle.
    let (front, rear) = (b / wheelbase / (slip + understeer), a / wheelbase / slip);
    let front_mps2 = front * (steering_rad - (lateral + a * yaw) / speed);
    let rear_mps2 = -rear * (lateral - b * yaw) / speed;
    let k2 = keys.yaw_inertia_kgm2.value() / MASS_KG;
    [front_mps2 + rear_mps2 - speed * yaw, (a * front_mps2 - b * rear_mps2) / k2]
}

/// A step of the classical Runge-Kutta method.
fn runge_kutta(keys: &Keys, state: [f64; 2], steering_rad: f64, speed: f64, h: f64) -> [f64; 2] {
    let moved = |by: [f64; 2], h: f64| [state[0] + h * by[0], state[1] + h * by[1]];
    let at = |state: [f64; 2]| derivatives(keys, state, steering_rad, speed);
    let first = at(state);
    let second = at(moved(first, 0.5 * h));
    let third = at(moved(second, 0.5 * h));
    let fourth = at(moved(third, h));
    let mean = [0, 1].map(|i| (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]) / 6.0);
    moved(mean, h)
}

#[test]
fn the_single_track_solves_its_equations() {
    let keys = Keys::default();
    let track = SingleTrack::new(&keys, MASS_KG);
    for speed_mps in [12.0, 35.0] {
        let mut slip = Slip { lateral_mps: 0.3, yaw_radps: -0.1 };
        let mut exact = [slip.lateral_mps, slip.yaw_radps];
        for step in 0..400 {
            let steering_rad = 0.02 * libm::sin(0.02 * f64::from(step));
            slip = track.step(slip, steering_rad, 9.0, speed_mps, 1e-3);
            exact = runge_kutta(&keys, exact, steering_rad, speed_mps, 1e-3);
            let off = (slip.lateral_mps - exact[0]).abs() + (slip.yaw_radps - exact[1]).abs();
            assert!(off < 2e-5, "{speed_mps} m/s, step {step}: {slip:?} {exact:?}");
        }
    }
}

#[test]
fn a_steady_state_rests_and_its_steering_angle_is_that_of_the_circle() {
    let keys = Keys::default();
    let track = SingleTrack::new(&keys, MASS_KG);
    for speed_mps in [8.0, 30.0] {
        let steering_rad = track.steering_rad(1.0 / 400.0, speed_mps);
        let slip = track.steady(steering_rad, speed_mps);
        assert!((slip.yaw_radps - speed_mps / 400.0).abs() < 1e-12);
        let [lateral, yaw] =
            derivatives(&keys, [slip.lateral_mps, slip.yaw_radps], steering_rad, speed_mps);
        assert!(lateral.abs() < 1e-9 && yaw.abs() < 1e-9, "{lateral} {yaw}");
    }
    assert_eq!(track.front_m, keys.cg_share.value() * keys.wheelbase_m.value());
}

/// Closing speed of an ego at 15 m/s on a body at its own place, sampled a second ago.
fn closing(speed_mps: f64, acceleration_mps2: f64, heading_rad: f64, within_m: f64) -> Option<f64> {
    let pose = VehiclePose { x_m: 0.5, y_m: 0.0, heading_rad, length_m: 20.0, width_m: 20.0 };
    let truth = VehicleTruthItem { speed_mps, acceleration_mps2, ..VehicleTruthItem::zeroed() };
    let ego = Rectangle::of(&VehiclePose { x_m: 0.0, heading_rad: 0.0, length_m: 4.5, ..pose });
    closing_at_contact(&ego, 15.0, 1.0, [(&truth, &pose)].into_iter(), within_m)
}

#[test]
fn a_body_closes_with_the_speed_that_it_has_by_now() {
    let near = |found: Option<f64>, expected: f64| {
        assert!(found.is_some_and(|found| (found - expected).abs() < 1e-9), "{found:?} {expected}");
    };
    near(closing(2.0, 1.0, 0.0, 30.0), 12.0);
    near(closing(2.0, -1.0, 0.0, 30.0), 14.0);
    // After half a second it stands, half a metre farther.
    near(closing(2.0, -4.0, 0.0, 30.0), 15.0);
    near(closing(2.0, -4.0, 0.0, 1.01), 15.0);
    assert_eq!(closing(2.0, -4.0, 0.0, 0.99), None, "its middle is 1 m away");
    // 2.5 m farther with the acceleration.
    near(closing(2.0, 1.0, 0.0, 3.01), 12.0);
    assert_eq!(closing(2.0, 1.0, 0.0, 2.99), None);
    // Half of a motion at 60° counts.
    near(closing(2.0, 0.0, std::f64::consts::FRAC_PI_3, 30.0), 14.0);
}

#[test]
fn a_truck_goes_on_from_what_another_process_kept() {
    let text = "schema_version = 1\nname = \"hills\"\nplant.vehicle = \"jh6-49t\"\n\
        plant.initial_speed_mps = 20\nroad.points = [[0, 100], [400, 108], [800, 100]]\n";
    let scenario = Scenario::parse("hills", text).expect("a right scenario");
    let truck = || Truck::new(&scenario).expect("a road").expect("a truck");
    let drive = |truck: &mut Truck, request_mps2: f64| {
        let actuation =
            Actuation { request_mps2, source: Source::Command, limited: false, engine: None };
        (0..300).for_each(|_| truck.step(&actuation, None));
    };
    let mut first = truck();
    drive(&mut first, -0.8);
    let mut second = truck();
    second.kept = first.kept;
    assert!(first.service_brake_s() > 0.5, "it brakes");
    drive(&mut first, -0.3);
    drive(&mut second, -0.3);
    assert_eq!(first.state(), second.state());
    assert_eq!(first.kept, second.kept);
    assert_eq!(first.powertrain(), second.powertrain());
    assert_eq!(first.fuel_l_per_100km(), second.fuel_l_per_100km());
    assert_ne!(first.state(), truck().state());
}
