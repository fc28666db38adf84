//! Cost of a message's end-to-end protection, and of the copy that a reader makes of a small one first:
//! `cargo bench -p messages`.
//!
//! Each figure is the median of many batches of protecting, checking or copying one message of a topic. Messages of
//! which only the elements in use are protected are also measured with [`ELEMENTS`] of them.

use messages::e2e::{Channel, Outcomes, profile7};
use messages::{TOPICS, Topic};
use std::hint::black_box;
use std::time::Instant;

const BATCHES: usize = 2001;
const BATCH: u32 = 200;
/// About what a scan of the radar holds.
const ELEMENTS: u64 = 64;

fn median_ns(mut work: impl FnMut(u32)) -> f64 {
    let mut batches: Vec<f64> = (0..BATCHES)
        .map(|batch| {
            let begun = Instant::now();
            for k in 0..BATCH {
                work(u32::try_from(batch).expect("few").wrapping_mul(BATCH).wrapping_add(k));
            }
            begun.elapsed().as_nanos() as f64 / f64::from(BATCH)
        })
        .collect();
    batches.sort_by(f64::total_cmp);
    batches[BATCHES / 2]
}

fn main() {
    let head = ["topic", "bytes", "protect, ns", "check, ns", "copy, ns"];
    println!("{:<22} {:>6} {:>12} {:>12} {:>12}", head[0], head[1], head[2], head[3], head[4]);
    for topic in TOPICS {
        row(topic.name(), topic.message_bytes());
        let in_use = bytes_with(topic, ELEMENTS);
        if in_use < topic.message_bytes() {
            row(&format!("  {ELEMENTS} elements"), in_use);
        }
    }
    println!("medians of {BATCHES} batches of {BATCH} messages each");
}

/// Bytes in use of a message with this number of elements.
fn bytes_with(topic: Topic, elements: u64) -> usize {
    let layout = topic.layout();
    let mut message = vec![0; layout.bytes];
    if let Some(count) = layout.fields.iter().find(|field| field.name == "count") {
        message[count.offset..count.offset + 8].copy_from_slice(&elements.to_le_bytes());
    }
    layout.bytes_in_use(&message)
}

fn row(name: &str, bytes: usize) {
    let mut message = vec![0x5a; bytes];
    let protect = median_ns(|counter| {
        profile7::protect(black_box(&mut message), 7, counter);
    });
    let (mut channel, mut outcomes) = (Channel::default(), Outcomes::default());
    let check = median_ns(|_| {
        black_box(channel.accept(black_box(&message), 7, 0, &mut outcomes));
    });
    let mut room = vec![0; message.len()];
    let copy = median_ns(|_| black_box(&mut room).copy_from_slice(black_box(&message)));
    println!("{name:<22} {bytes:>6} {protect:>12.0} {check:>12.0} {copy:>12.0}");
}
