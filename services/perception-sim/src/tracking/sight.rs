//! Share of the expected detections that come.
//!
//! Each scan is compared with the predictions of the previous one. A tracked vehicle in view should give a detection
//! again. So should a post beside the road, moved by the ego's own motion. The share is
//!
//! ```text
//!           Σ w · seen            seen: 1 if a detection came, else 0
//! share  =  ──────────            expected: probability of detection of a sound radar
//!           Σ w · expected        w: exp(-age / memory)
//! ```
//!
//! A radar that sees nothing at all has nothing to compare. The map predicts posts then. If none comes, though
//! [`Numbers::promised`] were to be seen, the share is 0.
//!
//! ```
//! use perception_sim::tracking::numbers::Numbers;
//! use perception_sim::tracking::sight::Share;
//!
//! let mut share = Share::new(&Numbers::DEFAULT);
//! for scan in 0..200 {
//!     share.forget(0.05);
//!     share.observe(1.0, scan % 4 == 0);
//! }
//! assert!((share.value() - 0.25).abs() < 0.05);
//! ```

use messages::Detection;

use super::association::Point;
use super::birth;
use super::course::Course;
use super::numbers::Numbers;
use super::track::FieldOfView;

/// Most posts that are compared.
const MAX_POSTS: usize = 128;

/// A share of expected events with a fading memory.
#[derive(Clone, Copy, Debug)]
pub struct Share {
    seen: f64,
    expected: f64,
    memory_s: f64,
}

impl Share {
    /// A sound radar is assumed.
    pub fn new(numbers: &Numbers) -> Self {
        let Numbers { assumed, memory_s, .. } = *numbers;
        Self { seen: assumed, expected: assumed, memory_s }
    }

    /// Lets `dt_s` pass.
    pub fn forget(&mut self, dt_s: f64) {
        let kept = libm::exp(-dt_s / self.memory_s);
        self.seen *= kept;
        self.expected *= kept;
    }

    /// Takes an event that was expected with a probability, and whether it came.
    pub fn observe(&mut self, probability: f64, came: bool) {
        self.expected += probability;
        self.seen += f64::from(u8::from(came));
    }

    /// The share, at most 1. It stays as it is while nothing is expected.
    pub fn value(&self) -> f64 {
        if self.expected > 0.0 { (self.seen / self.expected).min(1.0) } else { 1.0 }
    }
}

/// The estimate of a radar that gives detections.
#[derive(Clone, Debug)]
pub struct Sight {
    numbers: Numbers,
    share: Share,
    /// Posts where they were last seen, m ahead and to the left.
    posts: Vec<(f64, f64)>,
    /// Posts that a scan should show according to the map.
    promised_per_scan: f64,
    strong_db: f64,
    /// Posts that were promised since a scan showed a post or a vehicle.
    promised: f64,
}

impl Sight {
    /// A radar with this threshold, dB, on a road with this number of posts on each side of a kilometre.
    pub fn new(threshold_db: f64, posts_per_km: f64, numbers: &Numbers) -> Self {
        Self {
            numbers: *numbers,
            share: Share::new(numbers),
            posts: Vec::with_capacity(MAX_POSTS),
            promised_per_scan: 2e-3 * posts_per_km * numbers.reach_m,
            strong_db: threshold_db + numbers.strong_db,
            promised: 0.0,
        }
    }

    /// Takes a vehicle that was tracked before this scan and should be in it.
    pub fn observe_track(&mut self, seen: bool) {
        self.share.observe(self.numbers.track_again, seen);
    }

    /// Takes that this scan showed a tracked vehicle, wherever: a near one hides all posts.
    pub fn saw_a_vehicle(&mut self) {
        self.promised = 0.0;
    }

    /// Takes the posts of a scan, `dt_s` after the one before, of an ego with `ego_mps`. Allocates nothing.
    pub fn take_scan(
        &mut self,
        dt_s: f64,
        ego_mps: f64,
        points: &[Point],
        detections: &[Detection],
        (view, course): (&FieldOfView, &Course),
    ) {
        let numbers = &self.numbers;
        self.share.forget(dt_s);
        let stands = |point: &&Point| {
            !birth::moves(point, numbers)
                && point.y_m.abs() > numbers.posts_from_m
                && point.x_m > 0.0
        };
        for &(before_m, y_m) in &self.posts {
            let x_m = before_m - ego_mps * dt_s;
            let (ahead_m, left_m) = course.place(x_m, y_m);
            if view.shows(ahead_m, left_m) {
                let again = points.iter().any(|point| {
                    (point.x_m - x_m).abs() < numbers.post_along_m
                        && (point.y_m - y_m).abs() < numbers.post_across_m
                        && stands(&point)
                });
                self.share.observe(numbers.post_again, again);
            }
        }
        self.posts.clear();
        let mut any = false;
        for point in points.iter().filter(stands).filter(|point| point.x_m < numbers.reach_m) {
            any = true;
            let is_strong = detections[point.detection].snr_db > self.strong_db;
            if is_strong && self.posts.len() < MAX_POSTS {
                self.posts.push((point.x_m, point.y_m));
            }
        }
        self.promised = if any { 0.0 } else { self.promised + self.promised_per_scan };
    }

