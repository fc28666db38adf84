//! Balance of energy for any demand on the truck.

use proptest::prelude::*;
use truck_model::{Demand, GEARS, Ledger, Motion, Preset, Truck};

/// Largest error of the balance, relative to all energy moved.
const TOLERANCE: f64 = 1e-6;

fn presets() -> impl Strategy<Value = Preset> {
    prop_oneof![Just(Preset::Jh6At49T), Just(Preset::Jh6At25T)]
}

/// Pieces of (torque, service brake, gear, grade), 2 s each.
fn pieces() -> impl Strategy<Value = Vec<(f64, f64, Option<usize>, f64)>> {
    let gear = proptest::option::of(0..GEARS + 1);
    let brake = prop_oneof![3 => Just(0.0), 1 => 0.0..150e3_f64];
    prop::collection::vec((-2500.0..2500.0_f64, brake, gear, -0.06..0.06_f64), 1..60)
}

proptest! {
    #[test]
    fn work_in_is_kinetic_and_potential_energy_and_losses(
        preset in presets(),
        start_mps in 0.0..26.0_f64,
        dt_s in prop_oneof![Just(0.01), Just(0.001), Just(0.1)],
        pieces in pieces(),
    ) {
        let truck = Truck::preset(preset);
        let weight_n = truck.parameters().mass_kg * 9.81;
        let mut motion = Motion::new(&truck, 0.0, start_mps, 0.0);
        let start_j = truck.kinetic_energy_j(start_mps);
        let (mut height_m, mut moved_j) = (0.0, start_j + 1.0);
        for (torque, brake, gear, grade) in pieces {
            let demand = Demand { engine_torque_nm: torque, service_brake_n: brake, gear };
            for _ in 0..(2.0 / dt_s) as usize {
                let before = motion;
                motion.step(&truck, dt_s, &demand, grade);
                let distance_m = motion.position_m - before.position_m;
                height_m += distance_m * libm::sin(libm::atan(grade));
                prop_assert!(motion.speed_mps >= 0.0 && distance_m >= 0.0);
                prop_assert!(motion.fuel_g >= before.fuel_g);
                let (now, then) = (motion.ledger, before.ledger);
                prop_assert!(grows(&now, &then), "{now:?} after {then:?}");
                moved_j += (now.crank_j - then.crank_j).abs()
                    + (now.potential_j - then.potential_j).abs();
            }
        }
        let ledger = motion.ledger;
        let kinetic_j = truck.kinetic_energy_j(motion.speed_mps) - start_j;
        let losses_j = ledger.auxiliary_j
            + ledger.driveline_j
            + ledger.clutch_j
            + ledger.rolling_j
            + ledger.air_j
            + ledger.service_brake_j;
        let off_j = ledger.crank_j - losses_j - ledger.potential_j - kinetic_j;
        prop_assert!(off_j.abs() < TOLERANCE * moved_j, "{off_j} J of {moved_j} J: {ledger:?}");
        let potential_off_j = ledger.potential_j - weight_n * height_m;
        prop_assert!(potential_off_j.abs() < TOLERANCE * moved_j, "{potential_off_j}");
    }
}

/// Returns whether no loss shrinks, up to rounding.
fn grows(now: &Ledger, then: &Ledger) -> bool {
    let rounding_j = 1e-3;
    [
        now.auxiliary_j - then.auxiliary_j,
        now.driveline_j - then.driveline_j,
        now.clutch_j - then.clutch_j,
        now.rolling_j - then.rolling_j,
        now.air_j - then.air_j,
        now.service_brake_j - then.service_brake_j,
        now.engine_brake_j - then.engine_brake_j,
    ]
    .iter()
    .all(|&change| change >= -rounding_j)
}

#[test]
fn an_acceleration_is_what_was_asked_for() {
    let truck = Truck::preset(Preset::Jh6At49T);
    for (wanted, grade) in [(0.1, 0.0), (-0.2, 0.01), (-0.5, -0.02), (-2.0, 0.0), (-4.0, -0.04)] {
        let mut motion = Motion::new(&truck, 0.0, 21.0, grade);
        for _ in 0..150 {
            let demand =
                Demand::for_acceleration(&truck, wanted, motion.speed_mps, motion.gear, grade);
            motion.step(&truck, 0.01, &demand, grade);
        }
        let found = motion.acceleration_mps2;
        assert!((found - wanted).abs() < 0.02, "asked for {wanted}, got {found}");
    }
}

#[test]
fn it_starts_from_rest_and_stops_and_stays() {
    let truck = Truck::preset(Preset::Jh6At49T);
    let mut motion = Motion::new(&truck, 0.0, 0.0, 0.0);
    for _ in 0..12_000 {
        motion.step(&truck, 0.01, &Demand::torque(2000.0), 0.0);
    }
    assert!(motion.speed_mps > 20.0, "{motion:?}");
    assert_eq!(motion.gear, GEARS - 1);
    let brake = Demand { service_brake_n: 200e3, ..Demand::default() };
    for _ in 0..3000 {
        motion.step(&truck, 0.01, &brake, -0.05);
    }
    assert_eq!(motion.speed_mps, 0.0);
    let position_m = motion.position_m;
    motion.step(&truck, 0.01, &brake, -0.05);
    assert_eq!(motion.position_m, position_m);
}
