//! Translation of an OpenSCENARIO file into the keys of a scenario.
//!
//! The ego is this program's own. Its place, its speed and its extent come from the file, its control from
//! `[controller]`. Every other entity is an actor with the profile `storyboard`.

use std::path::{Path, PathBuf};

use openscenario::model::condition::{Condition, Test, Trigger};
use openscenario::model::{Drive, Script};
use openscenario::read;
use openscenario::world::{Extent, Way};
use openscenario::{Choices, Disk, Rule, Spot, World, WorldError};
use road::AxisError;

use crate::actor::MAX_ACTORS;
use crate::plan::{Lanes, OpendriveRoad, Plan, Start};
use crate::plant::Plant;
use crate::quantity::{Distance, LaneId};
use crate::reading::Foreign;
use crate::storyboard::Storyboard;
use crate::{SCHEMA_VERSION, ScenarioError, Table, Value, table};

/// Duration of a run whose storyboard has no end in time, s.
pub const DEFAULT_DURATION_S: f64 = 300.0;
/// Longest line of prose that a scenario takes, characters.
const MAX_LINE: usize = 500;
/// Shortest extent of an actor along the road, m.
const MIN_LENGTH_M: f64 = 0.1;

/// Reads an OpenSCENARIO file: the keys of the scenario that runs it, and its storyboard.
pub(crate) fn translated(
    path: &Path,
    choices: &Choices,
) -> Result<(Foreign, Storyboard), ScenarioError> {
    let file = path.display().to_string();
    let read = read::scenario(path, &Disk, choices).map_err(|e| ScenarioError::whole_of(&e))?;
    let (script, spots) = (read.script, read.spots);
    let place_of = |spot: Spot| format!("{file}:{spot}");
    let world = World::new(script.clone()).map_err(|cause| {
        let entity = cause.entity().and_then(|name| script.entity(name));
        let place = entity.map_or(file.clone(), |entity| place_of(spots.starts[entity]));
        ScenarioError::whole(&place, cause.to_string())
    })?;
    if let Some(index) = overlaps_the_ego(&script, &world) {
        let (place, entity) = (place_of(spots.starts[index]), script.entities[index].name.clone());
        let reason = "cannot be placed: it overlaps the ego at the start".to_owned();
        let cause = WorldError::Start { entity, reason };
        return Err(ScenarioError::whole(&place, cause.to_string()));
    }
    let count = script.entities.len() - 1;
    if count > MAX_ACTORS {
        return Err(ScenarioError::whole(&file, format!("{count} entities beside the ego"))
            .expecting(format!("at most {MAX_ACTORS}")));
    }
    let (road, way) = road_of(&script, &world).map_err(|cause| {
        let place = place_of(spots.starts[script.ego]);
        ScenarioError::whole(&place, format!("the ego's way: {cause}")).expecting(cause.expected())
    })?;
    let printable = read.description.chars().filter(|c| !c.is_control());
    let ego_mps = world.motion(script.ego).speed_mps;
    let mut plant = table! {
        initial_speed_mps: ego_mps,
        length_m: script.entities[script.ego].body.length_m,
    };
    if read.friction != 1.0 {
        let usual_mps2 = Plant::default().min_acceleration_mps2.value();
        plant.insert("min_acceleration_mps2".to_owned(), (read.friction * usual_mps2).into());
    }
    let mut keys = table! {
        schema_version: SCHEMA_VERSION,
        name: word(path.file_stem().and_then(|stem| stem.to_str()), "scenario"),
        description: printable.take(MAX_LINE).collect::<String>(),
        duration_s: ends_after(&script).unwrap_or(DEFAULT_DURATION_S),
        set_speed_mps: read.set_speed_mps.unwrap_or(ego_mps),
        plant: plant,
        actors: actors_of(&script, &world, way.as_ref()),
    };
    if !road.is_empty() {
        keys.insert("road".to_owned(), Value::Table(road));
    }
    let mut keys = Foreign::new(&file, keys);
    if let Some(spot) = spots.stop {
        keys.come_from("duration_s", &place_of(spot), "the `StopTrigger`");
    }
    let mut entities = vec![(script.ego, "plant".to_owned())];
    let actors = scripted(&script).enumerate();
    entities.extend(actors.map(|(number, entity)| (entity, format!("actors.{number}"))));
    for (entity, path) in entities {
        let name = &script.entities[entity].name;
        let (place, what) = (place_of(spots.starts[entity]), format!("`{name}` in Init"));
        if entity == script.ego {
            keys.come_from("set_speed_mps", &place, &what);
            keys.come_from("road", &place, &what);
        }
        let declared = place_of(spots.entities[entity]);
        keys.come_from(format!("{path}.length_m"), &declared, &format!("`{name}`"));
        keys.come_from(path, &place, &what);
    }
    let notices = super::start_notices::of(&script, &world, read.headings);
    let storyboard = Storyboard {
        source: file,
        hindrance: read.hindrance,
        notices: read.notices.into_iter().chain(notices).collect(),
        parameters: read.parameters.into_iter().collect(),
        script,
    };
    Ok((keys, storyboard))
}

