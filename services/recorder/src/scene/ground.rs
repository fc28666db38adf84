//! The ground of the scene: a straight road, or one with a plan.

use scenario::plan::Plan;

/// Width of the lane of a straight road, m.
pub(super) const LANE_WIDTH_M: f64 = 3.5;
/// Step along a line of a road with a plan, m.
const STEP_M: f64 = 3.0;

/// A place in the frame `road`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Place {
    pub(super) at_m: [f64; 2],
    pub(super) heading_rad: f64,
}

impl Place {
    /// The point ahead of here and to the left, m.
    pub(super) fn point(&self, ahead_m: f64, left_m: f64) -> [f64; 2] {
        let (sine, cosine) = libm::sincos(self.heading_rad);
        let [x, y] = self.at_m;
        [x + ahead_m * cosine - left_m * sine, y + ahead_m * sine + left_m * cosine]
    }

    /// All numbers are finite: a message from outside the group may hold anything.
    pub(super) fn is_finite(&self) -> bool {
        self.at_m.iter().all(|value| value.is_finite()) && self.heading_rad.is_finite()
    }
}

/// The road that is drawn.
#[derive(Debug)]
pub(super) enum Ground {
    /// Along x; the ego's lane alone is drawn.
    Straight,
    /// By its plan, with all lanes.
    Plan(Box<Plan>),
}

impl Ground {
    /// The place on the road, from its position along the axis and its offset to the left, m.
    pub(super) fn place(&self, position_m: f64, left_m: f64) -> Place {
        match self {
            Self::Straight => Place { at_m: [position_m, left_m], heading_rad: 0.0 },
            Self::Plan(plan) => {
                let pose = plan.axis().point(position_m, left_m).placed(&plan.start.pose());
                Place { at_m: [pose.x_m, pose.y_m], heading_rad: pose.heading_rad }
            }
        }
    }

    pub(super) fn has_plan(&self) -> bool {
        matches!(self, Self::Plan(_))
    }

    /// Width of the ego's lane, m.
    pub(super) fn lane_width_m(&self) -> f64 {
        match self {
            Self::Straight => LANE_WIDTH_M,
            Self::Plan(plan) => plan.lanes.width_m.value(),
        }
    }

    /// Offsets of the lines of the lanes, m to the left.
    pub(super) fn lines_m(&self) -> Vec<f64> {
        match self {
            Self::Straight => [-0.5, 0.5].map(|side| side * LANE_WIDTH_M).to_vec(),
            Self::Plan(plan) => {
                let lanes = &plan.lanes;
                let count = lanes.left.value() + lanes.right.value() + 1;
                let offset = |line| lanes.right_edge_m() + f64::from(line) * lanes.width_m.value();
                (0..=count).map(offset).collect()
            }
        }
    }

    /// A line along the road between two positions. Its points stay where they are when both positions move on.
    pub(super) fn line(&self, [from_m, to_m]: [f64; 2], left_m: f64) -> Vec<[f64; 2]> {
        let first = (from_m / STEP_M).ceil() as i64;
        let last = (to_m / STEP_M).floor() as i64;
        (first..=last).map(|step| self.place(step as f64 * STEP_M, left_m).at_m).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scenario::Scenario;

    #[test]
    fn a_place_turns_its_points() {
        let place = Place { at_m: [10.0, 5.0], heading_rad: std::f64::consts::FRAC_PI_2 };
        let [x, y] = place.point(3.0, 1.0);
        assert!((x - 9.0).abs() < 1e-12 && (y - 8.0).abs() < 1e-12);
        let ahead = Place::default().point(3.0, 1.0);
        assert_eq!(ahead, [3.0, 1.0], "exactly");
        assert!(!Place { heading_rad: f64::NAN, ..place }.is_finite());
    }

    #[test]
    fn lines_follow_the_plan() {
        let text = "schema_version = 1\nname = \"x\"\nset_speed_mps = 10\n[road.plan]\n\
                    pieces = [{ arc_m = 100, radius_m = 50, turn = \"left\" }, { line_m = 500 }]\n\
                    lanes = { left = 1, right = 0, width_m = 4 }\n";
        let scenario = Scenario::parse("x.toml", text).expect("it is right");
        let plan = scenario.road.plan().expect("it has one").clone();
        let ground = Ground::Plan(Box::new(plan));
        assert_eq!(ground.lines_m(), [-2.0, 2.0, 6.0]);
        // A circle around (0, 50).
        for [x, y] in ground.line([0.0, 60.0], 2.0) {
            assert!((libm::hypot(x, y - 50.0) - 48.0).abs() < 1e-6);
        }
        let heading_rad = ground.place(50.0, 0.0).heading_rad;
        assert!((heading_rad - 1.0).abs() < 1e-9);
    }
}
