//! Tests of a car on a road with heights.

use scenario::Scenario;
use scenario::grade::{GradeProfile, Point};

use super::*;

fn road(points: &[(f64, f64)]) -> GradeProfile {
    let point = |&(distance_m, height_m): &(f64, f64)| Point { distance_m, height_m };
    GradeProfile::new(points.iter().map(point).collect()).expect("a road")
}

/// A constant grade, percent.
fn slope(percent: f64) -> GradeProfile {
    road(&[(0.0, 0.0), (500.0, 5.0 * percent)])
}

fn car(keys: &str) -> Vehicle {
    let text = format!("schema_version = 1\nname = \"x\"\n[plant]\n{keys}\n");
    Vehicle::new(&Scenario::parse("x", &text).expect("it is right").plant)
}

#[test]
fn a_level_road_changes_no_bit() {
    let level = road(&[(0.0, 3.0), (500.0, 3.0), (1000.0, 3.0)]);
    let (mut plain, mut on_road) = (car("initial_speed_mps = 20"), car("initial_speed_mps = 20"));
    for step in 0..3000_i32 {
        let request = f64::from(step % 700 - 350) * 0.01;
        let ceiling = (step % 900 > 800).then_some(-6.0);
        plain.step_on(request, ceiling, None);
        on_road.step_on(request, ceiling, Some(&level));
        assert_eq!(plain.state(), on_road.state());
    }
}

#[test]
fn a_change_of_grade_acts_at_once_and_fades_with_the_lag() {
    let road = road(&[(0.0, 0.0), (100.0, 0.0), (600.0, 25.0)]);
    let mut car = car("initial_speed_mps = 20");
    car.take_slope(&road);
    let mut lowest = 0.0_f64;
    let mut slowest_mps = 20.0_f64;
    while car.state().position_m < 400.0 {
        car.step_on(0.0, None, Some(&road));
        lowest = lowest.min(car.state().acceleration_mps2);
        slowest_mps = slowest_mps.min(car.state().speed_mps);
    }
    // 5 % are 0.49 m/s², met over the car's length of 4.5 m: 0.22 s, with a lag of 0.5 s.
    assert!((-0.49..-0.35).contains(&lowest), "{lowest}");
    // The lag loses g sin θ tau.
    assert!((slowest_mps - (20.0 - 0.49 * 0.5)).abs() < 0.01, "{slowest_mps}");
    assert!(car.state().acceleration_mps2.abs() < 1e-3);
}

#[test]
fn gravity_takes_from_brakes_and_power() {
    let braked = |percent: f64| {
        let road = slope(percent);
        let mut car = car("initial_speed_mps = 30");
        car.take_slope(&road);
        for _ in 0..200 {
            car.step_on(-20.0, None, Some(&road));
        }
        car.state().acceleration_mps2
    };
    let gravity = 9.81 * 0.05 / libm::sqrt(1.0 + 0.05 * 0.05);
    assert!((braked(0.0) + 9.0).abs() < 0.2);
    assert!((braked(5.0) - braked(0.0) + gravity).abs() < 0.02, "uphill helps");
    assert!((braked(-5.0) - braked(0.0) - gravity).abs() < 0.02, "downhill costs");
    let top_mps = |percent: f64| {
        let road = road(&[(0.0, 0.0), (500.0, 5.0 * percent), (1000.0, 10.0 * percent)]);
        let mut car =
            car("initial_speed_mps = 20\npowertrain = { mass_kg = 2000, max_power_kw = 40 }");
        car.take_slope(&road);
        while car.state().position_m < 900.0 {
            car.step_on(3.0, None, Some(&road));
        }
        car.state().speed_mps
    };
    // 20 W/kg carry 40.8 m/s up 5 %, and 20.4 m/s up 10 %.
    assert!(top_mps(5.0) > 22.0 && (top_mps(10.0) - 20.4).abs() < 0.3, "{}", top_mps(10.0));
}

#[test]
fn a_car_stands_on_any_grade_and_starts_again() {
    for percent in [-12.0, -3.0, 0.0, 3.0, 12.0] {
        let road = slope(percent);
        let mut car = car("initial_speed_mps = 15");
        car.take_slope(&road);
        for _ in 0..1500 {
            car.step_on(-3.0, None, Some(&road));
        }
        let stands = car.state();
        assert_eq!(stands.speed_mps, 0.0, "{percent} %");
        for _ in 0..1000 {
            car.step_on(0.0, None, Some(&road));
        }
        assert_eq!(car.state(), State { acceleration_mps2: 0.0, ..stands }, "{percent} %");
        for _ in 0..300 {
            car.step_on(1.0, None, Some(&road));
        }
        assert!((car.state().speed_mps - 2.5).abs() < 0.2, "{percent} %: {:?}", car.state());
    }
}
