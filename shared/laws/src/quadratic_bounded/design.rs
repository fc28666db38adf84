//! A design as a data file, and its verification on loading.

use super::certificate::{self, ClosedMatrix, ClosedState, Content, Design, Gains};
use super::error::{DesignError, FORMAT, LARGEST};
use super::model::{Parameters, RULES, StateMatrix};
use serde::{Deserialize, Serialize};

/// The design that comes with the law.
const SHIPPED: &str =
    include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/designs/quadratic-bounded.json"));

/// The file: content and digest.
#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    design: Content,
    /// FNV-1a over the compact JSON text of `design`, 16 hexadecimal digits.
    digest: String,
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
        let design = Self::verify(file.content_checked()?)?;
        // Last, so that a change that matters is refused with the condition that it breaks.
        if file.digest != digest(&design.content) {
            return Err(DesignError::Digest);
        }
        Ok(design)
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

    /// The design that comes with the law.
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

    /// The file's text, which [`Design::load`] reads back to an equal design.
    pub fn to_json(&self) -> String {
        let file = File {
            format: FORMAT.to_owned(),
            digest: digest(&self.content),
            design: self.content.clone(),
        };
        let mut text = serde_json::to_string_pretty(&file).expect("numbers and strings only");
        text.push('\n');
        text
    }

    /// Conditions for which the design is made.
    pub fn parameters(&self) -> &Parameters {
        &self.content.parameters
    }

    /// Gains of each rule.
    pub fn rules(&self) -> &[Gains; RULES] {
        &self.rules
    }

    /// P of the ellipsoid V = z' P z <= 1, z = [x; xc].
    pub fn p(&self) -> &ClosedMatrix {
        &self.p
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
        (z.transpose() * self.p * z)[(0, 0)]
    }
}

impl File {
    /// The content, if every number is one that arithmetic survives.
    fn content_checked(&self) -> Result<Content, DesignError> {
        let c = &self.design;
        let numbers = c.p.iter().flatten().chain(&c.multipliers).chain([&c.alpha]).chain(
            c.rules
                .iter()
                .flat_map(|r| r.ac.iter().chain(&r.l).flatten().chain(&r.fx).chain(&r.fy)),
        );
        match numbers.copied().find(|v| !(-1e9..=1e9).contains(v)) {
            Some(value) => Err(DesignError::Number(value)),
            None => Ok(c.clone()),
        }
    }
}

/// FNV-1a, 64 bits: it finds accidental changes; what an adversary changes, the certificate refuses.
fn digest(content: &Content) -> String {
    let text = serde_json::to_vec(content).expect("numbers only");
    let hash = text.iter().fold(0xcbf2_9ce4_8422_2325_u64, |h, byte| {
        (h ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{hash:016x}")
}
