//! Counts over the cases of a matrix.

use crate::{Model, Outcome, PerModel, Verdict};

/// The models' results over the cases of a matrix.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Cases.
    pub cases: u32,
    /// Collisions of both kinds.
    pub collisions: PerModel<u32>,
    /// Rear-end collisions.
    pub rear_ends: PerModel<u32>,
    /// Cases in which both `careful-driver` and `regulation` end without a collision. `careful-driver` alone counts if
    /// `regulation` covers no case.
    pub mastered_by_both: u32,
}

impl Tally {
    /// Counts a case by the models' verdicts; `None` for a model that does not cover it.
    pub fn count(&mut self, verdicts: &PerModel<Option<Verdict>>) {
        self.cases += 1;
        for (model, verdict) in verdicts.iter() {
            let outcome = verdict.map_or(Outcome::None, |verdict| verdict.outcome);
            self.collisions[model] += u32::from(outcome.is_collision());
            self.rear_ends[model] += u32::from(outcome == Outcome::RearEnd);
        }
        self.mastered_by_both += u32::from(is_mastered_by_both(verdicts));
    }
}

/// True if both of the regulation's models end the case without a collision.
pub fn is_mastered_by_both(verdicts: &PerModel<Option<Verdict>>) -> bool {
    [Model::CarefulDriver, Model::Regulation]
        .into_iter()
        .filter_map(|model| verdicts[model])
        .all(|verdict| !verdict.outcome.is_collision())
}
