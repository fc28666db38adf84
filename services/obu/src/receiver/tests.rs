use super::*;
use crate::lanes::road_plane;
use bytemuck::Zeroable;
use its::Frame;
use its::geonetworking::{HEADER_BYTES, Source, StationType};
use its::mapem::{Approach, Connection, IntersectionGeometry, LEFT, Mapem, STRAIGHT};
use its::spatem::{
    IntersectionState, MovementEvent, MovementPhase, MovementState, Spatem, Timing as Details,
};
use its::time::{Stamp, TimeMark, its_timestamp};
use messages::PhaseState;
use scenario::radio::Origin;

const OWN: u32 = 4711;
const UNIT: u32 = 100_001;
const START_NS: i64 = 1_780_315_200_000_000_000;

fn plane() -> Plane {
    road_plane(&Origin::default())
}

fn at(ms: i64) -> Moment {
    Moment { now_ns: ms * 1_000_000, utc_start_ns: START_NS, ahead_ns: 0 }
}

fn frame(message: Message, ms: i64) -> Vec<u8> {
    let source = Source {
        station_type: StationType::RoadsideUnit,
        address: 1,
        timestamp: its_timestamp(at(ms).utc_ms()) as u32,
        position: plane().position(0.0, 0.0),
        accurate: true,
        speed: 0,
        heading: 0,
    };
    Frame { source, message }.encode().expect("in range")
}

/// Green until `end_ms`, then yellow for three seconds and red up to a minute.
fn spatem(station_id: u32, ms: i64, end_ms: i64) -> Spatem {
    let event = |state, end_ms: i64| {
        let mark = TimeMark::of(at(end_ms).utc_ms(), at(ms).utc_ms());
        let timing = Details {
            start: None,
            min_end: mark,
            max_end: Some(mark),
            likely_end: Some(mark),
            confidence: Some(15),
            next: None,
        };
        MovementEvent { state, timing: Some(timing) }
    };
    let events = vec![
        event(MovementPhase::ProtectedMovementAllowed, end_ms),
        event(MovementPhase::ProtectedClearance, end_ms + 3_000),
        event(MovementPhase::StopAndRemain, end_ms + 60_000),
    ];
    let state = IntersectionState {
        region: None,
        id: 1,
        revision: 0,
        status: 0,
        stamp: Some(Stamp::of(at(ms).utc_ms())),
        movements: vec![MovementState { signal_group: 7, events }],
    };
    Spatem { station_id, intersections: vec![state] }
}

fn spat(ms: i64, end_ms: i64) -> Vec<u8> {
    frame(Message::Spatem(spatem(UNIT, ms, end_ms)), ms)
}

/// The vehicle's lane, a lane that turns left, and a lane of the other direction.
fn geometry(stop_line_m: f64) -> IntersectionGeometry {
    let lane = |id, (x, y), along, maneuver, signal_group| its::mapem::Lane {
        id,
        approach: Approach::Ingress(1),
        maneuvers: maneuver,
        nodes: vec![(x, y), (along, 0)],
        connections: vec![Connection {
            lane: 9,
            maneuver: Some(maneuver),
            signal_group: Some(signal_group),
        }],
    };
    IntersectionGeometry {
        region: None,
        id: 1,
        revision: 0,
        reference: plane().position(stop_line_m + 10.0, 0.0),
        lane_width_cm: Some(350),
        lanes: vec![
            lane(1, (-1000, 350), -9000, LEFT, 8),
            lane(2, (-1000, 0), -9000, STRAIGHT, 7),
            lane(3, (1000, 0), 9000, STRAIGHT, 6),
        ],
        unread_lanes: 0,
    }
}

fn map_of(station_id: u32, ms: i64, geometry: IntersectionGeometry) -> Vec<u8> {
    let mapem = Mapem { station_id, revision: 0, intersections: vec![geometry] };
    frame(Message::Mapem(mapem), ms)
}

fn map(ms: i64) -> Vec<u8> {
    map_of(UNIT, ms, geometry(300.0))
}

