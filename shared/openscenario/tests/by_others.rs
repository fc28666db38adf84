//! Content of files by other authors, and its meaning here.

#![allow(
    clippy::result_large_err,
    reason = "an error ends the reading of a file; its size costs nothing"
)]

mod common;

use std::path::Path;

use common::*;
use openscenario::ReadError;
use openscenario::read::{Scenario, scenario};

const BOX: &str = "<BoundingBox><Center x=\"1\" y=\"0\" z=\"1\"/><Dimensions width=\"2\" length=\"4\" height=\"1.5\"/></BoundingBox>";

/// Reads a scenario whose lead is the entry `car` of a catalog, with these parameters assigned.
fn with_catalog(entries: &str, assigned: &str) -> Result<Scenario, ReadError> {
    with_head("revMajor=\"1\" revMinor=\"3\"", entries, assigned)
}

fn with_head(version: &str, entries: &str, assigned: &str) -> Result<Scenario, ReadError> {
    let locations = "<CatalogLocations><VehicleCatalog><Directory path=\"cars\"/></VehicleCatalog></CatalogLocations>";
    let text = Parts { head: locations.to_owned(), ..Parts::default() }.text();
    let lead = text.find("name=\"Lead\"").expect("there is a lead");
    let at = lead + text[lead..].find("<Vehicle").expect("it is described");
    let end = at + text[at..].find("</Vehicle>").expect("it ends") + "</Vehicle>".len();
    let reference = format!(
        "<CatalogReference catalogName=\"c\" entryName=\"car\"><ParameterAssignments>{assigned}</ParameterAssignments></CatalogReference>"
    );
    let text = format!("{}{reference}{}", &text[..at], &text[end..]);
    let catalog = format!(
        "<OpenSCENARIO>\n<FileHeader {version}/>\n<Catalog name=\"c\">{entries}</Catalog></OpenSCENARIO>"
    );
    let files =
        [("dir/a.xosc", text), ("dir/cars/c.xosc", catalog), ("dir/road.xodr", ROAD.into())];
    let files = files.into_iter().map(|(path, text)| (path.into(), text)).collect();
    scenario(Path::new("dir/a.xosc"), &Files(files), &Default::default())
}

/// The same with a catalog of a version.
fn of_version(version: &str, entry: &str) -> Result<Scenario, ReadError> {
    with_head(version, entry, "")
}

/// A car that may pull what its parameter names.
fn car() -> String {
    format!(
        "<Vehicle name=\"car\" vehicleCategory=\"car\"><ParameterDeclarations>\
         <ParameterDeclaration name=\"Pulled\" parameterType=\"string\" value=\"\"/></ParameterDeclarations>{BOX}\
         <TrailerHitch dx=\"-1.2\"/><Trailer><TrailerRef entityRef=\"$Pulled\"/></Trailer></Vehicle>"
    )
}

#[test]
fn only_the_entry_in_use_of_a_catalog_has_to_be_in_the_subset() {
    let other =
        "<Vehicle name=\"other\" vehicleCategory=\"car\"><Wings/></Vehicle><Route name=\"r\"/>";
    with_catalog(&format!("{other}{}", car()), "").expect("the car is in the subset");
    let winged = car().replace("<TrailerHitch dx=\"-1.2\"/>", "<Wings/>");
    let shown = with_catalog(&winged, "").expect_err("it has wings").to_string();
    assert!(
        shown.starts_with("dir/cars/c.xosc:3:278: element `Wings` in `Vehicle` is not supported"),
        "{shown}"
    );
}

#[test]
fn a_car_that_could_pull_a_trailer_is_alone() {
    let assign = |value: &str, name: &str| {
        format!("<ParameterAssignment parameterRef=\"{name}\" value=\"{value}\"/>")
    };
    with_catalog(&car(), &assign("", "Pulled")).expect("no trailer");
    // The name may be given with the sign of its uses.
    let shown = with_catalog(&car(), &assign("box", "$Pulled")).expect_err("a trailer").to_string();
    assert!(shown.contains("`box` would be pulled as a trailer, expected none"), "{shown}");
}

