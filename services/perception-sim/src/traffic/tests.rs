//! Tests of the other vehicles' motion.

use proptest::prelude::*;
use scenario::builtin;

use super::*;

const PERIOD_NS: u64 = 50_000_000;

macro_rules! reference {
    ($name:literal) => {
        include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/", $name, ".csv"))
    };
}

fn traffic(actors: &str) -> Traffic {
    let text = format!("schema_version = 1\nname = \"x\"\n{actors}");
    let scenario = Scenario::parse("x.toml", &text).unwrap_or_else(|error| panic!("{error}"));
    Traffic::new(&scenario)
}

fn ego(position_m: f64) -> Ego {
    Ego { position_m, ..Ego::default() }
}

fn lead(profile: &str) -> Traffic {
    traffic(&format!("[[actors]]\nname = \"lead\"\ngap_m = 50\n{profile}\n"))
}

/// The only vehicle at a time, reached in the radar's period.
fn at(traffic: &mut Traffic, time_s: f64) -> Vehicle {
    let end = (time_s * 1e9).round() as u64;
    for time_ns in (0..=end).step_by(PERIOD_NS as usize) {
        traffic.advance(time_ns, &ego(0.0));
    }
    traffic.advance(end, &ego(0.0));
    traffic.vehicles()[0]
}

#[test]
fn the_papers_leads_move_as_in_the_reference() {
    for (name, csv) in [
        ("cacc-a", reference!("cacc-a-cacc")),
        ("cacc-b", reference!("cacc-b-cacc")),
        ("cacc-c", reference!("cacc-c-cacc")),
        ("cacc-table3", reference!("cacc-table3-cacc")),
    ] {
        let builtin = builtin::find(name).expect("it is built in");
        let scenario = Scenario::parse(name, builtin.text).expect("it is right");
        let mut traffic = Traffic::new(&scenario);
        for (k, line) in csv.lines().skip(1).enumerate() {
            let row: Vec<f64> = line.split(',').map(|f| f.parse().expect("a number")).collect();
            let (position, gap, speed) = (row[1], row[7], row[8]);
            traffic.advance(2 * k as u64 * PERIOD_NS, &ego(0.0));
            let vehicle = traffic.vehicles()[0];
            assert!((vehicle.rear_position_m - position - gap).abs() < 2e-5, "{name} {k}");
            assert!((vehicle.speed_mps - speed).abs() < 1e-5, "{name} {k}");
            traffic.advance((2 * k as u64 + 1) * PERIOD_NS, &ego(0.0));
        }
    }
}

#[test]
fn a_constant_lead_keeps_its_speed() {
    let vehicle = at(&mut lead("initial_speed_mps = 20"), 30.0);
    assert!((vehicle.rear_position_m - 650.0).abs() < 1e-8);
    assert_eq!((vehicle.speed_mps, vehicle.acceleration_mps2), (20.0, 0.0));
}

#[test]
fn steps_reach_their_speeds_and_stay() {
    let profile = "initial_speed_mps = 10\nprofile.steps = [\
        { time_s = 2, speed_mps = 16, acceleration_mps2 = 3 },\
        { time_s = 6, speed_mps = 0, acceleration_mps2 = 4 }]";
    let vehicle = at(&mut lead(profile), 3.0);
    assert!((vehicle.speed_mps - 13.0).abs() < 1e-9 && vehicle.acceleration_mps2 == 3.0);
    assert!((vehicle.rear_position_m - (50.0 + 20.0 + 11.5)).abs() < 1e-8);
    let vehicle = at(&mut lead(profile), 5.5);
    assert!((vehicle.speed_mps - 16.0).abs() < 1e-9 && vehicle.acceleration_mps2.abs() < 1e-9);
    let vehicle = at(&mut lead(profile), 60.0);
    assert!(vehicle.speed_mps.abs() < 1e-9 && vehicle.acceleration_mps2.abs() < 1e-9);
    assert!((vehicle.rear_position_m - (50.0 + 20.0 + 26.0 + 32.0 + 32.0)).abs() < 1e-6);
}

#[test]
fn a_sine_is_integrated_to_its_closed_form() {
    let profile = "initial_speed_mps = 15\n\
        profile.sine = { amplitude_mps2 = 2, period_s = 10, start_s = 1 }";
    let vehicle = at(&mut lead(profile), 8.0);
    let w = 2.0 * std::f64::consts::PI / 10.0;
    let speed = 15.0 + 2.0 / w * (1.0 - libm::cos(w * 7.0));
    let position = 50.0 + 15.0 * 8.0 + 2.0 / w * (7.0 - libm::sin(w * 7.0) / w);
    assert!((vehicle.speed_mps - speed).abs() < 1e-6);
    assert!((vehicle.rear_position_m - position).abs() < 1e-5);
}

