//! Origin of the signals' age: the path of the timing behind each command, by the stamps of a recording.

use messages::{Command, Message, Origin, RadioFrames, Spat};
use recorder::Recording;
use std::collections::HashMap;
use std::path::Path;

/// The parts of the path; their sum is the age.
pub const PARTS: [&str; 5] = [
    "roadside unit: made to sent",
    "network",
    "wait for the vehicle's radio",
    "on-board unit",
    "wait for the controller",
];

/// The parts of all commands of a run, ms; empty if no frame states when it was sent.
pub fn parts_ms(recording: &Path) -> Vec<[f64; 5]> {
    let recording = Recording::open(recording).expect("the run's own recording");
    let mut batches: HashMap<Origin, Batch> = HashMap::new();
    // Timing by its acquisition: its batch, and its first forwarding, ns.
    let mut first: HashMap<i64, (Origin, i64)> = HashMap::new();
    let mut parts = Vec::new();
    for record in recording.records_of(&[RadioFrames::TOPIC, Spat::TOPIC, Command::TOPIC]) {
        let header = record.header();
        if let Some(frames) = record.message::<RadioFrames>() {
            batches.insert(Origin::of(&header), Batch::of(&frames));
        } else if record.topic == Spat::TOPIC {
            let handed_on = (header.origins.spat, header.publish_ns);
            first.entry(header.acquisition_ns).or_insert(handed_on);
        } else {
            let made_ns = header.origins.spat.acquisition_ns;
            let Some((origin, known_ns)) = first.get(&made_ns) else { continue };
            let Some(batch) = batches.get(origin) else { continue };
            let Some((sent_ns, received_ns)) = batch.first else { continue };
            let stamps =
                [made_ns, sent_ns, received_ns, batch.publish_ns, *known_ns, header.acquisition_ns];
            let mut part = [0.0; 5];
            for (part, pair) in part.iter_mut().zip(stamps.windows(2)) {
                *part = (pair[1] - pair[0]) as f64 / 1e6;
            }
            parts.push(part);
        }
    }
    parts
}

/// Forwarding time of a batch of frames, and sending and receiving time of its first frame, ns.
struct Batch {
    publish_ns: i64,
    first: Option<(i64, i64)>,
}

impl Batch {
    fn of(frames: &RadioFrames) -> Self {
        let mut stamped = frames.frames().iter().filter(|frame| frame.on_the_way_ns().is_some());
        let first = stamped.next().map(|frame| (frame.sent_ns, frame.received_ns));
        Self { publish_ns: frames.header.publish_ns, first }
    }
}
