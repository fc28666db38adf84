//! One hypothesis of the road: a row of curves, and where the ego is in its lane.
//!
//! A curve is a clothoid, an arc and a clothoid, as roads are built. Between two curves the road is straight.
//!
//! ```text
//! curvature        arc
//!               ┌───────┐
//!        ramp  /         \  ramp
//! ────────────┘           └──────────── arc length
//!           from           to
//! ```
//!
//! [`Line`] is the curve in the plane. It has nodes at equal arc lengths. Around a node it is the arc of a circle.

/// Curves of a hypothesis: the one at the ego or ahead, and the two behind that one.
pub const BENDS: usize = 3;
/// Distance between two nodes, m. The arc around a node is off by 0.1 m at most where a curve of 170 m radius begins.
pub const SPACING_M: f64 = 12.0;
/// Nodes behind the ego: the way of some seconds, which the ego has driven in its lane.
pub const BEHIND: usize = 6;
/// All nodes. The last one is 180 m ahead: beyond the radar's range.
pub const NODES: usize = 22;
/// Arc length of the first node, m.
pub const FIRST_M: f64 = -(BEHIND as f64) * SPACING_M;

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bend {
    /// Arc length at which it begins, m.
    pub from_m: f64,
    /// Curvature of the arc, 1/m, left positive.
    pub curvature_perm: f64,
    /// Length of each clothoid, m, above 0.
    pub ramp_m: f64,
    /// Length of the arc, m.
    pub arc_m: f64,
}

impl Bend {
    /// Arc length at which it ends, m.
    pub fn to_m(&self) -> f64 {
        self.from_m + 2.0 * self.ramp_m + self.arc_m
    }

    /// Ends at another arc length, m: by another length of the arc.
    pub fn end_at(&mut self, to_m: f64) {
        self.arc_m = to_m - self.from_m - 2.0 * self.ramp_m;
    }

    /// Curvature at an arc length, 1/m.
    pub fn at(&self, s_m: f64) -> f64 {
        let into_m = (s_m - self.from_m).min(self.to_m() - s_m);
        self.curvature_perm * (into_m / self.ramp_m).clamp(0.0, 1.0)
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hypothesis {
    /// Curves in their order.
    pub bends: [Bend; BENDS],
    /// Heading of the lane at the bumper in the body's axes, rad.
    pub heading_rad: f64,
    /// Middle of the lane to the left of the bumper, m.
    pub offset_m: f64,
    /// Distance of the nearest objects beside the road from the middle of the lane, left and right, m.
    pub edges_m: [f64; 2],
}

impl Hypothesis {
    /// Curvature at an arc length, 1/m.
    pub fn curvature_perm(&self, s_m: f64) -> f64 {
        self.bends.iter().map(|bend| bend.at(s_m)).sum()
    }
}

/// A place of the line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Node {
    /// In the body's axes, m.
    pub x_m: f64,
    pub y_m: f64,
    /// Cosine and sine of the heading.
    pub cosine: f64,
    pub sine: f64,
    /// Heading against the one at the bumper, rad.
    pub turn_rad: f64,
    /// Mean curvature around the node, 1/m.
    pub curvature_perm: f64,
}

/// Place of a point beside the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beside {
    /// Arc length of the foot of the perpendicular, m.
    pub s_m: f64,
    /// Distance to the left, m.
    pub d_m: f64,
    /// Heading of the line there, rad.
    pub heading_rad: f64,
}

/// The middle of the lane in the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    pub nodes: [Node; NODES],
    /// Heading at the bumper in the body's axes, rad.
    pub heading_rad: f64,
}

