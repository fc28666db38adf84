//! The record of a run.

use group::report::Outcome;
use serde::{Deserialize, Serialize};

use crate::method::{Evaluation, Refused};
use crate::problem::Value;
use crate::value::Judged;

/// A run that was done.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    pub point: Vec<f64>,
    /// Values of the variables there.
    pub values: Vec<Value>,
    pub seed: u64,
    /// End of the run.
    pub outcome: Outcome,
    /// The requirement that decides it.
    pub judged: Judged,
    /// Value of the point by the reference alone, below 0.
    pub reference: f64,
    /// It was drawn evenly from the admissible points.
    pub is_even: bool,
    /// Points that were tried before it and not driven.
    pub tried: usize,
    /// Some of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<Refused>,
}

impl Record {
    /// The value that the search makes small. Below 0 the run is a failure, as the reference avoids each point that is
    /// driven.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.judged.value
    }

    /// The run broke a requirement in a scene that the reference avoids.
    #[must_use]
    pub fn is_failure(&self) -> bool {
        self.value() < 0.0
    }

    /// The result as the choice of later runs needs it. The last digit of a number may differ where it comes from a
    /// journal: values count in millionths.
    pub(crate) fn told(&self) -> Evaluation {
        let rough = |number: f64| (number * 1e6).round() / 1e6;
        let place = |point: &[f64]| point.iter().map(|at| rough(*at)).collect();
        let refused = self
            .refused
            .iter()
            .map(|one| Refused { point: place(&one.point), value: rough(one.value) });
        Evaluation {
            point: place(&self.point),
            value: rough(self.value()),
            refused: refused.collect(),
        }
    }
}