#[test]
fn pieces_stop_at_standstill_and_at_the_cap() {
    let profile = "initial_speed_mps = 10\nmax_speed_mps = 12\nprofile.piecewise = [\
        { time_s = 0, acceleration_mps2 = 1 }, { time_s = 5, acceleration_mps2 = -4 }]";
    let vehicle = at(&mut lead(profile), 4.0);
    assert!((vehicle.speed_mps - 12.0).abs() < 1e-9 && vehicle.acceleration_mps2.abs() < 1e-9);
    let vehicle = at(&mut lead(profile), 20.0);
    assert!(vehicle.speed_mps.abs() < 1e-9);
    let position = 50.0 + 22.0 + 36.0 + 18.0;
    assert!((vehicle.rear_position_m - position).abs() < 1e-6);
}

#[test]
fn a_table_of_speeds_is_followed_between_and_beyond_its_points() {
    let profile = "profile.speeds = [[1, 10], [3, 14], [4, 0]]";
    assert!((at(&mut lead(profile), 0.5).speed_mps - 10.0).abs() < 1e-9);
    assert!((at(&mut lead(profile), 2.0).speed_mps - 12.0).abs() < 1e-9);
    let vehicle = at(&mut lead(profile), 9.0);
    assert!(vehicle.speed_mps.abs() < 1e-9);
    assert!((vehicle.rear_position_m - (50.0 + 10.0 + 24.0 + 7.0)).abs() < 1e-6);
}

#[test]
fn a_vehicle_appears_relative_to_the_ego_and_leaves() {
    let mut traffic = lead("initial_speed_mps = 10\nappears_at_s = 2\nleaves_at_s = 4");
    traffic.advance(1_950_000_000, &ego(30.0));
    assert!(!traffic.vehicles()[0].present);
    traffic.advance(2_000_000_000, &ego(31.0));
    assert_eq!(traffic.vehicles()[0].rear_position_m, 81.0);
    traffic.advance(3_000_000_000, &ego(50.0));
    assert!((traffic.vehicles()[0].rear_position_m - 91.0).abs() < 1e-9);
    traffic.advance(4_000_000_000, &ego(60.0));
    assert!(!traffic.vehicles()[0].present);
}

#[test]
fn a_cut_in_moves_smoothly_into_the_path_and_out_again() {
    let profile = "initial_speed_mps = 10\nlateral_offset_m = -3.5\nlateral = [\
        { time_s = 2, to_m = 0, duration_s = 4 }, { time_s = 10, to_m = 3.5, duration_s = 2 }]";
    let lateral = |time_s| at(&mut lead(profile), time_s).lateral_m;
    assert_eq!(lateral(2.0), -3.5);
    assert!((lateral(4.0) + 1.75).abs() < 1e-12);
    assert_eq!(lateral(6.0), 0.0);
    assert_eq!(lateral(30.0), 3.5);
    assert!(!at(&mut lead(profile), 3.0).in_ego_path());
    assert!(at(&mut lead(profile), 5.0).in_ego_path());
}

#[test]
fn a_cut_in_of_constant_speed_rises_evenly_and_ends_at_once() {
    let profile = "initial_speed_mps = 10\nlateral_offset_m = -3.5\nlateral = [\
        { time_s = 1, to_m = 0, duration_s = 4, rise_s = 1 }]";
    let lateral = |time_s| at(&mut lead(profile), time_s).lateral_m;
    assert_eq!(lateral(1.0), -3.5);
    assert!((lateral(2.0) + 3.0).abs() < 1e-9, "{}", lateral(2.0));
    assert!((lateral(3.5) + 1.5).abs() < 1e-9, "{}", lateral(3.5));
    assert_eq!(lateral(5.0), 0.0);
}

/// Places of two vehicles at 20 m/s after some time. One is in the ego's lane, the other 3.5 m to the left of it.
fn pair_in_a_curve(road: &str, events: &str, time_s: f64) -> [f64; 2] {
    let actor = |name: &str, lateral: &str| {
        format!(
            "[[actors]]\nname = \"{name}\"\ngap_m = 50\ninitial_speed_mps = 20\n\
             lateral_offset_m = {lateral}\n{events}"
        )
    };
    let text = format!("{}{}{road}", actor("lead", "0"), actor("beside", "3.5"));
    let mut traffic = traffic(&text);
    let end = (time_s * 1e9) as u64;
    for time_ns in (0..=end).step_by(PERIOD_NS as usize) {
        traffic.advance(time_ns, &ego(0.0));
    }
    [0, 1].map(|index| traffic.vehicles()[index].rear_position_m - 50.0)
}

