//! The belief about the road ahead: some hundred hypotheses ([`road`]), weighed by all that the radar knows.
//!
//! No hypothesis is chosen. Queries are means over all of them: the course, how exactly it is known, and the
//! probability that an object is in the ego's way.
//!
//! Standing things are gathered as [`landmarks`] in the plane of dead reckoning. A round of six scans works on a copy of
//! them, the evidence:
//!
//! ```text
//! scans 0, 1      weigh      each hypothesis by the new evidence over the old one
//! end of scan 1   resample   heavy ones are doubled, light ones end
//! scans 2 to 5    move       each by some small random steps, by Metropolis' rule
//! ```
//!
//! The rounds spread the work evenly: each scan computes as many likelihoods. A landmark counts once in all evidence.
//! So the belief never takes one object for many, and its spread is the true uncertainty.
//!
//! By the yaw rate alone nothing is ahead to weigh roads by: the course is the ego's own circle.
//!
//! Draws are seeded. A step allocates nothing.
//!
//! Source: W. R. Gilks and C. Berzuini, Following a moving target: Monte Carlo inference for dynamic Bayesian models,
//! Journal of the Royal Statistical Society B 63 (2001) 127: resample and move.

use super::course::Course;
use super::motion::{Frame, Motion};
use super::sources::{MapAhead, Sources};
use super::trail::{TRAILS, Trails};
use crate::random::Random;
use landmarks::{Echo, Landmarks};
use likelihood::{Evidence, LANES_PRIOR, Lanes, MAP_APART_M, MAP_PLACES, Mark, WAY, log_prior};
use moves::Step;
use outlook::Mean;
use road::{FIRST_M, Hypothesis, Line};

pub mod landmarks;
pub mod likelihood;
pub mod moves;
mod outlook;
pub mod road;

/// Hypotheses. Fewer that move more are truer than more that move less: with 128 and two steps the course was beyond
/// three standard deviations in 3.4 % of the scans of the example `course -- queues`, with 64 and five in 1.0 %.
pub const COUNT: usize = 64;
/// Scans of a round that weigh, and those that move. A likelihood is computed once to weigh, and once a step.
const WEIGHING: usize = 2;
const MOVING: usize = 4;
/// Steps of a hypothesis in a round: as many as 150 µs a scan allow.
const STEPS: usize = 5;

/// Least effective number of hypotheses after weighing. Evidence that leaves fewer is taken in gradually.
const LEAST_EFFECTIVE: f64 = 0.25 * COUNT as f64;

/// Way between two places of the ego's own way, m: all of them are within the line.
const WAY_APART_M: f64 = 17.0;
/// Memory of the ego's curvature, s, and speed from which the yaw rate shows it, m/s.
const OWN_MEMORY_S: f64 = 0.3;
const SLOW_MPS: f64 = 3.0;
/// Speed of the vehicles of a trail across the road from which they change lanes, m/s: a wander is slower.
const LANE_CHANGE_MPS: f64 = 0.6;
/// Turn and error of a landmark's direction by dead reckoning, rad: 0.05°.
const TURN_RAD: f64 = 8.7e-4;
/// Distance behind the ego up to which a landmark counts, m: it shows where the ego is in its lane.
const BEHIND_M: f64 = 40.0;
/// Error of a landmark's place that no number of echoes improves, m: the size of a post and its foot.
const PLACE_M: f64 = 0.1;
/// Seed of the draws.
const SEED: u64 = 0x05ee_d0f0_be11_ef00;

/// A hypothesis with its line and its weight.
#[derive(Clone, Copy, Debug, Default)]
struct Particle {
    hypothesis: Hypothesis,
    line: Line,
    log_prior: f64,
    log_likelihood: f64,
    lanes: Lanes,
}

impl Particle {
    fn new(hypothesis: Hypothesis, evidence: &Evidence) -> Self {
        let line = Line::of(&hypothesis);
        let log_prior = log_prior(&hypothesis, evidence.speed_mps);
        let (log_likelihood, lanes) = match log_prior.is_finite() {
            true => evidence.log_likelihood(&hypothesis, &line),
            false => (f64::NEG_INFINITY, LANES_PRIOR),
        };
        Self { hypothesis, line, log_prior, log_likelihood, lanes }
    }

    /// The hypothesis from another frame, at a point of this one's axes and turned by an angle. A curve that lies
    /// behind makes room for one that is drawn.
    fn moved(&self, to: (f64, f64), turn_rad: f64, random: &mut Random) -> Hypothesis {
        let there = self.line.beside(to);
        let mut hypothesis = self.hypothesis;
        hypothesis.offset_m = -there.d_m;
        hypothesis.heading_rad = there.heading_rad - turn_rad;
        hypothesis.bends.iter_mut().for_each(|bend| bend.from_m -= there.s_m);
        // An arc that reaches farther back than the line is as probable from there on: lengths are exponential.
        let first = &mut hypothesis.bends[0];
        let behind_m = FIRST_M - (first.from_m + first.ramp_m);
        if behind_m > 0.0 && first.arc_m - behind_m > likelihood::ARC_M.0 {
            first.from_m += behind_m;
            first.arc_m -= behind_m;
        }
        if hypothesis.bends[0].to_m() < FIRST_M {
            hypothesis.bends.rotate_left(1);
            moves::redraw(&mut hypothesis, road::BENDS - 1, random);
        }
        hypothesis
    }
}

