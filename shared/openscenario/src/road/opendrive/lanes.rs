//! `lanes`: offsets, sections, widths, and the links of lanes.

use road::{Lane, Lanes, Profile, Section, Stretch};

use super::text::{Text, children};
use crate::error::ReadError;
use crate::xml::Element;

const NOT_DRIVABLE: [&str; 15] = [
    "shoulder",
    "border",
    "none",
    "restricted",
    "parking",
    "median",
    "biking",
    "sidewalk",
    "curb",
    "walking",
    "tram",
    "rail",
    "stop",
    "roadWorks",
    "slipLane",
];

/// The lanes of one road, with the links of its outer ends.
pub struct Side {
    pub lanes: Lanes,
    /// For each lane of the first section the id of the lane that it continues.
    pub first: Vec<Link>,
    /// For each lane of the last section the id of the lane that continues it.
    pub last: Vec<Link>,
}

/// A lane's link to a lane of another road or section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link {
    pub id: i32,
    pub to: Option<i32>,
}

struct Links {
    before: Vec<Link>,
    after: Vec<Link>,
}

pub fn read(text: Text<'_>, road: &Element, length_m: f64) -> Result<Side, ReadError> {
    let Some(group) = road.child("lanes") else {
        return Err(text.element(road, "OpenDRIVE", "has no lanes", "`lanes`"));
    };
    let offsets = children(group, "laneOffset").map(|offset| text.stretch(offset, "s", 0.0));
    let offset = Profile::new(offsets.collect::<Result<_, _>>()?);
    let mut starts: Vec<(f64, &Element)> = Vec::new();
    for section in children(group, "laneSection") {
        let from_m = text.number(section, "s")?;
        let reason = format!("the lane section begins at s = {from_m} m");
        if let Some((before_m, _)) = starts.last()
            && !(from_m > *before_m)
        {
            return Err(text.meaning(section, reason, format!("more than {before_m}")));
        }
        if from_m >= length_m {
            let expected = format!("less than the road's {length_m} m");
            return Err(text.meaning(section, reason, expected));
        }
        starts.push((from_m, section));
    }
    let Some((first_m, first)) = starts.first() else {
        return Err(text.element(group, "road", "has no lane section", "a `laneSection`"));
    };
    if *first_m != 0.0 {
        let reason = format!("the first lane section begins at s = {first_m} m");
        return Err(text.meaning(first, reason, "0"));
    }
    let (mut sections, mut links) = (Vec::new(), Vec::new());
    let ends: Vec<f64> = starts[1..].iter().map(|(from_m, _)| *from_m).collect();
    for ((from_m, element), to_m) in starts.into_iter().zip(ends.into_iter().chain([length_m])) {
        let (section, link) = read_section(text, element, (from_m, to_m), &offset)?;
        sections.push(section);
        links.push(link);
    }
    for number in 1..sections.len() {
        for (from, to) in pairs(&links[number - 1].after, &links[number].before, false) {
            sections[number - 1].lanes[from].after = Some(to);
            sections[number].lanes[to].before = Some(from);
        }
    }
    let first = links.first().map(|links| links.before.clone()).unwrap_or_default();
    let last = links.pop().map(|links| links.after).unwrap_or_default();
    Ok(Side { lanes: Lanes { offset, sections, length_m }, first, last })
}

/// The pairs of places of lanes that continue each other, by the links of either side. If no lane has a link, equal ids
/// belong together, or opposite ones if one of the roads is `turned`.
pub fn pairs(before: &[Link], after: &[Link], turned: bool) -> Vec<(usize, usize)> {
    let none = before.iter().chain(after).all(|link| link.to.is_none());
    let sign = if turned { -1 } else { 1 };
    let mut pairs = Vec::new();
    for (from, link) in before.iter().enumerate() {
        let is_next = |other: &&Link| match none {
            true => other.id == sign * link.id,
            false => link.to == Some(other.id),
        };
        let named = after.iter().position(|other| is_next(&other));
        let naming =
            || after.iter().position(|other| other.to == Some(link.id) && link.to.is_none());
        if let Some(to) = named.or_else(naming)
            && pairs.iter().all(|(_, other)| *other != to)
        {
            pairs.push((from, to));
        }
    }
    pairs
}

fn read_section(
    text: Text<'_>,
    element: &Element,
    (from_m, to_m): (f64, f64),
    offset: &Profile,
) -> Result<(Section, Links), ReadError> {
    let read = |side| {
        let lanes = read_side(text, element, side, from_m)?;
        resolve(text, lanes, side, (from_m, to_m), offset)
    };
    let (right, left) = (read("right")?, read("left")?);
    let left_count = left.len();
    let mut links = Links { before: Vec::new(), after: Vec::new() };
    let mut lanes = Vec::with_capacity(right.len() + left_count);
    for Outlined { lane, before, after, .. } in right.into_iter().rev().chain(left) {
        links.before.push(Link { id: lane.id, to: before });
        links.after.push(Link { id: lane.id, to: after });
        lanes.push(lane);
    }
    if lanes.is_empty() {
        return Err(text.element(element, "lanes", "has no lanes", "at least one lane"));
    }
    Ok((Section { from_m, lanes, left: left_count }, links))
}

