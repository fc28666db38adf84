//! A file that is outside the subset, or makes no sense, is refused with its place.

#![allow(
    clippy::result_large_err,
    reason = "an error ends the reading of a file; its size costs nothing"
)]

mod common;

use common::*;
use openscenario::World;

#[track_caller]
fn refused(parts: &Parts, expected: &[&str]) {
    let shown = parts.refusal();
    for part in expected {
        assert!(shown.contains(part), "{shown}");
    }
    assert!(!shown.contains('\n'), "{shown}");
}

fn with_event(action: &str) -> Parts {
    Parts {
        stories: story(&[event("E", "override", &[action], &trigger(&[&at(1.0)]))]),
        ..Parts::default()
    }
}

#[test]
fn actions_outside_the_subset() {
    refused(
        &with_event("<PlatoonAction/>"),
        &[
            "dir/a.xosc:6:271: element `PlatoonAction` in `PrivateAction` is not supported, expected `LongitudinalAction`",
        ],
    );
    refused(
        &with_event(&speed("bezier", "time", 1.0, 1.0)),
        &[
            "attribute `dynamicsShape` of `SpeedActionDynamics`: `bezier` is not supported, expected `linear`, `cubic`, `sinusoidal` or `step`",
        ],
    );
    refused(
        &with_event(&speed("linear", "time", -1.0, 1.0)),
        &["`value` of `SpeedActionDynamics`: -1 is negative"],
    );
    refused(
        &with_event(&speed("linear", "time", 1.0, -1.0)),
        &["`value` of `AbsoluteTargetSpeed`: -1 is out of range, expected 0 or more"],
    );
    refused(
        &with_event(&lane_change("linear", "time", 1.0, "<AbsoluteTargetLane value=\"7\"/>")),
        &["road `0` has no lane `7`, expected `-2`, `-1` or `1`"],
    );
    refused(
        &with_event(&lane_change(
            "linear",
            "time",
            1.0,
            "<RelativeTargetLane entityRef=\"Other\" value=\"1\"/>",
        )),
        &["there is no entity `Other`, expected `Ego`, `Lead` or `Walker`"],
    );
}

#[test]
fn places_that_are_not_there() {
    let lead = |position: &str| Parts {
        init: private("Lead", &[&teleport(position)]),
        ..Parts::default()
    };
    refused(
        &lead("<LanePosition roadId=\"0\" laneId=\"9\" s=\"1\"/>"),
        &["road `0` has no lane `9`"],
    );
    refused(
        &lead("<LanePosition roadId=\"0\" laneId=\"-1\" s=\"2000\"/>"),
        &["2000 m are beyond the road's end, expected at most 1000"],
    );
    refused(
        &lead("<LanePosition roadId=\"5\" laneId=\"-1\" s=\"1\"/>"),
        &["there is no road `5`, expected `0`"],
    );
    let mut narrow = lead("<WorldPosition x=\"1\" y=\"0\"/>");
    narrow
        .files
        .push(("dir/road.xodr".into(), ROAD.replace("<line/>", "<arc curvature=\"0.1\"/>")));
    refused(&narrow, &["dir/road.xodr:1:49: a radius of 10.0 m, expected at least 20 m"]);
}

#[test]
fn parameters() {
    let parts = |declarations: &str, assigned: &[(&str, &str)]| Parts {
        parameters: format!("<ParameterDeclarations>{declarations}</ParameterDeclarations>"),
        assigned: assigned.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())).collect(),
        ..Parts::default()
    };
    let v = "<ParameterDeclaration name=\"v\" parameterType=\"double\" value=\"1\"/>";
    refused(
        &parts(v, &[("w", "1")]),
        &["parameter w=1: dir/a.xosc does not declare it, expected `v`"],
    );
    refused(
        &parts(v, &[("v", "fast")]),
        &["parameter v=fast: dir/a.xosc declares it as double, expected a number"],
    );
    let circle = "<ParameterDeclaration name=\"v\" parameterType=\"double\" value=\"${$v + 1}\"/>";
    refused(&parts(circle, &[]), &["dir/a.xosc:3:24: parameter `v` depends on itself (v -> v)"]);
    let mut undeclared = with_event(&speed("linear", "time", 1.0, 1.0));
    undeclared.stories = undeclared
        .stories
        .replace("value=\"1\"/></SpeedActionTarget>", "value=\"$fast\"/></SpeedActionTarget>");
    refused(
        &undeclared,
        &["dir/a.xosc:6:", ": parameter `fast` is not declared, expected no parameter here"],
    );
}

