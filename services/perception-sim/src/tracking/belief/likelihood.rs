//! How well a hypothesis explains what is known: the logarithms of its prior density and its likelihood.
//!
//! ```text
//! prior      curves follow each other, and drivers are not too fast for them
//! ego        keeps the middle of its lane, now and on the last 72 m
//! yaw rate   is that of the lane under the ego
//! landmark   is a post of either strip, a vehicle in one of three lanes, or anything anywhere
//! trails     keep their distance from the lane
//! map        has the curvatures ahead
//! ```
//!
//! Vehicles that stand form queues. So the lanes with a queue are drawn once for all landmarks: one of three lanes, two
//! of them, or all. The likelihood is the sum over these seven cases.
//!
//! A post and a vehicle differ in their cross section too. A post has 1 m² in the mean and a vehicle 6 m² or more.

use super::road::{Bend, Hypothesis, Line};

/// Width of a lane, m.
pub const LANE_M: f64 = 3.5;
/// Depth of the strip in which posts stand, m: from the edge of the hard strip to the ditch.
const STRIP_M: f64 = 3.0;
/// Wander of the ego about the middle of its lane, m. Source: Verster and Roth 2011, 0.2 m; with a margin of a half.
const SWAY_M: f64 = 0.3;
/// Angle between the way of the ego and its lane, rad: the same wander at 1 rad/s and 20 m/s.
const ANGLE_RAD: f64 = 0.012;
/// Lateral acceleration of an ego that steers within its lane, m/s²: that wander at 1 rad/s.
const STEERING_MPS2: f64 = 0.2;
/// Error of the curvature by the yaw rate at any speed, 1/m.
const OWN_PERM: f64 = 2e-4;
/// Half of the widest vehicle, m: echoes come from anywhere across it, and from its side alone where others hide it. The
/// standard deviation of its place in its lane, with that of the lane's width.
const HALF_WIDTH_M: f64 = 1.25;
const VEHICLE_M: f64 = 0.4;
/// Length of a body, m: a car's.
const BODY_M: f64 = 4.5;
/// Standard deviation of the difference between two places of a trail, m: the wander of both, and dead reckoning.
const TRAIL_M: f64 = 0.35;
/// Error of a curvature of the map, 1/m: the mean of a cell, at a place known to some metres.
const MAP_PERM: f64 = 5e-4;
/// Places at which the map counts: every 25 m up to the radar's range.
pub const MAP_PLACES: usize = 7;
/// Distance between two of them, m.
pub const MAP_APART_M: f64 = 25.0;
/// Shares of posts, vehicles and others among landmarks. Posts are most of what stands; a twentieth is noise.
const SHARES: [f64; 3] = [0.65, 0.30, 0.05];
/// Density of what may be anywhere: within 30 m on both sides, and seldom.
const ANYWHERE_PERM: f64 = 0.15 / 60.0;
/// Mean cross sections of a post and of a vehicle's places, m²: those of 0 dBsm and 10 dBsm, as far as one landmark has
/// them.
const POST_M2: f64 = 1.5;
const VEHICLE_M2: f64 = 8.0;
/// Lateral acceleration up to which any curve is as probable as its shape, m/s², and the scale beyond. Source: R79
/// allows 3 m/s² of assistance.
const COMFORT_MPS2: f64 = 2.5;
const HASTE_MPS2: f64 = 1.0;
/// Least logarithm of one measurement, so that a wrong one rules nothing out.
const LEAST: f64 = -8.0;

/// A landmark in the frame of the evidence.
#[derive(Clone, Copy, Debug, Default)]
pub struct Mark {
    pub at_m: (f64, f64),
    /// 1 / standard deviation as a post and as a vehicle, 1/m.
    sharp_perm: f64,
    blunt_perm: f64,
    /// Densities of a post in its strip and of a vehicle in its lane, in multiples of the density anywhere.
    post: f64,
    vehicle: f64,
}

impl Mark {
    /// A landmark at a place, m, known to `sigma_m`, with a mean cross section and the smallest one that shows there.
    pub fn new(at_m: (f64, f64), sigma_m: f64, area_m2: f64, least_m2: f64) -> Self {
        let [posts, vehicles, others] = SHARES;
        let blunt_m = libm::hypot(sigma_m, VEHICLE_M);
        let post = libm::exp(-(area_m2.min(40.0) - least_m2).max(0.0) / POST_M2) / POST_M2;
        let vehicle = libm::exp(-area_m2.min(60.0) / VEHICLE_M2) / VEHICLE_M2;
        let anywhere = others * ANYWHERE_PERM * (post + vehicle);
        Self {
            at_m,
            sharp_perm: 1.0 / sigma_m,
            blunt_perm: 1.0 / blunt_m,
            post: 0.5 * posts * post / (STRIP_M * anywhere),
            vehicle: vehicles * vehicle / (2.0 * HALF_WIDTH_M * anywhere),
        }
    }

