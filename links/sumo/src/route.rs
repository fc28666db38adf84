//! The ego's route as a road: what a scenario keeps of a net.

use std::path::Path as File;

use road::{Axis, AxisError, LaneLines, Piece, Pose};
use serde::{Deserialize, Serialize};

use crate::ReadError;
use crate::demand;
use crate::net::{self, Net};
use crate::path::{self, Light};
use crate::smooth::Smooth;

/// Smallest radius of a route, m: turns inside of junctions are narrow.
const MIN_RADIUS_M: f64 = 1.0;
/// Way between the ego's rear at the start and the beginning of its lane, m.
const BEHIND_M: f64 = 0.1;
/// Way from the end of the route to that of its last lane, m: SUMO takes a vehicle away that has come to the end.
const BEFORE_END_M: f64 = 5.0;
/// Share of a curve's radius up to which lanes reach inwards.
const INNER_SHARE: f64 = 0.8;
/// Length of a cell of the limits, m, and the places in it whose curvature is looked at.
const CELL_M: f64 = 5.0;
const CELL_SAMPLES: u32 = 10;
/// Lateral acceleration in a curve, m/s²: below the 2.3 m/s² that passengers accept, for a law that is late.
const LATERAL_MPS2: f64 = 1.8;
/// Least way between two stop lines, m.
const APART_M: f64 = 0.1;

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limit {
    /// Place on the axis, m.
    pub from_m: f64,
    pub speed_mps: f64,
}

/// A route of a net as the ego's road.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Route {
    pub edges: Vec<String>,
    /// Index of the lane on which the ego begins.
    pub lane: usize,
    /// Place of its front bumper on that lane, m.
    pub depart_m: f64,
    /// Lines and arcs of its axis.
    pub pieces: Vec<Piece>,
    /// Beginning of the axis in the plane of the net.
    pub start: Pose,
    /// Lines of the lanes along the axis.
    pub lines: LaneLines,
    pub limits: Vec<Limit>,
    pub lights: Vec<Light>,
    /// Remarks for a person, a sentence each.
    pub notes: Vec<String>,
}

impl Route {
    /// The axis, and its beginning in the plane of the net.
    ///
    /// # Errors
    /// When a turn is narrower than a metre.
    pub fn axis(&self) -> Result<(Axis, Pose), AxisError> {
        Ok((Axis::narrow(&self.pieces, MIN_RADIUS_M)?, self.start))
    }

    /// The largest limit of the route, m/s.
    pub fn fastest_mps(&self) -> f64 {
        self.limits.iter().map(|limit| limit.speed_mps).fold(0.0, f64::max)
    }

    /// Time of a free drive at the limits, s.
    pub fn free_s(&self) -> f64 {
        let length_m: f64 = self.pieces.iter().map(Piece::length_m).sum();
        let ends = self.limits.iter().skip(1).map(|limit| limit.from_m).chain([length_m]);
        let times = self.limits.iter().zip(ends);
        times.map(|(limit, end_m)| (end_m - limit.from_m).max(0.0) / limit.speed_mps.max(1.0)).sum()
    }
}

/// Reads the route `ego` of the configuration at `file`: the name of a route, vehicle, trip or flow, or
/// `from=EDGE,to=EDGE`. The ego is `length_m` long.
///
/// # Errors
/// When a file cannot be read, or has no such route.
pub fn read_route(file: &File, ego: &str, length_m: f64) -> Result<Route, ReadError> {
    let (net, demand) = net::configured(file)?;
    let net = Net::read(&net)?;
    let edges = demand::edges(ego, &net, &demand)?;
    let path = path::along(&net, &edges)?;
    let smooth = Smooth::of(&path.points);
    let whole = Axis::narrow(&smooth.pieces, MIN_RADIUS_M).map_err(|error| {
        let reason = format!("the route `{ego}` has {error}");
        net.refuse(reason, format!("turns of at least {MIN_RADIUS_M} m radius"))
    })?;
    let depart_m = (length_m + BEHIND_M).min(0.5 * whole.length_m());
    let end_m = (whole.length_m() - BEFORE_END_M).max(depart_m + BEHIND_M);
    let (pieces, start) = cut(&smooth.pieces, &whole, depart_m, end_m);
    let start = start.placed(&smooth.start);
    let place = |way_m: f64| smooth.place_m(way_m) - depart_m;
    let gives_way = |way_m: &f64| {
        let junction = format!("at {:.0} m a junction without lights", place(*way_m));
        format!("the ego does not give way: {junction} gives others the right of way")
    };
    let notes = path.yields_m.iter().take(4).map(gives_way).collect();
    let placed = |light: Light| Light { stop_line_m: place(light.stop_line_m), ..light };
    let mut lights: Vec<Light> = path.lights.into_iter().map(placed).collect();
    lights.retain(|light| light.stop_line_m > 0.0 && light.stop_line_m <= end_m - depart_m);
    lights.dedup_by(|light, last| last.stop_line_m + APART_M > light.stop_line_m);
    let limit = |of: &path::Stretch| Limit { from_m: place(of.from_m), speed_mps: of.speed_mps };
    let limits: Vec<Limit> = path.stretches.iter().map(limit).collect();
    let axis = Axis::narrow(&pieces, MIN_RADIUS_M).expect("a part of an axis is one");
    Ok(Route {
        edges,
        lane: path.first_lane,
        depart_m,
        lines: lane_lines(&axis, &path.stretches, place),
        pieces,
        start,
        limits: with_curves(&axis, &limits),
        lights,
        notes,
    })
}

