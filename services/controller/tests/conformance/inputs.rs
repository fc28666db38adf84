//! Inputs: ordinary ones, random ones, and numbers that no vehicle has.

use controller::law::{
    Ego, Input, Phase, PhaseInterval, Powertrain, Preview, SignalAhead, SpeedProfile, Target,
};
use rand_core::Rng;
use rand_pcg::Pcg64;

pub fn uniform(rng: &mut Pcg64, low: f64, high: f64) -> f64 {
    low + (high - low) * random::uniform(rng)
}

pub fn signal(distance_m: f64, phases: &[(Phase, f64)]) -> SignalAhead {
    let mut intervals = [PhaseInterval::default(); 8];
    for (slot, (phase, ends_in_s)) in intervals.iter_mut().zip(phases) {
        *slot = PhaseInterval { phase: *phase, ends_in_s: *ends_in_s };
    }
    SignalAhead { id: 257, distance_m, intervals, count: phases.len(), likely_s: 0.0 }
}

/// An ordinary moment: 20 m/s, a car ahead, a green light.
pub fn ordinary(k: u32) -> Input {
    let mut input = Input {
        time_s: 0.1 * f64::from(k),
        period_s: 0.1,
        ego: Ego { position_m: 2.0 * f64::from(k), speed_mps: 20.0, acceleration_mps2: 0.0 },
        target: Some(Target {
            track_id: 1,
            gap_m: 45.0,
            relative_speed_mps: -1.0,
            acceleration_mps2: 0.0,
            age_s: 0.02,
        }),
        set_speed_mps: 25.0,
        speed_limit_mps: 30.0,
        ..Input::default()
    };
    input.signals[0] = Some(signal(150.0, &[(Phase::Green, 12.0), (Phase::Red, 40.0)]));
    input.powertrain =
        Some(Powertrain { gear: 5, since_shift_s: 20.0, engine_torque_nm: 800.0, grade: 0.005 });
    input.preview = Some(Preview {
        start_m: 0.0,
        cell_m: 50.0,
        grades: core::array::from_fn(|cell| if cell % 20 < 10 { 0.01 } else { -0.015 }),
        count: 45,
    });
    input
}

/// Random but physical: everything a road shows, changing without continuity.
pub fn random(rng: &mut Pcg64, k: u32) -> Input {
    let speed = uniform(rng, 0.0, 45.0);
    let mut input = Input {
        time_s: 0.1 * f64::from(k),
        period_s: 0.1,
        ego: Ego {
            position_m: uniform(rng, 0.0, 1e5),
            speed_mps: speed,
            acceleration_mps2: uniform(rng, -9.0, 4.0),
        },
        set_speed_mps: uniform(rng, 0.0, 50.0),
        speed_limit_mps: [f64::INFINITY, 13.9, 27.8][rng.next_u32() as usize % 3],
        ..Input::default()
    };
    if !rng.next_u32().is_multiple_of(4) {
        input.target = Some(Target {
            track_id: rng.next_u32() % 3,
            gap_m: uniform(rng, -1.0, 250.0),
            relative_speed_mps: uniform(rng, -speed, 20.0),
            acceleration_mps2: uniform(rng, -9.0, 4.0),
            age_s: uniform(rng, 0.0, 0.3),
        });
    }
    if !rng.next_u32().is_multiple_of(3) {
        input.powertrain = Some(Powertrain {
            gear: rng.next_u32() as usize % 8,
            since_shift_s: uniform(rng, 0.0, 20.0),
            engine_torque_nm: uniform(rng, -2000.0, 2500.0),
            grade: uniform(rng, -0.06, 0.06),
        });
    }
    if !rng.next_u32().is_multiple_of(3) {
        let start_m = input.ego.position_m - uniform(rng, -100.0, 200.0);
        let grades = core::array::from_fn(|_| uniform(rng, -0.06, 0.06));
        let count = rng.next_u32() as usize % 70;
        input.preview = Some(Preview { start_m, cell_m: 50.0, grades, count });
    }
    if rng.next_u32().is_multiple_of(3) {
        let mut profile = SpeedProfile::constant(input.wanted_speed_mps());
        let from_m = uniform(rng, 0.0, 600.0);
        profile.cap(from_m, from_m + 50.0, uniform(rng, 0.0, 40.0), 1.0);
        profile.brake(uniform(rng, 0.5, 3.5));
        input.profile = Some(profile);
    }
    for slot in input.signals.iter_mut().take(rng.next_u32() as usize % 3) {
        let phase = [Phase::Unknown, Phase::Green, Phase::Yellow, Phase::Red];
        let phases = [0; 3].map(|_| (phase[rng.next_u32() as usize % 4], uniform(rng, -1.0, 60.0)));
        *slot = Some(signal(uniform(rng, -20.0, 400.0), &phases));
    }
    input
}

/// Every number of an input, to be spoilt one at a time.
pub fn numbers(input: &mut Input) -> Vec<&mut f64> {
    let mut all = vec![
        &mut input.time_s,
        &mut input.period_s,
        &mut input.ego.position_m,
        &mut input.ego.speed_mps,
        &mut input.ego.acceleration_mps2,
        &mut input.set_speed_mps,
        &mut input.speed_limit_mps,
    ];
    if let Some(t) = &mut input.target {
        let acceleration = &mut t.acceleration_mps2;
        all.extend([&mut t.gap_m, &mut t.relative_speed_mps, acceleration, &mut t.age_s]);
    }
    for s in input.signals.iter_mut().flatten() {
        all.extend([&mut s.distance_m, &mut s.likely_s]);
        all.extend(s.intervals.iter_mut().map(|i| &mut i.ends_in_s));
    }
    if let Some(p) = &mut input.powertrain {
        all.extend([&mut p.since_shift_s, &mut p.engine_torque_nm, &mut p.grade]);
    }
    if let Some(p) = &mut input.preview {
        all.extend([&mut p.start_m, &mut p.cell_m]);
        all.extend(p.grades.iter_mut().step_by(30));
    }
    all
}

pub const EVIL: [f64; 11] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN,
    f64::MIN_POSITIVE,
    1e300,
    -1e9,
    1e9,
    -0.0,
    0.0,
];
