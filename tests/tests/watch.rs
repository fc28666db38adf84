//! A run in a terminal, and after the terminal was closed.

use rustix::process::{Pid, Signal, kill_process};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use std::fs::File;
use std::os::fd::OwnedFd;
use std::process::{Command, Stdio};
use system_tests::{Corner, ignore_no_hang_up, text, wait_for};

const PROGRAM: &str = env!("CARGO_BIN_EXE_timegap-under-test");

/// A pseudo-terminal: the end of a terminal emulator, and the end of a program.
fn terminal() -> (OwnedFd, File) {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)
        .expect("a pseudo-terminal");
    grantpt(&master).expect("ours");
    unlockpt(&master).expect("ours");
    let name = ptsname(&master, Vec::new()).expect("it has a name");
    let path = name.to_str().expect("an ASCII path");
    let slave = File::options().read(true).write(true).open(path).expect("ours");
    (master, slave)
}

/// The terminal does not control the run, so that no SIGHUP helps.
#[test]
fn a_run_ends_with_its_terminal() {
    ignore_no_hang_up();
    let corner = Corner::new(PROGRAM);
    for (name, options, prints_there) in
        [("watched", ["--watch"].as_slice(), false), ("printing", &[], true)]
    {
        let (master, slave) = terminal();
        let end = || Stdio::from(slave.try_clone().expect("a descriptor"));
        let command = ["run", "following", "--duration", "600", "--out", name];
        let mut command = corner.command(&[&command, options].concat());
        command.stdin(end()).stderr(end());
        if prints_there {
            command.stdout(end());
        }
        let mut run = command.spawn().expect("it starts");
        drop(command);
        drop(slave);
        assert!(wait_for(|| corner.path().join(name).join("live.json").exists()), "never drove");
        if prints_there {
            // The signal of a closed terminal to its processes.
            let pid = Pid::from_raw(i32::try_from(run.id()).expect("fits")).expect("not zero");
            kill_process(pid, Signal::HUP).expect("our own process, not yet waited for");
        }
        drop(master);
        let mut status = None;
        let ended = wait_for(|| {
            status = run.try_wait().expect("our own child");
            status.is_some()
        });
        if !ended {
            run.kill().expect("our own child");
            run.wait().expect("our own child");
        }
        assert_eq!(status.and_then(|status| status.code()), Some(130), "{name}: as after Ctrl-C");
        corner.expect_nothing_left(&[]);
    }
}

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
