//! The paper's formulation against the reference closed loops and the published figures.

use papers::cacc::{self, Calibration, PRINTED, Recording, Runs, SCENES, Scene, Set};
use papers::runner::Driven;
use scenario::Setting;

macro_rules! reference {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/cacc-", $name, ".csv"))
    };
}

/// ACC and CACC in the scene.
fn drive(scene: &Scene, set: &[Setting]) -> [Recording; 2] {
    let driven = cacc::both_laws(scene, set, &|name, set| Driven::alone(name, set));
    driven.expect("the scenario drives to its end").each_ref().map(Recording::of)
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

fn agrees(ours: &Recording, reference: &str) {
    let [position, speed, request] = differences(ours, reference);
    println!("position {position:.1e} m, speed {speed:.1e} m/s, request {request:.1e} m/s²");
    assert!(position <= 0.05, "position differs by {position} m");
    assert!(speed <= 0.05, "speed differs by {speed} m/s");
}

#[test]
fn scenario_a_agrees_at_every_step() {
    let [acc, cacc] = drive(&SCENES[0], &[]);
    agrees(&acc, reference!("a-acc"));
    agrees(&cacc, reference!("a-cacc"));
}

#[test]
fn scenario_b_agrees_at_every_step() {
    let [acc, cacc] = drive(&SCENES[1], &[]);
    agrees(&acc, reference!("b-acc"));
    agrees(&cacc, reference!("b-cacc"));
}

#[test]
fn scenario_c_agrees_at_every_step() {
    let [acc, cacc] = drive(&SCENES[2], &[]);
    agrees(&acc, reference!("c-acc"));
    agrees(&cacc, reference!("c-cacc"));
}

#[test]
fn table_3_agrees_as_far_as_the_reference_solved_it() {
    let [acc, ours] = drive(&SCENES[3], &[]);
    agrees(&acc, reference!("table3-acc"));
    // From 2.1 s to 2.3 s the reference calls the light infeasible and follows without it. There is
    // a solution, as the shipped solver shows. The two loops part by these requests.
    let reference = reference!("table3-cacc");
    let early = Recording { time_s: ours.time_s[..21].to_vec(), ..ours.clone() };
    let first: String = reference.lines().take(22).map(|line| format!("{line}\n")).collect();
    let [position, speed, request] = differences(&early, &first);
    assert!(position < 1e-3 && speed < 1e-3 && request < 1e-3, "{position} {speed} {request}");
    let [position, speed, _] = differences(&ours, reference);
    println!("position {position:.2} m, speed {speed:.2} m/s");
    assert!(position <= 0.35 && speed <= 0.45, "{position} m, {speed} m/s");
}

/// The two solvers drive alike.
#[test]
fn clarabel_drives_scenario_a_as_riccati_does() {
    let [_, ours] = drive(&SCENES[0], &[]);
    let [_, other] = drive(&SCENES[0], &[Setting::new("controller.solver", "clarabel")]);
    for (a, b) in ours.request_mps2.iter().zip(&other.request_mps2) {
        assert!((a - b).abs() < 1e-3, "{a} {b}");
    }
}

/// Ids of the printed numbers outside their tolerance.
fn failed_rows(set: Set, kind: Calibration) -> Vec<&'static str> {
    let runs = SCENES.iter().map(|scene| (scene, drive(scene, &set.settings(scene))));
    let runs = Runs(runs.collect());
    let failed = PRINTED.iter().filter(|figure| !figure.row(&runs, kind).ok);
    failed.map(|figure| figure.id).collect()
}

#[test]
fn joint_weights_reproduce_the_figures_but_one() {
    assert_eq!(failed_rows(Set::Joint, Calibration::Joint), ["A.cacc.ed_min_mps"]);
}

#[test]
fn single_scenario_weights_reproduce_the_figures_but_two_durations() {
    let durations = ["A.cacc.negative_s", "B.cacc.positive_longer_s"];
    assert_eq!(failed_rows(Set::Fitted, Calibration::Fitted), durations);
}
