//! The bird's-eye view of a drive on a road with a plan, as data that the page's script draws (`assets/plane.js`).
//!
//! It shows the lanes, the way of the ego coloured by its speed, and the bodies at an instant. It marks the spans with
//! a lost lead or a false target. The first instant is the worst one. It is the collision, else the least time to
//! collision, else the least gap.

use crate::chart::{escape, script_json};
use crate::html::{Column, table};
use crate::targets::{JudgedScan, Owner, judge, spans};
use scenario::Scenario;
use scenario::plan::{Plan, offset_at};
use serde::Serialize;
use supervise::{Drive, DriveStep, PlaneScene};

const MOST_PLACES: usize = 1_200;
/// Most instants of the close-up.
const MOST_INSTANTS: usize = 300;
/// Road behind the start and beyond the end of the drive, m.
const AROUND_M: (f64, f64) = (60.0, 160.0);
/// Least range of the speed's colours, m/s.
const LEAST_RANGE_MPS: f64 = 2.0;
const MOST_FINDINGS: usize = 12;

/// The bird's-eye view of a drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlaneView {
    road: RoadView,
    way: Way,
    /// Speeds of the first and the last colour, m/s.
    low: f64,
    high: f64,
    findings: Vec<Finding>,
    ego: Size,
    frames: Vec<Frame>,
    /// Index of the worst instant.
    worst: usize,
    /// Reason why it is the worst.
    why: &'static str,
}

/// The way of the ego's front bumper, m, with its speed, m/s.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
struct Way {
    x: Vec<f64>,
    y: Vec<f64>,
    speed: Vec<f64>,
}

/// A kind of finding with its spans on the way.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Finding {
    name: &'static str,
    tone: &'static str,
    /// Indices of the first and the last place on the way.
    spans: Vec<(usize, usize)>,
    /// Begin and end of each, s.
    #[serde(skip)]
    times_s: Vec<(f64, f64)>,
}

/// Length and width, m.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct Size {
    length: f64,
    width: f64,
}

/// The bodies at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
struct Frame {
    /// Place and heading of the ego.
    ego: (f64, f64, f64),
    /// Middle, heading, length, width, and 1 in the ego's lane.
    bodies: Vec<(f64, f64, f64, f64, f64, u8)>,
    /// Place and colour of the target.
    target: Option<(f64, f64, &'static str)>,
    text: String,
}

/// Kinds of findings: name, colour, and whether a scan has it.
type Kind = (&'static str, &'static str, fn(&JudgedScan) -> bool);
const KINDS: [Kind; 3] = [
    ("lead lost", "stop", JudgedScan::is_lead_lost),
    ("neighbour taken", "clear", JudgedScan::is_neighbour_taken),
    ("target without a vehicle", "t3", JudgedScan::is_nothing_taken),
];

impl PlaneView {
    /// The view of a drive; none where the road has no plan or nothing was seen.
    pub fn of(scenario: &Scenario, drive: &Drive) -> Option<Self> {
        let plan = scenario.road.plan()?;
        let axis = plan.axis();
        let (first, last) = (drive.steps.first()?, drive.steps.last()?);
        drive.plane.first()?;
        let from_to_m = (first.position_m - AROUND_M.0, last.position_m + AROUND_M.1);
        let scans = judge(drive, &|p_m| axis.curvature_perm(p_m));
        let steps = steps_at(drive);
        let stride = drive.plane.len().div_ceil(MOST_PLACES).max(1);
        let places: Vec<usize> = (0..drive.plane.len()).step_by(stride).collect();
        let way = Way {
            x: places.iter().map(|&at| rounded(drive.plane[at].ego.x_m)).collect(),
            y: places.iter().map(|&at| rounded(drive.plane[at].ego.y_m)).collect(),
            speed: places.iter().map(|&at| rounded(steps[at].speed_mps)).collect(),
        };
        let speeds = || way.speed.iter().copied();
        let low = speeds().fold(f64::INFINITY, f64::min).floor();
        let high = speeds().fold(f64::NEG_INFINITY, f64::max).ceil().max(low + LEAST_RANGE_MPS);
        let findings = KINDS.map(|(name, tone, has)| {
            let times_s = spans(&scans, has);
            let at = |time_s: f64| {
                let index = drive.plane.partition_point(|scene| scene.time_s < time_s);
                (index / stride).min(places.len() - 1)
            };
            let spans = times_s.iter().map(|(from_s, to_s)| (at(*from_s), at(*to_s))).collect();
            Finding { name, tone, spans, times_s }
        });
        let findings = findings.into_iter().filter(|finding| !finding.spans.is_empty()).collect();
        let (worst, why) = worst(&steps, drive);
        let mut instants: Vec<usize> =
            (0..drive.plane.len()).step_by(drive.plane.len().div_ceil(MOST_INSTANTS)).collect();
        if let Err(place) = instants.binary_search(&worst) {
            instants.insert(place, worst);
        }
        let frames = instants.iter().map(|&at| {
            let scene = &drive.plane[at];
            let scan = scans.binary_search_by(|scan| scan.time_s.total_cmp(&scene.time_s));
            Frame::of(scene, &steps[at], scan.ok().map(|scan| &scans[scan]))
        });
        Some(Self {
            road: RoadView::of(plan, from_to_m),
            way,
            low,
            high,
            findings,
            ego: Size::of_ego(scenario),
            frames: frames.collect(),
            worst: instants.binary_search(&worst).unwrap_or(0),
            why,
        })
    }