    /// Share of the expected detections that came.
    pub fn share(&self) -> f64 {
        if self.promised >= self.numbers.promised { 0.0 } else { self.share.value() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::association::tests::point;
    use super::*;
    use bytemuck::Zeroable;

    const VIEW: FieldOfView = FieldOfView { half_rad: 0.52, resolution_rad: 0.05, edge_rad: 0.05 };

    /// The share after 4 s of posts every 10 m at 20 m/s. The scans for which `sees` is true show all of them.
    fn drive(sees: impl Fn(u32) -> bool) -> f64 {
        let mut sight = Sight::new(12.0, 50.0, &Numbers::DEFAULT);
        let strong = [Detection { snr_db: 30.0, ..Detection::zeroed() }; 16];
        for scan in 0..80 {
            let moved_m = f64::from(scan % 10);
            let posts = (0..6).map(|k| Point {
                ground_speed_mps: 0.0,
                ..point(20.0 + 10.0 * f64::from(k) - moved_m, 8.0, -20.0)
            });
            let points: Vec<Point> = if sees(scan) { posts.collect() } else { Vec::new() };
            sight.take_scan(0.05, 20.0, &points, &strong, (&VIEW, &Course::STRAIGHT));
        }
        sight.share()
    }

    #[test]
    fn the_share_is_what_came_of_what_was_expected() {
        // The sound radar that is assumed counts as four scans.
        let mut share = Share::new(&Numbers::DEFAULT);
        assert_eq!(share.value(), 1.0);
        share.observe(0.5, false);
        share.observe(0.25, false);
        assert!((share.value() - 4.0 / 4.75).abs() < 1e-12);
        share.observe(0.75, true);
        assert!((share.value() - 5.0 / 5.5).abs() < 1e-12);
        // The past counts as little as e^-1 after the memory; the share stays.
        share.forget(1.0);
        assert!((share.value() - 5.0 / 5.5).abs() < 1e-12);
        share.observe(1.0, false);
        let kept = libm::exp(-1.0);
        assert!((share.value() - 5.0 * kept / (5.5 * kept + 1.0)).abs() < 1e-12);
        share.observe(0.1, true);
        (0..9).for_each(|_| share.observe(0.0, true));
        assert_eq!(share.value(), 1.0, "no more than all");
    }

    /// The share after two scans. The first has a post at one place, the second one at another, 0.05 s later at 20 m/s.
    fn seen_again(first: (f64, f64), snr_db: f64, then: (f64, f64)) -> f64 {
        let mut sight = Sight::new(12.0, 0.0, &Numbers::DEFAULT);
        let echo = [Detection { snr_db, ..Detection::zeroed() }];
        for (x_m, y_m) in [first, then] {
            let post = Point { ground_speed_mps: 0.0, ..point(x_m, y_m, -20.0) };
            sight.take_scan(0.05, 20.0, &[post], &echo, (&VIEW, &Course::STRAIGHT));
        }
        sight.share()
    }

    #[test]
    fn a_post_comes_again_where_the_ego_has_moved_it() {
        // Four assumed scans that fade, and one post of which 0.9 are expected.
        let faded = 4.0 * libm::exp(-0.1);
        let missed = faded / (faded + 0.9);
        let at = |x_m: f64, y_m: f64| seen_again((40.0, 8.0), 30.0, (x_m, y_m));
        for (x_m, y_m) in [(39.0, 8.0), (39.9, 8.0), (38.1, 8.0), (39.0, 9.9), (39.0, 6.1)] {
            assert_eq!(at(x_m, y_m), 1.0, "{x_m} {y_m}");
        }
        for (x_m, y_m) in [(40.1, 8.0), (37.9, 8.0), (39.0, 10.1), (39.0, 5.9), (39.0, -8.0)] {
            assert!((at(x_m, y_m) - missed).abs() < 1e-12, "{x_m} {y_m}: {}", at(x_m, y_m));
        }
        // An object that is weak, far, in the lanes or at the edge of the view is not expected again.
        for (first, snr_db) in
            [((40.0, 8.0), 21.9), ((80.1, 8.0), 30.0), ((40.0, 4.9), 30.0), ((12.0, 8.0), 30.0)]
        {
            assert_eq!(seen_again(first, snr_db, (60.0, -8.0)), 1.0, "{first:?} {snr_db}");
        }
        assert!(seen_again((79.9, 8.0), 22.1, (60.0, -8.0)) < 1.0);
    }

    #[test]
    fn a_radar_that_sees_every_post_again_sees_all() {
        assert_eq!(drive(|_| true), 1.0);
    }

    #[test]
    fn scans_that_are_missing_lower_the_share() {
        let share = drive(|scan| scan % 4 != 3);
        assert!((0.6..0.85).contains(&share), "{share}");
    }

    #[test]
    fn no_echo_at_all_is_blind_where_the_map_has_posts() {
        assert_eq!(drive(|_| false), 0.0);
        let mut nowhere = Sight::new(12.0, 0.0, &Numbers::DEFAULT);
        for _ in 0..80 {
            nowhere.take_scan(0.05, 20.0, &[], &[], (&VIEW, &Course::STRAIGHT));
        }
        assert_eq!(nowhere.share(), 1.0, "no posts are promised");
    }

    #[test]
    fn tracked_vehicles_count_and_the_past_fades() {
        let mut sight = Sight::new(12.0, 0.0, &Numbers::DEFAULT);
        let mut see = |seen: bool, scans: u32| {
            for _ in 0..scans {
                sight.take_scan(0.05, 20.0, &[], &[], (&VIEW, &Course::STRAIGHT));
                sight.observe_track(seen);
            }
            sight.share()
        };
        assert!(see(true, 100) > 0.99);
        assert!(see(false, 60) < 0.1, "3 s later");
        assert!(see(true, 60) > 0.9, "and back");
    }
}
