//! The lines of a road's lanes along the line that a vehicle drives.

use road::{AxisError, LaneLines, Strip};

use super::{Driven, Ground, INSIDE_M, Road};

/// Distance between two stations, m.
const SPACING_M: f64 = 10.0;
/// Most stations of a line; longer lines have larger distances.
const MAX_STATIONS: f64 = 4000.0;
/// A narrower lane is not drawn, m.
const NARROW_M: f64 = 0.05;
/// Difference of two lines that counts as none, m.
const SAME_M: f64 = 1e-3;

impl Road {
    /// The lines of the lanes around a line of this road, as seen from it. They include all lanes without a break on
    /// which vehicles drive, also those of the other direction. `None` if the lines stay as they begin.
    ///
    /// The distance of a line counts across the reference line: where lanes shift, that is not quite across the line.
    ///
    /// # Errors
    /// When the line makes no axis.
    pub fn lane_lines(&self, line: &Driven) -> Result<LaneLines, AxisError> {
        let (reference, (axis, start)) = (Ground::of(self, &self.start())?, line.axis()?);
        let forward = line.to_m >= line.from_m;
        let (low_m, high_m) = (line.from_m.min(line.to_m), line.from_m.max(line.to_m));
        let count = libm::ceil((high_m - low_m) / SPACING_M).clamp(1.0, MAX_STATIONS);
        let even = (0..=count as u64).map(|i| low_m + (high_m - low_m) * i as f64 / count);
        let joints = self.lanes.sections.iter().map(|section| section.from_m);
        let joints = joints.filter(|at_m| *at_m > low_m + INSIDE_M && *at_m < high_m - INSIDE_M);
        let sides = joints.flat_map(|at_m| [at_m - INSIDE_M, at_m]);
        let mut places: Vec<f64> = even.chain(sides).collect();
        places.sort_by(f64::total_cmp);
        if !forward {
            places.reverse();
        }
        let (mut p_m, mut before_m) = (0.0, line.from_m);
        let mut stations: Vec<Vec<f64>> = Vec::with_capacity(places.len());
        for s_m in places {
            let t_m = line.offset.at(s_m);
            let at = reference.point(s_m, t_m).seen_from(&start);
            let found_m = axis.project(at.x_m, at.y_m, p_m + (s_m - before_m).abs()).0;
            (p_m, before_m) = (found_m.clamp(p_m, axis.length_m()), s_m);
            let lines = self.lines_around(s_m, t_m);
            if lines.is_empty() {
                continue;
            }
            let mut station: Vec<f64> = lines.into_iter().map(|at_m| at_m - t_m).collect();
            if !forward {
                station = station.into_iter().rev().map(|at_m| 0.0 - at_m).collect();
            }
            station.insert(0, p_m);
            stations
                .push(station.into_iter().map(|value| libm::round(value * 1e4) / 1e4).collect());
        }
        let is_same = |station: &Vec<f64>| {
            station.len() == stations[0].len()
                && station.iter().zip(&stations[0]).skip(1).all(|(a, b)| (a - b).abs() < SAME_M)
        };
        let changes = !stations.iter().all(is_same);
        let lines = LaneLines::new(stations);
        Ok(if changes && lines.is_sound() { lines } else { LaneLines::default() })
    }

    /// The lines of the drivable lanes around a place, from right to left. They count to the left of the reference
    /// line, m.
    fn lines_around(&self, s_m: f64, t_m: f64) -> Vec<f64> {
        let strips = self.strips(s_m);
        let Some(own) = self.lane_at(s_m, t_m) else { return Vec::new() };
        let goes_on = |strip: &&Strip| strip.drivable || strip.width_m <= NARROW_M;
        let right = strips[..own.index].iter().rev().take_while(goes_on).count();
        let left = strips[own.index + 1..].iter().take_while(goes_on).count();
        let mut lines = Vec::new();
        for strip in &strips[own.index - right..=own.index + left] {
            if strip.width_m <= NARROW_M && strip.index != own.index {
                continue;
            }
            let [from_m, to_m] = [-0.5, 0.5].map(|side| strip.center_m + side * strip.width_m);
            if lines.is_empty() {
                lines.push(from_m);
            }
            lines.push(to_m);
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::road::driven_lane;

    /// A second lane opens to the right between 100 and 150 m, behind a new section. There is a lane of the other
    /// direction.
    const ROAD: &str = r#"<OpenDRIVE><road id="1" length="300" junction="-1">
<planView><geometry s="0" x="0" y="0" hdg="0" length="300"><arc curvature="0.002"/></geometry></planView>
<lanes><laneSection s="0">
<left><lane id="1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></left>
<right><lane id="-1" type="driving"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right>
</laneSection><laneSection s="100">
<left><lane id="1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></left>
<right><lane id="-1" type="driving"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane>
<lane id="-2" type="driving"><width sOffset="0" a="0" b="0.07" c="0" d="0"/><width sOffset="50" a="3.5" b="0" c="0" d="0"/></lane></right>
</laneSection></lanes></road></OpenDRIVE>"#;

    #[test]
    fn a_lane_that_opens_moves_the_edge() {
        let lane = driven_lane(Path::new("a.xodr"), ROAD, "1", -1, 20.0).expect("a lane");
        let lines = lane.road.lane_lines(&lane.line).expect("an axis");
        // The lane's middle is on the outer side of the left curve: its way is longer.
        let along = |s_m: f64| (s_m - 20.0) * (1.0 + 0.002 * 1.75);
        let near = |p_m: f64, expected: [f64; 2]| {
            let edges = lines.edges_m(p_m).expect("edges");
            let off_m = (edges[0] - expected[0]).abs().max((edges[1] - expected[1]).abs());
            assert!(off_m < 1e-3, "{edges:?} at {p_m}");
        };
        near(0.0, [-1.75, 4.75]);
        near(along(100.0) - 0.1, [-1.75, 4.75]);
        near(along(130.0), [-1.75 - 2.1, 4.75]);
        near(along(290.0), [-5.25, 4.75]);
        // Three lines, then four.
        let lengths: Vec<usize> = lines.between(0.0, 400.0).iter().map(|line| line.len()).collect();
        assert_eq!(lengths.len(), 7, "{lengths:?}");
    }

    #[test]
    fn against_the_reference_line_left_is_right() {
        let lane = driven_lane(Path::new("a.xodr"), ROAD, "1", 1, 280.0).expect("a lane");
        let lines = lane.road.lane_lines(&lane.line).expect("an axis");
        let [right_m, left_m] = lines.edges_m(5.0).expect("edges");
        assert!((right_m + 1.5).abs() < 1e-3 && (left_m - 8.5).abs() < 1e-3, "{right_m} {left_m}");
        let [_, left_m] = lines.edges_m(270.0).expect("edges");
        assert!((left_m - 5.0).abs() < 1e-3, "{left_m}");
    }

    #[test]
    fn lanes_that_stay_as_they_are_have_no_lines_of_their_own() {
        let text = ROAD.split("</laneSection>").next().expect("a part").to_owned()
            + "</laneSection></lanes></road></OpenDRIVE>";
        let lane = driven_lane(Path::new("a.xodr"), &text, "1", -1, 20.0).expect("a lane");
        assert!(lane.road.lane_lines(&lane.line).expect("an axis").is_empty());
    }
}
