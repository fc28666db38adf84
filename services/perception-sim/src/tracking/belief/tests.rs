use super::*;

const DT_S: f64 = 0.05;
const SPEED_MPS: f64 = 20.0;
const SOURCES: Sources = Sources { yaw_rate: true, standing: true, trails: true, map: false };

/// An ego in the middle of a road that bends to the left from 120 m on, 200 m of radius, with posts 9 m to both sides
/// and a queue whose last vehicle is 230 m from the start.
struct Drive {
    belief: Belief,
    ego_m: f64,
    queue_d_m: f64,
}

const BEGIN_M: f64 = 120.0;
const RADIUS_M: f64 = 200.0;
const QUEUE_M: f64 = 230.0;

/// Point and heading of the road.
fn road(s_m: f64, d_m: f64) -> (f64, f64, f64) {
    let turn = ((s_m - BEGIN_M) / RADIUS_M).max(0.0);
    let (sine, cosine) = libm::sincos(turn);
    let radius_m = RADIUS_M - d_m;
    match s_m < BEGIN_M {
        true => (s_m, d_m, 0.0),
        false => (BEGIN_M + radius_m * sine, RADIUS_M - radius_m * cosine, turn),
    }
}

impl Drive {
    fn new(queue_d_m: f64) -> Self {
        Self { belief: Belief::new(SOURCES), ego_m: 0.0, queue_d_m }
    }

    /// A point of the road in the body's axes.
    fn seen(&self, s_m: f64, d_m: f64) -> (f64, f64) {
        let (x, y, heading) = road(self.ego_m, 0.0);
        let (px, py, _) = road(s_m, d_m);
        Frame { x_m: x, y_m: y, heading_rad: heading, way_m: 0.0 }.seen((px, py))
    }

    fn scan(&mut self) {
        let before = road(self.ego_m, 0.0).2;
        self.ego_m += SPEED_MPS * DT_S;
        let turned = road(self.ego_m, 0.0).2 - before;
        let motion =
            Motion { speed_mps: SPEED_MPS, yaw_rate_radps: Some(turned / DT_S), slip_rad: 0.0 };
        self.belief.advance(DT_S, &motion);
        let posts =
            (0..40).map(|k| (f64::from(k) * 13.0, if k % 2 == 0 { 9.0 } else { -9.5 }, 1.0));
        let queue = (0..6).map(|k| (QUEUE_M + 7.0 * f64::from(k), self.queue_d_m, 8.0));
        let echoes: Vec<Echo> = posts
            .chain(queue)
            .map(|(s_m, d_m, area_m2)| (self.seen(s_m, d_m), area_m2))
            .filter(|((x_m, y_m), _)| *x_m > 3.0 && libm::hypot(*x_m, *y_m) < 150.0)
            .map(|((x_m, y_m), area_m2)| {
                let sigma_m = 0.004 * libm::hypot(x_m, y_m);
                Echo { x_m, y_m, sigma_m, area_m2, least_m2: 0.1 }
            })
            .collect();
        self.belief.take(&motion, None, &echoes);
    }

    /// Probability that the last vehicle of the queue is in the way, at a gap, m.
    fn at_gap(&mut self, gap_m: f64) -> f64 {
        while QUEUE_M - self.ego_m > gap_m {
            self.scan();
        }
        self.belief.in_way(self.seen(QUEUE_M, self.queue_d_m), 0.3, 1.8)
    }
}

#[test]
fn a_queue_in_a_curve_is_in_the_way_or_beside_it() {
    for (d_m, is_in_way) in [(0.1, true), (3.5, false), (-3.4, false)] {
        let mut drive = Drive::new(d_m);
        let probability = drive.at_gap(90.0);
        assert_eq!(probability > 0.9, is_in_way, "{probability} at {d_m} m");
        assert_eq!(probability < 0.1, !is_in_way, "{probability} at {d_m} m");
    }
}

#[test]
fn the_course_follows_the_curve_within_its_deviation() {
    let mut drive = Drive::new(3.5);
    for gap_m in [110.0, 80.0, 50.0] {
        drive.at_gap(gap_m);
        let (d_m, sigma_m) = drive.belief.beside_m(drive.seen(drive.ego_m + 60.0, 0.0));
        assert!(d_m.abs() < 3.0 * sigma_m && sigma_m < 1.0, "{d_m} of {sigma_m} at {gap_m}");
        let course = drive.belief.course();
        let (x_m, y_m) = drive.seen(drive.ego_m + 60.0, 0.0);
        assert!((course.locate(x_m, y_m).d_m - d_m).abs() < 0.5, "the course is the mean");
    }
    assert!((drive.belief.course().curvature_perm(0.0) - 1.0 / RADIUS_M).abs() < 1e-3);
}

#[test]
fn two_drives_are_the_same_and_a_step_weighs_all() {
    let (mut one, mut other) = (Drive::new(0.0), Drive::new(0.0));
    assert_eq!(one.at_gap(150.0).to_bits(), other.at_gap(150.0).to_bits());
    let (marks, pairs) = one.belief.used();
    assert!(marks > 10 && pairs == 0, "{marks} {pairs}");
}
