//! Words of memory that the processes of a run share.

#![allow(unsafe_code, reason = "no crate maps shared memory as atomic words")]

mod own_file;

pub(crate) use own_file::{open_existing_own, open_own};

use rustix::fs::{FallocateFlags, fallocate};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use std::fs::File;
use std::io;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::atomic::AtomicU32;

/// Words that fit in one page.
pub(crate) const WORDS: usize = 1024;
/// Bytes of one page.
pub(crate) const PAGE_BYTES: usize = WORDS * size_of::<AtomicU32>();

/// Pages of words in `/dev/shm`, zero at first and the same for all who map them.
///
/// The first process makes them, and they stay valid when any of them dies. They are removed with
/// everything else that carries the run's prefix.
#[derive(Debug)]
pub struct SharedWords {
    first: NonNull<AtomicU32>,
    pages: usize,
}

// SAFETY: the mapping belongs to the process, not to a thread, and is only ever accessed as atomic words.
unsafe impl Send for SharedWords {}
// SAFETY: as above.
unsafe impl Sync for SharedWords {}

impl SharedWords {
    /// Maps the page called `name`.
    ///
    /// # Errors
    /// If it cannot be created, there is no room for it, or it is another user's.
    pub fn map(name: &str) -> io::Result<Self> {
        Self::of(&open_own(&Path::new("/dev/shm").join(name))?, 0, 1)
    }

    /// Maps `pages` pages of `file` from page `first` on, which get memory if they have none.
    pub(crate) fn of(file: &File, first: usize, pages: usize) -> io::Result<Self> {
        let (offset, bytes) = ((first * PAGE_BYTES) as u64, pages * PAGE_BYTES);
        // A page that cannot be had is an error here, and would be a SIGBUS later.
        fallocate(file, FallocateFlags::empty(), offset, bytes as u64)?;
        let protection = ProtFlags::READ | ProtFlags::WRITE;
        // A loop that writes to it is not to wait for its pages.
        let flags = MapFlags::SHARED | MapFlags::POPULATE;
        // SAFETY: no address is asked for, so that no other mapping is replaced.
        let start = unsafe { mmap(std::ptr::null_mut(), bytes, protection, flags, file, offset) }?;
        let first = NonNull::new(start.cast()).ok_or(io::ErrorKind::OutOfMemory)?;
        Ok(Self { first, pages })
    }

    /// The word at `index`.
    ///
    /// # Panics
    /// If `index` is 1024 or more for each page.
    #[must_use]
    pub fn word(&self, index: usize) -> &AtomicU32 {
        assert!(index < self.pages * WORDS, "a page has {WORDS} words");
        // SAFETY: the word is within the mapping, which is page-aligned and lives as long as `self`. All
        // processes access it as atomic words only.
        unsafe { self.first.add(index).as_ref() }
    }
}

impl Drop for SharedWords {
    fn drop(&mut self) {
        // SAFETY: the mapping is ours, and no reference into it outlives `self`.
        let _ = unsafe { munmap(self.first.as_ptr().cast(), self.pages * PAGE_BYTES) };
    }
}