/// A unit that received a map and a SPATEM: green until 20 s.
fn informed() -> Receiver {
    let mut receiver = Receiver::new(OWN, 500, plane());
    assert_eq!(receiver.take(&map(0), &at(0)), Verdict::Accepted);
    assert_eq!(receiver.take(&spat(0, 20_000), &at(0)), Verdict::Accepted);
    receiver
}

/// Stop lines, the end of the present phase, and the instant of the timing, ms.
fn told(receiver: &Receiver, ms: i64) -> (Vec<f64>, Option<f64>, Option<i64>) {
    let (mut map, mut spat) = (Map::zeroed(), Spat::zeroed());
    let made_ns = receiver.write(ms * 1_000_000, 0.0, &mut map, &mut spat);
    let lines = map.lanes[..map.count as usize].iter().map(|lane| lane.stop_line_m.round());
    let end_s = (spat.count > 0).then(|| spat.signals[0].intervals[0].likely_end_s);
    (lines.collect(), end_s, made_ns.map(|ns| ns / 1_000_000))
}

#[test]
fn the_lane_of_the_vehicle_and_its_signal_are_handed_on() {
    let receiver = informed();
    assert_eq!(told(&receiver, 100), (vec![300.0], Some(20.0), Some(0)));
    let (mut map, mut spat) = (Map::zeroed(), Spat::zeroed());
    receiver.write(0, 0.0, &mut map, &mut spat);
    assert_eq!((map.lanes[0].intersection_id, map.lanes[0].signal_group), (1, 7));
    assert_eq!(spat.signals[0].count, 3);
    assert_eq!(spat.signals[0].intervals[2].state, PhaseState::StopAndRemain.to_wire());
    // Passed lines are not handed on.
    let (mut map, mut spat) = (Map::zeroed(), Spat::zeroed());
    assert_eq!(receiver.write(0, 346.0, &mut map, &mut spat), None);
    assert_eq!((map.count, spat.count), (0, 0));
}

#[test]
fn a_lost_unit_makes_its_timing_old_and_does_not_take_it_away() {
    let receiver = informed();
    assert_eq!(told(&receiver, 5_000), (vec![300.0], Some(20.0), Some(0)));
}

#[test]
fn timing_without_a_map_waits_for_it() {
    let mut receiver = Receiver::new(OWN, 500, plane());
    assert_eq!(receiver.take(&spat(0, 20_000), &at(0)), Verdict::UnknownIntersection);
    assert_eq!(told(&receiver, 0).0, Vec::<f64>::new());
    assert_eq!(receiver.take(&map(100), &at(100)), Verdict::Accepted);
    assert_eq!(told(&receiver, 100), (vec![300.0], Some(20.0), Some(0)));
}

#[test]
fn one_frame_makes_no_intersection() {
    let mut receiver = Receiver::new(OWN, 500, plane());
    receiver.take(&map(0), &at(0));
    assert_eq!(told(&receiver, 0).0, Vec::<f64>::new());
}

#[test]
fn repeated_old_early_and_overtaken_frames_are_not_used() {
    let mut receiver = informed();
    let second = spat(200, 20_000);
    assert_eq!(receiver.take(&second, &at(200)), Verdict::Accepted);
    assert_eq!(receiver.take(&second, &at(300)), Verdict::Duplicated);
    assert_eq!(receiver.take(&spat(100, 20_000), &at(300)), Verdict::OutOfOrder);
    assert_eq!(receiver.take(&spat(300, 20_000), &at(900)), Verdict::TooOld);
    assert_eq!(receiver.take(&spat(1_501, 20_000), &at(1_000)), Verdict::TooOld, "of the future");
    assert_eq!(told(&receiver, 900).2, Some(200));
}

