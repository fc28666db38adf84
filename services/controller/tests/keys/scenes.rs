//! Scenes of every kind, and the drive of a law through one of them.

use controller::law::{
    Ego, Input, Law, Output, Phase, PhaseInterval, Plan, Powertrain, Preview, SignalAhead, Target,
};

/// Surroundings of a law in one scene.
#[derive(Clone, Copy)]
pub struct Scene {
    speed_mps: f64,
    set_mps: f64,
    /// Gap and speed of the lead at the start, and the time from which on it is there.
    lead: Option<(f64, f64, f64)>,
    /// The lead's acceleration by time, m/s².
    motion: fn(f64) -> f64,
    /// Distance of the stop line and the phases with the times of their ends.
    signal: Option<(f64, [(Phase, f64); 3])>,
}

pub const STEPS: u32 = 450;

pub fn scenes() -> [Scene; 8] {
    let base = Scene { speed_mps: 20.0, set_mps: 30.0, lead: None, motion: |_| 0.0, signal: None };
    let phases =
        |green, yellow, red| [(Phase::Red, red), (Phase::Green, green), (Phase::Yellow, yellow)];
    [
        Scene { lead: Some((60.0, 20.0, 0.0)), motion: wave, ..base },
        Scene {
            lead: Some((170.0, 8.0, 3.0)),
            motion: |t| if t > 25.0 { 1.0 } else { 0.0 },
            ..base
        },
        Scene { lead: Some((30.0, 20.0, 0.0)), motion: stop_and_go, ..base },
        Scene { speed_mps: 33.0, set_mps: 22.0, lead: Some((18.0, 26.0, 6.0)), ..base },
        Scene { signal: Some((260.0, phases(18.0, 21.0, 12.0))), ..base },
        Scene {
            lead: Some((40.0, 20.0, 0.0)),
            signal: Some((330.0, phases(16.0, 19.0, 2.0))),
            ..base
        },
        Scene {
            speed_mps: 15.0,
            lead: Some((34.5, 15.0, 0.0)),
            signal: Some((70.0, phases(4.5, 7.5, 0.0))),
            ..base
        },
        Scene { speed_mps: 10.0, lead: Some((20.0, 22.0, 0.0)), ..base },
    ]
}

fn wave(t: f64) -> f64 {
    0.8 * libm::sin(0.4 * t)
}

fn stop_and_go(t: f64) -> f64 {
    match t {
        t if t < 4.0 => 0.0,
        t if t < 9.0 => -6.0,
        t if t < 20.0 => 0.0,
        _ => 1.2,
    }
}

/// Drives one scene; `seen` gets each output and says whether to go on.
pub fn drive(law: &mut dyn Law, scene: &Scene, mut seen: impl FnMut(&Output) -> bool) {
    let (mut ego_m, mut speed, mut acceleration) = (0.0, scene.speed_mps, 0.0);
    let (gap, mut lead_mps, from_s) = scene.lead.unwrap_or((1e9, 0.0, f64::INFINITY));
    let mut lead_m = gap;
    let mut output = Output::default();
    law.reset();
    for step in 0..STEPS {
        let time_s = 0.1 * f64::from(step);
        // A radar's noise, so that filters and hysteresis matter.
        let noise = 0.3 * libm::sin(2.9 * f64::from(step));
        let mut input = Input {
            time_s,
            period_s: 0.1,
            ego: Ego { position_m: ego_m, speed_mps: speed, acceleration_mps2: acceleration },
            set_speed_mps: scene.set_mps,
            speed_limit_mps: f64::INFINITY,
            ..Input::default()
        };
        if time_s >= from_s && lead_m - ego_m < 200.0 {
            input.target = Some(Target {
                track_id: 1,
                gap_m: lead_m - ego_m + noise,
                relative_speed_mps: lead_mps - speed + 0.3 * noise,
                acceleration_mps2: (scene.motion)(time_s),
                age_s: 0.05,
            });
        }
        if let Some((line_m, phases)) = scene.signal {
            input.signals[0] = signal(line_m - ego_m, time_s, &phases);
        }
        let grade = 0.03 * libm::sin(ego_m / 180.0);
        input.powertrain = Some(Powertrain {
            gear: 6,
            since_shift_s: time_s,
            engine_torque_nm: 800.0 + 400.0 * acceleration,
            grade,
        });
        input.preview = Some(Preview {
            start_m: (ego_m / 50.0).floor() * 50.0,
            cell_m: 50.0,
            grades: core::array::from_fn(|cell| {
                0.03 * libm::sin(((ego_m / 50.0).floor() * 50.0 + 50.0 * cell as f64) / 180.0)
            }),
            count: 40,
        });
        law.step(&input, &mut output);
        if let Some(planning) = law.planning()
            && let Some(request) = planning.request()
        {
            let mut plan = Plan::default();
            planning.planner().plan(&request, &mut plan);
            planning.accept(&plan);
        }
        if !seen(&output) {
            return;
        }
        acceleration += 0.18 * (output.request_mps2() - acceleration);
        let next = (speed + 0.1 * acceleration).max(0.0);
        ego_m += 0.05 * (speed + next);
        (speed, acceleration) = (next, if next > 0.0 { acceleration } else { 0.0 });
        if time_s >= from_s {
            lead_mps = (lead_mps + 0.1 * (scene.motion)(time_s)).max(0.0);
            lead_m += 0.1 * lead_mps;
        } else {
            lead_m += 0.1 * speed;
        }
    }
}

fn signal(distance_m: f64, time_s: f64, phases: &[(Phase, f64); 3]) -> Option<SignalAhead> {
    let mut intervals = [PhaseInterval::default(); 8];
    let ahead = phases.iter().filter(|(_, end_s)| *end_s > time_s);
    let mut count = 0;
    for (phase, end_s) in ahead {
        intervals[count] = PhaseInterval { phase: *phase, ends_in_s: end_s - time_s };
        count += 1;
    }
    (distance_m > -10.0 && count > 0).then_some(SignalAhead {
        id: 257,
        distance_m,
        intervals,
        count,
        likely_s: 0.0,
    })
}
