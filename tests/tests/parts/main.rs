//! Studies in parts: array jobs, merges with missing parts, and survival.

use rustix::process::{Pid, Signal, kill_process};
use std::process::{Command, ExitCode};
use system_tests::cases::{self, case, long, needing};
use system_tests::{Corner, text, wait_for};

mod slurm;

use slurm::{Slurm, slurm};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// 2 scenarios, 2 faults, 40 seeds: 160 runs.
const CAMPAIGN: &str = r#"schema_version = 1
name = "small"
scenarios = ["cacc-a", "cut-in"]
controllers = ["acc-mpc"]
seeds = 40
set = ["duration_s=20"]

[[faults]]
kind = "drop"
topic = ["radar/tracks", "control/command"]
at_s = [0.5, 1.5]
for_s = 1.0

[[faults]]
kind = "corrupt"
topic = "radar/tracks"
probability = [0.1, 1.0]
bits = [1, 64]

[require]
max_aborted = 0
max_undetected_corruptions = 0
min_critical_faults = 0 # the runs are short
"#;

const SWEEP: [&str; 8] = [
    "sweep",
    "cut-in",
    "--duration",
    "5",
    "--vary",
    "runtime.extra_delay_ms=0..200/100",
    "--seeds",
    "1..3",
];

fn succeed(corner: &Corner, arguments: &[&str]) -> String {
    let output = corner.run(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", text(&output));
    text(&output)
}

fn file(corner: &Corner, path: &str) -> String {
    std::fs::read_to_string(corner.path().join(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn refused(corner: &Corner, arguments: &[&str], words: &[&str]) {
    let output = corner.run(arguments);
    let said = text(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
    assert!(words.iter().all(|word| said.contains(word)), "{arguments:?}: {said}");
}

fn a_sweep_in_parts_gives_the_bytes_of_one_machine() {
    let corner = Corner::new(PROGRAM);
    succeed(&corner, &[&SWEEP[..], &["--out", "whole"]].concat());
    for (index, out) in [("1", "a"), ("3", "c")] {
        let shard = format!("{index}/3");
        succeed(&corner, &[&SWEEP[..], &["--shard", &shard, "--out", out]].concat());
    }
    // The merge names the command that begins part 2.
    let output = corner.run(&["merge", "c", "a", "--out", "incomplete"]);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("shard 2/3 is missing, 3 runs"), "{said}");
    let command = said.lines().find_map(|line| line.trim().strip_prefix("timegap "));
    // Quoted words have no spaces here.
    let command = command.expect("a command").replace('\'', "");
    let words: Vec<&str> = command.split(' ').collect();
    succeed(&corner, &words);
    let part = words.last().expect("a directory");
    succeed(&corner, &["merge", part, "c", "a", "--out", "merged"]);
    for name in ["sweep.json", "runs.csv", "report.html"] {
        let (whole, merged) = (format!("whole/{name}"), format!("merged/{name}"));
        assert_eq!(file(&corner, &whole), file(&corner, &merged), "{name}");
    }
    refused(&corner, &["merge", "a", "a", "--out", "x"], &["the same part as"]);
    let other = [&SWEEP[..6], &["--seeds", "1..4", "--shard", "2/3", "--out", "other"]].concat();
    succeed(&corner, &other);
    refused(&corner, &["merge", "a", "other", "--out", "x"], &["another sweep"]);
    refused(&corner, &["merge", "a", "--seed", "3"], &["unexpected argument '--seed'"]);
    corner.expect_nothing_left(&[]);
}

fn a_comparison_and_a_matrix_in_parts_give_the_figures_of_one_machine() {
    let corner = Corner::new(PROGRAM);
    let compare = ["compare", "cut-in", "cacc-a", "--controllers", "acc-mpc,six-mode"];
    let matrix =
        ["test", "r157", "--matrix", "cut-in,cut-out", "--controllers", "acc-mpc", "--sample", "3"];
    for (name, study) in [("compare", &compare[..]), ("r157", &matrix[..])] {
        let whole = format!("{name}-whole");
        let output = corner.run(&[study, &["--out", &whole]].concat());
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
        let parts = ["1/2", "2/2"].map(|shard| format!("{name}-{}", &shard[..1]));
        for (shard, part) in ["1/2", "2/2"].iter().zip(&parts) {
            let output = corner.run(&[study, &["--shard", shard, "--out", part]].concat());
            assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
        }
        let merged = format!("{name}-merged");
        let output = corner.run(&["merge", &parts[0], &parts[1], "--out", &merged]);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
        let json = |directory: &str| {
            let text = file(&corner, &format!("{directory}/{name}.json"));
            let mut json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
            for row in json["rows"].as_array_mut().into_iter().flatten() {
                // Wall-clock time.
                row["timing"] = serde_json::Value::Null;
            }
            json
        };
        assert_eq!(json(&whole), json(&merged), "{name}");
    }
}

fn outside_an_array_job_auto_is_refused() {
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("small.toml"), CAMPAIGN).expect("our own directory");
    for study in [&SWEEP[..], &["campaign", "small.toml"]] {
        let words = ["not an array job", "SLURM_ARRAY_TASK_ID", "expected --shard I/N"];
        refused(&corner, &[study, &["--shard", "auto", "--out", "x"]].concat(), &words);
    }
    assert!(!corner.path().join("x").exists(), "nothing was begun");
    // Task 2 of 1 to 8 by hand.
    let arguments = ["campaign", "small.toml", "--seeds", "4", "--shard", "auto", "--out", "two"];
    let mut command = corner.command(&arguments);
    for (name, value) in [("ID", "2"), ("MIN", "1"), ("MAX", "8"), ("COUNT", "8")] {
        command.env(format!("SLURM_ARRAY_TASK_{name}"), value);
    }
    let output = command.output().expect("it starts");
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
    assert!(file(&corner, "two/part.json").contains("\"shard\": \"2/8\""));
    assert_eq!(file(&corner, "two/runs.jsonl").lines().count(), 2);
}

fn journals_that_do_not_fit_are_refused() {
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("small.toml"), CAMPAIGN).expect("our own directory");
    for shard in ["1/2", "2/2"] {
        let out = &shard[..1];
        let own = ["campaign", "small.toml", "--seeds", "1", "--shard", shard, "--out", out];
        let output = corner.run(&own);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
    }
    let merge = ["merge", "1", "2", "--out", "x"];
    let journal = corner.path().join("2/runs.jsonl");
    let good = std::fs::read_to_string(&journal).expect("a journal");
    let first = good.lines().next().expect("a run").to_owned() + "\n";
    // Old lines have no checksum.
    let plain = |line: &str| line.split(",\"xxh3\"").next().expect("a record").to_owned() + "}\n";
    let plain: String = good.lines().map(plain).collect();
    for (bad, words) in [
        (format!("{good}{first}"), "is there twice"),
        (good.replacen("\"run\":1", "\"run\":0", 1), "its checksum is wrong"),
        (plain.replacen("\"run\":1", "\"run\":0", 1), "does not belong to this part"),
        (plain.replacen("\"run\":1", "\"run\":999", 1), "does not belong to this part"),
        (format!("{{}}\n{good}"), "runs.jsonl:1"),
        (format!("\u{1}\u{2}\n{good}"), "expected the record of a run"),
    ] {
        std::fs::write(&journal, bad).expect("our own file");
        refused(&corner, &merge, &[words]);
    }
    std::fs::write(&journal, b"\xff\xfe\n").expect("our own file");
    refused(&corner, &merge, &["runs.jsonl"]);
    // A torn line is a missing run, which is named.
    std::fs::write(&journal, &good[..good.len() - 5]).expect("our own file");
    let output = corner.run(&merge);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let words = ["shard 2/2 in 2 is not finished, 1 runs", "timegap resume 2"];
    assert!(words.iter().all(|word| text(&output).contains(word)), "{}", text(&output));
}

fn a_campaigns_part_goes_on_and_is_merged_without_the_file_of_its_command() {
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("small.toml"), CAMPAIGN).expect("our own directory");
    let own = ["campaign", "small.toml", "--seeds", "1", "--out"];
    let done = |arguments: &[&str]| {
        let output = corner.run(arguments);
        assert!(matches!(output.status.code(), Some(0 | 1)), "{arguments:?}: {}", text(&output));
    };
    done(&[&own[..], &["whole"]].concat());
    for shard in ["1/2", "2/2"] {
        done(&[&own[..], &[&shard[..1], "--shard", shard]].concat());
    }
    std::fs::remove_file(corner.path().join("small.toml")).expect("our own file");
    let journal = corner.path().join("2/runs.jsonl");
    let kept = std::fs::read_to_string(&journal).expect("a journal");
    let first = kept.lines().next().expect("a run").to_owned() + "\n";
    std::fs::write(&journal, first).expect("our own file");
    done(&["resume", "2"]);
    assert_eq!(file(&corner, "2/runs.jsonl"), kept, "its own runs, the same bytes");
    done(&["merge", "1", "2", "--out", "merged"]);
    assert_eq!(file(&corner, "merged/campaign.json"), file(&corner, "whole/campaign.json"));
}

fn a_killed_part_goes_on_with_what_it_kept() {
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("small.toml"), CAMPAIGN).expect("our own directory");
    let own = ["campaign", "small.toml", "--seeds", "10", "--jobs", "1"];
    let mut child = corner.start(&[&own[..], &["--resume", "killed"]].concat());
    let lines = || {
        let journal = corner.path().join("killed/runs.jsonl");
        std::fs::read_to_string(journal).unwrap_or_default().lines().count()
    };
    assert!(wait_for(|| lines() >= 2), "nothing ran");
    child.kill().expect("our own child");
    child.wait().expect("our own child");
    let kept = lines();
    assert!((2..40).contains(&kept), "{kept} runs were kept");
    let output = corner.run(&["resume", "killed"]);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
    let output = corner.run(&[&own[..], &["--out", "whole"]].concat());
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
    assert_eq!(file(&corner, "killed/campaign.json"), file(&corner, "whole/campaign.json"));
    corner.expect_nothing_left(&[]);
}

