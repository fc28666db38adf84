//! Rows of standing places, and whether the road bends along one.
//!
//! Objects beside the road stand straight ahead before a curve: posts, a guard rail, a queue in the next lane. One echo
//! of them looks as a car that stands in the ego's lane. All of them together do not. They are on a line that comes
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
//! [`Places`] keeps what stood in the last scans. Lines of that form go through a place and a second one, and hold
//! others. All are more than [`APART_M`] from one another. The best line from beside the lane competes with
//! the best one from within it. The place is on such a row if the first holds more places. They may be farther: the last
//! car of a queue behind a curve is the nearest one.

use crate::object::Object;

/// Most places that are kept.
const MAX_PLACES: usize = 96;
/// Places farther beside the way are left out, m: what stands beyond the road's edge.
const WIDEST_M: f64 = 12.0;
/// A point is of a known place if it is this near, m along and across.
const SAME_M: (f64, f64) = (1.5, 1.2);
/// Gain of a new point on a place.
const GAIN: f64 = 0.3;
/// Times that a place must be seen to count: one false alarm is not a place.
const SEEN: u32 = 2;
/// A place is dropped after this time, s, and this far behind the bumper, m.
const KEPT_S: f64 = 3.0;
const BEHIND_M: f64 = 15.0;
/// Places of a row are at least this far apart, m: one vehicle shows several echoes.
const APART_M: f64 = 6.0;
/// They are at most this far apart, m. Chosen: the length of a queue of six cars.
const REACH_M: f64 = 45.0;
/// Greatest distance of a place from its line, m: a car reflects at its corners and in its middle.
const ON_LINE_M: f64 = 0.8;
/// Distance from the middle of the way from which a line begins beside the lane, m: half a lane. The inner side of a
/// lorry in the next lane is 2.2 m off, and the ego wanders.
const BESIDE_M: f64 = 1.75;
/// Half of the width of a vehicle, m.
const HALF_WIDTH_M: f64 = 0.9;
/// Largest distance from the middle of the way at which a line begins in the ego's lane, m. It is half a car, and both
/// wander.
const IN_LANE_M: f64 = 1.25;
/// No road bends more against the ego's way, 1/m.
const SHARPEST_PERM: f64 = 1.0 / 100.0;
/// Step of the start of the bend, m.
const BEGIN_STEP_M: f64 = 5.0;

/// A standing place on the ego's way.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    along_m: f64,
    off_m: f64,
    seen: u32,
    unseen_s: f64,
    /// It was seen in this scan.
    is_fresh: bool,
}

/// The standing places around the ego's way.
#[derive(Clone, Debug)]
pub struct Places {
    list: Vec<Place>,
}

impl Default for Places {
    /// An empty list with room for all places.
    fn default() -> Self {
        Self { list: Vec::with_capacity(MAX_PLACES) }
    }
}

impl Places {
    /// Drops all places.
    pub(crate) fn clear(&mut self) {
        self.list.clear();
    }

    /// Moves on by `period_s`, in which the ego drove `way_m`. Places are `seen` from the next circle then.
    pub(crate) fn move_on(
        &mut self,
        seen: impl Fn((f64, f64)) -> (f64, f64),
        period_s: f64,
        way_m: f64,
    ) {
        for place in &mut self.list {
            (place.along_m, place.off_m) = seen((place.along_m - way_m, place.off_m));
            place.unseen_s += period_s;
            place.is_fresh = false;
        }
        self.list.retain(|place| {
            let longest_s = if place.seen < SEEN { 2.5 * period_s } else { KEPT_S };
            place.unseen_s <= longest_s && place.along_m > -BEHIND_M
        });
    }

