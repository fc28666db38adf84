//! Laws of the user's own under names of their own, wherever a controller is named.

use serde_json::Value;
use std::process::ExitCode;
use system_tests::cases::{self, case};
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const ODD_LAW: &str = env!("CARGO_BIN_EXE_odd-law");

/// `--law name=odd-law words`.
fn law(name: &str, words: &str) -> String {
    format!("{name}={ODD_LAW} {words}")
}

/// The values of a key in the rows of a result.
fn values<'a>(result: &'a Value, rows: &str, key: &str) -> Vec<&'a Value> {
    let rows = result[rows].as_array().unwrap_or_else(|| panic!("no {rows}: {result}"));
    rows.iter().map(|row| &row[key]).collect()
}

/// The only law that is named drives. Its name stands in the summary, the page and the recording.
fn a_run_has_the_name_and_the_program() {
    let corner = Corner::new(PROGRAM);
    let mine = law("gentle", "follow");
    let run = ["run", "following", "--mode", "lockstep", "--duration", "4", "--law", &mine];
    let summary = corner.json(&[&run[..], &["--out", "out"]].concat());
    assert_eq!(
        (&summary["controller"], &summary["outcome"]),
        (&"gentle".into(), &"completed".into())
    );
    assert_eq!(summary["law"]["name"], "gentle");
    let program = corner.json(&["recording", "info", "out"])["programs"]["controller"].clone();
    assert_eq!(program["command"], format!("{ODD_LAW} follow"));
    let page = std::fs::read_to_string(corner.path().join("out/report.html")).expect("written");
    assert!(page.contains("gentle ("), "the page has the name");
    let inside = corner.json(&[&run[..], &["--in-process", "--digests"]].concat());
    let digests = |summary: &Value| summary["messages"]["control/command"]["digests"].clone();
    assert_eq!(digests(&summary), digests(&inside));
    let replayed = corner.json(&["recording", "replay", "out"]);
    assert_eq!(replayed["identical"], true, "{replayed}");
    corner.expect_nothing_left(&[]);
}

/// Two programs take part beside a law of timegap's own.
fn two_laws_are_compared_under_their_names() {
    let corner = Corner::new(PROGRAM);
    let (one, two) = (law("gentle", "follow"), law("eager", "follow --gain=0.8"));
    // The set speed is below the lead's, so that the gain on speed errors counts.
    let short =
        ["--set", "duration_s=6", "--set", "set_speed_mps=18", "--law", &one, "--law", &two];
    let named = ["compare", "following", "cut-in", "--controllers", "eager,acc-mpc,gentle"];
    let compared = corner.json(&[&named[..], &short].concat());
    let expected = ["eager", "acc-mpc", "gentle", "eager", "acc-mpc", "gentle"];
    assert_eq!(values(&compared, "rows", "controller"), expected);
    let figure = |row: usize| compared["rows"][row]["control"]["rms_jerk_mps3"].as_f64();
    assert_ne!(figure(0), figure(2), "they are two laws");
    corner.expect_nothing_left(&[]);
}

/// A law that a file declares, and a gain that is swept in its environment and its arguments.
fn a_file_declares_laws_and_a_sweep_turns_their_knobs() {
    let corner = Corner::new(PROGRAM);
    let scenario = format!(
        "schema_version = 1\nname = \"mine\"\nduration_s = 6\nset_speed_mps = 18\n[controller]\nname = \"gentle\"\n\
         [plant]\ninitial_speed_mps = 15\n\
         [laws.gentle]\ncommand = [{ODD_LAW:?}, \"follow\"]\nenv = {{ GAIN = 0.4 }}\n"
    );
    std::fs::write(corner.path().join("mine.toml"), scenario).expect("our own directory");
    let run = corner.json(&["run", "mine.toml", "--mode", "lockstep", "--no-record"]);
    assert_eq!(run["controller"], "gentle");
    let compared = corner.json(&["compare", "mine.toml", "--controllers", "gentle,acc-mpc"]);
    assert_eq!(values(&compared, "rows", "controller"), ["gentle", "acc-mpc"]);
    let jerks = |key: &str| -> Vec<f64> {
        let param = format!("laws.gentle.{key}=0.2,0.4,0.8");
        let swept = corner.json(&["sweep", "mine.toml", "--vary", &param]);
        let points = swept["points"].as_array().unwrap_or_else(|| panic!("{swept}"));
        let figure = |point: &Value| point["figures"]["rms_jerk_mps3"].as_f64();
        points.iter().map(|point| figure(point).unwrap_or_else(|| panic!("{point}"))).collect()
    };
    let by_environment = jerks("env.GAIN");
    assert!(by_environment.windows(2).all(|pair| pair[0] != pair[1]), "{by_environment:?}");
    assert_eq!(jerks("arguments.gain"), by_environment, "an argument does the same");
    corner.expect_nothing_left(&[]);
}

