//! Replay of an on-board unit's recording: every cycle up to the first whose frames or signals are not there.

use bytemuck::Zeroable;
use messages::{Header, Map, Origin, Origins, RadioFrames, Service, Spat, Topic};
use recorder::{LawNames, Metadata, Recording, Tally, Writer};
use runtime::Mode;
use scenario::{Overrides, Scenario};
use std::io::Cursor;
use std::path::PathBuf;

/// A recording in which cycle `k`, of this process, uses batch `k`. The messages that `lost` names by topic and number
/// are missing.
fn recording(processes: &[u32], lost: &[(Topic, u64)]) -> Recording {
    let scenario = Scenario::open("corridor", &Overrides::new(), &|_| Ok(Default::default()))
        .expect("built in");
    let metadata = Metadata::new(&scenario, Mode::Lockstep, 0, [].into(), LawNames::default());
    let mut file = Vec::new();
    let mut writer = Writer::begin(Cursor::new(&mut file), &metadata).expect("memory");
    let mut write = |topic, number, bytes: &[u8]| {
        if !lost.contains(&(topic, number)) {
            writer.message(topic, 10 * number as i64, bytes).expect("memory");
        }
    };
    for (&incarnation, k) in processes.iter().zip(1_u64..) {
        let mut frames = RadioFrames::zeroed();
        frames.header = header(Service::V2xSim, 0, k, Origins::NONE);
        write(Topic::RadioFrames, k, bytemuck::bytes_of(&frames));
        let origins = Origins { spat: Origin::of(&frames.header), ..Origins::NONE };
        let (mut map, mut spat) = (Map::zeroed(), Spat::zeroed());
        map.header = header(Service::Obu, incarnation, k, origins);
        spat.header = map.header;
        // In simulated time the messages of a cycle have any order.
        write(Topic::Spat, k, bytemuck::bytes_of(&spat));
        write(Topic::Map, k, bytemuck::bytes_of(&map));
    }
    writer.finish(&Tally::default()).expect("memory");
    Recording::of_bytes(PathBuf::from("test.mcap"), &file).expect("a recording")
}

fn header(source: Service, incarnation: u32, k: u64, origins: Origins) -> Header {
    let mut header = Header::new(10 * k, 100 * k as i64, origins);
    (header.sequence, header.incarnation, header.source) = (k, incarnation, source.to_wire());
    header
}

#[test]
fn every_cycle_has_its_frames_and_what_was_made_of_them() {
    let recording = recording(&[0; 200], &[]);
    let take = recording.unit_take();
    assert_eq!((take.cycles, take.with_frames, &take.cut_short), (200, 200, &None));
    for (cycle, k) in recording.unit_cycles(&take).zip(1_u64..) {
        assert_eq!((cycle.release().step, cycle.batch().sequence), (10 * k, k));
        assert!(cycle.frames.is_some() && cycle.spat.is_some() && cycle.sent.is_none());
    }
}

#[test]
fn a_loss_and_a_new_process_end_it() {
    for (lost, cycles, why) in [
        (
            (Topic::RadioFrames, 3),
            2,
            "message 3 of `radio/frames`, of its cycle 3, was not recorded",
        ),
        ((Topic::Spat, 2), 1, "message 2 of `v2x/spat`, of its cycle 2, was not recorded"),
        ((Topic::Map, 4), 3, "message 4 of `v2x/map`, of its cycle 4, was not recorded"),
    ] {
        let take = recording(&[0; 5], &[lost]).unit_take();
        assert_eq!((take.cycles, take.cut_short.as_deref()), (cycles, Some(why)));
    }
    let take = recording(&[0, 0, 1, 1], &[]).unit_take();
    assert_eq!(take.cycles, 2);
    assert!(take.cut_short.is_some_and(|why| why.contains("started again")));
}
