//! A run's private corner: a directory in memory, a prefix in `/dev/shm`, a lock.
//!
//! The directory is `$XDG_RUNTIME_DIR/timegap-<uid>/<id>`, or the same below `/dev/shm`. Both are file systems in
//! memory. iceoryx2 makes some hundred small files for a run, and waits for the disk with each.

pub mod dead_runs;

use crate::MachineError;
use messages::Service;
use runtime::{Group, Mode, Timetable};
use rustix::fs::{FlockOperation, flock};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use std::fs::{DirBuilder, File};
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicI64, AtomicU32, Ordering};
use std::time::Duration;

/// Name of the lock file in a run's root.
const LOCK: &str = "lock";
/// Longest path of a base directory: event sockets below it must fit in 108 bytes.
const LONGEST_BASE: usize = 24;
/// Attempts to make a root while other runs remove the empty base.
const ATTEMPTS: usize = 100;
/// Time for which a root without a lock is left alone: its owner may be about to lock it.
const GRACE: Duration = Duration::from_secs(60);

fn failed(action: &str, path: &Path) -> impl Fn(io::Error) -> MachineError + use<> {
    MachineError::cannot(format!("{action} {}", path.display()))
}

/// A run's root, locked by this process.
#[derive(Debug)]
pub struct RunRoot {
    path: PathBuf,
    prefix: String,
    lock: File,
}

