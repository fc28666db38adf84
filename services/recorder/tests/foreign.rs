//! Recordings that another program wrote or that are damaged on purpose. The reader gives the messages
//! of ours, or the fault. It never takes more memory or time than the file is worth.

use messages::{Message, Odometry};
use recorder::{Damage, LawNames, Metadata, ReadError, Recording, Tally, Writer};
use runtime::Mode;
use scenario::{Overrides, Scenario};
use std::io::{Cursor, Write};
use std::path::PathBuf;

const FOOTER: u8 = 2;
const CHUNK: u8 = 6;
const MESSAGE: u8 = 5;
const METADATA: u8 = 12;
const DATA_END: u8 = 15;
const COUNT: u64 = 600;

/// A record of the format.
fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat()
}

/// A file of ours with one message in each chunk, as its records.
fn ours() -> Vec<(u8, Vec<u8>)> {
    let scenario =
        Scenario::open("cacc-a", &Overrides::new(), &|_| Ok(Default::default())).expect("built in");
    let metadata = Metadata::new(&scenario, Mode::Realtime, 0, [].into(), LawNames::default());
    let mut file = Vec::new();
    let mut writer = Writer::begin(Cursor::new(&mut file), &metadata).expect("memory");
    for sequence in 1..=COUNT {
        let mut odometry = <Odometry as bytemuck::Zeroable>::zeroed();
        odometry.header.sequence = sequence;
        odometry.header.source = 1;
        odometry.header.publish_ns = sequence as i64 * 10_000_000;
        let at_ns = odometry.header.publish_ns;
        writer.message(Odometry::TOPIC, at_ns, bytemuck::bytes_of(&odometry)).expect("memory");
        writer.flush().expect("memory");
    }
    writer.finish(&Tally::default()).expect("memory");
    records(&file[8..])
}

fn records(mut rest: &[u8]) -> Vec<(u8, Vec<u8>)> {
    let mut found = Vec::new();
    while rest.len() > 9 {
        let length = u64::from_le_bytes(rest[1..9].try_into().expect("eight bytes")) as usize;
        found.push((rest[0], rest[9..9 + length].to_vec()));
        rest = &rest[9 + length..];
    }
    found
}

/// The records of a chunk of ours.
fn unpacked(chunk: &[u8]) -> Vec<u8> {
    let name = u32::from_le_bytes(chunk[28..32].try_into().expect("four bytes")) as usize;
    let mut records = Vec::new();
    let mut decoder = lz4::Decoder::new(&chunk[32 + name + 8..]).expect("memory");
    std::io::copy(&mut decoder, &mut records).expect("it was packed");
    records
}

/// A chunk with these records, said to be `length` bytes long.
fn chunk(times: &[u8], records: &[u8], compression: &str, packed: &[u8], length: u64) -> Vec<u8> {
    let checksum = crc32fast::hash(records);
    let mut body = times.to_vec();
    body.extend(length.to_le_bytes());
    body.extend(checksum.to_le_bytes());
    body.extend((compression.len() as u32).to_le_bytes());
    body.extend(compression.as_bytes());
    body.extend((packed.len() as u64).to_le_bytes());
    body.extend(packed);
    record(CHUNK, &body)
}

fn file(records: &[Vec<u8>]) -> Vec<u8> {
    [b"\x89MCAP0\r\n".to_vec(), records.concat()].concat()
}

fn read(records: &[Vec<u8>]) -> Result<Recording, ReadError> {
    Recording::of_bytes(PathBuf::from("test.mcap"), &file(records))
}

fn sequences(recording: &Recording) -> Vec<u64> {
    recording.messages::<Odometry>().map(|timed| timed.message.header.sequence).collect()
}

/// The part before the messages, and the chunks.
fn parts() -> (Vec<Vec<u8>>, Vec<Vec<u8>>) {
    let mut head = Vec::new();
    let mut chunks = Vec::new();
    for (opcode, body) in ours() {
        match opcode {
            METADATA if head.is_empty() => head.push(record(METADATA, &body)),
            CHUNK => chunks.push(body),
            _ => {}
        }
    }
    (head, chunks)
}

