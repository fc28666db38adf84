//! The paper's formulation against the reference closed loops and the published figures.

use controller::law::{
    Ego, Input, Law, MAX_SIGNALS, Output, Phase, PhaseInterval, Quality, SignalAhead, Target,
};
use controller::laws::cacc::config::Config;
use controller::laws::cacc::paper::PaperLaw;
use controller::laws::cacc::published::{Calibration, Runs, rows};
use controller::laws::cacc::scenes::{self, Recording, Scene};
use controller::laws::cacc::weights::{self, Weights};
use scenario::controller::{Solver, SpacingPolicy};

macro_rules! reference {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/cacc-", $name, ".csv"))
    };
}

fn law(set: Weights, policy: SpacingPolicy, light: bool) -> PaperLaw {
    let config = Config { spacing_policy: policy, weights: set, ..Config::default() };
    config.check().expect("the test's configuration is valid");
    let solver = config.create_solver();
    PaperLaw::new(&config, &set, light, solver).expect("a validated configuration is convex")
}

fn drive(scene: &Scene, set: Weights, light: bool) -> Recording {
    let policy = if scene.no_reverse {
        SpacingPolicy::MeasuredHeadway
    } else {
        SpacingPolicy::ConstantDistance
    };
    scenes::run(scene, &mut law(set, policy, light))
}

/// Largest differences in position, speed and request.
fn differences(ours: &Recording, reference: &str) -> [f64; 3] {
    let mut worst = [0.0_f64; 3];
    let mut count = 0;
    for (i, line) in reference.lines().skip(1).enumerate() {
        let field = |n: usize| -> f64 {
            line.split(',').nth(n).and_then(|f| f.parse().ok()).expect("a number in each column")
        };
        worst[0] = worst[0].max((ours.position_m[i] - field(1)).abs());
        worst[1] = worst[1].max((ours.speed_mps[i] - field(2)).abs());
        worst[2] = worst[2].max((ours.request_mps2[i] - field(4)).abs());
        count += 1;
    }
    assert_eq!(count, ours.time_s.len());
    worst
}

fn agrees(scene: &Scene, light: bool, reference: &str) {
    let [position, speed, request] = differences(&drive(scene, weights::JOINT, light), reference);
    println!("position {position:.1e} m, speed {speed:.1e} m/s, request {request:.1e} m/s²");
    assert!(position <= 0.05, "position differs by {position} m");
    assert!(speed <= 0.05, "speed differs by {speed} m/s");
}

#[test]
fn scenario_a_agrees_at_every_step() {
    agrees(&scenes::A, false, reference!("a-acc"));
    agrees(&scenes::A, true, reference!("a-cacc"));
}

#[test]
fn scenario_b_agrees_at_every_step() {
    agrees(&scenes::B, false, reference!("b-acc"));
    agrees(&scenes::B, true, reference!("b-cacc"));
}

#[test]
fn scenario_c_agrees_at_every_step() {
    agrees(&scenes::C, false, reference!("c-acc"));
    agrees(&scenes::C, true, reference!("c-cacc"));
}

#[test]
fn table_3_agrees_as_far_as_the_reference_solved_it() {
    let scene = scenes::table_3(scenes::TABLE_3_LEAD_JOINT_MPS2);
    agrees(&scene, false, reference!("table3-acc"));
    // From 2.1 s to 2.3 s the reference calls the light infeasible and follows without it; it has a
    // solution there, as the next test shows. The two loops part by these requests.
    let ours = drive(&scene, weights::JOINT, true);
    let reference = reference!("table3-cacc");
    let early = Recording { time_s: ours.time_s[..21].to_vec(), ..ours.clone() };
    let first: String = reference.lines().take(22).map(|line| format!("{line}\n")).collect();
    let [position, speed, request] = differences(&early, &first);
    assert!(position < 1e-3 && speed < 1e-3 && request < 1e-3, "{position} {speed} {request}");
    let [position, speed, _] = differences(&ours, reference);
    println!("position {position:.2} m, speed {speed:.2} m/s");
    assert!(position <= 0.35 && speed <= 0.45, "{position} m, {speed} m/s");
}

