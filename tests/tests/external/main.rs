//! A law in any language: the examples unchanged, and programs that misbehave in every way. Each has one clear
//! outcome and leaves nothing behind.

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::process::{Command, ExitCode};
use system_tests::cases::{self, case, needing};
use system_tests::{Corner, text, wait_for};

mod examples;

use examples::{
    c_compiler, notebooks, python3, the_c_example_drives, the_notebook_runs_as_it_is,
    the_python_example_drives,
};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const ODD_LAW: &str = env!("CARGO_BIN_EXE_odd-law");
const MY_CONTROLLER: &str = env!("CARGO_BIN_EXE_my-controller");

/// Options of a run with the program of these words.
fn by(words: &[&str]) -> Vec<String> {
    let words = serde_json::to_string(words).expect("texts");
    ["--controller", "external", "--set"]
        .map(str::to_owned)
        .into_iter()
        .chain([format!("controller.command={words}")])
        .collect()
}

/// `timegap run following` with that program and more options.
fn run_by<'a>(law: &'a [String], more: &[&'a str]) -> Vec<&'a str> {
    let law: Vec<&str> = law.iter().map(String::as_str).collect();
    [&["run", "following"], more, &law].concat()
}

const LOCKSTEP: [&str; 4] = ["--mode", "lockstep", "--duration", "6"];

fn controller(summary: &Value) -> Value {
    let services = summary["services"].as_array().expect("a list");
    let found = services.iter().find(|service| service["name"] == "controller");
    found.expect("it took part").clone()
}

/// Processes whose command line has `word`.
fn alive(word: &str) -> Vec<i32> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
        let Some(pid) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else {
            continue;
        };
        let line = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
        let mut words = line.split(|byte| *byte == 0);
        if pid != std::process::id() as i32 && words.any(|part| part == word.as_bytes()) {
            found.push(pid);
        }
    }
    found
}

/// A copy of the odd law under a unique name, so that its processes are distinct.
fn odd_law(corner: &Corner) -> String {
    let path = corner.path().join("odd-law");
    std::fs::copy(ODD_LAW, &path).expect("our own directory");
    path.to_string_lossy().into_owned()
}

fn gone(law: &str) {
    assert!(wait_for(|| alive(law).is_empty()), "orphans: {:?}", alive(law));
}

/// One program gives equal bytes in a group, in a repetition, and in one process; its name is reported.
fn the_same_bytes_by_pipe_in_a_group_and_in_one_process() {
    let corner = Corner::new(PROGRAM);
    let law = odd_law(&corner);
    let command = by(&[&law, "follow"]);
    let run = |more: &[&str]| corner.json(&run_by(&command, &[&LOCKSTEP[..], more].concat()));
    let (one, two) = (run(&["--out", "one"]), run(&["--no-record"]));
    let inside = run(&["--in-process", "--digests"]);
    for other in [&two, &inside] {
        for topic in ["control/command", "control/diagnostics", "vehicle/odometry"] {
            let digests = |summary: &Value| summary["messages"][topic]["digests"].clone();
            assert_eq!(digests(&one), digests(other), "{topic}");
        }
    }
    assert_eq!((&one["outcome"], &one["controller"]), (&"completed".into(), &"external".into()));
    let program = &controller(&one)["program"];
    assert_eq!(program["command"], format!("{law} follow"));
    let sum = Command::new("sha256sum").arg(&law).output().expect("coreutils");
    let sum = String::from_utf8_lossy(&sum.stdout).into_owned();
    assert_eq!(program["sha256"].as_str(), sum.split_whitespace().next());
    assert_eq!(controller(&inside)["program"], *program);
    assert_eq!(one["timing"]["law_program"]["starts"], 1);
    let info = corner.json(&["recording", "info", "one"]);
    assert_eq!(info["programs"]["controller"], *program);
    let page = std::fs::read_to_string(corner.path().join("one/report.html")).expect("written");
    assert!(page.contains("external (") && page.contains("odd-law follow"), "the page says who");
    // The program runs again with equal answers.
    let replayed = corner.json(&["recording", "replay", "one"]);
    assert_eq!(replayed["identical"], true, "{replayed}");
    assert_eq!(replayed["replayed_program"]["sha256"], program["sha256"]);
    gone(&law);
    corner.expect_nothing_left(&[]);
}

