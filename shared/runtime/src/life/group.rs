//! The group file: what the launcher writes for every process of a run, once.

use crate::{Mode, RuntimeError, Timetable};
use messages::Service;
use scenario::Scenario;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};

/// Everything that the processes of one run share, kept in the run's root in postcard's encoding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Group {
    /// Root of the run: iceoryx2's files, the lock and this file are below it.
    pub root: PathBuf,
    /// Prefix of the run's shared-memory objects.
    pub prefix: String,
    pub mode: Mode,
    pub timetable: Timetable,
    pub standby: Vec<Service>,
    /// Wall time after which a wait for a due sample gives up in lockstep, ns.
    pub patience_ns: i64,
    /// The effective scenario as a text ([`Scenario::to_toml`]); empty for a run without one.
    pub scenario: String,
}

impl Group {
    /// Name of the group file in the run's root.
    const FILE: &str = "group";

    /// The effective scenario.
    ///
    /// # Errors
    /// [`RuntimeError::Scenario`] if the group has none, or one of another version of the program.
    pub fn scenario(&self) -> Result<Scenario, RuntimeError> {
        Ok(Scenario::of_run(&self.scenario)?)
    }

    /// Reads the group file below `root`.
    pub fn read(root: &Path) -> Result<Self, RuntimeError> {
        let path = root.join(Self::FILE);
        let read = || postcard::from_bytes(&std::fs::read(&path)?).map_err(io::Error::other);
        read().map_err(RuntimeError::file(&path))
    }

    /// Writes the group file below its root.
    pub fn write(&self) -> Result<(), RuntimeError> {
        let path = self.root.join(Self::FILE);
        let bytes = postcard::to_allocvec(self).expect("a group is plain data");
        std::fs::write(&path, bytes).map_err(RuntimeError::file(&path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_reads_what_the_launcher_wrote() {
        let root = std::env::temp_dir().join(format!("timegap-group-{}", std::process::id()));
        std::fs::create_dir_all(&root).expect("the temporary directory is writable");
        let text = "schema_version = 1\nname = \"x\"\nset_speed_mps = 21.3\n[[faults]]\nkind = \"drop\"\n\
                    topic = \"v2x/spat\"\n";
        let scenario = Scenario::parse("x", text).expect("a scenario");
        let group = Group {
            root: root.clone(),
            prefix: "timegap_x_".into(),
            mode: Mode::Realtime,
            timetable: Timetable::of(&scenario),
            standby: vec![Service::Controller],
            patience_ns: 7,
            scenario: scenario.to_toml(),
        };
        group.write().expect("ours");
        let read = Group::read(&root).expect("it is there");
        assert_eq!(read, group);
        assert_eq!(read.scenario().expect("a scenario"), scenario);
        let none = Group { scenario: String::new(), ..group };
        assert!(matches!(none.scenario(), Err(RuntimeError::Scenario(_))));
        std::fs::write(root.join(Group::FILE), [0xff; 9]).expect("ours");
        assert!(matches!(Group::read(&root), Err(RuntimeError::Setup(..))));
        std::fs::remove_dir_all(&root).expect("ours");
    }
}