    /// The figure, and below it a table of the findings.
    pub fn html(&self) -> String {
        let title = "The way from above";
        let figure = format!(
            "<figure class=\"card plane\">\n<figcaption><h3>{title}</h3></figcaption>\n\
             <div class=\"plot\"></div>\n<script type=\"application/json\">{}</script>\n</figure>\n",
            script_json(self),
        );
        figure + &self.findings()
    }

    fn findings(&self) -> String {
        let spans = self.findings.iter().flat_map(|finding| {
            finding.times_s.iter().map(|(from_s, to_s)| (*from_s, *to_s, finding.name.to_owned()))
        });
        let mut all: Vec<(f64, f64, String)> = spans.collect();
        if all.is_empty() {
            return "<p>The target was the vehicle ahead whenever one was within 100 m.</p>\n"
                .into();
        }
        // The kinds keep their order where they have the same span.
        all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        all.dedup_by(|later, kept| {
            let same = (later.0, later.1) == (kept.0, kept.1);
            if same {
                kept.2 += &format!(", {}", later.2);
            }
            same
        });
        let more = all.len().saturating_sub(MOST_FINDINGS);
        let rows: Vec<_> = (all.iter().take(MOST_FINDINGS))
            .map(|(from_s, to_s, name)| {
                vec![format!("{from_s:.2}"), format!("{:.2}", to_s - from_s), name.clone()]
            })
            .collect();
        let head = [
            ("at, s", Column::Number),
            ("for, s", Column::Number),
            ("lost and false targets, by ground truth", Column::Text),
        ];
        let rest = match more {
            0 => String::new(),
            more => format!("<p class=\"quiet\">{} more</p>\n", escape(&more.to_string())),
        };
        table(&head, &rows) + &rest
    }
}

impl Size {
    fn of_ego(scenario: &Scenario) -> Self {
        Self { length: scenario.plant.length_m.value(), width: scenario::event::VEHICLE_WIDTH_M }
    }
}

impl Frame {
    fn of(scene: &PlaneScene, step: &DriveStep, scan: Option<&JudgedScan>) -> Self {
        let (tone, whose) = match scan {
            Some(scan) if scan.is_neighbour_taken() => ("clear", "a neighbour is the target"),
            Some(scan) if scan.is_nothing_taken() => ("t3", "the target is not a vehicle"),
            Some(scan) if scan.is_lead_lost() => ("stop", "the lead is lost"),
            Some(JudgedScan { owner: Some(Owner::Vehicle(_)), .. }) => {
                ("go", "the vehicle ahead is the target")
            }
            _ => ("muted", "no target"),
        };
        let lead = scan.and_then(|scan| scan.lead);
        let gap = lead.map_or_else(String::new, |lead| format!(" · gap {:.1} m", lead.gap_m));
        let text = format!("{:.2} s · {:.1} m/s{gap} · {whose}", scene.time_s, step.speed_mps);
        Self::with(scene, tone, text)
    }

    fn with(scene: &PlaneScene, tone: &'static str, text: String) -> Self {
        let bodies = scene.bodies.iter().map(|body| {
            let place = (rounded(body.x_m), rounded(body.y_m));
            let heading = fine(body.heading_rad);
            let size = (rounded(body.length_m), rounded(body.width_m));
            (place.0, place.1, heading, size.0, size.1, u8::from(body.in_lane))
        });
        let target = scene.seen.and_then(|seen| seen.target);
        Self {
            ego: (rounded(scene.ego.x_m), rounded(scene.ego.y_m), fine(scene.ego.heading_rad)),
            bodies: bodies.collect(),
            target: target.map(|target| (rounded(target.x_m), rounded(target.y_m), tone)),
            text,
        }
    }
}

/// The step at the time of each scene.
fn steps_at(drive: &Drive) -> Vec<DriveStep> {
    let mut steps = drive.steps.iter().peekable();
    let mut last = drive.steps.first().copied().unwrap_or_default();
    let at = |scene: &PlaneScene| {
        while let Some(step) = steps.next_if(|step| step.time_s <= scene.time_s + 1e-9) {
            last = *step;
        }
        last
    };
    drive.plane.iter().map(at).collect()
}

/// Index of the worst scene, and why it is the worst.
fn worst(steps: &[DriveStep], drive: &Drive) -> (usize, &'static str) {
    let least = |value: &dyn Fn(&DriveStep) -> Option<f64>| {
        let values = steps.iter().enumerate().filter_map(|(at, step)| Some((at, value(step)?)));
        let finite = values.filter(|(_, value)| value.is_finite());
        finite.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(at, _)| at)
    };
    let contact = drive.steps.iter().any(|step| step.gap_m.is_some_and(|gap_m| gap_m <= 0.0));
    if contact {
        return (steps.len() - 1, "the contact");
    }
    let collision = |step: &DriveStep| Some(step.time_to_collision_s).filter(|s| *s > 0.0);
    (least(&collision).map(|at| (at, "the least time to collision")))
        .or(least(&|step| step.gap_m).map(|at| (at, "the least gap")))
        .unwrap_or((0, "the start"))
}

