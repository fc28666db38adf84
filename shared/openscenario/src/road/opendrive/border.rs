//! Lanes that are described by their outer borders instead of their widths.
//!
//! A border is the distance of a lane's outer line from the reference line, positive to the left. The width of a lane is
//! the distance from the outer line of the lane inside it.

use road::{Lane, Profile, Stretch};

use super::text::Text;
use crate::error::ReadError;
use crate::xml::Element;

/// A width below 0 up to which it is the rounding of a program that wrote the file, m.
pub const MOST_BELOW_M: f64 = 0.01;

/// A lane as its element describes it, by widths or by borders, with its links to the sections before and after.
pub struct Outlined<'a> {
    pub lane: Lane,
    pub before: Option<i32>,
    pub after: Option<i32>,
    pub borders: Vec<(&'a Element, Stretch)>,
}

/// Gives lanes with borders their widths. The lanes of a side come from the middle outwards.
pub fn resolve<'a>(
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