impl RunRoot {
    /// Makes a new root for this process, after removing what dead runs of this user left.
    pub fn create() -> Result<Self, MachineError> {
        sweep(&base()?);
        // The number separates runs that threads of one launcher start at the same instant. The time separates
        // launchers with the same id in containers that share a directory.
        static NUMBER: AtomicI64 = AtomicI64::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed) & 0xfff;
        let time = runtime::monotonic_ns() & 0xfff;
        let id = format!("{:x}-{:x}", std::process::id(), time << 12 | number);
        let path = create(&id)?;
        // The lock is taken before it has its name: a process that can take it removes the root.
        let unlocked = path.join("unlocked");
        let lock = File::create_new(&unlocked).map_err(failed("create", &unlocked))?;
        flock(&lock, FlockOperation::NonBlockingLockExclusive)
            .map_err(|errno| failed("lock", &unlocked)(errno.into()))?;
        std::fs::rename(&unlocked, path.join(LOCK)).map_err(failed("rename", &unlocked))?;
        Ok(Self { prefix: prefix_of(&id), path, lock })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The group of this run; its members read `scenario`.
    pub fn group(
        &self,
        mode: Mode,
        timetable: Timetable,
        standby: Vec<Service>,
        scenario: String,
    ) -> Group {
        let (root, prefix) = (self.path.clone(), self.prefix.clone());
        let patience_ns = 10_000_000_000;
        Group { root, prefix, mode, timetable, standby, patience_ns, scenario }
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

/// Removes a run's directory and its shared memory.
pub fn wipe(root: &Path) {
    if let Some(id) = root.file_name().and_then(|name| name.to_str()) {
        let prefix = prefix_of(id);
        for entry in std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().starts_with(&prefix) {
                // Another process's clean-up may have been faster.
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
    let _ = std::fs::remove_dir_all(root);
    if let Some(base) = root.parent() {
        // It is removed with its last run: a directory that is not empty stays.
        let _ = std::fs::remove_dir(base);
    }
}

pub fn prefix_of(id: &str) -> String {
    format!("timegap_{id}_")
}

/// Makes the root of this id. A run that ends removes the base when it is empty: then it is made again.
fn create(id: &str) -> Result<PathBuf, MachineError> {
    for _ in 0..ATTEMPTS {
        let path = base()?.join(id);
        match DirBuilder::new().mode(0o700).create(&path) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(reason) => return Err(failed("create", &path)(reason)),
        }
    }
    let base = base()?;
    Err(MachineError(format!("{} is removed as often as it is made", base.display())))
}

/// The user's own directory for all runs.
pub fn base() -> Result<PathBuf, MachineError> {
    let uid = rustix::process::geteuid().as_raw();
    let runtime = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let parent = runtime.filter(|path| is_usable(path, uid));
    let base = parent.unwrap_or_else(|| SHARED_MEMORY.into()).join(format!("timegap-{uid}"));
    match DirBuilder::new().mode(0o700).create(&base) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => {
            return Err(failed("create", &base)(error));
        }
        _ => {}
    }
    let found = match std::fs::symlink_metadata(&base) {
        // Another launcher's last run has just removed it; it is made again when it is needed.
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(base),
        found => found.map_err(failed("examine", &base))?,
    };
    let own = found.is_dir() && found.uid() == uid && found.permissions().mode() & 0o077 == 0;
    let expected =
        "is not a directory that belongs to this user alone: remove it, or set XDG_RUNTIME_DIR";
    if own { Ok(base) } else { Err(MachineError(format!("{} {expected}", base.display()))) }
}

/// True if `path` is a directory of this user. It must be short enough for the names of sockets below it. Its
/// characters must be those that iceoryx2 takes in a path.
fn is_usable(path: &Path, uid: u32) -> bool {
    path.is_absolute()
        && path.as_os_str().len() <= LONGEST_BASE
        && path
            .as_os_str()
            .as_bytes()
            .iter()
            .all(|b| b.is_ascii_alphanumeric() || b"/._-".contains(b))
        && path.metadata().is_ok_and(|found| found.is_dir() && found.uid() == uid)
}

/// Removes the roots below `base` whose processes are all gone.
fn sweep(base: &Path) {
    for entry in std::fs::read_dir(base).into_iter().flatten().flatten() {
        let root = entry.path();
        let dead = match open_lock(&root) {
            Ok(lock) => flock(&lock, FlockOperation::NonBlockingLockExclusive).is_ok(),
            Err(_) => {
                let modified = entry.metadata().and_then(|metadata| metadata.modified());
                owner_is_gone(&root)
                    || modified.is_ok_and(|time| time.elapsed().is_ok_and(|age| age > GRACE))
            }
        };
        if dead {
            tracing::debug!("removing what a dead run left at {}", root.display());
            wipe(&root);
        }
    }
}

/// True if the process whose id the root's name begins with does not exist.
pub fn owner_is_gone(root: &Path) -> bool {
    let name = root.file_name().map(|name| name.to_string_lossy().into_owned());
    let pid = name.and_then(|name| u32::from_str_radix(name.split('-').next()?, 16).ok());
    pid.is_some_and(|pid| !Path::new("/proc").join(pid.to_string()).exists())
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_runtime_directory_is_short_and_the_users_own() {
        let uid = rustix::process::geteuid().as_raw();
        let here = std::env::temp_dir();
        assert!(!is_usable(Path::new("relative"), uid));
        assert!(!is_usable(Path::new("/no/such/directory"), uid));
        assert!(!is_usable(&here, uid + 1), "another user's");
        let long = here.join("a-name-that-makes-sockets-too-long");
        std::fs::create_dir_all(&long).expect("the temporary directory is writable");
        assert!(!is_usable(&long, uid));
        std::fs::remove_dir(&long).expect("ours");
        let short = Path::new("/tmp").join(format!("{:x}", std::process::id()));
        for name in ["%ü", "\n"] {
            let odd = short.with_extension(name);
            std::fs::create_dir_all(&odd).expect("/tmp is writable");
            assert!(!is_usable(&odd, uid), "{odd:?}");
            std::fs::remove_dir(&odd).expect("ours");
        }
        std::fs::create_dir_all(&short).expect("/tmp is writable");
        assert!(is_usable(&short, uid));
        std::fs::remove_dir(&short).expect("ours");
    }

    #[test]
    fn a_sweep_spares_the_living_and_removes_the_dead() {
        let base = std::env::temp_dir().join(format!("timegap-sweep-{}", std::process::id()));
        let [living, dead, young] = ["living", "dead", "young"].map(|name| base.join(name));
        for root in [&living, &dead, &young] {
            std::fs::create_dir_all(root).expect("the temporary directory is writable");
        }
        let lock = File::create_new(living.join(LOCK)).expect("new directory");
        flock(&lock, FlockOperation::NonBlockingLockExclusive).expect("only this test knows it");
        File::create_new(dead.join(LOCK)).expect("new directory");
        sweep(&base);
        assert!(living.exists() && !dead.exists() && young.exists());
        std::fs::remove_dir_all(&base).expect("ours");
    }
}
