//! `[road]`: how high the road is, and its plan.
//!
//! The heights have one of four sources, or none for a level road:
//!
//! ```toml
//! road.builtin = "hills-60km"
//! road.csv = "my-road.csv"                       # columns distance_m and height_m or grade_percent
//! road.points = [[0, 0], [50, 0.6], [100, 1.3]]  # distance in m, height in m
//! road.generated = { seed = 7, length_km = 20 }
//! ```

use scenario_derive::tables;
use std::path::PathBuf;

use ::road::grade::{Alignment, GradeProfile, MAX_POINTS, Point, ProfileFault, generate};
use serde::{Deserialize, Serialize};

use crate::Problem;
use crate::ScenarioError;
use crate::plan::Plan;
use crate::quantity::{
    Distance, GradeMagnitude, GradePercent, Height, Length, OutOfRange, Reach, RoadLength, Seed,
};
use crate::reading::csv::Table;
use crate::reading::refuse;
use crate::schema::Schema;

tables! {
    /// The road: one source of heights at most, and its plan. Beyond its ends it is level.
    pub struct Road {
        /// A road that comes with the program.
        pub builtin: Option<BuiltinRoad>,
        /// A CSV file; a relative path starts at the scenario file's directory, with `--set` also at the present one.
        pub csv: Option<PathBuf>,
        /// A road made by a random generator.
        pub generated: Option<Generated>,
        /// The points themselves; beside `csv`, what the file held when the scenario was opened.
        pub points: Vec<RoadPoint> = sparse,
        /// The course of the road in the plane; absent: a straight road, and no messages of the plane.
        pub plan: Option<Plan>,
    }

    /// A road compiled into the program.
    pub enum BuiltinRoad {
        /// [`HILLS_60KM`].
        #[serde(rename = "hills-60km")]
        Hills60km,
    }

    /// A hilly highway of a seed.
    #[derive(Copy)]
    pub struct Generated {
        /// Seed; each has its own road.
        pub seed: Seed,
        /// Length, km.
        pub length_km: RoadLength,
        /// Standard deviation of the grades, percent.
        pub grade_sigma_percent: GradeMagnitude = 1.38,
        /// Largest grade, percent.
        pub max_grade_percent: GradeMagnitude = 3.0,
        /// Shortest stretch of constant grade, m.
        pub min_tangent_m: Length = 300.0,
        /// Longest stretch of constant grade, m.
        pub max_tangent_m: Reach = 1500.0,
        /// Length of the vertical curves, m.
        pub curve_m: Length = 300.0,
        /// True if the road ends as high as it began.
        pub closed: bool = true,
    }
}

/// Checks that the keys that were written name one source of heights at most; the points beside a file are the file's.
pub(crate) fn one_source(is_written: impl Fn(&str) -> bool) -> Result<(), Problem> {
    let points = if is_written("road.csv") { "road.csv" } else { "road.points" };
    let sources = ["road.builtin", "road.generated", points];
    one_of("road", sources.map(|source| (source, is_written(source))))
}

/// Checks that a thing has one source at most.
pub(crate) fn one_of<const N: usize>(
    thing: &str,
    sources: [(&str, bool); N],
) -> Result<(), Problem> {
    let mut given = sources.into_iter().filter(|(_, is_given)| *is_given);
    let (Some((first, _)), Some((second, _))) = (given.next(), given.next()) else { return Ok(()) };
    refuse!("{second}": "the {thing} is given twice, by {first} and {second}",
        "one source for the {thing}", against "{first}")
}

/// Sixty kilometres of synthetic hilly motorway, closed in height: `distance_m,height_m`.
pub const HILLS_60KM: &str = include_str!("../../roads/hills-60km.csv");

/// A point of a road: `[distance_m, height_m]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
#[serde(expecting = "a point [distance_m, height_m]")]
pub struct RoadPoint(pub Distance, pub Height);