/// A wrong or missing first answer prevents the run: one error, status 2.
fn what_is_no_law_is_refused() {
    let corner = Corner::new(PROGRAM);
    let law = odd_law(&corner);
    for in_process in [false, true] {
        for (manner, words) in [
            ("garbage", ["hello, world", "expected"]),
            ("flood", ["yyyy", "expected"]),
            ("exit", ["exit status: 3", "I leave at once"]),
            ("die", ["exit status: 7", "I die at question 1"]),
            ("nan", ["request_mps2 = NaN", "expected a finite number"]),
            ("sleep", ["no answer within 0.5 s", "odd-law sleep"]),
        ] {
            let command = by(&[&law, manner]);
            let patience = ["--set", "controller.external.patience_s=0.5"];
            let inside: &[&str] = if in_process { &["--in-process"] } else { &[] };
            let output = corner.run(&run_by(
                &command,
                &[&LOCKSTEP[..], &patience, inside, &["--out", "o"]].concat(),
            ));
            let said = text(&output);
            assert_eq!(output.status.code(), Some(2), "{manner}: {said}");
            for word in words {
                assert!(said.contains(word), "{manner} should say `{word}`: {said}");
            }
            assert_eq!(said.lines().filter(|l| l.starts_with("error")).count(), 1, "{said}");
            assert!(!corner.path().join("o").exists(), "nothing of a run that never was");
            gone(&law);
            corner.expect_nothing_left(&[]);
        }
    }
}

/// A command without a program is shown at its key.
fn a_command_that_is_none() {
    let corner = Corner::new(PROGRAM);
    let scenario = |line: &str| {
        let file = format!(
            "schema_version = 1\nname = \"mine\"\n[controller]\nname = \"external\"\n{line}"
        );
        std::fs::write(corner.path().join("mine.toml"), file).expect("our own directory");
        let output = corner.run(&["run", "mine.toml"]);
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        text(&output)
    };
    assert!(scenario("").contains("mine.toml:3"), "the table where the key is missing");
    let said = scenario("command = [\"./no-such-law\"]\n");
    assert!(said.contains("mine.toml:5:11") && said.contains("./no-such-law"), "{said}");
    let said = scenario("command = \"python3 law.py\"\n");
    assert!(said.contains("mine.toml:5:11"), "{said}");
    let said = scenario("command = [\"sh\"]\nexternal = { patience = 3 }\n");
    assert!(said.contains("mine.toml:6:14") && said.contains("patience_s"), "{said}");
    corner.expect_nothing_left(&[]);
}

/// In simulated time a failing law ends the run, since a repetition would differ.
fn in_simulated_time_a_failure_ends_the_run() {
    let corner = Corner::new(PROGRAM);
    let law = odd_law(&corner);
    for (manner, word) in [
        ("die", "I die at question 20"),
        ("garbage", "hello, world"),
        ("flood", "yyyy"),
        ("twice", "expected"),
        ("sleep", "no answer within 0.5 s"),
    ] {
        let command = by(&[&law, manner, "20"]);
        let patience = ["--set", "controller.external.patience_s=0.5"];
        for inside in [&[][..], &["--in-process"]] {
            let more = [&LOCKSTEP[..], &patience, inside, &["--json", "--no-record"]].concat();
            let output = corner.run(&run_by(&command, &more));
            assert_eq!(output.status.code(), Some(1), "{manner}: {}", text(&output));
            let summary: Value = serde_json::from_slice(&output.stdout).expect("a summary");
            let why = summary["aborted_because"].as_str().unwrap_or_default();
            assert!(why.contains(word) && why.contains("odd-law"), "{manner}: {why}");
            gone(&law);
            corner.expect_nothing_left(&[]);
        }
    }
}

