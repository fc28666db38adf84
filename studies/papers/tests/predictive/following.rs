//! Behind a lead: the four points of the paper's figure, headway, and a lead that brakes hard.

use crate::roads::generated;
use controller::laws::truck::{Brakes, Keys, PlannerKind, Settings};
use papers::trips::{Assisted, Lead, Map, Moment, Noise, Road, Trip, chase};
use rand_core::Rng;
use rand_pcg::Pcg64;
use truck_model::{Preset, Truck};

/// Set speed of the following figure, m/s.
const SET_MPS: f64 = 25.0;
const RADAR: Noise = Noise { gap_m: 0.39, relative_speed_mps: 0.15, seed: 1 };
/// Modes of the law.
const PREDICTIVE: u32 = 1;
const FOLLOW: u32 = 2;

fn assisted(truck: &Truck, road: &Road, set_mps: f64) -> Assisted {
    let settings = Settings::new(truck, PlannerKind::DynamicProgramming);
    Assisted::new(&settings, set_mps, Map { road: road.clone(), shift_m: 0.0 })
}

/// Downhill, level, uphill, level again: 5 km.
fn figure_road() -> Road {
    let grade = |cell: usize| match cell {
        0..18 => -0.008,
        18..30 => -0.004,
        40..60 => 0.012,
        _ => 0.0,
    };
    Road::new(50.0, (0..100).map(grade).collect())
}

fn figure() -> Trip {
    let truck = Truck::preset(Preset::Jh6At25T);
    let lead = Lead {
        gap_m: 80.0,
        speed_mps: 22.0,
        accelerations: vec![(40.0, 0.0), (60.0, 0.10), (80.0, 0.04), (98.0, 0.0), (106.0, -0.5)],
    };
    let road = figure_road();
    chase(&truck, &road, 24.0, &lead, None, 160.0, &mut assisted(&truck, &road, SET_MPS))
}

fn between(chase: &Trip, from_m: f64, to_m: f64) -> Vec<Moment> {
    let inside = |moment: &&Moment| (from_m..to_m).contains(&moment.position_m);
    chase.moments.iter().filter(inside).copied().collect()
}

#[test]
fn the_four_points_of_the_figure() {
    let figure = figure();
    let truck = Truck::preset(Preset::Jh6At25T);

    // 1: downhill with drag alone, until the relative speed is gone.
    let downhill = between(&figure, 150.0, 350.0);
    for moment in &downhill {
        let rpm = truck.engine_rpm(moment.speed_mps, 5);
        let drag_nm = truck.engine().drag_torque_nm(rpm);
        assert!((moment.engine_torque_nm - drag_nm).abs() < 10.0, "{moment:?}");
        assert_eq!(moment.mode, FOLLOW);
    }
    assert!(downhill[0].lead_mps - downhill[0].speed_mps < -1.3);
    let after = between(&figure, 600.0, 800.0);
    assert!(after[0].lead_mps - after[0].speed_mps > -0.3, "{:?}", after[0]);

    // 2: a gap that grows slowly.
    let growing = between(&figure, 1100.0, 1500.0);
    assert!(growing.windows(2).all(|pair| pair[1].gap_m >= pair[0].gap_m));

    // 3: beyond the band the plan drives, no faster than the lead by more than the approach.
    let beyond = between(&figure, 1600.0, 1950.0);
    assert!(beyond.iter().any(|moment| moment.mode == PREDICTIVE));
    assert!(beyond.iter().all(|moment| moment.speed_mps < moment.lead_mps + 0.3));

    // 4: the lead brakes uphill: first a little, then more, then equal speeds.
    let braking = between(&figure, 2200.0, 2600.0);
    let hardest = braking.iter().map(|moment| moment.acceleration_mps2).fold(0.0, f64::min);
    assert!((-0.8..-0.1).contains(&hardest), "{hardest}");
    let last = figure.moments.last().expect("it has moments");
    assert!((last.lead_mps - last.speed_mps).abs() < 0.1, "{last:?}");
    assert_eq!(figure.ledger.service_brake_j, 0.0);
}

