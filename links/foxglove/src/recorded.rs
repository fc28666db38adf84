//! A recording, played to viewers at its own pace.

use crate::server::Server;
use messages::Topic;
use recorder::{Encoder, Recording};
use std::convert::Infallible;
use std::process::ExitCode;
use std::time::{Duration, Instant};
use supervise::is_signalled;

/// Time between two looks at the viewers.
const POLL: Duration = Duration::from_millis(20);

/// Plays all of a recording, from the moment at which the first viewer subscribes. Status 1 if parts of it are damaged,
/// which lines name.
pub(crate) fn play(recording: &Recording, server: Server, speed: f64) -> ExitCode {
    while !server.is_watched() && !is_signalled() {
        std::thread::sleep(POLL);
    }
    let mut encoder = Encoder::of(recording.metadata());
    let begun = Instant::now();
    let (mut first_ns, mut shown) = (None, Duration::ZERO);
    let mut records = recording.records();
    for record in records.by_ref().take_while(|_| !is_signalled()) {
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
    server.end("the recording has ended", || !is_signalled());
    let damage: Vec<_> = recording.damage().iter().chain(records.damage()).collect();
    damage.iter().for_each(|damage| eprintln!("{}: {damage}", recording.path().display()));
    if damage.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Sends a message, and what is drawn by it; the instant in ns since 1970.
pub(crate) fn hand_on(
    encoder: &mut Encoder,
    (topic, run_ns, bytes): (Topic, i64, &[u8]),
    server: &Server,
) -> u64 {
    let mut unix_ns = 0;
    let Ok(()) = encoder.encode(topic, run_ns, bytes, |head, payload| {
        unix_ns = head.log_time;
        server.send(head.channel_id, head.log_time, payload);
        Ok::<(), Infallible>(())
    });
    unix_ns
}
