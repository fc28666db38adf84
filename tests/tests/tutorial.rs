//! The tutorial: its commands in their order, and the reader's own controller in the group, with a fault.

use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use system_tests::{Corner, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const MY_CONTROLLER: &str = env!("CARGO_BIN_EXE_my-controller");

const TUTORIAL: &str = include_str!("../../docs/tutorial.md");

/// Steps of the tutorial, in its order.
#[derive(Debug, PartialEq)]
enum Step {
    /// Type this line.
    Type(String),
    /// Save this text in the file, or append it.
    Save { file: String, text: String, appends: bool },
}

/// The steps that a page asks for. Indented lines are typed; blocks below a sentence that names a file are saved.
fn steps(page: &str) -> Vec<Step> {
    let mut steps = Vec::new();
    let (mut before, mut lines) = ("", page.lines());
    while let Some(line) = lines.next() {
        if line.starts_with("```") {
            let block: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            let named = before.strip_suffix("`:").and_then(|words| words.rsplit_once('`'));
            if let Some((words, file)) = named {
                let (file, text) = (file.to_owned(), block.join("\n") + "\n");
                steps.push(Step::Save { file, text, appends: words.contains("Append") });
            }
        } else if let Some(typed) = line.strip_prefix("    ").filter(|line| !line.starts_with(' '))
        {
            steps.push(Step::Type(typed.to_owned()));
        }
        if !line.is_empty() {
            before = line;
        }
    }
    steps
}

/// True of a line that needs a second terminal, or what only a checkout has.
fn is_left_out(line: &str) -> bool {
    line.starts_with("cargo ") || line.contains("--watch") || line.contains(" RUN ")
}

/// True of a drive in real time: the next lines can be typed while it goes on.
fn takes_its_time(line: &str) -> bool {
    line.starts_with("timegap run ") && !line.contains("--mode lockstep")
}

/// A verdict on the tutorial's law is a finding, and no mistake.
fn expect_success(line: &str, output: &Output) {
    let may_find = [" r157 ", " iso15622 "].iter().any(|study| line.contains(study));
    let expected: &[i32] = if may_find { &[0, 1] } else { &[0] };
    let status = output.status.code();
    assert!(status.is_some_and(|status| expected.contains(&status)), "{line}: {}", text(output));
}

/// Waits for a drive in real time.
fn finish(driving: Option<(String, Child)>) {
    if let Some((line, child)) = driving {
        expect_success(&line, &child.wait_with_output().expect("our child"));
    }
}

#[test]
fn the_commands_work_in_the_order_in_which_they_stand() {
    let corner = Corner::new(PROGRAM);
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let link = |from: &Path, to: &str| {
        let to = corner.path().join(to);
        std::fs::create_dir_all(to.parent().expect("in the corner")).expect("ours");
        std::os::unix::fs::symlink(from, to).expect("ours");
    };
    link(Path::new(PROGRAM), "bin/timegap");
    link(&examples, "examples");
    link(Path::new(MY_CONTROLLER), "target/release/examples/my_controller");
    let places =
        [corner.path().join("bin").display().to_string(), std::env::var("PATH").expect("a path")];
    let mut typed = 0;
    let mut driving: Option<(String, Child)> = None;
    for step in steps(TUTORIAL) {
        match step {
            Step::Type(line) if is_left_out(&line) => {}
            Step::Type(line) => {
                let mut command = Command::new("sh");
                command
                    .args(["-c", &line])
                    .current_dir(corner.path())
                    .env("PATH", places.join(":"))
                    .env("TMPDIR", corner.path())
                    .env("XDG_RUNTIME_DIR", corner.path())
                    .stdin(Stdio::null())
                    .stdout(Stdio::piped())
                    .stderr(Stdio::piped());
                if takes_its_time(&line) {
                    finish(driving.take());
                    driving = Some((line, command.spawn().expect("there is a shell")));
                } else {
                    expect_success(&line, &command.output().expect("there is a shell"));
                }
                typed += 1;
            }
            Step::Save { file, text, appends } => {
                let path = corner.path().join(file);
                let old = if appends {
                    std::fs::read_to_string(&path).expect("it is there")
                } else {
                    String::new()
                };
                std::fs::write(path, old + &text).expect("our own directory");
            }
        }
    }
    finish(driving);
    assert!(typed > 15, "{typed} lines were typed");
    corner.expect_nothing_left(&[]);
}

#[test]
fn a_page_is_read_as_steps() {
    let page = "Save it as `a.py`:\n\n```python\nx\n```\n\n    type a\n\nAppend to `a.py`:\n\n```python\ny\n```\n\n```toml\nno file\n```\n";
    let save = |text: &str, appends| Step::Save { file: "a.py".into(), text: text.into(), appends };
    let expected = [save("x\n", false), Step::Type("type a".into()), save("y\n", true)];
    assert_eq!(steps(page), expected);
}

fn service() -> String {
    format!("controller={MY_CONTROLLER}")
}

#[test]
fn a_controller_of_ones_own_follows_in_lockstep() {
    let corner = Corner::new(PROGRAM);
    let arguments = ["run", "following", "--mode", "lockstep", "--duration", "30", "--no-record"];
    let summary = corner.json(&[&arguments[..], &["--service", &service()]].concat());
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let gap_m = summary["control"]["min_gap_m"].as_f64().expect("there is a lead");
    assert!(gap_m > 5.0, "{gap_m}");
    // Every law is measured against one stated gap.
    assert!(summary["control"]["final_gap_error_m"].is_f64(), "{}", summary["control"]);
    assert!(corner.roots().is_empty());
}

#[test]
fn it_is_replaced_when_it_is_killed() {
    let corner = Corner::new(PROGRAM);
    let shown = corner.run(&["list", "--show", "following"]);
    let text = String::from_utf8(shown.stdout).expect("a scenario is text");
    let fault = "\n[[faults]]\nkind = \"kill\"\nservice = \"controller\"\nat_s = 1.0\n";
    std::fs::write(corner.path().join("mine.toml"), text + fault).expect("our own directory");
    let arguments = ["run", "mine.toml", "--duration", "4", "--service"];
    let summary = corner.json(&[&arguments[..], &[&service()]].concat());
    assert_eq!(summary["outcome"], "completed", "{summary}");
    let controller = (summary["services"].as_array().expect("a list").iter())
        .find(|service| service["name"] == "controller")
        .expect("it took part");
    assert_eq!(controller["restarts"], 1, "{controller}");
    let recovered = &summary["faults"][0]["recovered_after_us"];
    assert!(matches!(recovered, Value::Number(_)), "{}", summary["faults"]);
}

#[test]
fn the_example_has_at_most_forty_lines() {
    assert!(include_str!("../../examples/my_controller.rs").lines().count() <= 40);
}
