//! Replay of a controller's recording: every cycle up to the first whose command or inputs are not there.

use bytemuck::Zeroable;
use messages::level::Level;
use messages::{Command, Diagnostics, Odometry, Origin, Topic};
use recorder::{LawNames, Metadata, Recording, Take, Tally, Writer};
use runtime::Mode;
use scenario::{Overrides, Scenario};
use std::io::Cursor;
use std::path::PathBuf;

/// A recording in which cycle `k` uses odometry `k`, without the messages that `lost` names
/// by topic and number. Cycle 2 is a silent one.
fn recording(cycles: &[(u32, u64)], lost: &[(Topic, u64)]) -> Recording {
    let scenario =
        Scenario::open("cacc-a", &Overrides::new(), &|_| Ok(Default::default())).expect("built in");
    let metadata = Metadata::new(&scenario, Mode::Realtime, 0, [].into(), LawNames::default());
    let mut file = Vec::new();
    let mut writer = Writer::begin(Cursor::new(&mut file), &metadata).expect("memory");
    let mut write = |topic, number, bytes: &[u8]| {
        if !lost.contains(&(topic, number)) {
            writer.message(topic, 10 * number as i64, bytes).expect("memory");
        }
    };
    for (&(incarnation, sequence), k) in cycles.iter().zip(1..) {
        let mut odometry = Odometry::zeroed();
        odometry.header.sequence = k;
        odometry.header.publish_ns = 10 * k as i64;
        write(Topic::Odometry, k, bytemuck::bytes_of(&odometry));
        let mut cycle = Diagnostics::zeroed();
        cycle.header.sequence = sequence;
        cycle.header.incarnation = incarnation;
        cycle.header.step = 10 * k;
        cycle.header.origins.odometry = Origin::of(&odometry.header);
        cycle.start_ns = odometry.header.publish_ns + 3;
        if k == 2 {
            cycle.rung = Level::Silent as u32;
        } else {
            let mut command = Command::zeroed();
            command.header = cycle.header;
            command.header.publish_ns = cycle.start_ns + 4;
            write(Topic::Command, k, bytemuck::bytes_of(&command));
        }
        write(Topic::Diagnostics, k, bytemuck::bytes_of(&cycle));
    }
    writer.finish(&Tally::default()).expect("memory");
    Recording::of_bytes(PathBuf::from("test.mcap"), &file).expect("a recording")
}

const RESTARTED: [(u32, u64); 5] = [(0, 1), (0, 2), (0, 3), (1, 1), (1, 2)];

fn lengths(takes: &[Take]) -> Vec<(u64, u64)> {
    takes.iter().map(|take| (take.cycles, take.commands)).collect()
}

#[test]
fn every_process_of_the_controller_is_a_take() {
    let recording = recording(&RESTARTED, &[]);
    let takes = recording.takes();
    assert_eq!(lengths(&takes), [(3, 2), (2, 2)], "one cycle is silent");
    let cycles: Vec<_> = recording.cycles(&takes[1]).collect();
    assert_eq!(cycles.len(), 2);
    assert!(cycles[0].samples[1].is_some(), "the odometry that it used");
    let release = cycles[0].release();
    assert_eq!((release.step, release.start_ns, release.publish_ns), (40, 43, 47));
    assert_eq!(release.inputs.odometry.sequence, 4);
    let silent = recording.cycles(&takes[0]).nth(1).expect("cycle 2").release();
    assert_eq!(silent.publish_ns, silent.start_ns);
    assert!(takes.iter().all(|take| take.cut_short.is_none()));
}

#[test]
fn a_loss_ends_its_take_alone() {
    for (lost, expected, why) in [
        ((Topic::Command, 3), [(2, 1), (2, 2)], "the command of its cycle 3 was not recorded"),
        (
            (Topic::Diagnostics, 2),
            [(1, 1), (2, 2)],
            "the diagnostics of its cycle 2 were not recorded",
        ),
        (
            (Topic::Odometry, 5),
            [(3, 2), (1, 1)],
            "message 5 of `vehicle/odometry`, which its cycle 2 used, was not recorded",
        ),
    ] {
        let takes = recording(&RESTARTED, &[lost]).takes();
        assert_eq!(lengths(&takes), expected, "{lost:?}");
        let said: Vec<_> = takes.iter().filter_map(|take| take.cut_short.as_deref()).collect();
        assert_eq!(said, [why]);
    }
}