fn end() -> Vec<u8> {
    [record(DATA_END, &[0; 4]), record(FOOTER, &[0; 20]), b"\x89MCAP0\r\n".to_vec()].concat()
}

#[test]
fn plain_and_packed_chunks_are_read_alike_and_messages_without_are_refused() {
    let (head, chunks) = parts();
    for compression in ["", "lz4", "none"] {
        let mut all = head.clone();
        for body in &chunks {
            let records = unpacked(body);
            match compression {
                "" => all.push(chunk(&body[..16], &records, "", &records, records.len() as u64)),
                "lz4" => all.push(record(CHUNK, body)),
                // No chunks at all.
                _ => all.push(records),
            }
        }
        all.push(end());
        if compression == "none" {
            assert_refused(&all, "messages outside of chunks");
            continue;
        }
        let recording = read(&all).expect("a recording");
        assert_eq!(sequences(&recording), (1..=COUNT).collect::<Vec<_>>(), "{compression}");
        assert_eq!(recording.survey().damage, [], "{compression}");
        assert_eq!(recording.statistics(), None, "it keeps none");
    }
}

fn assert_refused(records: &[Vec<u8>], why: &str) {
    let refused = read(records).expect_err(why);
    assert!(matches!(refused, ReadError::Foreign { .. }), "{refused}");
    assert!(refused.to_string().contains(why), "{refused}");
}

#[test]
fn chunks_out_of_the_order_of_their_log_times_are_refused() {
    let (head, mut chunks) = parts();
    let definitions = chunks.remove(0);
    chunks.swap(3, 4);
    let mut all = head;
    all.push(record(CHUNK, &definitions));
    all.extend(chunks.iter().map(|body| record(CHUNK, body)));
    all.push(end());
    assert_refused(&all, "not in the order of their log times");
}

#[test]
fn a_chunk_that_was_shuffled_is_left_out_from_there_on() {
    let (mut all, chunks) = parts();
    all.push(record(CHUNK, &chunks[0]));
    let swapped = [unpacked(&chunks[2]), unpacked(&chunks[1])].concat();
    let times = [&chunks[1][..8], &chunks[2][8..16]].concat();
    all.push(chunk(&times, &swapped, "", &swapped, swapped.len() as u64));
    all.push(end());
    let survey = read(&all).expect("a recording").survey();
    let [Damage::Chunk { reason, .. }] = &survey.damage[..] else { panic!("{:?}", survey.damage) };
    assert!(reason.contains("not in the order of their log times"), "{reason}");
    assert_eq!(survey.tally.messages(), 1);
}

#[test]
fn a_chunks_stated_length_costs_nothing() {
    let (head, chunks) = parts();
    let body = &chunks[0];
    let records = unpacked(body);
    let mut encoder = lz4::EncoderBuilder::new().build(Vec::new()).expect("memory");
    for _ in 0..64 {
        encoder.write_all(&[0; 1 << 20]).expect("memory");
    }
    let bomb = encoder.finish().0;
    let length = records.len() as u64;
    let cases = [
        (chunk(&[0; 16], &records, "lz4", &bomb, 1 << 40), "may have"),
        (chunk(&[0; 16], &records, "lz4", &bomb, 1000), "longer than the 1000 bytes"),
        (chunk(&[0; 16], &records, "", &records, length + 1), "of the"),
        (chunk(&[0; 16], &records, "brotli", &records, length), "`brotli`"),
        (chunk(&[0; 16], &records, "zstd", &records, length), "zstd data is damaged"),
        (chunk(&[0; 16], b"other", "", &records, length), "checksum"),
        (record(CHUNK, &body[..20]), "lengths do not fit"),
    ];
    for (chunk, why) in cases {
        let mut all = head.clone();
        all.extend(chunks.iter().map(|body| record(CHUNK, body)));
        all.push(chunk);
        all.push(end());
        let recording = read(&all).expect("the rest");
        let survey = recording.survey();
        assert_eq!(survey.tally.messages(), COUNT, "{why}");
        let [Damage::Chunk { reason, .. }] = &survey.damage[..] else {
            panic!("{why}: {:?}", survey.damage)
        };
        assert!(reason.contains(why), "{why}: {reason}");
    }
}