/// One program serves a worker's runs; what it keeps over resets shows in the repeated sample.
fn a_law_that_does_not_forget_is_found() {
    let corner = Corner::new(PROGRAM);
    let sweep = |law: &str| {
        let points = [
            "sweep",
            "following",
            "--duration",
            "3",
            "--vary",
            "set_speed_mps=20,21,22",
            "--verify-processes",
        ];
        corner.run(&[&points[..], &["--jobs", "1", "--json", "--law", law]].concat())
    };
    let forgets = sweep(&law("mine", "follow"));
    assert!(forgets.status.success(), "{}", text(&forgets));
    let remembers = sweep(&law("mine", "remember"));
    assert!(
        !remembers.status.success() && text(&remembers).contains("other bytes"),
        "{}",
        text(&remembers)
    );
    corner.expect_nothing_left(&[]);
}

/// The studies that make their scenarios.
fn standards_and_strings_take_them() {
    let corner = Corner::new(PROGRAM);
    let mine = law("gentle", "follow");
    let own = ["--controllers", "gentle", "--law", &mine];
    let judged = |words: &[&str]| -> Value {
        let output = corner.run(&[words, &own[..], &["--json"]].concat());
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
        serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output)))
    };
    let iso = judged(&["test", "iso15622"]);
    assert!(values(&iso, "rows", "law").iter().all(|law| **law == "gentle"), "{iso}");
    let r157 = judged(&["test", "r157", "--matrix", "cut-in", "--sample", "6"]);
    assert_eq!(r157["matrices"][0]["laws"][0]["law"], "gentle", "{r157}");
    std::fs::write(
        corner.path().join("mine.toml"),
        "schema_version = 1\nname = \"mine\"\nscenarios = [\"following\"]\nseeds = 2\nset = [\"duration_s=5\"]\n",
    )
    .expect("our own directory");
    let campaign = ["campaign", "mine.toml", "--law", &mine, "--out", "campaign"];
    let verdict = corner.json(&campaign);
    assert_eq!((&verdict["ok"], &verdict["runs"]), (&true.into(), &2.into()), "{verdict}");
    let records =
        std::fs::read_to_string(corner.path().join("campaign/runs.csv")).expect("written");
    assert!(records.contains("gentle") && !records.contains("cacc-mpc"), "{records}");
    let string = ["string", "following", "--vehicles", "4", "--duration", "15", "--law", &mine];
    let output =
        corner.run(&[&string[..], &["--controllers", "gentle,acc-mpc", "--json"]].concat());
    let string: Value =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output)));
    assert_eq!(
        values(&string, "vehicles", "controller"),
        ["gentle", "acc-mpc", "gentle", "acc-mpc"]
    );
    corner.expect_nothing_left(&[]);
}

fn what_is_no_law_is_refused_with_its_place() {
    let corner = Corner::new(PROGRAM);
    let mine = law("gentle", "follow");
    for (words, what) in [
        (&["run", "following", "--law", "gentle"][..], "expected NAME=COMMAND"),
        (&["run", "following", "--law", "acc-mpc=./x"], "a law of timegap's own"),
        (&["run", "following", "--law", "gentle=./no-such"], "there is no program `./no-such`"),
        (&["run", "following", "--law", &mine, "--law", &mine], "the name is given twice"),
        (
            &["compare", "following", "--controllers", "gentel", "--law", &mine],
            "did you mean `gentle`?",
        ),
        (&["compare", "following", "--controllers", "acc-mpc", "--law", &mine], "no run is driven"),
        (
            &["test", "iso15622", "--controllers", "acc-mpc", "--law", &mine],
            "no run is driven by it",
        ),
        (
            &["test", "signals", "--controllers", "acc-mpc", "--law", &mine],
            "no run is driven by it",
        ),
        (
            &["run", "following", "--controller", "acc-mpc", "--law", &mine],
            "no run is driven by it",
        ),
        (&["test", "iso15622", "--controllers", "gentle"], "unknown value `gentle`"),
        (
            &["run", "following", "--set", "laws.a.caller=true", "--controller", "a"],
            "is a function of the program",
        ),
    ] {
        let output = corner.run(words);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {}", text(&output));
        assert!(text(&output).contains(what), "{words:?}: {}", text(&output));
    }
    corner.expect_nothing_left(&[]);
}

fn main() -> ExitCode {
    cases::run(&[
        case("a_run_has_the_name_and_the_program", a_run_has_the_name_and_the_program),
        case("two_laws_are_compared_under_their_names", two_laws_are_compared_under_their_names),
        case(
            "a_file_declares_laws_and_a_sweep_turns_their_knobs",
            a_file_declares_laws_and_a_sweep_turns_their_knobs,
        ),
        case("a_law_that_does_not_forget_is_found", a_law_that_does_not_forget_is_found),
        case("standards_and_strings_take_them", standards_and_strings_take_them),
        case("what_is_no_law_is_refused_with_its_place", what_is_no_law_is_refused_with_its_place),
    ])
}