impl Road {
    /// True if no heights are given.
    pub fn is_level(&self) -> bool {
        self.builtin.is_none()
            && self.csv.is_none()
            && self.generated.is_none()
            && self.points.is_empty()
    }

    /// The road in the plane, if it has one.
    pub fn plan(&self) -> Option<&Plan> {
        self.plan.as_ref()
    }

    /// The road's heights.
    ///
    /// # Errors
    /// When the points are not a road, or the file has not been read.
    pub fn profile(&self) -> Result<GradeProfile, Problem> {
        if let Some(BuiltinRoad::Hills60km) = self.builtin {
            return Ok(parse_csv("built-in road", HILLS_60KM).expect("a test reads it"));
        }
        if let Some(generated) = &self.generated {
            return generated.profile();
        }
        if self.csv.is_some() && self.points.is_empty() {
            return Err(Problem::unread("road.csv", "points, or a scenario file"));
        }
        let point =
            |point: &RoadPoint| Point { distance_m: point.0.value(), height_m: point.1.value() };
        GradeProfile::new(self.points.iter().map(point).collect()).map_err(|error| {
            let path = format!("road.points.{}", error.index);
            Problem::new(path, error.to_string(), error.expected())
        })
    }
}

impl Generated {
    fn profile(&self) -> Result<GradeProfile, Problem> {
        let (shortest, longest) = (self.min_tangent_m.value(), self.max_tangent_m.value());
        refuse!(if shortest > longest, "road.generated.max_tangent_m":
            "the longest tangent is shorter than the shortest", "at least {shortest} m",
            against "road.generated.min_tangent_m");
        let alignment = Alignment {
            length_m: 1e3 * self.length_km.value(),
            grade_sigma: self.grade_sigma_percent.value() / 100.0,
            max_grade: self.max_grade_percent.value() / 100.0,
            tangent_m: [shortest, longest],
            curve_m: self.curve_m.value(),
            closed: self.closed,
        };
        Ok(generate(&alignment, self.seed.value()))
    }
}

/// Heights of a file, way and height in m, as a scenario keeps them.
pub(crate) fn points(
    heights: impl IntoIterator<Item = [f64; 2]>,
) -> Result<Vec<RoadPoint>, Problem> {
    let refuse = |error: OutOfRange<f64>| {
        Problem::new("road", error.to_string(), "heights that are in range")
    };
    let point = |[distance_m, height_m]: [f64; 2]| {
        let distance = Distance::try_from(distance_m).map_err(refuse)?;
        Ok(RoadPoint(distance, Height::try_from(height_m).map_err(refuse)?))
    };
    heights.into_iter().map(point).collect()
}

