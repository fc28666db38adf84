//! The files that a scenario names: recorded motions, roads in CSV and OpenDRIVE.

use std::path::{Path, PathBuf};

use openscenario::xml::MAX_FILE_BYTES;

use super::document::{Document, MAX_TEXT_BYTES};
use super::error::Refusal;
use super::problem::Problem;
use super::text_file::read;
use crate::Scenario;
use crate::actor::{Actor, Profile};
use crate::plan::{Lanes, Start};
use crate::recorded::{self, READING};
use crate::road;

/// Fills in what the scenario takes from files: the actors' recorded motions, the road. `own` is the scenario
/// file's directory. Returns remarks on the records.
pub(super) fn load(
    scenario: &mut Scenario,
    document: &Document<'_>,
    own: Option<&Path>,
) -> Result<Vec<String>, Refusal> {
    let mut notes = Vec::new();
    for (index, actor) in scenario.actors.iter_mut().enumerate() {
        notes.extend(load_record(actor, index, document, own)?);
    }
    let (road, is_set) = (&mut scenario.road, is_set(document, "road.csv", "road.points"));
    if let Some(file) = &road.csv
        && let Some(path) = to_read(file, own, is_set, road.points.is_empty())
    {
        let text = read(&path, MAX_TEXT_BYTES).map_err(|reason| {
            let message = format!("{} {reason}", path.display());
            let expected = "a CSV file with the columns distance_m and height_m or grade_percent";
            Problem::new("road.csv", message, expected)
        })?;
        let profile = road::parse_csv(&path.display().to_string(), &text)?;
        let heights = profile.points().iter().map(|point| [point.distance_m, point.height_m]);
        road.points = road::points(heights)?;
    }
    notes.extend(load_plan(scenario, document, own)?);
    let file = scenario.traffic.sumo.as_ref().and_then(|file| {
        let is_set = ["sumo", "ego"].iter().any(|key| document.is_set(&format!("traffic.{key}")));
        to_read(file, own, is_set, scenario.traffic.route.is_none())
    });
    notes.extend(crate::sumo_traffic::load(scenario, document, file.as_deref())?);
    Ok(notes)
}

/// Reads the recorded motion of an actor, if it has one. Returns remarks on it.
fn load_record(
    actor: &mut Actor,
    index: usize,
    document: &Document<'_>,
    own: Option<&Path>,
) -> Result<Vec<String>, Refusal> {
    let Profile::Csv(csv) = &mut actor.profile else { return Ok(Vec::new()) };
    let key = |key: &str| format!("actors.{index}.profile.csv.{key}");
    let is_set = is_set(document, &key("file"), &key("points"));
    let Some(path) = to_read(&csv.file, own, is_set, csv.points.is_empty()) else {
        let changed = READING.iter().map(|reading| key(reading)).find(|key| document.is_set(key));
        return match changed.filter(|_| !csv.points.is_empty()) {
            None => Ok(Vec::new()),
            Some(changed) => Err(Problem::new(
                changed,
                "the record has been read already, and its points stand in the scenario",
                "the key `file` set too, so that the file is read again",
            )
            .into()),
        };
    };
    if let Err(reason) = std::fs::File::open(&path) {
        let message = format!("{} cannot be opened: {reason}", path.display());
        let expected = "a CSV file, an MCAP file or a ROS bag";
        return Err(Problem::new(key("file"), message, expected).into());
    }
    let record = recorded::read(&path, csv).map_err(|refusal| match refusal {
        Refusal::Key(problem) => Problem { path: key(&problem.path), ..problem }.into(),
        file => file,
    })?;
    record.expect_whole()?;
    let leaves = [actor.leaves_at_s, record.leaves_at_s].into_iter().flatten();
    actor.leaves_at_s =
        leaves.reduce(|own, of_record| if of_record < own { of_record } else { own });
    let about = |note| format!("actor {}, {}: {note}", actor.name.as_str(), path.display());
    let notes = record.notes().into_iter().map(about).collect();
    csv.points = record.points;
    Ok(notes)
}