#[test]
fn a_clock_that_is_off_moves_the_ends_and_too_far_refuses_all() {
    let mut receiver = Receiver::new(OWN, 500, plane());
    let off = |ms: i64, ns| Moment { utc_start_ns: START_NS + ns, ..at(ms) };
    receiver.take(&map(0), &off(0, 400_000_000));
    receiver.take(&spat(0, 20_000), &off(0, 400_000_000));
    assert_eq!(told(&receiver, 0).1, Some(19.6));
    assert_eq!(receiver.take(&spat(100, 20_000), &off(100, 600_000_000)), Verdict::TooOld);
    // A known offset does no harm.
    let known = |ms| Moment { ahead_ns: -600_000_000, ..off(ms, 600_000_000) };
    let mut receiver = Receiver::new(OWN, 500, plane());
    receiver.take(&map(0), &known(0));
    assert_eq!(receiver.take(&spat(0, 20_000), &known(0)), Verdict::Accepted);
    assert_eq!(told(&receiver, 0).1, Some(20.0));
}

#[test]
fn a_change_must_be_repeated() {
    let mut receiver = informed();
    assert_eq!(receiver.take(&spat(100, 25_000), &at(100)), Verdict::Contradicting);
    assert_eq!(told(&receiver, 100), (vec![300.0], Some(20.0), Some(100)), "green, as before");
    assert_eq!(receiver.take(&spat(200, 20_000), &at(200)), Verdict::Accepted);
    assert_eq!(receiver.take(&spat(300, 25_000), &at(300)), Verdict::Contradicting);
    // Its end may change again: the shown phase counts.
    assert_eq!(receiver.take(&spat(400, 27_000), &at(400)), Verdict::Accepted);
    assert_eq!(told(&receiver, 400).1, Some(27.0));
    let red = |ms| {
        let mut spatem = spatem(UNIT, ms, ms - 5_000);
        spatem.intersections[0].movements[0].events.drain(..2);
        frame(Message::Spatem(spatem), ms)
    };
    assert_eq!(receiver.take(&red(9_000), &at(9_000)), Verdict::Contradicting);
    assert_eq!(told(&receiver, 9_000), (vec![300.0], Some(27.0), Some(400)), "it may be false");
    assert_eq!(receiver.take(&red(9_100), &at(9_100)), Verdict::Accepted);
}

#[test]
fn two_units_that_disagree_make_the_signal_unknown() {
    let mut receiver = informed();
    let other = |ms, end_ms| frame(Message::Spatem(spatem(200_001, ms, end_ms)), ms);
    assert_eq!(receiver.take(&other(100, 30_000), &at(100)), Verdict::Contradicting);
    assert_eq!(receiver.take(&spat(200, 20_000), &at(200)), Verdict::Contradicting);
    assert_eq!(told(&receiver, 200), (vec![300.0], None, Some(0)));
    // A single message stands for two seconds.
    for ms in (300..=2_000).step_by(100) {
        assert_eq!(receiver.take(&spat(ms, 20_000), &at(ms)), Verdict::Contradicting);
    }
    assert_eq!(receiver.take(&spat(2_200, 20_000), &at(2_200)), Verdict::Accepted);
    assert_eq!(told(&receiver, 2_200), (vec![300.0], Some(20.0), Some(2_200)));
    assert_eq!(
        receiver.take(&other(2_300, 20_000), &at(2_300)),
        Verdict::Contradicting,
        "said once"
    );
    assert_eq!(receiver.take(&other(2_400, 20_000), &at(2_400)), Verdict::Accepted, "they agree");
}

#[test]
fn a_unit_that_was_contradicted_twice_is_not_right_because_the_other_one_is_silent() {
    let mut receiver = informed();
    let other = |ms, end_ms| frame(Message::Spatem(spatem(200_001, ms, end_ms)), ms);
    // Green until 30 s and red until 90 s, where the first unit says 20 s and 80 s.
    assert_eq!(receiver.take(&spat(100, 20_000), &at(100)), Verdict::Accepted);
    for ms in [200, 300] {
        assert_eq!(receiver.take(&other(ms, 30_000), &at(ms)), Verdict::Contradicting);
    }
    for ms in (1_000..29_000).step_by(1_000) {
        assert_eq!(receiver.take(&other(ms, 30_000), &at(ms)), Verdict::Contradicting, "{ms}");
        assert_eq!(told(&receiver, ms), (vec![300.0], None, Some(100)));
    }
    // The first unit's announcements are over.
    for ms in [81_000, 81_100] {
        receiver.take(&other(ms, 120_000), &at(ms));
    }
    assert_eq!(told(&receiver, 81_100).1, Some(120.0));
}

