//! A written file is read, a broken one up to its damage.

use messages::{Command, Heartbeat, Message, Odometry};
use recorder::{Damage, LawNames, Metadata, ReadError, Recording, Tally, Writer, recover};
use runtime::Mode;
use scenario::{Overrides, Scenario};
use std::io::Cursor;
use std::path::PathBuf;

const MESSAGES: u64 = 600;

fn metadata() -> Metadata {
    let scenario =
        Scenario::open("cacc-a", &Overrides::new(), &|_| Ok(Default::default())).expect("built in");
    let granted = serde_json::from_str(
        r#"{"requested":"fifo:80","granted":"other","core":1,"memory_locked":false,"refused":[]}"#,
    )
    .expect("a grant");
    let scheduling = [("controller".to_owned(), granted)].into();
    let law = LawNames { modes: vec!["one".into()], ..LawNames::default() };
    Metadata::new(&scenario, Mode::Realtime, 1_700_000_000_000_000_000, scheduling, law)
}

fn stamped<T: Message>(sequence: u64) -> T {
    let mut message = T::zeroed();
    let header = message.header_mut();
    header.sequence = sequence;
    header.publish_ns = sequence as i64 * 1_000_000;
    header.source = 1;
    message
}

/// A recording of two topics in three flushes.
fn file(end: bool) -> Vec<u8> {
    let mut file = Vec::new();
    let mut writer = Writer::begin(Cursor::new(&mut file), &metadata()).expect("memory");
    for sequence in 1..=MESSAGES {
        let mut odometry: Odometry = stamped(sequence);
        odometry.position_m = sequence as f64 / 3.0;
        let log_time_ns = odometry.header.publish_ns + 500;
        writer
            .message(Odometry::TOPIC, log_time_ns, bytemuck::bytes_of(&odometry))
            .expect("memory");
        let mut command: Command = stamped(sequence);
        command.plan_mps2[127] = -(sequence as f64);
        writer.message(Command::TOPIC, log_time_ns, bytemuck::bytes_of(&command)).expect("memory");
        if sequence % 200 == 0 {
            writer.flush().expect("memory");
        }
    }
    if end {
        writer.finish(&Tally::default()).expect("memory");
    } else {
        // As after SIGKILL: the writer is never closed.
        std::mem::forget(writer);
    }
    file
}

fn middle_of_second_chunk(file: &[u8]) -> usize {
    const CHUNK: u8 = 6;
    let mut at = 8;
    let mut chunks = 0;
    loop {
        let length = u64::from_le_bytes(file[at + 1..at + 9].try_into().expect("eight bytes"));
        let length = 9 + usize::try_from(length).expect("small");
        chunks += u32::from(file[at] == CHUNK);
        if chunks == 2 {
            return at + length / 2;
        }
        at += length;
    }
}

fn read(file: &[u8]) -> Result<Recording, ReadError> {
    Recording::of_bytes(PathBuf::from("test.mcap"), file)
}

#[test]
fn written_files_are_read() {
    let recording = read(&file(true)).expect("a recording");
    assert_eq!(*recording.metadata(), metadata());
    assert_eq!((recording.damage(), recording.tally()), (&[][..], Some(&Tally::default())));
    assert_eq!(recording.records().count() as u64, 2 * MESSAGES);
    for (timed, sequence) in recording.messages::<Odometry>().zip(1..) {
        assert_eq!(timed.log_time_ns, sequence * 1_000_000 + 500);
        assert_eq!(timed.message.header.sequence, sequence as u64);
        assert_eq!(timed.message.position_m, sequence as f64 / 3.0);
    }
    let last = recording.messages::<Command>().last().expect("commands");
    assert_eq!(last.message.plan_mps2[127], -(MESSAGES as f64));
    assert_eq!(recording.messages::<Heartbeat>().count(), 0);
    let survey = recording.survey();
    assert_eq!(survey.end_ns, MESSAGES as i64 * 1_000_000 + 500);
    assert_eq!((survey.tally.messages(), survey.damage.len()), (2 * MESSAGES, 0));
}

#[test]
fn a_file_that_was_never_ended_keeps_what_was_flushed() {
    let recording = read(&file(false)).expect("a prefix");
    assert_eq!(recording.records().count() as u64, 2 * MESSAGES);
    assert_eq!(recording.damage(), [Damage::CutOff { bytes: 0 }]);
    assert_eq!(recording.tally(), None);
}

