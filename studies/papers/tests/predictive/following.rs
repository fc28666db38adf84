//! Behind a lead: the four points of the paper's figure, headway, and a lead that brakes hard.

use crate::roads::generated;
use controller::law::Target;
use controller::laws::truck::{Brakes, Keys, PlannerKind, Settings};
use papers::trips::{Assisted, CONTROL_PERIOD_S, Driver, Map, Road, Seen, drive};
use rand_core::Rng;
use rand_pcg::Pcg64;
use truck_model::{Demand, Motion, Preset, Truck};

/// Set speed of the following figure, m/s.
const SET_MPS: f64 = 25.0;
/// Standard deviations of the radar's gap, m, and relative speed, m/s.
const NOISE: (f64, f64) = (0.39, 0.15);
/// Farthest that the radar sees, m.
const RANGE_M: f64 = 200.0;
/// Modes of the law.
const PREDICTIVE: u32 = 1;
const FOLLOW: u32 = 2;

/// The vehicle ahead: a speed at the start and accelerations that end at the given times.
struct Lead {
    gap_m: f64,
    speed_mps: f64,
    /// (until, acceleration) in s and m/s², in order of time; it keeps its speed afterwards.
    accelerations: Vec<(f64, f64)>,
}

/// One control period behind a lead.
#[derive(Clone, Copy, Debug)]
struct Moment {
    motion: Motion,
    lead_mps: f64,
    gap_m: f64,
    mode: u32,
}

/// The law behind a lead.
struct Behind {
    law: Assisted,
    lead: Lead,
    radar: Option<Pcg64>,
    until_s: f64,
    moments: Vec<Moment>,
}

impl Driver for Behind {
    fn demand(&mut self, seen: &Seen<'_>) -> Demand {
        let (motion, lead) = (seen.motion, &mut self.lead);
        let part = lead.accelerations.iter().find(|(until_s, _)| seen.time_s < *until_s);
        let acceleration_mps2 = part.map_or(0.0, |part| part.1);
        let (gap_m, lead_mps) = (lead.gap_m - motion.position_m, lead.speed_mps);
        let mut off =
            |sigma: f64| self.radar.as_mut().map_or(0.0, |radar| sigma * random::normal(radar));
        let target = (gap_m < RANGE_M).then(|| Target {
            track_id: 1,
            gap_m: gap_m + off(NOISE.0),
            relative_speed_mps: lead_mps - motion.speed_mps + off(NOISE.1),
            acceleration_mps2,
            age_s: 0.0,
        });
        lead.speed_mps = (lead_mps + CONTROL_PERIOD_S * acceleration_mps2).max(0.0);
        lead.gap_m += 0.5 * CONTROL_PERIOD_S * (lead_mps + lead.speed_mps);
        let demand = self.law.demand(&Seen { target, ..*seen });
        if seen.time_s < self.until_s {
            let mode = self.law.mode();
            self.moments.push(Moment { motion: *motion, lead_mps, gap_m, mode });
        }
        demand
    }
}

/// Drives behind a lead for `until_s`, or to the road's end.
fn chase(
    (truck, road, start_mps): (&Truck, &Road, f64),
    lead: Lead,
    is_noisy: bool,
    until_s: f64,
    law: Assisted,
) -> Vec<Moment> {
    let radar = is_noisy.then(|| Pcg64::new(1, 3));
    let mut driver = Behind { law, lead, radar, until_s, moments: Vec::new() };
    // Behind a lead that stands, the truck stands too.
    let _ = drive(truck, road, start_mps, &mut driver);
    driver.moments
}

fn least_gap_m(moments: &[Moment]) -> f64 {
    moments.iter().map(|moment| moment.gap_m).fold(f64::INFINITY, f64::min)
}

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

fn figure() -> Vec<Moment> {
    let truck = Truck::preset(Preset::Jh6At25T);
    let lead = Lead {
        gap_m: 80.0,
        speed_mps: 22.0,
        accelerations: vec![(40.0, 0.0), (60.0, 0.10), (80.0, 0.04), (98.0, 0.0), (106.0, -0.5)],
    };
    let road = figure_road();
    let law = assisted(&truck, &road, SET_MPS);
    chase((&truck, &road, 24.0), lead, false, 160.0, law)
}

fn between(chase: &[Moment], from_m: f64, to_m: f64) -> Vec<Moment> {
    let inside = |moment: &&Moment| (from_m..to_m).contains(&moment.motion.position_m);
    chase.iter().filter(inside).copied().collect()
}