#[test]
fn a_change_after_a_silence_must_be_repeated_as_well() {
    let mut receiver = informed();
    assert_eq!(receiver.take(&spat(6_000, 25_000), &at(6_000)), Verdict::Contradicting);
    assert_eq!(receiver.take(&spat(6_100, 25_000), &at(6_100)), Verdict::Accepted);
}

#[test]
fn a_map_that_is_too_old_for_timing_still_has_its_line() {
    let mut receiver = Receiver::new(OWN, 500, plane());
    assert_eq!(receiver.take(&map(0), &at(60_000)), Verdict::Accepted);
    assert_eq!(receiver.take(&spat(59_000, 90_000), &at(60_000)), Verdict::TooOld);
    // The signal exists, and its timing is unknown.
    assert_eq!(told(&receiver, 60_000), (vec![300.0], None, Some(0)));
    let moved = map_of(UNIT, 1_000, geometry(320.0));
    assert_eq!(receiver.take(&moved, &at(61_000)), Verdict::TooOld, "it has a map");
    let mut receiver = Receiver::new(OWN, 500, plane());
    assert_eq!(receiver.take(&map(0), &at(700_000)), Verdict::TooOld);
}

#[test]
fn an_intersection_without_a_map_has_a_line_before_its_unit() {
    let sent = |ms, message| {
        let mut frame = Frame::decode(&frame(message, ms)).expect("it is ours");
        frame.source.position = plane().position(310.0, 5.0);
        frame.encode().expect("in range")
    };
    let timing = |ms| sent(ms, Message::Spatem(spatem(UNIT, ms, 20_000)));
    let without_map = || {
        let mut receiver = Receiver::new(OWN, 500, plane());
        for ms in (0..=2_000).step_by(100) {
            assert_eq!(receiver.take(&timing(ms), &at(ms)), Verdict::UnknownIntersection);
            assert_eq!(told(&receiver, ms).0, Vec::<f64>::new(), "its map may be on the way");
        }
        receiver.take(&timing(2_100), &at(2_100));
        assert_eq!(told(&receiver, 2_100), (vec![280.0], None, Some(0)));
        receiver
    };
    // Its map comes: without a lane of the vehicle's twice, or with its line.
    let mut other = without_map();
    let mut bare = geometry(300.0);
    bare.lanes.remove(1);
    for ms in [2_200, 2_300] {
        assert_eq!(other.take(&map_of(UNIT, ms, bare.clone()), &at(ms)), Verdict::MissingLane);
    }
    other.take(&timing(2_400), &at(2_400));
    assert_eq!(told(&other, 2_400).0, Vec::<f64>::new());
    let mut receiver = without_map();
    receiver.take(&map(2_200), &at(2_200));
    assert_eq!(told(&receiver, 2_200), (vec![300.0], Some(20.0), Some(2_100)));
}