fn nothing_is_gone_on_with_that_was_not_begun() {
    let corner = Corner::new(PROGRAM);
    let sweep = |name: &'static str| {
        ["sweep", name, "--vary", "runtime.extra_delay_ms=0..100/50", "--duration", "1"]
    };
    succeed(
        &corner,
        &["run", "following", "--mode", "lockstep", "--duration", "1", "--out", "run"],
    );
    succeed(&corner, &[&sweep("cut-in")[..], &["--out", "sweep"]].concat());
    for (place, held, words) in
        [("run", "report.html", "no part.json"), ("sweep", "sweep.json", "it holds another study")]
    {
        let before = file(&corner, &format!("{place}/{held}"));
        let output = corner.run(&[&sweep("following")[..], &["--resume", place]].concat());
        assert_eq!(output.status.code(), Some(2), "{}", text(&output));
        assert!(text(&output).contains(words), "{}", text(&output));
        assert_eq!(file(&corner, &format!("{place}/{held}")), before, "replaced");
    }
}

/// A full disk: an error, and the journal continues when there is room again.
fn a_journal_survives_a_full_disk() {
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("small.toml"), CAMPAIGN).expect("our own directory");
    std::fs::create_dir(corner.path().join("disk")).expect("our own directory");
    let script = "mount -t tmpfs -o size=16k none disk && {
        \"$0\" campaign small.toml --seeds 10 --resume disk/out; echo \"first: $?\"
        mount -o remount,size=4m disk
        \"$0\" resume disk/out --json > json; echo \"second: $?\"; }";
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", script, PROGRAM])
        .current_dir(corner.path())
        .env("XDG_RUNTIME_DIR", corner.path())
        .output()
        .expect("it starts");
    let said = text(&output);
    assert!(said.contains("first: 3") && said.contains("No space left"), "{said}");
    assert!(said.contains("timegap resume disk/out"), "{said}");
    let json: serde_json::Value = serde_json::from_str(&file(&corner, "json")).expect("a verdict");
    assert_eq!((&json["runs"], &json["planned"]), (&40.into(), &40.into()), "{said}");
}