/// Reads the OpenDRIVE file of a plan: the line that the ego drives along, its lanes and its heights. Returns notes on it.
fn load_plan(
    scenario: &mut Scenario,
    document: &Document<'_>,
    own: Option<&Path>,
) -> Result<Vec<String>, Refusal> {
    const FILE: &str = "road.plan.opendrive.file";
    let Some(plan) = &mut scenario.road.plan else { return Ok(Vec::new()) };
    let Some(opendrive) = &mut plan.opendrive else { return Ok(Vec::new()) };
    let is_set = is_set(document, FILE, "road.plan.opendrive.line");
    let Some(path) = to_read(&opendrive.file, own, is_set, opendrive.line.is_none()) else {
        return Ok(Vec::new());
    };
    let text = read(&path, MAX_FILE_BYTES).map_err(|reason| {
        Problem::new(FILE, format!("{} {reason}", path.display()), "an OpenDRIVE file")
    })?;
    let lane = opendrive.read(&path, &text)?;
    let refuse = |error| Problem::of_axis(FILE, &error);
    let heights = lane.road.heights_along(&lane.line).map_err(refuse)?;
    let lines = lane.road.lane_lines(&lane.line).map_err(refuse)?;
    opendrive.line = Some(lane.line);
    if !document.has("road.plan.start") {
        plan.start = Start::of_pose(&lane.start);
    }
    if !document.has("road.plan.lanes") {
        let lanes = Lanes::beside(lane.beside, lane.width_m);
        plan.lanes = Lanes { along: lines, ..lanes };
    }
    if scenario.road.is_level() && !heights.is_empty() {
        scenario.road.points = road::points(heights)?;
    }
    Ok(lane.notices)
}

/// True if the command line set a file without its points. The points in the scenario are then another file's.
fn is_set(document: &Document<'_>, file: &str, points: &str) -> bool {
    document.is_set(file) && !document.is_set(points)
}

/// Path of a file that has to be read. A relative path starts at the directory `own`. One that the command line set
/// starts at the present directory, unless that file is in `own`.
fn to_read(file: &Path, own: Option<&Path>, is_set: bool, is_unread: bool) -> Option<PathBuf> {
    let beside = own.map(|own| own.join(file));
    match is_set {
        true => Some(beside.filter(|path| path.is_file()).unwrap_or_else(|| file.to_owned())),
        false => beside.filter(|_| is_unread),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Overrides;

    /// Also over a built-in scenario, which has no directory, and in the place of another file's points.
    #[test]
    fn a_file_that_is_set_on_the_command_line_is_read_from_the_present_directory() {
        let here = std::env::current_dir().expect("it is there");
        let directory = std::env::temp_dir().join(format!("timegap-set-{}", std::process::id()));
        std::fs::create_dir_all(&directory).expect("writable");
        std::fs::write(directory.join("road.csv"), "distance_m,height_m\n0,0\n400,4\n")
            .expect("writable");
        let up = "../".repeat(here.components().count());
        let relative = format!("{up}{}", directory.join("road.csv").display());
        let mut overrides = Overrides::new();
        overrides.set(crate::Setting::new("road", crate::table! { csv: relative }));
        let opened = Scenario::open("truck-hills", &overrides, &|_| Ok(Default::default()))
            .expect("a scenario");
        let points = &opened.road.points;
        assert_eq!(points.len(), 2);
        let kept = directory.join("scenario.toml");
        let other = opened.to_toml().replace("400.0", "500.0");
        std::fs::write(&kept, other).expect("writable");
        let mut overrides = Overrides::new();
        overrides.set("road.csv=road.csv".parse().expect("a setting"));
        let again =
            Scenario::open(&kept.to_string_lossy(), &overrides, &|_| Ok(Default::default()));
        assert_eq!(&again.expect("a scenario").road.points, points);
        std::fs::write(directory.join("lead.csv"), "time_s,speed_mps\n0,20\n9,20\n")
            .expect("writable");
        let lead = format!("{up}{}", directory.join("lead.csv").display());
        let mut overrides = Overrides::new();
        let csv = crate::table! { csv: crate::table! { file: lead } };
        overrides.set(crate::Setting::new("actors[0].profile", csv));
        let driven = Scenario::open("following", &overrides, &|_| Ok(Default::default()))
            .expect("a scenario");
        assert_eq!(driven.actors[0].profile.points().map(<[_]>::len), Some(2));
        std::fs::remove_dir_all(&directory).expect("ours");
    }
}
