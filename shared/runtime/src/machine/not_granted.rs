//! Requests that the kernel refuses a loop.

use serde::{Deserialize, Serialize};
use std::fmt;

/// A request to the kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Asked {
    /// Sleeps that end on time without real-time priority.
    TimerSlack,
    /// This core.
    Core(usize),
    /// Memory that stays where it is.
    LockedMemory,
    /// `SCHED_FIFO` with this priority.
    Fifo(u8),
}

const TIMER_SLACK: &str = "timer slack of 1 ns";
const LOCKED_MEMORY: &str = "locked memory";

impl fmt::Display for Asked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TimerSlack => f.write_str(TIMER_SLACK),
            Self::Core(core) => write!(f, "core {core}"),
            Self::LockedMemory => f.write_str(LOCKED_MEMORY),
            Self::Fifo(priority) => write!(f, "fifo:{priority}"),
        }
    }
}

/// Something that the kernel did not grant. In JSON it is one text, `what: why`.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct NotGranted {
    /// The request.
    pub what: Asked,
    /// The kernel's reason.
    pub why: String,
}

impl fmt::Display for NotGranted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.what, self.why)
    }
}

impl From<NotGranted> for String {
    fn from(refused: NotGranted) -> Self {
        refused.to_string()
    }
}

/// A text that names nothing that is asked of the kernel.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is nothing that is asked of the kernel")]
pub struct UnknownRefusal(String);

impl TryFrom<String> for NotGranted {
    type Error = UnknownRefusal;

    fn try_from(text: String) -> Result<Self, UnknownRefusal> {
        let what = |name: &str| match name {
            TIMER_SLACK => Some(Asked::TimerSlack),
            LOCKED_MEMORY => Some(Asked::LockedMemory),
            _ => match (name.strip_prefix("core "), name.strip_prefix("fifo:")) {
                (Some(core), _) => core.parse().ok().map(Asked::Core),
                (None, Some(priority)) => priority.parse().ok().map(Asked::Fifo),
                (None, None) => None,
            },
        };
        let parts = text.split_once(": ").and_then(|(name, why)| Some((what(name)?, why)));
        match parts {
            Some((what, why)) => Ok(Self { what, why: why.to_owned() }),
            None => Err(UnknownRefusal(text)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_is_read_back_as_it_was_written() {
        let asked = [Asked::TimerSlack, Asked::Core(3), Asked::LockedMemory, Asked::Fifo(80)];
        for what in asked {
            let refused = NotGranted { what, why: "no: not here".into() };
            assert_eq!(NotGranted::try_from(refused.to_string()), Ok(refused));
        }
        assert!(NotGranted::try_from("core x: no".to_owned()).is_err());
    }
}
