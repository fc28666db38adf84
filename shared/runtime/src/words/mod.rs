//! Memory that the processes of a run share: structs of atomic numbers.

#![allow(unsafe_code, reason = "no crate maps shared memory as atomic numbers")]

use messages::{Service, TOPICS, Topic};
use rustix::fs::{FallocateFlags, OFlags, fallocate};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use std::alloc::{Layout, alloc_zeroed, dealloc, handle_alloc_error};
use std::fs::{File, OpenOptions};
use std::io::{self, Error, ErrorKind};
use std::ops::Deref;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, AtomicU64};

pub(crate) const PAGE_BYTES: usize = 4096;

pub type SharedWords = Shared<[AtomicU32; PAGE_BYTES / size_of::<AtomicU32>()]>;

/// A type of which shared memory can hold a value.
///
/// # Safety
/// It is `repr(C)` and has atomic numbers alone. So all zeros are a value, and every process may write at any time.
pub unsafe trait Atomics {}

// SAFETY: they are what the trait asks for.
unsafe impl Atomics for AtomicU32 {}
// SAFETY: as above.
unsafe impl Atomics for AtomicU64 {}
// SAFETY: as its elements are.
unsafe impl<T: Atomics, const N: usize> Atomics for [T; N] {}

/// A `T` in `/dev/shm`, zero at first and the same for all who map it. Or one that this process has alone.
///
/// The first process makes the file, and it stays valid when any of them dies. It is removed with everything else that
/// carries the run's prefix.
#[derive(Debug)]
pub struct Shared<T: Atomics> {
    place: NonNull<T>,
    is_mapped: bool,
}

// SAFETY: the memory belongs to the process, not to a thread, and is only ever accessed as atomic numbers.
unsafe impl<T: Atomics> Send for Shared<T> {}
// SAFETY: as above.
unsafe impl<T: Atomics> Sync for Shared<T> {}

impl<T: Atomics> Shared<T> {
    /// Maps the file called `name`.
    ///
    /// # Errors
    /// If it cannot be created, there is no room for it, or it is another user's.
    pub fn map(name: &str) -> io::Result<Self> {
        Self::of(&open_own(&Path::new("/dev/shm").join(name))?, 0)
    }

    /// Maps the part of `file` that begins at `offset`, at the begin of a page. It gets memory if it has none.
    pub(crate) fn of(file: &File, offset: usize) -> io::Result<Self> {
        const { assert!(align_of::<T>() <= PAGE_BYTES) };
        let (offset, bytes) = (offset as u64, size_of::<T>());
        // A page that cannot be had is an error here, and would be a SIGBUS later.
        fallocate(file, FallocateFlags::empty(), offset, bytes as u64)?;
        let protection = ProtFlags::READ | ProtFlags::WRITE;
        // A loop that writes to it is not to wait for its pages.
        let flags = MapFlags::SHARED | MapFlags::POPULATE;
        // SAFETY: no address is asked for, so that no other mapping is replaced.
        let start = unsafe { mmap(std::ptr::null_mut(), bytes, protection, flags, file, offset) }?;
        let place = NonNull::new(start.cast()).ok_or(io::ErrorKind::OutOfMemory)?;
        Ok(Self { place, is_mapped: true })
    }

    /// One of this process alone.
    pub(crate) fn private() -> Self {
        const { assert!(size_of::<T>() > 0) };
        let layout = Layout::new::<T>();
        // SAFETY: the layout is not of size 0.
        let start = unsafe { alloc_zeroed(layout) };
        let place = NonNull::new(start.cast()).unwrap_or_else(|| handle_alloc_error(layout));
        Self { place, is_mapped: false }
    }
}

impl<T: Atomics> Deref for Shared<T> {
    type Target = T;

    fn deref(&self) -> &T {
        // SAFETY: the memory has the size and alignment of a `T` and lives as long as `self`. Any bytes are a `T`, and
        // all processes access them as atomic numbers only.
        unsafe { self.place.as_ref() }
    }
}

