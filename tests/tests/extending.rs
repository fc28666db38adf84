//! CONTRIBUTING.md's steps for a new message and a new service, done in a copy of the sources. A message is two edits.
//! A service is a folder, a row and a line in a manifest.

use messages::{Service, TOPICS};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use system_tests::text;

/// Copies the sources below `from`. A file that is the same keeps its time, so that it is not compiled again.
fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("the target folder is writable");
    for entry in std::fs::read_dir(from).expect("a folder of the workspace") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("an entry has a name");
        let new = to.join(name);
        if path.is_dir() {
            if name != "target" && name != ".git" && name != "runs" {
                copy(&path, &new);
            }
        } else if std::fs::read(&new).ok() != std::fs::read(&path).ok() {
            std::fs::copy(&path, &new).expect("the target folder is writable");
        }
    }
}

/// Profile of this test's own build, and the folder of all builds.
fn build() -> (String, PathBuf) {
    let program = std::env::current_exe().expect("a test is a program");
    let profile = program.ancestors().nth(2).expect("target/PROFILE/deps/PROGRAM");
    let name = profile.file_name().expect("it has a name").to_string_lossy().into_owned();
    let target = profile.parent().expect("the folder of all builds").to_owned();
    (if name == "debug" { "dev".to_owned() } else { name }, target)
}

/// A copy of the workspace, to be edited.
struct Copy {
    root: PathBuf,
    target: PathBuf,
    profile: String,
}

impl Copy {
    fn new() -> Self {
        let (profile, target) = build();
        let root = target.join("extending");
        // Only what an earlier run of this test added.
        let _ = std::fs::remove_dir_all(root.join("services/probe"));
        copy(Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the workspace"), &root);
        Self { root, target, profile }
    }

    /// Writes `text` behind the first `place` of a file.
    fn insert(&self, file: &str, place: &str, text: &str) {
        let path = self.root.join(file);
        let old = std::fs::read_to_string(&path).expect("a file of the workspace");
        let at = old.find(place).unwrap_or_else(|| panic!("{file} has no `{place}`")) + place.len();
        std::fs::write(path, format!("{}{text}{}", &old[..at], &old[at..])).expect("writable");
    }

    /// Writes a new file.
    fn create(&self, file: &str, text: &str) {
        let path = self.root.join(file);
        std::fs::create_dir_all(path.parent().expect("a file is in a folder")).expect("writable");
        std::fs::write(path, text).expect("writable");
    }

    fn cargo(&self, arguments: &[&str]) {
        let output = Command::new(env!("CARGO"))
            .args(arguments)
            .args(["--offline", "--profile", &self.profile])
            .env("CARGO_TARGET_DIR", &self.target)
            .current_dir(&self.root)
            .output()
            .expect("cargo runs tests, so it is there");
        assert!(output.status.success(), "{arguments:?}: {}", text(&output));
    }

    /// Runs a command of the copy, built just before.
    fn timegap(&self, arguments: &[&str]) -> Output {
        self.cargo(&["build", "-p", "timegap", "--features", "studies", "--bin", "timegap"]);
        let folder = if self.profile == "dev" { "debug" } else { &self.profile };
        let output = Command::new(self.target.join(folder).join("timegap"))
            .args(arguments)
            .current_dir(&self.root)
            .output()
            .expect("the command starts");
        assert!(output.status.success(), "{arguments:?}: {}", text(&output));
        output
    }
}

/// First edit of a message: its struct.
const STRUCT: &str = r#"
layout! {
    /// Position of the ego, as a probe receives it.
    pub message Probe "timegap_msgs/msg/Probe" {
        /// Position, m.
        pub position_m: f64,
    }
}
"#;

/// A service's folder.
const MANIFEST: &str = r#"[package]
name = "probe"
description = "Hands on how far the ego is"
version.workspace = true
edition.workspace = true
rust-version.workspace = true
license.workspace = true
publish.workspace = true

[dependencies]
messages.workspace = true
runtime.workspace = true

[lints]
workspace = true
"#;
const MAIN: &str = r"//! The probe as a program of its own.

use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    runtime::run_service(messages::Service::Probe, &arguments, probe::run)
}
";
const LIBRARY: &str = r"//! Hands on how far the ego is.

