//! Queries: means over the hypotheses.

use std::array::from_fn;

use super::super::course::Course;
use super::road::{FIRST_M, Line, NODES, Node, SPACING_M};
use super::{Belief, COUNT, Particle, likelihood};

/// Wander of the ego and of an object in the way, m.
const SWAY_M: f64 = 0.3;
/// Half of the ego's width, m: 1.8 m.
const HALF_WIDTH_M: f64 = 0.9;
/// Standard deviation of the course that the kind of hypotheses leaves: roads are not exactly clothoids and arcs, and
/// some hundred draws are not all. At the ego, m, and its growth with the distance.
const LEFT_M: f64 = 0.1;
const LEFT_RAD: f64 = 0.002;

/// Error of the circle's heading, rad, and of its curvature, 1/m: a wander of 0.2 m within the lane.
const ASKEW_RAD: f64 = 0.012;
const STEERED_PERM: f64 = 3e-4;

/// Mean over the hypotheses, in the frame of the lines.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mean {
    pub(super) line: Line,
    /// Standard deviations at the nodes across the road, m, and of the heading, rad.
    pub(super) sigma_m: [f64; NODES],
    pub(super) sigma_rad: [f64; NODES],
}

impl Belief {
    /// Mean and spread of the lines.
    pub(super) fn summary(&self) -> Mean {
        let share = 1.0 / COUNT as f64;
        let mut mean = Mean::default();
        let mean_of = |value: &dyn Fn(&Particle) -> f64| {
            share * self.particles.iter().map(value).sum::<f64>()
        };
        let heading_rad = mean_of(&|particle| particle.hypothesis.heading_rad);
        let mut nodes = from_fn::<_, NODES, _>(|_| Node::default());
        for particle in &self.particles {
            for (sum, node) in nodes.iter_mut().zip(&particle.line.nodes) {
                sum.x_m += share * node.x_m;
                sum.y_m += share * node.y_m;
                sum.turn_rad += share * node.turn_rad;
                sum.curvature_perm += share * node.curvature_perm;
            }
        }
        for node in &mut nodes {
            (node.sine, node.cosine) = libm::sincos(heading_rad + node.turn_rad);
        }
        for particle in &self.particles {
            let askew_rad = particle.hypothesis.heading_rad - heading_rad;
            for (index, (node, middle)) in particle.line.nodes.iter().zip(&nodes).enumerate() {
                let (dx, dy) = (node.x_m - middle.x_m, node.y_m - middle.y_m);
                let across_m = dy * middle.cosine - dx * middle.sine;
                mean.sigma_m[index] += share * across_m * across_m;
                let turn_rad = askew_rad + node.turn_rad - middle.turn_rad;
                mean.sigma_rad[index] += share * turn_rad * turn_rad;
            }
        }
        mean.sigma_m = from_fn(|index| {
            let left_m = LEFT_M + LEFT_RAD * (index as f64 * SPACING_M + FIRST_M).abs();
            (mean.sigma_m[index] + left_m * left_m).sqrt()
        });
        mean.sigma_rad = mean.sigma_rad.map(|square| (square + LEFT_RAD * LEFT_RAD).sqrt());
        mean.line = Line { nodes, heading_rad };
        mean
    }

    /// The course from the ego on: the mean's heading and curvatures.
    pub(super) fn bent(&self) -> Course {
        if !self.sources.looks_ahead() {
            return Course::bent(self.evidence.slip_rad, |_| self.own_perm.unwrap_or(0.0));
        }
        let ego = self.ego;
        let there = self.mean.line.beside(self.frame.seen((ego.x_m, ego.y_m)));
        let heading_rad = there.heading_rad - (ego.heading_rad - self.frame.heading_rad);
        let nodes = &self.mean.line.nodes;
        Course::bent(heading_rad, |sigma_m| {
            between(there.s_m + sigma_m, |index| nodes[index].curvature_perm)
        })
    }

    /// A point of the body's axes in the frame of the lines.
    fn framed(&self, point_m: (f64, f64)) -> (f64, f64) {
        self.frame.seen(self.ego.placed(point_m))
    }

