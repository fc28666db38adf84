//! The two ways in which a file is refused: by its keys, or by the content of a file that it names.

use super::error::ScenarioError;
use super::problem::Problem;

/// Reason why something in a file is not taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// A key is wrong; its place is looked up by its path.
    #[error(transparent)]
    Key(#[from] Problem),
    /// Something in another file is wrong, or in the command line.
    #[error(transparent)]
    File(#[from] ScenarioError),
}