fn an_array_of_eight_with_a_killed_task_gives_the_bytes_of_one_machine() {
    let corner = Corner::new(PROGRAM);
    std::fs::write(corner.path().join("small.toml"), CAMPAIGN).expect("our own directory");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/slurm/campaign.sbatch");
    let slurm = Slurm::start(&corner).expect("it has started before");
    let (at, program) = (format!("--chdir={}", corner.path().display()), PROGRAM);
    let export = format!(
        "--export=ALL,TIMEGAP={program},CAMPAIGN=small.toml,XDG_RUNTIME_DIR={}",
        corner.path().display()
    );
    let said = slurm.command("sbatch", &["--parsable", &at, &export, script]);
    let job = said.split_whitespace().next().expect("a number").to_owned();
    assert!(job.parse::<u32>().is_ok(), "{said}");

    // The fifth task is killed after its first run.
    let journal = corner.path().join("shards/5/runs.jsonl");
    let kept = || std::fs::read_to_string(&journal).unwrap_or_default().lines().count();
    let mut victim = None;
    let found = wait_for(|| {
        victim = process_with("shards/5");
        victim.is_some() && kept() >= 1
    });
    assert!(found, "no task 5: {}\n{}", slurm.command("squeue", &[]), slurm.log(&corner));
    kill_process(victim.expect("it was found"), Signal::KILL).expect("our own task");
    let task = format!("{job}_5");
    let state = || slurm.command("scontrol", &["-o", "show", "job", &task]);
    assert!(wait_for(|| state().contains("JobState=FAILED")), "{}", state());
    assert!((1..20).contains(&kept()), "{} runs were kept", kept());
    slurm.command("scontrol", &["requeue", &task]);
    // A requeued job would wait for its node's cleanup.
    slurm.command("scontrol", &["update", &format!("JobId={task}"), "StartTime=now"]);
    let done = || slurm.command("squeue", &["-h", "-j", &job]).trim().is_empty();
    assert!(wait_for(|| done() && kept() == 20), "{}\n{}", state(), slurm.log(&corner));

    let shards: Vec<String> = (1..=8).map(|task| format!("shards/{task}")).collect();
    let shards: Vec<&str> = shards.iter().map(String::as_str).collect();
    let output = corner.run(&[&["merge"], &shards[..], &["--out", "merged"]].concat());
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
    let output = corner.run(&["campaign", "small.toml", "--out", "whole"]);
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", text(&output));
    for name in ["campaign.json", "runs.csv"] {
        let (whole, merged) = (format!("whole/{name}"), format!("merged/{name}"));
        assert_eq!(file(&corner, &whole), file(&corner, &merged), "{name}");
    }
}