#[test]
fn a_file_that_is_cut_is_read_and_one_that_goes_on_is_refused() {
    let whole = file(true);
    let of = |file: &[u8]| read(file).expect("a recording").damage().to_vec();
    // The magic bytes, the footer, the summary: a reader that begins at the end needs all of them.
    for missing in [1, 8, 9, 36, 37, 60, 500] {
        let damage = of(&whole[..whole.len() - missing]);
        assert!(matches!(damage[..], [Damage::CutOff { .. }]), "{missing} bytes: {damage:?}");
    }
    for more in [&whole[..], b"x"] {
        let refused = read(&[&whole[..], more].concat()).expect_err("another file follows");
        assert!(refused.to_string().contains("behind its end"), "{refused}");
    }
}

#[test]
fn every_prefix_is_read_as_far_as_it_goes() {
    let whole = file(true);
    let all: Vec<_> = read(&whole).expect("whole").records().map(|r| r.bytes().to_vec()).collect();
    let mut before = 0;
    for length in (0..whole.len()).step_by(1009) {
        match read(&whole[..length]) {
            Ok(prefix) => {
                let found: Vec<_> = prefix.records().map(|r| r.bytes().to_vec()).collect();
                assert!(all.starts_with(&found), "{length} bytes: not a prefix");
                assert!(found.len() >= before, "{length} bytes: fewer than from fewer bytes");
                before = found.len();
            }
            Err(ReadError::Foreign { .. }) => assert_eq!(before, 0, "{length} bytes"),
            Err(error) => panic!("{length} bytes: {error}"),
        }
    }
    assert_eq!(before, all.len());
}

/// First byte behind the data section.
fn end_of_data(file: &[u8]) -> usize {
    const DATA_END: u8 = 15;
    let mut at = 8;
    loop {
        let length = u64::from_le_bytes(file[at + 1..at + 9].try_into().expect("eight bytes"));
        let end = at + 9 + usize::try_from(length).expect("small");
        if file[at] == DATA_END {
            return end;
        }
        at = end;
    }
}

#[test]
fn one_wrong_bit_behind_the_messages_costs_no_message() {
    let whole = file(true);
    let all: Vec<_> = read(&whole).expect("whole").records().map(|r| r.bytes().to_vec()).collect();
    let from = end_of_data(&whole);
    // The record that ends the data section, the summary, the footer and the magic bytes.
    for at in (from - 13..whole.len()).step_by(499) {
        let mut file = whole.clone();
        file[at] ^= 1 << (at % 8);
        let recording = read(&file).unwrap_or_else(|error| panic!("byte {at}: {error}"));
        let found: Vec<_> = recording.records().map(|r| r.bytes().to_vec()).collect();
        assert!(found == all, "byte {at}: {} of {}", found.len(), all.len());
        assert!(!recording.damage().is_empty(), "byte {at}: the damage is unnoticed");
    }
}

#[test]
fn a_damaged_chunk_is_left_out_and_said() {
    let mut file = file(true);
    let whole = read(&file).expect("whole");
    let middle = middle_of_second_chunk(&file);
    file[middle] ^= 0x40;
    let recording = read(&file).expect("the rest");
    assert!(recording.records().count() < whole.records().count());
    assert!(recording.records().count() > 0);
    let damage = recording.survey().damage;
    let [Damage::Chunk { offset, bytes, .. }] = &damage[..] else { panic!("{damage:?}") };
    assert!((*offset..offset + bytes).contains(&(middle as u64)));
}

#[test]
fn a_recovered_file_is_whole_and_counts_what_is_missing() {
    let file = file(false);
    let broken = read(&file[..file.len() * 2 / 3]).expect("a prefix");
    let mut recovered = Cursor::new(Vec::new());
    let (result, summary) = recover(&broken, &mut recovered).expect("memory");
    let again = read(recovered.get_ref()).expect("whole");
    assert!(again.damage().is_empty());
    assert_eq!(again.tally(), Some(&result.tally));
    assert_eq!(result.tally.messages(), broken.records().count() as u64);
    assert_eq!((result.tally.lost(), result.damage.len()), (0, 1));
    assert!(broken.records().eq(again.records()));
    // The file's own statistics agree, without a look at any message.
    let statistics = again.statistics().expect("it was ended");
    assert_eq!(statistics, again.survey());
    let read = mcap::Summary::read(recovered.get_ref()).expect("readable").expect("there");
    assert_eq!(read.stats, summary.stats);
}

#[test]
fn other_files_are_refused_with_the_reason() {
    let error = read(b"not a recording").expect_err("no magic").to_string();
    assert!(error.contains("not an MCAP file"), "{error}");
    let mut empty = Cursor::new(Vec::new());
    mcap::Writer::new(&mut empty).and_then(|mut writer| writer.finish()).expect("memory");
    let error = read(empty.get_ref()).expect_err("no metadata").to_string();
    assert!(error.contains("which run"), "{error}");
}