    fn away_m(&self, (x_m, y_m): (f64, f64)) -> f64 {
        libm::hypot(self.at_m.0 - x_m, self.at_m.1 - y_m)
    }

    /// Density of anything but a vehicle in a lane, at a distance to the left of the lane's middle, m.
    fn other(&self, d_m: f64, hypothesis: &Hypothesis) -> f64 {
        let [left_m, right_m] = hypothesis.edges_m;
        let strip_of = |from_m: f64| strip(from_m * self.sharp_perm, STRIP_M * self.sharp_perm);
        1.0 + self.post * (strip_of(d_m - left_m) + strip_of(-d_m - right_m))
    }

    /// Densities of a vehicle in the right lane, the own one and the left one.
    fn lanes(&self, d_m: f64) -> [f64; 3] {
        [-LANE_M, 0.0, LANE_M].map(|lane_m| {
            let from_m = d_m - lane_m + HALF_WIDTH_M;
            self.vehicle * strip(from_m * self.blunt_perm, 2.0 * HALF_WIDTH_M * self.blunt_perm)
        })
    }

    /// Probability that it is in the own lane, or that it is anything, which is in the way with `in_way`. `lanes` are
    /// those by an evidence that contains it.
    pub fn in_lane(&self, d_m: f64, hypothesis: &Hypothesis, lanes: &Lanes, in_way: f64) -> f64 {
        let (other, [a, b, c]) = (self.other(d_m, hypothesis), self.lanes(d_m));
        let own = in_lanes([0.0, b, 0.0]);
        let all = in_lanes([a, b, c]);
        (lanes.iter().zip(own).zip(all))
            .map(|((lane, own), all)| lane * (in_way + own) / (other + all))
            .sum()
    }
}

/// Places of the ego's own way.
pub const WAY: usize = 4;

/// Evidence in one frame.
#[derive(Clone, Debug, Default)]
pub struct Evidence {
    pub marks: Vec<Mark>,
    /// Places where the ego was, m.
    pub way: Vec<(f64, f64)>,
    /// Two places of one vehicle each, m.
    pub pairs: Vec<((f64, f64), (f64, f64))>,
    /// Curvature of the ego's way, 1/m, and the arc length at which it was that of the road.
    pub own: Option<(f64, f64)>,
    /// Direction of the ego's way in the body's axes, rad.
    pub slip_rad: f64,
    pub speed_mps: f64,
    pub map_perm: Option<[f64; MAP_PLACES]>,
}

impl Evidence {
    /// Keeps one landmark of each body: the rearmost. All of them show the same place across the road.
    pub fn count_bodies_once(&mut self) {
        self.marks.sort_unstable_by(|a, b| a.at_m.0.total_cmp(&b.at_m.0));
        let mut kept = 0;
        for index in 0..self.marks.len() {
            let at_m = self.marks[index].at_m;
            if self.marks[..kept].iter().all(|mark| mark.away_m(at_m) >= BODY_M) {
                self.marks[kept] = self.marks[index];
                kept += 1;
            }
        }
        self.marks.truncate(kept);
    }

    /// The landmark of the body at a point.
    pub fn body(&self, at_m: (f64, f64)) -> Option<&Mark> {
        let near = self.marks.iter().filter(|mark| mark.away_m(at_m) < BODY_M);
        near.min_by(|a, b| a.away_m(at_m).total_cmp(&b.away_m(at_m)))
    }