/// The campaign process whose command line names a directory.
fn process_with(directory: &str) -> Option<Pid> {
    for entry in std::fs::read_dir("/proc").ok()?.flatten() {
        let Some(pid) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else {
            continue;
        };
        let line = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
        let line = String::from_utf8_lossy(&line).into_owned();
        let mut words = line.split('\0');
        if words.next() == Some(PROGRAM) && words.any(|word| word == directory) {
            return Pid::from_raw(pid);
        }
    }
    None
}

fn main() -> ExitCode {
    cases::run(&[
        case(
            "a_sweep_in_parts_gives_the_bytes_of_one_machine",
            a_sweep_in_parts_gives_the_bytes_of_one_machine,
        ),
        case(
            "a_comparison_and_a_matrix_in_parts_give_the_figures_of_one_machine",
            a_comparison_and_a_matrix_in_parts_give_the_figures_of_one_machine,
        ),
        case("outside_an_array_job_auto_is_refused", outside_an_array_job_auto_is_refused),
        case("journals_that_do_not_fit_are_refused", journals_that_do_not_fit_are_refused),
        case(
            "nothing_is_gone_on_with_that_was_not_begun",
            nothing_is_gone_on_with_that_was_not_begun,
        ),
        case(
            "a_campaigns_part_goes_on_and_is_merged_without_the_file_of_its_command",
            a_campaigns_part_goes_on_and_is_merged_without_the_file_of_its_command,
        ),
        case("a_killed_part_goes_on_with_what_it_kept", a_killed_part_goes_on_with_what_it_kept),
        needing(
            cases::mount_namespace,
            "a_journal_survives_a_full_disk",
            a_journal_survives_a_full_disk,
        ),
        long(
            slurm,
            "an_array_of_eight_with_a_killed_task_gives_the_bytes_of_one_machine",
            an_array_of_eight_with_a_killed_task_gives_the_bytes_of_one_machine,
        ),
    ])
}
