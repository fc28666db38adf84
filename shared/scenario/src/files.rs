//! The files behind a scenario: the scenario file itself, speed tables and roads in CSV.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::string::FromUtf8Error;

use super::Scenario;
use super::actor::Profile;
use super::document::{Document, MAX_TEXT_BYTES};
use super::error::ScenarioError;
use super::plan::{AlongRoad, DrivenLine, Lanes, Start};
use super::problem::Problem;
use super::recorded::{self, READING, RecordedError};
use super::road::{self, Heights};
use openscenario::xml::MAX_FILE_BYTES;

/// Reason why a text file is not read.
#[derive(Debug, thiserror::Error)]
pub(super) enum TextFileError {
    #[error("cannot be opened: {0}")]
    NotOpened(#[source] io::Error),
    #[error("is not a regular file")]
    Irregular,
    #[error("cannot be read: {0}")]
    NotRead(#[source] io::Error),
    #[error("is larger than {0} bytes")]
    TooLarge(usize),
    #[error("is not UTF-8 text (byte {})", .0.utf8_error().valid_up_to())]
    NotText(#[from] FromUtf8Error),
}

/// Longest text of a recorded motion, bytes.
pub(super) const MAX_RECORD_BYTES: usize = 64 << 20;

/// Reads a text file of at most `most` bytes.
pub(super) fn read(path: &Path, most: usize) -> Result<String, TextFileError> {
    // Looked at before it is opened: to open a pipe is to wait for its other end.
    if !path.metadata().map_err(TextFileError::NotOpened)?.is_file() {
        return Err(TextFileError::Irregular);
    }
    let file = File::open(path).map_err(TextFileError::NotOpened)?;
    let mut bytes = Vec::new();
    file.take(most as u64 + 1).read_to_end(&mut bytes).map_err(TextFileError::NotRead)?;
    if bytes.len() > most {
        return Err(TextFileError::TooLarge(most));
    }
    Ok(String::from_utf8(bytes)?)
}

/// Fills in what the scenario takes from files: the actors' recorded motions, the road. `own` is the scenario
/// file's directory. Returns remarks on the records.
pub(super) fn load(
    scenario: &mut Scenario,
    document: &Document<'_>,
    own: Option<&Path>,
) -> Result<Vec<String>, ScenarioError> {
    let mut notes = Vec::new();
    for (index, actor) in scenario.actors.iter_mut().enumerate() {
        let Profile::Csv(csv) = &mut actor.profile else { continue };
        let key = |key: &str| format!("actors.{index}.profile.csv.{key}");
        let is_set = is_set(document, &key("file"), &key("points"));
        let Some(path) = to_read(&csv.file, own, is_set, csv.points.is_empty()) else {
            let changed =
                READING.iter().map(|reading| key(reading)).find(|key| document.is_set(key));
            if let (Some(changed), false) = (changed, csv.points.is_empty()) {
                let problem = Problem::new(
                    changed,
                    "the record has been read already, and its points stand in the scenario",
                    "the key `file` set too, so that the file is read again",
                );
                return Err(document.problem(&problem));
            }
            continue;
        };
        if let Err(reason) = File::open(&path).map_err(TextFileError::NotOpened) {
            return Err(document.problem(&Problem::new(
                key("file"),
                format!("{} {reason}", path.display()),
                "a CSV file, an MCAP file or a ROS bag",
            )));
        }
        let record = recorded::read(&path, csv).map_err(|error| match error {
            RecordedError::Key { key: name, message, expected } => {
                document.problem(&Problem::new(key(name), message, expected))
            }
            RecordedError::File(error) => error,
        })?;
        record.expect_whole()?;
        let about = |note| format!("actor {}, {}: {note}", actor.name.as_str(), path.display());
        notes.extend(record.notes().into_iter().map(about));
        actor.leaves_at_s = match (actor.leaves_at_s, record.leaves_at_s) {
            (Some(own), Some(of_record)) if of_record < own => Some(of_record),
            (own, of_record) => own.or(of_record),
        };
        csv.points = record.points;
    }
    if let Heights::Csv { file, points } = &mut scenario.road.heights
        && let is_set = is_set(document, "road.csv", "road.points")
        && let Some(path) = to_read(file, own, is_set, points.is_empty())
    {
        let text = read(&path, MAX_TEXT_BYTES).map_err(|reason| {
            document.problem(&Problem::new(
                "road.csv",
                format!("{} {reason}", path.display()),
                "a CSV file with the columns distance_m and height_m or grade_percent",
            ))
        })?;
        let profile = road::parse_csv(&path.display().to_string(), &text)?;
        *points = road::points_of(&profile);
    }
    notes.extend(load_plan(scenario, document, own)?);
    Ok(notes)
}

/// Reads the OpenDRIVE file of a plan: the line that the ego drives along, its lanes and its heights. Returns notes on it.
fn load_plan(
    scenario: &mut Scenario,
    document: &Document<'_>,
    own: Option<&Path>,
) -> Result<Vec<String>, ScenarioError> {
    const FILE: &str = "road.plan.opendrive.file";
    let Some(plan) = &mut scenario.road.plan else { return Ok(Vec::new()) };
    let Some(opendrive) = &mut plan.opendrive else { return Ok(Vec::new()) };
    let is_set = is_set(document, FILE, "road.plan.opendrive.line");
    let Some(path) = to_read(&opendrive.file, own, is_set, opendrive.line.is_none()) else {
        return Ok(Vec::new());
    };
    let text = read(&path, MAX_FILE_BYTES).map_err(|reason| {
        let message = format!("{} {reason}", path.display());
        document.problem(&Problem::new(FILE, message, "an OpenDRIVE file"))
    })?;
    let lane = opendrive.read(&path, &text).map_err(|problem| document.problem(&problem))?;
    let heights = lane.road.heights_along(&lane.line).map_err(|error| {
        document.problem(&Problem::new(FILE, error.to_string(), error.expected()))
    })?;
    let lines = lane.road.lane_lines(&lane.line).map_err(|error| {
        document.problem(&Problem::new(FILE, error.to_string(), error.expected()))
    })?;
    opendrive.line = Some(DrivenLine(lane.line));
    if !document.has("road.plan.start") {
        plan.start = Start::of_pose(&lane.start);
    }
    if !document.has("road.plan.lanes") {
        let lanes = Lanes::beside(lane.beside, lane.width_m);
        plan.lanes = Lanes { along: AlongRoad(lines), ..lanes };
    }
    if scenario.road.is_level() && !heights.is_empty() {
        let points = road::points(&heights).map_err(|problem| document.problem(&problem))?;
        scenario.road.heights = Heights::Points(points);
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
    use crate::overrides::Overrides;

    #[test]
    fn a_directory_is_not_a_scenario() {
        assert!(matches!(read(Path::new("/"), MAX_TEXT_BYTES), Err(TextFileError::Irregular)));
    }

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
        overrides.set(&format!("road={{csv=\"{relative}\"}}")).expect("an option");
        let opened = Scenario::open("truck-hills", &overrides, &|_| Ok(Default::default()))
            .expect("a scenario");
        let Heights::Csv { points, .. } = &opened.road.heights else { panic!("{:?}", opened.road) };
        assert_eq!(points.len(), 2);
        let kept = directory.join("scenario.toml");
        let other = opened.to_toml().replace("400.0", "500.0");
        std::fs::write(&kept, other).expect("writable");
        let mut overrides = Overrides::new();
        overrides.set("road.csv=road.csv").expect("an option");
        let again =
            Scenario::open(&kept.to_string_lossy(), &overrides, &|_| Ok(Default::default()));
        let again = again.expect("a scenario").road.heights;
        let Heights::Csv { points: read, .. } = again else { panic!() };
        assert_eq!(&read, points);
        std::fs::write(directory.join("lead.csv"), "time_s,speed_mps\n0,20\n9,20\n")
            .expect("writable");
        let lead = format!("{up}{}", directory.join("lead.csv").display());
        let mut overrides = Overrides::new();
        overrides
            .set(&format!("actors[0].profile={{csv={{file=\"{lead}\"}}}}"))
            .expect("an option");
        let driven = Scenario::open("following", &overrides, &|_| Ok(Default::default()))
            .expect("a scenario");
        assert_eq!(driven.actors[0].profile.points().map(<[_]>::len), Some(2));
        std::fs::remove_dir_all(&directory).expect("ours");
    }
}