/// The actors: the entities that the storyboard moves, each with a name of its own.
fn actors_of(script: &Script, world: &World, way: Option<&Way>) -> Vec<Table> {
    let mut names: Vec<String> = Vec::new();
    let actor = |index: usize| {
        let mut name = word(Some(&script.entities[index].name), "actor");
        if names.contains(&name) {
            name = format!("{}-{index}", name.chars().take(60).collect::<String>());
        }
        names.push(name.clone());
        let (gap_m, length_m) = place_of_actor(script, world, index, way);
        let initial_speed_mps = world.motion(index).speed_mps;
        table! {
            name: name,
            gap_m: gap_m,
            initial_speed_mps: initial_speed_mps,
            length_m: length_m,
            profile: "storyboard",
        }
    };
    scripted(script).map(actor).collect()
}

/// The keys of the road along the line on which the ego begins: its course, if it has curves, and its heights. With them
/// comes the line itself, if it has curves.
fn road_of(script: &Script, world: &World) -> Result<(Table, Option<Way>), AxisError> {
    let (start, extent) = (world.motion(script.ego), world.extent(script.ego));
    let (road, is_curved) = (&script.roads[start.row], !world.is_straight());
    let none = || (Table::new(), None);
    if !start.present || (!is_curved && road.steepest_slope() == 0.0) {
        return Ok(none());
    }
    let direction = start.direction();
    let front_s_m = extent.front_s_m(direction);
    let middle_t_m = 0.5 * (extent.from_t_m + extent.to_t_m);
    let Some(lane) = road.lane_at(front_s_m, middle_t_m) else { return Ok(none()) };
    let line = road.driven(&lane, front_s_m, middle_t_m - lane.center_m, direction);
    let points = road.heights_along(&line)?;
    let lines = road.lane_lines(&line)?;
    let way = Way::of(world, &line)?;
    let mut keys = Table::new();
    if !points.is_empty() {
        let points: Vec<_> = points.into_iter().map(|point| point.to_vec()).collect();
        keys.insert("points".to_owned(), points.into());
    }
    if !is_curved {
        return Ok((keys, None));
    }
    let opendrive = OpendriveRoad {
        file: PathBuf::from("the storyboard's road"),
        road: road.part_at(front_s_m).id.clone(),
        lane: LaneId::try_from(i64::from(lane.id)).unwrap_or(LaneId::of(0)),
        s_m: Distance::try_from(front_s_m).unwrap_or(Distance::of(0.0)),
        line: Some(line),
        of_storyboard: true,
    };
    let start = Start::of_pose(&way.start.placed(&script.roads[0].start()));
    let lanes = Lanes::beside(road.neighbours(&lane, front_s_m), lane.width_m);
    let lanes = Lanes { along: lines, ..lanes };
    let mut plan = Plan::default();
    (plan.opendrive, plan.start, plan.lanes) = (Some(opendrive), start, lanes);
    let plan = Value::try_from(plan).expect("a plan has a form in TOML");
    keys.insert("plan".to_owned(), plan);
    Ok((keys, Some(way)))
}

/// The first entity whose body lies in the ego's at the start.
fn overlaps_the_ego(script: &Script, world: &World) -> Option<usize> {
    let (ego, has_place) = (script.ego, |index: &usize| world.motion(*index).present);
    let others = (0..script.entities.len()).filter(|&index| index != ego).filter(has_place);
    let mut touching = others.filter(|&index| world.touch(index, ego));
    touching.next().filter(|_| has_place(&ego))
}

/// The entities that the storyboard moves.
fn scripted(script: &Script) -> impl Iterator<Item = usize> {
    let is_scripted = |&index: &usize| script.entities[index].drive == Drive::Scripted;
    (0..script.entities.len()).filter(is_scripted)
}