/// The backup replaces an answer that no vehicle can follow, in both clocks.
fn an_answer_that_is_no_number_is_refused_in_its_cycle() {
    let corner = Corner::new(PROGRAM);
    let law = odd_law(&corner);
    let command = by(&[&law, "nan", "20"]);
    let more = [&LOCKSTEP[..], &["--json", "--out", "out"]].concat();
    let output = corner.run(&run_by(&command, &more));
    let summary: Value = serde_json::from_slice(&output.stdout).expect("a summary");
    assert_eq!((output.status.code(), &summary["outcome"]), (Some(1), &"driven_by_backup".into()));
    let count = |key: &str| summary["law"][key].as_u64().unwrap_or_else(|| panic!("{summary}"));
    assert_eq!(count("cycles"), count("answered") + count("backup"), "{summary}");
    assert_eq!((count("refused"), count("late")), (count("backup"), 0), "{summary}");
    let page = std::fs::read_to_string(corner.path().join("out/report.html")).expect("written");
    assert!(page.contains("cycles by the backup, not by"), "the page says who drove");
    assert!(summary["timing"]["law_program"]["refused"].as_u64() > Some(10), "{summary}");
    assert!(summary["timing"]["backup_cycles"].as_u64() > Some(10), "{summary}");
    let failure = summary["timing"]["law_program"]["failures"][0].as_str().unwrap_or_default();
    assert!(failure.contains("request_mps2 = NaN"), "{failure}");
    // A few such answers leave the drive to the law, and the scenario can allow more.
    for (first, allowed) in [("58", &[][..]), ("20", &["--set", "require.max_backup_share=1"])] {
        let command = by(&[&law, "nan", first]);
        let more = [&LOCKSTEP[..], &["--no-record"], allowed].concat();
        assert_eq!(corner.json(&run_by(&command, &more))["outcome"], "completed");
    }
}

/// In real time the backup drives while the law is late, and a failed law is replaced.
fn in_real_time_the_backup_drives_and_the_law_is_replaced() {
    let corner = Corner::new(PROGRAM);
    let law = odd_law(&corner);
    for (manner, late, replaced) in [
        ("slow", true, false),
        ("sleep", true, true),
        ("die", false, true),
        ("garbage", false, true),
        ("flood", false, true),
    ] {
        let command = by(&[&law, manner, "10"]);
        let more = ["--duration", "3", "--no-record", "--set", "require.max_backup_share=1"];
        let summary = corner.json(&run_by(&command, &more));
        assert_eq!(summary["outcome"], "completed", "{manner}: {summary}");
        let program = &summary["timing"]["law_program"];
        let count = |key: &str| program[key].as_u64().unwrap_or_default();
        assert!(count("answers") > 0, "{manner}: {program}");
        assert!(!late || count("late") > 0, "{manner}: {program}");
        assert_eq!(count("starts") > 1, replaced, "{manner}: {program}");
        let failures = program["failures"].as_array().expect("a list");
        assert_eq!(!failures.is_empty(), replaced, "{manner}: {program}");
        assert_eq!(controller(&summary)["restarts"], 0, "{manner}: the service itself went on");
        gone(&law);
    }
    corner.expect_nothing_left(&[]);
}

/// The law ends with its controller, however that ends.
fn no_orphan_when_the_controller_or_all_of_it_is_killed() {
    let corner = Corner::new(PROGRAM);
    let law = odd_law(&corner);
    let command = by(&[&law, "stays"]);
    let more = ["--duration", "600", "--out", "out", "--no-record"];
    let child = corner.start(&run_by(&command, &more));
    assert!(wait_for(|| corner.path().join("out/live.json").exists()), "never drove");
    let roots = corner.roots();
    let own = || -> Vec<i32> {
        let services = corner.processes();
        alive(&law).into_iter().filter(|pid| services.iter().all(|(p, _)| p != pid)).collect()
    };
    let launcher = i32::try_from(child.id()).expect("fits");
    let laws = || own().into_iter().filter(|pid| *pid != launcher).collect::<Vec<_>>();
    let before = laws();
    assert_eq!(before.len(), 1, "one law");
    let kill = |pid: i32| {
        let pid = Pid::from_raw(pid).expect("a process id");
        kill_process(pid, Signal::KILL).expect("our own process");
    };
    kill(corner.wait_for_process("timegap-controller"));
    assert!(wait_for(|| laws().len() == 1 && laws() != before), "another one: {:?}", laws());
    // The launcher dies: the services notice it, and nothing stays.
    kill(launcher);
    let _ = child.wait_with_output();
    gone(&law);
    corner.expect_nothing_left(&roots);
}