    /// Logarithm of the likelihood of a hypothesis, with the prior of the ego's place in its lane.
    /// The second result has the probabilities of the lanes with a queue.
    pub fn log_likelihood(&self, hypothesis: &Hypothesis, line: &Line) -> (f64, Lanes) {
        let normal = |off: f64| (-0.5 * off * off).max(LEAST);
        let mut sum = -0.5 * square(hypothesis.offset_m / SWAY_M);
        sum += normal((hypothesis.heading_rad - self.slip_rad) / ANGLE_RAD);
        for place in &self.way {
            sum += normal(line.across_m(*place) / SWAY_M);
        }
        if let Some((own_perm, at_m)) = self.own {
            let steering_perm = STEERING_MPS2 / square(self.speed_mps.max(3.0));
            let off_perm = own_perm - hypothesis.curvature_perm(at_m);
            sum += normal(off_perm / libm::hypot(steering_perm, OWN_PERM));
        }
        for (near, far) in &self.pairs {
            sum += normal((line.across_m(*far) - line.across_m(*near)) / TRAIL_M);
        }
        if let Some(map_perm) = &self.map_perm {
            for (place, perm) in map_perm.iter().enumerate() {
                let off_perm = perm - hypothesis.curvature_perm(place as f64 * MAP_APART_M);
                sum += normal(off_perm / (MAP_PERM + 0.1 * perm.abs()));
            }
        }
        let (marks, lanes) = self.log_marks(hypothesis, line);
        (sum + marks, lanes)
    }

    /// The part of the landmarks, and the probabilities of the lanes with a queue.
    fn log_marks(&self, hypothesis: &Hypothesis, line: &Line) -> (f64, Lanes) {
        // Products over the landmarks: beside any lane, and by the case of the queues. Each factor is from 1 to some
        // 1,000, so that 64 of them do not overflow.
        let (mut beside, mut cases) = (1.0, LANES_PRIOR);
        for mark in &self.marks {
            let d_m = line.across_m(mark.at_m);
            let other = mark.other(d_m, hypothesis);
            match d_m.abs() > LANE_M + HALF_WIDTH_M + 2.0 / mark.blunt_perm {
                true => beside *= other,
                false => {
                    let densities = in_lanes(mark.lanes(d_m));
                    cases.iter_mut().zip(densities).for_each(|(case, lane)| *case *= other + lane);
                }
            }
        }
        let sum: f64 = cases.iter().sum();
        (libm::log(beside) + libm::log(sum), cases.map(|case| case / sum))
    }
}

/// Probabilities of the lanes with a queue: right, own, left, right and own, own and left, right and left, all.
pub type Lanes = [f64; 7];
/// One certain lane before any evidence, and one certain set of more lanes.
const ONE_LANE: f64 = 0.28;
const MORE_LANES: f64 = 0.04;
/// See [`Lanes`].
pub const LANES_PRIOR: Lanes =
    [ONE_LANE, ONE_LANE, ONE_LANE, MORE_LANES, MORE_LANES, MORE_LANES, MORE_LANES];

/// Densities of a vehicle by the lanes with a queue, from those by its own lane. It is in each of them alike.
fn in_lanes([a, b, c]: [f64; 3]) -> Lanes {
    [a, b, c, 0.5 * (a + b), 0.5 * (b + c), 0.5 * (a + c), (a + b + c) * (1.0 / 3.0)]
}

/// Bounds of a hypothesis: lengths of clothoid and arc, m, radius, m, and distance of the strips, m.
pub const RAMP_M: (f64, f64) = (0.5, 200.0);
/// See [`RAMP_M`].
pub const ARC_M: (f64, f64) = (10.0, 800.0);
/// Smallest and largest radius: from a hairpin on, and up to what is straight within the radar's range.
pub const RADIUS_M: (f64, f64) = (25.0, 3_000.0);
/// Nearest and farthest strip: beside the own lane, and beyond four of them.
pub const EDGE_M: (f64, f64) = (3.0, 18.0);
/// Mean length of clothoids and arcs, m.
pub const MEAN_RAMP_M: f64 = 60.0;
/// See [`MEAN_RAMP_M`].
pub const MEAN_ARC_M: f64 = 200.0;
/// Longest straight road before a curve, m, and the mean of a short one. It is the sight: a curve beyond it has no effect
/// yet. A longer straight road has curves that hardly bend. With 400 m a curve that came into sight was missed in 8 of
/// 192 drives of the test's kind, with 170 m in 1.
pub const STRAIGHT_M: f64 = 170.0;
/// See [`STRAIGHT_M`].
pub const SHORT_M: f64 = 8.0;

