//! The paper's formulation where its program has no solution or its input is false.

use law::{
    Ego, Input, Law, MAX_SIGNALS, Output, Phase, PhaseInterval, Quality, SignalAhead, Target,
};
use laws::cacc::config::Config;
use laws::cacc::paper::PaperLaw;
use scenario::controller::{SpacingPolicy, Weights};

fn law(set: Weights, policy: SpacingPolicy, light: bool) -> PaperLaw {
    let standstill_distance_m = 12.0;
    let config =
        Config { spacing_policy: policy, weights: set, standstill_distance_m, ..Config::default() };
    config.check().expect("the test's configuration is valid");
    let solver = config.create_solver();
    PaperLaw::new(&config, light, solver).expect("a validated configuration is convex")
}

/// A measured state beyond the buffer makes the paper's program infeasible; the law still answers.
#[test]
fn a_state_beyond_the_buffer_is_relaxed() {
    let mut law = law(Weights::default(), SpacingPolicy::MeasuredHeadway, false);
    let mut output = Output::default();
    let near = Target { track_id: 1, gap_m: 8.0, relative_speed_mps: -5.0, ..Target::default() };
    law.step(&behind(near), &mut output);
    assert_eq!((output.quality, output.plan_len), (Quality::Relaxed, 100));
    assert!(output.request_mps2() < -4.0, "{}", output.request_mps2());
}

#[test]
fn false_numbers_never_reach_the_command() {
    let mut law = law(Weights::default(), SpacingPolicy::MeasuredHeadway, true);
    let mut output = Output::default();
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        for field in 0..8 {
            let mut target = Target { track_id: 1, gap_m: 30.0, ..Target::default() };
            let mut input = behind(target);
            let mut distance_m = 50.0;
            match field {
                0 => target.gap_m = x,
                1 => target.relative_speed_mps = x,
                2 => input.ego.speed_mps = x,
                3 => input.ego.acceleration_mps2 = x,
                4 => input.time_s = x,
                5 => input.period_s = x,
                6 => input.set_speed_mps = x,
                _ => distance_m = x,
            }
            input.target = Some(target);
            input.signals = light(Phase::Green, 4.0, distance_m);
            law.reset();
            law.step(&input, &mut output);
            assert!(output.plan_len >= 1);
            for u in &output.plan_mps2[..output.plan_len] {
                assert!((-4.9..=4.9).contains(u), "field {field} at {x}: {u}");
            }
        }
    }
}

fn behind(target: Target) -> Input {
    Input {
        time_s: 1.0,
        period_s: 0.1,
        ego: Ego { position_m: 10.0, speed_mps: 15.0, acceleration_mps2: 0.0 },
        target: Some(target),
        set_speed_mps: f64::INFINITY,
        speed_limit_mps: f64::INFINITY,
        ..Input::default()
    }
}

/// The light has a solution at 2.1 s and 2.2 s of Table 3. Rolled out by hand, the plan meets every
/// constraint of the paper's program. At 2.1 s its margin is 17 mm.
#[test]
fn the_light_has_a_solution_where_the_reference_found_no_solution() {
    // State and light of instances 778 and 779: e, ed, a, H, t_l.
    let at = [
        (-4.227_668_079_53, 0.871_712_556_12, 1.004_118_809_52, -8.198_048_834_19, 7.9),
        (-3.989_879_002_49, 0.733_324_437_08, 1.258_879_953_00, -6.486_026_655_62, 7.8),
    ];
    for (mut e, mut ed, mut a, h, t_l) in at {
        let (v, v_lead) = (6.0, 6.0 - ed);
        let target = Target {
            track_id: 1,
            gap_m: 1.5 * v + 12.0 - e,
            relative_speed_mps: -ed,
            ..Target::default()
        };
        let mut input = behind(target);
        input.ego = Ego { position_m: 6.5, speed_mps: v, acceleration_mps2: a };
        input.signals = light(Phase::Green, t_l, v_lead * t_l - h - e);
        let mut output = Output::default();
        law(Weights::default(), SpacingPolicy::MeasuredHeadway, true).step(&input, &mut output);
        assert_eq!((output.quality, output.plan_len), (Quality::Full, 100));
        for (k, u) in output.plan_mps2[..100].iter().enumerate() {
            (e, ed, a) = (e + 0.1 * ed, ed + 0.1 * a, 0.8 * a + 0.2 * u);
            let t = t_l - 0.1 * (k + 1) as f64;
            if t > 1e-6 {
                assert!(e + t * ed + 0.5 * t * t * a + h > 0.0, "stage {k}");
            }
            assert!(e <= 12.0 + 1e-6);
            assert!((-4.9..=4.9).contains(u));
        }
        assert!(e.abs() < 1e-4 && ed.abs() < 1e-4 && a.abs() < 1e-4, "{e} {ed} {a}");
    }
}

fn light(phase: Phase, ends_in_s: f64, distance_m: f64) -> [Option<SignalAhead>; MAX_SIGNALS] {
    let mut signal = SignalAhead { id: 256, distance_m, count: 1, ..SignalAhead::default() };
    signal.intervals[0] = PhaseInterval { phase, ends_in_s };
    let mut all = [None; MAX_SIGNALS];
    all[0] = Some(signal);
    all
}
