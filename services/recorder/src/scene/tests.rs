//! Scenes of a straight and of a curved road, byte for byte where their place in a message is known.

use super::*;
use bytemuck::Zeroable;
use messages::{Header, Origins, VehiclePose, VehicleTruthItem};

const CURVED: &str = "schema_version = 1\nname = \"x\"\nset_speed_mps = 10\n[road.plan]\n\
                      pieces = [{ arc_m = 100, radius_m = 100, turn = \"left\" }, { line_m = 500 }]\n";

/// The scene of a scenario with one vehicle, once the ego is at `pose`.
fn scene(text: &str, pose: Option<EgoPose>) -> Scene {
    let scenario = Scenario::parse("x.toml", text).expect("it is right");
    let mut scene = Scene::on(Some(&scenario), 0);
    let header = Header::new(0, 0, Origins::NONE);
    let mut truth = VehicleTruth { header, count: 1, ..VehicleTruth::zeroed() };
    truth.vehicles[0] =
        VehicleTruthItem { rear_position_m: 40.0, in_lane: 1, ..Zeroable::zeroed() };
    scene.take(Topic::VehicleTruth, 0, bytemuck::bytes_of(&truth));
    if let Some(pose) = pose {
        let mut poses = VehiclePoses { header, count: 1, ..VehiclePoses::zeroed() };
        let heading_rad = 0.5;
        poses.poses[0] =
            VehiclePose { x_m: 42.0, y_m: 9.0, heading_rad, length_m: 4.0, width_m: 2.0 };
        scene.take(Topic::VehiclePoses, 0, bytemuck::bytes_of(&poses));
        let odometry = Odometry { header, position_m: 1.0, ..Odometry::zeroed() };
        scene.take(Topic::Odometry, 0, bytemuck::bytes_of(&odometry));
        assert!(scene.drawn().is_empty(), "it waits for the pose");
        scene.take(Topic::EgoPose, 0, bytemuck::bytes_of(&pose));
    } else {
        let odometry = Odometry { header, position_m: 1.0, ..Odometry::zeroed() };
        scene.take(Topic::Odometry, 0, bytemuck::bytes_of(&odometry));
    }
    scene
}

/// Translation and rotation of the transforms of a message, which has the `frames` in this order.
fn transforms_of(payload: &[u8], frames: &[&str]) -> Vec<[f64; 7]> {
    let body = &payload[4..];
    let mut at: usize = 4;
    let mut found = Vec::new();
    let text = |at: &mut usize| {
        *at = at.next_multiple_of(4);
        let length = u32::from_le_bytes(body[*at..*at + 4].try_into().expect("four bytes"));
        let bytes = &body[*at + 4..*at + 3 + length as usize];
        *at += 4 + length as usize;
        String::from_utf8(bytes.to_vec()).expect("a name")
    };
    for frame in frames {
        at = at.next_multiple_of(4) + 8;
        assert_eq!(text(&mut at), "road");
        assert_eq!(text(&mut at), *frame);
        at = at.next_multiple_of(8);
        let value = |index: usize| {
            let from = at + 8 * index;
            f64::from_le_bytes(body[from..from + 8].try_into().expect("eight bytes"))
        };
        found.push(std::array::from_fn(value));
        at += 56;
    }
    found
}

#[test]
fn bodies_of_a_road_with_a_plan_have_their_poses() {
    let pose = EgoPose { x_m: 1.0, y_m: 0.25, heading_rad: 0.01, ..EgoPose::zeroed() };
    let drawn = scene(CURVED, Some(pose)).drawn();
    let [ego, vehicle] = transforms_of(&drawn[0].payload, &["ego", "vehicle_0"])[..] else {
        panic!("two frames")
    };
    let (sine, cosine) = libm::sincos(0.005);
    assert_eq!(ego, [1.0, 0.25, 0.0, 0.0, 0.0, sine, cosine]);
    let (sine, cosine) = libm::sincos(0.5);
    assert!((vehicle[0] - (42.0 - 2.0 * cosine)).abs() < 1e-12, "its rear bumper");
    assert!((vehicle[1] - (9.0 - 2.0 * sine)).abs() < 1e-12);
    assert!((2.0 * libm::atan2(vehicle[5], vehicle[6]) - 0.5).abs() < 1e-12);
}

#[test]
fn a_straight_road_is_drawn_along_x() {
    let text = "schema_version = 1\nname = \"x\"\nset_speed_mps = 10\n";
    let drawn = scene(text, None).drawn();
    let found = transforms_of(&drawn[0].payload, &["ego", "vehicle_0"]);
    let at = |x: f64| [x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    assert_eq!(found, [at(1.0), at(40.0)]);
}

#[test]
fn a_curved_road_has_a_strip_for_each_line_of_its_lanes() {
    let pose = EgoPose { x_m: 1.0, ..EgoPose::zeroed() };
    let scene = scene(CURVED, Some(pose));
    let lanes = scene.lanes(1.0);
    assert_eq!(lanes.len(), 4, "three lanes");
    let nowhere = EgoPose { x_m: f64::NAN, ..pose };
    let mut scene = self::scene(CURVED, Some(nowhere));
    assert!(scene.drawn().is_empty(), "a pose that is not a number is not drawn");
}