#[test]
fn a_controller_action_of_version_1_0_holds_two_that_do_nothing() {
    let action = |active: &str| {
        format!(
            "<ControllerAction><AssignControllerAction><Controller name=\"c\"><Properties/></Controller></AssignControllerAction>\
             <OverrideControllerValueAction><Throttle value=\"0\" active=\"false\"/><Brake value=\"0\" active=\"{active}\"/>\
             <Gear number=\"0\" active=\"false\"/></OverrideControllerValueAction></ControllerAction>"
        )
    };
    let parts = |active: &str| Parts {
        init: private("Lead", &[&place(-1, 60.0), &action(active)]),
        ..Parts::default()
    };
    parts("false").read().expect("nothing is overridden");
    let shown = parts("true").refusal();
    assert!(
        shown.contains("`active` of `Brake`: `Brake` would be overridden, expected false"),
        "{shown}"
    );
}

#[test]
fn the_name_of_a_condition_is_not_evaluated() {
    let named = at(1.0).replace("name=\"c\"", "name=\"${Words + $x}\"");
    let start = trigger(&[&named]);
    let event = event("E", "override", &[&speed("step", "time", 0.0, 1.0)], &start);
    Parts { stories: story(&[event]), ..Parts::default() }.read().expect("names are free");
}

#[test]
fn weather_has_no_effect_and_the_friction_of_init_is_a_factor() {
    let action = |friction: &str| {
        format!(
            "<GlobalAction><EnvironmentAction><Environment name=\"e\"><TimeOfDay animation=\"false\" dateTime=\"2020-01-01T12:00:00\"/>\
             <Weather cloudState=\"free\"><Sun intensity=\"1\" azimuth=\"0\" elevation=\"1\"/><Fog visualRange=\"1000\"/>\
             <Precipitation precipitationType=\"dry\" intensity=\"0\"/></Weather><RoadCondition frictionScaleFactor=\"{friction}\"/>\
             </Environment></EnvironmentAction></GlobalAction>"
        )
    };
    let parts = |init: &str, later: &str| {
        let event = event("E", "override", &["LATER"], &trigger(&[&at(1.0)]));
        let stories = story(&[event]).replace("<PrivateAction>LATER</PrivateAction>", later);
        Parts {
            init: init.to_owned() + &private("Lead", &[&place(-1, 60.0)]),
            stories,
            ..Parts::default()
        }
    };
    let dry = private("Lead", &[&place(-1, 60.0)]);
    assert_eq!(
        Parts { init: dry, ..Parts::default() }.read().expect("no road condition").friction,
        1.0
    );
    for friction in ["1.0", "0.5"] {
        let read = parts(&action(friction), &action(friction)).read().expect("it stays");
        assert_eq!(read.friction, friction.parse().expect("a number"));
    }
    let shown = parts(&action("0.5"), &action("0.4")).refusal();
    assert!(
        shown.contains("would change during the drive, expected the friction of Init"),
        "{shown}"
    );
    assert!(parts("", &action("0.4")).refusal().contains("would change during the drive"));
    let shown = parts(&action("0"), &action("1")).refusal();
    assert!(
        shown.contains("`frictionScaleFactor` of `RoadCondition`: 0 is out of range"),
        "{shown}"
    );
}

#[test]
fn the_ego_may_be_the_hero_or_the_only_entity() {
    let text = Parts::default().text().replace("\"Ego\"", "\"Hero\"");
    let read = |text: String| {
        let files = [("dir/a.xosc", text), ("dir/road.xodr", ROAD.to_owned())];
        let files = files.into_iter().map(|(path, text)| (path.into(), text)).collect();
        scenario(Path::new("dir/a.xosc"), &Files(files), &Default::default())
    };
    read(text).expect("the hero is the ego");
    let alone = format!(
        "<OpenSCENARIO><FileHeader revMajor=\"1\" revMinor=\"1\"/><RoadNetwork><LogicFile filepath=\"road.xodr\"/></RoadNetwork>\
         <Entities><ScenarioObject name=\"Car\"><Vehicle name=\"v\" vehicleCategory=\"car\">{BOX}</Vehicle></ScenarioObject></Entities>\
         <Storyboard><Init><Actions>{}</Actions></Init><StopTrigger/></Storyboard></OpenSCENARIO>",
        private("Car", &[&place(-1, 10.0), &speed("step", "time", 0.0, 20.0)])
    );
    read(alone).expect("the only entity is the ego");
}

#[test]
fn catalogs_of_version_0_9_are_read_with_a_note() {
    let read = of_version("revMajor=\"0\" revMinor=\"9\"", &car()).expect("its entries are alike");
    let noted = "dir/cars/c.xosc: a catalog of version 0.9: its entries are read as those of 1.0";
    assert!(read.notices.iter().any(|notice| notice == noted), "{:?}", read.notices);
    let newer = of_version("revMajor=\"1\" revMinor=\"0\"", &car()).expect("it is supported");
    assert!(!newer.notices.iter().any(|notice| notice.contains("version")), "{:?}", newer.notices);
    let shown =
        of_version("revMajor=\"0\" revMinor=\"8\"", &car()).expect_err("too old").to_string();
    assert!(shown.starts_with("dir/cars/c.xosc:2:1: version 0.8"), "{shown}");
}

