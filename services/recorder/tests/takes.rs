//! What can be replayed: every cycle up to the first whose command or inputs are not there.

use recorder::{Metadata, Recording, Take, Writer};
use shared::messages::{Command, Message, Odometry, Origin};
use shared::runtime::Mode;
use shared::scenario::{Overrides, Scenario};
use std::io::Cursor;
use std::path::PathBuf;

/// Takes of a recording in which command `k` of each incarnation uses odometry `k`, without the
/// messages that `lost` names by topic and number.
fn takes(commands: &[(u32, u64)], lost: &[(&str, u64)]) -> Vec<Take> {
    let scenario = Scenario::open("cacc-a", &Overrides::new(), &|_| Ok(())).expect("built in");
    let metadata = Metadata::new(&scenario, Mode::Realtime, 0, [].into());
    let mut file = Vec::new();
    let mut writer = Writer::begin(Cursor::new(&mut file), &metadata).expect("memory");
    let mut write = |topic, number, bytes: &[u8]| {
        if !lost.contains(&(shared::messages::Topic::name(topic), number)) {
            writer.message(topic, 0, bytes).expect("memory");
        }
    };
    let mut odometry: Odometry = bytemuck::Zeroable::zeroed();
    for &(incarnation, sequence) in commands {
        odometry.header.sequence += 1;
        odometry.header.publish_ns += 10;
        write(Odometry::TOPIC, odometry.header.sequence, bytemuck::bytes_of(&odometry));
        let mut command: Command = bytemuck::Zeroable::zeroed();
        command.header.sequence = sequence;
        command.header.incarnation = incarnation;
        command.header.step = 10 * odometry.header.sequence;
        command.header.origins.odometry = Origin::of(&odometry.header);
        command.start_ns = odometry.header.publish_ns + 3;
        write(Command::TOPIC, odometry.header.sequence, bytemuck::bytes_of(&command));
    }
    writer.finish(&Default::default()).expect("memory");
    Recording::of_bytes(PathBuf::from("test.mcap"), &file).expect("a recording").takes()
}

const RESTARTED: [(u32, u64); 5] = [(0, 1), (0, 2), (0, 3), (1, 1), (1, 2)];

#[test]
fn every_process_of_the_controller_is_a_take() {
    let takes = takes(&RESTARTED, &[]);
    let lengths: Vec<_> = takes.iter().map(|t| (t.incarnation, t.releases.len())).collect();
    assert_eq!(lengths, [(0, 3), (1, 2)]);
    let release = takes[1].releases[0];
    assert_eq!((release.step, release.start_ns, release.inputs.odometry.sequence), (40, 43, 4));
    assert!(takes.iter().all(|take| take.cut_short.is_none()));
}

#[test]
fn a_lost_command_or_input_ends_its_take_alone() {
    let without_command = takes(&RESTARTED, &[("control/command", 2)]);
    assert_eq!(without_command.iter().map(|t| t.commands.len()).collect::<Vec<_>>(), [1, 2]);
    let why = without_command[0].cut_short.as_deref();
    assert_eq!(why, Some("its command 2 was not recorded"));

    let without_input = takes(&RESTARTED, &[("vehicle/odometry", 5)]);
    assert_eq!(without_input.iter().map(|t| t.commands.len()).collect::<Vec<_>>(), [3, 1]);
    let why = without_input[1].cut_short.as_deref().unwrap_or_default();
    assert!(why.contains("message 5 of `vehicle/odometry`, which its command 2 used"), "{why}");
}
