//! Storage of a run: shared memory and sockets.

use super::finding::Finding;
use std::path::Path;
use supervise::{DeadRun, MachineError};

/// Room in the file system of the shared memory, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    pub size: u64,
    pub free: u64,
}

/// Room for a run of `needed` bytes on a machine with `memory` bytes of available memory.
pub fn shared_memory(
    room: Result<Room, MachineError>,
    needed: u64,
    memory: Option<u64>,
) -> Finding {
    const CHECK: &str = "shared memory";
    let room = match room {
        Ok(room) => room,
        Err(error) => {
            let fix = "sudo mkdir -p /dev/shm && sudo mount -t tmpfs -o size=64m tmpfs /dev/shm";
            return Finding::fatal(CHECK, error.to_string(), fix);
        }
    };
    let [size, free, needed_kib] = [room.size, room.free, needed].map(|bytes| bytes.div_ceil(1024));
    let runs = room.free / needed.max(1);
    let found = format!("{free} of {size} KiB free, room for {runs} runs at once");
    if runs == 0 {
        let enlarged = (room.size - room.free + 4 * needed).div_ceil(1 << 20);
        let found = format!("{free} of {size} KiB free, and a run may use {needed_kib} KiB");
        let fix = format!("sudo mount -o remount,size={enlarged}m /dev/shm");
        return Finding::fatal(CHECK, found, &fix);
    }
    match memory {
        Some(memory) if memory < needed => Finding::warn(
            CHECK,
            found,
            format!("only {} KiB of memory back it", memory.div_ceil(1024)),
            None,
        ),
        _ => Finding::ok(CHECK, found),
    }
}

/// The directory for the runs' small files: the one in use, and the one that XDG_RUNTIME_DIR requests.
pub fn run_directory(base: Result<&Path, &MachineError>, asked: Option<&Path>) -> Finding {
    const CHECK: &str = "run directory";
    match base {
        Err(error) => Finding::fatal(CHECK, error.to_string(), "unset XDG_RUNTIME_DIR"),
        Ok(base) => match asked {
            Some(asked) if !base.starts_with(asked) => Finding::warn(
                CHECK,
                format!("{}, not below XDG_RUNTIME_DIR = {}", base.display(), asked.display()),
                "that directory is not this user's own, or its name is too long for the names of \
                 sockets below it (108 bytes); nothing else",
                Some("unset XDG_RUNTIME_DIR".into()),
            ),
            _ => Finding::ok(CHECK, base.display().to_string()),
        },
    }
}

/// Runs whose launcher is gone, with what they hold.
pub fn leftovers(dead: &[DeadRun]) -> Finding {
    const CHECK: &str = "leftovers";
    if dead.is_empty() {
        return Finding::ok(CHECK, "every run of this user that ended is gone");
    }
    let kib = dead.iter().map(|run| run.shared_bytes).sum::<u64>().div_ceil(1024);
    let processes: usize = dead.iter().map(|run| run.processes.len()).sum();
    let found = format!(
        "{} ended without cleaning up: {kib} KiB of shared memory, {processes} processes",
        report::print::counted(dead.len() as u64, "run"),
    );
    let kill = dead.iter().flat_map(|run| &run.processes).map(|pid| format!(" {pid}"));
    let kill: String = kill.collect();
    let kill = if kill.is_empty() { String::new() } else { format!("kill -9{kill}; ") };
    let objects =
        dead.iter().map(|run| format!(" /dev/shm/{}* {}", run.prefix, run.root.display()));
    let fix = format!("{kill}rm -rf{}", objects.collect::<String>());
    Finding::warn(CHECK, found, "they hold memory and may slow this machine", Some(fix))
}

/// Available memory, bytes, from `/proc/meminfo`.
pub fn available_memory(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().trim_end_matches(" kB").parse().ok()?;
    Some(kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::super::finding::Verdict;
    use super::*;

    const MIB: u64 = 1 << 20;

    #[test]
    fn shared_memory_of_several_machines() {
        let room = |size, free| Ok(Room { size: size * MIB, free: free * MIB });
        let desktop = shared_memory(room(8192, 8000), 4 * MIB, Some(16_000 * MIB));
        assert_eq!(desktop.verdict, Verdict::Ok);
        assert!(desktop.found.contains("2000 runs"), "{desktop:?}");
        assert!(!shared_memory(room(64, 60), 4 * MIB, None).prevents_runs, "a container's 64 MiB");
        let full = shared_memory(room(64, 3), 4 * MIB, None);
        assert!(full.prevents_runs);
        assert_eq!(full.fix.as_deref(), Some("sudo mount -o remount,size=77m /dev/shm"));
        let missing = MachineError("/dev/shm is needed for shared memory".into());
        let none = shared_memory(Err(missing), MIB, None);
        assert!(none.prevents_runs && none.found.contains("/dev/shm is needed"));
        assert_eq!(shared_memory(room(64, 60), 4 * MIB, Some(MIB)).verdict, Verdict::Warn);
    }

    #[test]
    fn a_long_or_missing_run_directory() {
        let used = Path::new("/run/user/7/timegap-7");
        assert_eq!(run_directory(Ok(used), None).verdict, Verdict::Ok);
        assert_eq!(run_directory(Ok(used), Some(Path::new("/run/user/7"))).verdict, Verdict::Ok);
        let long = Path::new("/var/lib/users/with/a/long/name");
        assert_eq!(run_directory(Ok(used), Some(long)).verdict, Verdict::Warn);
        let refused = MachineError("it is removed as often as it is made".into());
        assert!(run_directory(Err(&refused), None).prevents_runs);
    }

    #[test]
    fn a_killed_group_is_named_with_the_command_that_removes_it() {
        assert_eq!(leftovers(&[]).verdict, Verdict::Ok);
        let run = DeadRun {
            root: "/run/user/7/timegap-7/1f-2".into(),
            prefix: "timegap_1f-2_".into(),
            shared_bytes: 4096,
            processes: vec![77],
        };
        let found = leftovers(&[run]);
        assert_eq!(found.verdict, Verdict::Warn);
        assert!(found.found.starts_with("1 run ") && found.found.contains("4 KiB"), "{found:?}");
        let fix = "kill -9 77; rm -rf /dev/shm/timegap_1f-2_* /run/user/7/timegap-7/1f-2";
        assert_eq!(found.fix.as_deref(), Some(fix));
    }

    #[test]
    fn available_memory_from_its_file() {
        let text = "MemTotal:       24684084 kB\nMemAvailable:    1024 kB\n";
        assert_eq!(available_memory(text), Some(MIB));
        assert_eq!(available_memory(""), None);
    }
}
