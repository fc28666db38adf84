//! Roads in a row, by their links, and the ways through junctions.

use road::{MAX_GAP_M, MAX_KINK_RAD, MIN_RADIUS_M, Pose, Profile};

use super::Found;
use super::geometry::Line;
use super::lanes::{self, Link, Side};
use super::text::{Text, children};
use crate::error::{Place, ReadError};
use crate::road::ground::{NARROW_RADIUS_M, legs};
use crate::road::{Cut, Part, Road};
use crate::xml::{Document, Element};

/// Most roads of a row that leads through junctions.
const MOST_ROADS: usize = 64;

#[derive(Clone, Copy, PartialEq)]
pub struct Member<'a> {
    pub road: &'a Element,
    /// It is driven from its end to its start.
    pub reversed: bool,
    /// The connection of a junction by which it is met.
    pub by: Option<&'a Element>,
}

/// The beginning of a way.
#[derive(Clone, Copy, Debug)]
pub struct Start<'a> {
    pub road: &'a str,
    /// Along and across the road, m.
    pub at: (f64, f64),
    /// The way leads against the road's reference line.
    pub reversed: bool,
}

/// A member as it was read, in the direction of the row; or a row of them.
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

impl Document {
    fn road(&self, id: Option<&str>) -> Option<&Element> {
        children(&self.root, "road").find(|road| road.attribute("id") == id)
    }

    /// The members behind one: a road, or the ways through a junction. `behind` is false for the road before it.
    fn next<'a>(&'a self, of: &Member<'a>, behind: bool) -> Vec<Member<'a>> {
        let end = if behind != of.reversed { "successor" } else { "predecessor" };
        let Some(link) = of.road.child("link").and_then(|links| links.child(end)) else {
            return Vec::new();
        };
        let (id, own) = (link.attribute("elementId"), of.road.attribute("id"));
        if link.attribute("elementType") == Some("junction") {
            let junction = children(&self.root, "junction").find(|it| it.attribute("id") == id);
            let ways = junction.into_iter().flat_map(|it| children(it, "connection"));
            let ways = ways.filter(|way| behind && way.attribute("incomingRoad") == own);
            let member = |way: &'a Element| {
                let road = way.attribute("connectingRoad").or(way.attribute("linkedRoad"));
                let reversed = way.attribute("contactPoint") == Some("end");
                Some(Member { road: self.road(Some(road?))?, reversed, by: Some(way) })
            };
            return ways.filter_map(member).collect();
        }
        let is_road = link.attribute("elementType").is_none_or(|kind| kind == "road");
        let road = self.road(id).filter(|road| is_road && outside_junctions(road));
        let at_start = link.attribute("contactPoint").map_or(behind, |point| point == "start");
        let member = |road| Member { road, reversed: at_start != behind, by: None };
        road.map(member).into_iter().collect()
    }

    /// The members from one to a road, as few as possible.
    fn path<'a>(&'a self, from: Member<'a>, to: &str) -> Option<Vec<Member<'a>>> {
        let (mut ways, mut at) = (vec![vec![from]], 0);
        while let Some(way) = ways.get(at).cloned() {
            let last = way[way.len() - 1];
            if last.road.attribute("id") == Some(to) {
                return Some(way);
            }
            for next in self.next(&last, true) {
                if ways.iter().all(|way| way[way.len() - 1] != next) {
                    ways.push(way.iter().copied().chain([next]).collect());
                }
            }
            at += 1;
        }
        None
    }

    /// The row of a way from a start over these roads, and then straight on in its lane. Without such a way the error has
    /// the `place` where it is asked for.
    pub(crate) fn along(
        &self,
        start: &Start<'_>,
        over: &[&str],
        place: &Place,
    ) -> Result<Found, ReadError> {
        let way = |reversed: bool| {
            let from = self.road(Some(start.road)).map(|road| Member { road, reversed, by: None });
            let mut way = Vec::from_iter(from);
            for road in over {
                let more = way.pop().and_then(|last| self.path(last, road));
                way.extend(more.ok_or_else(|| {
                    let reason =
                        format!("no way leads from road `{}` to road `{road}`", start.road);
                    ReadError::meaning(place.clone(), reason, "roads that their links connect")
                })?);
            }
            Ok(way)
        };
        let way = way(start.reversed).or_else(|error| way(!start.reversed).map_err(|_| error))?;
        read(self, way[0], Some((start, &way)))
    }
}