#[test]
fn catalogs_and_entries_that_are_missing() {
    let text = Parts::default().text();
    let object = "<ScenarioObject name=\"New\"><CatalogReference catalogName=\"cars\" entryName=\"van\"/></ScenarioObject>";
    let with = |locations: &str, files: &[(&str, &str)]| {
        let head = format!("<CatalogLocations>{locations}</CatalogLocations>");
        let mut all: std::collections::BTreeMap<std::path::PathBuf, String> =
            files.iter().map(|(path, text)| (path.into(), (*text).to_owned())).collect();
        let text = text
            .replace("<RoadNetwork>", &format!("{head}<RoadNetwork>"))
            .replace("</Entities>", &format!("{object}</Entities>"));
        all.insert("dir/a.xosc".into(), text);
        all.insert("dir/road.xodr".into(), ROAD.to_owned());
        openscenario::read::scenario(
            std::path::Path::new("dir/a.xosc"),
            &Files(all),
            &Default::default(),
        )
    };
    let location = "<VehicleCatalog><Directory path=\"./cars\"/></VehicleCatalog>";
    let shown = with("", &[]).expect_err("no location").to_string();
    assert!(shown.contains("catalog `cars` is in none of the catalog locations"), "{shown}");
    let shown = with(location, &[]).expect_err("no directory").to_string();
    assert!(
        shown.starts_with("dir/a.xosc:3:35: the catalogs of dir/cars cannot be read"),
        "{shown}"
    );
    let catalog = |entry: &str| {
        format!(
            "<OpenSCENARIO>\n<FileHeader revMajor=\"1\" revMinor=\"0\"/><Catalog name=\"cars\">\n{entry}</Catalog></OpenSCENARIO>"
        )
    };
    let van = "<Vehicle name=\"van\" vehicleCategory=\"van\"><ParameterDeclarations><ParameterDeclaration name=\"l\" parameterType=\"double\" value=\"6\"/></ParameterDeclarations>\
        <BoundingBox><Center x=\"1\" y=\"0\" z=\"1\"/><Dimensions width=\"2\" length=\"$l\" height=\"2\"/></BoundingBox></Vehicle>";
    let shown = with(
        location,
        &[("dir/cars/c.xosc", &catalog(&van.replace("name=\"van\"", "name=\"bus\"")))],
    )
    .expect_err("no entry")
    .to_string();
    assert!(
        shown.contains("catalog `cars` (dir/cars/c.xosc) has no entry `van`, expected `bus`"),
        "{shown}"
    );
    let shown =
        with(location, &[("dir/cars/c.xosc", &catalog(&van.replace("BoundingBox", "Box")))])
            .expect_err("an entry outside the subset")
            .to_string();
    assert!(
        shown.starts_with("dir/cars/c.xosc:3:155:")
            && shown.contains(": element `Box` in `Vehicle`"),
        "{shown}"
    );
    let read = with(location, &[("dir/cars/c.xosc", &catalog(van))]).expect("it is there");
    assert_eq!(read.script.entities.last().map(|entity| entity.body.length_m), Some(6.0));
}

#[test]
fn the_ego_must_be_known_and_placed() {
    let text = Parts::default().text().replace("\"Ego\"", "\"Car\"");
    let read = |text: &str| {
        let files = [("dir/a.xosc", text), ("dir/road.xodr", ROAD)];
        let files = files.iter().map(|(path, text)| (path.into(), (*text).to_owned())).collect();
        openscenario::read::scenario(
            std::path::Path::new("dir/a.xosc"),
            &Files(files),
            &Default::default(),
        )
    };
    let shown = read(&text).expect_err("no ego").to_string();
    assert!(
        shown.contains(
            "no entity is known to be the ego, expected `--ego NAME` with `Car`, `Lead` or `Walker`"
        ),
        "{shown}"
    );
    let controlled = text.replacen("<ScenarioObject name=\"Car\">", "<ScenarioObject name=\"Car\"><ObjectController><Controller name=\"c\"/></ObjectController>", 1);
    assert_eq!(read(&controlled).expect("the controlled one is the ego").script.ego, 0);
    let parts = Parts {
        init: private(
            "Ego",
            &[&lane_change("linear", "time", 3.0, "<AbsoluteTargetLane value=\"-2\"/>")],
        ),
        ..Parts::default()
    };
    refused(&parts, &["timegap's stack drives the ego from the start"]);
}

#[test]
fn storyboard_references_are_looked_up() {
    let missing = Parts {
        stop: trigger(&[&state("none", 0.0, "event", "Nothing", "completeState")]),
        ..Parts::default()
    };
    refused(
        &missing,
        &[
            "dir/a.xosc:7:99: the storyboard has no event `Nothing`, expected the name of one, and there is no event",
        ],
    );
    let twice = story(&[
        event("E", "override", &[&speed("step", "time", 0.0, 1.0)], &trigger(&[&at(1.0)])),
        event("E", "override", &[&speed("step", "time", 0.0, 1.0)], &trigger(&[&at(1.0)])),
    ]);
    let several = Parts {
        stories: twice,
        stop: trigger(&[&state("none", 0.0, "event", "E", "completeState")]),
        ..Parts::default()
    };
    refused(&several, &["the storyboard has several parts called `E`"]);
}

#[test]
fn a_missing_road_is_assumed_and_said() {
    let text = Parts::default().text();
    let files = [("dir/a.xosc".into(), text)].into_iter().collect();
    let read = openscenario::read::scenario(
        std::path::Path::new("dir/a.xosc"),
        &Files(files),
        &Default::default(),
    )
    .expect("a road is assumed");
    assert_eq!(read.notices.len(), 2, "{:?}", read.notices);
    assert!(
        read.notices[0]
            .contains("dir/road.xodr is not there: a straight road with lanes of 3.5 m is assumed")
    );
    assert!(read.notices[1].contains("`Walker` has no place in Init"));
}

#[test]
fn a_vehicle_wider_than_its_lane() {
    let mut narrow = Parts::default();
    narrow.files.push(("dir/road.xodr".into(), ROAD.replace("a=\"4\"", "a=\"1.9\"")));
    let script = narrow.read().expect("it can be read").script;
    let refused = World::new(script).expect_err("2 m do not fit").to_string();
    assert_eq!(refused, "`Ego` is 2 m wide, expected at most the 1.9 m of lane -1");
}