impl Line {
    /// The line of a hypothesis.
    pub fn of(hypothesis: &Hypothesis) -> Self {
        // Turns at every half of a spacing, against the one at the bumper.
        let mut turns = [0.0; 2 * NODES + 1];
        for bend in &hypothesis.bends {
            let from_m = bend.from_m - FIRST_M + 0.5 * SPACING_M;
            if from_m > 0.5 * SPACING_M * turns.len() as f64 {
                break;
            }
            let half_per_ramp = 0.5 / bend.ramp_m;
            let second_m = bend.ramp_m + bend.arc_m;
            // Integral of the trapezoid: of one ramp that rises, less that of one that falls.
            let rise_m = |into_m: f64| {
                let on_ramp_m = into_m.clamp(0.0, bend.ramp_m);
                on_ramp_m * on_ramp_m * half_per_ramp + (into_m - bend.ramp_m).max(0.0)
            };
            let first = (from_m / (0.5 * SPACING_M)).max(0.0) as usize;
            for (index, turn) in turns.iter_mut().enumerate().skip(first) {
                let into_m = index as f64 * (0.5 * SPACING_M) - from_m;
                *turn += bend.curvature_perm * (rise_m(into_m) - rise_m(into_m - second_m));
            }
        }
        let at_bumper = turns[2 * BEHIND + 1];
        let mut line = Self { heading_rad: hypothesis.heading_rad, ..Self::default() };
        let (sine, cosine) = libm::sincos(hypothesis.heading_rad + turns[1] - at_bumper);
        let mut node = Node { cosine, sine, ..Node::default() };
        for (index, room) in line.nodes.iter_mut().enumerate() {
            let [before, here, middle] = [0, 1, 2].map(|k| turns[2 * index + k]);
            node.turn_rad = here - at_bumper;
            node.curvature_perm = (middle - before) * (1.0 / SPACING_M);
            *room = node;
            let after = turns[(2 * index + 3).min(2 * NODES)];
            // Simpson's rule for the way, in the node's axes.
            let ((cos_middle, sin_middle), (cos_after, sin_after)) =
                (small(middle - here), small(after - here));
            let along_m = (SPACING_M / 6.0) * (1.0 + 4.0 * cos_middle + cos_after);
            let across_m = (SPACING_M / 6.0) * (4.0 * sin_middle + sin_after);
            node.x_m += node.cosine * along_m - node.sine * across_m;
            node.y_m += node.sine * along_m + node.cosine * across_m;
            (node.cosine, node.sine) = node.turned(after - here);
        }
        let origin = line.nodes[BEHIND];
        let aside = (-origin.sine * hypothesis.offset_m, origin.cosine * hypothesis.offset_m);
        for node in &mut line.nodes {
            node.x_m += aside.0 - origin.x_m;
            node.y_m += aside.1 - origin.y_m;
        }
        line
    }

    /// Distance of a point of the body's axes to the left of the line, m.
    pub fn across_m(&self, (x_m, y_m): (f64, f64)) -> f64 {
        let (index, along_m, across_m) = nearest(&self.nodes, (SPACING_M, FIRST_M), (x_m, y_m));
        let curvature = self.nodes[index].curvature_perm;
        let (a, g) = (curvature * along_m, 1.0 - curvature * across_m);
        let square = along_m * along_m + across_m * across_m;
        (2.0 * across_m - curvature * square) / (1.0 + (a * a + g * g).sqrt())
    }

    /// Place of a point of the body's axes.
    pub fn beside(&self, point: (f64, f64)) -> Beside {
        let (index, along_m, across_m) = nearest(&self.nodes, (SPACING_M, FIRST_M), point);
        let node = &self.nodes[index];
        let curvature = node.curvature_perm;
        let slope = curvature * along_m / (1.0 - curvature * across_m).max(0.2);
        let stretch = (1.0 - curvature * across_m).max(0.2);
        let arc_m = along_m / stretch * (1.0 - slope * slope / 3.0);
        Beside {
            s_m: FIRST_M + index as f64 * SPACING_M + arc_m,
            d_m: self.across_m(point),
            heading_rad: self.heading_rad + node.turn_rad + curvature * arc_m,
        }
    }
}

