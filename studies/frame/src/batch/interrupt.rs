//! Signals that ask for an end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use supervise::SignalsError;

/// Notices the signals that ask for an end, also between two groups, when no group listens.
pub struct Interrupt {
    came: Arc<AtomicBool>,
    registered: Vec<signal_hook::SigId>,
}

impl Interrupt {
    /// Begins to listen.
    pub fn watch() -> Result<Self, SignalsError> {
        let came = Arc::new(AtomicBool::new(false));
        let registered = supervise::end_signals()
            .into_iter()
            .map(|signal| signal_hook::flag::register(signal, Arc::clone(&came)))
            .collect::<Result<_, _>>()?;
        Ok(Self { came, registered })
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
