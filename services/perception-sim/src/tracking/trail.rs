//! Trails of other vehicles: where they drove, in the ego's axes.
//!
//! Places are kept in the axes of dead reckoning by speed, yaw rate and slip angle. So the ego's motion moves none of
//! them. Its error grows with the way; over a trail's length it is small.

use super::motion::Frame;

/// Places of a trail.
const PLACES: usize = 24;
/// Trails at most.
pub const TRAILS: usize = 8;
/// Way of the ego between two places of a trail, m.
const SPACING_M: f64 = 5.0;
/// A trail ends when its vehicle has not been seen over this way of the ego, m.
const FORGOTTEN_M: f64 = 60.0;
/// Fewest places ahead of the ego in a trail that is used.
const FEWEST: usize = 4;
/// Distance ahead from which a place is used, m.
const AHEAD_M: f64 = 2.0;

#[derive(Clone, Copy, Debug, Default)]
pub struct Trails([Trail; TRAILS]);

#[derive(Clone, Copy, Debug, Default)]
struct Trail {
    /// Identity of the track; 0: unused.
    id: u32,
    /// The places, a ring.
    places: [(f64, f64); PLACES],
    /// Places ever left.
    count: usize,
    /// Way of the ego at the last one, m.
    last_m: f64,
}

impl Trails {
    /// A vehicle is at a point of the body's axes, m.
    pub fn leave(&mut self, ego: &Frame, id: u32, point_m: (f64, f64)) {
        let way_m = ego.way_m;
        let known = self.0.iter().position(|trail| trail.id == id);
        let free = || {
            let is_free = |trail: &Trail| trail.id == 0 || way_m - trail.last_m > FORGOTTEN_M;
            self.0.iter().position(is_free)
        };
        let Some(index) = known.or_else(free) else { return };
        let trail = &mut self.0[index];
        if trail.id != id || way_m - trail.last_m > FORGOTTEN_M {
            *trail = Trail { id, last_m: way_m - SPACING_M, ..Trail::default() };
        }
        if way_m - trail.last_m >= SPACING_M {
            trail.places[trail.count % PLACES] = ego.placed(point_m);
            trail.count += 1;
            trail.last_m = way_m;
        }
    }

    /// Drops a vehicle's trail: it has left its lane.
    pub fn forget(&mut self, id: u32) {
        self.0.iter_mut().filter(|trail| trail.id == id).for_each(|trail| trail.id = 0);
    }

    /// Calls back with pairs of places of each trail in the body's axes: the nearest ahead, and a farther one. Each
    /// trail has two of these.
    pub fn pairs(&self, ego: &Frame, mut each: impl FnMut((f64, f64), (f64, f64))) {
        for trail in self.0.iter().filter(|trail| trail.id != 0) {
            let oldest = trail.count.saturating_sub(PLACES);
            let place = |index: usize| ego.seen(trail.places[index % PLACES]);
            let Some(first) = (oldest..trail.count).find(|&index| place(index).0 > AHEAD_M) else {
                continue;
            };
            let ahead = trail.count - first;
            if ahead >= FEWEST {
                each(place(first), place(trail.count - 1));
                each(place(first), place(trail.count - 1 - (ahead - 1) / 2));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::motion::Motion;
    use super::*;

    /// Pairs that a lead 60 m ahead leaves on a circle of `radius_m` in `scans` scans at 30 m/s.
    fn follow(radius_m: f64, scans: u32) -> Vec<((f64, f64), (f64, f64))> {
        let motion = Motion { speed_mps: 30.0, ..Motion::default() };
        let angle = 60.0 / radius_m;
        let ahead = (radius_m * libm::sin(angle), radius_m * (1.0 - libm::cos(angle)));
        let (mut ego, mut trails) = (Frame::default(), Trails::default());
        for _ in 0..scans {
            ego.advance(0.05, &motion, 0.05 * 30.0 / radius_m);
            trails.leave(&ego, 7, ahead);
        }
        let mut pairs = Vec::new();
        trails.pairs(&ego, |near, far| pairs.push((near, far)));
        pairs
    }

    #[test]
    fn a_lead_on_a_circle_leaves_its_trail_on_the_circle() {
        let pairs = follow(400.0, 60);
        assert_eq!(pairs.len(), 2);
        for place in pairs.into_iter().flat_map(|(near, far)| [near, far]) {
            let radius_m = place.0.hypot(place.1 - 400.0);
            assert!((radius_m - 400.0).abs() < 0.02, "{place:?}");
        }
        let ((near, _), (far, _)) = follow(400.0, 60)[0];
        assert!(near < 8.0 && far > 50.0, "{near} to {far}");
    }

    #[test]
    fn a_short_trail_is_not_used_and_a_forgotten_one_neither() {
        assert!(follow(400.0, 8).is_empty());
        let (mut ego, mut trails) = (Frame::default(), Trails::default());
        let motion = Motion { speed_mps: 20.0, ..Motion::default() };
        for _ in 0..20 {
            ego.advance(0.05, &motion, 0.0);
            trails.leave(&ego, 1, (40.0, 0.0));
        }
        trails.forget(1);
        trails.pairs(&ego, |_, _| panic!("it is forgotten"));
    }

    #[test]
    fn a_place_is_left_every_five_metres_and_four_of_them_are_used() {
        let motion = Motion { speed_mps: 20.0, ..Motion::default() };
        let pairs = |scans: u32, pause_m: f64| {
            let (mut ego, mut trails) = (Frame::default(), Trails::default());
            for scan in 0..scans {
                // A metre a scan; once a pause in which the vehicle is not seen.
                ego.advance(0.05, &motion, 0.0);
                ego.advance(if scan == 12 { pause_m / 20.0 } else { 0.0 }, &motion, 0.0);
                trails.leave(&ego, 1, (140.0, 2.0));
            }
            let mut pairs = Vec::new();
            trails.pairs(&ego, |near, far| pairs.push((near, far)));
            pairs
        };
        assert!(pairs(15, 0.0).is_empty(), "three places");
        // The first place is 15 m behind the last one, and the middle one 5 m behind it.
        assert_eq!(pairs(16, 0.0), [((125.0, 2.0), (140.0, 2.0)), ((125.0, 2.0), (135.0, 2.0))]);
        assert!(!pairs(20, 57.0).is_empty(), "it goes on after 59 m");
        assert!(pairs(20, 62.0).is_empty(), "it begins anew");
    }

    #[test]
    fn more_vehicles_than_trails_leave_the_first_ones_in_peace() {
        let (mut ego, mut trails) = (Frame::default(), Trails::default());
        let motion = Motion { speed_mps: 20.0, ..Motion::default() };
        for _ in 0..40 {
            ego.advance(0.05, &motion, 0.0);
            (1..=12).for_each(|id| trails.leave(&ego, id, (40.0, f64::from(id))));
        }
        let mut count = 0;
        trails.pairs(&ego, |near, far| {
            count += 1;
            assert!((near.1 - far.1).abs() < 1e-9, "of one vehicle");
        });
        assert_eq!(count, 2 * TRAILS);
    }
}
