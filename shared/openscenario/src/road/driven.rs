//! The line that a vehicle drives along on a road: its lane's middle, or beside it.

use std::path::Path;

use road::{Axis, AxisError, Laid, Leg, MAX_GAP_M, MIN_RADIUS_M, Pose, Profile, Strip};
use serde::{Deserialize, Serialize};

use super::{Cut, Ground, INSIDE_M, Road, ground};
use crate::error::{Place, ReadError, one_of};
use crate::xml;

/// Distance between two heights, m.
const HEIGHT_SPACING_M: f64 = 20.0;
const SHORTEST_M: f64 = 1e-3;
/// Most heights of a line; longer lines have larger distances.
const MAX_HEIGHTS: f64 = 4000.0;

/// A line along a road, as data: its axis is made from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Driven {
    pub pieces: Vec<Laid>,
    /// Cuts of the reference line.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cuts: Vec<Cut>,
    /// The line's distance to the left of the reference line, m.
    pub offset: Profile,
    /// Its beginning along the reference line, m.
    pub from_m: f64,
    /// Its end; less than its beginning if it leads against the reference line, m.
    pub to_m: f64,
}

/// The lane of an OpenDRIVE file on which a drive begins.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivenLane {
    pub line: Driven,
    /// Beginning of the line in the coordinates of the file.
    pub start: Pose,
    pub road: Road,
    /// Lanes of the same direction to the left and to the right, as the vehicle faces.
    pub beside: [usize; 2],
    pub width_m: f64,
    /// Notes for a person, a sentence each.
    pub notices: Vec<String>,
}

impl Driven {
    /// Its axis, and where that begins as seen from the start of the reference line.
    ///
    /// # Errors
    /// When the line has a radius below 20 m, a gap or a kink.
    pub fn axis(&self) -> Result<(Axis, Pose), AxisError> {
        let start = self.pieces.first().map_or(Pose::default(), |laid| laid.start);
        let legs = ground::legs(&self.pieces, &self.cuts, &start)?;
        let least_m = if self.cuts.is_empty() { MIN_RADIUS_M } else { ground::NARROW_RADIUS_M };
        Leg::beside(&legs, &self.offset, (self.from_m, self.to_m), least_m)
    }
}

impl Road {
    /// The line from a place on, `aside_m` to the left of its lane's middle, in a direction of the reference line.
    pub fn driven(&self, lane: &Strip, from_m: f64, aside_m: f64, direction: f64) -> Driven {
        let center = self.lanes.center(self.lanes.section(from_m), lane.index);
        let length_m = self.length_m.unwrap_or(from_m);
        let (low_m, high_m) = (from_m.clamp(0.0, length_m), length_m);
        let shift = Profile::constant(aside_m);
        // It ends where the lane ends, and goes on as one beside it.
        let is_end = |at_m: &f64| (center.at(*at_m) - center.at(at_m - INSIDE_M)).abs() > MAX_GAP_M;
        let ends = self.lanes.sections.iter().map(|section| section.from_m).filter(is_end);
        let to_m = match direction > 0.0 {
            true => ends.filter(|at_m| *at_m > low_m).fold(high_m, f64::min),
            false => ends.filter(|at_m| *at_m < low_m).fold(0.0, f64::max),
        };
        Driven {
            pieces: self.pieces.clone(),
            cuts: self.cuts.clone(),
            offset: Profile::sum(&[(1.0, &center), (1.0, &shift)], 0.0, length_m),
            from_m: low_m,
            to_m,
        }
    }

    /// Numbers of drivable lanes of the same direction to the left and to the right, without a break, as traffic faces.
    pub fn neighbours(&self, lane: &Strip, s_m: f64) -> [usize; 2] {
        let strips = self.strips(s_m);
        let same =
            |other: &&Strip| other.is_left == lane.is_left && other.drivable && other.width_m > 0.0;
        let left = strips.iter().skip(lane.index + 1).take_while(same).count();
        let right = strips.iter().take(lane.index).rev().take_while(same).count();
        if self.direction(lane) > 0.0 { [left, right] } else { [right, left] }
    }

