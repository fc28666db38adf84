//! The members of a group by what they are: services of the car, or nodes of a user's graph.

use crate::Error;
use messages::Service;
use runtime::{Figures, Group, enroll};
use std::fmt::{Debug, Display};

/// Identity of a member, which all its processes share. It is shown by its name.
pub trait Role: Copy + Eq + Debug + Display + Send + 'static {
    /// Its processes send no heartbeats: their counts alone show that they live.
    const IS_SEEN_BY_COUNTS: bool;

    /// Words behind `timegap service` by which this program becomes one of its processes.
    fn words(self) -> Vec<String>;

    /// Enters a process of it among those of the run, where receivers look senders up.
    fn enroll(self, _prefix: &str, _incarnation: u32, _pid: u32) -> Result<(), Error> {
        Ok(())
    }

    /// The counts of its processes.
    fn figures(self, group: &Group) -> Figures;
}

impl Role for Service {
    const IS_SEEN_BY_COUNTS: bool = false;

    fn words(self) -> Vec<String> {
        vec![self.name().to_owned()]
    }

    fn enroll(self, prefix: &str, incarnation: u32, pid: u32) -> Result<(), Error> {
        Ok(enroll(prefix, self, incarnation, pid)?)
    }

    fn figures(self, group: &Group) -> Figures {
        Figures::of(group, self)
    }
}
