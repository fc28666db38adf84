//! The ground of the scene: a straight road, or one with a plan.

use scenario::plan::{Plan, offset_at};

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
#[derive(Debug, Default)]
pub(super) enum Ground {
    /// Along x; the ego's lane alone is drawn.
    #[default]
    Straight,
    /// Ground by the road's plan, with all lanes.
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

    pub(super) fn lane_width_m(&self) -> f64 {
        match self {
            Self::Straight => LANE_WIDTH_M,
            Self::Plan(plan) => plan.lanes.width_m.value(),
        }
    }

    /// The lines of the lanes between two positions. Their points stay where they are when both positions move on.
    pub(super) fn lines(&self, [from_m, to_m]: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
        let along = |line: Vec<[f64; 2]>| -> Vec<[f64; 2]> {
            let (first_m, last_m) = (line[0][0].max(from_m), line[line.len() - 1][0].min(to_m));
            let (first, last) =
                ((first_m / STEP_M).ceil() as i64, (last_m / STEP_M).floor() as i64);
            (first..=last)
                .map(|step| step as f64 * STEP_M)
                .map(|p_m| self.place(p_m, offset_at(&line, p_m)).at_m)
                .collect()
        };
        let lines = match self {
            Self::Straight => [-0.5, 0.5]
                .map(|side| [from_m, to_m].map(|p_m| [p_m, side * LANE_WIDTH_M]).to_vec())
                .to_vec(),
            Self::Plan(plan) => plan.lanes.lines(from_m, to_m),
        };
        lines.into_iter().map(along).filter(|line| line.len() > 1).collect()
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
        // Circles around (0, 50).
        let lines = ground.lines([0.0, 60.0]);
        assert_eq!(lines.len(), 3);
        for (line, offset_m) in lines.iter().zip([-2.0, 2.0, 6.0]) {
            assert_eq!(line.len(), 21);
            for [x, y] in line {
                assert!((libm::hypot(*x, y - 50.0) - (50.0 - offset_m)).abs() < 1e-6);
            }
        }
        let heading_rad = ground.place(50.0, 0.0).heading_rad;
        assert!((heading_rad - 1.0).abs() < 1e-9);
    }
}
