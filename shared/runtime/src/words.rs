//! Words of memory that the processes of a run share.

#![allow(unsafe_code, reason = "no crate maps shared memory as atomic words")]

use super::own_file::{open_existing_own, open_own};
use rustix::fs::{FallocateFlags, fallocate};
use rustix::mm::{MapFlags, ProtFlags, mmap, munmap};
use std::fs::File;
use std::io;
use std::path::Path;
use std::ptr::NonNull;
use std::sync::atomic::AtomicU32;

/// Words that fit in one page.
pub(super) const WORDS: usize = 1024;
const BYTES: usize = WORDS * size_of::<AtomicU32>();

/// A page of words in `/dev/shm`, zero at first and the same for all who map it.
///
/// The first process makes it, and it stays valid when any of them dies. It is removed with
/// everything else that carries the run's prefix.
#[derive(Debug)]
pub struct SharedWords(NonNull<AtomicU32>);

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
        Self::of(&open_own(&Path::new("/dev/shm").join(name))?)
    }

    /// Maps the page called `name` that another process made.
    ///
    /// # Errors
    /// If there is none, or it is another user's.
    pub(super) fn map_existing(name: &str) -> io::Result<Self> {
        Self::of(&open_existing_own(&Path::new("/dev/shm").join(name))?)
    }

    fn of(file: &File) -> io::Result<Self> {
        // A page that cannot be had is an error here, and would be a SIGBUS later.
        fallocate(file, FallocateFlags::empty(), 0, BYTES as u64)?;
        let (protection, flags) = (ProtFlags::READ | ProtFlags::WRITE, MapFlags::SHARED);
        // SAFETY: no address is asked for, so that no other mapping is replaced.
        let page = unsafe { mmap(std::ptr::null_mut(), BYTES, protection, flags, file, 0) }?;
        NonNull::new(page.cast()).map(Self).ok_or_else(|| io::ErrorKind::OutOfMemory.into())
    }

    /// The word at `index`.
    ///
    /// # Panics
    /// If `index` is 1024 or more.
    #[must_use]
    pub fn word(&self, index: usize) -> &AtomicU32 {
        assert!(index < WORDS, "a page has {WORDS} words");
        // SAFETY: the word is within the mapping, which is page-aligned, lives as long as `self`
        // and is only ever accessed as atomic words, by all processes.
        unsafe { self.0.add(index).as_ref() }
    }
}

impl Drop for SharedWords {
    fn drop(&mut self) {
        // SAFETY: the mapping is ours, and no reference into it outlives `self`.
        let _ = unsafe { munmap(self.0.as_ptr().cast(), BYTES) };
    }
}
