//! Signals by frames: roadside units, air, on-board unit and controller in whole runs.

use report::summary::Summary;
use runtime::Mode;
use scenario::{Overrides, Scenario};
use std::time::Duration;
use supervise::in_process;
use supervise::report::Outcome;
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// `corridor` with additional keys, which must be new.
fn corridor(keys: &str) -> Scenario {
    let builtin = scenario::builtin::find("corridor").expect("it is built in").text;
    let text = format!("{builtin}\n{keys}");
    let check = &controller::laws::check;
    Scenario::parse_with("corridor", &text, &Overrides::new(), check).expect("a right scenario")
}

fn drive(scenario: &Scenario) -> Summary {
    let group = in_process::run(scenario).expect("it runs");
    Summary::new(scenario, Mode::Lockstep, &group, Duration::ZERO)
}

fn verdict(summary: &Summary, name: &str) -> u64 {
    summary.radio.as_ref().expect("frames were on air").verdicts[name]
}

/// Time on a degradation level of the controller, s.
fn on(summary: &Summary, level: &str) -> f64 {
    summary.rungs["controller"].time_s.get(level).copied().unwrap_or(0.0)
}

#[test]
fn a_drive_by_frames_is_the_drive_by_structs() {
    let frames = drive(&corridor(""));
    let mut direct = corridor("");
    direct.v2x.radio = scenario::radio::Radio::Direct;
    let direct = drive(&direct);
    assert!(direct.radio.is_none());
    for summary in [&frames, &direct] {
        assert_eq!(summary.outcome, Outcome::Completed);
        assert!(on(summary, "signals-lost") < 0.5, "{:?}", summary.rungs);
    }
    let crossed = |summary: &Summary| summary.control.figures.stop_line_crossing_s.expect("it did");
    assert!((crossed(&frames) - crossed(&direct)).abs() < 0.5);
    let radio = frames.radio.as_ref().expect("frames were on air");
    // Timing of an intersection is unknown until its first map.
    let used = verdict(&frames, "accepted") + verdict(&frames, "unknown_intersection");
    assert_eq!((used, radio.left_out), (radio.frames, 0), "{:?}", radio.verdicts);
    assert!(radio.frames > 500 && radio.cams_sent > 200, "{radio:?}");
    let reaction = frames.timing.signal_reaction_us.expect("signals changed ahead");
    assert!(reaction.count >= 2, "{reaction:?}");
}

#[test]
fn a_group_of_processes_says_the_same_as_one_process() {
    let corner = Corner::new(PROGRAM);
    let run = |extra: &[&str]| {
        let own = ["run", "corridor", "--mode", "lockstep", "--duration", "30"];
        let summary = corner.json(&[&own, extra].concat());
        let verdicts = summary["radio"]["verdicts"].clone();
        (summary["messages"].clone(), verdicts)
    };
    let (memory, shared) =
        (run(&["--in-process", "--digests", "--no-record"]), run(&["--no-record"]));
    assert!(!memory.0["radio/frames"]["digests"]["v2x-sim"].is_null(), "{}", memory.0);
    assert_eq!(memory, shared);
}

#[test]
fn a_radio_that_is_cut_takes_the_controller_down_the_ladder_and_back() {
    let cut = drive(&corridor("[v2x.air]\nfrom_s = 8\nfor_s = 5\nloss_probability = 1\n"));
    assert_eq!(cut.outcome, Outcome::Completed);
    let lost_s = on(&cut, "signals-lost");
    assert!((4.0..7.0).contains(&lost_s), "{lost_s}");
    let dropped = "[[faults]]\nkind = \"drop\"\ntopic = \"radio/frames\"\nat_s = 8\nfor_s = 5\n";
    let dropped = drive(&corridor(dropped));
    assert_eq!(dropped.outcome, Outcome::Completed);
    assert!((4.0..7.0).contains(&on(&dropped, "signals-lost")));
}

#[test]
fn whatever_is_wrong_on_air_is_counted_and_no_red_light_is_run() {
    let cases = [
        ("[v2x.air]\nduplicate_probability = 0.2\n", "duplicated"),
        ("[v2x.air]\nreorder_probability = 0.2\n", "out_of_order"),
        ("[v2x.air]\ntruncate_probability = 0.2\n", "malformed"),
        ("[v2x.air]\nbit_flip_probability = 0.2\n", "contradicting"),
        ("[v2x.air]\nreplay_probability = 0.2\nreplay_age_s = 60\n", "too_old"),
        ("[v2x.air]\ndelay_ms = 800\n", "too_old"),
        ("[v2x.unit]\ncontradicted_from_s = 5\n", "contradicting"),
        ("[v2x.unit]\nmap_changes_at_s = 10\nmap_shift_m = -5\n", "contradicting"),
        (
            "[v2x.unit]\nmap_changes_at_s = 10\nmap_changes_of = 1\nmap_shift_m = 15\n",
            "contradicting",
        ),
        ("[v2x.unit]\ncountdown_wrong_from_s = 10\ncountdown_jump_s = 3\n", "contradicting"),
        ("[v2x.unit]\ncountdown_wrong_from_s = 10\ncountdown_jump_s = -3\n", "contradicting"),
        ("[v2x.unit]\nclock_offset_ms = 2000\n", "too_old"),
        ("[v2x.obu]\nclock_offset_ms = -2000\n", "too_old"),
        ("[v2x.obu]\nstation_id = 100001\n", "same_station_id"),
    ];
    for (keys, name) in cases {
        let summary = drive(&corridor(keys));
        assert!(verdict(&summary, name) > 0, "{keys}: {:?}", summary.radio);
        // A unit that seems to be the vehicle itself is not known.
        let is_heard = name != "same_station_id";
        assert!(summary.outcome != Outcome::RedLight || !is_heard, "{keys}: {:?}", summary.outcome);
    }
}

#[test]
fn a_killed_on_board_unit_is_replaced_and_the_drive_goes_on() {
    let corner = Corner::new(PROGRAM);
    let builtin = scenario::builtin::find("corridor").expect("it is built in").text;
    let kill = "\n[[faults]]\nkind = \"kill\"\nservice = \"obu\"\nat_s = 1\n";
    std::fs::write(corner.path().join("kill.toml"), format!("{builtin}{kill}")).expect("ours");
    let run = ["run", "kill.toml", "--mode", "realtime", "--duration", "4", "--no-record"];
    let summary = corner.json(&run);
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let services = summary["services"].as_array().expect("a list");
    let obu = services.iter().find(|service| service["name"] == "obu").expect("it is there");
    assert_eq!(obu["restarts"], 1, "{summary}");
    let levels = &summary["rungs"]["controller"]["time_s"];
    assert!(levels["signals-lost"].as_f64().is_some_and(|s| s > 0.5), "{levels}");
    corner.expect_nothing_left(&[]);
}

#[test]
fn keys_about_frames_without_frames_are_refused() {
    let corner = Corner::new(PROGRAM);
    for (key, expected) in [
        ("v2x.air.loss_probability=0.5", "v2x.air has no effect without frames"),
        ("v2x.obu.max_age_ms=100", "v2x.obu has no effect without frames"),
        ("v2x.radio=smoke", "direct"),
    ] {
        let output = corner.run(&["run", "cacc-a", "--set", key]);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(expected), "{}", text(&output));
    }
}