/// Logarithm of the prior density of the curves and edges, up to a constant.
pub fn log_prior(hypothesis: &Hypothesis, speed_mps: f64) -> f64 {
    let within = |value: f64, (from, to): (f64, f64)| (from..=to).contains(&value);
    let mut sum = 0.0;
    // Beyond the bound nothing would bring the first curve back into sight.
    if hypothesis.bends[0].from_m > STRAIGHT_M {
        return f64::NEG_INFINITY;
    }
    let mut end_m = None;
    for bend in &hypothesis.bends {
        let Bend { curvature_perm, ramp_m, arc_m, .. } = *bend;
        let perm = curvature_perm.abs();
        if !within(ramp_m, RAMP_M) || !within(arc_m, ARC_M) || perm > 1.0 / RADIUS_M.0 {
            return f64::NEG_INFINITY;
        }
        // Radii are even by their logarithm.
        sum -= libm::log(perm.max(1.0 / RADIUS_M.1)) + ramp_m / MEAN_RAMP_M + arc_m / MEAN_ARC_M;
        let haste_mps2 = perm * square(speed_mps) - COMFORT_MPS2;
        sum += (-0.5 * square(haste_mps2.max(0.0) / HASTE_MPS2)).max(LEAST);
        if let Some(end_m) = end_m {
            let gap_m = bend.from_m - end_m;
            if !within(gap_m, (0.0, STRAIGHT_M)) {
                return f64::NEG_INFINITY;
            }
            sum += libm::log(0.5 / STRAIGHT_M + 0.5 / SHORT_M * libm::exp(-gap_m / SHORT_M));
        }
        end_m = Some(bend.to_m());
    }
    let are_edges = hypothesis.edges_m.iter().all(|edge_m| within(*edge_m, EDGE_M));
    if are_edges { sum } else { f64::NEG_INFINITY }
}

/// Probability of a place from 0 to `width` in standard deviations, without transcendental functions: the normal
/// distribution's, within 4 %.
pub(super) fn strip(place: f64, width: f64) -> f64 {
    let below = |z: f64| {
        let share = (0.5 + z * (1.0 / 3.76)).clamp(0.0, 1.0);
        share * share * (3.0 - 2.0 * share)
    };
    below(place) - below(place - width)
}

