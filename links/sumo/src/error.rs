//! Files that make no route, and programs that are no SUMO.

/// A file of SUMO's that makes no road for the ego.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// The file is not there, not readable, or not well-formed.
    #[error(transparent)]
    File(#[from] openscenario::ReadError),
    /// Its content does not fit.
    #[error("{place}: {reason}, expected {expected}")]
    Meaning {
        /// The file with line and column.
        place: String,
        /// The fault.
        reason: String,
        /// The right form.
        expected: String,
    },
    /// The name of the ego's way leads nowhere.
    #[error("{file}: {reason}, expected {expected}")]
    Ego {
        /// The file that was searched.
        file: String,
        /// The fault.
        reason: String,
        /// The right form.
        expected: String,
    },
}

impl ReadError {
    pub(crate) fn ego(file: &str, reason: impl Into<String>, expected: impl Into<String>) -> Self {
        Self::Ego { file: file.to_owned(), reason: reason.into(), expected: expected.into() }
    }
}

/// A failure of the program SUMO, before or during a run.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    /// There is no such program.
    #[error(
        "SUMO: there is no program `sumo` in $SUMO_HOME/bin or on the PATH, expected SUMO 1.20 or later \
         (pip install eclipse-sumo)"
    )]
    Missing,
    /// The system does not let it start.
    #[error("SUMO: cannot start {program}: {reason}")]
    Start {
        /// The program.
        program: String,
        /// The system's error.
        #[source]
        reason: std::io::Error,
    },
    /// It speaks another version of the protocol.
    #[error(
        "SUMO: {name} speaks version {version} of TraCI, expected {expected} or later (SUMO 1.20)"
    )]
    Version {
        /// The program's own name.
        name: String,
        /// Its version of TraCI.
        version: i32,
        /// The least version.
        expected: i32,
    },
    /// It ended on its own.
    #[error("SUMO: ended {when}: {words}")]
    Ended {
        /// Phase of the run.
        when: String,
        /// Its last words, or its status.
        words: String,
    },
    /// It does not answer.
    #[error("SUMO: no answer {when} within {waited_s} s")]
    Silent {
        /// Phase of the run.
        when: String,
        /// Time waited, s.
        waited_s: f64,
    },
    /// It refuses a command.
    #[error("SUMO: {command} was refused: {words}")]
    Refused {
        /// The command.
        command: &'static str,
        /// Its reason.
        words: String,
    },
    /// Its answer makes no sense.
    #[error("SUMO: an answer that is not TraCI: {0}")]
    Nonsense(&'static str),
    /// The ego found no place on its first lane.
    #[error(
        "SUMO: no room for the ego on lane `{lane}` within {waited_s} s of simulated time, expected a lane with a gap (traffic.begin_s moves the start)"
    )]
    NoRoom {
        /// The lane.
        lane: String,
        /// Simulated time waited, s.
        waited_s: f64,
    },
}
