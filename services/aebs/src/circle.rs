//! The ego's way ahead as a circle.
//!
//! The emergency brake takes the road ahead for a continuation of what the ego drives now. Its curvature is
//!
//! ```text
//! κ = r / v          r: yaw rate, rad/s; v: speed, m/s
//! ```
//!
//! behind a low-pass of [`LAG_S`]. Below [`SLOWEST_MPS`] the quotient is worthless: the curvature stays as it was.
//!
//! A point (x, y) of the *body* counts from the middle of the front bumper: x along the body, y to the left. It becomes
//! (σ, d): the length along the circle and the distance left of it. With the circle's centre at (0, 1/κ)
//!
//! ```text
//! q = κ (x² + y²) - 2 y
//! d = -q / (1 + √(1 + κ q))
//! σ = atan2(κ x, 1 - κ y) / κ
//! ```
//!
//! which is (x, y) where κ = 0. The body does not point along the way of its bumper. It turns about its rear axle, and
//! the tyres slip. The way's heading there is κ (l - k v²). l is the distance from the bumper to the rear axle. k is
//! the slip of the rear tyres per lateral acceleration ([`OwnWay::new`]).
//!
//! ```
//! use aebs::circle::Circle;
//!
//! let circle = Circle { curvature_perm: 1.0 / 250.0, heading_rad: 0.0 };
//! let (x_m, y_m) = circle.to_body(60.0, -3.5);
//! let (along_m, off_m) = circle.to_way(x_m, y_m);
//! assert!((along_m - 60.0).abs() < 1e-9 && (off_m + 3.5).abs() < 1e-9);
//! ```

/// Time constant of the curvature's low-pass, s. Chosen: five samples of the sensor. Its noise of 0.1 °/s would be 3 cm
/// at the last point to brake. A curve that begins or ends must show at once.
const LAG_S: f64 = 0.05;
/// Speed below which a yaw rate does not show a curvature, m/s. Chosen: 0.1 °/s of offset is 1/1,700 m there.
const SLOWEST_MPS: f64 = 3.0;

/// Standard deviation of the road's curvature around that of the circle, 1/m. Chosen: the driver's own steering (0.2 m
/// of wander in 3 s), and a yaw rate that is off by 0.1 °/s.
const SIGMA_PERM: f64 = 3e-4;

/// A circle through the middle of the ego's front bumper.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Circle {
    /// Curvature, 1/m, positive to the left.
    pub curvature_perm: f64,
    /// Heading of the circle at the bumper, rad to the left of the body.
    pub heading_rad: f64,
}

/// A vector in axes that are turned to the left by `rad`.
fn seen_turned((x_m, y_m): (f64, f64), rad: f64) -> (f64, f64) {
    let (sine, cosine) = libm::sincos(rad);
    (x_m * cosine + y_m * sine, y_m * cosine - x_m * sine)
}

impl Circle {
    /// Length along the circle and distance left of it, m, of a point of the body.
    pub fn to_way(&self, x_m: f64, y_m: f64) -> (f64, f64) {
        self.place(x_m, y_m).0
    }

    /// The same, and the circle's heading there, rad to the left of the body.
    pub(crate) fn place(&self, x_m: f64, y_m: f64) -> ((f64, f64), f64) {
        let (x_m, y_m) = seen_turned((x_m, y_m), self.heading_rad);
        let k = self.curvature_perm;
        if k == 0.0 {
            return ((x_m, y_m), self.heading_rad);
        }
        let q_m = k * (x_m * x_m + y_m * y_m) - 2.0 * y_m;
        let root = (1.0 + k * q_m).max(0.0).sqrt();
        let turn_rad = libm::atan2(k * x_m, 1.0 - k * y_m);
        ((turn_rad / k, -q_m / (1.0 + root)), self.heading_rad + turn_rad)
    }

    /// The point of the body that is `along_m` along the circle and `off_m` left of it.
    pub fn to_body(&self, along_m: f64, off_m: f64) -> (f64, f64) {
        let half_rad = 0.5 * self.curvature_perm * along_m;
        // A chord has the heading of half of its turn.
        let chord_m =
            if half_rad == 0.0 { along_m } else { along_m * libm::sin(half_rad) / half_rad };
        let (x_m, y_m) = seen_turned((0.0, off_m), -half_rad);
        seen_turned((chord_m + x_m, y_m), -half_rad - self.heading_rad)
    }

    /// A place on this circle as seen from the `next` one, when the ego has driven `way_m` and has turned by
    /// `turn_rad`. The place has been moved back by the way already.
    pub(crate) fn seen_from(
        &self,
        next: &Self,
        (way_m, turn_rad): (f64, f64),
        (along_m, off_m): (f64, f64),
    ) -> (f64, f64) {
        // The body turned by as much more than the circle does on this way.
        let more_rad = turn_rad - self.curvature_perm * way_m;
        let (x_m, y_m) = seen_turned(self.to_body(along_m, off_m), more_rad);
        next.to_way(x_m, y_m)
    }
}

