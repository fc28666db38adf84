//! A search in the caller's thread, until its first violation.

use frame::batch;
use group::{Error, GroupOptions};

use crate::method::{Admission, Chooser, Evaluation, MethodName, seed_of};
use crate::problem::Problem;
use crate::value::judge;

/// True if the reference avoids a point.
///
/// # Errors
/// A point that the scenario refuses.
pub fn admit(problem: &Problem, point: &[f64]) -> Result<Admission, Error> {
    let Some(driver) = &problem.reference else { return Ok(Admission { value: -200.0 }) };
    let scenario = problem.scenario(&problem.values(point), 1)?;
    Ok(Admission { value: driver.drive(&scenario, false).value() })
}

/// Number of the first failing run of a search, from 1; none within the budget.
///
/// # Errors
/// An interrupt, or a run that cannot be done.
pub fn first_violation(
    problem: &Problem,
    (method, seed): (MethodName, u64),
    budget: usize,
    group: &GroupOptions,
    going_on: &dyn Fn() -> bool,
) -> Result<Option<usize>, Error> {
    let mut chooser = Chooser::new(method, &problem.kinds(), seed, 1);
    for run in 0..budget {
        let proposal = chooser.propose(run, &|point| admit(problem, point))?;
        let values = problem.values(&proposal.point);
        let scenario = problem.scenario(&values, seed_of(seed, 6, run as u64))?;
        let summary = batch::lockstep(&scenario, group, going_on)?.summary;
        let value = judge(&summary).value;
        if value < 0.0 {
            return Ok(Some(run + 1));
        }
        chooser.tell(run, Evaluation { point: proposal.point, value, refused: proposal.refused });
    }
    Ok(None)
}
