//! Headings at the start, and the end of the road.

mod common;

use std::path::Path;

use common::*;
use openscenario::{Choices, LaneHeadings, World, read};

/// The lead's direction along the reference line when it begins in a lane with an orientation.
fn direction(lane: i32, orientation: &str, headings: LaneHeadings) -> f64 {
    let place = format!(
        "<TeleportAction><Position><LanePosition roadId=\"0\" laneId=\"{lane}\" s=\"60\">\
         {orientation}</LanePosition></Position></TeleportAction>"
    );
    let init = private("Lead", &[&place, &speed("step", "time", 0.0, 20.0)]);
    Parts { init, headings: Some(headings), ..Parts::default() }.run().of_entity("Lead").direction()
}

#[test]
fn headings_count_from_the_reference_line_or_from_the_traffic() {
    let turned = "<Orientation type=\"relative\" h=\"3.14159\"/>";
    let (road, traffic) = (LaneHeadings::Road, LaneHeadings::Traffic);
    for (lane, orientation, headings, expected) in [
        (-1, "", road, 1.0),
        (-1, "", traffic, 1.0),
        (1, "", road, 1.0),
        (1, "", traffic, -1.0),
        (1, turned, road, -1.0),
        (1, turned, traffic, 1.0),
    ] {
        let found = direction(lane, orientation, headings);
        assert_eq!(found, expected, "lane {lane} {orientation} {headings:?}");
    }
}

/// A file says by its author which program reads it as it is meant; the user's choice comes first.
#[test]
fn headings_of_a_file_of_esmini_count_from_the_traffic() {
    let by = |author: &str, headings| {
        let place = "<TeleportAction><Position><LanePosition roadId=\"0\" laneId=\"1\" s=\"60\"/></Position></TeleportAction>";
        let init = private("Lead", &[place]);
        let author = format!("revMinor=\"2\" author=\"{author}\"");
        let text = Parts { init, ..Parts::default() }.text().replacen("revMinor=\"2\"", &author, 1);
        let files = [("dir/a.xosc", text), ("dir/road.xodr", ROAD.to_owned())];
        let files = Files(files.into_iter().map(|(path, text)| (path.into(), text)).collect());
        let choices = Choices { headings, ..Choices::default() };
        let read = read::scenario(Path::new("dir/a.xosc"), &files, &choices).expect("it is sound");
        let noted = read.notices.iter().any(|notice| notice.contains("--lane-headings road"));
        let world = World::new(read.script).expect("it is sound");
        (world.motion(1).direction(), noted)
    };
    assert_eq!(by("Esmini-Team", None), (-1.0, true));
    assert_eq!(by("Esmini-Team", Some(LaneHeadings::Road)), (1.0, false));
    assert_eq!(by("a person", None), (1.0, false));
}

#[test]
fn an_oncoming_heading_of_two_meanings_is_noted() {
    let place = "<TeleportAction><Position><LanePosition roadId=\"0\" laneId=\"1\" s=\"60\">\
                 <Orientation type=\"relative\" h=\"3.14159\"/></LanePosition></Position></TeleportAction>";
    let init = private("Lead", &[place, &speed("step", "time", 0.0, 20.0)]);
    let noted = |headings| {
        let parts = Parts { init: init.clone(), headings: Some(headings), ..Parts::default() };
        let notices = parts.read().expect("it is sound").notices;
        notices.iter().any(|notice| notice.contains("`--lane-headings traffic`"))
    };
    assert!(noted(LaneHeadings::Road));
    assert!(!noted(LaneHeadings::Traffic));
}

#[test]
fn a_drive_ends_where_the_egos_road_ends() {
    let mut run = Parts::default().run();
    // The ego's front is 3 m ahead of its origin, which begins at 10 m of 1000 m.
    let end_s = (1000.0 - 13.0) / 20.0;
    assert!(!run.to(end_s - 0.05).world.is_stopped());
    let world = &run.to(end_s + 0.05).world;
    assert!(world.is_stopped() && world.has_road_ended());
}
