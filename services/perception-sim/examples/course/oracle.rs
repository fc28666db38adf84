//! An observer that knows how the scenes are made: what the radar's echoes can show at best.
//!
//! Its roads are one clothoid, arc and clothoid from the place where the drive began, so they stay where they are. It
//! is given the true motion of the ego. Some thousand roads are weighed every half second by all standing echoes, and
//! moved by some random steps. The queue stands in the own lane or in the next one.
//!
//! It shares no code with the belief of `perception-sim`. It is slow, and made to be read beside the table.

use messages::Detection;
use perception_sim::random::Random;
use road::Pose;

/// Time between two weighings, s.
const EVERY_S: f64 = 0.5;
/// Length of a step along a road, m, and its beginning and end.
const STEP_M: f64 = 3.0;
const BEHIND_M: f64 = 30.0;
const NODES: usize = 196;
/// Standard deviations of the random steps: start, curvature, ramp, arc, heading, offset.
const STEPS: [f64; 6] = [4.0, 1.5e-4, 6.0, 8.0, 0.0012, 0.06];

/// Start, m, curvature, 1/m, ramp, m, arc, m, heading, rad, and offset, m.
type Road = [f64; 6];

/// Echoes of one standing object: place, number, cross section, weight, nearest range.
#[derive(Clone, Copy)]
struct Cluster {
    at: (f64, f64),
    count: f64,
    area_m2: f64,
    weight: f64,
    range_m: f64,
}

/// Posterior of the queue's last vehicle.
#[derive(Clone, Copy)]
pub struct Verdict {
    pub in_lane: f64,
    pub offset_m: f64,
    pub sigma_m: f64,
}

pub struct Oracle {
    random: Random,
    roads: Vec<Road>,
    densities: Option<Vec<f64>>,
    in_lane: Vec<f64>,
    clusters: Vec<Cluster>,
    way: Vec<(f64, f64)>,
    start: Pose,
    speed_mps: f64,
    next_s: f64,
}

impl Oracle {
    pub fn new(count: usize, speed_mps: f64, start: Pose) -> Self {
        let mut random = Random::of_run(5, 77);
        let roads = (0..3 * count).map(|_| drawn(&mut random, speed_mps)).collect();
        Self {
            random,
            roads,
            densities: None,
            in_lane: vec![0.0; 3 * count],
            clusters: Vec::new(),
            way: Vec::new(),
            start,
            speed_mps,
            next_s: 0.3,
        }
    }

    /// Takes a scan at the ego's true place. `rear` is where the queue ends in the ego's axes. Every half second it
    /// says what it thinks of it.
    pub fn take(
        &mut self,
        time_s: f64,
        ego: &Pose,
        detections: &[Detection],
        rear: (f64, f64),
    ) -> Option<Verdict> {
        let start = self.start;
        let (sine, cosine) = start.heading_rad.sin_cos();
        let (dx, dy) = (ego.x_m - start.x_m, ego.y_m - start.y_m);
        let here = (cosine * dx + sine * dy, cosine * dy - sine * dx);
        let heading = ego.heading_rad - start.heading_rad;
        let last = self.way.last().copied().unwrap_or((0.0, 0.0));
        if (here.0 - last.0).hypot(here.1 - last.1) > 25.0 {
            self.way.push(here);
        }
        for detection in detections {
            self.gather(here, heading, detection);
        }
        if time_s < self.next_s {
            return None;
        }
        self.next_s = time_s + EVERY_S;
        self.clusters.retain(|cluster| {
            let (x, y) = (cluster.at.0 - here.0, cluster.at.1 - here.1);
            x * heading.cos() + y * heading.sin() > -60.0 || x.hypot(y) < 60.0
        });
        let skip = self.way.len().saturating_sub(6);
        self.way.drain(..skip);
        self.weigh();
        let (sine, cosine) = heading.sin_cos();
        let rear =
            (here.0 + rear.0 * cosine - rear.1 * sine, here.1 + rear.0 * sine + rear.1 * cosine);
        let count = self.roads.len() as f64;
        let offsets: Vec<f64> =
            self.roads.iter().map(|road| beside_m(&drawn_line(road), rear)).collect();
        let mean = offsets.iter().sum::<f64>() / count;
        let square = offsets.iter().map(|offset| (offset - mean).powi(2)).sum::<f64>() / count;
        Some(Verdict {
            in_lane: self.in_lane.iter().sum::<f64>() / count,
            offset_m: mean,
            sigma_m: square.sqrt(),
        })
    }

