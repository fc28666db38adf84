//! Requirements of the command line, for campaigns whose scenarios come from no file.

use group::Error;
use report::results::{Document, Table};
use report::verdicts::{LEAST, Least};
use scenario::Scenario;

/// Adds the formulas to a scenario's requirements.
///
/// # Errors
/// If one of them is not a requirement of this scenario.
pub(crate) fn add(mut scenario: Scenario, formulas: &[String]) -> Result<Scenario, Error> {
    scenario.require.formulas.extend_from_slice(formulas);
    group::requirements(&scenario)?;
    Ok(scenario)
}

/// The formulas as words of a command line.
pub(crate) fn words(formulas: &[String]) -> Vec<String> {
    formulas.iter().flat_map(|formula| ["--require".to_owned(), formula.clone()]).collect()
}

/// Shows the least margins over all runs.
pub(crate) fn show(document: Document, margins: &[Least]) -> Document {
    document.table(Table::new("Requirements of the command", LEAST, margins))
}
