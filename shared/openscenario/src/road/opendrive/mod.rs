//! Reader of OpenDRIVE files.

mod geometry;
mod lanes;
mod row;
mod text;

#[cfg(test)]
mod tests;

use road::MIN_RADIUS_M;

use super::Road;
use crate::error::{ReadError, one_of};
use crate::scene::MOST_LISTED;
use crate::xml::{Document, Element};
use geometry::Line;
pub(crate) use row::Start;
use row::{Member, outside_junctions};
pub use text::Text;
use text::children;

#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    pub road: Road,
    /// Notes for a person on how the file was understood, a sentence each.
    pub notices: Vec<String>,
}

/// Reads the road `id` of an OpenDRIVE file with the roads that follow and precede it by their links. Without an id it
/// is the only road or row of roads.
///
/// # Errors
/// When there is no such road, or it cannot be driven.
pub fn read(document: &Document, id: Option<&str>) -> Result<Found, ReadError> {
    let text = Text { file: &document.file };
    let root = &document.root;
    if root.name != "OpenDRIVE" {
        return Err(text.element(root, "the file", "is not supported", "`OpenDRIVE`"));
    }
    let roads: Vec<&Element> = children(root, "road").collect();
    let open: Vec<&Element> =
        roads.iter().copied().filter(|road| outside_junctions(road)).collect();
    let named = |road: &&&Element| id.is_some() && road.attribute("id") == id;
    if let Some(second) = roads.iter().filter(named).nth(1) {
        let (fault, expected) = ("has the id of another road", "an id of its own");
        return Err(text.element(second, "OpenDRIVE", fault, expected));
    }
    let around =
        |road: &&Element| row::read(document, Member { road, reversed: false, by: None }, None);
    let found = match (id, open.first()) {
        (Some(_), _) => roads.iter().find(|road| named(road)).map(around),
        (None, Some(road)) => Some(around(road)).filter(|found| {
            open.len() == 1 || found.as_ref().is_ok_and(|it| it.road.parts.len() == open.len())
        }),
        (None, None) => {
            let reason = match roads.len() {
                0 => "this file has no road".to_owned(),
                count => format!("each of the {count} roads in this file belongs to a junction"),
            };
            return Err(text.meaning(root, reason, "a road outside of junctions"));
        }
    };
    found.unwrap_or_else(|| Err(unnamed(text, root, id, if id.is_some() { &roads } else { &open })))
}

/// The nearest road outside of junctions that can be driven, with the place of a point along and across it, m.
pub(crate) fn nearest(document: &Document, x_m: f64, y_m: f64) -> Option<(&str, f64, f64)> {
    let text = Text { file: &document.file };
    let place = |road: &'_ Element| {
        let line = Line::read(text, road).ok()?;
        let (x_m, y_m) = line.pieces.first()?.start.to_local(x_m, y_m);
        let (s_m, t_m) = line.axis(text, MIN_RADIUS_M).ok()?.nearest(x_m, y_m);
        Some((libm::hypot(s_m - s_m.clamp(0.0, line.length_m), t_m), s_m, t_m))
    };
    let roads = children(&document.root, "road").filter(|road| outside_junctions(road));
    let places = roads.filter_map(|road| Some((place(road)?, road.attribute("id")?)));
    places.min_by(|a, b| a.0.0.total_cmp(&b.0.0)).map(|((_, s_m, t_m), id)| (id, s_m, t_m))
}

/// The error where no road, or no single one, is named.
fn unnamed(text: Text<'_>, root: &Element, id: Option<&str>, roads: &[&Element]) -> ReadError {
    let ids = roads.iter().filter_map(|road| road.attribute("id"));
    let first = match ids.clone().next() {
        Some(_) => one_of(ids.take(MOST_LISTED)),
        None => "a road with an id".to_owned(),
    };
    let rest = match roads.len().saturating_sub(MOST_LISTED) {
        0 => String::new(),
        rest => format!(" (and {rest} more)"),
    };
    let (reason, wanted) = match id {
        Some(id) => (format!("there is no road `{id}` in this file"), first + &rest),
        None => (
            format!("this file has {} roads and no position names the ego's", roads.len()),
            format!("a lane or road position of the ego with the `roadId` {first}{rest}"),
        ),
    };
    text.meaning(root, reason, wanted)
}
