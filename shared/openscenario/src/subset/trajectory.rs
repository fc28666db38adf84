//! Trajectories. Clothoids and NURBS are cut into chords of half a metre.
//!
//! A chord of length c is off a curve of radius R by c²/(8 R): 3 mm at 10 m.

use road::Pose;

use super::catalog::FromCatalog;
use super::position::{Spot, in_plane};
use super::route::{AcquirePositionAction, AssignRouteAction};
use crate::declare::{
    AtLeastOne, AtLeastZero, Count, Node, Number, OneOf, Positive, Truth, elements, words,
};
use crate::model::action::{self, Action, Vertex as Corner};
use crate::model::position::{self, From, Heading};
use crate::parameter::{ParameterDeclarations, Scoped};

const CHORD_M: f64 = 0.5;
/// Most chords of a curve; longer curves have longer chords.
const MAX_CHORDS: f64 = 20_000.0;

/// A control point: its position with its time, s, and its weight.
pub(crate) struct Control {
    position: position::Position,
    time_s: f64,
    weight: f64,
}

words! {
    /// Ways to follow that do the same.
    FollowingMode = () { "follow" (), "position" () }

    /// The origin of a time; its value is whether this is the start of the run.
    ReferenceContext = bool { "absolute" true, "relative" false }
}

elements! { "Actions";
    /// a trajectory replaces both the longitudinal and the lateral action
    RoutingAction -> Action []
    {action: OneOf<(FollowTrajectoryAction, AssignRouteAction, AcquirePositionAction)>}

    /// the entity moves along the trajectory, then goes straight on with its last speed
    FollowTrajectoryAction -> Action ["initialDistanceOffset" offset_m: Option<AtLeastZero> as "m"] {
        timing: Option<TimeReference>,
        _: Option<TrajectoryFollowingMode>,
        vertices: OneOf<(TrajectoryRef, Scoped<Trajectory>, FromCatalog<Trajectory>)>,
    } |node| {
        let (timing, initial_offset_m) = (timing.flatten(), offset_m.unwrap_or(0.0));
        let increase = vertices.is_sorted_by(|a, b| a.time_s < b.time_s);
        if timing.is_some() && !increase {
            let reason = "the times of the vertices do not increase";
            return Err(node.refuse(reason, "increasing times"));
        }
        if timing.is_some() && initial_offset_m > 0.0 {
            return Err(node.refuse("a timed trajectory has no initial offset", "no timing"));
        }
        Ok(Action::Trajectory(action::Trajectory { vertices, timing, initial_offset_m }))
    }

    /// the trajectory
    TrajectoryRef -> Vec<Corner> []
    {vertices: OneOf<(Scoped<Trajectory>, FromCatalog<Trajectory>)>}

    /// closed="false" only
    Trajectory -> Vec<Corner> ["closed" closed: Truth]
    {_: Option<ParameterDeclarations>, vertices: TrajectoryShape}
    unused ["name"]
    |node| {
        if closed {
            return Err(node.wrong("closed", "closed trajectories are not supported", "false"));
        }
        Ok(vertices)
    }

    /// the line
    TrajectoryShape = "Shape" -> Vec<Corner> [] {vertices: OneOf<(Polyline, Clothoid, Nurbs)>}

    /// straight pieces between two or more vertices
    Polyline -> Vec<Corner> [] {vertices: AtLeastOne<Vertex>}
    |node| {
        match vertices.len() {
            0 | 1 => Err(node.refuse("a line of one vertex", "two vertices or more")),
            _ => Ok(vertices),
        }
    }

    /// times increase; all or none have one
    Vertex -> Corner ["time" time_s: Option<Number> as "s"] {position: Spot}
    { Ok(Corner { time_s: time_s.unwrap_or(0.0), position }) }

    /// with timing the vertices' times set the speed, without it the entity keeps its own
    TimeReference -> Option<action::Timing> [] {timing: OneOf<(Untimed, Timing)>}

    /// no timing
    Untimed = "None" -> Option<action::Timing> [] {} { Ok(None) }

    /// time = scale * vertex time + offset, from the start of the run or of the action
    Timing -> Option<action::Timing>
    ["domainAbsoluteRelative" absolute: ReferenceContext, "scale" scale: Positive,
        "offset" offset_s: Number as "s"] {}
    { Ok(Some(action::Timing { absolute, scale, offset_s })) }

    /// follow and position do the same
    TrajectoryFollowingMode -> () ["followingMode" _: FollowingMode] {}

    /// the curvature changes evenly from the position on; with timing the way is covered evenly between its times
    Clothoid -> Vec<Corner>
    ["curvature" start_perm: Number as "1/m", "curvaturePrime" rate: Option<Number> as "1/m²",
        "curvatureDot" former_rate: Option<Number> as "1/m²", "length" length_m: Positive as "m",
        "startTime" from_s: Option<Number> as "s", "stopTime" to_s: Option<Number> as "s"]
    {position: Spot}
    |node| {
        let rate = rate.or(former_rate).unwrap_or(0.0);
        let (row, near_s_m, start) = in_plane(node, &position)?;
        let chords = libm::ceil(length_m / CHORD_M).min(MAX_CHORDS);
        let chord_m = length_m / chords;
        let heading = |p_m: f64| start.heading_rad + (start_perm + 0.5 * rate * p_m) * p_m;
        let (from_s, to_s) = (from_s.unwrap_or(0.0), to_s.unwrap_or(0.0));
        let (mut at, mut points) = ((start.x_m, start.y_m), vec![(start.x_m, start.y_m, from_s)]);
        for chord in 0..chords as u64 {
            let p_m = chord as f64 * chord_m;
            // Simpson's rule.
            for (share, weight) in [(0.0, 1.0), (0.5, 4.0), (1.0, 1.0)] {
                let (sin, cos) = libm::sincos(heading(p_m + share * chord_m));
                let way_m = weight * chord_m / 6.0;
                at = (at.0 + way_m * cos, at.1 + way_m * sin);
            }
            points.push((at.0, at.1, from_s + (to_s - from_s) * (p_m + chord_m) / length_m));
        }
        Ok(vertices(node, (row, near_s_m), &points))
    }

    /// order: degree and 1, not above the number of control points; one knot a control point and order more
    Nurbs -> Vec<Corner> ["order" order: Count]
    {controls: AtLeastOne<ControlPoint>, knots: AtLeastOne<Knot>}
    |node| {
        let (order, count) = (order as usize, controls.len());
        let is_sound = (2..=count).contains(&order)
            && knots.len() == count + order
            && knots.is_sorted()
            && knots[order - 1] < knots[count];
        if !is_sound {
            let reason = format!("order {order} with {count} points and {} knots", knots.len());
            let expected = "order 2 or more, as many points at least, and as many knots as both, which do not decrease";
            return Err(node.refuse(reason, expected));
        }
        let (from, to) = (knots[order - 1], knots[count]);
        let mut weighted = Vec::with_capacity(count);
        let (mut places, mut length_m) = (Vec::<(usize, f64, Pose)>::with_capacity(count), 0.0);
        for Control { position, time_s, weight } in &controls {
            let (row, s_m, at) = in_plane(node, position)?;
            let last = places.last().map_or(at, |(.., last)| *last);
            length_m += libm::hypot(at.x_m - last.x_m, at.y_m - last.y_m);
            places.push((row, s_m, at));
            weighted.push([at.x_m * weight, at.y_m * weight, time_s * weight, *weight]);
        }
        // The control points' polygon is at least as long as the curve.
        let chords = libm::ceil(length_m / CHORD_M).clamp(count as f64, MAX_CHORDS);
        let at = |chord: u64| {
            let [x, y, t, w] = spline(order, &knots, &weighted, from + (to - from) * chord as f64 / chords);
            (x / w, y / w, t / w)
        };
        let points: Vec<_> = (0..=chords as u64).map(at).collect();
        Ok(vertices(node, (places[0].0, places[0].1), &points))
    }

    /// pulls the curve by its weight, 1 if it is missing; all or none have a time
    ControlPoint -> Control
    ["time" time_s: Option<Number> as "s", "weight" weight: Option<Positive>] {position: Spot}
    { Ok(Control { position, time_s: time_s.unwrap_or(0.0), weight: weight.unwrap_or(1.0) }) }

    /// a value of the curve's parameter
    Knot -> f64 ["value" value: Number] {}
}

