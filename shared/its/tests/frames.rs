//! Messages to bytes and back, and bytes that are not a message.

use its::cam::{self, Cam, LowFrequency};
use its::geodesy::Position;
use its::geonetworking::{HEADER_BYTES, Headers, Source, StationType};
use its::mapem::{Approach, Connection, IntersectionGeometry, LEFT, Lane, Mapem, STRAIGHT};
use its::spatem::{IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing};
use its::time::{Stamp, TimeMark};
use its::{DecodeError, Frame, MAX_FRAME_BYTES, Message};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

fn source() -> Source {
    Source {
        station_type: StationType::RoadsideUnit,
        address: 0x0200_0000_0001,
        timestamp: 12_345,
        position: Position { latitude: 487_000_000, longitude: 91_000_000 },
        accurate: true,
        speed: 0,
        heading: 0,
    }
}

fn mark() -> impl Strategy<Value = TimeMark> {
    (0..=36_001u16).prop_map(|value| TimeMark::new(value).expect("in range"))
}

fn timing() -> impl Strategy<Value = Timing> {
    let marks = (option::of(mark()), mark(), option::of(mark()), option::of(mark()));
    (marks, option::of(0..=15u8), option::of(mark())).prop_map(
        |((start, min_end, max_end, likely_end), confidence, next)| Timing {
            start,
            min_end,
            max_end,
            likely_end,
            confidence,
            next,
        },
    )
}

fn movement() -> impl Strategy<Value = MovementState> {
    let state = (0..10usize).prop_map(|index| MovementPhase::ALL[index]);
    let event =
        (state, option::of(timing())).prop_map(|(state, timing)| MovementEvent { state, timing });
    (any::<u8>(), vec(event, 1..=8))
        .prop_map(|(signal_group, events)| MovementState { signal_group, events })
}

fn stamp() -> impl Strategy<Value = Stamp> {
    (0..527_040u32, 0..=60_999u16)
        .prop_map(|(minute_of_year, millisecond)| Stamp { minute_of_year, millisecond })
}

fn spatem() -> impl Strategy<Value = Message> {
    let head = (option::of(any::<u16>()), any::<u16>(), 0..128u8, any::<u16>());
    let intersection = (head, option::of(stamp()), vec(movement(), 1..=4)).prop_map(
        |((region, id, revision, status), stamp, movements)| IntersectionState {
            region,
            id,
            revision,
            status,
            stamp,
            movements,
        },
    );
    (any::<u32>(), vec(intersection, 1..=3)).prop_map(|(station_id, intersections)| {
        Message::Spatem(Spatem { station_id, intersections })
    })
}

fn lane() -> impl Strategy<Value = Lane> {
    let approach = (any::<bool>(), 0..16u8).prop_map(|(ingress, number)| {
        if ingress { Approach::Ingress(number) } else { Approach::Egress(number) }
    });
    let connection = (any::<u8>(), option::of(0..1u16 << 12), option::of(any::<u8>()))
        .prop_map(|(lane, maneuver, signal_group)| Connection { lane, maneuver, signal_group });
    // All six sizes of offsets.
    let offset = || (0..6u32, any::<i16>()).prop_map(|(shift, value)| value >> (shift * 2));
    (any::<u8>(), approach, 0..1u16 << 12, vec((offset(), offset()), 2..=6), vec(connection, 0..=3))
        .prop_map(|(id, approach, maneuvers, nodes, connections)| Lane {
            id,
            approach,
            maneuvers,
            nodes,
            connections,
        })
}

fn mapem() -> impl Strategy<Value = Message> {
    let position = (-900_000_000..=900_000_001i32, -1_800_000_000..=1_800_000_001i32)
        .prop_map(|(latitude, longitude)| Position { latitude, longitude });
    let head = (option::of(any::<u16>()), any::<u16>(), 0..128u8, position);
    let intersection = (head, option::of(0..=32_767u16), vec(lane(), 1..=6)).prop_map(
        |((region, id, revision, reference), lane_width_cm, lanes)| IntersectionGeometry {
            region,
            id,
            revision,
            reference,
            lane_width_cm,
            lanes,
            unread_lanes: 0,
        },
    );
    (any::<u32>(), 0..128u8, vec(intersection, 1..=3)).prop_map(
        |(station_id, revision, intersections)| {
            Message::Mapem(Mapem { station_id, revision, intersections })
        },
    )
}

fn cam() -> impl Strategy<Value = Message> {
    let motion =
        (0..=3601u16, 0..=16_383u16, -160..=161i16, -32_766..=32_767i16, 1..=1023u16, 1..=62u8)
            .prop_map(|(heading, speed, acceleration, yaw_rate, length, width)| cam::Motion {
                heading,
                speed,
                acceleration,
                yaw_rate,
                length,
                width,
            });
    let slow = (0..16u8, any::<u8>()).prop_map(|(role, lights)| LowFrequency { role, lights });
    let place = (-900_000_000..=900_000_001i32, -1_800_000_000..=1_800_000_001i32);
    (any::<u32>(), any::<u16>(), any::<u8>(), place, motion, option::of(slow)).prop_map(
        |(station_id, generation_delta, station_type, place, motion, low_frequency)| {
            Message::Cam(Cam {
                station_id,
                generation_delta,
                station_type,
                position: Position { latitude: place.0, longitude: place.1 },
                motion,
                low_frequency,
            })
        },
    )
}

