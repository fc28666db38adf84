//! The kinds of faults by their names.

use serde::{Deserialize, Serialize};

use super::{Disturbance, Effect, Falsification, ProcessFault};

/// Kind of a fault: its name in files, on the command line and in results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// [`ProcessFault::Kill`].
    Kill,
    /// [`ProcessFault::Stop`].
    Stop,
    /// [`ProcessFault::RestartStorm`].
    RestartStorm,
    /// [`ProcessFault::KillHelper`].
    KillHelper,
    /// [`ProcessFault::Hog`].
    Hog,
    /// [`ProcessFault::Memory`].
    Memory,
    /// [`Disturbance::Delay`].
    Delay,
    /// [`Disturbance::Drop`].
    Drop,
    /// [`Disturbance::Duplicate`].
    Duplicate,
    /// [`Disturbance::Reorder`].
    Reorder,
    /// [`Disturbance::Corrupt`].
    Corrupt,
    /// [`Falsification::Freeze`].
    Freeze,
    /// [`Falsification::Bias`].
    Bias,
    /// [`Falsification::Stale`].
    Stale,
    /// [`Falsification::ClockStep`].
    ClockStep,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 15] = [
        Self::Kill,
        Self::Stop,
        Self::RestartStorm,
        Self::KillHelper,
        Self::Hog,
        Self::Memory,
        Self::Delay,
        Self::Drop,
        Self::Duplicate,
        Self::Reorder,
        Self::Corrupt,
        Self::Freeze,
        Self::Bias,
        Self::Stale,
        Self::ClockStep,
    ];

    /// Name in files, on the command line and in results.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Kill => "kill",
            Self::Stop => "stop",
            Self::RestartStorm => "restart-storm",
            Self::KillHelper => "kill-helper",
            Self::Hog => "hog",
            Self::Memory => "memory",
            Self::Delay => "delay",
            Self::Drop => "drop",
            Self::Duplicate => "duplicate",
            Self::Reorder => "reorder",
            Self::Corrupt => "corrupt",
            Self::Freeze => "freeze",
            Self::Bias => "bias",
            Self::Stale => "stale",
            Self::ClockStep => "clock-step",
        }
    }
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl Effect {
    /// Its kind.
    #[must_use]
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Process(ProcessFault::Kill { .. }) => Kind::Kill,
            Self::Process(ProcessFault::Stop { .. }) => Kind::Stop,
            Self::Process(ProcessFault::RestartStorm { .. }) => Kind::RestartStorm,
            Self::Process(ProcessFault::KillHelper { .. }) => Kind::KillHelper,
            Self::Process(ProcessFault::Hog { .. }) => Kind::Hog,
            Self::Process(ProcessFault::Memory { .. }) => Kind::Memory,
            Self::Channel(fault) => match fault.disturbance {
                Disturbance::Delay { .. } => Kind::Delay,
                Disturbance::Drop => Kind::Drop,
                Disturbance::Duplicate => Kind::Duplicate,
                Disturbance::Reorder => Kind::Reorder,
                Disturbance::Corrupt { .. } => Kind::Corrupt,
            },
            Self::Sender(fault) => match fault.falsification {
                Falsification::Freeze { .. } => Kind::Freeze,
                Falsification::Bias { .. } => Kind::Bias,
                Falsification::Stale { .. } => Kind::Stale,
                Falsification::ClockStep { .. } => Kind::ClockStep,
            },
        }
    }
}