/// The lanes of one side from the middle outwards. A lane with borders has no width yet.
fn read_side<'a>(
    text: Text<'_>,
    section: &'a Element,
    side: &'static str,
    from_m: f64,
) -> Result<Vec<Outlined<'a>>, ReadError> {
    let mut lanes: Vec<Outlined<'a>> = Vec::new();
    for element in children(section, side).flat_map(|group| children(group, "lane")) {
        let id = text.whole(element, "id")?;
        if id == 0 || (id > 0) != (side == "left") {
            let expected = "positive ids on the left, negative ones on the right";
            return Err(text.element(element, side, "has an id of the other side", expected));
        }
        if lanes.iter().any(|lane| lane.lane.id == id) {
            return Err(text.element(element, side, "is there twice", "lanes with different ids"));
        }
        let widths = children(element, "width").map(|width| text.stretch(width, "sOffset", from_m));
        let widths: Vec<_> = widths.collect::<Result<_, _>>()?;
        // If a lane has both, its widths count in the standard.
        let mut borders = Vec::new();
        if widths.is_empty() {
            for border in children(element, "border") {
                borders.push((border, text.stretch(border, "sOffset", from_m)?));
            }
            if borders.is_empty() {
                return Err(text.element(element, side, "has no width", "a `width` or a `border`"));
            }
        }
        if let Some((stretch, width)) = widths
            .iter()
            .zip(children(element, "width"))
            .find(|(w, _)| w.factors[0] < -MOST_BELOW_M)
        {
            let reason = format!("a width of {} m", stretch.factors[0]);
            return Err(text.meaning(width, reason, "at least 0 m"));
        }
        let link = |name: &str| {
            let to = element.child("link").and_then(|link| link.child(name));
            to.map(|to| text.whole(to, "id")).transpose()
        };
        let kind = element.attribute("type").unwrap_or("driving");
        let drivable = !NOT_DRIVABLE.contains(&kind);
        let width = Profile::new(widths);
        let lane = Lane { id, drivable, width, before: None, after: None };
        let (before, after) = (link("predecessor")?, link("successor")?);
        lanes.push(Outlined { lane, before, after, borders });
    }
    lanes.sort_by_key(|lane| lane.lane.id.abs());
    Ok(lanes)
}

/// A width below 0 up to which it is the rounding of a program that wrote the file, m.
const MOST_BELOW_M: f64 = 0.01;

/// A lane as its element describes it, by widths or by borders, with its links to the sections before and after.
struct Outlined<'a> {
    lane: Lane,
    before: Option<i32>,
    after: Option<i32>,
    borders: Vec<(&'a Element, Stretch)>,
}

/// Gives lanes with borders their widths. The lanes of a side come from the middle outwards.
///
/// A border is the distance of a lane's outer line from the reference line, positive to the left. The width of a lane is
/// the distance from the outer line of the lane inside it.
fn resolve<'a>(
    text: Text<'_>,
    mut lanes: Vec<Outlined<'a>>,
    side: &str,
    (from_m, to_m): (f64, f64),
    offset: &Profile,
) -> Result<Vec<Outlined<'a>>, ReadError> {
    let bordered = lanes.iter().find_map(|lane| lane.borders.first()).map(|(border, _)| *border);
    if let Some(border) = bordered
        && offset.stretches().iter().any(|stretch| stretch.factors != [0.0; 4])
    {
        let reason = "a `border` of a road with a `laneOffset`";
        return Err(text.meaning(border, reason, "widths, or no lane offset"));
    }
    let sign = if side == "left" { 1.0 } else { -1.0 };
    let mut outer = Profile::default();
    for Outlined { lane, borders, .. } in &mut lanes {
        if let Some((first, _)) = borders.first() {
            let line = Profile::new(borders.iter().map(|(_, stretch)| *stretch).collect());
            lane.width = Profile::sum(&[(sign, &line), (-1.0, &outer)], from_m, to_m);
            for stretch in lane.width.stretches() {
                let width_m = stretch.factors[0];
                if width_m < -MOST_BELOW_M {
                    let (id, at_m) = (lane.id, stretch.from_m);
                    let reason = format!("lane {id} has a width of {width_m:.3} m at s = {at_m} m");
                    let expected = "a border outside of the lanes inside it";
                    return Err(text.meaning(first, reason, expected));
                }
            }
        }
        if bordered.is_some() {
            outer = Profile::sum(&[(1.0, &outer), (1.0, &lane.width)], from_m, to_m);
        }
    }
    Ok(lanes)
}
