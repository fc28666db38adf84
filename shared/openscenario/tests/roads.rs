//! Roads of our own, read and evaluated, against CARLA's reader and against pyclothoids and scipy: `roads/roads.py`
//! makes the tables. Public files are compared too if `OPENDRIVE_FILES` names a folder with them. `OPENDRIVE_TABLE` and
//! `OPENDRIVE_LINES` name the tables that the script printed: of lane middles by CARLA, of lines by the libraries.

use openscenario::road::{Found, read};
use openscenario::xml;
use std::collections::BTreeMap;
use std::path::Path;

/// Largest distance from the oracle, m. CARLA computes in single precision.
const TOLERANCE_M: f64 = 1e-3;
/// Steps along a lane's own axis, m.
const STEP_M: f64 = 7.3;

fn row(file: &str, text: &str, road: &str) -> Result<Found, Box<openscenario::ReadError>> {
    Ok(read(&xml::parse(file, text)?, Some(road))?)
}

/// Distances of lane middles from a table, m, by file.
fn deviations(
    table: &str,
    text_of: impl Fn(&str) -> Option<String>,
) -> BTreeMap<String, (usize, f64)> {
    let mut worst: BTreeMap<String, (usize, f64)> = BTreeMap::new();
    let mut roads: BTreeMap<(String, String), _> = BTreeMap::new();
    for line in table.lines() {
        let fields: Vec<&str> = line.split(',').collect();
        let [file, id, lane] = [fields[0], fields[1], fields[2]];
        let number = |i: usize| fields[i].parse::<f64>().expect("a number");
        let road = roads.entry((file.to_owned(), id.to_owned())).or_insert_with(|| {
            let found = row(file, &text_of(file)?, id);
            let found =
                found.inspect_err(|error| println!("road {id} is refused: {error}")).ok()?;
            let axis =
                road::Axis::laid(&found.road.pieces, road::MIN_RADIUS_M).expect("it was read");
            Some((found.road, axis))
        });
        let Some((road, axis)) = road else { continue };
        let part = road.part(id).expect("the road was asked for");
        let (s_m, _) = part.place(number(3), 0.0);
        let lane = road.lane(s_m, lane.parse().expect("an id")).expect("the lane is there");
        let at = axis.point(s_m, lane.center_m).placed(&road.start());
        let away_m = (at.x_m - number(4)).hypot(at.y_m - number(5));
        let entry = worst.entry(file.to_owned()).or_default();
        *entry = (entry.0 + 1, entry.1.max(away_m));
    }
    worst
}

/// Distances of the reference lines and the lanes' lines from a table, m, by file. They are points, worst, and the
/// place of the worst.
fn lines_apart(
    table: &str,
    text_of: impl Fn(&str) -> Option<String>,
) -> BTreeMap<String, (usize, f64, String)> {
    let mut worst: BTreeMap<String, (usize, f64, String)> = BTreeMap::new();
    let mut roads: BTreeMap<(String, String), _> = BTreeMap::new();
    for line in table.lines() {
        let fields: Vec<&str> = line.split(',').collect();
        let [file, id, which] = [fields[0], fields[1], fields[2]];
        let number = |i: usize| fields[i].parse::<f64>().expect("a number");
        let road = roads.entry((file.to_owned(), id.to_owned())).or_insert_with(|| {
            let found = row(file, &text_of(file)?, id).ok()?;
            let axis =
                road::Axis::laid(&found.road.pieces, road::MIN_RADIUS_M).expect("it was read");
            Some((found.road, axis))
        });
        let Some((road, axis)) = road else { continue };
        let (s_m, _) = road.part(id).expect("the road was asked for").place(number(3), 0.0);
        // A lane's outer line; the line of lane 0 is the inner one of a lane beside it.
        let edge = |id: i32, outwards: f64| {
            let strip = road.lane(s_m, id)?;
            let to_left = if strip.is_left { outwards } else { -outwards };
            Some(strip.center_m + to_left * 0.5 * strip.width_m)
        };
        let t_m = match which {
            "r" => Some(0.0),
            "0" => edge(-1, -1.0).or_else(|| edge(1, -1.0)),
            _ => edge(which.parse().expect("an id"), 1.0),
        };
        let at = axis.point(s_m, t_m.expect("the lane is there")).placed(&road.start());
        let away_m = (at.x_m - number(4)).hypot(at.y_m - number(5));
        let entry = worst.entry(file.to_owned()).or_default();
        entry.0 += 1;
        if away_m > entry.1 {
            (entry.1, entry.2) = (away_m, line.to_owned());
        }
    }
    worst
}

fn own() -> String {
    include_str!("roads/own.xodr").to_owned()
}

