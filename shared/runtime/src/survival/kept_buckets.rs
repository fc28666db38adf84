//! The buckets of a histogram in shared memory, where they outlive the process.

use crate::words::SharedWords;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Buckets of a histogram in shared memory.
#[derive(Debug)]
pub(crate) struct KeptBuckets {
    words: SharedWords,
    /// False while the process stands by.
    records: Arc<AtomicBool>,
}

impl KeptBuckets {
    /// Buckets in `words`, which count while `records` is set.
    pub(crate) fn new(words: SharedWords, records: Arc<AtomicBool>) -> Self {
        Self { words, records }
    }

    /// Counts one value more.
    pub(crate) fn add(&self, bucket: usize) {
        if self.records.load(Ordering::Relaxed) {
            self.words.word(bucket).fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Values counted in `bucket`.
    pub(crate) fn count(&self, bucket: usize) -> u64 {
        self.words.word(bucket).load(Ordering::Relaxed).into()
    }
}
