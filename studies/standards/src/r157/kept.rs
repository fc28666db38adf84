//! Ends of the cases, as the journal of a part keeps them.

use crate::{Outcome, Verdict};
use frame::batch::Done;
use group::Error;
use serde::{Deserialize, Serialize};

use super::judge;

/// A verdict in the journal of a part.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct End {
    /// Digit of the outcome.
    outcome: u8,
    /// Speed difference at the contact, m/s.
    impact_mps: f64,
    /// A requirement is broken.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    is_broken: bool,
}

/// End of a case with a law.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    alone: End,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    with_brake: Option<End>,
}

impl End {
    /// The end of a drive.
    pub fn of(done: &Done) -> Self {
        let verdict = judge::verdict(&done.drive);
        Self {
            outcome: verdict.outcome.digit(),
            impact_mps: verdict.impact_speed_mps,
            is_broken: done.summary.requirements.iter().any(|verdict| !verdict.met),
        }
    }

    /// True if a requirement is broken.
    pub fn is_broken(self) -> bool {
        self.is_broken
    }

    /// The end as a verdict.
    pub fn verdict(self) -> Verdict {
        let outcome = Outcome::from_digit(self.outcome).unwrap_or(Outcome::None);
        Verdict { outcome, impact_speed_mps: self.impact_mps }
    }
}

impl Kept {
    /// The ends with and without the emergency brake, of one run if it never braked.
    pub fn of(
        with_brake: bool,
        drive: &dyn Fn(bool) -> Result<Done, Error>,
    ) -> Result<Self, Error> {
        let braked = with_brake.then(|| drive(true)).transpose()?;
        let silent = braked.as_ref().filter(|done| done.summary.aebs.interventions == Some(0));
        let alone = match silent {
            Some(done) => End::of(done),
            None => End::of(&drive(false)?),
        };
        Ok(Self { alone, with_brake: braked.as_ref().map(End::of) })
    }

    /// A drive without the emergency brake.
    pub fn alone(done: &Done) -> Self {
        Self { alone: End::of(done), with_brake: None }
    }

    /// The end with the emergency brake or without.
    pub fn end(&self, aebs: bool) -> Option<End> {
        if aebs { self.with_brake } else { Some(self.alone) }
    }
}
