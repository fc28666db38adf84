//! Runs whose launcher is gone although they still hold processes, shared memory or a directory.
//!
//! The janitor removes a run whose launcher was killed, and the next run removes what a dead janitor left. This
//! module names what is there in between.

use crate::root::SHARED_MEMORY;
use crate::root::{base, owner_is_gone, prefix_of};
use std::collections::BTreeMap;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// A run without its launcher.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeadRun {
    /// Directory of the run, which may be gone.
    pub root: PathBuf,
    /// Prefix of its shared-memory objects.
    pub prefix: String,
    /// Size of these objects, bytes.
    pub shared_bytes: u64,
    pub processes: Vec<u32>,
}

pub fn dead_runs() -> Vec<DeadRun> {
    let Ok(base) = base() else { return Vec::new() };
    let found = below(&base, Path::new(SHARED_MEMORY));
    // `base` makes the directory; one with runs stays.
    let _ = std::fs::remove_dir(&base);
    found
}

fn below(base: &Path, shared_memory: &Path) -> Vec<DeadRun> {
    let uid = rustix::process::geteuid().as_raw();
    let mut found: BTreeMap<String, u64> = BTreeMap::new();
    for entry in std::fs::read_dir(base).into_iter().flatten().flatten() {
        found.entry(entry.file_name().to_string_lossy().into_owned()).or_default();
    }
    for entry in std::fs::read_dir(shared_memory).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let id = name.strip_prefix("timegap_").and_then(|rest| rest.split('_').next());
        let Some((id, metadata)) = id.zip(entry.metadata().ok()) else { continue };
        if metadata.uid() == uid {
            *found.entry(id.to_owned()).or_default() += metadata.len();
        }
    }
    let dead = found.into_iter().filter(|(id, _)| owner_is_gone(Path::new(id)));
    dead.map(|(id, shared_bytes)| {
        let root = base.join(&id);
        let processes = processes_of(&root);
        DeadRun { prefix: prefix_of(&id), root, shared_bytes, processes }
    })
    .collect()
}

/// Living processes with `root` among their arguments.
fn processes_of(root: &Path) -> Vec<u32> {
    let root = root.to_string_lossy();
    let mut found = Vec::new();
    for entry in std::fs::read_dir("/proc").into_iter().flatten().flatten() {
        let Ok(pid) = entry.file_name().to_string_lossy().parse() else { continue };
        let line = std::fs::read(entry.path().join("cmdline")).unwrap_or_default();
        if String::from_utf8_lossy(&line).split('\0').any(|word| word == root) {
            found.push(pid);
        }
    }
    found
}

/// Time for which an object without content and without a maker's process in its name is left alone.
const YOUNG: Duration = Duration::from_millis(100);
/// The bits of an object's mode while it is made: its owner may write it, and nothing else is granted.
const UNFINISHED: u32 = 0o200;

/// Removes what process `pid` of the run with this prefix, which is gone, has not finished.
pub fn remove_unfinished(prefix: &str, pid: u32) {
    for entry in std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(name) = name.to_str().and_then(|name| name.strip_prefix(prefix)) else { continue };
        // Another process may have removed it.
        let Ok(found) = entry.metadata() else { continue };
        if found.size() > 0 || found.mode() & 0o777 != UNFINISHED {
            continue;
        }
        let age =
            found.modified().ok().and_then(|then| SystemTime::now().duration_since(then).ok());
        if names(name, pid) || age.is_some_and(|age| age > YOUNG) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// True if one of the numbers in an object's name is a port's id of this process. iceoryx2's ids
/// are seconds, nanoseconds, process and counter.
fn names(name: &str, pid: u32) -> bool {
    let ids = name.split(['_', '.']).filter_map(|part| part.parse::<u128>().ok());
    ids.into_iter().any(|id| (id >> 64) as u32 == pid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;
    use std::path::PathBuf;

    #[test]
    fn a_run_of_a_dead_process_is_found_and_one_of_a_living_process_is_not() {
        let place = std::env::temp_dir().join(format!("timegap-dead-{}", std::process::id()));
        let (base, shared) = (place.join("base"), place.join("shm"));
        // No process can have the largest id of 32 bits.
        let (dead, living) = ("ffffffff-1", format!("{:x}-2", std::process::id()));
        for directory in [&base.join(dead), &base.join(&living), &shared] {
            std::fs::create_dir_all(directory).expect("the temporary directory is writable");
        }
        std::fs::write(shared.join("timegap_ffffffff-1_wake"), "1234").expect("ours");
        std::fs::write(shared.join("timegap_fffffffe-3_wake"), "12").expect("ours");
        std::fs::write(shared.join("another"), "12").expect("ours");
        let found = below(&base, &shared);
        std::fs::remove_dir_all(&place).expect("ours");
        let seen: Vec<_> = found.iter().map(|run| (&*run.prefix, run.shared_bytes)).collect();
        assert_eq!(seen, [("timegap_fffffffe-3_", 2), ("timegap_ffffffff-1_", 4)]);
        assert!(found.iter().all(|run| run.processes.is_empty() && run.root.starts_with(&base)));
    }

    #[test]
    fn only_what_the_dead_process_was_making_is_removed() {
        let prefix = format!("timegap_unfinished-{}_", std::process::id());
        let id = |pid: u32| (7_u128 << 96) | (u128::from(pid) << 64) | 99;
        let make = |name: &str, mode: u32, text: &str| {
            let path = PathBuf::from(SHARED_MEMORY).join(format!("{prefix}{name}"));
            std::fs::write(&path, text).expect("shared memory is writable");
            std::fs::set_permissions(&path, PermissionsExt::from_mode(mode)).expect("ours");
            path
        };
        let dead = make(&format!("_a1_{}_{}.connection", id(17), id(18)), 0o200, "");
        let others = make(&format!("_a1_{}_{}.connection", id(19), id(18)), 0o200, "");
        let whole = make(&format!("_a1_{}.data", id(17)), 0o600, "");
        let sized = make(&format!("_b1_{}.data", id(17)), 0o200, "x");
        remove_unfinished(&prefix, 17);
        let left = [&dead, &others, &whole, &sized].map(|path| path.exists());
        for path in [&others, &whole, &sized] {
            std::fs::remove_file(path).expect("ours");
        }
        assert_eq!(left, [false, true, true, true]);
    }
}
