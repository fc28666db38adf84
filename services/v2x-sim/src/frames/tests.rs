use super::*;
use scenario::radio::SIMULATED_START_NS;
use scenario::{Scenario, builtin};

fn frames(keys: &str) -> Frames {
    let text = builtin::find("corridor").expect("it is built in").text;
    let scenario = Scenario::parse("corridor", &format!("{text}\n{keys}")).expect("right");
    Frames::new(&scenario)
}

fn read(frames: &Frames, time_ns: u64, ego_m: Option<f64>) -> Vec<Message> {
    let sent = frames.at(time_ns, SIMULATED_START_NS, ego_m, None).expect("there is room");
    sent.iter().map(|f| Frame::decode(&f.bytes).expect("a frame").message).collect()
}

#[test]
fn each_unit_in_reach_sends_its_signals_and_once_a_second_its_map() {
    let frames = frames("");
    let count = |ego_m| {
        let tenths = (0..10).flat_map(|k| read(&frames, k * 100_000_000, ego_m));
        let (maps, spats): (Vec<_>, Vec<_>) =
            tenths.partition(|message| matches!(message, Message::Mapem(_)));
        (maps.len(), spats.len())
    };
    assert_eq!(count(Some(-1.0)), (0, 0));
    assert_eq!(count(Some(0.0)), (1, 10));
    assert_eq!(count(None), (3, 30));
}

#[test]
fn a_map_leads_back_to_the_stop_line_and_the_signal_of_the_lane() {
    let Some(Message::Mapem(map)) = read(&frames(""), 0, Some(0.0)).pop() else {
        panic!("a map comes at first")
    };
    let geometry = &map.intersections[0];
    let plane = frames("").path.plane;
    let middle = plane.point(geometry.reference);
    let straight = &geometry.lanes[0];
    assert!((middle.0 + f64::from(straight.nodes[0].0) / 100.0 - 300.0).abs() < 0.01);
    assert!(middle.1.abs() < 0.01);
    assert_eq!(straight.connections[0].signal_group, Some(1));
    assert_eq!(geometry.lanes[1].connections[0].signal_group, Some(2), "the turning lane's");
}

#[test]
fn a_road_at_the_date_line_has_its_maps_where_they_belong() {
    for longitude_deg in [180.0, 179.999, -180.0, -179.999] {
        for heading_deg in [90.0, 270.0] {
            let frames = frames(&format!(
                "[v2x.origin]\nlongitude_deg = {longitude_deg}\nheading_deg = {heading_deg}\n"
            ));
            for message in read(&frames, 0, None) {
                let Message::Mapem(map) = message else { continue };
                let geometry = &map.intersections[0];
                let (along_m, left_m) = frames.path.plane.point(geometry.reference);
                let place = format!("{longitude_deg} {heading_deg}: {along_m} m");
                assert!((250.0..1500.0).contains(&along_m) && left_m.abs() < 0.01, "{place}");
            }
        }
    }
}

#[test]
fn the_map_changes_of_one_intersection_where_one_is_named() {
    let revisions = |keys: &str| {
        let frames = frames(&format!("[v2x.unit]\nmap_changes_at_s = 5\n{keys}"));
        let messages = read(&frames, 6_000_000_000, None).into_iter();
        let of = |message| match message {
            Message::Spatem(spatem) => Some(spatem.intersections[0].revision),
            Message::Mapem(_) | Message::Cam(_) => None,
        };
        messages.filter_map(of).collect::<Vec<_>>()
    };
    assert_eq!(revisions(""), [1, 1, 1]);
    assert_eq!(revisions("map_changes_of = 2"), [0, 1, 0]);
}

/// Announced ends of the first signal, s of run time.
fn ends_s(frames: &Frames, time_s: f64) -> Vec<f64> {
    let time_ns = (1e9 * time_s) as u64;
    let messages = read(frames, time_ns, Some(0.0));
    let Some(Message::Spatem(spatem)) = messages.first() else { panic!("{messages:?}") };
    let utc_ms = SIMULATED_START_NS / 1_000_000 + (time_ns / 1_000_000) as i64;
    let end_s = |event: &MovementEvent| {
        let mark = event.timing.and_then(|timing| timing.likely_end);
        let end_ms = mark.and_then(|mark| mark.utc(utc_ms)).expect("it is known");
        (end_ms - SIMULATED_START_NS / 1_000_000) as f64 / 1e3
    };
    spatem.intersections[0].movements[0].events.iter().map(end_s).collect()
}

#[test]
fn announced_ends_are_the_programs_or_wrong_if_the_scenario_says_so() {
    let at = |keys: &str, time_s: f64| {
        let keys = format!("[v2x.unit]\ncountdown_wrong_from_s = 10\n{keys}");
        ends_s(&frames(&keys), time_s)
    };
    assert_eq!((at("", 0.0)[0], at("", 20.0)[0]), (27.0, 27.0));
    let slides = "countdown_jump_s = 2\ncountdown_slide = 0.5";
    assert_eq!((at(slides, 0.0)[0], at(slides, 12.0)[0]), (27.0, 30.0));
    let jitters = "countdown_jitter_s = 1.5";
    assert_eq!(at(jitters, 9.9)[0], 27.0);
    let ends: Vec<f64> = (110..200).map(|k| at(jitters, f64::from(k) / 10.0)[0]).collect();
    assert!(ends.iter().all(|end_s| (25.5..=28.5).contains(end_s)), "{ends:?}");
    assert!(ends.iter().any(|end_s| *end_s < 26.0) && ends.iter().any(|end_s| *end_s > 28.0));
    let extends = "countdown_extends_s = 4";
    let ends = [11.9, 12.0, 23.9, 24.0].map(|time_s| at(extends, time_s)[..2].to_vec());
    assert_eq!(ends, [[12.0, 15.0], [16.0, 19.0], [24.0, 27.0], [27.0, 30.0]]);
    let lacks = "countdown_lacks_next = true";
    assert_eq!((at(lacks, 9.9).len(), at(lacks, 10.0)), (MAX_INTERVALS, vec![27.0]));
}