    /// Takes a standing point of the present scan.
    pub(crate) fn take(&mut self, along_m: f64, off_m: f64) {
        if off_m.abs() > WIDEST_M {
            return;
        }
        let is_full = self.list.len() == MAX_PLACES;
        let known = self.list.iter_mut().find(|place| {
            (place.along_m - along_m).abs() < SAME_M.0 && (place.off_m - off_m).abs() < SAME_M.1
        });
        match known {
            Some(place) => {
                place.along_m += GAIN * (along_m - place.along_m);
                place.off_m += GAIN * (off_m - place.off_m);
                place.seen += u32::from(!place.is_fresh);
                (place.unseen_s, place.is_fresh) = (0.0, true);
            }
            None if !is_full => {
                self.list.push(Place { along_m, off_m, seen: 1, unseen_s: 0.0, is_fresh: true });
            }
            None => {}
        }
    }

    /// True if an object is on a row from beside the lane. Only what the ego would brake for is asked about: the search
    /// is long.
    pub(crate) fn have_on_row(&self, object: &Object) -> bool {
        object.row_m.is_some_and(|(along_m, off_m)| self.lead_to(along_m, off_m))
    }

    /// True if this place is on a row of standing places that begins beside the lane. The road may bend along it.
    ///
    /// A line from beside the lane then holds more places than any from the middle of the ego's own lane. A queue in
    /// the ego's lane is on a line from that middle. The inner edge of a vehicle in a queue is seen. So its middle may
    /// be half a width farther out.
    fn lead_to(&self, along_m: f64, off_m: f64) -> bool {
        let mut apart = [(0.0, 0.0); MAX_PLACES];
        let mut count = 0;
        for place in self.seen_apart(along_m) {
            apart[count] = (place.along_m, place.off_m);
            count += 1;
        }
        let apart = &apart[..count];
        let outer_m = off_m + HALF_WIDTH_M * off_m.signum();
        let (mut most_beside, mut most_own) = (0, 0);
        for place in [(along_m, off_m), (along_m, outer_m)] {
            for &second in apart {
                let begins = (0..).map(|step| f64::from(step) * BEGIN_STEP_M);
                for begin_m in begins.take_while(|begin_m| *begin_m < along_m - APART_M) {
                    let Some(line) = Line::through(begin_m, place, second) else { continue };
                    let most = if line.begins_beside() {
                        &mut most_beside
                    } else if line.begins_in_lane() {
                        &mut most_own
                    } else {
                        continue;
                    };
                    let held = apart.iter().filter(|third| {
                        (third.0 - second.0).abs() > APART_M && line.holds(third.0, third.1)
                    });
                    *most = held.count().max(*most);
                }
            }
        }
        most_beside > most_own
    }

    /// The places that count, apart from one at this distance.
    fn seen_apart(&self, along_m: f64) -> impl Iterator<Item = &Place> {
        self.list
            .iter()
            .filter(move |place| place.seen >= SEEN)
            .filter(move |place| (APART_M..REACH_M).contains(&(place.along_m - along_m).abs()))
    }
}

/// The line `d(σ) = begins at + bend / 2 max(0, σ - begin)²`.
struct Line {
    begin_m: f64,
    at_m: f64,
    bend_perm: f64,
}

impl Line {
    /// The line through two places that bends from `begin_m` on; `None` if no road bends like that.
    fn through(
        begin_m: f64,
        (along_m, off_m): (f64, f64),
        (second_along_m, second_off_m): (f64, f64),
    ) -> Option<Self> {
        let (p, q) = ((second_along_m - begin_m).max(0.0), along_m - begin_m);
        let bend_perm = 2.0 * (off_m - second_off_m) / (q * q - p * p);
        let at_m = off_m - 0.5 * bend_perm * q * q;
        (bend_perm.abs() <= SHARPEST_PERM).then_some(Self { begin_m, at_m, bend_perm })
    }

    /// It comes from beside the lane.
    fn begins_beside(&self) -> bool {
        self.at_m.abs() > BESIDE_M
    }

    fn begins_in_lane(&self) -> bool {
        self.at_m.abs() < IN_LANE_M
    }

