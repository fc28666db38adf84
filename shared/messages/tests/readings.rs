//! Readings of a receiver from a message: motion between two samples, lists with a count, numbers of states.

use bytemuck::Zeroable;
use messages::level::{Level, LevelLog};
use messages::*;
use proptest::prelude::*;

/// Position and speed after `age_s`, by small steps of a body that stops and does not reverse.
fn stepped(mut position_m: f64, mut v: f64, a: f64, age_s: f64) -> (f64, f64) {
    const STEPS: u32 = 10_000;
    let dt = age_s / f64::from(STEPS);
    for _ in 0..STEPS {
        let next = if a < 0.0 { (v + a * dt).max(0.0) } else { v + a * dt };
        position_m += 0.5 * (v + next) * dt;
        v = next;
    }
    (position_m, v)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn an_ego_moves_on_with_its_acceleration_until_it_stands(
        position_m in -500.0..500.0f64, v in 0.0..40.0f64, a in -8.0..3.0f64, age_s in -0.5..6.0f64,
    ) {
        let mut odometry = Odometry { position_m, speed_mps: v, acceleration_mps2: a, ..Odometry::zeroed() };
        let mut truth = EgoTruth { position_m, speed_mps: v, acceleration_mps2: a, ..EgoTruth::zeroed() };
        odometry.header.acquisition_ns = 2_500_000_000;
        truth.header.acquisition_ns = 2_500_000_000;
        // A sample from the future is taken as it is.
        let expected = stepped(position_m, v, a, age_s.max(0.0));
        for (moved_m, speed_mps) in [odometry.moved_to(2.5 + age_s), truth.moved_to(2.5 + age_s)] {
            prop_assert!((moved_m - expected.0).abs() < 1e-2, "{} m, expected {}", moved_m, expected.0);
            prop_assert!((speed_mps - expected.1).abs() < 1e-2, "{} m/s", speed_mps);
        }
    }
}

#[test]
fn only_the_line_of_a_red_signal_is_a_red_line() {
    let mut truth = EgoTruth { stop_line_m: 5.0, ..EgoTruth::zeroed() };
    for state in PhaseState::ALL {
        truth.signal_state = state.to_wire();
        let is_red = state == PhaseState::StopAndRemain;
        assert_eq!(truth.red_line_m(), if is_red { 5.0 } else { f64::INFINITY }, "{state:?}");
    }
}

/// Lengths that a list of `capacity` elements has for counts at the boundaries.
fn lengths(capacity: usize, mut of: impl FnMut(u64) -> usize) -> Vec<usize> {
    [0, 1, capacity as u64 - 1, capacity as u64, capacity as u64 + 1, u64::MAX]
        .map(&mut of)
        .to_vec()
}

/// Lengths that they must have: never more than there is room for.
fn bounded(capacity: usize) -> Vec<usize> {
    vec![0, 1, capacity - 1, capacity, capacity, capacity]
}

#[test]
fn a_list_has_as_many_elements_as_are_counted_and_never_more_than_fit() {
    let mut tracks = RadarTracks::zeroed();
    let mut scan = RadarDetections::zeroed();
    let mut poses = VehiclePoses::zeroed();
    let mut frames = RadioFrames::zeroed();
    let of_tracks = lengths(MAX_TRACKS, |count| {
        tracks.count = count;
        tracks.tracks().len()
    });
    let of_scan = lengths(MAX_DETECTIONS, |count| {
        scan.count = count;
        scan.detections().len()
    });
    let of_poses = lengths(MAX_TRACKS, |count| {
        poses.count = count;
        poses.poses().len()
    });
    let of_frames = lengths(MAX_FRAMES, |count| {
        frames.count = count;
        frames.frames().len()
    });
    assert_eq!((of_tracks, of_scan), (bounded(MAX_TRACKS), bounded(MAX_DETECTIONS)));
    assert_eq!((of_poses, of_frames), (bounded(MAX_TRACKS), bounded(MAX_FRAMES)));
    // They begin with the first element.
    (tracks.count, tracks.tracks[0].id) = (1, 77);
    (scan.count, scan.detections[0].range_m) = (1, 7.5);
    (poses.count, poses.poses[0].x_m) = (1, 8.5);
    (frames.count, frames.frames[0].sent_ns) = (1, 9);
    assert_eq!((tracks.tracks()[0].id, scan.detections()[0].range_m), (77, 7.5));
    assert_eq!((poses.poses()[0].x_m, frames.frames()[0].sent_ns), (8.5, 9));
}

