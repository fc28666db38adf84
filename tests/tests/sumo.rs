//! SUMO's traffic around the ego: repeatable bytes, the lights, and the ends of a program that misbehaves.

use messages::{AnnouncedMotion, AnnouncedMotions, Odometry};
use recorder::Recording;
use serde_json::Value;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use system_tests::cases::{self, Needed, needing};
use system_tests::{Corner, python, status_of, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const GRID: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/sumo/grid.sumocfg");

fn always() -> Needed {
    Ok(())
}

fn interpreter() -> Result<PathBuf, system_tests::missing::Missing> {
    python::SUMO.interpreter(Path::new(env!("CARGO_TARGET_TMPDIR")))
}

fn pypi() -> Needed {
    interpreter().map(|_| ())
}

/// A command that finds SUMO in the environment of the tests.
fn with_sumo(corner: &Corner, arguments: &[&str]) -> Command {
    let python = interpreter().expect("looked for");
    let scripts = python.parent().expect("bin").to_owned();
    let path = std::env::var("PATH").unwrap_or_default();
    let mut command = corner.command(arguments);
    command.env("PATH", format!("{}:{path}", scripts.display())).env_remove("SUMO_HOME");
    command
}

/// Processes of SUMO that this test's configuration has.
fn sumos(parent_words: &str) -> Vec<i32> {
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let pids = entries.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok());
    let is_ours = |pid: &i32| {
        let line = std::fs::read(format!("/proc/{pid}/cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line).replace('\0', " ");
        line.contains("--remote-port") && line.contains(parent_words)
    };
    pids.filter(is_ours).collect()
}

/// Times that a process has waited.
fn waits(pid: i32) -> u64 {
    status_of(pid, "voluntary_ctxt_switches").unwrap_or(0)
}

/// A copy of the example, so that its processes are this test's.
fn own_grid(corner: &Corner) -> String {
    for file in ["grid.net.xml", "grid.rou.xml", "grid.sumocfg"] {
        let from = Path::new(GRID).with_file_name(file);
        std::fs::copy(from, corner.path().join(file)).expect("a file of the example");
    }
    corner.path().join("grid.sumocfg").display().to_string()
}

fn drive(corner: &Corner, more: &[&str]) -> Value {
    let grid = own_grid(corner);
    let usual =
        ["run", &grid, "--ego", "through", "--mode", "lockstep", "--duration", "25", "--json"];
    let mut command = with_sumo(corner, &[&usual[..], more].concat());
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{}", text(&output));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn digests(summary: &Value) -> Vec<(String, Value)> {
    let messages = summary["messages"].as_object().expect("a table").iter();
    messages.map(|(topic, one)| (topic.clone(), one["digests"].clone())).collect()
}

fn the_same_seed_gives_the_same_bytes_in_one_process_and_in_a_group() {
    let corner = Corner::new(PROGRAM);
    let begin = ["--set", "traffic.begin_s=30"];
    let inside = ["--in-process", "--digests", "--out", "a"];
    let first = drive(&corner, &[&begin[..], &inside].concat());
    let group = drive(&corner, &[&begin[..], &["--out", "b", "--no-record"]].concat());
    assert_eq!(digests(&first), digests(&group));
    let other = drive(&corner, &[&begin[..], &inside[..3], &["c", "--seed", "2"]].concat());
    assert_ne!(digests(&first), digests(&other), "another seed is other traffic");
    assert!(first["messages"]["truth/lights"]["sent"].as_u64() > Some(400), "{first}");
    assert!(sumos(&corner.path().display().to_string()).is_empty(), "SUMO is gone");
}

/// The summaries of two egos that share one SUMO, with CAMs on air.
fn drive_two(corner: &Corner, grid: &str, out: &str, more: &[&str]) -> [Value; 2] {
    let usual = ["run", grid, "--ego", "through", "--egos", "2", "--mode", "lockstep"];
    let rest = ["--duration", "15", "--set", "traffic.begin_s=30", "--out", out];
    let frames = ["--set", "v2x.radio=\"frames\""];
    let mut command = with_sumo(corner, &[&usual[..], &rest, &frames, more].concat());
    let output = command.output().expect("it starts");
    assert!(output.status.success(), "{}", text(&output));
    ["ego-1", "ego-2"].map(|ego| {
        let file = corner.path().join(out).join(ego).join("summary.json");
        serde_json::from_slice(&std::fs::read(file).expect("a summary each")).expect("JSON")
    })
}

fn two_egos_share_one_sumo_and_repeat_their_bytes() {
    let corner = Corner::new(PROGRAM);
    let grid = own_grid(&corner);
    let inside = ["--in-process", "--digests"];
    let first = drive_two(&corner, &grid, "a", &inside);
    assert_ne!(digests(&first[0]), digests(&first[1]));
    let again = drive_two(&corner, &grid, "b", &inside);
    let group = drive_two(&corner, &grid, "c", &[]);
    for (ego, number) in first.iter().zip(0..) {
        assert_eq!(digests(ego), digests(&again[number]), "ego {number}");
        assert_eq!(digests(ego), digests(&group[number]), "ego {number}, process groups");
    }
    assert!(sumos(&corner.path().display().to_string()).is_empty(), "SUMO is gone");
    corner.expect_nothing_left(&[]);
    // The second ego receives the first one's CAMs: what that one's odometry had.
    let [first, second] = ["c/ego-1", "c/ego-2"].map(|run| recording(&corner, run));
    let sent: Vec<Odometry> = first.messages::<Odometry>().map(|timed| timed.message).collect();
    let motions = motions(&second);
    let received: Vec<_> = motions.iter().flatten().collect();
    assert!(received.len() > 100, "{}", received.len());
    for motion in received {
        assert_eq!(motion.station_id, 4711, "the first one's");
        let is_its = |own: &Odometry| {
            (own.speed_mps - motion.speed_mps).abs() < 0.3
                && (own.acceleration_mps2 - motion.acceleration_mps2).abs() < 0.2
        };
        assert!(sent.iter().any(is_its), "{motion:?}");
    }
}

fn recording(corner: &Corner, run: &str) -> Recording {
    Recording::open(&corner.path().join(run)).expect("a recording")
}

/// The motions that an ego received, of each cycle.
fn motions(run: &Recording) -> Vec<Vec<AnnouncedMotion>> {
    let messages = run.messages::<AnnouncedMotions>();
    messages.map(|timed| timed.message.motions().to_vec()).collect()
}

fn a_killed_sumo_ends_both_egos() {
    let corner = Corner::new(PROGRAM);
    let grid = own_grid(&corner);
    let words = corner.path().display().to_string();
    let usual = ["run", &grid, "--ego", "through", "--egos", "2", "--duration", "3000"];
    let rest = ["--out", "k"];
    let child = with_sumo(&corner, &[&usual[..], &rest].concat()).spawn().expect("it starts");
    let drives = || corner.path().join("k/ego-2/live.json").exists();
    assert!(wait_for(drives), "both drive");
    for pid in sumos(&words) {
        let _ = Command::new("kill").args(["-KILL", &pid.to_string()]).status();
    }
    let output = child.wait_with_output().expect("our child");
    assert_eq!(output.status.code(), Some(3), "{}", text(&output));
    assert!(wait_for(|| sumos(&words).is_empty()), "SUMO is gone");
    corner.expect_nothing_left(&[]);
}

/// The process that has a seat at a shared SUMO, of this test's corner.
fn run_of_ego(words: &str, number: u32) -> Option<i32> {
    let seat = format!(" {number}\0");
    let is_its = |pid: &i32| {
        let of = |file: &str| std::fs::read(format!("/proc/{pid}/{file}")).unwrap_or_default();
        let (line, kept) = (of("cmdline"), of("environ"));
        let (line, kept) = (String::from_utf8_lossy(&line), String::from_utf8_lossy(&kept));
        let given = kept.split_once("TIMEGAP_SUMO=").map(|(_, rest)| rest);
        let is_seated =
            given.is_some_and(|rest| rest.trim_start_matches(char::is_numeric).starts_with(&seat));
        is_seated && line.contains("\0run\0") && line.contains(words)
    };
    let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.file_name().to_str()?.parse::<i32>().ok()).find(is_its)
}

fn a_killed_ego_leaves_the_net_to_the_other() {
    let corner = Corner::new(PROGRAM);
    let grid = own_grid(&corner);
    let words = corner.path().display().to_string();
    let usual = ["run", &grid, "--ego", "through", "--egos", "2", "--duration", "15"];
    let child = with_sumo(&corner, &[&usual[..], &["--out", "k"]].concat()).spawn();
    let child = child.expect("it starts");
    assert!(wait_for(|| corner.path().join("k/ego-2/live.json").exists()), "both drive");
    // SUMO waits for each step: after sixty waits both have driven for seconds.
    let steps = || sumos(&words).into_iter().map(waits).sum::<u64>();
    let begun = steps();
    assert!(wait_for(|| steps() >= begun + 60), "it is stepped");
    let run = run_of_ego(&words, 2).expect("it drives").to_string();
    let _ = Command::new("kill").args(["-KILL", &run]).status();
    let output = child.wait_with_output().expect("our child");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    assert_eq!(said.matches("ended the run of ego 2; the others went on").count(), 1, "{said}");
    let summary = std::fs::read(corner.path().join("k/ego-1/summary.json")).expect("it went on");
    let summary: Value = serde_json::from_slice(&summary).expect("JSON");
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let received = motions(&recording(&corner, "k/ego-1"));
    assert!(received.iter().any(|motions| motions.len() == 1), "it sent before");
    assert_eq!(received.last().map(Vec::len), Some(0), "and not after");
    assert!(wait_for(|| sumos(&words).is_empty()), "SUMO is gone");
}

fn lights_come_as_frames_too() {
    let corner = Corner::new(PROGRAM);
    let frames = ["--in-process", "--out", "f", "--set", "v2x.radio=\"frames\""];
    let summary = drive(&corner, &frames);
    assert!(summary["radio"]["verdicts"]["accepted"].as_u64() > Some(100), "{}", summary["radio"]);
}

fn a_program_that_ends_or_hangs_is_one_line_and_leaves_nothing() {
    let corner = Corner::new(PROGRAM);
    let grid = own_grid(&corner);
    let words = corner.path().display().to_string();
    for (mode, signal) in [
        (&["--mode", "lockstep", "--in-process"][..], "KILL"),
        (&["--mode", "lockstep", "--in-process"][..], "STOP"),
        (&["--mode", "realtime"][..], "KILL"),
    ] {
        let usual =
            ["run", &grid, "--ego", "through", "--duration", "3000", "--out", "k", "--force"];
        let deadline = ["--set", "traffic.deadline_s=1", "--set", "set_speed_mps=1"];
        let child = with_sumo(&corner, &[&usual[..], mode, &deadline].concat()).spawn();
        let child = child.expect("it starts");
        assert!(wait_for(|| !sumos(&words).is_empty()), "SUMO runs");
        assert!(wait_for(|| corner.path().join("k/scenario.toml").exists()), "it drives");
        // It waits for each step: after twenty it is in the middle of the drive.
        let begun: u64 = sumos(&words).into_iter().map(waits).sum();
        let drives = || sumos(&words).into_iter().map(waits).sum::<u64>() >= begun + 20;
        assert!(wait_for(drives), "it is stepped");
        for pid in sumos(&words) {
            let _ = Command::new("kill").args([format!("-{signal}"), pid.to_string()]).status();
        }
        let output = child.wait_with_output().expect("our child");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(3), "{mode:?} {signal}: {}", text(&output));
        assert_eq!(said.matches("SUMO: ").count(), 1, "{said}");
        assert!(wait_for(|| sumos(&words).is_empty()), "SUMO is gone");
        corner.expect_nothing_left(&[]);
    }
}