    fn gather(&mut self, here: (f64, f64), heading: f64, detection: &Detection) {
        let Detection { range_m, range_rate_mps, azimuth_rad, rcs_dbsm, .. } = *detection;
        if (range_rate_mps + self.speed_mps * azimuth_rad.cos()).abs() > 0.5 {
            return;
        }
        let (sine, cosine) = (heading + azimuth_rad).sin_cos();
        let at = (here.0 + range_m * cosine, here.1 + range_m * sine);
        let sigma_m = range_m * 0.22_f64.to_radians() + 0.15;
        let (weight, area_m2) = (1.0 / (sigma_m * sigma_m), 10_f64.powf(0.1 * rcs_dbsm));
        let reach_m = 3.0 * sigma_m + 0.5;
        let far = |cluster: &Cluster| {
            let (dx, dy) = (at.0 - cluster.at.0, at.1 - cluster.at.1);
            let (along, across) = (dx * cosine + dy * sine, dy * cosine - dx * sine);
            let is_near = along.abs() < 1.6 && across.abs() < reach_m;
            if is_near { along.abs() / 1.6 + across.abs() / reach_m } else { f64::INFINITY }
        };
        let nearest = self.clusters.iter_mut().min_by(|a, b| far(a).total_cmp(&far(b)));
        match nearest {
            Some(cluster) if far(cluster).is_finite() => {
                let share = weight / (cluster.weight + weight);
                cluster.at.0 += share * (at.0 - cluster.at.0);
                cluster.at.1 += share * (at.1 - cluster.at.1);
                cluster.weight += weight;
                cluster.count += 1.0;
                cluster.area_m2 += area_m2;
                cluster.range_m = cluster.range_m.min(range_m);
            }
            _ => self.clusters.push(Cluster { at, count: 1.0, area_m2, weight, range_m }),
        }
    }

    fn weigh(&mut self) {
        let is_first = self.densities.is_none();
        let now: Vec<(f64, f64)> = self.roads.iter().map(|road| self.likelihood(road)).collect();
        let before = self.densities.take().unwrap_or_else(|| vec![0.0; now.len()]);
        let logs: Vec<f64> = now.iter().zip(&before).map(|(now, before)| now.0 - before).collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = logs.iter().map(|log| (log - most).exp()).collect();
        let count = if is_first { self.roads.len() / 3 } else { self.roads.len() };
        let apart = weights.iter().sum::<f64>() / count as f64;
        let (mut due, mut sum) = (apart * self.random.uniform(), 0.0);
        let (mut roads, mut known) = (Vec::new(), Vec::new());
        for (index, weight) in weights.iter().enumerate() {
            sum += weight;
            while due < sum {
                roads.push(self.roads[index]);
                known.push(now[index]);
                due += apart;
            }
        }
        for turn in 0..if is_first { 3 } else { 2 } {
            let scale = if turn % 2 == 0 { 1.0 } else { 0.35 };
            for index in 0..roads.len() {
                let mut next = roads[index];
                for (value, step) in next.iter_mut().zip(STEPS) {
                    *value += scale * step * self.random.normal();
                }
                next[2] = (next[2] - 0.5).abs() + 0.5;
                let found = self.likelihood(&next);
                let prior = |road: &Road| log_prior(road, self.speed_mps);
                let ratio = found.0 + prior(&next) - known[index].0 - prior(&roads[index]);
                if self.random.uniform().ln() < ratio {
                    (roads[index], known[index]) = (next, found);
                }
            }
        }
        self.roads = roads;
        self.densities = Some(known.iter().map(|known| known.0).collect());
        self.in_lane = known.iter().map(|known| known.1).collect();
    }

    /// Logarithm of the likelihood, and the probability that the queue is in the own lane.
    fn likelihood(&self, road: &Road) -> (f64, f64) {
        let line = drawn_line(road);
        let base: f64 = self
            .way
            .iter()
            .map(|place| -0.5 * (beside_m(&line, *place) / 0.3).powi(2).min(25.0))
            .sum();
        let mut lanes = [base; 3];
        for cluster in self.clusters.iter().filter(|cluster| cluster.count >= 2.0) {
            let d_m = beside_m(&line, cluster.at);
            let turn_m = cluster.range_m * 0.05_f64.to_radians();
            let sigma_m = (1.0 / cluster.weight + turn_m * turn_m + 0.01).sqrt();
            let mean_m2 = cluster.area_m2 / cluster.count;
            let least_db = 12.0 - 15.0 + 40.0 * (cluster.range_m.max(5.0) / 100.0).log10();
            let least_m2 = 10_f64.powf(0.1 * least_db);
            let post = (-(mean_m2.min(40.0) - least_m2).max(0.0) / 1.5).exp();
            let vehicle = (-mean_m2.min(60.0) / 8.0).exp() / 4.0;
            let strips = 0.5 * (strip(d_m, sigma_m) + strip(-d_m, sigma_m));
            let wide_m = sigma_m.hypot(0.7);
            for (lane, sum) in lanes.iter_mut().enumerate() {
                let off = (d_m - 3.5 * (lane as f64 - 1.0)) / wide_m;
                let queue = (-0.5 * off * off).exp() / (2.5066 * wide_m);
                let other = 0.05 * 0.15 / 60.0 * (post + vehicle);
                *sum += (0.65 * post * strips + 0.30 * vehicle * queue + other).ln();
            }
        }
        let most = lanes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let total = most + lanes.iter().map(|lane| (lane - most).exp()).sum::<f64>().ln();
        (total, (lanes[1] - total).exp())
    }
}