/// The node nearest to a point, and the point in its axes. The nodes are `spacing_m` apart, and the first one is at the
/// arc length `first_m`.
#[inline]
pub fn nearest(
    nodes: &[Node],
    (spacing_m, first_m): (f64, f64),
    (x_m, y_m): (f64, f64),
) -> (usize, f64, f64) {
    let last = (nodes.len() - 1) as f64;
    let at = |place: f64| place.round().clamp(0.0, last) as usize;
    let seen_from = |index: usize| {
        let node = &nodes[index];
        let (dx, dy) = (x_m - node.x_m, y_m - node.y_m);
        (index, dx * node.cosine + dy * node.sine, dy * node.cosine - dx * node.sine)
    };
    let range_m = (x_m * x_m + y_m * y_m).sqrt();
    let mut here =
        seen_from(at((if x_m < 0.0 { -range_m } else { range_m } - first_m) / spacing_m));
    // Each step brings the foot of the perpendicular closer; on a strong curve a few are needed.
    for _ in 0..5 {
        let (index, along_m, across_m) = here;
        if along_m.abs() <= 0.5 * spacing_m {
            break;
        }
        let stretch = (1.0 - nodes[index].curvature_perm * across_m).max(0.2);
        let next = at(index as f64 + along_m / (spacing_m * stretch));
        if next == index {
            break;
        }
        here = seen_from(next);
    }
    here
}

impl Node {
    /// Cosine and sine of its heading turned by an angle.
    pub fn turned(&self, turn_rad: f64) -> (f64, f64) {
        let (cosine, sine) = small(turn_rad);
        (self.cosine * cosine - self.sine * sine, self.sine * cosine + self.cosine * sine)
    }
}

/// Cosine and sine of a turn between two nodes: series whose error is below 1e-7 up to 0.6 rad, and 1e-15 up to 0.05.
fn small(turn_rad: f64) -> (f64, f64) {
    let square = turn_rad * turn_rad;
    let cosine = 1.0 - 0.5 * square * (1.0 - square * (1.0 / 12.0) * (1.0 - square * (1.0 / 30.0)));
    let sine = turn_rad
        * (1.0 - square * (1.0 / 6.0) * (1.0 - square * (1.0 / 20.0) * (1.0 - square / 42.0)));
    (cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry() -> Hypothesis {
        let bend = Bend { from_m: 40.0, curvature_perm: -1.0 / 170.0, ramp_m: 63.0, arc_m: 180.0 };
        let far = Bend { from_m: 900.0, ramp_m: 1.0, ..Bend::default() };
        Hypothesis {
            bends: [bend, far, far],
            heading_rad: 0.02,
            offset_m: 0.3,
            edges_m: [8.0, 8.0],
        }
    }

    /// Point at an arc length by small steps, and the heading there.
    fn walked(hypothesis: &Hypothesis, s_m: f64) -> (f64, f64, f64) {
        let steps = 4_000;
        let step_m = s_m / f64::from(steps);
        let heading = hypothesis.heading_rad;
        let start =
            (-hypothesis.offset_m * libm::sin(heading), hypothesis.offset_m * libm::cos(heading));
        (0..steps).fold((start.0, start.1, heading), |(x, y, heading), k| {
            let curvature = hypothesis.curvature_perm((f64::from(k) + 0.5) * step_m);
            let middle = heading + 0.5 * step_m * curvature;
            (
                x + step_m * libm::cos(middle),
                y + step_m * libm::sin(middle),
                heading + step_m * curvature,
            )
        })
    }

    #[test]
    fn it_follows_clothoid_arc_and_clothoid() {
        for (s_m, d_m) in [(-50.0, 1.0), (20.0, -3.0), (61.0, 0.0), (110.0, 3.5), (150.0, -8.0)] {
            let (x, y, heading) = walked(&entry(), s_m);
            let point = (x - d_m * libm::sin(heading), y + d_m * libm::cos(heading));
            let found = Line::of(&entry()).beside(point);
            assert!((found.d_m - d_m).abs() < 0.03, "{found:?} for {s_m}, {d_m}");
            assert!((found.s_m - s_m).abs() < 0.1, "{found:?} for {s_m}, {d_m}");
            assert!((found.heading_rad - heading).abs() < 2e-3, "{found:?}, {heading}");
        }
    }

    #[test]
    fn a_sudden_tight_arc_is_followed_to_a_few_tenths() {
        let mut tight = entry();
        tight.bends[0] =
            Bend { from_m: 33.0, curvature_perm: 1.0 / 60.0, ramp_m: 0.5, arc_m: 50.0 };
        for s_m in [30.0, 39.0, 60.0, 90.0, 120.0] {
            let (x, y, _) = walked(&tight, s_m);
            let off_m = Line::of(&tight).across_m((x, y));
            assert!(off_m.abs() < 0.25, "{off_m} at {s_m}");
        }
    }
}
