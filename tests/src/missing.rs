//! The reason why a test cannot run on this machine.

use std::fmt;

/// A need that is not met: a program, a Python package, a privilege or the network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Missing(pub String);

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl From<&str> for Missing {
    fn from(reason: &str) -> Self {
        Self(reason.to_owned())
    }
}