    fn holds(&self, along_m: f64, off_m: f64) -> bool {
        let bent_m = (along_m - self.begin_m).max(0.0);
        let line_m = self.at_m + 0.5 * self.bend_perm * bent_m * bent_m;
        (off_m - line_m).abs() < ON_LINE_M
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::circle::Circle;

    /// Places as an ego on a straight sees them whose lane bends with `radius_m` in `begin_m`.
    fn before_a_curve(begin_m: f64, radius_m: f64, places: &[(f64, f64)]) -> Places {
        let curve = Circle { curvature_perm: 1.0 / radius_m, heading_rad: 0.0 };
        let mut kept = Places::default();
        for _ in 0..3 {
            for (along_m, off_m) in places {
                let (x_m, y_m) = if *along_m < begin_m {
                    (*along_m, *off_m)
                } else {
                    let (x_m, y_m) = curve.to_body(along_m - begin_m, *off_m);
                    (begin_m + x_m, y_m)
                };
                kept.take(x_m, y_m);
            }
            kept.move_on(|place| place, 0.05, 0.0);
        }
        kept
    }

    /// Places as an ego in a curve sees them that ends `end_m` ahead, on the circle that it drives.
    fn in_a_curve(end_m: f64, radius_m: f64, places: &[(f64, f64)]) -> Places {
        let curve = Circle { curvature_perm: 1.0 / radius_m, heading_rad: 0.0 };
        let (sine, cosine) = libm::sincos(curve.curvature_perm * end_m);
        let (end_x_m, end_y_m) = curve.to_body(end_m, 0.0);
        let mut kept = Places::default();
        for _ in 0..3 {
            for &(along_m, off_m) in places {
                let beyond_m = along_m - end_m;
                let place = if beyond_m < 0.0 {
                    (along_m, off_m)
                } else {
                    curve.to_way(
                        end_x_m + beyond_m * cosine - off_m * sine,
                        end_y_m + beyond_m * sine + off_m * cosine,
                    )
                };
                kept.take(place.0, place.1);
            }
            kept.move_on(|place| place, 0.05, 0.0);
        }
        kept
    }

    /// Those places that stand in the path straight ahead.
    fn in_path(places: &Places) -> Vec<(f64, f64)> {
        let ahead = places.list.iter().filter(|place| place.off_m.abs() < 1.9);
        ahead.map(|place| (place.along_m, place.off_m)).collect()
    }

    fn row(first_m: f64, step_m: f64, off_m: f64) -> Vec<(f64, f64)> {
        (0..12).map(|k| (first_m + step_m * f64::from(k), off_m)).collect()
    }

    #[test]
    fn a_queue_in_the_next_lane_of_a_curve_ahead_stands_beside_it() {
        for radius_m in [125.0, 250.0, 500.0, 1000.0] {
            for begin_m in [0.0, 20.0, 40.0] {
                let queue = row(5.0, 8.0, -3.5);
                let places = before_a_curve(begin_m, radius_m, &queue);
                let ahead = in_path(&places);
                assert!(radius_m > 500.0 || !ahead.is_empty(), "{radius_m} {begin_m}");
                for (along_m, off_m) in ahead {
                    assert!(places.lead_to(along_m, off_m), "{radius_m} {begin_m} {along_m}");
                }
            }
        }
    }

    #[test]
    fn the_same_on_the_other_side() {
        let places = before_a_curve(10.0, -125.0, &row(5.0, 8.0, 3.5));
        let ahead = in_path(&places);
        assert!(!ahead.is_empty() && ahead.iter().all(|(x, y)| places.lead_to(*x, *y)));
    }

    #[test]
    fn the_last_car_of_a_queue_beside_the_road_behind_a_curve_is_on_its_row() {
        for (radius_m, end_m) in [(125.0, 2.0), (-125.0, 2.0)] {
            let inner_m = 3.5 * f64::signum(radius_m);
            let places = in_a_curve(end_m, radius_m, &row(22.0, 7.5, inner_m));
            let last = places.list[0];
            assert!(last.off_m.abs() < 2.6, "{radius_m}: in the way, {last:?}");
            assert!(places.lead_to(last.along_m, last.off_m), "{radius_m} {places:?}");
        }
    }

    #[test]
    fn a_queue_in_the_own_lane_is_no_such_row_on_an_arc_or_behind_it() {
        for radius_m in [125.0, -250.0, 500.0] {
            for end_m in [10.0, 30.0, 500.0] {
                for off_m in [-0.4, 0.0, 0.4] {
                    let places = in_a_curve(end_m, radius_m, &row(25.0, 7.5, off_m));
                    let last = places.list[0];
                    if last.off_m.abs() < 1.9 {
                        let leads = places.lead_to(last.along_m, last.off_m);
                        assert!(!leads, "{radius_m} {end_m} {off_m}");
                    }
                }
            }
        }
    }

    #[test]
    fn posts_of_a_curve_ahead_stand_beside_it() {
        for radius_m in [125.0, 250.0, 500.0] {
            for first_m in [4.0, 9.0, 14.0, 19.0] {
                let places = before_a_curve(0.0, radius_m, &row(first_m - 20.0, 20.0, -8.0));
                for (along_m, off_m) in in_path(&places) {
                    assert!(places.lead_to(along_m, off_m), "{radius_m} {first_m} {along_m}");
                }
            }
        }
    }

    #[test]
    fn a_queue_in_the_own_lane_is_no_row_from_beside_it() {
        for radius_m in [125.0, -250.0, 500.0, 1e9] {
            for begin_m in [0.0, 20.0, 60.0] {
                let mut standing = row(45.0, 7.5, 0.0);
                standing.extend(row(3.0, 20.0, -8.0));
                standing.extend(row(8.0, 20.0, 8.0));
                let places = before_a_curve(begin_m, radius_m, &standing);
                let (x_m, y_m) = {
                    let curve = Circle { curvature_perm: 1.0 / radius_m, heading_rad: 0.0 };
                    let beyond_m: f64 = 45.0 - begin_m;
                    let (x_m, y_m) = curve.to_body(beyond_m.max(0.0), 0.0);
                    (begin_m.min(45.0) + x_m, y_m)
                };
                if y_m.abs() < 1.9 {
                    assert!(!places.lead_to(x_m, y_m), "{radius_m} {begin_m}");
                }
            }
        }
    }

    #[test]
    fn queues_in_both_lanes_leave_the_nearest_car_of_the_own_one_in_the_way() {
        let mut standing = row(40.0, 7.5, 0.0);
        standing.extend(row(30.0, 7.5, -3.5));
        for radius_m in [250.0, -250.0, 1e9] {
            let places = before_a_curve(40.0, radius_m, &standing);
            assert!(!places.lead_to(40.0, 0.0), "{radius_m}");
        }
    }

    #[test]
    fn one_sighting_is_no_place_and_old_ones_are_forgotten() {
        let mut places = Places::default();
        for (along_m, off_m) in row(5.0, 8.0, -3.5) {
            places.take(along_m, off_m + along_m * along_m / 250.0);
        }
        assert!(!places.lead_to(29.0, 0.0), "seen once");
        for _ in 0..3 {
            places.move_on(|place| place, 0.05, 0.0);
        }
        assert!(places.list.is_empty());
        let mut places = before_a_curve(0.0, 125.0, &row(5.0, 8.0, -3.5));
        places.move_on(|place| place, 1.0, 40.0);
        assert!(places.list.iter().all(|place| place.along_m > -BEHIND_M));
        assert!(!places.list.is_empty());
    }

    #[test]
    fn there_is_an_end_to_what_is_kept() {
        let mut places = Places::default();
        for k in 0..1000 {
            places.take(2.0 * f64::from(k), 5.0);
        }
        assert_eq!(places.list.len(), MAX_PLACES);
        assert_eq!(places.list.capacity(), MAX_PLACES);
    }
}