/// Reads a road from a CSV text. It has the column `distance_m` and one of `height_m` and `grade_percent`; the grade's
/// value holds up to the next line's distance.
///
/// # Errors
/// When the text is not such a table; shows the line.
pub fn parse_csv(source: &str, text: &str) -> Result<GradeProfile, ScenarioError> {
    const COLUMNS: &str = "distance_m,height_m or distance_m,grade_percent";
    let table = Table::split(source, text);
    let distance = table.column("distance_m", COLUMNS)?;
    let (height, grade) = (table.find("height_m"), table.find("grade_percent"));
    if table.len() < 2 || table.len() > MAX_POINTS {
        return Err(ScenarioError::whole(source, format!("{} lines of numbers", table.len()))
            .expecting(format!("2 to {MAX_POINTS} points of a road")));
    }
    let value = match (height, grade) {
        (Some(height), None) => height,
        (None, Some(grade)) => grade,
        (None, None) => table.column("height_m", COLUMNS)?,
        (Some(_), Some(_)) => {
            return Err(ScenarioError::whole(source, "both heights and grades")
                .expecting(format!("the columns {COLUMNS}")));
        }
    };
    let mut points: Vec<Point> = Vec::with_capacity(table.len());
    let mut slope = 0.0;
    for row in 0..table.len() {
        let distance_m = table.number::<Distance>(row, distance)?.value();
        let height_m = if height.is_some() {
            table.number::<Height>(row, value)?.value()
        } else {
            let before = points.last().copied().unwrap_or(Point { distance_m, height_m: 0.0 });
            let height_m = before.height_m + slope * (distance_m - before.distance_m);
            slope = table.number::<GradePercent>(row, value)?.value() / 100.0;
            Height::try_from(height_m)
                .map_err(|error| table.fault(row, value, &error.to_string()))?
                .value()
        };
        points.push(Point { distance_m, height_m });
    }
    GradeProfile::new(points).map_err(|error| {
        let is_of_heights = matches!(error.fault, ProfileFault::TooSteep(_));
        let column = if is_of_heights { value } else { distance };
        table.fault(error.index, column, &error.to_string()).expecting(error.expected())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scenario;

    fn refusal(text: &str) -> String {
        parse_csv("road.csv", text).expect_err("no road").to_string()
    }

    #[test]
    fn the_built_in_road_is_sixty_kilometres_closed_within_three_percent() {
        let road = parse_csv("hills", HILLS_60KM).expect("a right road");
        assert_eq!((road.end_m(), road.height_m(60e3)), (60e3, 0.0));
        let grades = road.points().windows(2).map(|pair| road.grade(pair[0].distance_m));
        let steepest = grades.fold(0.0_f64, |most, grade| most.max(grade.abs()));
        assert!((0.02..=0.0301).contains(&steepest), "{steepest}");
    }

    #[test]
    fn grades_are_summed_up_to_heights() {
        let text = "# by hand\nnote,grade_percent,distance_m\na,2,0\nb,-1,100\nc,0,300\n";
        let road = parse_csv("road.csv", text).expect("a right road");
        assert_eq!([100.0, 200.0, 300.0].map(|x| road.height_m(x)), [2.0, 1.0, 0.0]);
    }

    #[test]
    fn faults_are_shown_where_they_are() {
        let cases = [
            ("distance_m,height_m\n0,0\n50,NaN\n", "road.csv:3:4: NaN is out of range"),
            ("distance_m,height_m\n0,0\n50,x\n", "road.csv:3:4: `x` is not a number"),
            ("distance_m,height_m\n0,0\n50\n", "road.csv:3:1: no `height_m` in this line"),
            ("distance_m,height_m\n0,0\n50,1\n50,1\n", "road.csv:4:1: distances must increase"),
            ("distance_m,height_m\n0,0\n900,1\n", "road.csv:3:1: a gap of 900 m"),
            ("distance_m,height_m\n0,0\n50,30\n", "road.csv:3:4: a grade of 60.0 %"),
            ("distance_m,grade_percent\n0,25\n50,1\n", "road.csv:2:3: 25 is out of range"),
            ("s,z\n0,0\n50,1\n", "road.csv:1:1: no column `distance_m`"),
            ("distance_m,z\n0,0\n50,1\n", "road.csv:1:1: no column `height_m`"),
        ];
        for (text, expected) in cases {
            let shown = refusal(text);
            assert!(shown.starts_with(&format!("error: {expected}")), "{text}\n{shown}");
        }
        assert!(refusal("distance_m,height_m\n0,0\n").contains("1 lines of numbers"));
        let both = "distance_m,height_m,grade_percent\n0,0,0\n50,1,2\n";
        assert!(refusal(both).contains("both heights and grades"));
    }

    #[test]
    fn two_sources_are_one_too_many() {
        let points = "points = [[0, 0], [50, 1]]";
        let text = format!(
            "schema_version = 1\nname = \"x\"\n[road]\nbuiltin = \"hills-60km\"\n{points}\n"
        );
        let said = Scenario::parse("x.toml", &text).expect_err("two").to_string();
        assert!(
            said.contains("x.toml:5:") && said.contains("by road.builtin and road.points"),
            "{said}"
        );
        let file: Road = toml::from_str(&format!("csv = \"a.csv\"\n{points}")).expect("one");
        assert!(file.csv.is_some() && file.points.len() == 2, "the file's points");
    }
}