/// Largest distance of a line from its chords, m: less than a pixel of the close-up.
const SAGITTA_M: f64 = 0.03;
/// Shortest and longest chord, m.
const CHORD_M: (f64, f64) = (2.0, 60.0);

/// The lanes as lines in the plane.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RoadView {
    left: Line,
    right: Line,
    /// Lines between lanes.
    lines: Vec<Line>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
struct Line {
    x: Vec<f64>,
    y: Vec<f64>,
}

impl RoadView {
    /// The lanes between two positions, m.
    pub fn of(plan: &Plan, from_to_m: (f64, f64)) -> Self {
        let (axis, start, lanes) = (plan.axis(), plan.start.pose(), &plan.lanes);
        let between = lanes.lines(from_to_m.0, from_to_m.1);
        let mut places_m = places(&|p_m| axis.curvature_perm(p_m), from_to_m);
        places_m.extend(between.iter().flatten().map(|point| point[0]));
        places_m.retain(|p_m| (from_to_m.0..=from_to_m.1).contains(p_m));
        places_m.sort_by(f64::total_cmp);
        places_m.dedup();
        let line = |offset_m: &dyn Fn(f64) -> f64, places_m: &mut dyn Iterator<Item = f64>| {
            let mut line = Line::default();
            for p_m in places_m {
                let pose = axis.point(p_m, offset_m(p_m)).placed(&start);
                line.x.push(rounded(pose.x_m));
                line.y.push(rounded(pose.y_m));
            }
            line
        };
        let all = || places_m.iter().copied();
        let edge = |side: usize| line(&|p_m| lanes.edges_m(p_m)[side], &mut all());
        // The first and the last line of a stretch are edges.
        let inner = between.iter().enumerate().filter(|(index, own)| {
            let is_neighbour =
                |other: Option<&Vec<[f64; 2]>>| other.is_some_and(|other| other[0][0] == own[0][0]);
            let before = index.checked_sub(1).and_then(|before| between.get(before));
            is_neighbour(before) && is_neighbour(between.get(index + 1))
        });
        let lines = inner.map(|(_, points)| {
            let (first_m, last_m) = (points[0][0], points[points.len() - 1][0]);
            let mut own = all().filter(|p_m| (first_m..=last_m).contains(p_m));
            line(&|p_m| offset_at(points, p_m), &mut own)
        });
        Self { left: edge(1), right: edge(0), lines: lines.collect() }
    }
}

/// Positions whose chords are near the axis: close together in curves, far apart on straights.
fn places(curvature: &dyn Fn(f64) -> f64, (from_m, to_m): (f64, f64)) -> Vec<f64> {
    let mut places = vec![from_m];
    let mut at_m = from_m;
    while at_m < to_m {
        let mut chord_m = CHORD_M.1;
        while chord_m > CHORD_M.0 {
            let bends =
                [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| curvature(at_m + share * chord_m).abs());
            let most_perm = bends.into_iter().fold(0.0, f64::max);
            if most_perm * chord_m * chord_m <= 8.0 * SAGITTA_M {
                break;
            }
            chord_m *= 0.8;
        }
        at_m = (at_m + chord_m.max(CHORD_M.0)).min(to_m);
        places.push(at_m);
    }
    places
}

/// To a centimetre, as a screen shows it.
pub fn rounded(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}

/// To a tenth of a milliradian.
pub fn fine(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

#[cfg(test)]
mod road_tests {
    use super::*;

    #[test]
    fn chords_are_short_in_curves_alone() {
        let places_m = places(&|p_m| if p_m < 500.0 { 0.0 } else { 0.01 }, (0.0, 1_000.0));
        assert_eq!((places_m[0], places_m.last()), (0.0, Some(&1_000.0)));
        for pair in places_m.windows(2) {
            let chord_m = pair[1] - pair[0];
            assert!(chord_m <= CHORD_M.1);
            assert!(pair[1] <= 500.0 || 0.01 * chord_m.powi(2) <= 8.0 * SAGITTA_M + 1e-9);
        }
        assert!((100..200).contains(&places_m.len()), "{}", places_m.len());
    }
}