fn drawn(random: &mut Random, speed_mps: f64) -> Road {
    let least_m = (speed_mps * speed_mps / 2.5).max(60.0);
    let radius_m = random.between(least_m.ln(), 1200_f64.ln()).exp();
    let sign = if random.uniform() < 0.5 { -1.0 } else { 1.0 };
    let weak = if random.uniform() < 0.2 { 0.02 } else { 1.0 };
    let ramp_m = if random.uniform() < 0.5 { 0.5 } else { random.between(30.0, 100.0) };
    [
        random.between(-40.0, 330.0),
        sign * weak / radius_m,
        ramp_m,
        random.between(120.0, 420.0),
        0.006 * random.normal(),
        0.2 * random.normal(),
    ]
}

fn log_prior(road: &Road, speed_mps: f64) -> f64 {
    let [start_m, curvature_perm, ramp_m, arc_m, heading_rad, offset_m] = *road;
    let is_road = (-40.0..330.0).contains(&start_m)
        && (0.5..100.0).contains(&ramp_m)
        && (120.0..420.0).contains(&arc_m)
        && curvature_perm.abs() < 1.0 / (speed_mps * speed_mps / 2.5).max(60.0);
    let shape = -curvature_perm.abs().max(1.0 / 1200.0).ln();
    let place = -0.5 * (heading_rad / 0.006).powi(2) - 0.5 * (offset_m / 0.2).powi(2);
    if is_road { shape + place } else { f64::NEG_INFINITY }
}

/// Point, heading and curvature.
type Node = (f64, f64, f64, f64);

fn drawn_line(road: &Road) -> Vec<Node> {
    let [start_m, curvature_perm, ramp_m, arc_m, heading_rad, offset_m] = *road;
    let origin = (BEHIND_M / STEP_M) as usize;
    let (mut x, mut y, mut heading) = (0.0, 0.0, 0.0);
    let mut nodes: Vec<Node> = (0..NODES)
        .map(|index| {
            let s_m = (index as f64 + 0.5) * STEP_M - BEHIND_M;
            let into_m = (s_m - start_m).min(start_m + 2.0 * ramp_m + arc_m - s_m);
            let perm = curvature_perm * (into_m / ramp_m).clamp(0.0, 1.0);
            let node = (x, y, heading, perm);
            let (sine, cosine) = (heading + 0.5 * perm * STEP_M).sin_cos();
            (x, y, heading) = (x + STEP_M * cosine, y + STEP_M * sine, heading + perm * STEP_M);
            node
        })
        .collect();
    let (x, y, heading, _) = nodes[origin];
    let turn = heading_rad - heading;
    let (sine, cosine) = turn.sin_cos();
    for node in &mut nodes {
        let (dx, dy) = (node.0 - x, node.1 - y);
        *node =
            (dx * cosine - dy * sine, dx * sine + dy * cosine + offset_m, node.2 + turn, node.3);
    }
    nodes
}

/// Distance of a point to the left of a line, m.
fn beside_m(line: &[Node], (x, y): (f64, f64)) -> f64 {
    let range_m = x.hypot(y);
    let index = |s_m: f64| (((s_m + BEHIND_M) / STEP_M).max(0.0) as usize).min(NODES - 1);
    let window = &line[index(range_m - 20.0)..=index(1.25 * range_m + 45.0)];
    let square = |node: &&Node| (x - node.0).powi(2) + (y - node.1).powi(2);
    let nearest = window.iter().min_by(|a, b| square(a).total_cmp(&square(b)));
    let (node_x, node_y, heading, perm) = *nearest.expect("a window has nodes");
    let (sine, cosine) = heading.sin_cos();
    let (dx, dy) = (x - node_x, y - node_y);
    let along = dx * cosine + dy * sine;
    dy * cosine - dx * sine - 0.5 * perm * along * along
}

/// Density of a post in its strip, 8 to 11 m from the middle of the lane, 1/m.
fn strip(d_m: f64, sigma_m: f64) -> f64 {
    let below = |z: f64| 0.5 * (1.0 + (0.797_884_6 * (z + 0.044_715 * z * z * z)).tanh());
    (below((d_m - 8.0) / sigma_m) - below((d_m - 11.0) / sigma_m)) / 3.0
}