/// A controller program is reported by its name, and replayed by its program only.
fn a_controller_program_is_told_and_replayed() {
    let corner = Corner::new(PROGRAM);
    let service = format!("controller={MY_CONTROLLER}");
    let run = ["run", "following", "--mode", "lockstep", "--duration", "4", "--out", "out"];
    let summary = corner.json(&[&run[..], &["--service", &service]].concat());
    assert_eq!(summary["controller"], "two-seconds", "{summary}");
    assert_eq!(controller(&summary)["program"]["command"], MY_CONTROLLER);
    let refused = corner.run(&["recording", "replay", "out"]);
    assert_eq!(refused.status.code(), Some(2), "{}", text(&refused));
    assert!(text(&refused).contains("--service controller=PROGRAM"), "{}", text(&refused));
    let replayed = corner.json(&["recording", "replay", "out", "--service", &service]);
    assert_eq!(replayed["identical"], true, "{replayed}");
    let other = corner.run(&["recording", "replay", "out", "--service", "plant=/bin/true"]);
    assert_eq!(other.status.code(), Some(2), "{}", text(&other));
    corner.expect_nothing_left(&[]);
}

/// Batches and comparisons drive it, also at 1 kHz.
fn it_compares_and_sweeps_and_runs_at_one_kilohertz() {
    let corner = Corner::new(PROGRAM);
    let law = odd_law(&corner);
    let key = format!("controller.command=[\"{law}\"]");
    let short = ["--set", "duration_s=4", "--set", &key];
    let compared =
        [&["compare", "following", "--controllers", "acc-mpc,external"], &short[..]].concat();
    let rows = corner.json(&compared);
    assert_eq!(rows["rows"].as_array().map(Vec::len), Some(2), "{rows}");
    let sweep = ["sweep", "following", "--controller", "external", "--vary"];
    let swept = corner.json(&[&sweep[..], &["set_speed_mps=20..24/2"], &short].concat());
    assert!(swept["ok"] != false, "{swept}");
    let command = by(&[&law]);
    let fast = ["--mode", "lockstep", "--duration", "2", "--set", "controller.period_ms=1"];
    let summary = corner.json(&run_by(&command, &[&fast[..], &["--no-record"]].concat()));
    assert_eq!(summary["outcome"], "completed", "{summary}");
    assert!(summary["timing"]["law_program"]["answers"].as_u64() > Some(1500), "{summary}");
    gone(&law);
}

fn main() -> ExitCode {
    cases::run(&[
        case(
            "the_same_bytes_by_pipe_in_a_group_and_in_one_process",
            the_same_bytes_by_pipe_in_a_group_and_in_one_process,
        ),
        case("what_is_no_law_is_refused", what_is_no_law_is_refused),
        case("a_command_that_is_none", a_command_that_is_none),
        case("in_simulated_time_a_failure_ends_the_run", in_simulated_time_a_failure_ends_the_run),
        case(
            "an_answer_that_is_no_number_is_refused_in_its_cycle",
            an_answer_that_is_no_number_is_refused_in_its_cycle,
        ),
        case(
            "in_real_time_the_backup_drives_and_the_law_is_replaced",
            in_real_time_the_backup_drives_and_the_law_is_replaced,
        ),
        case(
            "no_orphan_when_the_controller_or_all_of_it_is_killed",
            no_orphan_when_the_controller_or_all_of_it_is_killed,
        ),
        case(
            "a_controller_program_is_told_and_replayed",
            a_controller_program_is_told_and_replayed,
        ),
        case(
            "it_compares_and_sweeps_and_runs_at_one_kilohertz",
            it_compares_and_sweeps_and_runs_at_one_kilohertz,
        ),
        needing(python3, "the_python_example_drives", the_python_example_drives),
        needing(notebooks, "the_notebook_runs_as_it_is", the_notebook_runs_as_it_is),
        needing(c_compiler, "the_c_example_drives", the_c_example_drives),
    ])
}