/// The curvature of the ego's way. The default is that of a straight road.
#[derive(Clone, Debug, Default)]
pub struct OwnWay {
    bumper_m: f64,
    slip_rad_per_mps2: f64,
    curvature_sigma_perm: f64,
    curvature_perm: f64,
    yaw_rate_radps: f64,
    speed_mps: f64,
    last_ns: Option<i64>,
}

impl OwnWay {
    /// The way of a car on a road with curves, before its first yaw rate. Its front bumper is `bumper_m` ahead of the
    /// rear axle (0: the body points along its way). The rear tyres slip by an angle per lateral acceleration.
    pub fn new(bumper_m: f64, slip_rad_per_mps2: f64) -> Self {
        Self { bumper_m, slip_rad_per_mps2, curvature_sigma_perm: SIGMA_PERM, ..Self::default() }
    }

    /// Takes the yaw rate that was acquired at `acquired_ns` by an ego of `speed_mps`. A sample that is not later than
    /// the last one, or that is not a number, is passed over.
    pub fn take(&mut self, acquired_ns: i64, yaw_rate_radps: f64, speed_mps: f64) {
        let elapsed_ns = self.last_ns.map_or(i64::MAX, |last_ns| acquired_ns - last_ns);
        if elapsed_ns <= 0 || !yaw_rate_radps.is_finite() || !speed_mps.is_finite() {
            return;
        }
        let is_first = self.last_ns.replace(acquired_ns).is_none();
        (self.yaw_rate_radps, self.speed_mps) = (yaw_rate_radps, speed_mps);
        if speed_mps < SLOWEST_MPS {
            return;
        }
        let gain = if is_first { 1.0 } else { 1.0 - libm::exp(-1e-9 * elapsed_ns as f64 / LAG_S) };
        self.curvature_perm += gain * (yaw_rate_radps / speed_mps - self.curvature_perm);
    }

    /// True on a road that may have curves.
    pub(crate) fn is_curved(&self) -> bool {
        self.curvature_sigma_perm > 0.0
    }

    pub fn yaw_rate_radps(&self) -> f64 {
        self.yaw_rate_radps
    }

    pub fn circle(&self) -> Circle {
        let lever_m = self.bumper_m - self.slip_rad_per_mps2 * self.speed_mps * self.speed_mps;
        Circle { curvature_perm: self.curvature_perm, heading_rad: self.curvature_perm * lever_m }
    }

