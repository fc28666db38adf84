//! Roads in a row, by their links.

use road::{Axis, MAX_GAP_M, MAX_KINK_RAD, Pose, Profile};

use super::Found;
use super::geometry::Line;
use super::lanes::{self, Link, Side};
use super::text::{Text, children};
use crate::error::ReadError;
use crate::road::{Part, Road};
use crate::xml::Element;

pub struct Row<'a> {
    members: Vec<Member<'a>>,
    asked: usize,
}

#[derive(Clone, Copy)]
struct Member<'a> {
    road: &'a Element,
    /// It is driven from its end to its start.
    reversed: bool,
}

/// A member as it was read, in the direction of the row.
struct Read {
    road: Road,
    /// End of its last piece; an error if it cannot be driven.
    end: Result<Pose, ReadError>,
    first: Vec<Link>,
    last: Vec<Link>,
}

/// True if a road is not a way through a junction.
pub fn outside_junctions(road: &Element) -> bool {
    road.attribute("junction").is_none_or(|junction| junction.trim() == "-1")
}

impl<'a> Member<'a> {
    /// The next road of the row, if it is one of `roads`: behind the end, or before the start.
    fn neighbour(&self, roads: &[&'a Element], behind: bool) -> Option<Self> {
        if !outside_junctions(self.road) {
            return None;
        }
        let at_end = behind != self.reversed;
        let link =
            self.road.child("link")?.child(if at_end { "successor" } else { "predecessor" })?;
        if link.attribute("elementType").is_some_and(|kind| kind != "road") {
            return None;
        }
        let id = link.attribute("elementId")?;
        let is_next = |road: &&Element| road.attribute("id") == Some(id) && outside_junctions(road);
        let road = roads.iter().copied().find(is_next)?;
        // It is met at its start if it is driven forwards behind the end, or backwards before the start.
        let at_start = match link.attribute("contactPoint") {
            Some(point) => point == "start",
            None => names(road, "predecessor", self.road) || !names(road, "successor", self.road),
        };
        Some(Self { road, reversed: at_start != behind })
    }

    fn read(&self, text: Text<'_>, notices: &mut Vec<String>) -> Result<Read, ReadError> {
        let line = Line::read(text, self.road)?;
        let length_m = line.length_m;
        let profile = self.road.child("elevationProfile");
        let heights = profile.into_iter().flat_map(|profile| children(profile, "elevation"));
        let heights = heights.map(|height| text.stretch(height, "s", 0.0));
        let heights = Profile::new(heights.collect::<Result<_, _>>()?);
        let Side { lanes, first, last } = lanes::read(text, self.road, length_m)?;
        // Only now: a word in place of a number is a clearer error than its effect on the line.
        let end = line.axis(text).map(|axis| axis.pose(length_m).placed(&line.pieces[0].start));
        notices.extend(line.notices.iter().cloned());
        let id = self.road.attribute("id").unwrap_or_default().to_owned();
        let mut road = Road {
            length_m: Some(length_m),
            parts: vec![Part { id, from_m: 0.0, length_m, reversed: self.reversed }],
            pieces: Vec::new(),
            left_hand: self.road.attribute("rule") == Some("LHT"),
            lanes,
            heights,
        };
        if !self.reversed {
            road.pieces = line.pieces;
            return Ok(Read { road, end, first, last });
        }
        let start = line.pieces[0].start;
        let heading_rad = start.heading_rad + std::f64::consts::PI;
        road.pieces = line.reversed();
        (road.lanes, road.heights) = (road.lanes.reversed(), road.heights.reversed(length_m));
        let turned = |links: Vec<Link>| links.into_iter().rev().collect();
        let end = end.map(|_| Pose { heading_rad, ..start });
        Ok(Read { road, end, first: turned(last), last: turned(first) })
    }
}

fn names(road: &Element, link: &str, other: &Element) -> bool {
    let to = road.child("link").and_then(|links| links.child(link));
    to.is_some_and(|to| to.attribute("elementId") == other.attribute("id"))
}

impl<'a> Row<'a> {
    /// The road with all that follow and precede it by their links, up to a junction. A ring ends where it began.
    pub fn around(roads: &[&'a Element], road: &'a Element) -> Self {
        let mut members = vec![Member { road, reversed: false }];
        let is_new = |members: &[Member<'a>], next: &Member<'a>| {
            members.iter().all(|member| !std::ptr::eq(member.road, next.road))
        };
        while let Some(next) = members[members.len() - 1].neighbour(roads, true)
            && is_new(&members, &next)
        {
            members.push(next);
        }
        let mut before = Vec::new();
        let mut first = members[0];
        while let Some(next) = first.neighbour(roads, false)
            && is_new(&members, &next)
            && is_new(&before, &next)
        {
            before.push(next);
            first = next;
        }
        before.reverse();
        let asked = before.len();
        before.append(&mut members);
        Self { members: before, asked }
    }

    pub fn len(&self) -> usize {
        self.members.len()
    }

    pub fn read(&self, text: Text<'_>) -> Result<Found, ReadError> {
        let mut notices = Vec::new();
        // The roads so far, the links at the end, and its pose.
        let mut whole: Option<(Road, Vec<Link>, Pose)> = None;
        for (number, member) in self.members.iter().enumerate() {
            let Read { road: mut next, end, first, last } = member.read(text, &mut notices)?;
            let ends_before = match (&end, &whole) {
                (Err(error), _) if number == self.asked => return Err(error.clone()),
                (Err(error), _) => Some(format!("the row of roads ends there: {error}")),
                (Ok(_), Some((.., last_end))) if !is_joined(last_end, &next.pieces[0].start) => {
                    Some(format!(
                        "{}: road `{}` is linked to the one before, and their reference lines do not meet: the row of \
                         roads ends between them",
                        text.place(member.road),
                        next.parts[0].id
                    ))
                }
                _ => None,
            };
            if let Some(notice) = ends_before {
                notices.push(notice);
                if number > self.asked {
                    break;
                }
                whole = None;
            }
            let Ok(end) = end else { continue };
            let Some((road, last_links, last_end)) = &mut whole else {
                whole = Some((next, last, end));
                continue;
            };
            let turned = road.parts.last().is_some_and(|part| part.reversed) != member.reversed;
            next.parts[0].from_m = road.lanes.length_m;
            let next_m = next.lanes.length_m;
            road.parts.append(&mut next.parts);
            road.pieces.append(&mut next.pieces);
            next.heights.append_to(&mut road.heights, road.lanes.length_m, next_m);
            road.lanes.append(&next.lanes, &lanes::pairs(last_links, &first, turned));
            road.length_m = Some(road.lanes.length_m);
            (*last_links, *last_end) = (last, end);
        }
        let Some((road, ..)) = whole else { unreachable!("a row has a road") };
        let axis = Axis::laid(&road.pieces);
        axis.map_err(|error| {
            text.meaning(
                self.members[0].road,
                format!("the roads in a row: {error}"),
                error.expected(),
            )
        })?;
        Ok(Found { road, notices })
    }
}

/// True if a road begins where the one before ends.
fn is_joined(end: &Pose, start: &Pose) -> bool {
    let gap_m = libm::hypot(start.x_m - end.x_m, start.y_m - end.y_m);
    let kink_rad = libm::remainder(start.heading_rad - end.heading_rad, std::f64::consts::TAU);
    gap_m <= MAX_GAP_M && kink_rad.abs() <= MAX_KINK_RAD
}