/// The gap to the ego's front and the length of an entity that the storyboard moves, m, at the start: along `way`, or
/// without one along the road.
fn place_of_actor(script: &Script, world: &World, index: usize, way: Option<&Way>) -> (f64, f64) {
    let (ego, extent) = (world.extent(script.ego), world.extent(index));
    if !world.motion(index).present {
        return (0.0, script.entities[index].body.length_m.max(MIN_LENGTH_M));
    }
    let gap_m = match world.motion(script.ego).direction() > 0.0 {
        true => extent.from_s_m - ego.to_s_m,
        false => ego.from_s_m - extent.to_s_m,
    };
    let extent = way.map_or(extent, |way| {
        Extent::of(&script.entities[index].body, &way.along(world, index, gap_m))
    });
    let gap_m = if way.is_some() { extent.from_s_m } else { gap_m };
    (gap_m.max(0.0), (extent.to_s_m - extent.from_s_m).max(MIN_LENGTH_M))
}

/// A text as a scenario's name: its letters, digits, `-` and `_`.
pub(crate) fn word(text: Option<&str>, otherwise: &str) -> String {
    let good = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let word: String =
        text.unwrap_or_default().chars().map(|c| if good(c) { c } else { '-' }).take(64).collect();
    if word.is_empty() { otherwise.to_owned() } else { word }
}

