//! A law as a node on DDS, with PyPI's `cyclonedds` for ROS 2: in a network namespace of its own, whose other interface
//! counts what leaves.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output, Stdio};
use system_tests::cases::{self, Needed, needing};
use system_tests::{Corner, python, text};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");
const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples");

/// A namespace with loopback and an interface to a network, with the packets that were sent there at the end. The peer
/// is in the namespace too, so that packets to the network go somewhere.
const NAMESPACE: &str = r#"
ip link set lo up
ip link add lan0 type veth peer name lan1
for one in lan0 lan1; do echo 1 > /proc/sys/net/ipv6/conf/$one/disable_ipv6; done
ip addr add 10.77.0.1/24 dev lan0
ip link set lan0 up && ip link set lan1 up
ip route add default via 10.77.0.254 dev lan0
"#;
const SENT: &str = "awk '/lan0:/ { print \"sent \" $11 }' /proc/net/dev >&2\n";

fn interpreter() -> Result<PathBuf, system_tests::missing::Missing> {
    python::DDS.interpreter(Path::new(env!("CARGO_TARGET_TMPDIR")))
}

fn needs() -> Needed {
    interpreter()?;
    cases::program("ip")?;
    let output = Command::new("unshare").args(["--net", "--map-root-user", "true"]).output();
    match output {
        Ok(output) if output.status.success() => Ok(()),
        _ => Err("unshare --net: no network namespaces".into()),
    }
}

/// Runs `timegap ARGUMENTS` in a namespace, beside the example's node if there is one. The text has the packets sent.
fn in_namespace(corner: &Corner, node: Option<&str>, arguments: &[&str]) -> Output {
    let python = interpreter().expect("looked for before");
    let begin = node.map_or(String::new(), |node| {
        let (python, xml) = (python.display(), format!("{EXAMPLES}/cyclonedds.xml"));
        format!("CYCLONEDDS_URI=file://{xml} {python} {node} & node=$!\n")
    });
    let end = node.map_or("", |_| "kill $node 2>/dev/null || true\n");
    let script = format!(
        "set -e\n{NAMESPACE}{begin}\"$@\" && status=0 || status=$?\n{end}{SENT}exit $status"
    );
    let mut command = Command::new("unshare");
    command.args(["--net", "--map-root-user", "bash", "-c", &script, "namespace", PROGRAM]);
    command.args(arguments).current_dir(corner.path()).env("XDG_RUNTIME_DIR", corner.path());
    command.stdin(Stdio::null()).output().expect("it starts")
}

fn summary(output: &Output) -> Value {
    assert!(output.status.success(), "{}", text(output));
    serde_json::from_slice(&output.stdout).expect("a summary")
}

fn packets(output: &Output) -> u32 {
    let said = String::from_utf8_lossy(&output.stderr);
    let count = said.lines().find_map(|line| line.strip_prefix("sent ")?.parse().ok());
    count.unwrap_or_else(|| panic!("no count of packets: {said}"))
}

fn a_node_drives_and_nothing_leaves_the_machine() {
    let corner = Corner::new(PROGRAM);
    let node = format!("{EXAMPLES}/ros2_law.py");
    let run = ["run", "following", "--law", "mine=ros2:", "--duration", "8", "--json", "--out"];
    let idle = packets(&in_namespace(&corner, None, &["--version"]));
    let live = in_namespace(&corner, Some(&node), &[&run[..], &["live"]].concat());
    let live_summary = summary(&live);
    assert_eq!(live_summary["outcome"], "completed", "{live_summary}");
    assert_eq!(packets(&live), idle, "{}", text(&live));
    // The same law as a program: in simulated time the same drive.
    let lockstep = ["--mode", "lockstep"];
    let node_run = in_namespace(&corner, Some(&node), &[&run[..], &["node"], &lockstep].concat());
    let program = format!("mine=python3 {EXAMPLES}/my_law.py");
    let run =
        ["run", "following", "--law", &program, "--duration", "8", "--json", "--out", "program"];
    let program_run = in_namespace(&corner, None, &[&run[..], &lockstep].concat());
    let digests =
        |output: &Output| summary(output)["messages"]["control/command"]["digests"].clone();
    assert_eq!(digests(&node_run), digests(&program_run), "{}", text(&node_run));
    assert_eq!(packets(&node_run), idle, "{}", text(&node_run));
    corner.expect_nothing_left(&[]);
}

fn without_a_node_or_with_one_that_dies_the_backup_or_one_line_remains() {
    let corner = Corner::new(PROGRAM);
    let run =
        ["run", "following", "--law", "mine=ros2:3", "--set", "controller.external.patience_s=3"];
    let none = in_namespace(&corner, None, &[&run[..], &["--duration", "3"]].concat());
    assert_eq!(none.status.code(), Some(2), "{}", text(&none));
    assert!(text(&none).contains("no answer within 3 s"), "{}", text(&none));
    assert!(text(&none).contains("waits for a node"), "{}", text(&none));
    // It answers for two seconds and is gone.
    let dying = corner.path().join("dying.py");
    let source = std::fs::read_to_string(format!("{EXAMPLES}/ros2_law.py")).expect("shipped");
    let answer = "        command.write(";
    let source = source
        .replace(answer, &format!("        if question.time_s > 2: raise SystemExit\n{answer}"));
    std::fs::write(&dying, source).expect("ours");
    let dying = dying.display().to_string();
    let run = ["run", "following", "--law", "mine=ros2:", "--duration", "6", "--json"];
    let output = in_namespace(&corner, Some(&dying), &run);
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let summary: Value = serde_json::from_slice(&output.stdout).expect("a summary");
    assert_eq!(summary["outcome"], "driven_by_backup", "{summary}");
    let count = |of: &str| summary["law"][of].as_u64().expect("a count");
    assert!(count("answered") > 10 && count("backup") > 10, "{}", summary["law"]);
    corner.expect_nothing_left(&[]);
}

fn main() -> ExitCode {
    cases::run(&[
        needing(
            needs,
            "a_node_drives_and_nothing_leaves",
            a_node_drives_and_nothing_leaves_the_machine,
        ),
        needing(
            needs,
            "without_a_node_one_line_remains",
            without_a_node_or_with_one_that_dies_the_backup_or_one_line_remains,
        ),
    ])
}
