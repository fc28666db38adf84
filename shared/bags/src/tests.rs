//! Files as other programs write them, whole and damaged.

use crate::{BagError, mcap::MAGIC, series_from};
use ::mcap::records::MessageHeader;
use proptest::prelude::*;
use std::io::Cursor;

const DEFINITION: &str = "std_msgs/Header header\nstring unit\nfloat64 speed\nuint16[] flags\nfloat32[2] xy\n\
    ====\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n\
    ====\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
/// The same in ROS 1, whose headers have a sequence number and whose time is a scalar.
const ROS1_DEFINITION: &str = "Header header\nstring unit\nfloat64 speed\nuint16[] flags\nfloat32[2] xy\n\
    ====\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n";

fn fields() -> Vec<String> {
    ["header.stamp", "speed", "flags[1]", "xy[1]"].map(String::from).to_vec()
}

/// A message in CDR, aligned by hand: stamp, frame `car`, unit `m`, speed, flags [7, 8], xy.
fn cdr(seconds: i32, speed: f64) -> Vec<u8> {
    let mut body = vec![0, 1, 0, 0];
    body.extend(seconds.to_le_bytes());
    body.extend(500_000_000_u32.to_le_bytes());
    body.extend([4, 0, 0, 0, b'c', b'a', b'r', 0, 2, 0, 0, 0, b'm', 0, 0, 0]);
    body.extend(speed.to_le_bytes());
    body.extend([2, 0, 0, 0, 7, 0, 8, 0]);
    body.extend([1.5_f32, -2.5].map(f32::to_le_bytes).concat());
    body
}

fn ros1(seconds: u32, speed: f64) -> Vec<u8> {
    let mut body = [9_u32, seconds, 500_000_000, 3].map(u32::to_le_bytes).concat();
    body.extend(b"car\x01\0\0\0m");
    body.extend(speed.to_le_bytes());
    body.extend([2, 0, 0, 0, 7, 0, 8, 0]);
    body.extend([1.5_f32, -2.5].map(f32::to_le_bytes).concat());
    body
}

/// An MCAP file by the reference implementation. Its second message is earlier than its first.
fn mcap_file(compression: Option<::mcap::Compression>) -> Vec<u8> {
    file_of(compression, ("ros2msg", "cdr", DEFINITION), [cdr(11, 5.0), cdr(10, 4.5)])
}

/// The same from a converted ROS 1 bag.
fn converted_file() -> Vec<u8> {
    file_of(None, ("ros1msg", "ros1", ROS1_DEFINITION), [ros1(11, 5.0), ros1(10, 4.5)])
}

fn file_of(
    compression: Option<::mcap::Compression>,
    (language, encoding, definition): (&str, &str, &str),
    [later, earlier]: [Vec<u8>; 2],
) -> Vec<u8> {
    let options = ::mcap::WriteOptions::new().compression(compression);
    let mut writer = options.create(Cursor::new(Vec::new())).expect("memory");
    let schema = writer.add_schema("my/msg/Speed", language, definition.as_bytes());
    let channel = writer
        .add_channel(schema.expect("a schema"), "/speed", encoding, &Default::default())
        .expect("a channel");
    let other = writer.add_schema("x.Y", "protobuf", b"").expect("a schema");
    let other = writer.add_channel(other, "/proto", "protobuf", &Default::default());
    let other = other.expect("a channel");
    for (channel_id, log_time, data) in
        [(channel, 2_000, later), (other, 1_500, vec![1]), (channel, 1_000, earlier)]
    {
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: 0 };
        writer.write_to_known_channel(&header, &data).expect("memory");
    }
    writer.finish().expect("memory");
    writer.into_inner().into_inner()
}

fn read(bytes: &[u8], topic: &str) -> Result<Vec<Vec<f64>>, BagError> {
    let series = series_from(&mut Cursor::new(bytes), topic, &fields())?;
    Ok(series.rows.into_iter().map(|row| row.values).collect())
}

#[test]
fn the_folder_of_a_bag_stands_for_its_one_file() {
    let folder = std::env::temp_dir().join(format!("timegap-bag-{}", std::process::id()));
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes).expect("ours");
    std::fs::create_dir(&folder).expect("ours");
    write("metadata.yaml", b"rosbag2_bagfile_information:\n");
    assert!(!crate::is_bag(&folder));
    write("drive_0.mcap", &mcap_file(None));
    assert!(crate::is_bag(&folder));
    let rows = crate::series(&folder, "/speed", &fields()).map(|series| series.rows.len());
    assert_eq!(rows.expect("one bag"), 2);
    write("drive_1.mcap", &mcap_file(None));
    let refused = crate::topics(&folder).expect_err("two bags").to_string();
    assert!(refused.starts_with("it is a folder with 2 bags, expected one of them"), "{refused}");
    std::fs::remove_dir_all(&folder).expect("ours");
}

#[test]
fn numbers_come_out_by_topic_and_path_in_order_of_time() {
    let expected = vec![vec![10.5, 4.5, 8.0, -2.5], vec![11.5, 5.0, 8.0, -2.5]];
    let files = [mcap_file(None), mcap_file(Some(::mcap::Compression::Lz4)), converted_file()];
    for file in files {
        assert_eq!(read(&file, "/speed").expect("a right file"), expected);
    }
}

#[test]
fn refusals_name_what_the_file_has() {
    let file = mcap_file(None);
    let said =
        |result: Result<_, BagError>| result.map(|_: Vec<_>| ()).expect_err("wrong").to_string();
    let no_topic = said(read(&file, "/fast"));
    assert_eq!(no_topic, "no topic `/fast`, expected one of `/proto`, `/speed`");
    assert!(said(read(&file, "/proto")).contains("encoded as protobuf"));
    let field = series_from(&mut Cursor::new(&file), "/speed", &["unit".into()]).expect_err("text");
    let expected = "expected one of `header.stamp`, `speed`, `flags[0]`, `xy[0]`";
    assert!(field.to_string().ends_with(expected), "{field}");
    assert!(said(read(b"#ROSBAG V2.0\n\0\0\0", "/speed")).contains("`rosbags-convert` makes one"));
    assert!(said(read(b"SQLite format 3\0", "/speed")).contains("`ros2 bag convert` makes one"));
    assert_eq!(said(read(b"time_s,speed_mps", "/")), "it is not a bag, expected an MCAP file");
}

#[test]
fn a_type_that_repeats_itself_without_bytes_ends() {
    let nested = "A[4000000000] a\n====\nMSG: x/A\nB[4000000000] b\n====\nMSG: x/B\nuint8[0] c\n";
    let definition =
        crate::definition::Definition::parse("x/Root", &format!("{nested}float64 z\n"));
    let found = crate::decode::number(&definition, "z", false, &[0; 8]);
    assert!(found.is_err() || found == Ok(None), "{found:?}");
}

proptest! {
    #[test]
    fn damaged_files_never_panic(
        at in any::<prop::sample::Index>(), bits in 1..=255u8, kind in 0..2usize,
    ) {
        let mut file = if kind == 0 { mcap_file(None) } else { converted_file() };
        let at = at.index(file.len() - MAGIC.len()) + MAGIC.len();
        file[at] ^= bits;
        let _ = read(&file, "/speed");
        let _ = read(&file[..at], "/speed");
    }
}