#[test]
fn reference_and_lane_lines_lie_where_other_libraries_have_them() {
    let worst = lines_apart(include_str!("roads/lines.csv"), |_| Some(own()));
    println!("{worst:?}");
    let (points, away_m, _) = &worst["own.xodr"];
    assert!(*points == 324 && *away_m < TOLERANCE_M, "{worst:?}");
}

#[test]
fn lanes_of_roads_in_a_row_lie_where_another_reader_has_them() {
    let worst = deviations(include_str!("roads/lanes.csv"), |_| Some(own()));
    println!("{worst:?}");
    let (points, away_m) = worst["own.xodr"];
    assert!(points > 190 && away_m < TOLERANCE_M, "{points} points, {away_m} m");
}

#[test]
fn roads_in_a_row_are_one_road() {
    let found = row("own.xodr", &own(), "1").expect("three roads");
    let road = found.road;
    let parts: Vec<(&str, bool)> = road.parts.iter().map(|p| (p.id.as_str(), p.reversed)).collect();
    assert_eq!(parts, [("1", false), ("2", true), ("3", false)]);
    // Lane -1 of the first is lane 1 of the second, which lies to the right of the row. It is lane -1 again after it.
    let lane = road.lane(10.0, -1).expect("it is there");
    let center = road.lanes.center(0, lane.index);
    let ids =
        [10.0, 200.0, 340.0, road.parts[1].from_m + 5.0, road.parts[2].from_m + 5.0].map(|s_m| {
            let lane = road.lane_at(s_m, center.at(s_m)).expect("a lane");
            assert!((lane.center_m - center.at(s_m)).abs() < 1e-9, "{s_m}: {lane:?}");
            assert_eq!(road.direction(&lane), 1.0);
            lane.id
        });
    assert_eq!(ids, [-1, -1, -1, 1, -1]);
    let axis = road::Axis::laid(&road.pieces, road::MIN_RADIUS_M).expect("an axis");
    let (end_m, first) = (road.length_m.expect("it ends"), road.parts[0].length_m);
    let leg = road::Leg { axis, start: road::Pose::default(), from_m: 0.0, shift_m: 0.0 };
    let beside =
        road::Leg::beside(std::slice::from_ref(&leg), &center, (0.0, end_m), road::MIN_RADIUS_M);
    let (axis, (lane_axis, start)) = (leg.axis, beside.expect("the lane has no kink"));
    // A place of the lane is found on the reference line, in the lane's middle.
    let mut p_m = 0.0;
    while p_m < lane_axis.length_m() {
        let at = lane_axis.pose(p_m).placed(&start);
        let (s_m, t_m) = axis.nearest(at.x_m, at.y_m);
        assert!((t_m - center.at(s_m)).abs() < 1e-4, "{p_m}: {t_m} {}", center.at(s_m));
        p_m += STEP_M;
    }
    assert!((road.heights.at(first) - road.heights.at(first - 1e-6)).abs() < 10.0);
    // Another road of the row gives the same row.
    for id in ["2", "3"] {
        let other = row("own.xodr", &own(), id).expect("three roads").road;
        assert_eq!(other.parts.len(), 3);
        assert!((other.length_m.expect("it ends") - end_m).abs() < 1e-9);
    }
}

#[test]
#[ignore = "reads public files: OPENDRIVE_FILES names their folder"]
fn public_files_agree_with_another_reader() {
    let folder = std::env::var("OPENDRIVE_FILES").expect("OPENDRIVE_FILES names a folder");
    let mut files = 0;
    for entry in std::fs::read_dir(&folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|end| end != "xodr") {
            continue;
        }
        let name = path.file_name().expect("a file").to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).expect("a text");
        files += 1;
        match read(&xml::parse(&name, &text).expect("it is well-formed"), None) {
            Ok(found) => println!(
                "{name}: {:?} m, {} parts, {:?}",
                found.road.length_m,
                found.road.parts.len(),
                found.notices
            ),
            Err(error) => println!("{name}: refused: {error}"),
        }
    }
    assert!(files > 0, "no .xodr file in {folder}");
    let text_of = |file: &str| std::fs::read_to_string(Path::new(&folder).join(file)).ok();
    if let Ok(table) = std::env::var("OPENDRIVE_LINES") {
        let worst = lines_apart(&std::fs::read_to_string(table).expect("the table"), text_of);
        println!("lines {worst:#?}");
        assert!(worst.values().all(|(_, away_m, _)| *away_m < TOLERANCE_M), "{worst:?}");
    }
    // Each road by its id: ways through junctions too.
    let Ok(table) = std::env::var("OPENDRIVE_TABLE") else { return };
    let table = std::fs::read_to_string(table).expect("the table");
    let worst = deviations(&table, text_of);
    println!("{worst:#?}");
    assert!(worst.values().all(|(_, away_m)| *away_m < 2.5e-3), "{worst:?}");
}
