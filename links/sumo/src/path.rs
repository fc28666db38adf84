//! The ego's lanes along its edges, with as few lane changes as the connections allow.
//!
//! ```text
//! edge 0          junction          edge 1                       junction
//! ── lane a ──────╮ via lanes ╭──── lane b ──╮                ╭──
//!                 ╰───────────╯              ╰──── lane c ────╯     a change where b does not lead on
//! ```

use crate::ReadError;
use crate::line::{Line, distance};
use crate::net::{Connection, Lane, Net};
use serde::{Deserialize, Serialize};

/// Points that are nearer to each other are one, m.
const SAME_M: f64 = 0.02;
/// Way of a change to the next lane, m, and its share of the edge at most.
const CHANGE_M: f64 = 50.0;
const CHANGE_SHARE: f64 = 0.6;
/// Share of the edge before a change begins.
const BEFORE_SHARE: f64 = 0.2;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Light {
    /// The controller's id in the net.
    pub controller: String,
    /// Place of the ego's movement in the controller's state.
    pub link: usize,
    /// Place of the stop line on the axis, m.
    pub stop_line_m: f64,
}

/// A stretch of the path from a way along its points on.
pub struct Stretch {
    pub from_m: f64,
    pub to_m: f64,
    pub speed_mps: f64,
    /// Lines from right to left at its beginning and at its end, m from the middle of the ego's lane.
    pub lines: [Vec<f64>; 2],
}

/// The path in the plane of the net.
#[derive(Default)]
pub struct Path {
    pub points: Vec<[f64; 2]>,
    pub stretches: Vec<Stretch>,
    /// Lights with the ways to their stop lines.
    pub lights: Vec<Light>,
    /// Ways to junctions without lights at which the ego would have to give way, m.
    pub yields_m: Vec<f64>,
    pub first_lane: usize,
    length_m: f64,
}

/// The lane on which the ego comes to an edge, and the one on which it leaves it, with the connection that leads on.
struct OnEdge<'a> {
    enters: usize,
    leaves: usize,
    onward: Option<&'a Connection>,
}

pub fn along(net: &Net, edges: &[String]) -> Result<Path, ReadError> {
    let mut path = Path::default();
    let lanes = lanes_along(net, edges)?;
    path.first_lane = lanes[0].enters;
    for (edge, on) in edges.iter().zip(&lanes) {
        path.drive(&net.edges[edge], on);
        let Some(onward) = on.onward else { continue };
        if let Some((controller, link)) = &onward.light {
            let (controller, stop_line_m) = (controller.clone(), path.length_m);
            path.lights.push(Light { controller, link: *link, stop_line_m });
        } else if onward.yields {
            path.yields_m.push(path.length_m);
        }
        let mut via = onward.via.as_deref();
        while let Some((inside, index, lane)) = via.and_then(|id| net.lane(id)) {
            path.follow(lane, vec![-0.5 * lane.width_m, 0.5 * lane.width_m]);
            let further = net.leaving(inside).iter().find(|next| next.from_lane == index);
            via = further.and_then(|next| next.via.as_deref());
        }
    }
    match path.points.len() {
        0 | 1 => Err(net.refuse("the ego's edges have no length", "longer edges")),
        _ => Ok(path),
    }
}

impl Path {
    fn add(&mut self, point: [f64; 2]) {
        let way_m = self.points.last().map_or(0.0, |last| distance(*last, point));
        if self.points.is_empty() || way_m > SAME_M {
            self.points.push(point);
            self.length_m += way_m;
        }
    }

    fn follow(&mut self, lane: &Lane, lines: Vec<f64>) {
        self.shape(&lane.shape, lane.speed_mps, [lines.clone(), lines]);
    }

    fn shape(&mut self, shape: &[[f64; 2]], speed_mps: f64, lines: [Vec<f64>; 2]) {
        let from_m = self.length_m;
        shape.iter().for_each(|point| self.add(*point));
        if self.length_m > from_m {
            self.stretches.push(Stretch { from_m, to_m: self.length_m, speed_mps, lines });
        }
    }

