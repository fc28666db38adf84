//! The arguments as matrices, cases and laws.

use clap::ValueEnum;
use frame::batch::laws::own_named;
use group::{Error, UsageError};

use super::R157Arguments;
use super::matrix::{self, Case, Matrix};

/// Refuses arguments that contradict each other.
pub fn refuse(arguments: &R157Arguments) -> Result<(), UsageError> {
    let matrices = arguments.matrix.iter().enumerate();
    let mut twice = matrices.filter(|(place, matrix)| arguments.matrix[..*place].contains(matrix));
    if let Some((_, matrix)) = twice.next() {
        let why = format_args!("{} is there twice", matrix.name());
        return Err(UsageError::at("--matrix", why, "each once"));
    }
    match (arguments.models_only, arguments.sample, arguments.seed) {
        (true, None, Some(seed)) => {
            let why = "the models have no noise";
            Err(UsageError::option("--seed", seed, why, "--sample, or no seed"))
        }
        _ => Ok(()),
    }
}

/// The matrices that the arguments name, with their cases.
pub fn matrices(arguments: &R157Arguments) -> Vec<(Matrix, Vec<Case>)> {
    let mut matrices = arguments.matrix.clone();
    if matrices.is_empty() {
        matrices = Matrix::value_variants().to_vec();
    }
    matrices.sort_unstable();
    matrices.into_iter().map(|matrix| (matrix, cases(matrix, arguments))).collect()
}

/// Seed of the drawn cases and of the noise.
pub fn seed(arguments: &R157Arguments) -> u32 {
    arguments.seed.unwrap_or(1)
}

fn cases(matrix: Matrix, arguments: &R157Arguments) -> Vec<Case> {
    let cases = matrix.cases();
    match arguments.sample {
        Some(count) => matrix::sample(cases, count.get(), seed(arguments).into()),
        None => cases,
    }
}

/// The named laws; empty for the models alone.
pub fn names(arguments: &R157Arguments) -> Result<Vec<String>, Error> {
    let names = match arguments.models_only {
        true => Vec::new(),
        false => own_named(&arguments.controllers, &arguments.laws.names())?,
    };
    arguments.laws.expect_all_in(&names)?;
    Ok(names)
}
