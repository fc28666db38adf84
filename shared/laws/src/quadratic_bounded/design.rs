//! A design as a data file, and its verification on loading.

use super::certificate::{self, ClosedMatrix, ClosedState, Content, Design, Failure, Gains};
use super::model::{Parameters, RULES, StateMatrix};
use scenario::Problem;
use serde::Deserialize;
use thiserror::Error;

/// Largest accepted file, bytes; a design needs about 8000.
const LARGEST: usize = 64 * 1024;
/// Claims of the file.
const FORMAT: &str = "timegap quadratic-bounded design 1";
/// The design that comes with the law.
const SHIPPED: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/quadratic-bounded.json"));

/// Reason why a file is not a usable design.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DesignError {
    #[error("the design file cannot be read: {0}")]
    Read(String),
    #[error("the design file has {bytes} bytes, more than {LARGEST}")]
    TooLarge { bytes: usize },
    /// Not JSON of the right shape; the message has line and column.
    #[error("not a design file: {0}")]
    Syntax(String),
    /// Another format or version, as found.
    #[error("format {0:?}: expected {FORMAT:?}")]
    Format(String),
    #[error("design parameter {}, expected {}", .0.message, .0.expected)]
    Parameter(Problem),
    #[error("the certificate fails: {0}")]
    Condition(#[from] Failure),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    design: Content,
}

impl Design {
    /// Reads and verifies a design file.
    ///
    /// # Errors
    /// Error in the text, or the condition and the rule that the numbers fail.
    pub fn load(text: &str) -> Result<Self, DesignError> {
        if text.len() > LARGEST {
            return Err(DesignError::TooLarge { bytes: text.len() });
        }
        let file: File =
            serde_json::from_str(text).map_err(|e| DesignError::Syntax(e.to_string()))?;
        if file.format != FORMAT {
            return Err(DesignError::Format(file.format.chars().take(80).collect()));
        }
        Self::verify(file.design)
    }

    /// Reads and verifies the file at `path`; a relative path starts at the working directory.
    ///
    /// # Errors
    /// As [`Design::load`], or that the file cannot be read.
    pub fn open(path: &str) -> Result<Self, DesignError> {
        let text =
            std::fs::read_to_string(path).map_err(|error| DesignError::Read(error.to_string()))?;
        Self::load(&text)
    }

    pub fn shipped() -> Self {
        Self::load(SHIPPED).expect("the shipped file is verified by the tests")
    }

    /// Verifies numbers from wherever they come.
    ///
    /// # Errors
    /// A parameter outside its range, or the condition and the rule that the numbers fail.
    pub fn verify(content: Content) -> Result<Self, DesignError> {
        content.parameters.check().map_err(DesignError::Parameter)?;
        certificate::verify(content).map_err(DesignError::Condition)
    }

    /// Conditions for which the design is made.
    pub fn parameters(&self) -> &Parameters {
        &self.content.parameters
    }

    pub fn rules(&self) -> &[Gains; RULES] {
        &self.content.rules
    }

    /// P of the ellipsoid V = z' P z <= 1, z = [x; xc].
    pub fn p(&self) -> &ClosedMatrix {
        &self.content.p
    }

    /// The matrix of the best controller state: xc = reset x makes V least.
    pub fn reset(&self) -> &StateMatrix {
        &self.reset
    }

    /// X^-1: V = x' X^-1 x just after a reset.
    pub fn x_inverse(&self) -> &StateMatrix {
        &self.x_inverse
    }

    /// V = z' P z.
    pub fn lyapunov(&self, z: &ClosedState) -> f64 {
        (z.transpose() * self.content.p * z)[(0, 0)]
    }
}