#[derive(Clone, Debug)]
pub struct Belief {
    sources: Sources,
    random: Random,
    ego: Frame,
    landmarks: Landmarks,
    trails: Trails,
    /// Places of the ego's own way in the plane, m, the newest first, and its way at that one, m.
    way: Vec<(f64, f64)>,
    way_m: f64,
    own_perm: Option<f64>,
    evidence: Evidence,
    /// Frame of the particles, and of those that are weighed.
    frame: Frame,
    next_frame: Frame,
    particles: Vec<Particle>,
    next: Vec<Particle>,
    log_weights: Vec<f64>,
    scan: usize,
    mean: Mean,
    course: Course,
}

impl Belief {
    /// Before the first scan.
    pub fn new(sources: Sources) -> Self {
        let mut random = Random::of_run(SEED, 0);
        let mut evidence = Evidence::default();
        evidence.marks.reserve(landmarks::MOST);
        evidence.way.reserve(WAY);
        evidence.pairs.reserve(2 * TRAILS);
        let particles: Vec<Particle> =
            (0..COUNT).map(|_| Particle::new(moves::first(&mut random), &evidence)).collect();
        let mut belief = Self {
            sources,
            random,
            ego: Frame::default(),
            landmarks: Landmarks::default(),
            trails: Trails::default(),
            way: Vec::with_capacity(WAY + 1),
            way_m: 0.0,
            own_perm: None,
            evidence,
            frame: Frame::default(),
            next_frame: Frame::default(),
            next: particles.clone(),
            particles,
            log_weights: vec![0.0; COUNT],
            scan: 0,
            mean: Mean::default(),
            course: Course::STRAIGHT,
        };
        belief.mean = belief.summary();
        belief.course = belief.bent();
        belief
    }

    /// A source shows the road ahead.
    pub fn looks_ahead(&self) -> bool {
        self.sources.looks_ahead()
    }

    /// Moves the ego on to the next scan.
    pub fn advance(&mut self, dt_s: f64, motion: &Motion) {
        let told = motion.yaw_rate_radps.filter(|_| self.sources.yaw_rate);
        let motion = Motion { yaw_rate_radps: told, ..*motion };
        let yaw_rate_radps = self.landmarks.yaw_rate_radps(&motion);
        // Without a yaw rate the ego follows the course.
        let turn_rad = match yaw_rate_radps {
            Some(radps) => radps * dt_s,
            None => self.course.curvature_perm(0.0) * motion.speed_mps * dt_s,
        };
        self.ego.advance(dt_s, &motion, turn_rad);
        if self.ego.way_m - self.way_m >= WAY_APART_M {
            self.way_m = self.ego.way_m;
            self.way.insert(0, (self.ego.x_m, self.ego.y_m));
            self.way.truncate(WAY);
        }
        self.own_perm = match yaw_rate_radps.filter(|_| motion.speed_mps >= SLOW_MPS) {
            None => None,
            Some(radps) => {
                let perm = radps / motion.speed_mps;
                let share = (dt_s / OWN_MEMORY_S).min(1.0);
                Some(self.own_perm.map_or(perm, |before| before + share * (perm - before)))
            }
        };
        self.course = self.bent();
    }

    /// Takes in a scan: the ego's motion, the map, and what stands. Allocates nothing.
    pub fn take(&mut self, motion: &Motion, map: Option<&MapAhead>, echoes: &[Echo]) {
        self.evidence.slip_rad = motion.slip_rad;
        if !self.sources.looks_ahead() {
            self.course = self.bent();
            return;
        }
        if self.sources.standing {
            self.landmarks.take(&self.ego, echoes);
        }
        if self.scan == 0 {
            self.gather(motion, map);
        }
        match self.scan {
            ..WEIGHING => self.weigh(self.scan),
            _ => self.step(self.scan - WEIGHING),
        }
        self.scan += 1;
        if self.scan == WEIGHING {
            self.resample();
            self.frame = self.next_frame;
            self.mean = self.summary();
        } else if self.scan == WEIGHING + MOVING {
            self.scan = 0;
            self.mean = self.summary();
        }
        self.course = self.bent();
    }