#[test]
fn the_inner_lane_of_a_curve_is_shorter() {
    // A left curve: the vehicle on the left covers 250 m of the axis on 246.5 m.
    let arc = "[road.plan]\npieces = [{ arc_m = 900, radius_m = 250, turn = \"left\" }]\n";
    // An event moves vehicles by a storyboard, by the same rule.
    let event =
        "[[actors.events]]\nwhen = { time_s = 90 }\nspeed = { to_mps = 0, rate_mps2 = 1 }\n";
    for events in ["", event] {
        let [lead_m, beside_m] = pair_in_a_curve(arc, events, 9.0);
        assert!((lead_m - 180.0).abs() < 1e-6, "{lead_m}");
        assert!((beside_m - 180.0 / (1.0 - 3.5 / 250.0)).abs() < 0.02, "{beside_m}");
        let straight = "[road.plan]\npieces = [{ line_m = 900 }]\n";
        let [plain, planned] = ["", straight].map(|road| pair_in_a_curve(road, events, 9.0));
        assert_eq!(plain.map(f64::to_bits), planned.map(f64::to_bits));
    }
}

#[test]
fn a_body_lies_on_its_offset_along_the_tangent() {
    let arc = "[road.plan]\npieces = [{ arc_m = 900, radius_m = 125, turn = \"right\" }]\n";
    let text = format!("schema_version = 1\nname = \"x\"\n{arc}");
    let scenario = Scenario::parse("x.toml", &text).expect("it is right");
    let axis = scenario.road.plan().expect("it has one").axis();
    let lorry = Vehicle {
        present: true,
        rear_position_m: 91.75,
        length_m: 16.5,
        lateral_m: 3.5,
        speed_mps: 20.0,
        ..Vehicle::default()
    };
    let pose = lorry.pose(axis);
    assert!((pose.heading_rad + 100.0 / 125.0).abs() < 1e-9);
    // The centre of the curve is at (0, -125).
    assert!((libm::hypot(pose.x_m, pose.y_m + 125.0) - 128.5).abs() < 1e-6);
    let oncoming = Vehicle { speed_mps: -20.0, ..lorry }.pose(axis);
    assert!((oncoming.heading_rad - pose.heading_rad - std::f64::consts::PI).abs() < 1e-12);
}

proptest! {
    #[test]
    fn the_result_does_not_depend_on_the_sampling(
        skips in prop::collection::vec(1u64..20, 1..40), paper: bool,
    ) {
        let how = if paper { "paper-euler\"\nintegration_step_ms = 100" } else { "fine\"" };
        let text = format!("[plant]\nintegrator = \"{how}\n[[actors]]\nname = \"lead\"\n\
            gap_m = 50\ninitial_speed_mps = 8\nprofile.steps = [\
            {{ time_s = 1.23, speed_mps = 0, acceleration_mps2 = 3.1 }},\
            {{ time_s = 7, speed_mps = 20, acceleration_mps2 = 1.7 }}]");
        let (mut coarse, mut fine) = (traffic(&text), traffic(&text));
        coarse.advance(0, &ego(0.0));
        let (mut now, mut last) = (0, 0.0);
        for skip in skips {
            for _ in 0..skip {
                fine.advance(now, &ego(0.0));
                now += 10_000_000;
            }
            fine.advance(now, &ego(0.0));
            coarse.advance(now, &ego(0.0));
            prop_assert_eq!(fine.vehicles(), coarse.vehicles());
            let vehicle = fine.vehicles()[0];
            prop_assert!(vehicle.speed_mps >= 0.0 && vehicle.rear_position_m >= last);
            last = vehicle.rear_position_m;
        }
    }
}

/// The closed sum against steps of 1 ms: a lateral motion that never begins keeps a vehicle from the sum.
#[test]
fn a_vehicle_that_keeps_its_offset_is_where_small_steps_bring_it() {
    let road = "[road.plan]\npieces = [{ line_m = 80 }, { spiral_m = 60 }, \
        { arc_m = 150, radius_m = 60, turn = \"right\" }, { spiral_m = 40 }, { line_m = 60 }]\n";
    let never = "lateral = [{ time_s = 900, to_m = 0, duration_s = 2 }]\n";
    let [summed, stepped] = ["", never].map(|events| pair_in_a_curve(road, events, 17.0));
    assert!((summed[0] - 340.0).abs() < 1e-9, "on the axis: {summed:?}");
    assert!((summed[1] - stepped[1]).abs() < 5e-3, "{summed:?} {stepped:?}");
    assert!(summed[1] < 332.0, "the outer lane is longer: {summed:?}");
}
