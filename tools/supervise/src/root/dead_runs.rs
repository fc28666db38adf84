//! Runs whose launcher is gone although they still hold processes, shared memory or a directory.
//!
//! The janitor removes a run whose launcher was killed, and the next run removes what a dead janitor left. This
//! module names what is there in between.

use crate::root::room::SHARED_MEMORY;
use crate::root::{base, owner_is_gone, prefix_of};
use std::collections::BTreeMap;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

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

/// All dead runs of this user.
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
