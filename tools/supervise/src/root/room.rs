//! Needs of a run, checked before the start. A refusal is then one line; a process that met the lack later would die.

use crate::MachineError;
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

/// Folder of POSIX shared memory.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";
/// Files that a process of a group may need to have open. The launcher of `truck-follow` with a recorder has
/// 78, its recorder 76, its controller 57.
const OPEN_FILES: u64 = 128;
/// Address space that a process of a group may need, bytes. The launcher of `corridor` has 1,060 MiB: each thread
/// reserves some, and uses next to none of it.
const ADDRESS_SPACE: u64 = 1536 << 20;

/// Checks that shared memory can be written and has room for `needed` bytes. Later a missing page would end the
/// process that touches it. Checks also that processes may open the files of a run.
///
/// # Errors
/// The missing resource, and the way to get it.
pub fn check_room(needed: u64) -> Result<(), MachineError> {
    check_writable()?;
    let (_, free) = shared_memory_room()?;
    let needed_kib = needed.div_ceil(1024);
    if free < needed {
        return Err(MachineError(format!(
            "{SHARED_MEMORY} has {} KiB free and a run may use {needed_kib} KiB: free some, or enlarge it with \
             `mount -o remount,size=64m {SHARED_MEMORY}`",
            free.div_ceil(1024)
        )));
    }
    if let Some(allowed) = getrlimit(Resource::Fsize).current.filter(|allowed| *allowed < needed) {
        // Shared memory is files.
        return Err(MachineError(format!(
            "a process may write files of {} KiB and a run may use {needed_kib} KiB of shared memory: raise the \
             limit with `ulimit -f unlimited`",
            allowed / 1024
        )));
    }
    check_address_space()?;
    check_open_files()
}

/// Size of the file system of the shared memory and what is free of it, bytes.
pub fn shared_memory_room() -> Result<(u64, u64), MachineError> {
    let found = rustix::fs::statvfs(SHARED_MEMORY).map_err(|error| {
        MachineError(format!("{SHARED_MEMORY} is needed for shared memory: {error}"))
    })?;
    Ok((found.f_blocks * found.f_frsize, found.f_bavail * found.f_frsize))
}

/// Makes an object in shared memory and removes it.
fn check_writable() -> Result<(), MachineError> {
    static NUMBER: AtomicU32 = AtomicU32::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let name = format!("timegap-probe-{}-{number}", std::process::id());
    let path = Path::new(SHARED_MEMORY).join(name);
    let made = std::fs::OpenOptions::new().write(true).create_new(true).mode(0o600).open(&path);
    made.and_then(|_| std::fs::remove_file(&path)).map_err(|error| {
        MachineError(format!(
            "{SHARED_MEMORY} cannot be written ({error}): messages go through it; mount it with \
             `mount -t tmpfs -o size=64m tmpfs {SHARED_MEMORY}`"
        ))
    })
}

fn check_address_space() -> Result<(), MachineError> {
    match getrlimit(Resource::As).current {
        Some(allowed) if allowed < ADDRESS_SPACE => {
            // It would end at an allocation, without a word.
            Err(MachineError(format!(
                "a process may have {} KiB of address space and one of a run needs up to {} KiB: raise the limit \
                 with `ulimit -v unlimited`",
                allowed / 1024,
                ADDRESS_SPACE / 1024
            )))
        }
        _ => Ok(()),
    }
}

/// Raises the limit of open files as far as the machine allows, and checks that it is enough.
fn check_open_files() -> Result<(), MachineError> {
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    // An unlimited number is absent here.
    if current != maximum {
        // A refused limit stays as it was; the check below decides whether it is enough.
        let _ = setrlimit(Resource::Nofile, Rlimit { current: maximum, maximum });
    }
    let allowed = getrlimit(Resource::Nofile).current.unwrap_or(u64::MAX);
    if allowed >= OPEN_FILES {
        return Ok(());
    }
    Err(MachineError(format!(
        "a process may have {allowed} files open and one of a run needs up to {OPEN_FILES}: raise the limit with \
         `ulimit -n {OPEN_FILES}`"
    )))
}