fn square(value: f64) -> f64 {
    value * value
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight road, then a curve to the left from 60 m on, of 200 m radius.
    fn road() -> Hypothesis {
        let bend = Bend { from_m: 60.0, curvature_perm: 0.005, ramp_m: 40.0, arc_m: 200.0 };
        let next = Bend { from_m: 345.0, ..bend };
        let last = Bend { from_m: 630.0, ..bend };
        Hypothesis { bends: [bend, next, last], edges_m: [8.0; 2], ..Hypothesis::default() }
    }

    /// Point beside the road.
    fn at(s_m: f64, d_m: f64) -> (f64, f64) {
        let line = Line::of(&road());
        // Newton's method on the place.
        let mut point = (s_m, d_m);
        for _ in 0..30 {
            let there = line.beside(point);
            let (sine, cosine) = libm::sincos(there.heading_rad);
            let (along, across) = (s_m - there.s_m, d_m - there.d_m);
            point.0 += along * cosine - across * sine;
            point.1 += along * sine + across * cosine;
        }
        point
    }

    fn density(evidence: &Evidence, hypothesis: &Hypothesis) -> f64 {
        log_prior(hypothesis, evidence.speed_mps)
            + evidence.log_likelihood(hypothesis, &Line::of(hypothesis)).0
    }

    fn evidence() -> Evidence {
        Evidence { speed_mps: 20.0, ..Evidence::default() }
    }

    #[test]
    fn posts_favour_the_road_between_them() {
        let mut evidence = evidence();
        for k in 0..5 {
            let s_m = 20.0 + 20.0 * f64::from(k);
            evidence.marks.push(Mark::new(at(s_m, 9.0), 0.3, 1.0, 0.1));
            evidence.marks.push(Mark::new(at(s_m, -9.5), 0.3, 1.0, 0.1));
        }
        let mut later = road();
        later.bends[0].from_m = 75.0;
        let mut right = road();
        right.bends[0].curvature_perm = -0.005;
        let truth = density(&evidence, &road());
        assert!(truth > density(&evidence, &later), "a curve 15 m later");
        assert!(truth > density(&evidence, &right) + 10.0, "to the other side");
    }

    #[test]
    fn a_queue_stands_in_a_lane_and_its_vehicles_in_one() {
        let of = |offsets: [f64; 3]| {
            let mut evidence = evidence();
            for (index, d_m) in offsets.into_iter().enumerate() {
                let s_m = 40.0 + 8.0 * index as f64;
                evidence.marks.push(Mark::new(at(s_m, d_m), 0.3, 8.0, 0.1));
            }
            density(&evidence, &road())
        };
        assert!(of([0.2, -0.2, 0.1]) > of([1.75; 3]) + 2.0, "not between two lanes");
        assert!(of([3.5; 3]) > of([3.5, 0.0, -3.5]) + 1.0, "a row is simpler");
        assert!((of([3.5; 3]) - of([0.0; 3])).abs() < 0.1, "each lane is as probable");
    }

    #[test]
    fn a_body_counts_once_and_its_rear_is_kept() {
        let mut evidence = evidence();
        // A car with its wheelhouses, and the next one 7 m behind its rear.
        for place in [(47.0, 3.4), (43.6, 2.6), (40.0, 3.4), (40.8, 2.6), (50.6, 2.6)] {
            evidence.marks.push(Mark::new(place, 0.3, 8.0, 0.1));
        }
        evidence.count_bodies_once();
        let kept: Vec<_> = evidence.marks.iter().map(|mark| mark.at_m).collect();
        assert_eq!(kept, [(40.0, 3.4), (47.0, 3.4)]);
    }

    #[test]
    fn a_vehicle_between_two_lanes_is_in_that_of_its_queue() {
        let in_lane = |d_m: f64, queue_d_m: Option<f64>| {
            let mut evidence = evidence();
            let queue = |k: u32| at(40.0 + 8.0 * f64::from(k), queue_d_m.unwrap_or(0.0));
            let marks = (0..4).map(|k| Mark::new(queue(k), 0.3, 8.0, 0.1));
            evidence.marks.extend(marks.filter(|_| queue_d_m.is_some()));
            evidence.marks.push(Mark::new(at(80.0, d_m), 0.5, 8.0, 0.1));
            let (_, lanes) = evidence.log_likelihood(&road(), &Line::of(&road()));
            let body = evidence.body(at(81.0, d_m)).expect("it is there");
            body.in_lane(d_m, &road(), &lanes, 0.0)
        };
        assert!(in_lane(0.8, None) > 0.95, "a vehicle");
        assert!(in_lane(1.6, Some(3.5)) < 0.1, "the side of one in the queue");
        assert!(in_lane(1.6, Some(0.0)) > 0.9, "in the own lane");
    }

    #[test]
    fn the_ego_keeps_its_lane_and_the_map_its_curvature() {
        let aside = Hypothesis { offset_m: 0.9, ..road() };
        assert!(density(&evidence(), &road()) > density(&evidence(), &aside) + 4.0);
        let own = Evidence { own: Some((0.004, -5.0)), ..evidence() };
        let mut early = road();
        early.bends[0].from_m = -60.0;
        assert!(density(&own, &early) > density(&own, &road()), "it turns already");
        let perm = std::array::from_fn(|place| road().curvature_perm(place as f64 * MAP_APART_M));
        let map = Evidence { map_perm: Some(perm), ..evidence() };
        let mut late = road();
        late.bends[0].from_m = 110.0;
        late.bends[1].from_m = 395.0;
        late.bends[2].from_m = 680.0;
        let lead = density(&evidence(), &road()) - density(&evidence(), &late);
        assert!(density(&map, &road()) - density(&map, &late) > lead + 8.0);
    }

    #[test]
    fn trails_are_parallel() {
        let mut evidence = evidence();
        evidence.pairs.push((at(10.0, 3.5), at(110.0, 3.5)));
        let mut straight = road();
        straight.bends[0].curvature_perm = 1e-6;
        let alone = Evidence { speed_mps: 20.0, ..Evidence::default() };
        let gain =
            |hypothesis: &Hypothesis| density(&evidence, hypothesis) - density(&alone, hypothesis);
        assert!(gain(&road()).abs() < 0.05 && gain(&straight) == LEAST);
    }

    #[test]
    fn roads_that_cannot_be_have_no_density() {
        let is_none = |hypothesis: &Hypothesis| log_prior(hypothesis, 20.0) == f64::NEG_INFINITY;
        assert!(!is_none(&road()));
        let mut overlap = road();
        overlap.bends[1].from_m = 300.0;
        assert!(is_none(&overlap));
        assert!(is_none(&Hypothesis { edges_m: [2.0, 8.0], ..road() }));
        let mut sharp = road();
        sharp.bends[2].curvature_perm = -0.05;
        assert!(is_none(&sharp));
        // A curve that needs 5 m/s² is less probable, and possible.
        assert!(log_prior(&road(), 31.6) < log_prior(&road(), 20.0) - 3.0);
        assert!(!log_prior(&road(), 60.0).is_infinite());
    }

    #[test]
    fn the_polynomial_is_near_the_normal_distribution() {
        for k in -40..=40 {
            let z = f64::from(k) * 0.1;
            let below = 0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2);
            assert!((strip(z, 1e6) - below).abs() < 0.04, "{z}");
        }
    }
}