    /// Probability that an object is in the ego's way. It is at a point of the body's axes, m, known across the road to
    /// `sigma_m`, and `width_m` wide. Ego and object wander in their lanes.
    pub fn in_way(&self, point_m: (f64, f64), sigma_m: f64, width_m: f64) -> f64 {
        let point_m = self.framed(point_m);
        let sharp_perm = 1.0 / libm::hypot(sigma_m, SWAY_M);
        let half_m = HALF_WIDTH_M + 0.5 * width_m;
        let among = |particle: &Particle| {
            let from = (particle.line.across_m(point_m) + half_m) * sharp_perm;
            likelihood::strip(from, 2.0 * half_m * sharp_perm)
        };
        self.particles.iter().map(among).sum::<f64>() / COUNT as f64
    }

    /// The same of an object that has always stood. A post is never in the way, and a vehicle stands in a lane, near
    /// the others of its queue. The cross section distinguishes the two.
    pub fn in_way_standing(&self, point_m: (f64, f64), sigma_m: f64, width_m: f64) -> f64 {
        let there_m = self.next_frame.seen(self.ego.placed(point_m));
        let Some(mark) = self.evidence.body(there_m) else {
            return self.in_way(point_m, sigma_m, width_m);
        };
        let at_m = self.frame.seen(self.next_frame.placed(mark.at_m));
        let half_m = HALF_WIDTH_M + 0.5 * width_m;
        let among = |particle: &Particle| {
            let d_m = particle.line.across_m(at_m);
            let in_way = likelihood::strip((d_m + half_m) / SWAY_M, 2.0 * half_m / SWAY_M);
            mark.in_lane(d_m, &particle.hypothesis, &particle.lanes, in_way)
        };
        self.particles.iter().map(among).sum::<f64>() / COUNT as f64
    }

    /// Probability that a track is in the way, by its place on the course: the arc length and the distance to the left, m.
    pub fn in_way_at(&self, place: (f64, f64), sigma_m: f64, width_m: f64, has_moved: bool) -> f64 {
        let point_m = self.course.place(place.0, place.1);
        match has_moved {
            true => self.in_way(point_m, sigma_m, width_m),
            false => self.in_way_standing(point_m, sigma_m, width_m),
        }
    }

    /// Distance of a point of the body's axes to the left of the lane's middle, m, with its standard deviation.
    pub fn beside_m(&self, point_m: (f64, f64)) -> (f64, f64) {
        let point_m = self.framed(point_m);
        let (mut sum, mut squares) = (0.0, 0.0);
        for particle in &self.particles {
            let d_m = particle.line.across_m(point_m);
            sum += d_m;
            squares += d_m * d_m;
        }
        let (mean, count) = (sum / COUNT as f64, COUNT as f64);
        let left_m = LEFT_M + LEFT_RAD * libm::hypot(point_m.0, point_m.1);
        (mean, ((squares / count - mean * mean).max(0.0) + left_m * left_m).sqrt())
    }

    pub fn course(&self) -> &Course {
        &self.course
    }

    /// Standard deviation of the course's place across the road at an arc length, m.
    pub fn sigma_m(&self, sigma_m: f64) -> f64 {
        if !self.sources.looks_ahead() {
            return libm::hypot(ASKEW_RAD * sigma_m, 0.5 * STEERED_PERM * sigma_m * sigma_m);
        }
        between(sigma_m, |index| self.mean.sigma_m[index])
    }

    /// Standard deviation of the course's heading at an arc length, rad.
    pub fn heading_sigma_rad(&self, sigma_m: f64) -> f64 {
        between(sigma_m, |index| self.mean.sigma_rad[index])
    }

    /// Landmarks and pairs of trail places in use.
    #[cfg(test)]
    pub fn used(&self) -> (u32, u32) {
        (self.evidence.marks.len() as u32, self.evidence.pairs.len() as u32)
    }
}

/// Value at an arc length, between those at two nodes.
fn between(s_m: f64, at: impl Fn(usize) -> f64) -> f64 {
    let place = ((s_m - FIRST_M) / SPACING_M).clamp(0.0, (NODES - 1) as f64);
    let index = (place as usize).min(NODES - 2);
    let before = at(index);
    before + (place - index as f64) * (at(index + 1) - before)
}
