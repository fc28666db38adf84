//! A run's private corner: a directory in the temporary directory, a prefix in `/dev/shm`, a lock.

use crate::Error;
use rustix::fs::{FlockOperation, flock};
use std::fs::{DirBuilder, File};
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Duration;

/// Where POSIX shared memory lives.
const SHARED_MEMORY: &str = "/dev/shm";
/// Name of the lock file in a run's root.
const LOCK: &str = "lock";
/// Longest path of a base directory: event sockets below it must fit in 108 bytes.
const LONGEST_BASE: usize = 24;
/// A root without a lock is left alone for so long: its owner may be about to lock it.
const GRACE: Duration = Duration::from_secs(60);

/// A run's root, locked by this process.
#[derive(Debug)]
pub struct RunRoot {
    path: PathBuf,
    prefix: String,
    lock: File,
}

impl RunRoot {
    /// Makes a new root for this process, after removing what dead runs of this user left.
    pub fn create() -> Result<Self, Error> {
        let base = base()?;
        sweep(&base);
        // The number keeps apart runs that threads of one launcher start at the same instant, the
        // time those of launchers with the same id in containers that share a directory.
        static NUMBER: AtomicI64 = AtomicI64::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed) & 0xfff;
        let time = runtime::monotonic_ns() & 0xfff;
        let id = format!("{:x}-{:x}", std::process::id(), time << 12 | number);
        let path = base.join(&id);
        let error = |reason| Error::Path { action: "create", path: path.clone(), reason };
        DirBuilder::new().mode(0o700).create(&path).map_err(error)?;
        // Nobody may find the lock before it is taken: who can take it removes the root.
        let unlocked = path.join("unlocked");
        let lock = File::create_new(&unlocked).map_err(error)?;
        flock(&lock, FlockOperation::NonBlockingLockExclusive)
            .map_err(|e| Error::Machine(format!("cannot lock {}: {e}", path.display())))?;
        std::fs::rename(&unlocked, path.join(LOCK)).map_err(error)?;
        Ok(Self { prefix: prefix_of(&id), path, lock })
    }

    /// The directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Prefix of the run's shared-memory objects.
    pub fn prefix(&self) -> &str {
        &self.prefix
    }

    /// The lock, to be inherited by every service.
    pub fn lock(&self) -> BorrowedFd<'_> {
        self.lock.as_fd()
    }

    /// Removes the root and the run's shared memory. All services must be gone.
    pub fn remove(self) {
        wipe(&self.path);
    }
}

/// Opens the lock of the run at `root` without taking it.
pub fn open_lock(root: &Path) -> io::Result<File> {
    File::open(root.join(LOCK))
}

/// True while some process of the run at `root` lives.
pub fn is_alive(root: &Path) -> bool {
    open_lock(root)
        .is_ok_and(|lock| flock(&lock, FlockOperation::NonBlockingLockExclusive).is_err())
}

/// Checks that shared memory has room for `needed` bytes: a page that cannot be had later would end
/// the process that touches it.
pub fn check_room(needed: u64) -> Result<(), Error> {
    let (_, free) = shared_memory_room()?;
    if free >= needed {
        return Ok(());
    }
    let [free, needed] = [free, needed].map(|bytes| bytes.div_ceil(1024));
    Err(Error::Machine(format!(
        "{SHARED_MEMORY} has {free} KiB free and a run may use {needed} KiB: free some, or enlarge \
         it with `mount -o remount,size=64m {SHARED_MEMORY}`"
    )))
}

/// Size of the file system of the shared memory and what is free of it, bytes.
pub fn shared_memory_room() -> Result<(u64, u64), Error> {
    let found = rustix::fs::statvfs(SHARED_MEMORY)
        .map_err(|e| Error::Machine(format!("{SHARED_MEMORY} is needed for shared memory: {e}")))?;
    Ok((found.f_blocks * found.f_frsize, found.f_bavail * found.f_frsize))
}

/// Removes a run's directory and its shared memory.
pub fn wipe(root: &Path) {
    if let Some(id) = root.file_name().and_then(|name| name.to_str()) {
        let prefix = prefix_of(id);
        for entry in std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&prefix) {
                // Somebody else's clean-up may have been faster.
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
    let _ = std::fs::remove_dir_all(root);
}

fn prefix_of(id: &str) -> String {
    format!("timegap_{id}_")
}

/// The user's own directory for all runs.
pub fn base() -> Result<PathBuf, Error> {
    let uid = rustix::process::geteuid().as_raw();
    let temporary = std::env::temp_dir();
    let temporary = if temporary.as_os_str().len() > LONGEST_BASE || !temporary.is_absolute() {
        PathBuf::from("/tmp")
    } else {
        temporary
    };
    let base = temporary.join(format!("timegap-{uid}"));
    match DirBuilder::new().mode(0o700).create(&base) {
        Err(e) if e.kind() != io::ErrorKind::AlreadyExists => {
            return Err(Error::Machine(format!("cannot create {}: {e}", base.display())));
        }
        _ => {}
    }
    let found = std::fs::symlink_metadata(&base)
        .map_err(|e| Error::Machine(format!("cannot examine {}: {e}", base.display())))?;
    if !found.is_dir() || found.uid() != uid || found.permissions().mode() & 0o077 != 0 {
        return Err(Error::Machine(format!(
            "{} is not a directory that belongs to this user alone: remove it, or set TMPDIR",
            base.display()
        )));
    }
    Ok(base)
}

/// Removes the roots below `base` whose processes are all gone.
fn sweep(base: &Path) {
    for entry in std::fs::read_dir(base).into_iter().flatten().flatten() {
        let root = entry.path();
        let dead = match open_lock(&root) {
            Ok(lock) => flock(&lock, FlockOperation::NonBlockingLockExclusive).is_ok(),
            Err(_) => entry
                .metadata()
                .and_then(|metadata| metadata.modified())
                .is_ok_and(|modified| modified.elapsed().is_ok_and(|age| age > GRACE)),
        };
        if dead {
            tracing::debug!("removing what a dead run left at {}", root.display());
            wipe(&root);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_spares_the_living_and_removes_the_dead() {
        let base = std::env::temp_dir().join(format!("timegap-sweep-{}", std::process::id()));
        let [living, dead, young] = ["living", "dead", "young"].map(|name| base.join(name));
        for root in [&living, &dead, &young] {
            std::fs::create_dir_all(root).expect("the temporary directory is writable");
        }
        let lock = File::create_new(living.join(LOCK)).expect("new directory");
        flock(&lock, FlockOperation::NonBlockingLockExclusive).expect("nobody else knows it");
        File::create_new(dead.join(LOCK)).expect("new directory");
        sweep(&base);
        assert!(living.exists() && !dead.exists() && young.exists());
        std::fs::remove_dir_all(&base).expect("ours");
    }
}
