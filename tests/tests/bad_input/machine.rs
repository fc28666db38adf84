//! Limits and faults of the machine: exit status 3, one sentence that names the place, and nothing left.

use super::PROGRAM;
use std::process::Command;
use system_tests::{Corner, text};

pub fn low_limits_of_the_machine() {
    let corner = Corner::new(PROGRAM);
    for (limit, words) in [
        ("-n 32", ["32 files", "ulimit -n"]),
        ("-v 1000000", ["1000000 KiB of address space", "ulimit -v"]),
        ("-s 256", ["256 KiB", "ulimit -s"]),
        ("-f 1000", ["a process may write files of", "ulimit -f"]),
    ] {
        let line = format!("ulimit {limit}; exec \"$0\" run cacc-a --mode lockstep");
        let output = Command::new("sh")
            .args(["-c", &line, PROGRAM])
            .current_dir(corner.path())
            .env("XDG_RUNTIME_DIR", corner.path())
            .output()
            .expect("a shell starts");
        let said = text(&output);
        assert_eq!(output.status.code(), Some(3), "{limit}: {said}");
        assert!(words.iter().all(|word| said.contains(word)), "{limit}: {said}");
        assert!(!corner.path().join("runs").exists(), "nothing is left of a run that never was");
    }
}

/// A failed print is an error.
pub fn a_full_standard_output() {
    let corner = Corner::new(PROGRAM);
    for arguments in [["list"].as_slice(), &["run", "cacc-a", "--mode", "lockstep", "--json"]] {
        let full = std::fs::File::options().write(true).open("/dev/full").expect("it is there");
        let output = corner.command(arguments).stdout(full).output().expect("it starts");
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {}", text(&output));
        assert!(text(&output).contains("standard output"), "{}", text(&output));
    }
}

pub fn a_foreign_base_directory() {
    let corner = Corner::new(PROGRAM);
    let uid = rustix::process::geteuid().as_raw();
    let base = corner.path().join(format!("timegap-{uid}"));
    std::os::unix::fs::symlink("/tmp", &base).expect("our own directory");
    let output = corner.run(&["run", "cacc-a", "--mode", "lockstep"]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output));
    assert!(text(&output).contains("belongs to this user alone"), "{}", text(&output));
}

/// A full /dev/shm of our own, in a mount namespace if the kernel grants one.
pub fn full_shared_memory() {
    let script = |size: &str| {
        format!(
            "mount -t tmpfs -o size={size} none /dev/shm && exec \"$0\" run cacc-a --mode lockstep"
        )
    };
    let corner = Corner::new(PROGRAM);
    let run = |size: &str| {
        Command::new("unshare")
            .args(["--user", "--map-root-user", "--mount", "sh", "-c", &script(size), PROGRAM])
            .current_dir(corner.path())
            .env("XDG_RUNTIME_DIR", corner.path())
            .output()
    };
    let output = run("64m").expect("it starts");
    assert!(output.status.success(), "with enough room: {}", text(&output));
    for size in ["64k", "200k", "1m"] {
        let output = run(size).expect("it started before");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(3), "{size}: {}", text(&output));
        assert!(said.contains("/dev/shm"), "{size}: {said}");
        corner.expect_nothing_left(&[]);
    }
}

/// A read-only /dev/shm: one sentence that names it.
pub fn read_only_shared_memory() {
    let corner = Corner::new(PROGRAM);
    let script = "mount -t tmpfs -o ro none /dev/shm && exec \"$0\" run cacc-a --mode lockstep";
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", script, PROGRAM])
        .current_dir(corner.path())
        .output()
        .expect("it started before");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{}", text(&output));
    assert!(said.contains("/dev/shm cannot be written") && said.lines().count() == 1, "{said}");
    assert!(!corner.path().join("runs").exists(), "nothing is left of a run that never was");
}

/// A full disk: the results are printed, then the error, and no partial file is left.
pub fn full_disk() {
    let corner = Corner::new(PROGRAM);
    let disk = corner.path().join("disk");
    std::fs::create_dir(&disk).expect("our own directory");
    let script = "mount -t tmpfs -o size=40k none disk && { \"$0\" run cacc-a --mode lockstep \
                  --out disk/out; status=$?; ls disk/out >&2; exit $status; }";
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", script, PROGRAM])
        .current_dir(corner.path())
        .env("XDG_RUNTIME_DIR", corner.path())
        .output()
        .expect("it starts");
    let said = text(&output);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("crossing") && said.contains("No space left"), "{said}");
    assert!(!said.contains("report  "), "a page is named that is not there: {said}");
    assert!(!said.contains(".part") && !said.contains(".new"), "a half file is left: {said}");
    assert!(!said.contains("read too late"), "the disk is why messages are lost: {said}");
}