#[test]
fn a_box_without_a_size_is_assumed_and_one_with_half_a_size_refused() {
    let sized = |width: f64, length: f64| {
        car().replace("width=\"2\" length=\"4\"", &format!("width=\"{width}\" length=\"{length}\""))
    };
    let read = with_catalog(&sized(0.0, 0.0), "").expect("its size is unknown");
    let lead = read.script.entities.iter().find(|entity| entity.name == "Lead").expect("a lead");
    assert_eq!((lead.body.length_m, lead.body.width_m), (4.5, 1.8));
    let noted = "the bounding box has no size: 4.5 m by 1.8 m is assumed";
    assert!(read.notices.iter().any(|notice| notice.ends_with(noted)), "{:?}", read.notices);
    for (width, length, wrong) in [(0.0, 4.0, "width"), (2.0, 0.0, "length")] {
        let shown = with_catalog(&sized(width, length), "").expect_err("half a size").to_string();
        let expected = format!("attribute `{wrong}` of `Dimensions`: 0 is out of range");
        assert!(shown.contains(&expected), "{shown}");
    }
}

#[test]
fn the_user_may_name_the_ego() {
    let named = |name: &str| Parts { ego: Some(name.to_owned()), ..Parts::default() };
    let script = named("Lead").read().expect("it is there").script;
    assert_eq!(script.entities[script.ego].name, "Lead");
    let shown = named("Leed").refusal();
    assert!(shown.contains("`--ego Leed` names no entity, expected `Ego`, `Lead` or `Walker` (did you mean `Lead`?)"), "{shown}");
}

#[test]
fn a_speed_that_the_ego_must_reach_in_time_is_its_set_speed() {
    let init = private("Ego", &[&place(-1, 10.0), &speed("linear", "rate", 3.0, 25.0)])
        + &private("Lead", &[&place(-1, 60.0)]);
    let text = Parts { init, ..Parts::default() };
    let read = text.read().expect("the stack speeds up by itself");
    assert_eq!(read.set_speed_mps, Some(25.0));
    assert!(read.notices.iter().any(|notice| notice.contains("25 m/s is its set speed")));
    assert_eq!(Parts::default().read().expect("a step").set_speed_mps, None);
}

#[test]
fn an_entry_of_a_catalog_may_use_the_scenarios_parameters_with_a_note() {
    let text = |named: &str| {
        let declared = format!(
            "<ParameterDeclarations><ParameterDeclaration name=\"{named}\" parameterType=\"double\" value=\"7\"/></ParameterDeclarations>"
        );
        let head = "<CatalogLocations><ManeuverCatalog><Directory path=\"cars\"/></ManeuverCatalog></CatalogLocations>";
        let start = trigger(&[&at(1.0)]);
        let slow = event("E", "override", &[&speed("step", "time", 0.0, 5.0)], &start);
        let slow = slow.replace("value=\"5\"", "value=\"$v\"");
        let reference = "<CatalogReference catalogName=\"c\" entryName=\"slow\"/>";
        let stories = story(&[]).replace("<Maneuver name=\"Maneuver\"></Maneuver>", reference);
        let catalog = format!(
            "<OpenSCENARIO>\n<FileHeader revMajor=\"1\" revMinor=\"1\"/>\n<Catalog name=\"c\"><Maneuver name=\"slow\">{slow}</Maneuver></Catalog></OpenSCENARIO>"
        );
        let files = vec![("dir/cars/c.xosc".to_owned(), catalog)];
        Parts { parameters: declared, head: head.to_owned(), stories, files, ..Parts::default() }
    };
    let parts = text("v");
    let noted = "`slow` uses parameters of the scenario that it does not declare";
    let notices = parts.read().expect("the scenario has it").notices;
    assert!(notices.iter().any(|notice| notice.ends_with(noted)), "{notices:?}");
    assert_eq!(parts.run().to(1.5).lead().speed_mps, 7.0);
    let shown = text("w").refusal();
    assert!(
        shown.starts_with("dir/cars/c.xosc:3:") && shown.contains("parameter `v` is not"),
        "{shown}"
    );
}