    /// Standard deviation of the road's distance from the circle at `along_m`, m; 0 on a straight road.
    pub(crate) fn sigma_m(&self, along_m: f64) -> f64 {
        0.5 * self.curvature_sigma_perm * along_m * along_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn circle(radius_m: f64, heading_rad: f64) -> Circle {
        Circle { curvature_perm: 1.0 / radius_m, heading_rad }
    }

    #[test]
    fn a_straight_way_is_the_body_itself() {
        let straight = Circle::default();
        for (x_m, y_m) in [(0.0, 0.0), (60.0, -3.5), (-3.0, 1.75), (1e-9, 5.0)] {
            assert_eq!(straight.to_way(x_m, y_m), (x_m, y_m));
            assert_eq!(straight.to_body(x_m, y_m), (x_m, y_m));
        }
    }

    #[test]
    fn a_quarter_of_a_circle_is_where_it_is_by_hand() {
        let left = circle(100.0, 0.0);
        let quarter_m = 50.0 * std::f64::consts::PI;
        let (along_m, off_m) = left.to_way(100.0, 100.0);
        assert!((along_m - quarter_m).abs() < 1e-9 && off_m.abs() < 1e-9, "{along_m} {off_m}");
        // Five metres nearer to the centre is five to the left.
        let (along_m, off_m) = left.to_way(95.0, 100.0);
        assert!((along_m - quarter_m).abs() < 1e-9 && (off_m - 5.0).abs() < 1e-9);
        let (x_m, y_m) = circle(-100.0, 0.0).to_body(quarter_m, 5.0);
        assert!((x_m - 105.0).abs() < 1e-9 && (y_m + 100.0).abs() < 1e-9, "{x_m} {y_m}");
    }

    #[test]
    fn a_lead_of_a_curve_is_far_beside_the_body_and_on_the_way() {
        let left = circle(250.0, 0.0);
        // The chord of 60 m: 2 R sin(σ / 2 R) in the direction σ / 2 R.
        let (range_m, azimuth_rad) = (500.0 * libm::sin(60.0 / 500.0), 60.0 / 500.0);
        let (y_m, x_m) = libm::sincos(azimuth_rad);
        let (along_m, off_m) = left.to_way(range_m * x_m, range_m * y_m);
        assert!(range_m * y_m > 7.0);
        assert!((along_m - 60.0).abs() < 1e-9 && off_m.abs() < 1e-9, "{along_m} {off_m}");
        assert!(((left.heading_rad + left.curvature_perm * 60.0) - 0.24).abs() < 1e-12);
    }

    #[test]
    fn a_body_that_points_outwards_sees_its_way_turned() {
        let turned = circle(125.0, 0.016);
        let (_, off_m) = circle(125.0, 0.0).to_way(60.0, 0.0);
        let (_, turned_off_m) = turned.to_way(60.0, 0.0);
        // By 60 m times 0.016 rad, a little less for the bend.
        assert!((off_m - turned_off_m - 0.96).abs() < 0.15, "{off_m} {turned_off_m}");
    }

    #[test]
    fn a_standing_object_is_carried_to_its_place_on_the_next_circle() {
        // The ego drives 1 m on a circle of 125 m. Its filter still had 200 m before, and has 125 m then.
        let (before, next, truth) = (circle(200.0, 0.0), circle(125.0, 0.0), circle(125.0, 0.0));
        let place = (40.0, -3.5);
        let (x_m, y_m) = truth.to_body(place.0, place.1);
        let (along_m, off_m) = before.to_way(x_m, y_m);
        let seen = before.seen_from(&next, (1.0, 1.0 / 125.0), (along_m - 1.0, off_m));
        assert!((seen.0 - 39.0).abs() < 0.03 && (seen.1 + 3.5).abs() < 0.01, "{seen:?}");
    }

    fn car() -> OwnWay {
        OwnWay::new(3.6, 0.0055)
    }

    #[test]
    fn a_curvature_comes_with_the_lag_and_stays_when_the_ego_stops() {
        let mut way = car();
        let mut time_ns = 0;
        let mut drive = |way: &mut OwnWay, yaw_rate_radps, speed_mps, cycles| {
            for _ in 0..cycles {
                time_ns += 10_000_000;
                way.take(time_ns, yaw_rate_radps, speed_mps);
            }
        };
        drive(&mut way, 0.0, 20.0, 10);
        drive(&mut way, 0.08, 20.0, 5);
        let risen = way.circle().curvature_perm * 250.0;
        assert!((risen - 0.632).abs() < 1e-3, "a time constant later: {risen}");
        drive(&mut way, 0.08, 20.0, 400);
        assert!((way.circle().curvature_perm - 0.004).abs() < 1e-6);
        drive(&mut way, 0.001, 1.0, 400);
        assert!((way.circle().curvature_perm - 0.004).abs() < 1e-6);
        way.take(time_ns, 9.0, 20.0);
        way.take(time_ns + 10_000_000, f64::NAN, 20.0);
        assert!((way.circle().curvature_perm - 0.004).abs() < 1e-6, "old, and no number");
    }

    #[test]
    fn a_yaw_rate_shows_the_curvature_from_3_mps_on() {
        let curvature_perm = |speed_mps: f64| {
            let mut way = car();
            way.take(0, 0.03, speed_mps);
            assert_eq!(way.yaw_rate_radps(), 0.03);
            way.circle().curvature_perm
        };
        assert_eq!((curvature_perm(2.99), curvature_perm(3.0)), (0.0, 0.01));
    }

    #[test]
    fn the_body_points_inwards_when_fast_and_outwards_when_slow() {
        let heading_deg = |radius_m: f64, speed_mps: f64| {
            let mut way = car();
            way.take(0, speed_mps / radius_m, speed_mps);
            way.circle().heading_rad.to_degrees()
        };
        // The design's figures: 0.2° inwards at 500 m and 31.6 m/s, 0.9° outwards at 125 m and 17 m/s.
        assert!((heading_deg(500.0, 31.6) + 0.2).abs() < 0.03, "{}", heading_deg(500.0, 31.6));
        assert!((heading_deg(125.0, 17.0) - 0.9).abs() < 0.05, "{}", heading_deg(125.0, 17.0));
    }

    proptest! {
        #[test]
        fn a_place_on_the_way_comes_back(
            radius in 20.0..3000.0_f64, left in proptest::bool::ANY, share in -0.2..1.5_f64,
            off in -12.0..12.0_f64, heading in -0.05..0.05_f64,
        ) {
            let circle = circle(if left { radius } else { -radius }, heading);
            let along_m = (share * radius).clamp(-30.0, 150.0);
            let (x_m, y_m) = circle.to_body(along_m, off);
            let (back_m, off_m) = circle.to_way(x_m, y_m);
            prop_assert!((back_m - along_m).abs() < 1e-8, "{} {}", back_m, along_m);
            prop_assert!((off_m - off).abs() < 1e-8, "{} {}", off_m, off);
        }

        #[test]
        fn a_huge_radius_is_straight(x in -10.0..150.0_f64, y in -12.0..12.0_f64) {
            let (along_m, off_m) = circle(1e9, 0.0).to_way(x, y);
            prop_assert!((along_m - x).abs() < 1e-4 && (off_m - y).abs() < 1e-4);
        }

        #[test]
        fn a_mirrored_world_is_mirrored(
            radius in 50.0..3000.0_f64, x in 0.0..120.0_f64, y in -12.0..12.0_f64,
            heading in -0.05..0.05_f64,
        ) {
            let (along_m, off_m) = circle(radius, heading).to_way(x, y);
            let mirrored = circle(-radius, -heading).to_way(x, -y);
            prop_assert_eq!(mirrored, (along_m, -off_m));
        }
    }
}
