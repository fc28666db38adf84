//! The difference between a recorded and a replayed message.

use crate::recordings::diff::first_difference;
use messages::{Message, Place};
use runtime::Mode;
use serde::Serialize;
use std::fmt;

/// Fields about the machine's performance.
const MACHINE: [&str; 7] = [
    "header.protection",
    "header.publish_ns",
    "idle_ns",
    "voluntary_switches",
    "involuntary_switches",
    "minor_faults",
    "major_faults",
];

/// Fields that are not compared in a run with this clock.
pub(super) fn not_compared(mode: Mode) -> Vec<&'static str> {
    match mode {
        Mode::Lockstep => Vec::new(),
        Mode::Realtime => MACHINE.to_vec(),
    }
}

pub(super) fn places<T: Message>(not_compared: &[&str]) -> Vec<Place> {
    let mut places = T::LAYOUT.scalars();
    places.retain(|place| !not_compared.iter().any(|field| place.path.starts_with(field)));
    places
}

#[derive(Debug, Serialize)]
pub(super) struct Difference {
    pub(super) topic: &'static str,
    pub(super) incarnation: u32,
    pub(super) sequence: u64,
    pub(super) step: u64,
    pub(super) field: String,
    pub(super) recorded: String,
    pub(super) replayed: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { topic, sequence, field, recorded, replayed, .. } = self;
        write!(f, "{topic}, message {sequence}, {field}: {recorded} recorded, {replayed} replayed")
    }
}

impl Difference {
    /// The first of `places` whose bytes differ.
    pub(super) fn between<T: Message>(
        places: &[Place],
        recorded: &T,
        replayed: &T,
    ) -> Option<Self> {
        let [a, b] = [recorded, replayed].map(bytemuck::bytes_of);
        let header = recorded.header();
        let place = first_difference(places, a, b)?;
        Some(Self {
            topic: T::TOPIC.name(),
            incarnation: header.incarnation,
            sequence: header.sequence,
            step: header.step,
            field: place.path.clone(),
            recorded: place.read(a).to_string(),
            replayed: place.read(b).to_string(),
        })
    }
}
