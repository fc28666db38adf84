use proptest::prelude::*;
use scenario::plant::Powertrain;
use scenario::quantity::{Acceleration, Mass, PeriodMs, Power, Speed, TimeConstant};

use super::*;

macro_rules! reference {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/", $name, ".csv"))
    };
}

fn paper(period_ms: u32, initial_speed_mps: f64) -> Plant {
    Plant {
        period_ms: PeriodMs::of(period_ms),
        integrator: Integrator::PaperEuler,
        integration_step_ms: PeriodMs::of(100),
        initial_speed_mps: Speed::of(initial_speed_mps),
        ..Plant::default()
    }
}

/// Follows the requests of a reference run and returns the largest deviations of x, v and a.
fn deviations(csv: &str, period_ms: u32) -> [f64; 3] {
    let rows: Vec<Vec<f64>> = csv
        .lines()
        .skip(1)
        .map(|line| line.split(',').take(5).map(|f| f.parse().expect("a number")).collect())
        .collect();
    let mut vehicle = Vehicle::new(&paper(period_ms, rows[0][2]));
    let mut worst = [0.0f64; 3];
    for row in &rows {
        let State { position_m, speed_mps, acceleration_mps2 } = vehicle.state();
        for (i, ours) in [position_m, speed_mps, acceleration_mps2].into_iter().enumerate() {
            worst[i] = worst[i].max((ours - row[1 + i]).abs());
        }
        for _ in 0..100 / period_ms {
            vehicle.step(row[4]);
        }
    }
    worst
}

#[test]
fn the_papers_plant_is_reproduced_at_any_period() {
    let references = [
        reference!("cacc-a-acc"),
        reference!("cacc-a-cacc"),
        reference!("cacc-b-acc"),
        reference!("cacc-b-cacc"),
        reference!("cacc-c-acc"),
        reference!("cacc-c-cacc"),
        reference!("cacc-table3-acc"),
        reference!("cacc-table3-cacc"),
    ];
    for csv in references {
        for period_ms in [10, 20, 50, 100] {
            // The reference prints five decimals, its requests six.
            for deviation in deviations(csv, period_ms) {
                assert!(deviation < 2e-5, "off by {deviation} at {period_ms} ms");
            }
        }
    }
}

#[test]
fn the_fine_integrator_is_exact_for_a_step_of_the_request() {
    let plant = Plant { initial_speed_mps: Speed::of(20.0), ..Plant::default() };
    let mut vehicle = Vehicle::new(&plant);
    for _ in 0..200 {
        vehicle.step(-3.0);
    }
    // The closed form for t = 2 s: a = u (1 - e^(-t/tau)) and its integrals.
    let (t, tau, u) = (2.0, 0.5, -3.0);
    let gained = tau * (1.0 - libm::exp(-t / tau));
    let state = vehicle.state();
    assert!((state.acceleration_mps2 - u * (1.0 - libm::exp(-t / tau))).abs() < 1e-12);
    assert!((state.speed_mps - (20.0 + u * (t - gained))).abs() < 1e-11);
    let x = 20.0 * t + u * (0.5 * t * t - tau * (t - gained));
    assert!((state.position_m - x).abs() < 1e-10);
}

#[test]
fn the_result_does_not_depend_on_the_fine_step_while_moving() {
    let run = |step_ms| {
        let plant = Plant {
            initial_speed_mps: Speed::of(20.0),
            integration_step_ms: PeriodMs::of(step_ms),
            ..Plant::default()
        };
        let mut vehicle = Vehicle::new(&plant);
        for k in 0..500 {
            vehicle.step(if k % 7 < 3 { 2.0 } else { -1.5 });
        }
        vehicle.state()
    };
    let (fine, coarse) = (run(1), run(10));
    assert!((fine.position_m - coarse.position_m).abs() < 1e-9);
    assert!((fine.speed_mps - coarse.speed_mps).abs() < 1e-10);
}

#[test]
fn a_stop_ends_at_standstill_and_a_start_leaves_it() {
    let plant = Plant { initial_speed_mps: Speed::of(10.0), ..Plant::default() };
    let mut vehicle = Vehicle::new(&plant);
    for _ in 0..1000 {
        vehicle.step(-4.0);
    }
    let stopped = vehicle.state();
    assert_eq!((stopped.speed_mps, stopped.acceleration_mps2), (0.0, 0.0));
    // v0²/(2 b) + v0 tau, less the little that the lag's tail gives back.
    assert!((stopped.position_m - (12.5 + 5.0)).abs() < 0.6, "{stopped:?}");
    vehicle.step(-4.0);
    assert_eq!(vehicle.state(), stopped);
    vehicle.step(1.0);
    assert!(vehicle.state().speed_mps > 0.0);
}

#[test]
fn a_request_that_changes_inside_an_euler_step_counts_with_its_mean() {
    let (mut split, mut mean) = (Vehicle::new(&paper(10, 15.0)), Vehicle::new(&paper(10, 15.0)));
    for k in 0..10 {
        split.step(if k < 5 { 4.0 } else { -2.0 });
        mean.step(1.0);
    }
    let difference = split.state().acceleration_mps2 - mean.state().acceleration_mps2;
    assert!(difference.abs() < 1e-12);
}

