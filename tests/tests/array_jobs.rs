//! The files for array jobs and workflows in `examples`: the engines' keys are present, and `timegap` accepts every
//! command.

use std::collections::BTreeSet;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::{Command, Output};
use system_tests::{Corner, text};
use yaml_rust2::{Yaml, YamlLoader};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples");

/// A replacement for `timegap` that records its arguments, a word per line.
fn stand_in(corner: &Corner) -> String {
    let path = corner.path().join("timegap");
    let script = format!("#!/bin/sh\nprintf '%s\\n' \"$@\" > {}/words\n", corner.path().display());
    std::fs::write(&path, script).expect("our own corner");
    std::fs::set_permissions(&path, PermissionsExt::from_mode(0o755)).expect("our own file");
    path.to_str().expect("plain letters").to_owned()
}

/// Arguments of the replacement.
fn words(corner: &Corner) -> Vec<String> {
    let words = std::fs::read_to_string(corner.path().join("words")).expect("it was called");
    words.lines().map(str::to_owned).collect()
}

/// Parses a whole command line without running it.
fn understood(corner: &Corner, words: &[String]) {
    let line: Vec<&str> = words.iter().map(String::as_str).collect();
    let parsed = |line: &[&str]| corner.run(&[line, &["--help"]].concat());
    let output = parsed(&line);
    assert!(output.status.success(), "{line:?}: {}", text(&output));
    // Help would hide an unknown option before it.
    let output = parsed(&[&line[..], &["--no-such-option"]].concat());
    assert_eq!(output.status.code(), Some(2), "{line:?}");
}

fn read(path: &str) -> String {
    std::fs::read_to_string(Path::new(EXAMPLES).join(path))
        .unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// Runs a batch script like Slurm for one task of its array.
fn task(corner: &Corner, path: &str, program: &str, task: u32) -> Output {
    Command::new("bash")
        .arg(Path::new(EXAMPLES).join(path))
        .current_dir(corner.path())
        .env("TIMEGAP", program)
        .env("TMPDIR", corner.path())
        .env("XDG_RUNTIME_DIR", corner.path())
        .env("SLURM_ARRAY_TASK_ID", task.to_string())
        .envs(
            [("MIN", "1"), ("MAX", "8"), ("COUNT", "8")]
                .map(|(name, value)| (format!("SLURM_ARRAY_TASK_{name}"), value)),
        )
        .output()
        .expect("bash is there")
}

#[test]
fn batch_scripts_ask_for_an_array_that_can_be_requeued() {
    for path in ["slurm/campaign.sbatch", "slurm/sweep.sbatch"] {
        let script = read(path);
        assert!(script.starts_with("#!/bin/bash\n"), "{path}");
        let asked: BTreeSet<&str> =
            script.lines().filter_map(|line| line.strip_prefix("#SBATCH ")).collect();
        for needed in ["--array=1-8", "--ntasks=1", "--requeue", "--open-mode=append"] {
            assert!(asked.contains(needed), "{path} asks for {asked:?}");
        }
        let corner = Corner::new(PROGRAM);
        let output = task(&corner, path, &stand_in(&corner), 3);
        assert!(output.status.success(), "{path}: {}", text(&output));
        let words = words(&corner);
        let after = |option: &str| {
            let at = words.iter().position(|word| word == option);
            at.and_then(|at| words.get(at + 1)).unwrap_or_else(|| panic!("{path}: no {option}"))
        };
        // Each task has a directory of its own, where a requeued one continues.
        assert_eq!((after("--shard").as_str(), after("--resume").as_str()), ("auto", "shards/3"));
        understood(&corner, &words);
        // Commands in its comments.
        let typed = script.lines().filter_map(|line| line.strip_prefix("#   timegap "));
        let typed: Vec<&str> = typed.collect();
        assert!(!typed.is_empty(), "{path} says how to merge");
        for line in typed {
            let line: Vec<String> = line.split_whitespace().map(str::to_owned).collect();
            understood(&corner, &line);
        }
    }
}

#[test]
fn a_task_of_the_sweep_does_its_part() {
    let corner = Corner::new(PROGRAM);
    let output = task(&corner, "slurm/sweep.sbatch", PROGRAM, 3);
    assert!(output.status.success(), "{}", text(&output));
    let journal = corner.path().join("shards/3/runs.jsonl");
    let runs = std::fs::read_to_string(journal).expect("the journal").lines().count();
    // 21 delays and 20 seeds, not divisible by eight.
    assert!((52..=53).contains(&runs), "{runs} of {}", 21 * 20);
    corner.expect_nothing_left(&[]);
}

/// A value of a document by its path.
fn at<'a>(mut node: &'a Yaml, path: &str) -> &'a Yaml {
    for key in path.split('.') {
        node = match key.parse::<usize>() {
            Ok(index) => &node[index],
            Err(_) => &node[key],
        };
    }
    assert!(!node.is_badvalue(), "no {path}");
    node
}