fn message() -> impl Strategy<Value = Message> {
    prop_oneof![spatem(), mapem(), cam()]
}

proptest! {
    #[test]
    fn every_message_comes_back(message in message()) {
        let frame = Frame { source: source(), message };
        match frame.encode() {
            Ok(bytes) => {
                prop_assert!(bytes.len() <= MAX_FRAME_BYTES);
                prop_assert_eq!(Frame::decode(&bytes), Ok(frame));
            }
            Err(error) => prop_assert!(matches!(error, its::EncodeError::TooLong(_)), "{}", error),
        }
    }

    #[test]
    fn flipped_and_cut_frames_are_read_or_refused(
        message in message(), flips in vec((any::<prop::sample::Index>(), 0..8u8), 0..20),
        keep in any::<prop::sample::Index>(),
    ) {
        let Ok(mut bytes) = (Frame { source: source(), message }).encode() else { return Ok(()) };
        for (index, bit) in flips {
            let index = index.index(bytes.len());
            bytes[index] ^= 1 << bit;
        }
        let _ = Frame::decode(&bytes);
        bytes.truncate(keep.index(bytes.len()));
        prop_assert!(Frame::decode(&bytes).is_err());
    }

    #[test]
    fn any_payload_behind_right_headers_is_read_or_refused(
        message in message(), payload in vec(any::<u8>(), 0..400),
    ) {
        let Ok(mut bytes) = (Frame { source: source(), message }).encode() else { return Ok(()) };
        // Version, message id and other bytes after the headers.
        bytes.truncate(HEADER_BYTES + 2);
        bytes.extend(&payload);
        let length = (bytes.len() - 40) as u16;
        bytes[8..10].copy_from_slice(&length.to_be_bytes());
        if let Ok(frame) = Frame::decode(&bytes) {
            // The decoded message is small: the bytes bound its size.
            let entries = match &frame.message {
                Message::Spatem(spatem) => spatem.intersections.iter()
                    .flat_map(|i| &i.movements).map(|m| m.events.len()).sum(),
                Message::Mapem(mapem) => mapem.intersections.iter()
                    .flat_map(|i| &i.lanes).map(|l| l.nodes.len()).sum(),
                Message::Cam(_) => 0,
            };
            prop_assert!(entries <= 8 * bytes.len());
        }
    }

    #[test]
    fn arbitrary_bytes_are_read_or_refused(bytes in vec(any::<u8>(), 0..1600)) {
        let _ = Frame::decode(&bytes);
    }
}

fn small_spatem(group: u8) -> Spatem {
    let timing = Timing {
        start: None,
        min_end: TimeMark::new(100).expect("in range"),
        max_end: None,
        likely_end: None,
        confidence: Some(15),
        next: None,
    };
    let events = vec![MovementEvent {
        state: MovementPhase::ProtectedMovementAllowed,
        timing: Some(timing),
    }];
    Spatem {
        station_id: 7,
        intersections: vec![IntersectionState {
            region: None,
            id: 1,
            revision: 0,
            status: 0,
            stamp: None,
            movements: vec![MovementState { signal_group: group, events }],
        }],
    }
}

#[test]
fn a_frame_that_is_too_long_or_out_of_range_has_no_bytes() {
    let mut spatem = small_spatem(1);
    let movement = spatem.intersections[0].movements.remove(0);
    let events = movement.events.repeat(16);
    spatem.intersections[0].movements = (0..100)
        .map(|signal_group| MovementState { signal_group, events: events.clone() })
        .collect();
    let error = Frame { source: source(), message: Message::Spatem(spatem) }.encode();
    assert!(matches!(error, Err(its::EncodeError::TooLong(_))), "{error:?}");
    let mut spatem = small_spatem(1);
    spatem.intersections[0].revision = 200;
    let error = Frame { source: source(), message: Message::Spatem(spatem) }.encode();
    assert!(matches!(error, Err(its::EncodeError::Range(_))), "{error:?}");
    let lane = Lane {
        id: 1,
        approach: Approach::Ingress(1),
        maneuvers: STRAIGHT | LEFT,
        nodes: vec![(0, 0)],
        connections: Vec::new(),
    };
    let intersection = IntersectionGeometry {
        region: None,
        id: 1,
        revision: 0,
        reference: Position::default(),
        lane_width_cm: None,
        lanes: vec![lane],
        unread_lanes: 0,
    };
    let mapem = Mapem { station_id: 1, revision: 0, intersections: vec![intersection] };
    let error = Frame { source: source(), message: Message::Mapem(mapem) }.encode();
    assert!(matches!(error, Err(its::EncodeError::Range(_))), "one node is not a lane: {error:?}");
}