#[test]
fn a_radar_sees_all_half_or_nothing_from_its_share_on() {
    let sights = [1.0, 0.7, 0.699, 0.33, 0.329, 0.0, f64::NAN];
    use Sight::{Blind, Full, Limited};
    assert_eq!(sights.map(Sight::of_share), [Full, Full, Limited, Limited, Blind, Blind, Blind]);
    let mut tracks = RadarTracks { seen_share: 0.5, ego_speed_mps: 12.0, ..RadarTracks::zeroed() };
    assert_eq!((tracks.sight(), tracks.measured_ego_speed_mps()), (Limited, None));
    tracks.ego_speed_points = 1;
    assert_eq!(tracks.measured_ego_speed_mps(), Some(12.0));
}

#[test]
fn the_nearest_vehicle_in_lane_is_the_one_ahead() {
    let mut truth = VehicleTruth::zeroed();
    let vehicle = |in_lane: u64, rear_position_m: f64, speed_mps: f64| VehicleTruthItem {
        in_lane,
        rear_position_m,
        speed_mps,
        ..VehicleTruthItem::zeroed()
    };
    truth.vehicles[..5].copy_from_slice(&[
        vehicle(1, 140.0, 1.0),
        vehicle(1, 130.0, 2.0),
        vehicle(0, 105.0, 3.0),
        vehicle(1, 95.0, 4.0),
        vehicle(1, 101.0, 5.0),
    ]);
    truth.count = 4;
    assert_eq!(
        AllVehicles::of(&truth).nearest_ahead(100.0),
        Some((30.0, 2.0)),
        "one beside and one behind do not count"
    );
    assert_eq!(
        AllVehicles::of(&truth).nearest_ahead(99.9).map(|found| found.1),
        Some(4.0),
        "5 m behind the front it counts"
    );
    truth.count = 5;
    assert_eq!(AllVehicles::of(&truth).nearest_ahead(100.0), Some((1.0, 5.0)));
    truth.count = 0;
    assert_eq!(AllVehicles::of(&truth).nearest_ahead(100.0), None);
    truth.count = u64::MAX;
    assert_eq!(AllVehicles::of(&truth).nearest_ahead(100.0), Some((1.0, 5.0)), "no more than fit");
}

#[test]
fn a_frame_is_read_as_it_was_written() {
    let mut frame = RadioFrame::zeroed();
    frame.write(100, 350, &[9; 40]);
    assert_eq!((frame.data(), frame.on_the_way_ns()), (&[9; 40][..], Some(250)));
    // A shorter one leaves nothing of the longer one, a too long one is cut.
    frame.write(RadioFrame::UNKNOWN_NS, 350, &[1, 2]);
    assert_eq!((frame.data(), frame.on_the_way_ns()), (&[1, 2][..], None));
    assert!(frame.bytes[2..].iter().all(|byte| *byte == 0));
    frame.write(0, 0, &[3; MAX_FRAME_BYTES + 1]);
    assert_eq!(frame.data(), [3; MAX_FRAME_BYTES]);
    frame.length = u32::MAX;
    assert_eq!(frame.data().len(), MAX_FRAME_BYTES);
}

#[test]
fn an_origin_means_the_sample_of_its_step_and_unless_it_rides_its_instant() {
    let sample = Origin { sequence: 3, acquisition_ns: 20, publish_ns: 30 };
    assert!(sample.means(&sample, false) && sample.means(&sample, true));
    let others = [
        (Origin { sequence: 4, ..sample }, false),
        (Origin { acquisition_ns: 21, ..sample }, false),
        (Origin { publish_ns: 31, ..sample }, true),
    ];
    for (other, with_ride) in others {
        assert!(!sample.means(&other, false), "{other:?}");
        assert_eq!(sample.means(&other, true), with_ride, "{other:?}");
    }
    assert!(sample.is_some() && !Origin::NONE.is_some());
    let header = Header { sequence: 3, acquisition_ns: 20, publish_ns: 30, ..Header::zeroed() };
    assert_eq!(Origin::of(&header), sample);
    let header = Header::new(5, 20, Origins::NONE);
    assert_eq!((header.step, header.acquisition_ns, header.sequence), (5, 20, 0));
    assert_eq!(header.origins, Origins::NONE);
}

#[test]
fn unknown_numbers_are_the_cautious_state() {
    assert_eq!(BrakeState::from_wire(2), BrakeState::Braking);
    assert_eq!(BrakeState::from_wire(99), BrakeState::Blind);
    assert_eq!(PhaseState::from_wire(6), PhaseState::ProtectedMovementAllowed);
    assert_eq!(PhaseState::from_wire(99), PhaseState::Unavailable);
    assert!(PhaseState::ALL.iter().all(|state| PhaseState::from_wire(state.to_wire()) == *state));
}