/// A killed launcher takes SUMO with it.
fn a_killed_run_leaves_no_program() {
    let corner = Corner::new(PROGRAM);
    let grid = own_grid(&corner);
    let words = corner.path().display().to_string();
    for mode in [&["--mode", "lockstep", "--in-process"][..], &["--mode", "realtime"]] {
        let usual =
            ["run", &grid, "--ego", "through", "--duration", "3000", "--set", "set_speed_mps=1"];
        let mut child =
            with_sumo(&corner, &[&usual[..], mode].concat()).spawn().expect("it starts");
        assert!(wait_for(|| !sumos(&words).is_empty()), "SUMO runs");
        child.kill().expect("ours");
        child.wait().expect("ours");
        assert!(wait_for(|| sumos(&words).is_empty()), "{mode:?}: SUMO is gone");
    }
}

fn files_and_programs_that_do_not_fit_are_one_line() {
    let corner = Corner::new(PROGRAM);
    let grid = own_grid(&corner);
    let write = |name: &str, text: &str| {
        std::fs::write(corner.path().join(name), text).expect("ours");
    };
    write("no-net.sumocfg", "<configuration><input/></configuration>");
    write("not.sumocfg", "<routes/>");
    write("gone.sumocfg", "<configuration><net-file value=\"gone.net.xml\"/></configuration>");
    write(
        "broken.net.xml",
        "<net><edge id=\"a\"><lane id=\"a_0\" speed=\"x\" shape=\"0,0 9,0\"/></edge></net>",
    );
    write("broken.sumocfg", "<configuration><net-file value=\"broken.net.xml\"/></configuration>");
    let tools = corner.path().join("tools");
    std::fs::create_dir_all(&tools).expect("ours");
    let script = tools.join("sumo");
    std::fs::write(&script, "#!/bin/sh\necho 'Error: the net is bad.' >&2\nexit 1\n")
        .expect("ours");
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755)).expect("ours");
    let tools = tools.display().to_string();
    let cases: [(&[&str], &str, i32, &str); 9] = [
        (&[&grid], "", 2, "no way for the ego, expected --ego ROUTE"),
        (
            &[&grid, "--ego", "nix"],
            "",
            2,
            "no route, vehicle, trip or flow `nix`, expected `through`",
        ),
        (
            &[&grid, "--ego", "from=nix,to=A0A1"],
            "",
            2,
            "the net has no edge `nix`, expected one of",
        ),
        (&["no-net.sumocfg", "--ego", "a"], "", 2, "no net file, expected <net-file"),
        (
            &["not.sumocfg", "--ego", "a"],
            "",
            2,
            "not.sumocfg:1:1: the outermost element is `routes`",
        ),
        (&["gone.sumocfg", "--ego", "a"], "", 2, "gone.net.xml: cannot be opened"),
        (
            &["broken.sumocfg", "--ego", "a"],
            "",
            2,
            "broken.net.xml:1:34: attribute `speed` of `lane`: `x` is not",
        ),
        (&[&grid, "--ego", "through"], "/nowhere", 3, "SUMO: there is no program `sumo`"),
        (&[&grid, "--ego", "through"], &tools, 3, "SUMO: ended at its start: the net is bad."),
    ];
    for (arguments, path, status, what) in cases {
        let all = [&["run", "--mode", "lockstep", "--in-process"], arguments].concat();
        let mut command = corner.command(&all);
        command.env("PATH", format!("{path}:/nowhere")).env_remove("SUMO_HOME");
        let output = command.output().expect("it starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {}", text(&output));
        assert!(said.contains(what) && said.lines().count() == 1, "{arguments:?}: {said}");
        corner.expect_nothing_left(&[]);
    }
    assert!(!corner.path().join("runs").exists(), "nothing was kept");
}

fn main() -> ExitCode {
    cases::run(&[
        needing(
            always,
            "files_and_programs_that_do_not_fit",
            files_and_programs_that_do_not_fit_are_one_line,
        ),
        needing(
            pypi,
            "the_same_seed",
            the_same_seed_gives_the_same_bytes_in_one_process_and_in_a_group,
        ),
        needing(pypi, "lights_come_as_frames", lights_come_as_frames_too),
        needing(pypi, "two_egos_share_one_sumo", two_egos_share_one_sumo_and_repeat_their_bytes),
        needing(pypi, "a_killed_ego_leaves", a_killed_ego_leaves_the_net_to_the_other),
        needing(pypi, "a_killed_sumo_ends_both_egos", a_killed_sumo_ends_both_egos),
        needing(
            pypi,
            "a_program_that_ends_or_hangs",
            a_program_that_ends_or_hangs_is_one_line_and_leaves_nothing,
        ),
        needing(pypi, "a_killed_run", a_killed_run_leaves_no_program),
    ])
}
