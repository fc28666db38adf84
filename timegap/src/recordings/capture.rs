//! `timegap recording export --pcap`: the frames of a recording as a capture for Wireshark.

use its::geonetworking::Headers;
use its::pcap::Writer;
use messages::{RadioFrames, RadioSent};
use recorder::Record;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use supervise::Error;

const FILE: &str = "radio.pcap";

/// The frames at the vehicle: received and sent ones.
#[derive(Default)]
pub struct Capture {
    frames: Vec<(i64, Vec<u8>)>,
}

impl Capture {
    pub fn add(&mut self, record: &Record) {
        if let Some(batch) = record.message::<RadioFrames>() {
            let frames = batch.frames().iter();
            let start_ns = batch.utc_start_ns;
            self.frames.extend(frames.map(|f| (start_ns + f.received_ns, f.data().to_vec())));
        } else if let Some(sent) = record.message::<RadioSent>() {
            let at_ns = sent.utc_start_ns + sent.frame.sent_ns;
            self.frames.push((at_ns, sent.frame.data().to_vec()));
        }
    }

    /// Writes the capture in order of the frames' times; returns its path and the number of frames.
    pub fn finish(mut self, directory: &Path) -> Result<(PathBuf, u64), Error> {
        let path = directory.join(FILE);
        // Stable: frames of one instant stay in order of arrival.
        self.frames.sort_by_key(|(unix_ns, _)| *unix_ns);
        let write = || {
            let mut writer = Writer::new(BufWriter::new(File::create(&path)?))?;
            for (unix_ns, frame) in &self.frames {
                // An unreadable frame has no known sender.
                let address = Headers::read(frame).map_or(0, |(headers, _)| headers.source.address);
                writer.write(*unix_ns, address as u32, frame)?;
            }
            writer.finish()
        };
        match write() {
            Ok(()) => Ok((path, self.frames.len() as u64)),
            Err(reason) => Err(Error::Path { action: "write", path, reason }),
        }
    }
}