#[test]
fn a_map_changes_with_its_revision_or_when_it_is_repeated() {
    let mut receiver = informed();
    let moved = |ms| map_of(UNIT, ms, geometry(290.0));
    assert_eq!(receiver.take(&moved(1_000), &at(1_000)), Verdict::Contradicting);
    assert_eq!(told(&receiver, 1_000).0, [290.0], "of two lines the nearer one");
    assert_eq!(receiver.take(&moved(2_000), &at(2_000)), Verdict::Accepted);
    assert_eq!(told(&receiver, 2_000).0, [290.0]);
    // Timing of the next revision waits for its map, which it announces.
    let mut next = spatem(UNIT, 2_100, 20_000);
    next.intersections[0].revision = 1;
    let next = frame(Message::Spatem(next), 2_100);
    assert_eq!(receiver.take(&next, &at(2_100)), Verdict::Contradicting);
    let newer = IntersectionGeometry { revision: 1, ..geometry(280.0) };
    assert_eq!(receiver.take(&map_of(UNIT, 2_200, newer), &at(2_200)), Verdict::Accepted);
    assert_eq!(told(&receiver, 2_200).0, [280.0]);
    // Another station does not move the stop line.
    let other = map_of(200_001, 2_300, geometry(350.0));
    assert_eq!(receiver.take(&other, &at(2_300)), Verdict::Contradicting);
    assert_eq!(told(&receiver, 2_300).0, [280.0]);
}

#[test]
fn a_line_that_a_newer_map_puts_behind_a_waiting_vehicle_counts_until_it_is_passed() {
    let mut receiver = informed();
    let moved = |ms| map_of(UNIT, ms, geometry(290.0));
    receiver.take(&moved(1_000), &at(1_000));
    assert_eq!(receiver.take(&moved(2_000), &at(2_000)), Verdict::Accepted);
    let line_m = |ego_m| {
        let (mut map, mut spat) = (Map::zeroed(), Spat::zeroed());
        receiver.write(2_000_000_000, ego_m, &mut map, &mut spat);
        map.lanes[0].stop_line_m.round()
    };
    assert_eq!([line_m(289.0), line_m(298.0), line_m(301.0)], [290.0, 300.0, 290.0]);
}

#[test]
fn a_map_without_the_lane_and_timing_without_its_signal_are_counted() {
    let mut receiver = Receiver::new(OWN, 500, plane());
    let mut bare = geometry(300.0);
    bare.lanes.remove(1);
    assert_eq!(receiver.take(&map_of(UNIT, 0, bare), &at(0)), Verdict::MissingLane);
    assert_eq!(told(&receiver, 0).0, Vec::<f64>::new());
    receiver.take(&map(100), &at(100));
    let mut other = spatem(UNIT, 200, 20_000);
    other.intersections[0].movements[0].signal_group = 6;
    let other = frame(Message::Spatem(other), 200);
    assert_eq!(receiver.take(&other, &at(200)), Verdict::MissingLane);
    assert_eq!(told(&receiver, 200).1, None, "the signal is unknown");
}

#[test]
fn other_frames_are_counted_by_their_kind() {
    let mut receiver = Receiver::new(OWN, 500, plane());
    let good = spat(0, 20_000);
    let with = |at: usize, byte: u8| {
        let mut bytes = good.clone();
        bytes[at] = byte;
        bytes
    };
    let own = frame(Message::Spatem(spatem(OWN, 0, 20_000)), 0);
    let cases = [
        (own, Verdict::SameStationId),
        (with(0, 0x21), Verdict::OtherProfile),
        // A signed frame whose envelope cannot be read.
        (with(0, 0x12), Verdict::Malformed),
        (with(HEADER_BYTES, 3), Verdict::OtherProfile),
        (with(41, 0xd3), Verdict::UnknownMessage),
        (with(HEADER_BYTES + 1, 99), Verdict::UnknownMessage),
        (good[..60].to_vec(), Verdict::Malformed),
        (Vec::new(), Verdict::Malformed),
        (vec![0xff; 1501], Verdict::Malformed),
    ];
    for (bytes, verdict) in cases {
        assert_eq!(receiver.take(&bytes, &at(0)), verdict);
    }
    let counts = receiver.verdicts.by_name();
    assert_eq!((counts["other_profile"], counts["malformed"], counts["accepted"]), (2, 4, 0));
    assert_eq!(counts.values().sum::<u64>(), 9);
}