    /// Copies what is known into the evidence of a round.
    fn gather(&mut self, motion: &Motion, map: Option<&MapAhead>) {
        let ego = self.ego;
        self.next_frame = ego;
        let evidence = &mut self.evidence;
        evidence.marks.clear();
        evidence.way.clear();
        evidence.pairs.clear();
        evidence.speed_mps = motion.speed_mps;
        for landmark in self.landmarks.list.iter().filter(|landmark| landmark.count >= 2.0) {
            let at_m = ego.seen(landmark.place_m);
            if at_m.0 >= -BEHIND_M {
                let turn_m = TURN_RAD * landmark.nearest_m;
                let variance_m2 = 1.0 / landmark.weight + turn_m * turn_m + PLACE_M * PLACE_M;
                let area_m2 = landmark.area_m2 / landmark.count;
                let mark = Mark::new(at_m, variance_m2.sqrt(), area_m2, landmark.least_m2);
                evidence.marks.push(mark);
            }
        }
        evidence.count_bodies_once();
        if self.sources.yaw_rate {
            evidence.way.extend(self.way.iter().map(|place| ego.seen(*place)));
        }
        let behind_m = -motion.speed_mps * OWN_MEMORY_S;
        evidence.own = self.own_perm.map(|perm| (perm, behind_m));
        self.trails.pairs(&ego, |near, far| evidence.pairs.push((near, far)));
        evidence.map_perm = map.filter(|_| self.sources.map).and_then(|map| {
            let mut perm = [0.0; MAP_PLACES];
            for (place, perm) in perm.iter_mut().enumerate() {
                *perm = map.curvature_perm(place as f64 * MAP_APART_M)?;
            }
            Some(perm)
        });
    }

    /// The share of the hypotheses that a scan of some scans handles.
    fn share(scan: usize, scans: usize) -> std::ops::Range<usize> {
        scan * COUNT / scans..(scan + 1) * COUNT / scans
    }

    /// Weighs a share of the hypotheses.
    fn weigh(&mut self, scan: usize) {
        let to = self.frame.seen((self.next_frame.x_m, self.next_frame.y_m));
        let turn_rad = self.next_frame.heading_rad - self.frame.heading_rad;
        for index in Self::share(scan, WEIGHING) {
            let before = &self.particles[index];
            let hypothesis = before.moved(to, turn_rad, &mut self.random);
            let after = Particle::new(hypothesis, &self.evidence);
            self.log_weights[index] = match after.log_prior.is_finite() {
                true => after.log_likelihood - before.log_likelihood,
                false => f64::NEG_INFINITY,
            };
            self.next[index] = after;
        }
    }

    /// Doubles the heavy ones and ends the light ones.
    fn resample(&mut self) {
        let heaviest = self.log_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !heaviest.is_finite() {
            self.particles.copy_from_slice(&self.next);
            return;
        }
        let mut power = 1.0;
        let (mut total, mut squares);
        loop {
            (total, squares) = (0.0, 0.0);
            for log_weight in &self.log_weights {
                let weight = libm::exp(power * (log_weight - heaviest));
                total += weight;
                squares += weight * weight;
            }
            if total * total >= LEAST_EFFECTIVE * squares || power < 1e-3 {
                break;
            }
            power *= 0.7;
        }
        let apart = total / COUNT as f64;
        let (mut due, mut sum, mut kept) = (apart * self.random.uniform(), 0.0, 0);
        for (index, log_weight) in self.log_weights.iter().enumerate() {
            sum += libm::exp(power * (log_weight - heaviest));
            while due < sum && kept < COUNT {
                self.particles[kept] = self.next[index];
                (kept, due) = (kept + 1, due + apart);
            }
        }
        // Rounding may leave the last one without a successor.
        for index in kept..COUNT {
            self.particles[index] = self.particles[index.saturating_sub(1)];
        }
    }

    /// Moves a share of the hypotheses by some steps.
    fn step(&mut self, scan: usize) {
        for index in Self::share(scan, MOVING) {
            for _ in 0..STEPS {
                let before = &self.particles[index];
                let mut other = || {
                    let index = (self.random.uniform() * COUNT as f64) as usize;
                    &self.particles[index].hypothesis
                };
                let others = [other(), other()];
                let (hypothesis, step) = moves::step(&before.hypothesis, others, &mut self.random);
                let after = Particle::new(hypothesis, &self.evidence);
                let prior = match step {
                    Step::Walk => after.log_prior - before.log_prior,
                    Step::Redraw if after.log_prior.is_finite() => 0.0,
                    Step::Redraw => f64::NEG_INFINITY,
                };
                let ratio = prior + after.log_likelihood - before.log_likelihood;
                if libm::log(1.0 - self.random.uniform()) < ratio {
                    self.particles[index] = after;
                }
            }
        }
    }

    /// A vehicle is at a point of the body's axes, m, and moves across the road with `lateral_mps`.
    pub fn leave_trail(&mut self, id: u32, point_m: (f64, f64), lateral_mps: f64) {
        if !self.sources.trails {
        } else if lateral_mps.abs() > LANE_CHANGE_MPS {
            self.trails.forget(id);
        } else {
            self.trails.leave(&self.ego, id, point_m);
        }
    }
}

#[cfg(test)]
mod tests;