use messages::{Header, Odometry, Origins, Probe, ServiceState};
use runtime::{Cycle, Overrun, Publisher, Runtime, RuntimeError, Subscriber};

/// Runs the probe in its group, to the end of the run.
///
/// # Errors
/// If the group's shared memory is not usable.
pub fn run(mut runtime: Runtime) -> Result<(), RuntimeError> {
    let scenario = runtime.scenario();
    let mut odometry: Subscriber<Odometry> = runtime.subscriber()?;
    let mut probe: Publisher<Probe> = runtime.publisher()?;
    runtime.begin(&scenario)?;
    runtime.run_cycles(|runtime| {
        let Some(release) = runtime.next_release(Overrun::Skip)? else { return Ok(Cycle::Last) };
        runtime.update(&mut odometry)?;
        let origins = Origins { odometry: odometry.origin(), ..Origins::NONE };
        probe.send_with(|message| {
            message.header = Header::new(release.step, release.scheduled_ns, origins);
            message.position_m = odometry.newest().map_or(0.0, |odometry| odometry.position_m);
        })?;
        runtime.end_cycle(ServiceState::Running)?;
        Ok(Cycle::Next)
    })?;
    runtime.finish(())
}
";

#[test]
#[ignore = "minutes: it builds the workspace in a folder of its own, twice"]
fn a_message_is_two_edits_and_a_service_a_folder_a_row_and_a_line() {
    let copy = Copy::new();
    let topic_row = |sender: &str| {
        let number = TOPICS.len();
        format!("\n    {number} Probe \"probe/position\" Report, {sender};")
    };

    // A message: its struct and its row.
    let health = "shared/messages/src/health.rs";
    let end = std::fs::read_to_string(copy.root.join(health)).expect("a file of the workspace");
    copy.create(health, &(end + STRUCT));
    copy.insert(
        "shared/messages/src/topic.rs",
        "topics! { $",
        &topic_row("[Plant] to [Controller]"),
    );
    copy.cargo(&["test", "-p", "messages", "-p", "scenario", "-p", "runtime", "--lib"]);
    let reference = copy.timegap(&["print", "reference", "messages"]);
    assert!(text(&reference).contains("probe/position"), "the reference reads the row");

    // A service that sends it: its folder, its row, and the line in the launcher's manifest, which cargo needs.
    let topics = copy.root.join("shared/messages/src/topic.rs");
    let rows = std::fs::read_to_string(&topics).expect("a file of the workspace");
    let rows = rows
        .replace(&topic_row("[Plant] to [Controller]"), &topic_row("[Probe] to [] shows Probe"));
    // Its name in the row of the topic that it reads.
    let rows = rows.replacen("Function, [Plant] to [", "Function, [Plant] to [Probe, ", 1);
    copy.create("shared/messages/src/topic.rs", &rows);
    copy.create("services/probe/Cargo.toml", MANIFEST);
    copy.create("services/probe/src/lib.rs", LIBRARY);
    copy.create("services/probe/src/main.rs", MAIN);
    let (number, track) = (Service::ALL.len() + 1, Service::ALL.len());
    let row = format!(
        "\n    /// Hands on how far the ego is.
    Probe = {number} \"probe\", probe: Descriptor {{
        pace: Pace::Control, presence: Presence::Always, priority: 78, track: {track},
        can_stand_by: true,
    }};"
    );
    copy.insert("shared/messages/src/service.rs", "services! { $", &row);
    copy.insert(
        "tools/supervise/Cargo.toml",
        "[dependencies]\n",
        "probe = { path = \"../../services/probe\" }\n",
    );
    let of_libraries = "test -p messages -p scenario -p runtime -p supervise --lib";
    copy.cargo(&of_libraries.split(' ').collect::<Vec<_>>());
    let run =
        ["run", "following", "--mode", "lockstep", "--duration", "2", "--no-record", "--json"];
    for carrier in [&[][..], &["--in-process"]] {
        let output = copy.timegap(&[&run[..], carrier].concat());
        let summary: Value = serde_json::from_slice(&output.stdout).expect("--json prints JSON");
        let sent = &summary["messages"]["probe/position"];
        assert!(sent["sent"].as_u64() > Some(10), "{carrier:?}: {sent}");
    }
    let reference = copy.timegap(&["print", "reference", "scenario"]);
    assert!(text(&reference).contains("probe"), "keys of each service read the row");
}
