//! Hand-made captures: both formats, both byte orders, links, truncation and garbage.

use proptest::prelude::*;
use radio::{Capture, CaptureError};
use std::path::PathBuf;

const SECOND: i64 = 1_000_000_000;

fn open(bytes: &[u8]) -> Result<Capture, CaptureError> {
    Capture::read(bytes)
}

/// A classic capture of microseconds in this machine's byte order.
fn pcap(link: u32, packets: &[(u32, u32, &[u8])]) -> Vec<u8> {
    let mut file = Vec::new();
    file.extend(0xa1b2_c3d4_u32.to_le_bytes());
    file.extend([2, 0, 4, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    file.extend(65_535_u32.to_le_bytes());
    file.extend(link.to_le_bytes());
    for (second, microsecond, data) in packets {
        let length = u32::try_from(data.len()).expect("short");
        for word in [*second, *microsecond, length, length] {
            file.extend(word.to_le_bytes());
        }
        file.extend(*data);
    }
    file
}

/// A pcapng capture of nanoseconds in big-endian order.
fn pcapng(link: u16, packets: &[(i64, &[u8])]) -> Vec<u8> {
    let block = |kind: u32, body: &[u8]| {
        let length = u32::try_from(body.len() + 12).expect("short").to_be_bytes();
        [&kind.to_be_bytes()[..], &length, body, &length].concat()
    };
    let section = [&0x1a2b_3c4d_u32.to_be_bytes()[..], &[0, 1, 0, 0], &[0xff; 8]].concat();
    let resolution = [0, 9, 0, 1, 9, 0, 0, 0, 0, 0, 0, 0];
    let interface = [&link.to_be_bytes()[..], &[0; 6], &resolution].concat();
    let mut file = [block(0x0a0d_0d0a, &section), block(1, &interface)].concat();
    for (stamp_ns, data) in packets {
        let stamp = stamp_ns.unsigned_abs();
        let length = u32::try_from(data.len()).expect("short");
        let mut body = vec![0; 4];
        body.extend(u32::try_from(stamp >> 32).expect("32 bits").to_be_bytes());
        body.extend((stamp as u32).to_be_bytes());
        body.extend([length.to_be_bytes(), length.to_be_bytes()].concat());
        body.extend(*data);
        body.resize(body.len().next_multiple_of(4), 0);
        file.extend(block(6, &body));
    }
    file
}

fn ethernet(ether_type: u16, payload: &[u8]) -> Vec<u8> {
    [&[0xff; 6][..], &[2; 6], &ether_type.to_be_bytes(), payload].concat()
}

fn due(capture: &mut Capture, now_ns: i64) -> Vec<Vec<u8>> {
    std::iter::from_fn(|| capture.receive(now_ns)).map(|frame| frame.bytes().to_vec()).collect()
}

#[test]
fn frames_become_due_as_run_time_passes() {
    let (one, two) = (ethernet(0x8947, b"one"), ethernet(0x8947, b"two"));
    let tagged = ethernet(0x8100, &[&[0, 5][..], &0x8947_u16.to_be_bytes(), b"tagged"].concat());
    let arp = ethernet(0x0806, b"who has");
    let packets: [(u32, u32, &[u8]); 4] =
        [(1000, 500_000, &one), (1000, 600_000, &arp), (1001, 0, &tagged), (1001, 500_000, &two)];
    let mut capture = open(&pcap(1, &packets)).expect("a good capture");
    assert_eq!((capture.frames(), capture.passed_over, capture.duration_ns()), (3, 1, SECOND));
    assert_eq!(capture.wall_clock_ns(0), 1000 * SECOND + SECOND / 2);
    assert_eq!(due(&mut capture, 0), [b"one"]);
    assert_eq!(due(&mut capture, SECOND / 2 - 1), Vec::<Vec<u8>>::new());
    let tagged = capture.receive(SECOND / 2).expect("due now");
    assert_eq!((tagged.bytes(), tagged.sent_ns), (&b"tagged"[..], Some(1001 * SECOND)));
    assert_eq!(tagged.travelled_ns(), Some((0, 0)));
    assert_eq!(due(&mut capture, 10 * SECOND), [b"two"]);
    assert_eq!(due(&mut capture, i64::MAX), Vec::<Vec<u8>>::new());
}

#[test]
fn pcapng_of_the_other_byte_order_and_packets_that_are_frames() {
    let mut capture =
        open(&pcapng(147, &[(3 * SECOND + 7, b"b"), (3 * SECOND, b"a")])).expect("a good capture");
    assert_eq!(capture.wall_clock_ns(7), 3 * SECOND + 7);
    assert_eq!(due(&mut capture, 6), [b"a"]);
    assert_eq!(due(&mut capture, 7), [b"b"]);
}

#[test]
fn wireless_and_cooked_frames_are_read() {
    let snap = [0xaa, 0xaa, 3, 0, 0, 0];
    let header = |control: [u8; 2], more: usize| [&control[..], &[0; 22], &vec![0; more]].concat();
    let air = |header: Vec<u8>, snap: &[u8]| [&header, snap, &[0x89, 0x47], b"abc"].concat();
    let quality = air(header([0x88, 0], 2), &snap);
    let captured = |link: u32, packet: &[u8]| {
        open(&pcap(link, &[(1, 0, packet)])).ok().map(|mut capture| due(&mut capture, 0).concat())
    };
    let read = Some(b"abc".to_vec());
    assert_eq!(captured(105, &quality), read, "quality of service");
    assert_eq!(captured(105, &air(header([0x08, 0], 0), &snap)), read, "plain");
    assert_eq!(captured(105, &air(header([0x88, 3], 8), &snap)), read, "four addresses");
    assert_eq!(captured(105, &air(header([0x88, 0x80], 6), &[])), read, "high throughput, no SNAP");
    assert_eq!(captured(105, &air(header([0x88, 0x40], 2), &snap)), None, "encrypted");
    assert_eq!(captured(105, &air(header([0x80, 0], 0), &snap)), None, "a beacon");
    let tap = |head: &[u8], check: &[u8]| captured(127, &[head, &quality, check].concat());
    assert_eq!(tap(&[0, 0, 8, 0, 0, 0, 0, 0], &[]), read, "no fields");
    let timed = [&[0, 0, 25, 0, 3, 0, 0, 0][..], &[9; 8], &[0x10], &[0; 8]].concat();
    assert_eq!(tap(&timed, &[1, 2, 3, 4]), read, "timer and flags, with a check sequence");
    let extended = [&[0, 0, 17, 0, 2, 0, 0, 0x80][..], &[0; 4], &[0x10], &[0; 4]].concat();
    assert_eq!(tap(&extended, &[1, 2, 3, 4]), read, "two words of fields");
    assert_eq!(captured(127, &[0, 0, 200, 0, 0, 0, 0, 0]), None, "a header longer than the packet");
    let cooked = [&[0, 4, 0, 1, 0, 6][..], &[2; 6], &[0, 0, 0x89, 0x47], b"abc"].concat();
    assert_eq!(captured(113, &cooked), read);
}

#[test]
fn another_link_type_is_one_error() {
    for file in [pcap(228, &[(1, 0, b"IPv4")]), pcapng(228, &[(1, b"IPv4")])] {
        let error = open(&file).expect_err("no such link is read");
        assert!(matches!(error, CaptureError::LinkType { packet: 1, link_type: 228 }), "{error}");
        assert!(error.to_string().contains("expected 1 (Ethernet)"), "{error}");
    }
}

#[test]
fn packets_without_a_stamp_are_counted_in_one_error() {
    let mut file = pcapng(147, &[(SECOND, b"a")]);
    for _ in 0..2 {
        // Length of the packet, then the packet.
        file.extend([3_u32, 20, 1].map(u32::to_be_bytes).concat());
        file.extend(b"b\0\0\0");
        file.extend(20_u32.to_be_bytes());
    }
    let error = open(&file).expect_err("it is not known when they are due").to_string();
    assert!(error.starts_with("2 of 3 packets are simple packet blocks"), "{error}");
}

#[test]
fn a_capture_that_is_cut_off_ends_before_the_cut() {
    let (one, two) = (ethernet(0x8947, b"one"), ethernet(0x8947, b"two"));
    let classic = pcap(1, &[(1, 0, &one), (2, 0, &two)]);
    let newer = pcapng(1, &[(SECOND, &one), (2 * SECOND, &two)]);
    for file in [classic, newer] {
        assert!(!open(&file).expect("whole").is_truncated);
        for cut in 1..=17 {
            let mut capture = open(&file[..file.len() - cut]).expect("one is whole");
            assert!(capture.is_truncated);
            assert_eq!(due(&mut capture, 10 * SECOND), [b"one"]);
        }
    }
}

#[test]
fn a_file_is_read_as_its_bytes_are() {
    let path = std::env::temp_dir().join(format!("timegap-capture-{}", std::process::id()));
    let file = pcap(147, &[(1, 0, b"frame")]);
    std::fs::write(&path, &file).expect("room for a small file");
    let opened = Capture::open(&path);
    std::fs::remove_file(&path).expect("it was written");
    assert_eq!(due(&mut opened.expect("a good capture"), 0), [b"frame"]);
}

#[test]
fn what_holds_no_frame_is_one_error() {
    let said = |file: &[u8]| open(file).expect_err("no frames").to_string();
    assert!(said(b"").contains("is not a capture"));
    assert!(
        said(b"schema_version = 1\nname = \"no capture at all\"\n").contains("is not a capture")
    );
    assert!(said(&pcap(1, &[])).contains("none of 0 packets"));
    let arp = ethernet(0x0806, b"who has");
    assert!(said(&pcap(1, &[(1, 0, &arp)])).contains("none of 1 packets is a GeoNetworking"));
    assert!(said(&pcap(147, &[(1, 0, &[0; 1501])])).contains("none of 1 packets"));
    let missing = Capture::open(&PathBuf::from("/no/such/capture")).expect_err("no file");
    assert!(matches!(missing, CaptureError::Read(_)));
    let directory = Capture::open(&std::env::temp_dir()).expect_err("a directory");
    assert!(matches!(directory, CaptureError::Read(_)));
}

proptest! {
    #[test]
    fn garbage_is_refused_or_played(
        place in 0..400usize, byte: u8, cut in 0..400usize, newer: bool, tail in prop::collection::vec(any::<u8>(), 0..64),
    ) {
        let frame = ethernet(0x8947, &[7; 60]);
        let mut file = if newer {
            pcapng(1, &[(SECOND, &frame), (2 * SECOND, &frame)])
        } else {
            pcap(1, &[(1, 0, &frame), (2, 0, &frame)])
        };
        if let Some(place) = file.get_mut(place) {
            *place = byte;
        }
        file.truncate(cut);
        file.extend(tail);
        if let Ok(mut capture) = open(&file) {
            let frames = capture.frames();
            prop_assert_eq!(due(&mut capture, i64::MAX).len(), frames);
        }
    }
}
