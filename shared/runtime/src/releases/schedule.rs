//! A recorded run's releases: when a service began each cycle, and with which samples.
//!
//! A service that finds a schedule in the run's root takes its releases and its inputs from there alone. Clock, arrival
//! times of samples and end-to-end checks play no part. That check acted when the run was recorded. So a cycle sees
//! again exactly what it saw then.

use crate::RuntimeError;
use bytemuck::{Pod, Zeroable};
use messages::Service;
use messages::{Origin, Origins, Topic};
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};

#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct ScheduledRelease {
    pub step: u64,
    /// Time when the cycle began to work on its inputs, ns of run time.
    pub start_ns: i64,
    /// Time when its command was published, ns of run time; the same as `start_ns` without a
    /// command.
    pub publish_ns: i64,
    pub inputs: Origins,
}

/// The releases of one process, in order.
#[derive(Debug)]
pub struct Schedule {
    releases: BufReader<File>,
    present: Option<ScheduledRelease>,
}

impl Schedule {
    /// Writes the schedule of `service` into the run's root.
    pub fn write(
        root: &Path,
        service: Service,
        releases: impl Iterator<Item = ScheduledRelease>,
    ) -> Result<(), RuntimeError> {
        let path = file(root, service);
        let write = || {
            let mut file = BufWriter::new(File::create(&path)?);
            for release in releases {
                file.write_all(bytemuck::bytes_of(&release))?;
            }
            file.flush()
        };
        write().map_err(RuntimeError::file(&path))
    }

    /// Opens the schedule of `service`, if the run has one.
    pub(crate) fn read(root: &Path, service: Service) -> Result<Option<Self>, RuntimeError> {
        let path = file(root, service);
        match File::open(&path) {
            Ok(file) => Ok(Some(Self { releases: BufReader::new(file), present: None })),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(reason) => Err(RuntimeError::file(&path)(reason)),
        }
    }

    /// Goes on to the next release; `None` after the last.
    pub(crate) fn advance(&mut self) -> Option<ScheduledRelease> {
        let mut release = ScheduledRelease::zeroed();
        self.releases.read_exact(bytemuck::bytes_of_mut(&mut release)).ok()?;
        self.present = Some(release);
        self.present
    }

    /// The sample of `topic` that the present release used.
    pub(crate) fn input(&self, topic: Topic) -> Origin {
        let Some(release) = &self.present else { return Origin::NONE };
        match topic {
            Topic::Odometry | Topic::LateralMotion => release.inputs.odometry,
            Topic::RadarTracks | Topic::Course => release.inputs.radar,
            // The on-board unit's place for what the signals come from.
            Topic::Spat | Topic::RadioFrames => release.inputs.spat,
            Topic::Map => release.inputs.map,
            Topic::Powertrain => release.inputs.powertrain,
            Topic::Preview | Topic::Curves => release.inputs.preview,
            _ => Origin::NONE,
        }
    }
}

fn file(root: &Path, service: Service) -> PathBuf {
    root.join(format!("{service}.schedule"))
}
