//! The gap that a law keeps behind a lead of its own speed. Cases with a lead begin there.
//!
//! The ego's set speed is the lead's speed. So a law has no reason to close up from a larger gap. The gap is found by
//! one drive for each law and speed. Every case then begins there, at the lead's speed and without acceleration.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use group::{Ended, Error, Failure, Status};

use super::drive::{self, Conditions, Driver};

/// Time in which a law closes up or falls back to its own gap, s.
pub const CLOSES_UP_S: f64 = 25.0;

/// A drive behind a lead did not reach its end.
#[derive(Debug, thiserror::Error)]
#[error("{law} behind a lead at {speed_kmh} km/h: the run was aborted")]
pub struct NotSettled {
    law: String,
    speed_kmh: u32,
}

impl Failure for NotSettled {
    fn status(&self) -> Status {
        Status::Machine
    }
}

/// Settled gaps, m, by law and speed, km/h, as far as they were asked for.
#[derive(Debug)]
pub struct Settled {
    conditions: Conditions,
    gaps_m: Mutex<BTreeMap<(String, u32), f64>>,
}

impl Settled {
    /// Gaps of drives with this seed, before the first drive.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self::under(Conditions { seed, ..Conditions::default() })
    }

    /// Gaps of drives under these conditions, before the first drive.
    #[must_use]
    pub fn under(conditions: Conditions) -> Self {
        Self { conditions, gaps_m: Mutex::default() }
    }

    /// The common part of the drives.
    #[must_use]
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// The seed.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.conditions.seed
    }

    /// The gap that `law` keeps at `speed_kmh`, m. The first to ask drives; two at once drive the same.
    ///
    /// # Errors
    /// [`Error::Scenario`] if there is no such law, [`NotSettled`], or what keeps the run from starting.
    pub fn gap_m(&self, law: &str, speed_kmh: u32) -> Result<f64, Error> {
        let key = (law.to_owned(), speed_kmh);
        if let Some(gap_m) = self.gaps_m().get(&key) {
            return Ok(*gap_m);
        }
        let driver = Driver { law: law.to_owned(), aebs: false };
        let scenario = drive::behind_a_lead(speed_kmh, &driver, &self.conditions, CLOSES_UP_S)?;
        let group = group::in_process::run_unsealed(&scenario, &|| false)?;
        let last = group.drive.steps.iter().rev().find_map(|step| step.gap_m);
        let gap_m = last.filter(|_| group.ended == Ended::Orderly);
        let gap_m = gap_m.ok_or_else(|| NotSettled { law: law.to_owned(), speed_kmh })?;
        self.gaps_m().insert(key, gap_m);
        Ok(gap_m)
    }

    fn gaps_m(&self) -> MutexGuard<'_, BTreeMap<(String, u32), f64>> {
        self.gaps_m.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
