//! Workers that share numbered pieces of work, and the signals that end it.

use indicatif::ProgressBar;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;
use supervise::{Error, MachineError};

/// The work on a piece by its number. The function is false once the work is to end.
pub type Work<'a, T> = dyn Fn(usize, &dyn Fn() -> bool) -> T + Sync + 'a;

/// Does `pieces` pieces of work, `at_once` at a time, in their order. `each` gets the number and the result of each as
/// it ends, in this thread. An error of `each` ends the rest.
///
/// # Errors
/// [`Error::Interrupted`] if a signal asked for the end, or the first error of `each`. All workers have ended by then.
pub fn share<T: Send>(
    pieces: usize,
    at_once: usize,
    bar: &ProgressBar,
    work: &Work<'_, T>,
    each: &mut dyn FnMut(usize, T) -> Result<(), Error>,
) -> Result<(), Error> {
    let interrupt = Interrupt::watch()?;
    let stop = AtomicBool::new(false);
    let next = AtomicUsize::new(0);
    let mut end = Ok(());
    std::thread::scope(|scope| {
        // Bounded: drives are large, and their receiver may be slower than the workers.
        let (sender, results) = sync_channel(at_once);
        for _ in 0..at_once.min(pieces) {
            let (sender, next) = (sender.clone(), &next);
            let going_on = || !stop.load(Ordering::Relaxed) && !interrupt.came();
            scope.spawn(move || {
                while going_on() {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= pieces || sender.send((index, work(index, &going_on))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        for (index, result) in results {
            match each(index, result) {
                Ok(()) => bar.inc(1),
                Err(error) => {
                    stop.store(true, Ordering::Relaxed);
                    // A piece that waited for one that failed was only interrupted.
                    if matches!(end, Ok(()) | Err(Error::Interrupted)) {
                        end = Err(error);
                    }
                }
            }
        }
    });
    if interrupt.came() { Err(Error::Interrupted) } else { end }
}

/// Notices the signals that ask for an end, also between two groups, when no group listens.
pub struct Interrupt {
    came: Arc<AtomicBool>,
    registered: Vec<signal_hook::SigId>,
}

impl Interrupt {
    /// Begins to listen.
    pub fn watch() -> Result<Self, MachineError> {
        let came = Arc::new(AtomicBool::new(false));
        Ok(Self { registered: supervise::flag_end(&came)?, came })
    }

    /// True once such a signal came.
    pub fn came(&self) -> bool {
        self.came.load(Ordering::Relaxed)
    }
}

impl Drop for Interrupt {
    fn drop(&mut self) {
        for &id in &self.registered {
            signal_hook::low_level::unregister(id);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_is_done_once() {
        let mut seen = vec![0; 100];
        let mut each = |index: usize, square: usize| {
            assert_eq!(square, index * index);
            seen[index] += 1;
            Ok(())
        };
        share(100, 3, &ProgressBar::hidden(), &|index, _| index * index, &mut each)
            .expect("no piece fails");
        assert!(seen.iter().all(|&times| times == 1));
    }

    #[test]
    fn the_first_error_ends_the_rest() {
        let mut seen = 0;
        let mut each = |index: usize, (): ()| {
            seen += 1;
            if index >= 5 { Err(Error::Interrupted) } else { Ok(()) }
        };
        let end = share(1_000_000, 1, &ProgressBar::hidden(), &|_, _| (), &mut each);
        assert!(matches!(end, Err(Error::Interrupted)));
        assert!(seen < 1_000_000, "{seen}");
    }
}
