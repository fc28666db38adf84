//! The files behind a scenario: the scenario file itself, speed tables and roads in CSV.

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::string::FromUtf8Error;

use super::Scenario;
use super::actor::{MAX_PROFILE_POINTS, Profile};
use super::document::{Document, MAX_TEXT_BYTES};
use super::error::ScenarioError;
use super::problem::Problem;
use super::quantity::{Speed, Time};
use super::road::{self, Road};
use super::speeds::SpeedPoint;
use super::table::Table;

/// Why a text file is not read.
#[derive(Debug, thiserror::Error)]
pub(super) enum TextFileError {
    #[error("cannot be opened: {0}")]
    NotOpened(#[source] io::Error),
    #[error("is not a regular file")]
    Irregular,
    #[error("cannot be read: {0}")]
    NotRead(#[source] io::Error),
    #[error("is larger than {MAX_TEXT_BYTES} bytes")]
    TooLarge,
    #[error("is not UTF-8 text (byte {})", .0.utf8_error().valid_up_to())]
    NotText(#[from] FromUtf8Error),
}

/// Reads a text file of at most [`MAX_TEXT_BYTES`].
pub(super) fn read(path: &Path) -> Result<String, TextFileError> {
    // Looked at before it is opened: to open a pipe is to wait for its other end.
    if !path.metadata().map_err(TextFileError::NotOpened)?.is_file() {
        return Err(TextFileError::Irregular);
    }
    let file = File::open(path).map_err(TextFileError::NotOpened)?;
    let mut bytes = Vec::new();
    file.take(MAX_TEXT_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(TextFileError::NotRead)?;
    if bytes.len() > MAX_TEXT_BYTES {
        return Err(TextFileError::TooLarge);
    }
    Ok(String::from_utf8(bytes)?)
}

/// Fills in what the scenario takes from files: the actors' speed tables, the road. `own` is the scenario
/// file's directory.
pub(super) fn load(
    scenario: &mut Scenario,
    document: &Document<'_>,
    own: Option<&Path>,
) -> Result<(), ScenarioError> {
    for (index, actor) in scenario.actors.iter_mut().enumerate() {
        let Profile::Csv(csv) = &mut actor.profile else { continue };
        let key = format!("actors.{index}.profile.csv.file");
        let is_set = is_set(document, &key, &format!("actors.{index}.profile.csv.points"));
        let Some(path) = to_read(&csv.file, own, is_set, csv.points.is_empty()) else { continue };
        let text = read(&path).map_err(|reason| {
            document.problem(&Problem::new(
                key,
                format!("{} {reason}", path.display()),
                "a CSV file with the columns time_s and speed_mps",
            ))
        })?;
        csv.points = parse_csv(&path.display().to_string(), &text)?;
    }
    if let Road::Csv { file, points } = &mut scenario.road
        && let is_set = is_set(document, "road.csv", "road.points")
        && let Some(path) = to_read(file, own, is_set, points.is_empty())
    {
        let text = read(&path).map_err(|reason| {
            document.problem(&Problem::new(
                "road.csv",
                format!("{} {reason}", path.display()),
                "a CSV file with the columns distance_m and height_m or grade_percent",
            ))
        })?;
        let profile = road::parse_csv(&path.display().to_string(), &text)?;
        *points = road::points_of(&profile);
    }
    Ok(())
}

/// Whether a file was set on the command line, and its points were not: those that are there are another's.
fn is_set(document: &Document<'_>, file: &str, points: &str) -> bool {
    document.is_set(file) && !document.is_set(points)
}

/// Where a file is that has to be read. A relative path starts at the directory `own`; one that was set on the
/// command line starts at the present directory unless that file is in `own`.
fn to_read(file: &Path, own: Option<&Path>, is_set: bool, is_unread: bool) -> Option<PathBuf> {
    let beside = own.map(|own| own.join(file));
    match is_set {
        true => Some(beside.filter(|path| path.is_file()).unwrap_or_else(|| file.to_owned())),
        false => beside.filter(|_| is_unread),
    }
}

/// Reads the columns `time_s` and `speed_mps` of a CSV text; other columns are passed over.
pub(super) fn parse_csv(source: &str, text: &str) -> Result<Vec<SpeedPoint>, ScenarioError> {
    const COLUMNS: &str = "time_s,speed_mps";
    let table = Table::split(source, text);
    if table.len() == 0 && (table.find("time_s").is_some() || text.trim().is_empty()) {
        return Err(ScenarioError::whole(source, "no values")
            .expecting(format!("a line `{COLUMNS}` and at least one line of numbers")));
    }
    let time = table.column("time_s", COLUMNS)?;
    let speed = table.column("speed_mps", COLUMNS)?;
    if table.len() > MAX_PROFILE_POINTS {
        return Err(ScenarioError::whole(source, "too many lines")
            .expecting(format!("at most {MAX_PROFILE_POINTS} points")));
    }
    let mut points: Vec<SpeedPoint> = Vec::with_capacity(table.len());
    for row in 0..table.len() {
        let time_s = table.number::<Time>(row, time)?;
        let speed_mps = table.number::<Speed>(row, speed)?;
        if points.last().is_some_and(|last| last.0 >= time_s) {
            return Err(table
                .fault(row, time, "times must increase")
                .expecting("a time later than the line before"));
        }
        points.push(SpeedPoint(time_s, speed_mps));
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::overrides::Overrides;

    fn refusal(text: &str) -> String {
        parse_csv("lead.csv", text).expect_err("the table is wrong").to_string()
    }

    #[test]
    fn columns_are_found_by_name() {
        let text = "# a drive\nnote, speed_mps ,time_s\nx, 1.5 ,0\n\ny,2,0.1\r\n";
        let points = parse_csv("lead.csv", text).expect("the table is right");
        let expected = [(0.0, 1.5), (0.1, 2.0)];
        let expected = expected.map(|(t, v)| SpeedPoint(Time::of(t), Speed::of(v)));
        assert_eq!(points, expected);
    }

    #[test]
    fn faults_are_shown_where_they_are() {
        let shown = refusal("time_s,speed_mps\n0,1\n0.0,2\n");
        assert!(shown.contains("lead.csv:3:1: times must increase"), "{shown}");
        let shown = refusal("time_s,speed_mps\n0,NaN\n");
        assert!(shown.contains("lead.csv:2:3: NaN is out of range"), "{shown}");
        let shown = refusal("time_s,speed_mps\n0,-1\n");
        assert!(shown.contains("lead.csv:2:3: -1 is out of range"), "{shown}");
        let shown = refusal("time_s,speed_mps\n0, fast\n");
        assert!(shown.contains("lead.csv:2:4: `fast` is not a number"), "{shown}");
        let shown = refusal("time_s,speed_mps\n0\n");
        assert!(shown.contains("lead.csv:2:1: no `speed_mps` in this line"), "{shown}");
        let shown = refusal("t,v\n0,1\n");
        assert!(shown.contains("lead.csv:1:1: no column `time_s`"), "{shown}");
        for empty in ["", "\n\n", "time_s,speed_mps\n"] {
            assert!(refusal(empty).contains("no values"));
        }
    }

    #[test]
    fn an_endless_table_is_refused() {
        let mut text = String::from("time_s,speed_mps\n");
        for i in 0..=MAX_PROFILE_POINTS {
            text.push_str(&format!("{i},0\n"));
        }
        assert!(refusal(&text).contains("too many lines"));
    }

    #[test]
    fn a_directory_is_not_a_scenario() {
        assert!(matches!(read(Path::new("/")), Err(TextFileError::Irregular)));
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
        let Road::Csv { points, .. } = &opened.road else { panic!("{:?}", opened.road) };
        assert_eq!(points.len(), 2);
        let kept = directory.join("scenario.toml");
        let other = opened.to_toml().replace("400.0", "500.0");
        std::fs::write(&kept, other).expect("writable");
        let mut overrides = Overrides::new();
        overrides.set("road.csv=road.csv").expect("an option");
        let again =
            Scenario::open(&kept.to_string_lossy(), &overrides, &|_| Ok(Default::default()));
        let Road::Csv { points: read, .. } = again.expect("a scenario").road else { panic!() };
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