/// Time after which a storyboard has ended in any case. A group of its stop trigger asks only that this time has
/// passed.
fn ends_after(script: &Script) -> Option<f64> {
    let Trigger(groups) = script.stop.as_ref()?;
    let passes = |condition: &Condition| match condition.test {
        Test::Time { rule: Rule::GreaterThan | Rule::GreaterOrEqual, value } => {
            Some(value + condition.delay_ns as f64 * 1e-9)
        }
        _ => None,
    };
    let after = |group: &Vec<Condition>| {
        group.iter().map(passes).try_fold(0.0, |most: f64, at| Some(most.max(at?)))
    };
    groups.iter().filter(|group| !group.is_empty()).filter_map(after).min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scenario;
    use openscenario::Assignment;
    use openscenario::model::condition::Edge;

    fn at(value: f64, delay_s: f64) -> Condition {
        let test = Test::Time { rule: Rule::GreaterOrEqual, value };
        Condition { edge: Edge::Rising, delay_ns: (delay_s * 1e9) as u64, test }
    }

    #[test]
    fn the_end_in_time_is_the_earliest_that_nothing_else_is_asked_for() {
        let mut script = Script {
            roads: vec![openscenario::road::Road::assumed()],
            ego: 0,
            entities: Vec::new(),
            values: Vec::new(),
            init: Vec::new(),
            stories: Vec::new(),
            stop: None,
        };
        assert_eq!(ends_after(&script), None);
        let value = Condition {
            test: Test::Value {
                of: 0,
                rule: Rule::EqualTo,
                value: openscenario::Value::Number(1.0),
            },
            ..at(0.0, 0.0)
        };
        script.stop = Some(Trigger(vec![vec![at(1.0, 0.0), value], Vec::new()]));
        assert_eq!(ends_after(&script), None);
        let groups = &mut script.stop.as_mut().expect("it is there").0;
        groups.push(vec![at(20.0, 2.5), at(3.0, 0.0)]);
        groups.push(vec![at(40.0, 0.0)]);
        assert_eq!(ends_after(&script), Some(22.5));
    }

    #[test]
    fn places_near_the_end_of_a_curve_are_measured_along_the_egos_lane() {
        const ROAD: &str = r#"<OpenDRIVE><road id="2" length="30" junction="-1"><planView>
            <geometry s="0" x="0" y="0" hdg="0" length="30"><arc curvature="-0.03"/></geometry></planView>
            <lanes><laneSection s="0"><right><lane id="-1" type="driving">
            <width sOffset="0" a="3" b="0" c="0" d="0"/></lane></right></laneSection></lanes></road></OpenDRIVE>"#;
        let object = |name: &str, kind: &str, length: f64| {
            format!(
                "<ScenarioObject name=\"{name}\">{kind}<BoundingBox><Center x=\"0\" y=\"0\" z=\"0\"/>\
                 <Dimensions length=\"{length}\" width=\"0.2\" height=\"1\"/></BoundingBox></{}></ScenarioObject>",
                kind[1..].split(' ').next().expect("a name")
            )
        };
        let place = |name: &str, position: &str| {
            format!(
                "<Private entityRef=\"{name}\"><PrivateAction><TeleportAction><Position>{position}</Position>\
                 </TeleportAction></PrivateAction></Private>"
            )
        };
        let text = format!(
            "<OpenSCENARIO><FileHeader revMajor=\"1\" revMinor=\"2\" description=\"a\"/>\
             <RoadNetwork><LogicFile filepath=\"a.xodr\"/></RoadNetwork><Entities>{}{}</Entities>\
             <Storyboard><Init><Actions>{}{}</Actions></Init><StopTrigger/></Storyboard></OpenSCENARIO>",
            object("Ego", "<Vehicle name=\"e\" vehicleCategory=\"car\">", 4.0),
            object(
                "Post",
                "<MiscObject name=\"m\" miscObjectCategory=\"obstacle\" mass=\"1\">",
                0.1
            ),
            place("Ego", "<LanePosition roadId=\"2\" laneId=\"-1\" s=\"3\"/>"),
            place("Post", "<RoadPosition roadId=\"2\" s=\"29.325\" t=\"0\"/>"),
        );
        let folder = std::env::temp_dir().join(format!("timegap-near-end-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("ours");
        std::fs::write(folder.join("a.xodr"), ROAD).expect("ours");
        std::fs::write(folder.join("a.xosc"), text).expect("ours");
        let all = |_: &Scenario| Ok(Default::default());
        let (path, choices) = (folder.join("a.xosc"), Choices::default());
        let read = Scenario::open_openscenario(&path, &choices, &Default::default(), &all);
        std::fs::remove_dir_all(&folder).expect("ours");
        let scenario = read.unwrap_or_else(|error| panic!("{error}"));
        // From the ego's front at s = 5 m, on the lane's radius, 1.5 m inside.
        let gap_m = (29.325 - 5.0) * (1.0 - 0.03 * 1.5) - 0.05;
        let found_m = scenario.actors[0].gap_m.value();
        assert!((found_m - gap_m).abs() < 0.01, "{found_m} {gap_m}");
    }

    #[test]
    fn the_friction_of_init_is_a_factor_of_the_egos_strongest_deceleration() {
        let examples = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/openscenario");
        let text = std::fs::read_to_string(format!("{examples}/cut_in.xosc")).expect("an example");
        let road = "<Actions><GlobalAction><EnvironmentAction><Environment name=\"e\">\
                    <RoadCondition frictionScaleFactor=\"0.4\"/></Environment></EnvironmentAction></GlobalAction>";
        let text = text.replacen("<Actions>", road, 1).replace("\"./", &format!("\"{examples}/"));
        let file =
            std::env::temp_dir().join(format!("timegap-slippery-{}.xosc", std::process::id()));
        std::fs::write(&file, text).expect("ours");
        let all = |_: &Scenario| Ok(Default::default());
        let read =
            Scenario::open_openscenario(&file, &Choices::default(), &Default::default(), &all);
        std::fs::remove_file(&file).expect("ours");
        let found_mps2 = read.unwrap_or_else(|error| panic!("{error}")).plant.min_acceleration_mps2;
        let usual_mps2 = Plant::default().min_acceleration_mps2.value();
        assert_eq!(found_mps2.value(), 0.4 * usual_mps2);
    }

    #[test]
    fn names_become_words() {
        assert_eq!(word(Some("Lead vehicle 1"), "x"), "Lead-vehicle-1");
        assert_eq!(word(Some(""), "x"), "x");
    }

    #[test]
    fn an_error_names_the_place_in_the_openscenario_file() {
        const FILE: &str = "crossing_pedestrian.xosc";
        let directory = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/openscenario");
        let path = Path::new(directory).join(FILE);
        let assigned = Assignment { name: "Ego_Speed_mps".to_owned(), value: "200".to_owned() };
        let choices = Choices { assigned: vec![assigned], ..Choices::default() };
        let said = Scenario::open_openscenario(&path, &choices, &Default::default(), &|_| {
            Ok(Default::default())
        })
        .expect_err("too fast")
        .to_string();
        let place = format!(
            "{FILE}:30:9: `Ego` in Init makes a scenario with initial_speed_mps = 200.0: 200 is out of range, expected "
        );
        assert!(said.contains(&place), "{said}");
    }

    #[test]
    fn an_option_that_leaves_no_actors_is_named() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/openscenario/cut_in.xosc");
        let mut overrides = crate::Overrides::new();
        overrides.set("actors=[]".parse().expect("an option"));
        let choices = Choices::default();
        let said = Scenario::open_openscenario(Path::new(path), &choices, &overrides, &|_| {
            Ok(Default::default())
        })
        .expect_err("the storyboard moves one")
        .to_string();
        assert!(said.starts_with("error: --set actors=[]: 1 entities for 0 of 0 actors"), "{said}");
    }
}