#[test]
fn lengths_beyond_the_file_are_its_end() {
    let (head, chunks) = parts();
    for opcode in [METADATA, CHUNK, MESSAGE, 99] {
        let mut all = head.clone();
        all.extend(chunks.iter().map(|body| record(CHUNK, body)));
        all.push([&[opcode][..], &u64::from(u32::MAX).to_le_bytes(), b"few"].concat());
        let recording = read(&all).expect("the rest");
        assert_eq!(recording.damage(), [Damage::CutOff { bytes: 12 }]);
        assert_eq!(recording.records().count() as u64, COUNT);
    }
    // A text of 4 GiB in a record of a few bytes.
    let huge = [&4_u32.to_le_bytes()[..], b"name", &u32::MAX.to_le_bytes()].concat();
    let all = [head, vec![record(METADATA, &huge), end()]].concat();
    let recording = read(&all).expect("a recording");
    assert!(matches!(recording.damage(), [Damage::Chunk { .. }]), "{:?}", recording.damage());
}

#[test]
fn a_payload_that_is_not_ours_is_damage_of_its_chunk() {
    let (head, chunks) = parts();
    let mut all = head;
    for (index, body) in chunks.iter().enumerate() {
        let mut records = unpacked(body);
        if index == 3 {
            // Big-endian CDR: the byte behind the heads of record and message.
            records[9 + 22 + 1] = 0;
        }
        all.push(chunk(&body[..16], &records, "", &records, records.len() as u64));
    }
    all.push(end());
    let survey = read(&all).expect("a recording").survey();
    assert_eq!(survey.tally.messages(), COUNT - 1);
    let [Damage::Chunk { reason, .. }] = &survey.damage[..] else { panic!("{:?}", survey.damage) };
    assert!(reason.contains("`vehicle/odometry`"), "{reason}");
}

#[test]
fn files_without_anything_are_refused_with_the_reason() {
    for (bytes, why) in
        [(&b""[..], "empty"), (b"\x89MCAP", "not an MCAP file"), (b"\x89MCAP0\r\n", "which run")]
    {
        let error = Recording::of_bytes("test.mcap".into(), bytes).expect_err(why).to_string();
        assert!(error.contains(why), "{error}");
    }
}

/// A file of ours in which `from` is `to`, as long, in every channel and schema.
fn with(from: &[u8], to: &[u8]) -> Result<Recording, ReadError> {
    let (mut all, chunks) = parts();
    for body in &chunks {
        let (times, mut changed) = (body[..16].to_vec(), Vec::new());
        for (opcode, mut body) in records(&unpacked(body)) {
            let at = body.windows(from.len()).position(|bytes| bytes == from);
            if let (Some(at), true) = (at, opcode != MESSAGE) {
                body[at..at + to.len()].copy_from_slice(to);
            }
            changed.extend(record(opcode, &body));
        }
        all.push(chunk(&times, &changed, "", &changed, changed.len() as u64));
    }
    all.push(end());
    read(&all)
}

#[test]
fn a_topic_under_another_name_is_refused_by_name() {
    let refused = with(b"vehicle/odometry", b"vehicle/Odometry").expect_err("renamed").to_string();
    assert!(refused.contains("`vehicle/Odometry` is that of `vehicle/odometry`"), "{refused}");
}

#[test]
fn other_encodings_are_not_read_as_ours() {
    let encodings: [(&[u8], &[u8]); 2] =
        [(b"\x03\0\0\0cdr", b"\x03\0\0\0xml"), (b"ros2msg", b"ros1msg")];
    for (ours, other) in encodings {
        let refused = with(ours, other).expect_err("not ours");
        assert!(matches!(refused, ReadError::Layout { .. }), "{refused}");
    }
}
