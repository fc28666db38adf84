//! A recording, played to viewers at its own pace.

use crate::live::hand_on;
use crate::server::Server;
use recorder::{Encoder, Recording};
use std::time::{Duration, Instant};

/// Time between two looks at the viewers.
const POLL: Duration = Duration::from_millis(20);

/// Plays all of a recording, from the moment at which the first viewer subscribes.
pub(crate) fn play(recording: &Recording, server: Server, speed: f64) {
    while !server.is_watched() {
        std::thread::sleep(POLL);
    }
    let mut encoder = Encoder::of(recording.metadata());
    let begun = Instant::now();
    let (mut first_ns, mut shown) = (None, Duration::ZERO);
    for record in recording.records() {
        let run_ns = record.log_time_ns - *first_ns.get_or_insert(record.log_time_ns);
        let due = Duration::from_nanos(run_ns.unsigned_abs()).div_f64(speed);
        // Messages of one look are sent together.
        if due > shown + POLL {
            std::thread::sleep(due.saturating_sub(begun.elapsed()));
            shown = due;
        }
        let message = (record.topic, record.log_time_ns, record.bytes());
        server.send_time(hand_on(&mut encoder, message, &server));
    }
    while !server.is_idle() {
        std::thread::sleep(POLL);
    }
    server.end("the recording has ended");
}
