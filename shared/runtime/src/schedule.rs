//! A recorded run's releases: when a service began each cycle, and with which samples.
//!
//! A service that finds a schedule in the run's root takes its releases and its inputs from there
//! and from nothing else: neither a clock nor the time at which samples arrive, and not the
//! end-to-end check, which had its say when the run was recorded. So a cycle sees again exactly what
//! it saw then.

use super::RuntimeError;
use bytemuck::{Pod, Zeroable};
use messages::Service;
use messages::{Origin, Origins, Topic};
use std::path::{Path, PathBuf};

/// One recorded release.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct ScheduledRelease {
    /// Simulation step.
    pub step: u64,
    /// When the cycle began to work on its inputs, ns of run time.
    pub start_ns: i64,
    /// When its command was published, ns of run time; the same as `start_ns` without a command.
    pub publish_ns: i64,
    /// The samples that it used.
    pub inputs: Origins,
}

/// The releases of one process, in order.
#[derive(Debug)]
pub struct Schedule {
    releases: Vec<ScheduledRelease>,
    next: usize,
}

impl Schedule {
    /// Writes the schedule of `service` into the run's root.
    ///
    /// # Errors
    /// [`RuntimeError::GroupFile`] if it cannot be written.
    pub fn write(
        root: &Path,
        service: Service,
        releases: &[ScheduledRelease],
    ) -> Result<(), RuntimeError> {
        let path = file(root, service);
        std::fs::write(&path, bytemuck::cast_slice(releases))
            .map_err(|e| RuntimeError::GroupFile { path, reason: e.to_string() })
    }

    /// Reads the schedule of `service`, if the run has one.
    pub(super) fn read(root: &Path, service: Service) -> Result<Option<Self>, RuntimeError> {
        let path = file(root, service);
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(RuntimeError::GroupFile { path, reason: e.to_string() }),
        };
        let releases = bytes.chunks_exact(size_of::<ScheduledRelease>());
        let releases = releases.map(bytemuck::pod_read_unaligned).collect();
        Ok(Some(Self { releases, next: 0 }))
    }

    /// Goes on to the next release; `None` after the last.
    pub(super) fn advance(&mut self) -> Option<ScheduledRelease> {
        let release = self.releases.get(self.next).copied()?;
        self.next += 1;
        Some(release)
    }

    /// The sample of `topic` that the present release used.
    pub(super) fn input(&self, topic: Topic) -> Origin {
        let present = self.next.checked_sub(1).and_then(|index| self.releases.get(index));
        let Some(release) = present else { return Origin::NONE };
        match topic {
            Topic::Odometry => release.inputs.odometry,
            Topic::RadarTracks => release.inputs.radar,
            Topic::Spat => release.inputs.spat,
            Topic::Map => release.inputs.map,
            Topic::Powertrain => release.inputs.powertrain,
            Topic::Preview => release.inputs.preview,
            _ => Origin::NONE,
        }
    }
}

fn file(root: &Path, service: Service) -> PathBuf {
    root.join(format!("{service}.schedule"))
}