impl<T: Atomics> Drop for Shared<T> {
    fn drop(&mut self) {
        // SAFETY: the memory is ours, from `of` or `private`, and no reference into it outlives `self`.
        unsafe {
            match self.is_mapped {
                true => drop(munmap(self.place.as_ptr().cast(), size_of::<T>())),
                false => dealloc(self.place.as_ptr().cast(), Layout::new::<T>()),
            }
        }
    }
}

#[repr(C, align(64))]
#[derive(Debug)]
struct Line<T>(T);

/// The words that all processes of a run share.
#[repr(C)]
#[derive(Debug)]
pub(crate) struct RunWords {
    /// Counts of notifications, one for each topic. Programs of users wake by them too: a word every 64 bytes.
    wake: [Line<AtomicU32>; TOPICS.len()],
    services: [Line<ServiceWords>; Service::ALL.len()],
    /// Processes that only listen, as the members below.
    pub(crate) listeners: [AtomicU64; KNOWN],
}

/// Processes of a service, and listeners, that are known at the same time. A few of them live. Messages of the others
/// may still be on their way.
pub(crate) const KNOWN: usize = 16;

#[repr(C)]
#[derive(Debug)]
pub(crate) struct ServiceWords {
    /// Incarnation of the one process that may send.
    pub(crate) epoch: AtomicU32,
    /// Words in which the kernel marks the end of each of the members.
    pub(crate) ends: [AtomicU32; KNOWN],
    /// The service's members.
    pub(crate) processes: [AtomicU64; KNOWN],
}

// SAFETY: words alone.
unsafe impl Atomics for RunWords {}

impl RunWords {
    /// Maps the words of the run whose shared memory has this prefix.
    pub(crate) fn map(prefix: &str) -> io::Result<Shared<Self>> {
        Shared::map(&format!("{prefix}wake"))
    }

    /// The word that counts the notifications of a topic.
    pub(crate) fn wake(&self, topic: Topic) -> &AtomicU32 {
        &self.wake[topic as usize].0
    }

    pub(crate) fn of(&self, service: Service) -> &ServiceWords {
        &self.services[service.index()].0
    }
}

/// Makes the file at `path`, or opens the one that another process of this user made.
///
/// Every user may make a file in `/dev/shm`, also one with the name of ours, before us. A page that another user can
/// truncate kills the processes that read it.
pub(crate) fn open_own(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).mode(0o600).custom_flags(OFlags::NOFOLLOW.bits().cast_signed());
    match options.create_new(true).open(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        made => return made,
    }
    open_existing_own(path)
}

/// Opens the file at `path` that a process of this user made.
pub(crate) fn open_existing_own(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).custom_flags(OFlags::NOFOLLOW.bits().cast_signed());
    let file = options.open(path)?;
    let found = file.metadata()?;
    let own = rustix::process::geteuid().as_raw() == found.uid();
    if own && found.is_file() && found.mode() & 0o077 == 0 {
        Ok(file)
    } else {
        let what = format!("{} is not a file of this user alone", path.display());
        Err(Error::new(ErrorKind::PermissionDenied, what))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn a_file_is_shared_within_a_user_and_refused_beyond() {
        let path = std::env::temp_dir().join(format!("timegap-own-{}", std::process::id()));
        drop(open_own(&path).expect("new"));
        drop(open_own(&path).expect("ours"));
        for (mode, why) in [(0o666, "others may write it"), (0o640, "others may read it")] {
            std::fs::set_permissions(&path, PermissionsExt::from_mode(mode)).expect("ours");
            assert!(open_own(&path).is_err(), "{why}");
        }
        std::fs::remove_file(&path).expect("ours");
        std::os::unix::fs::symlink("/dev/null", &path).expect("free again");
        assert!(open_own(&path).is_err(), "a link to something else");
        std::fs::remove_file(&path).expect("ours");
        if rustix::process::geteuid().is_root() {
            std::fs::write(&path, "").expect("writable");
            std::fs::set_permissions(&path, PermissionsExt::from_mode(0o600)).expect("ours");
            std::os::unix::fs::chown(&path, Some(65_534), None).expect("root may");
            assert!(open_own(&path).is_err(), "another user's");
            std::fs::remove_file(&path).expect("root may");
        }
    }
}