#[test]
fn power_limits_the_acceleration_at_speed() {
    let plant = Plant {
        initial_speed_mps: Speed::of(25.0),
        powertrain: Some(Powertrain { mass_kg: Mass::of(2000.0), max_power_kw: Power::of(100.0) }),
        ..Plant::default()
    };
    let mut vehicle = Vehicle::new(&plant);
    for _ in 0..300 {
        vehicle.step(5.0);
    }
    let state = vehicle.state();
    assert!(state.acceleration_mps2 > 1.5 && state.acceleration_mps2 < 2.0);
    let mut free = Vehicle::new(&Plant { powertrain: None, ..plant });
    for _ in 0..300 {
        free.step(5.0);
    }
    assert!(free.state().acceleration_mps2 > 4.9);
}

fn plants() -> impl Strategy<Value = Plant> {
    let integrators = prop_oneof![Just((Integrator::Fine, 1)), Just((Integrator::PaperEuler, 100))];
    (0.0..40.0f64, -5.0..4.0f64, 0.1..2.0f64, integrators).prop_map(|(v, a, tau, (how, step))| {
        Plant {
            integrator: how,
            integration_step_ms: PeriodMs::of(step),
            initial_speed_mps: Speed::of(v),
            initial_acceleration_mps2: Acceleration::of(a),
            actuator_time_constant_s: TimeConstant::of(tau),
            ..Plant::default()
        }
    })
}

proptest! {
    #[test]
    fn it_never_reverses_and_stays_within_its_bounds(
        plant in plants(), requests in prop::collection::vec(-20.0..20.0f64, 1..400),
    ) {
        let mut vehicle = Vehicle::new(&plant);
        for request in requests {
            let before = vehicle.state();
            vehicle.step(request);
            let after = vehicle.state();
            prop_assert!(after.speed_mps >= 0.0);
            prop_assert!(after.position_m >= before.position_m);
            prop_assert!((-9.0 - 1e-9..=5.0 + 1e-9).contains(&after.acceleration_mps2));
        }
    }
}

#[test]
fn the_emergency_brakes_effect_is_over_when_it_lets_go() {
    let initial_speed_mps = Speed::of(30.0);
    let mut vehicle = Vehicle::new(&Plant { initial_speed_mps, ..Plant::default() });
    for _ in 0..50 {
        vehicle.step_on(1.0, Some(-8.0), None);
    }
    assert_eq!(vehicle.state().acceleration_mps2, -8.0);
    vehicle.step(0.0);
    assert_eq!(vehicle.state().acceleration_mps2, 0.0, "there was no drive under the brake");
    // The controller's own braking is still there.
    for _ in 0..100 {
        vehicle.step_on(-2.0, Some(-8.0), None);
    }
    vehicle.step(-2.0);
    let State { speed_mps, acceleration_mps2, .. } = vehicle.state();
    assert!(speed_mps > 10.0 && (-2.0..-1.0).contains(&acceleration_mps2));
}

#[test]
fn the_emergency_brake_stops_the_vehicle_where_the_formula_says() {
    let plant = Plant { initial_speed_mps: Speed::of(4.1), ..Plant::default() };
    let mut vehicle = Vehicle::new(&plant);
    for _ in 0..25 {
        vehicle.step_on(0.0, Some(-8.0), None);
    }
    let State { position_m, speed_mps, .. } = vehicle.state();
    assert!((speed_mps - 2.1).abs() < 1e-12 && (position_m - 0.775).abs() < 1e-12);
    for _ in 0..50 {
        vehicle.step_on(0.0, Some(-8.0), None);
    }
    let stopped = vehicle.state();
    assert!((stopped.position_m - 4.1 * 4.1 / 16.0).abs() < 1e-9, "{stopped:?}");
    assert_eq!((stopped.speed_mps, stopped.acceleration_mps2), (0.0, 0.0));
}

#[test]
fn a_vehicle_that_brakes_harder_than_the_ceiling_keeps_to_its_own_braking() {
    let plant = Plant {
        initial_speed_mps: Speed::of(20.0),
        initial_acceleration_mps2: Acceleration::of(-4.0),
        ..Plant::default()
    };
    let mut vehicle = Vehicle::new(&plant);
    vehicle.step_on(-4.0, Some(-1.0), None);
    assert!((vehicle.state().acceleration_mps2 + 4.0).abs() < 1e-12);
}

#[test]
fn a_stop_inside_of_a_step_is_placed_by_the_share_of_the_step() {
    let plant = Plant {
        integration_step_ms: PeriodMs::of(10),
        initial_speed_mps: Speed::of(0.02),
        initial_acceleration_mps2: Acceleration::of(-4.0),
        ..Plant::default()
    };
    let mut vehicle = Vehicle::new(&plant);
    vehicle.step(-4.0);
    // 0.02 m/s less 0.04 m/s in 10 ms: it stands after 5 ms.
    assert!((vehicle.state().position_m - 5e-5).abs() < 1e-12);
}