/// A measured state beyond the buffer makes the paper's program infeasible; the law still answers.
#[test]
fn a_state_beyond_the_buffer_is_relaxed() {
    let mut law = law(weights::JOINT, SpacingPolicy::MeasuredHeadway, false);
    let mut output = Output::default();
    let near = Target { track_id: 1, gap_m: 8.0, relative_speed_mps: -5.0, ..Target::default() };
    law.step(&behind(near), &mut output);
    assert_eq!((output.quality, output.plan_len), (Quality::Relaxed, 100));
    assert!(output.request_mps2() < -4.0, "{}", output.request_mps2());
}

#[test]
fn false_numbers_never_reach_the_command() {
    let mut law = law(weights::JOINT, SpacingPolicy::MeasuredHeadway, true);
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

/// The two solvers drive alike.
#[test]
fn clarabel_drives_scenario_a_as_riccati_does() {
    let config = Config { spacing_policy: SpacingPolicy::ConstantDistance, ..Config::default() };
    let clarabel = Config { solver: Solver::Clarabel, ..config }.create_solver();
    let mut law = PaperLaw::new(&config, &weights::JOINT, true, clarabel)
        .expect("a validated configuration is convex");
    let other = scenes::run(&scenes::A, &mut law);
    let ours = drive(&scenes::A, weights::JOINT, true);
    for (a, b) in ours.request_mps2.iter().zip(&other.request_mps2) {
        assert!((a - b).abs() < 1e-3, "{a} {b}");
    }
}

/// The light has a solution at 2.1 s and 2.2 s of Table 3: rolled out by hand, the plan meets every
/// constraint of the paper's program. At 2.1 s its margin is 17 mm.
#[test]
fn the_light_has_a_solution_where_the_reference_found_none() {
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
        law(weights::JOINT, SpacingPolicy::MeasuredHeadway, true).step(&input, &mut output);
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

/// Runs all scenarios, each with the weights `set` names for it.
fn failed_rows(
    set: impl Fn(char) -> Weights,
    t3_lead: f64,
    kind: Calibration,
) -> Vec<&'static str> {
    let table_3 = scenes::table_3(t3_lead);
    let runs = [
        drive(&scenes::A, set('A'), false),
        drive(&scenes::A, set('A'), true),
        drive(&scenes::B, set('A'), true),
        drive(&scenes::C, set('C'), false),
        drive(&scenes::C, set('C'), true),
        drive(&table_3, set('T'), false),
        drive(&table_3, set('T'), true),
    ];
    let table = rows(
        &Runs {
            a_acc: Some(runs[0].trajectory()),
            a_cacc: Some(runs[1].trajectory()),
            b_cacc: Some(runs[2].trajectory()),
            c_acc: Some(runs[3].trajectory()),
            c_cacc: Some(runs[4].trajectory()),
            t3_acc: Some(runs[5].trajectory()),
            t3_cacc: Some(runs[6].trajectory()),
        },
        kind,
    );
    for row in &table {
        println!(
            "{:26} {:8.3} {:8.3?} {:5.2} {}",
            row.id, row.paper, row.ours, row.tolerance, row.ok
        );
    }
    table.iter().filter(|row| !row.ok).map(|row| row.id).collect()
}

#[test]
fn joint_weights_reproduce_the_figures_but_one() {
    let failed =
        failed_rows(|_| weights::JOINT, scenes::TABLE_3_LEAD_JOINT_MPS2, Calibration::Joint);
    assert_eq!(failed, ["A.cacc.ed_min_mps"]);
}

#[test]
fn single_scenario_weights_reproduce_the_figures_but_three_durations() {
    let set = |scenario| match scenario {
        'A' => weights::SCENARIO_A,
        'C' => weights::SCENARIO_C,
        _ => weights::TABLE_3,
    };
    let failed = failed_rows(set, scenes::TABLE_3_LEAD_SINGLE_MPS2, Calibration::Single);
    let durations = ["A.cacc.negative_s", "B.cacc.positive_longer_s", "C.acc.saturated_down_s"];
    assert_eq!(failed, durations);
}
