//! The faults that a scenario can have, each as a problem.

use group::{Error, absent};
use scenario::Scenario;

use super::messages;
use super::sort::BEGIN;
use crate::problem::{Draft, FAULT, Problem, Value, Variable, is_refusal};

/// A fault with its ranges.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Its name: kind and target.
    pub name: String,
    /// Unit of its size; empty for shares and for a fault without a size.
    pub unit: &'static str,
    /// Its variables: begin, duration and size, as far as it has them.
    pub problem: Problem,
}

/// The faults of messages and of timing that a scenario of this duration can have. `open` makes a
/// problem of a draft.
///
/// # Errors
/// Mistakes in the scenario.
pub fn candidates(
    draft: &dyn Fn() -> Draft,
    duration_s: f64,
    open: &dyn Fn(Draft) -> Result<Problem, Error>,
) -> Result<Vec<Candidate>, Error> {
    let mut found = Vec::new();
    for sort in messages::sorts() {
        let (name, unit) = (sort.name.clone(), sort.unit);
        let problem = open(sort.lay_over(draft(), duration_s))?;
        let candidate = Candidate { name, unit, problem };
        match candidate.problem.scenario(&candidate.severe(&[0.5]), 1) {
            Ok(scenario) if has_targets(&scenario) => found.push(candidate),
            Ok(_) => {}
            // The scenario does not allow a fault of this kind. One example is a figure of a topic that is not sent.
            Err(error) if is_refusal(&error) => {}
            Err(error) => return Err(error),
        }
    }
    Ok(found)
}

/// Every fault of the scenario has something to act on.
fn has_targets(scenario: &Scenario) -> bool {
    scenario.faults.iter().all(|fault| absent(fault, scenario).is_none())
}

impl Candidate {
    /// The values of a point of the unit cube. The begin is as drawn; duration and size come from the upper half of
    /// their ranges. Smaller faults hardly break anything if these break nothing.
    #[must_use]
    pub fn severe(&self, point: &[f64]) -> Vec<Value> {
        let place = |(k, variable): (usize, &Variable)| {
            let at = point[k % point.len()];
            let at = match variable.name.as_str() {
                BEGIN => at,
                FAULT => 0.999,
                // A size that is negative grows downwards.
                _ if variable.nominal == variable.domain.at(1.0) => 0.5 - 0.5 * at,
                _ => 0.5 + 0.5 * at,
            };
            variable.domain.at(at)
        };
        self.problem.variables.iter().enumerate().map(place).collect()
    }

    /// Place of a value between the smallest and the largest, from 0 to 1.
    #[must_use]
    pub fn severity(&self, name: &str, values: &[Value]) -> f64 {
        let mut named = self.problem.variables.iter().zip(values);
        let Some((variable, value)) = named.find(|(one, _)| one.name == name) else {
            // Without a size a fault has its full one.
            return 1.0;
        };
        let place = |value| variable.domain.place(value);
        (place(value) - place(&variable.nominal)).abs()
    }

    /// The value of a variable by its name.
    #[must_use]
    pub fn value(&self, name: &str, values: &[Value]) -> Option<f64> {
        let found = self.problem.variables.iter().zip(values).find(|(one, _)| one.name == name);
        found?.1.number()
    }
}