#[test]
fn the_four_points_of_the_figure() {
    let figure = figure();
    let truck = Truck::preset(Preset::Jh6At25T);

    // 1: downhill with drag alone, until the relative speed is gone.
    let downhill = between(&figure, 150.0, 350.0);
    for moment in &downhill {
        let rpm = truck.engine_rpm(moment.motion.speed_mps, 5);
        let drag_nm = truck.engine().drag_torque_nm(rpm);
        assert!((moment.motion.engine_torque_nm - drag_nm).abs() < 10.0, "{moment:?}");
        assert_eq!(moment.mode, FOLLOW);
    }
    assert!(downhill[0].lead_mps - downhill[0].motion.speed_mps < -1.3);
    let after = between(&figure, 600.0, 800.0);
    assert!(after[0].lead_mps - after[0].motion.speed_mps > -0.3, "{:?}", after[0]);

    // 2: a gap that grows slowly.
    let growing = between(&figure, 1100.0, 1500.0);
    assert!(growing.windows(2).all(|pair| pair[1].gap_m >= pair[0].gap_m));

    // 3: beyond the band the plan drives, no faster than the lead by more than the approach.
    let beyond = between(&figure, 1600.0, 1950.0);
    assert!(beyond.iter().any(|moment| moment.mode == PREDICTIVE));
    assert!(beyond.iter().all(|moment| moment.motion.speed_mps < moment.lead_mps + 0.3));

    // 4: the lead brakes uphill: first a little, then more, then equal speeds.
    let braking = between(&figure, 2200.0, 2600.0);
    let hardest = braking.iter().map(|moment| moment.motion.acceleration_mps2).fold(0.0, f64::min);
    assert!((-0.8..-0.1).contains(&hardest), "{hardest}");
    let last = figure.last().expect("it has moments");
    assert!((last.lead_mps - last.motion.speed_mps).abs() < 0.1, "{last:?}");
    assert_eq!(last.motion.ledger.service_brake_j, 0.0);
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
            for is_noisy in [false, true] {
                let law = assisted(&truck, &road, SET_MPS);
                let ours = chase((&truck, &road, 20.0), wandering(seed), is_noisy, 1100.0, law);
                let moving = ours.iter().filter(|moment| moment.motion.speed_mps > 5.0);
                let headways_s = moving.map(|moment| moment.gap_m / moment.motion.speed_mps);
                let least_s = headways_s.fold(f64::INFINITY, f64::min);
                assert!(least_s >= 1.0, "{} road {seed}: {least_s} s", preset.name());
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
                for is_noisy in [false, true] {
                    let lead = Lead {
                        gap_m,
                        speed_mps: 20.8,
                        accelerations: vec![(20.0, 0.0), (24.0, -6.0)],
                    };
                    let law = assisted(&truck, &road, 20.8);
                    let chase = chase((&truck, &road, 20.8), lead, is_noisy, 60.0, law);
                    let least_m = least_gap_m(&chase);
                    assert!(
                        least_m > 2.0,
                        "{} at {grade} from {gap_m} m: {least_m}",
                        preset.name()
                    );
                    let ledger = chase[chase.len() - 1].motion.ledger;
                    assert!(ledger.service_brake_j > 0.0 && ledger.engine_brake_j > 0.0);
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
    let runs = [Brakes::None, Brakes::Engine, Brakes::Service].map(|brakes| {
        let settings = Settings::of_keys(&truck, &Keys { brakes, ..Keys::default() });
        let map = Map { road: road.clone(), shift_m: 0.0 };
        let accelerations = vec![(20.0, 0.0), (24.0, -1.0)];
        let lead = Lead { gap_m: 55.0, speed_mps: 20.8, accelerations };
        chase((&truck, &road, 20.8), lead, false, 40.0, Assisted::new(&settings, 20.8, map))
    });
    let last = |run: &Vec<Moment>| run[run.len() - 1].motion.ledger;
    let [none, engine, service] = runs.each_ref().map(last);
    assert_eq!((none.service_brake_j, none.engine_brake_j), (0.0, 0.0));
    assert_eq!(engine.service_brake_j, 0.0);
    assert!(engine.engine_brake_j > 0.0 && service.service_brake_j > 0.0);
    let gaps = runs.each_ref().map(|run| least_gap_m(run));
    assert!(gaps.is_sorted(), "{gaps:?}");
}