impl<'a> Member<'a> {
    fn read(&self, text: Text<'_>, notices: &mut Vec<String>) -> Result<Read, ReadError> {
        let line = Line::read(text, self.road)?;
        let length_m = line.length_m;
        let profile = self.road.child("elevationProfile");
        let heights = profile.into_iter().flat_map(|profile| children(profile, "elevation"));
        let heights = heights.map(|height| text.stretch(height, "s", 0.0));
        let heights = Profile::new(heights.collect::<Result<_, _>>()?);
        let Side { lanes, mut first, mut last } = lanes::read(text, self.road, length_m)?;
        let met = if self.reversed { &mut last } else { &mut first };
        for link in self.by.into_iter().flat_map(|by| children(by, "laneLink")) {
            let (from, to) = (text.whole(link, "from")?, text.whole(link, "to")?);
            met.iter_mut().filter(|lane| lane.id == to).for_each(|lane| lane.to = Some(from));
        }
        // Only now: a word in place of a number is a clearer error than its effect on the line.
        let is_narrow = !outside_junctions(self.road);
        let end = line.axis(text, if is_narrow { NARROW_RADIUS_M } else { MIN_RADIUS_M });
        let end = end.map(|axis| axis.pose(length_m).placed(&line.pieces[0].start));
        notices.extend(line.notices.iter().cloned());
        let id = self.road.attribute("id").unwrap_or_default().to_owned();
        let mut road = Road {
            length_m: Some(length_m),
            parts: vec![Part { id, from_m: 0.0, length_m, reversed: self.reversed, shift_m: 0.0 }],
            pieces: Vec::new(),
            cuts: if is_narrow || self.by.is_some() { vec![Cut::default()] } else { Vec::new() },
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

/// Reads a road with those before and behind it by their links. A ring ends where it began. The row ends at a junction, or
/// leads `through` junctions along a way, and then straight on in the lane of its start.
pub fn read<'a>(
    document: &'a Document,
    asked: Member<'a>,
    through: Option<(&Start<'_>, &[Member<'a>])>,
) -> Result<Found, ReadError> {
    let text = Text { file: &document.file };
    let (mut notices, mut members) = (Vec::new(), vec![asked]);
    let is_new = |members: &[Member<'a>], next: &Member<'a>| {
        members.iter().all(|member| member.road != next.road)
    };
    while let [before] = document.next(&members[0], false)[..]
        && is_new(&members, &before)
    {
        members.insert(0, before);
    }
    let mut row: Option<Read> = None;
    for member in &members {
        let next = member.read(text, &mut notices)?;
        let fault = next.fault(row.as_ref(), text.place(member.road));
        match (&fault, &mut row) {
            (None, Some(row)) => row.append(next),
            _ => {
                notices.extend(fault);
                row = match next.end {
                    Err(error) if *member == asked => return Err(error),
                    Err(_) => None,
                    Ok(_) => Some(next),
                };
            }
        }
    }
    let Some(mut row) = row else { unreachable!("a row has the road that was asked for") };
    while members.len() < MOST_ROADS {
        let last = members[members.len() - 1];
        let mut ways = document.next(&last, true);
        ways.retain(|member| is_new(&members, member));
        if through.is_none() && ways.iter().any(|member| member.by.is_some()) {
            break;
        }
        let (start, way) = through.unzip();
        let known = way.unwrap_or_default().iter().position(|member| *member == last);
        if let Some([next, rest @ ..]) = known.and_then(|known| way?.get(known + 1..)) {
            let then = rest.first();
            let leads_on =
                |it: &Member<'a>| then.is_some_and(|then| document.next(it, true).contains(then));
            ways.retain(|member| member == next || leads_on(member));
        }
        let lane = start.and_then(|start| row.lane_at_end(start));
        let mut best: Option<((bool, f64), Member<'a>, Read)> = None;
        for member in ways {
            let next = match member.read(text, &mut notices) {
                Err(_) if through.is_some() => continue,
                next => next?,
            };
            let leaves = !row.pairs(&next).iter().any(|(from, _)| lane == Some(*from));
            let turn_rad = next.end.as_ref().map(|end| turn(&next.road.start(), end).abs());
            let cost = (leaves, turn_rad.unwrap_or(f64::INFINITY));
            if best.as_ref().is_none_or(|best| cost < best.0) {
                best = Some((cost, member, next));
            }
        }
        let Some((_, member, next)) = best else { break };
        if let Some(fault) = next.fault(Some(&row), text.place(member.road)) {
            notices.push(fault);
            break;
        }
        row.append(next);
        members.push(member);
    }
    let axes = legs(&row.road.pieces, &row.road.cuts, &Pose::default());
    axes.map_err(|error| {
        text.meaning(members[0].road, format!("the roads in a row: {error}"), error.expected())
    })?;
    Ok(Found { road: row.road, notices })
}

/// The angle from one direction to another, rad.
fn turn(from: &Pose, to: &Pose) -> f64 {
    libm::remainder(to.heading_rad - from.heading_rad, std::f64::consts::TAU)
}

impl Read {
    /// Places of lanes of the last section that lanes of the next road continue.
    fn pairs(&self, next: &Self) -> Vec<(usize, usize)> {
        let is_turned = |road: &Road| road.parts.last().is_some_and(|part| part.reversed);
        lanes::pairs(&self.last, &next.first, is_turned(&self.road) != is_turned(&next.road))
    }

    /// The lane at the end that the lane at a start leads to, by its place in its section.
    fn lane_at_end(&self, start: &Start<'_>) -> Option<usize> {
        let (lanes, part) = (&self.road.lanes, self.road.part(start.road)?);
        let (s_m, t_m) = part.place(start.at.0, start.at.1);
        let lane = self.road.lane_at(part.inside(s_m), t_m)?;
        let center = lanes.center(lanes.section(part.inside(s_m)), lane.index);
        Some(self.road.lane_at(lanes.length_m, center.at(lanes.length_m))?.index)
    }

    /// Why a row ends before this member, if it does. In a junction a line may begin beside the one before.
    fn fault(&self, row: Option<&Self>, place: Place) -> Option<String> {
        let end = match (&self.end, row) {
            (Err(error), _) => return Some(format!("the row of roads ends there: {error}")),
            (Ok(_), None) => return None,
            (Ok(_), Some(row)) => row.end.as_ref().ok()?,
        };
        let start = self.road.start();
        let (along_m, aside_m) = end.to_local(start.x_m, start.y_m);
        let is_cut = row.is_some_and(|row| self.road.cuts.len() + row.road.cuts.len() > 0);
        let gap_m = libm::hypot(along_m, if is_cut { 0.0 } else { aside_m });
        let is_joined = gap_m <= MAX_GAP_M && turn(end, &start).abs() <= MAX_KINK_RAD;
        (!is_joined).then(|| {
            format!(
                "{place}: road `{}` is linked to the one before, and their reference lines do not meet: the row of \
                 roads ends between them",
                self.road.parts[0].id
            )
        })
    }

    /// Adds the next road, which has no fault.
    fn append(&mut self, mut next: Self) {
        let (pairs, road) = (self.pairs(&next), &mut self.road);
        let (from_m, next_m) = (road.lanes.length_m, next.road.lanes.length_m);
        if next.road.cuts.len() + road.cuts.len() > 0 {
            let start = next.road.start();
            let aside_m = self.end.as_ref().map_or(0.0, |end| end.to_local(start.x_m, start.y_m).1);
            if road.cuts.is_empty() {
                road.cuts.push(Cut::default());
            }
            let shift_m = road.cuts[road.cuts.len() - 1].shift_m + aside_m;
            road.cuts.push(Cut { piece: road.pieces.len(), from_m, shift_m });
            next.road.parts[0].shift_m = shift_m;
            let parts = [(1.0, &next.road.lanes.offset), (1.0, &Profile::constant(shift_m))];
            next.road.lanes.offset = Profile::sum(&parts, 0.0, next_m);
        }
        next.road.parts[0].from_m = from_m;
        road.parts.append(&mut next.road.parts);
        road.pieces.append(&mut next.road.pieces);
        next.road.heights.append_to(&mut road.heights, from_m, next_m);
        road.lanes.append(&next.road.lanes, &pairs);
        road.length_m = Some(road.lanes.length_m);
        (self.last, self.end) = (next.last, next.end);
    }
}
