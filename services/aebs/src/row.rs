//! Rows of standing objects, and whether the road bends along one.
//!
//! Objects beside the road stand straight ahead before a curve: posts, a guard rail, a queue in the next lane. One of
//! them looks as a car that stands in the ego's lane. All of them together do not. They are on a line that comes
//! from *beside* the ego's lane and crosses the path ahead.
//!
//! ```text
//!           o     path
//!         ..o.............►      the row begins d0 beside the lane and bends across the path from σ = e on:
//!    ego    o                    d(σ) = d0 + c/2 max(0, σ - e)²
//!         o  o
//!    o o o                       a queue in the own lane begins in the path and never comes from beside it
//! ```
//!
//! Lines of that form go through a place and a second one, and hold others. All are more than [`APART_M`] from one
//! another. The best line from beside the lane competes with the best one from within it. The place is on such a row
//! if the first holds more places. They may be farther: the last car of a queue behind a curve is the nearest one.

use crate::object::MAX_OBJECTS;

/// Places of a row are at least this far apart, m: one vehicle may come out as several objects.
const APART_M: f64 = 6.0;
/// They are at most this far apart, m. Chosen: the length of a queue of six cars.
const REACH_M: f64 = 45.0;
/// Greatest distance of a place from its line, m: a car reflects at its corners and in its middle.
const ON_LINE_M: f64 = 0.8;
/// Distance from the middle of the way from which a line begins beside the lane, m: half a lane.
const BESIDE_M: f64 = 1.75;
/// Largest distance from the middle of the way at which a line begins in the ego's lane, m. It is half a car, and both
/// wander.
const IN_LANE_M: f64 = 1.25;
/// No road bends more against the ego's way, 1/m.
const SHARPEST_PERM: f64 = 1.0 / 100.0;
/// Step of the start of the bend, m.
const BEGIN_STEP_M: f64 = 5.0;

/// A place along the way and left of it, m.
type Place = (f64, f64);

/// True if `place` is on a row of the `standing` ones that begins beside the lane. The road may bend along it.
pub(crate) fn leads_to(standing: impl Iterator<Item = Place>, place: Place) -> bool {
    let mut apart = [(0.0, 0.0); MAX_OBJECTS];
    let is_apart = |other: &Place| (APART_M..REACH_M).contains(&(other.0 - place.0).abs());
    let count = apart.iter_mut().zip(standing.filter(is_apart)).map(|(to, from)| *to = from);
    let count = count.count();
    let apart = &apart[..count];
    let (mut most_beside, mut most_own) = (0, 0);
    let begins = (0..).map(|step| f64::from(step) * BEGIN_STEP_M);
    for begin_m in begins.take_while(|begin_m| *begin_m < place.0 - APART_M) {
        for &second in apart {
            let Some(line) = Line::through(begin_m, place, second) else { continue };
            let most = match line.at_m.abs() {
                off_m if off_m > BESIDE_M => &mut most_beside,
                off_m if off_m < IN_LANE_M => &mut most_own,
                _ => continue,
            };
            let is_third = |third: &&Place| (third.0 - second.0).abs() > APART_M;
            let held = apart.iter().filter(is_third).filter(|third| line.holds(**third));
            *most = held.count().max(*most);
        }
    }
    most_beside > most_own
}

/// The line `d(σ) = at + bend / 2 max(0, σ - begin)²`.
struct Line {
    begin_m: f64,
    at_m: f64,
    bend_perm: f64,
}

impl Line {
    /// The line through two places that bends from `begin_m` on; `None` if no road bends like that.
    fn through(begin_m: f64, place: Place, second: Place) -> Option<Self> {
        let (p, q) = ((second.0 - begin_m).max(0.0), place.0 - begin_m);
        let bend_perm = 2.0 * (place.1 - second.1) / (q * q - p * p);
        let at_m = place.1 - 0.5 * bend_perm * q * q;
        (bend_perm.abs() <= SHARPEST_PERM).then_some(Self { begin_m, at_m, bend_perm })
    }

    fn holds(&self, place: Place) -> bool {
        let bent_m = (place.0 - self.begin_m).max(0.0);
        let line_m = self.at_m + 0.5 * self.bend_perm * bent_m * bent_m;
        (place.1 - line_m).abs() < ON_LINE_M
    }
}

#[cfg(test)]
mod tests;