#[test]
fn topics_are_found_by_name_and_have_one_sender_in_each_group() {
    for topic in TOPICS {
        assert_eq!(Topic::by_name(topic.name()), Some(topic));
        assert_eq!(
            topic.role() == Role::Truth,
            topic.name().starts_with("truth/"),
            "{}",
            topic.name()
        );
        assert_eq!(topic.message_bytes(), topic.layout().bytes);
        // One rides with another one of the same sender.
        if let Some(other) = topic.rides_with() {
            assert!(topic.sources().iter().all(|sender| other.sources().contains(sender)));
        }
    }
    assert_eq!(Topic::by_name("vehicle/odometer"), None);
    assert_eq!(Topic::Course.rides_with(), Some(Topic::RadarTracks));
    assert_eq!(Topic::Odometry.rides_with(), None);
    let (all, without_unit) = (Service::ALL, [Service::Plant, Service::V2xSim]);
    assert_eq!(Topic::Spat.source(&all), Some(Service::Obu));
    assert_eq!(Topic::Spat.source(&without_unit), Some(Service::V2xSim));
    assert_eq!(Topic::Heartbeat.source(&all), None);
    assert_eq!(Topic::Odometry.shows(), None);
    assert_eq!(Topic::Command.shows(), Some(Service::Controller));
    assert_eq!(Topic::Brake.shows(), Some(Service::Aebs));
}

#[test]
fn services_and_values_are_written_as_results_show_them() {
    assert_eq!(format!("{:>12}|", Service::Aebs), "        aebs|");
    let error = "radar".parse::<Service>().expect_err("no service").to_string();
    assert!(error.contains("unknown service `radar`") && error.contains("plant, perception-sim"));
    let written = [
        Value::Bytes(&[0x0a, 0xff]).to_string(),
        Value::Unsigned(7).to_string(),
        Value::Signed(-7).to_string(),
        Value::Float(0.5).to_string(),
    ];
    assert_eq!(written, ["0x0aff", "7", "-7", "0.5"]);
}

#[test]
fn a_log_of_levels_begins_late_and_keeps_its_first_changes() {
    let mut log = LevelLog::default();
    log.begin(10.0, Level::LeadLost);
    assert_eq!(log.now, Level::LeadLost);
    log.observe(10.5, Level::LeadLost);
    assert_eq!((log.report().time_s.len(), log.report().time_s["lead-lost"]), (1, 0.5));
    assert!(log.report().changes.is_empty(), "a level that stays is not a change");
    // A stamp that goes back adds no time.
    log.observe(10.0, Level::Full);
    assert_eq!((log.report().time_s["lead-lost"], log.now), (0.5, Level::Full));
    // Up to 1,024 changes are kept, the time of all counts.
    for change in 0..2000 {
        let level = [Level::SignalsLost, Level::Full][change % 2];
        log.observe(10.0 + 0.5 * (change + 1) as f64, level);
    }
    let report = log.report();
    assert_eq!(report.changes.len(), 1024);
    assert_eq!((report.time_s["full"], report.time_s["signals-lost"]), (500.0, 500.0));
    assert_eq!(log.now, Level::Full);
}

#[test]
fn each_scalar_is_read_with_its_type() {
    let mut frames = RadioFrames::zeroed();
    frames.frames[1].write(-5, 6, &[0xab]);
    frames.frames[0].length = 0x0102_0304;
    let bytes = bytemuck::bytes_of(&frames);
    let places = Topic::RadioFrames.layout().scalars();
    let place = |path: &str| places.iter().find(|place| place.path == path).expect("a field");
    assert_eq!(place("frames.1.sent_ns").read(bytes), Value::Signed(-5));
    assert_eq!(place("frames.0.length").read(bytes), Value::Unsigned(0x0102_0304));
    let Value::Bytes(data) = place("frames.1.bytes").read(bytes) else {
        panic!("bytes are one value")
    };
    assert_eq!((data.len(), data[0], data[1]), (MAX_FRAME_BYTES, 0xab, 0));
    let place = place("frames.1.received_ns");
    assert_eq!((place.layout, place.field, place.bytes), ("RadioFrame", "received_ns", 8));
}

#[test]
fn elements_are_named_as_in_rust_and_structs_by_their_own_name() {
    for (scalar, name, bytes) in [
        (Scalar::U8, "u8", 1),
        (Scalar::U32, "u32", 4),
        (Scalar::U64, "u64", 8),
        (Scalar::I64, "i64", 8),
        (Scalar::F64, "f64", 8),
    ] {
        let element = Element::Scalar(scalar);
        assert_eq!((element.name(), element.bytes()), (name, bytes));
    }
    let header = Topic::Heartbeat.layout().fields[0].shape.element;
    assert_eq!((header.name(), header.bytes()), ("Header", size_of::<Header>()));
}
