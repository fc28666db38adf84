//! The group file: what the launcher tells every process of a run, once.

use crate::{Mode, RuntimeError, Timetable};
use messages::Service;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Everything that the processes of one run share, kept in the run's root as `group.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// Root of the run: iceoryx2's files, the lock and this file are below it.
    pub root: PathBuf,
    /// Prefix of the run's shared-memory objects.
    pub prefix: String,
    /// Clock.
    pub mode: Mode,
    /// Periods.
    pub timetable: Timetable,
    /// Services that have a standby.
    pub standby: Vec<Service>,
    /// Wall time after which a wait for a due sample gives up in lockstep, ns.
    pub patience_ns: i64,
    /// The effective scenario, TOML.
    pub scenario: String,
}

impl Group {
    /// Name of the group file in the run's root.
    pub const FILE: &str = "group.json";

    /// Reads the group file below `root`.
    ///
    /// # Errors
    /// [`RuntimeError::GroupFile`] if it cannot be read or is not one.
    pub fn read(root: &Path) -> Result<Self, RuntimeError> {
        let path = root.join(Self::FILE);
        let error = |reason| RuntimeError::GroupFile { path: path.clone(), reason };
        let text = std::fs::read_to_string(&path).map_err(error)?;
        serde_json::from_str(&text).map_err(|e| error(e.into()))
    }

    /// Writes the group file below its root.
    ///
    /// # Errors
    /// [`RuntimeError::GroupFile`] if it cannot be written.
    pub fn write(&self) -> Result<(), RuntimeError> {
        let path = self.root.join(Self::FILE);
        let text = serde_json::to_string_pretty(self).expect("a group is plain data");
        std::fs::write(&path, text)
            .map_err(|reason| RuntimeError::GroupFile { path: path.clone(), reason })
    }
}
