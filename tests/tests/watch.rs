//! A run without the terminal that it was started in.

use rustix::process::{Pid, Signal, kill_process};
use std::process::{Command, Stdio};
use system_tests::{Corner, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// `nohup` starts programs with SIGHUP ignored.
#[test]
fn an_ignored_hang_up_stays_ignored() {
    let corner = Corner::new(PROGRAM);
    let run = Command::new("sh")
        .args(["-c", "trap '' HUP; exec \"$0\" run cacc-a --duration 2 --out out", PROGRAM])
        .current_dir(corner.path())
        .env("XDG_RUNTIME_DIR", corner.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell starts");
    assert!(wait_for(|| corner.path().join("out/live.json").exists()), "never drove");
    let pid = Pid::from_raw(i32::try_from(run.id()).expect("fits")).expect("not zero");
    kill_process(pid, Signal::HUP).expect("our own process, not yet waited for");
    let output = run.wait_with_output().expect("our own child");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output));
}