/// The point of a B-spline at a parameter, by de Boor's algorithm.
fn spline(order: usize, knots: &[f64], points: &[[f64; 4]], at: f64) -> [f64; 4] {
    let last = points.len();
    // The span that holds the parameter, and is not empty.
    let mut span = knots.partition_point(|knot| *knot <= at).clamp(order, last) - 1;
    while knots[span] == knots[span + 1] && span + 1 > order {
        span -= 1;
    }
    let mut row: Vec<[f64; 4]> = points[span + 1 - order..=span].to_vec();
    for level in 1..order {
        for j in (level..order).rev() {
            let i = j + span + 1 - order;
            let share = (at - knots[i]) / (knots[i + order - level] - knots[i]);
            row[j] = std::array::from_fn(|k| row[j - 1][k] + share * (row[j][k] - row[j - 1][k]));
        }
    }
    row[order - 1]
}

/// Corners from points of the plane with their times. They follow each other from a place of the road on.
fn vertices(
    node: Node<'_>,
    (row, mut near_s_m): (usize, f64),
    points: &[(f64, f64, f64)],
) -> Vec<Corner> {
    let ground = &node.scene.row(row).ground;
    let corner = |&(x_m, y_m, time_s): &(f64, f64, f64)| {
        let (s_m, t_m) = ground.project((x_m, y_m), near_s_m);
        near_s_m = s_m;
        let from = From::Road { row, s_m, t_m };
        Corner { time_s, position: position::Position { from, heading: Heading::Road(0.0) } }
    };
    points.iter().map(corner).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_1_SQRT_2;

    use super::*;

    /// A quarter of a circle is a rational spline of order 3.
    #[test]
    fn a_quarter_of_a_circle() {
        let w = FRAC_1_SQRT_2;
        let points = [[1.0, 0.0, 0.0, 1.0], [w, w, 0.0, w], [0.0, 1.0, 0.0, 1.0]];
        let knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        for i in 0..=10 {
            let [x, y, _, w] = spline(3, &knots, &points, f64::from(i) / 10.0);
            assert!((libm::hypot(x / w, y / w) - 1.0).abs() < 1e-12);
        }
        let [x, y, ..] = spline(3, &knots, &points, 1.0);
        assert!(x.abs() < 1e-12 && (y - 1.0).abs() < 1e-12);
    }

    /// Order 2 is the polygon of the control points, also where knots are the same.
    #[test]
    fn the_second_order_is_a_polygon() {
        let points = [[0.0, 0.0, 0.0, 1.0], [2.0, 0.0, 1.0, 1.0], [2.0, 4.0, 3.0, 1.0]];
        let at = |u: f64| spline(2, &[0.0, 0.0, 1.0, 2.0, 2.0], &points, u);
        assert_eq!(at(0.5), [1.0, 0.0, 0.5, 1.0]);
        assert_eq!(at(1.5), [2.0, 2.0, 2.0, 1.0]);
        assert_eq!(at(2.0), [2.0, 4.0, 3.0, 1.0]);
    }
}
