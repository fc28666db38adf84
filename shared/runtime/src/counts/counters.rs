//! Counters in shared memory.

use crate::words::SharedWords;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Counters that outlive the process and stand still while it is a standby. They wrap at 2³².
#[derive(Clone, Debug)]
pub(super) struct Counters {
    words: Arc<SharedWords>,
    /// The word of the first counter.
    first: usize,
    /// False while the process stands by.
    records: Arc<AtomicBool>,
}

impl Counters {
    /// The counters in `words` from word `first` on, which count while `records` is set.
    pub(super) fn new(words: Arc<SharedWords>, first: usize, records: Arc<AtomicBool>) -> Self {
        Self { words, first, records }
    }

    /// Adds `more` to counter `index`.
    pub(super) fn add(&self, index: usize, more: u32) {
        if self.records.load(Ordering::Relaxed) {
            self.words.word(self.first + index).fetch_add(more, Ordering::Relaxed);
        }
    }

    /// Raises the number that counters `index` (upper half) and `index + 1` hold to at least `number`. One process
    /// at a time does so. Another one may read a mixture of two numbers.
    pub(super) fn raise(&self, index: usize, number: u64) {
        if self.records.load(Ordering::Relaxed) && number > self.number(index) {
            let word = |index| self.words.word(self.first + index);
            word(index).store((number >> 32) as u32, Ordering::Relaxed);
            word(index + 1).store(number as u32, Ordering::Relaxed);
        }
    }

    /// The number that [`Self::raise`] raises.
    pub(super) fn number(&self, index: usize) -> u64 {
        self.get(index) << 32 | self.get(index + 1)
    }

    /// Value of counter `index`.
    pub(super) fn get(&self, index: usize) -> u64 {
        self.words.word(self.first + index).load(Ordering::Relaxed).into()
    }
}