#[test]
fn a_wrong_bit_never_changes_the_accepted_timing() {
    let good = spat(100, 20_000);
    for bit in 0..8 * good.len() {
        let mut receiver = informed();
        let mut wrong = good.clone();
        wrong[bit / 8] ^= 0x80 >> (bit % 8);
        receiver.take(&wrong, &at(100));
        // Nothing, or an end within what a tenth of a second more or less makes.
        let end_s = told(&receiver, 100).1;
        assert!(end_s.is_none_or(|end_s| (end_s - 20.0).abs() < 0.4), "bit {bit}: {end_s:?}");
    }
}

/// A frame in the envelope of a station in use: a digest as signer, a time, a signature of any bytes.
fn sealed(frame: &[u8]) -> Vec<u8> {
    let payload = &frame[4..];
    let length = (payload.len() as u16).to_be_bytes();
    let basic = [0x12, frame[1], frame[2], frame[3]];
    let envelope = [3, 0x81, 0, 0x40, 3, 0x80, 0x82, length[0], length[1]];
    let header = [0x40, 1, 137, 0, 2, 0x86, 0, 0, 0, 0, 0];
    let signer = [0x80, 1, 2, 3, 4, 5, 6, 7, 8, 0x80, 0x80];
    [&basic[..], &envelope, payload, &header, &signer, &[7; 64]].concat()
}

#[test]
fn signed_frames_are_used_as_others_or_counted_alone() {
    let mut receiver = Receiver::new(OWN, 500, plane());
    assert_eq!(receiver.take(&sealed(&map(0)), &at(0)), Verdict::Accepted);
    assert_eq!(receiver.take(&sealed(&spat(0, 20_000)), &at(0)), Verdict::Accepted);
    let signers = &receiver.signers;
    assert_eq!(signers.frames, 2);
    assert_eq!(signers.not_verified["0102030405060708"].frames, 2);
    let mut deaf = Receiver { uses_signed: false, ..Receiver::new(OWN, 500, plane()) };
    assert_eq!(deaf.take(&sealed(&map(0)), &at(0)), Verdict::Signed);
    assert_eq!(deaf.take(&map(0), &at(0)), Verdict::Accepted);
    assert_eq!((deaf.verdicts.of(Verdict::Signed), deaf.signers.frames), (1, 1));
    let mut broken = sealed(&map(100));
    broken.truncate(60);
    assert_eq!(receiver.take(&broken, &at(100)), Verdict::Malformed);
}

#[test]
fn a_cam_from_a_curve_is_the_motion_at_its_place_until_the_next_one_is_missing() {
    let arc = road::Piece::Arc { length_m: 300.0, curvature_perm: 0.01 };
    let axis = road::Axis::narrow(&[arc], 1.0).expect("an axis");
    let mut unit = Receiver::new(OWN, 1000, plane());
    unit.path.axis = Some(axis);
    let text = scenario::builtin::find("corridor").expect("built in").text;
    let scenario = scenario::Scenario::parse("corridor", text).expect("right");
    let mut other = crate::awareness::Awareness::of(&scenario, 4712);
    other.path = unit.path.clone();
    let mut odometry = messages::Odometry::zeroed();
    (odometry.position_m, odometry.speed_mps, odometry.acceleration_mps2) = (150.0, 10.0, -3.0);
    let cam = other.due(&odometry, 1.0, &at(0)).expect("the first one");
    assert_eq!(unit.take(&cam, &at(50)), Verdict::Accepted);
    let [motion] = unit.motions[..] else { panic!("{:?}", unit.motions) };
    assert_eq!((motion.station_id, motion.made_ns), (4712, 0));
    assert_eq!((motion.speed_mps, motion.acceleration_mps2), (10.0, -3.0));
    let length_m = scenario.plant.length_m.value();
    assert!((motion.rear_position_m + length_m - 150.0).abs() < 0.1, "{motion:?}");
    assert!((motion.lateral_m - 1.0).abs() < 0.1, "{motion:?}");
    unit.forget(1_200_000_000, 0.0);
    assert_eq!(unit.motions.len(), 1);
    unit.forget(1_201_000_000, 0.0);
    assert!(unit.motions.is_empty());
}