#[test]
fn another_profile_is_named_and_not_read() {
    let message = Message::Spatem(small_spatem(1));
    let bytes = Frame { source: source(), message }.encode().expect("a small frame");
    let changed = |at: usize, value: u8| {
        let mut bytes = bytes.clone();
        bytes[at] = value;
        Frame::decode(&bytes).expect_err("it is another")
    };
    assert_eq!(changed(HEADER_BYTES + 1, 0x13), DecodeError::MessageId { port: 2004, found: 0x13 });
    let version = DecodeError::ProtocolVersion { message_id: 4, found: 3 };
    assert_eq!(changed(HEADER_BYTES, 3), version);
    // BTP port 2002 is DENM's.
    assert_eq!(changed(41, 0xd2), DecodeError::Port(2002));
    assert_eq!(changed(0, 0x12), DecodeError::Secured);
    assert_eq!(changed(0, 0x21), DecodeError::Version(2));
    let other = DecodeError::OtherHeader { header_type: 0x20, next_header: 2 };
    assert_eq!(changed(5, 0x20), other, "a beacon");
}

/// A message of pycrate (`foreign.py`).
fn foreign(name: &str) -> Vec<u8> {
    let mut lines = include_str!("foreign.txt").lines().filter_map(|line| line.split_once(' '));
    let (_, hex) = lines.find(|(found, _)| *found == name).expect("it is there");
    unhex(hex)
}

fn unhex(text: &str) -> Vec<u8> {
    let byte = |at: usize| u8::from_str_radix(&text[at..at + 2], 16).expect("hexadecimal");
    (0..text.len()).step_by(2).map(byte).collect()
}

fn framed(port: u16, payload: &[u8]) -> Vec<u8> {
    let mut frame = Vec::new();
    Headers { source: source(), traffic_class: 3, port }.write(payload.len() as u16, &mut frame);
    frame.extend(payload);
    frame
}

#[test]
fn messages_of_north_america_are_of_another_profile_however_they_come() {
    for (name, port, message_id) in [("sae_spat", 2004, 0x13), ("sae_map", 2003, 0x12)] {
        let message = foreign(name);
        let version = DecodeError::ProtocolVersion { message_id, found: 0 };
        assert_eq!(Frame::decode(&framed(port, &message)), Err(version));
        // Frames without headers, and after those of WSMP (IEEE 1609.3): version 3, PSID 0x82, length.
        assert_eq!(Frame::decode(&message), Err(DecodeError::Version(0)));
        let wsmp = [&[0x03, 0x00, 0x80, 0x02, message.len() as u8], &message[..]].concat();
        assert_eq!(Frame::decode(&wsmp), Err(DecodeError::Version(0)));
    }
}

#[test]
fn a_message_of_another_kind_is_unknown_on_its_own_port_and_on_ours() {
    let srem = foreign("srem");
    assert_eq!(Frame::decode(&framed(2007, &srem)), Err(DecodeError::Port(2007)));
    let message_id = DecodeError::MessageId { port: 2004, found: 9 };
    assert_eq!(Frame::decode(&framed(2004, &srem)), Err(message_id));
}

#[test]
fn a_cam_of_others_is_read() {
    let frame = Frame::decode(&framed(2001, &foreign("cam_east"))).expect("a CAM");
    let Message::Cam(cam) = frame.message else { panic!("{frame:?}") };
    assert_eq!(
        (cam.station_id, cam.position.longitude, cam.motion.speed),
        (4711, 91_010_000, 1000)
    );
}

#[test]
fn additions_of_a_later_version_are_passed_over() {
    let frame = framed(2004, &foreign("spatem_later"));
    let Ok(Message::Spatem(spatem)) = Frame::decode(&frame).map(|frame| frame.message) else {
        panic!("a SPATEM")
    };
    let movements = &spatem.intersections[0].movements;
    let ends = |movement: &MovementState| {
        let end = |event: &MovementEvent| event.timing.map(|timing| timing.min_end.value());
        movement.events.iter().map(|event| (event.state, end(event))).collect::<Vec<_>>()
    };
    let expected = [
        (MovementPhase::StopAndRemain, Some(100)),
        (MovementPhase::ProtectedMovementAllowed, Some(200)),
    ];
    for (movement, group) in movements.iter().zip([9, 10]) {
        assert_eq!((movement.signal_group, ends(movement)), (group, expected.to_vec()));
    }
    assert_eq!(movements.len(), 2);
}

/// Messages with all parts of the standards, and falsified ones. `vectors.txt` has the results of a decoder
/// that is generated from the standards' ASN.1 (`cargo test -p its --features oracle`).
#[test]
fn messages_of_all_parts_are_read_as_a_generated_decoder_reads_them() {
    let (mut read, mut refused) = (0, 0);
    for line in include_str!("vectors.txt").lines() {
        let [port, payload, expected] =
            line.splitn(3, ' ').collect::<Vec<_>>().try_into().expect("port, bytes, message");
        let frame = framed(port.parse().expect("a port"), &unhex(payload));
        let message = Frame::decode(&frame).map(|frame| frame.message).ok();
        assert_eq!(format!("{message:?}"), expected, "{payload}");
        if message.is_some() { read += 1 } else { refused += 1 }
    }
    assert!(read > 30 && refused > 10, "{read} {refused}");
}
