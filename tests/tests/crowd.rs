//! More vehicles than one message carries: up to 64 beside the ego, on a straight road and on one with curves.

use std::time::Duration;

use messages::MAX_TRACKS;
use report::summary::Summary;
use runtime::Mode;
use scenario::actor::MAX_ACTORS;
use scenario::{Overrides, Scenario};
use supervise::in_process;

const CURVES: &str = "[road.plan]\npieces = [{ line_m = 100 }, { spiral_m = 60 }, { arc_m = 300, radius_m = 400, \
    turn = \"left\" }, { spiral_m = 60 }, { line_m = 500 }]\n";

/// Vehicles in both neighbouring lanes, and the last of all, slower than the ego, in its own.
fn scene(others: usize, road: &str) -> Scenario {
    let mut text = format!(
        "schema_version = 1\nname = \"crowd\"\nset_speed_mps = 20\nduration_s = 12\n\
         plant.initial_speed_mps = 20\n{road}"
    );
    for place in 0..others {
        let is_last = place + 1 == others;
        let (gap_m, speed_mps, lateral_m) = match is_last {
            true => (60, 17.0, 0.0),
            false => (4 + 7 * (place / 2), 20.0, if place % 2 == 0 { 3.5 } else { -3.5 }),
        };
        text += &format!(
            "[[actors]]\nname = \"car-{place}\"\ngap_m = {gap_m}\ninitial_speed_mps = {speed_mps:?}\n\
             lateral_offset_m = {lateral_m:?}\n"
        );
    }
    let checked = Scenario::parse_with("crowd", &text, &Overrides::new(), &controller::laws::check);
    checked.unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn all_vehicles_are_in_the_world_and_the_last_one_is_followed() {
    for (road, others) in [("", MAX_ACTORS), (CURVES, MAX_ACTORS), (CURVES, MAX_TRACKS + 1)] {
        let scenario = scene(others, road);
        let group = in_process::run(&scenario).expect("it runs");
        let drive = &group.drive;
        assert!(drive.vehicles.iter().all(|truth| truth.vehicles.len() == others));
        assert!(drive.plane.iter().all(|scene| scene.bodies.len() == others));
        assert_eq!(drive.plane.is_empty(), road.is_empty());
        let last = drive.steps.last().expect("it drives");
        assert!(last.time_s > 11.9, "no contact: {last:?}");
        let lead = drive.steps.iter().rev().find_map(|step| step.lead);
        assert_eq!(lead, Some(others as u32 - 1), "the referee's lead");
        // A law that does not see the vehicle ahead drives 240 m.
        assert!(last.position_m < 238.0, "it is seen: {last:?}");
        for scene in &drive.plane {
            let lead = &scene.bodies[others - 1];
            let gap_m = (lead.x_m - scene.ego.x_m).hypot(lead.y_m - scene.ego.y_m);
            assert!((20.0..70.0).contains(&gap_m), "{gap_m} m at {} s", scene.time_s);
            assert!(lead.in_lane, "its place on the axis is that of its own body");
        }
    }
}

#[test]
fn a_second_message_goes_out_only_where_the_first_has_no_room() {
    let topics = |others: usize, road: &str| -> Vec<String> {
        let scenario = scene(others, road);
        let group = in_process::run(&scenario).expect("it runs");
        let summary = Summary::new(&scenario, Mode::Lockstep, &group, Duration::ZERO);
        let names = summary.messages.into_keys();
        names.filter(|topic| topic.starts_with("truth/more")).collect()
    };
    assert!(topics(MAX_TRACKS, "").is_empty() && topics(MAX_TRACKS, CURVES).is_empty());
    assert_eq!(topics(MAX_TRACKS + 1, ""), ["truth/more_vehicles"]);
    assert_eq!(topics(MAX_TRACKS + 1, CURVES), ["truth/more_poses", "truth/more_vehicles"]);
}

#[test]
fn one_vehicle_too_many_is_refused() {
    let text = "schema_version = 1\nname = \"crowd\"\n".to_owned()
        + &(0..=MAX_ACTORS)
            .map(|k| format!("[[actors]]\nname = \"a{k}\"\ngap_m = 9\ninitial_speed_mps = 20\n"))
            .collect::<String>();
    let refused = Scenario::parse("crowd.toml", &text).expect_err("one too many").to_string();
    assert!(refused.contains("65 actors") && refused.contains("at most 64"), "{refused}");
    assert!(refused.contains("crowd.toml:3"), "{refused}");
}