    /// Points of the heights along a line of this road: way along the line, height, m. `None` for a level road.
    ///
    /// # Errors
    /// When the line makes no axis.
    pub fn heights_along(&self, line: &Driven) -> Result<Vec<[f64; 2]>, AxisError> {
        if self.steepest_slope() == 0.0 {
            return Ok(Vec::new());
        }
        let (reference, (axis, start)) = (Ground::of(self, &self.start())?, line.axis()?);
        let count = libm::ceil(axis.length_m() / HEIGHT_SPACING_M).clamp(1.0, MAX_HEIGHTS);
        let (mut s_m, mut before_m) = (line.from_m, 0.0);
        let sign = if line.to_m < line.from_m { -1.0 } else { 1.0 };
        let point = |i: u64| {
            let p_m = axis.length_m() * (i as f64 / count);
            let at = axis.pose(p_m).placed(&start);
            (s_m, _) = reference.project((at.x_m, at.y_m), s_m + sign * (p_m - before_m));
            before_m = p_m;
            [p_m, self.heights.at(s_m)]
        };
        Ok((0..=count as u64).map(point).collect())
    }
}

/// Reads the lane `lane` of the road `road` of an OpenDRIVE file. It begins at `s_m`, in the direction of its traffic.
/// `text` is the file's content.
///
/// # Errors
/// When there is no such road, lane or place, or it cannot be driven.
pub fn driven_lane(
    file: &Path,
    text: &str,
    road: &str,
    lane: i32,
    s_m: f64,
) -> Result<DrivenLane, ReadError> {
    let document = xml::parse(&file.display().to_string(), text)?;
    let found = super::read(&document, Some(road))?;
    let element = document.root.children.iter().find(|e| e.attribute("id") == Some(road));
    let spot = element.map_or(document.root.spot, |element| element.spot);
    let place = Place { file: document.file.clone(), spot };
    let refuse =
        |reason: String, expected: String| ReadError::meaning(place.clone(), reason, expected);
    let Some(part) = found.road.part(road) else {
        return Err(refuse(format!("there is no road `{road}`"), found.road.names()));
    };
    if !(s_m <= part.length_m) {
        let expected = format!("less than {} m", part.length_m);
        return Err(refuse(format!("road `{road}` ends before s = {s_m} m"), expected));
    }
    let at_m = part.inside(part.place(s_m, 0.0).0);
    let Some(strip) = found.road.lane(at_m, lane) else {
        let expected = found.road.lane_names(at_m);
        return Err(refuse(format!("road `{road}` has no lane `{lane}` at s = {s_m} m"), expected));
    };
    if !strip.drivable {
        let lanes = found.road.lanes.strips(at_m).filter(|lane| lane.drivable);
        let ids: Vec<String> = lanes.map(|lane| lane.id.to_string()).collect();
        let expected = one_of(ids.iter().map(String::as_str));
        return Err(refuse(format!("nothing drives on lane `{lane}` of road `{road}`"), expected));
    }
    let direction = found.road.direction(&strip);
    let length_m = found.road.length_m.unwrap_or(f64::INFINITY);
    let ahead_m = if direction > 0.0 { length_m - at_m } else { at_m };
    if ahead_m < SHORTEST_M {
        let reason = format!("traffic of lane `{lane}` of road `{road}` leaves it at s = {s_m} m");
        let way = if (direction > 0.0) == part.reversed { "larger" } else { "smaller" };
        return Err(refuse(reason, format!("a {way} s")));
    }
    let line = found.road.driven(&strip, at_m, 0.0, direction);
    let (_, start) = line.axis().map_err(|error| {
        refuse(format!("lane `{lane}` of road `{road}`: {error}"), error.expected())
    })?;
    Ok(DrivenLane {
        start: start.placed(&found.road.start()),
        beside: found.road.neighbours(&strip, at_m),
        width_m: strip.width_m,
        line,
        road: found.road,
        notices: found.notices,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROAD: &str = r#"<OpenDRIVE><road id="1" length="400" junction="-1">
<planView><geometry s="0" x="10" y="20" hdg="0" length="400"><arc curvature="0.002"/></geometry></planView>
<elevationProfile><elevation s="0" a="3" b="0.02" c="0" d="0"/></elevationProfile>
<lanes><laneSection s="0">
<left><lane id="1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></left>
<right><lane id="-1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane>
<lane id="-2" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane>
<lane id="-3" type="shoulder"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></right>
</laneSection></lanes></road></OpenDRIVE>"#;

    fn lane(lane: i32, s_m: f64) -> Result<DrivenLane, ReadError> {
        driven_lane(Path::new("a.xodr"), ROAD, "1", lane, s_m)
    }

    #[test]
    fn a_lane_leads_on_from_its_place() {
        let right = lane(-1, 100.0).expect("a lane");
        let (axis, _) = right.line.axis().expect("an axis");
        assert!((axis.length_m() - 300.0 * (1.0 + 0.002 * 1.5)).abs() < 1e-6);
        assert!((axis.curvature_perm(50.0) - 1.0 / 501.5).abs() < 1e-9);
        assert!((right.start.heading_rad - 0.2).abs() < 1e-9);
        assert_eq!((right.beside, right.width_m), ([0, 1], 3.0));
        let heights = right.road.heights_along(&right.line).expect("heights");
        let [last_m, height_m] = heights[heights.len() - 1];
        assert!((last_m - axis.length_m()).abs() < 1e-9 && (height_m - 11.0).abs() < 1e-6);
        assert!((heights[0][1] - 5.0).abs() < 1e-6);
    }

    #[test]
    fn traffic_of_the_left_lane_comes_the_other_way() {
        let left = lane(1, 100.0).expect("a lane");
        let (axis, _) = left.line.axis().expect("an axis");
        assert!((axis.length_m() - 100.0 * (1.0 - 0.002 * 1.5)).abs() < 1e-6);
        // A left curve of the reference line is a right curve now.
        assert!((axis.curvature_perm(50.0) + 1.0 / 498.5).abs() < 1e-9);
        let turned = left.start.heading_rad - 0.2 - std::f64::consts::PI;
        assert!(libm::remainder(turned, std::f64::consts::TAU).abs() < 1e-9);
        assert_eq!(left.beside, [0, 0]);
        let heights = left.road.heights_along(&left.line).expect("heights");
        assert!((heights[heights.len() - 1][1] - 3.0).abs() < 1e-6);
    }

    #[test]
    fn a_lane_without_a_way_ahead_is_refused() {
        let said = lane(1, 0.0).expect_err("it leads to s = 0").to_string();
        assert!(
            said.ends_with("lane `1` of road `1` leaves it at s = 0 m, expected a larger s"),
            "{said}"
        );
        let said = lane(-1, 400.0).expect_err("it leads to the end").to_string();
        assert!(said.ends_with("leaves it at s = 400 m, expected a smaller s"), "{said}");
    }

    /// A cubic whose declared length differs from its true one is passed evenly, its lanes too.
    #[test]
    fn a_lane_beside_a_cubic_of_another_declared_length_can_be_driven() {
        let shape = r#"<paramPoly3 pRange="normalized" aU="0" bU="100" cU="0" dU="0" aV="0" bV="0" cV="20" dV="0"/>"#;
        let text = ROAD.replace(r#"<arc curvature="0.002"/>"#, shape);
        let [text, short] = ["104", "99"]
            .map(|length| text.replace(r#"length="400""#, &format!(r#"length="{length}""#)));
        for text in [text, short] {
            let left = driven_lane(Path::new("a.xodr"), &text, "1", -1, 0.0).expect("a lane");
            let (axis, _) = left.line.axis().expect("an axis");
            // The outer lane of a left curve is longer by 1.5 m times the turn.
            let way_m = 102.606_07 + 1.5 * libm::atan(0.4);
            assert!((axis.length_m() - way_m).abs() < 1e-3, "{}", axis.length_m());
            let end = axis.pose(axis.length_m());
            assert!((end.heading_rad - libm::atan(0.4)).abs() < 1e-6, "{end:?}");
        }
    }

    #[test]
    fn what_is_not_there_is_refused() {
        let said = |error: ReadError| error.to_string();
        assert_eq!(
            said(lane(-4, 0.0).expect_err("no such lane")),
            "a.xodr:1:12: road `1` has no lane `-4` at s = 0 m, expected `-3`, `-2`, `-1` or `1`"
        );
        assert_eq!(
            said(lane(-3, 0.0).expect_err("a shoulder")),
            "a.xodr:1:12: nothing drives on lane `-3` of road `1`, expected `-1`, `-2` or `1`"
        );
        assert!(said(lane(-1, 401.0).expect_err("too far")).contains("ends before s = 401 m"));
        let none = driven_lane(Path::new("a.xodr"), ROAD, "9", -1, 0.0).expect_err("no road");
        assert!(said(none).contains("there is no road `9` in this file, expected `1`"));
    }
}