/// The pieces between two places of a chain, and the pose at the first one.
fn cut(pieces: &[Piece], axis: &Axis, from_m: f64, to_m: f64) -> (Vec<Piece>, Pose) {
    let (mut kept, mut passed_m) = (Vec::new(), 0.0);
    for piece in pieces {
        let end_m = passed_m + piece.length_m();
        let length_m = end_m.min(to_m) - passed_m.max(from_m);
        if length_m > 1e-9 {
            kept.push(match *piece {
                Piece::Arc { curvature_perm, .. } => Piece::Arc { length_m, curvature_perm },
                _ => Piece::Line { length_m },
            });
        }
        passed_m = end_m;
    }
    (kept, axis.pose(from_m))
}

/// The limits, lowered where a curve is passed slower. The map of curves has cells of 25 m, and turns inside of junctions
/// are shorter.
fn with_curves(axis: &Axis, limits: &[Limit]) -> Vec<Limit> {
    let cells = libm::ceil(axis.length_m() / CELL_M) as u32;
    let of_cell = |cell: u32| {
        let from_m = f64::from(cell) * CELL_M;
        let legal = |limit: &&Limit| limit.from_m < from_m + CELL_M;
        let last = limits.iter().take_while(legal).last();
        let begun = limits.iter().take_while(|limit| limit.from_m <= from_m).last();
        let legal_mps = [last, begun].into_iter().flatten().map(|limit| limit.speed_mps);
        let legal_mps = legal_mps.fold(f64::INFINITY, f64::min);
        let samples =
            (0..CELL_SAMPLES).map(|k| from_m + CELL_M * f64::from(k) / f64::from(CELL_SAMPLES));
        let sharpest = samples.map(|p_m| axis.curvature_perm(p_m).abs()).fold(0.0, f64::max);
        let curve_mps = (LATERAL_MPS2 / sharpest.max(1e-9)).sqrt();
        let speed_mps =
            if curve_mps < legal_mps { (10.0 * curve_mps).floor() / 10.0 } else { legal_mps };
        Limit { from_m, speed_mps }
    };
    let mut all: Vec<Limit> = (0..cells).map(of_cell).collect();
    all.dedup_by_key(|limit| limit.speed_mps);
    all
}

/// Lines of the lanes along an axis. In a narrow turn they stay on this side of its centre.
fn lane_lines(axis: &Axis, stretches: &[path::Stretch], place: impl Fn(f64) -> f64) -> LaneLines {
    let mut stations: Vec<Vec<f64>> = Vec::new();
    for stretch in stretches {
        for (way_m, lines) in [stretch.from_m, stretch.to_m].into_iter().zip(&stretch.lines) {
            let last_m = stations.last().map_or(f64::NEG_INFINITY, |station| station[0]);
            let p_m = place(way_m).min(axis.length_m()).max(last_m);
            let curvature_perm = axis.curvature_perm(p_m);
            let inner_m = INNER_SHARE / curvature_perm.abs().max(1e-9);
            let within = |line_m: &f64| match line_m * curvature_perm > 0.0 {
                true => line_m.clamp(-inner_m, inner_m),
                false => *line_m,
            };
            let mut station = vec![p_m];
            station.extend(lines.iter().map(within));
            stations.push(station);
        }
    }
    LaneLines::new(stations)
}