fn string<'a>(node: &'a Yaml, path: &str) -> &'a str {
    at(node, path).as_str().unwrap_or_else(|| panic!("{path} is not a text"))
}

fn strings(node: &Yaml, path: &str) -> Vec<String> {
    let list = at(node, path).as_vec().unwrap_or_else(|| panic!("{path} is not a list"));
    list.iter().map(|word| word.as_str().expect("a word").to_owned()).collect()
}

fn documents(path: &str) -> Vec<Yaml> {
    YamlLoader::load_from_str(&read(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn job<'a>(documents: &'a [Yaml], claims: &[&str]) -> &'a Yaml {
    let job = documents.iter().find(|document| document["kind"].as_str() == Some("Job"));
    let job = job.expect("a job");
    assert_eq!(string(job, "apiVersion"), "batch/v1");
    let pod = at(job, "spec.template.spec");
    let container = at(pod, "containers.0");
    assert_eq!(string(container, "image"), "timegap:latest");
    // Every mounted place is a volume, and every claim exists.
    let volumes: Vec<&str> =
        at(pod, "volumes").as_vec().expect("a list").iter().map(|v| string(v, "name")).collect();
    for mount in at(container, "volumeMounts").as_vec().expect("a list") {
        assert!(volumes.contains(&string(mount, "name")), "{mount:?}");
        assert!(string(mount, "mountPath").starts_with('/'));
    }
    let claimed = at(pod, "volumes").as_vec().expect("a list").iter();
    for volume in claimed.filter(|volume| !volume["persistentVolumeClaim"].is_badvalue()) {
        assert!(claims.contains(&string(volume, "persistentVolumeClaim.claimName")));
    }
    job
}

#[test]
fn the_indexed_job_has_what_kubernetes_reads() {
    let corner = Corner::new(PROGRAM);
    let documents = documents("kubernetes/campaign.yaml");
    let claim = documents.iter().find(|d| d["kind"].as_str() == Some("PersistentVolumeClaim"));
    let claim = string(claim.expect("a claim"), "metadata.name");
    let campaign = job(&documents, &[claim]);
    assert_eq!(string(campaign, "spec.completionMode"), "Indexed");
    let completions = at(campaign, "spec.completions").as_i64().expect("a number");
    assert!((1..=completions).contains(&at(campaign, "spec.parallelism").as_i64().expect("one")));
    assert_eq!(string(campaign, "spec.template.spec.restartPolicy"), "OnFailure");
    let container = at(campaign, "spec.template.spec.containers.0");
    let index = at(container, "env.0");
    assert_eq!(string(index, "name"), "JOB_COMPLETION_INDEX");
    assert_eq!(
        string(index, "valueFrom.fieldRef.fieldPath"),
        "metadata.annotations['batch.kubernetes.io/job-completion-index']"
    );
    let arguments = strings(container, "args");
    // A pod's environment lacks the number of parts: it must equal the number of completions.
    assert!(arguments.contains(&format!("auto/{completions}")), "{arguments:?}");
    let own = "/results/shard-$(JOB_COMPLETION_INDEX)";
    assert!(arguments.iter().any(|word| word == own), "{arguments:?}");
    let replaced: Vec<String> =
        arguments.iter().map(|word| word.replace("$(JOB_COMPLETION_INDEX)", "3")).collect();
    assert!(replaced.iter().all(|word| !word.contains("$(")), "{replaced:?}");
    understood(&corner, &replaced);

    let documents = self::documents("kubernetes/merge.yaml");
    let merge = job(&documents, &[claim]);
    let command = strings(merge, "spec.template.spec.containers.0.command");
    let path = format!("{}:/usr/bin:/bin", corner.path().display());
    let _ = stand_in(&corner);
    for part in 0..completions {
        std::fs::create_dir(corner.path().join(format!("shard-{part}"))).expect("ours");
    }
    let status = Command::new(&command[0])
        .args(&command[1..])
        .current_dir(corner.path())
        .env("PATH", path)
        .status();
    assert!(status.expect("a shell").success());
    let words = words(&corner);
    let parts = words.iter().filter(|word| word.starts_with("shard-")).count();
    assert_eq!(parts, usize::try_from(completions).expect("few"), "{words:?}");
    understood(&corner, &words);
    let image = read("kubernetes/Dockerfile");
    assert!(image.contains("ENTRYPOINT [\"timegap\"]") && image.contains("--locked -p timegap"));
}

#[test]
fn the_gate_s_workflow_types_what_timegap_accepts() {
    let corner = Corner::new(PROGRAM);
    let workflow = documents("gate/gate.yml").remove(0);
    let steps = at(&workflow, "jobs.gate.steps").as_vec().expect("a list");
    let runs = steps.iter().filter_map(|step| step["run"].as_str());
    let gate = runs.map(str::trim).find(|run| run.starts_with("timegap ")).expect("the gate");
    let words = shlex::split(gate).expect("words of a shell").split_off(1);
    understood(&corner, &words);
    for file in ["--junit", "--markdown", "--against"] {
        assert!(words.iter().any(|word| word == file), "{file}: {words:?}");
    }
}

#[test]
fn a_law_that_got_worse_fails_the_gate_and_an_equal_one_passes() {
    let corner = Corner::new(PROGRAM);
    let compare = |more: &[&str]| {
        let words = ["compare", "cut-in", "--controllers", "acc-mpc", "--seeds", "12"];
        corner.run(&[&words[..], more].concat())
    };
    let base = compare(&["--out", "base"]);
    assert!(base.status.success(), "{}", text(&base));
    let equal = compare(&["--against", "base/compare.json", "--out", "equal"]);
    assert!(equal.status.success(), "{}", text(&equal));
    assert!(text(&equal).contains("0 figures are worse (12 pairs"), "{}", text(&equal));
    // Late commands cost every seed a part of its gap.
    let late = ["--set", "runtime.extra_delay_ms=300", "--junit", "gate.xml"];
    let worse =
        compare(&[&late[..], &["--against", "base/compare.json", "--out", "worse"]].concat());
    assert_eq!(worse.status.code(), Some(1), "{}", text(&worse));
    let junit = std::fs::read_to_string(corner.path().join("gate.xml")).expect("it was written");
    assert!(junit.contains("<failure"), "{junit}");
    let result = std::fs::read(corner.path().join("worse/compare.json")).expect("it was written");
    let result = serde_json::from_slice(&result).expect("JSON");
    let schema = &corner.schemas()["compare"];
    assert_eq!(system_tests::schema::check(schema, &result), [""; 0], "with a baseline too");
    let missing = compare(&["--against", "nowhere.json", "--out", "missing"]);
    assert_eq!(missing.status.code(), Some(2));
    assert!(text(&missing).contains("--against nowhere.json"), "{}", text(&missing));
    assert!(!corner.path().join("missing").exists(), "a refused study leaves nothing");
}
