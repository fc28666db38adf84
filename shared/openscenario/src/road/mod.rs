//! The road: its course, lanes and heights, from an OpenDRIVE file.
//!
//! Everything moves in the road's own coordinates: `s` along the reference line, `t` across it, positive to the left.
//! Roads that follow each other by their links are one road here. Its `s` counts from the start of the first. A road of
//! the file that runs the other way is turned around.

mod driven;
mod ground;
mod lines;
mod opendrive;

use road::{Laid, Lane, Lanes, Pose, Profile, Section, Strip};
use serde::{Deserialize, Serialize};

use crate::error::one_of;
pub use driven::{Driven, DrivenLane, driven_lane};
pub use ground::Cut;
pub(crate) use ground::Ground;
pub use opendrive::{Found, Text, read};
pub(crate) use opendrive::{Start, nearest};

pub const ASSUMED_LANE_WIDTH_M: f64 = 3.5;
const ASSUMED_LANES: i32 = 8;
/// A place at the very end of a part belongs to it, not to the next one, m.
pub(crate) const INSIDE_M: f64 = 1e-6;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Road {
    /// Its length, m; a road without one has no end.
    pub length_m: Option<f64>,
    /// The roads of the file that it is made of, in order.
    pub parts: Vec<Part>,
    /// The pieces of its reference line; none for a straight line along the x axis.
    pub pieces: Vec<Laid>,
    /// Cuts of the reference line, if it leads through junctions: it goes on beside its last part.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cuts: Vec<Cut>,
    pub left_hand: bool,
    pub lanes: Lanes,
    /// Height of the reference line, m.
    pub heights: Profile,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Part {
    pub id: String,
    pub from_m: f64,
    pub length_m: f64,
    /// Its own reference line runs the other way.
    pub reversed: bool,
    /// Its reference line is that far to the left of the road's, m.
    #[serde(default)]
    pub shift_m: f64,
}

impl Part {
    /// A place on the file's road, `s` and `t`, m, on the road that it is a part of.
    ///
    /// ```
    /// use openscenario::road::Part;
    /// let id = "7".to_owned();
    /// let part = Part { id, from_m: 300.0, length_m: 100.0, reversed: true, shift_m: 0.0 };
    /// assert_eq!(part.place(30.0, 2.0), (370.0, -2.0));
    /// ```
    pub fn place(&self, s_m: f64, t_m: f64) -> (f64, f64) {
        match self.reversed {
            false => (self.from_m + s_m, self.shift_m + t_m),
            true => (self.from_m + (self.length_m - s_m), self.shift_m - t_m),
        }
    }

    /// The place on the file's road of one of the road that it is a part of: the opposite of [`Self::place`].
    pub fn own(&self, s_m: f64, t_m: f64) -> (f64, f64) {
        match self.reversed {
            false => (s_m - self.from_m, t_m - self.shift_m),
            true => (self.length_m - (s_m - self.from_m), self.shift_m - t_m),
        }
    }

    /// The direction of its own reference line from the road's, rad.
    pub fn heading_rad(&self) -> f64 {
        if self.reversed { std::f64::consts::PI } else { 0.0 }
    }

    /// A place of the road that is surely on this part, m.
    pub fn inside(&self, s_m: f64) -> f64 {
        s_m.clamp(self.from_m, self.from_m.max(self.from_m + self.length_m - INSIDE_M))
    }
}

impl Road {
    /// A straight road without end, with eight lanes of 3.5 m on each side. It stands in for a missing road file.
    ///
    /// ```
    /// let road = openscenario::road::Road::assumed();
    /// assert_eq!(road.lane(100.0, -2).map(|lane| lane.center_m), Some(-5.25));
    /// ```
    pub fn assumed() -> Self {
        let ids = (-ASSUMED_LANES..=ASSUMED_LANES).filter(|id| *id != 0);
        Self::straight(ids, ASSUMED_LANES as usize, 0.0)
    }

    /// A straight road without end, with one lane around the reference line.
    pub fn one_lane() -> Self {
        Self::straight(std::iter::once(-1), 0, 0.5 * ASSUMED_LANE_WIDTH_M)
    }

    fn straight(ids: impl Iterator<Item = i32>, left: usize, offset_m: f64) -> Self {
        let lane = |id| Lane {
            id,
            drivable: true,
            width: Profile::constant(ASSUMED_LANE_WIDTH_M),
            before: None,
            after: None,
        };
        let section = Section { from_m: 0.0, lanes: ids.map(lane).collect(), left };
        let (id, length_m) = ("0".to_owned(), f64::INFINITY);
        let part = Part { id, from_m: 0.0, length_m, reversed: false, shift_m: 0.0 };
        Self {
            length_m: None,
            parts: vec![part],
            pieces: Vec::new(),
            cuts: Vec::new(),
            left_hand: false,
            lanes: Lanes {
                offset: Profile::constant(offset_m),
                sections: vec![section],
                length_m: f64::INFINITY,
            },
            heights: Profile::default(),
        }
    }

    pub fn start(&self) -> Pose {
        self.pieces.first().map_or(Pose::default(), |laid| laid.start)
    }

    pub fn part(&self, id: &str) -> Option<&Part> {
        self.parts.iter().find(|part| part.id == id)
    }

    /// A place of another row on a road that this one has too: `s` and `t`, m, and true if they run against each other.
    pub fn place_of(&self, other: &Self, s_m: f64, t_m: f64) -> Option<(f64, f64, bool)> {
        let part = other.part_at(s_m);
        let here = self.part(&part.id)?;
        let (s_m, t_m) = part.own(s_m, t_m);
        let (s_m, t_m) = here.place(s_m, t_m);
        Some((s_m, t_m, here.reversed != part.reversed))
    }

    pub fn part_at(&self, s_m: f64) -> &Part {
        self.parts.iter().rev().find(|part| part.from_m <= s_m).unwrap_or(&self.parts[0])
    }

    /// The ids of its parts, for errors.
    pub(crate) fn names(&self) -> String {
        one_of(self.parts.iter().map(|part| part.id.as_str()))
    }

    pub fn lane(&self, s_m: f64, id: i32) -> Option<Strip> {
        self.lanes.strip(s_m, id)
    }

    /// The ids of the lanes at a place, for errors.
    pub(crate) fn lane_names(&self, s_m: f64) -> String {
        let names: Vec<String> = self.strips(s_m).iter().map(|lane| lane.id.to_string()).collect();
        one_of(names.iter().map(String::as_str))
    }

    /// The lanes at a place from right to left.
    fn strips(&self, s_m: f64) -> Vec<Strip> {
        let mut strips: Vec<Strip> = self.lanes.strips(s_m).collect();
        strips.sort_by_key(|strip| strip.index);
        strips
    }

    /// The direction in which traffic drives on a lane: 1 along the reference line, -1 against it.
    pub fn direction(&self, lane: &Strip) -> f64 {
        if lane.is_left == self.left_hand { 1.0 } else { -1.0 }
    }

    /// The lane nearest to a place, m.
    pub fn lane_at(&self, s_m: f64, t_m: f64) -> Option<Strip> {
        let distance = |lane: &Strip| ((t_m - lane.center_m).abs() - 0.5 * lane.width_m).max(0.0);
        let nearest =
            |a: &Strip, b: &Strip| distance(a).total_cmp(&distance(b)).then(a.index.cmp(&b.index));
        self.lanes.strips(s_m).min_by(nearest)
    }

    /// The lane some lanes to the left (in the direction of `s`) of the one at a place.
    pub fn lane_beside(&self, s_m: f64, t_m: f64, lanes_left: i32) -> Option<Strip> {
        let index = i64::try_from(self.lane_at(s_m, t_m)?.index).ok()? + i64::from(lanes_left);
        let index = usize::try_from(index).ok()?;
        self.lanes.strips(s_m).find(|lane| lane.index == index)
    }

    /// True if a place, m, is on one of the lanes.
    pub fn holds(&self, s_m: f64, t_m: f64) -> bool {
        self.lanes.strips(s_m).any(|lane| (t_m - lane.center_m).abs() <= 0.5 * lane.width_m)
    }

    /// Distance by which the middle of the lane moves to the left between two places, m. A lane that ends stays.
    pub fn drift(&self, from_s_m: f64, t_m: f64, to_s_m: f64) -> f64 {
        let Some(lane) = self.lane_at(from_s_m, t_m) else { return 0.0 };
        let (from, to) = (self.lanes.section(from_s_m), self.lanes.section(to_s_m));
        let (mut moved_m, mut at_m, mut joint_m) = (0.0, lane.center_m, from_s_m);
        let forward = from < to;
        let center = |section: usize, index: usize, s_m: f64| {
            let sections = &self.lanes.sections;
            let end_m =
                sections.get(section + 1).map_or(f64::INFINITY, |next| next.from_m - INSIDE_M);
            let s_m = s_m.clamp(sections[section].from_m, end_m.max(sections[section].from_m));
            self.lanes
                .strips(s_m)
                .find(|lane| lane.index == index)
                .map_or(0.0, |lane| lane.center_m)
        };
        for (section, index) in self.lanes.chain((from, lane.index), forward) {
            if section != from {
                at_m = center(section, index, joint_m);
            }
            if section == to {
                return moved_m + center(section, index, to_s_m) - at_m;
            }
            joint_m = self.lanes.sections[if forward { section + 1 } else { section }].from_m;
            moved_m += center(section, index, joint_m) - at_m;
        }
        moved_m
    }

    /// True if the lane at a place leads on to the last section, or against the reference line to the first one.
    pub fn leads_on(&self, s_m: f64, t_m: f64, direction: f64) -> bool {
        let (here, forward) = (self.lanes.section(s_m), direction > 0.0);
        let end = if forward { self.lanes.sections.len() - 1 } else { 0 };
        let lane = self.lane_at(s_m, t_m).map(|lane| (here, lane.index));
        lane.is_some_and(|lane| self.lanes.chain(lane, forward).any(|(section, _)| section == end))
    }

    /// The steepest slope, up or down, as height over distance.
    pub fn steepest_slope(&self) -> f64 {
        let stretches = self.heights.stretches();
        let mut steepest: f64 = 0.0;
        for (i, stretch) in stretches.iter().enumerate() {
            let end_m = stretches.get(i + 1).map_or(self.lanes.length_m, |next| next.from_m);
            let [_, b, c, d] = stretch.factors;
            let length_m = (end_m - stretch.from_m).max(0.0);
            // The extremes are at the ends, or at the turning point of a cubic's slope.
            let turn_m = if d == 0.0 { 0.0 } else { (-c / (3.0 * d)).clamp(0.0, length_m) };
            for x in [0.0, turn_m, length_m] {
                steepest = steepest.max((b + (2.0 * c + 3.0 * d * x) * x).abs());
            }
        }
        steepest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_assumed_road_has_lanes_of_both_signs() {
        let road = Road::assumed();
        assert_eq!(road.lane(1e6, -4).map(|lane| lane.center_m), Some(-12.25));
        assert_eq!(road.lane(-5.0, 1).map(|lane| lane.center_m), Some(1.75));
        assert_eq!(road.lane_beside(0.0, -1.75, 1).map(|lane| lane.id), Some(1));
        assert_eq!(road.drift(0.0, -1.75, 5e3), 0.0);
        let ground = Ground::of(&road, &Pose::default()).expect("a line");
        assert!(ground.legs[0].axis.is_straight());
    }

    #[test]
    fn one_lane_lies_around_the_reference_line() {
        let road = Road::one_lane();
        let lane = road.lane_at(7.0, 0.3).expect("one");
        assert_eq!((lane.id, lane.center_m, road.direction(&lane)), (-1, 0.0, 1.0));
    }
}