/// A lead that wanders about 20 m/s.
fn wandering(seed: u64) -> Lead {
    let mut rng = Pcg64::new(u128::from(seed), 1);
    let mut speed_mps = 20.0;
    let accelerations = (1..=80).map(|part| {
        let chance = (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let aim_mps = 17.0 + 6.0 * chance;
        let mps2 = ((aim_mps - speed_mps) / 15.0_f64).clamp(-0.4, 0.15);
        speed_mps += 15.0 * mps2;
        (15.0 * f64::from(part), mps2)
    });
    Lead { gap_m: 55.0, speed_mps: 20.0, accelerations: accelerations.collect() }
}

#[test]
fn it_keeps_a_second_of_headway_behind_a_lead_that_wanders() {
    for preset in Preset::ALL {
        let truck = Truck::preset(preset);
        for seed in 1..=3 {
            let road = generated(20_000.0, seed);
            let lead = wandering(seed);
            for noise in [None, Some(RADAR)] {
                let mut law = assisted(&truck, &road, SET_MPS);
                let ours = chase(&truck, &road, 20.0, &lead, noise, 1100.0, &mut law);
                let braked_mj = ours.ledger.service_brake_j / 1e6;
                println!(
                    "{} road {seed}: headway {:.2} s, service brakes {braked_mj:.2} MJ",
                    preset.name(),
                    ours.least_headway_s(),
                );
                assert!(ours.least_headway_s() >= 1.0);
            }
        }
    }
}

#[test]
fn a_lead_that_brakes_at_6_mps2_is_not_hit() {
    for preset in Preset::ALL {
        let truck = Truck::preset(preset);
        for grade in [-0.03, 0.0, 0.03] {
            let road = Road::new(50.0, vec![grade; 100]);
            for gap_m in [30.0, 40.0, 55.0] {
                for noise in [None, Some(RADAR)] {
                    let lead = Lead {
                        gap_m,
                        speed_mps: 20.8,
                        accelerations: vec![(20.0, 0.0), (24.0, -6.0)],
                    };
                    let mut law = assisted(&truck, &road, 20.8);
                    let chase = chase(&truck, &road, 20.8, &lead, noise, 60.0, &mut law);
                    let least_m = chase.least_gap_m();
                    assert!(
                        least_m > 2.0,
                        "{} at {grade} from {gap_m} m: {least_m}",
                        preset.name()
                    );
                    assert!(
                        chase.ledger.service_brake_j > 0.0 && chase.ledger.engine_brake_j > 0.0
                    );
                }
            }
        }
    }
}

/// As published: torque between drag and full load, whatever the lead does.
#[test]
fn torque_alone_uses_no_brake_and_the_engine_brake_helps() {
    let truck = Truck::preset(Preset::Jh6At25T);
    let road = Road::new(50.0, vec![-0.03; 100]);
    let lead =
        Lead { gap_m: 55.0, speed_mps: 20.8, accelerations: vec![(20.0, 0.0), (24.0, -1.0)] };
    let [none, engine, service] = [Brakes::None, Brakes::Engine, Brakes::Service].map(|brakes| {
        let settings = Settings::of_keys(&truck, &Keys { brakes, ..Keys::default() });
        let map = Map { road: road.clone(), shift_m: 0.0 };
        let mut law = Assisted::new(&settings, 20.8, map);
        chase(&truck, &road, 20.8, &lead, None, 40.0, &mut law)
    });
    assert_eq!((none.ledger.service_brake_j, none.ledger.engine_brake_j), (0.0, 0.0));
    assert_eq!(engine.ledger.service_brake_j, 0.0);
    assert!(engine.ledger.engine_brake_j > 0.0 && service.ledger.service_brake_j > 0.0);
    let gaps = [&none, &engine, &service].map(Trip::least_gap_m);
    assert!(gaps.is_sorted(), "{gaps:?}");
}