    /// Goes along an edge, with a change of lane where it is needed.
    fn drive(&mut self, lanes: &[Lane], on: &OnEdge<'_>) {
        let (from, to) = (&lanes[on.enters], &lanes[on.leaves]);
        if on.enters == on.leaves {
            return self.follow(from, lines(lanes, on.enters));
        }
        let (first, second) = (Line::of(&from.shape), Line::of(&to.shape));
        let (first_m, second_m) = (first.length_m(), second.length_m());
        let changed = on.enters.abs_diff(on.leaves) as f64;
        let share = (CHANGE_M * changed / first_m).min(CHANGE_SHARE);
        let begin_m = BEFORE_SHARE * first_m;
        let end_m = (BEFORE_SHARE + share) * second_m;
        let (own, other) = (lines(lanes, on.enters), lines(lanes, on.leaves));
        let speed_mps = from.speed_mps.min(to.speed_mps);
        let before = first.part(0.0, begin_m);
        let after = second.part(end_m, second_m);
        self.shape(&before, speed_mps, [own.clone(), own.clone()]);
        self.shape(&after[..1], speed_mps, [own, other.clone()]);
        self.shape(&after, speed_mps, [other.clone(), other]);
    }
}

/// Lines of the drivable lanes around one of an edge, from right to left. Lane 0 is the rightmost.
fn lines(lanes: &[Lane], own: usize) -> Vec<f64> {
    let half_m = 0.5 * lanes[own].width_m;
    let mut lines = vec![-half_m, half_m];
    for lane in lanes[..own].iter().rev().take_while(|lane| lane.drivable) {
        lines.insert(0, lines[0] - lane.width_m);
    }
    for lane in lanes[own + 1..].iter().take_while(|lane| lane.drivable) {
        lines.push(lines[lines.len() - 1] + lane.width_m);
    }
    lines
}

/// The lanes along edges: backwards, from the lanes that lead on to the last edge.
fn lanes_along<'a>(net: &'a Net, edges: &[String]) -> Result<Vec<OnEdge<'a>>, ReadError> {
    let Some(last) = edges.last() else {
        return Err(net.refuse("the ego's route has no edges", "one or more"));
    };
    // Changes still to be made from each lane of an edge at its end, and the onward connection with the next leaving lane.
    type End<'a> = Option<(usize, Option<(&'a Connection, usize)>)>;
    let drivable = |lane: &Lane| lane.drivable.then_some((0, None));
    let mut ends: Vec<Vec<End<'a>>> = vec![net.lanes(last)?.iter().map(drivable).collect()];
    for pair in edges.windows(2).rev() {
        let (lanes, next) = (net.lanes(&pair[0])?, &ends[ends.len() - 1]);
        let end = |index: usize| -> End<'a> {
            let onward = net.leaving(&pair[0]).iter();
            let onward = onward.filter(|one| one.to == pair[1] && one.from_lane == index);
            let changes = |one: &'a Connection| {
                next.iter().enumerate().filter_map(move |(leaves, end)| {
                    let (rest, _) = (*end)?;
                    Some((rest + one.to_lane.abs_diff(leaves), Some((one, leaves))))
                })
            };
            onward.flat_map(changes).min_by_key(|(cost, _)| *cost)
        };
        let found: Vec<_> =
            (0..lanes.len()).map(|index| end(index).filter(|_| lanes[index].drivable)).collect();
        if found.iter().all(Option::is_none) {
            let reason = format!("no lane for cars leads from `{}` to `{}`", pair[0], pair[1]);
            return Err(net.refuse(reason, "a route whose edges are connected"));
        }
        ends.push(found);
    }
    ends.reverse();
    let first = ends[0].iter().enumerate().filter_map(|(index, end)| Some((index, (*end)?.0)));
    let Some((mut leaves, _)) = first.min_by_key(|(_, cost)| *cost) else {
        let reason = format!("cars may not drive on `{}`", edges[0]);
        return Err(net.refuse(reason, "an edge with a lane for passenger cars"));
    };
    let mut enters = leaves;
    let on = ends.iter().map(|lanes| {
        let onward = lanes[leaves].and_then(|(_, onward)| onward);
        let on = OnEdge { enters, leaves, onward: onward.map(|(connection, _)| connection) };
        if let Some((connection, next)) = onward {
            (enters, leaves) = (connection.to_lane, next);
        }
        on
    });
    Ok(on.collect())
}
