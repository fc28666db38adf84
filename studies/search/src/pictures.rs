//! Pictures of a search: all runs at once, the best so far, and the two variables that matter most. The failing drives
//! stand beside the reference's.

use report::chart::{self, Axis, Chart, Curve, Edges, Mark, Plot, Stroke, Tone};
use supervise::DriveStep;

use crate::distinct::effects;
use crate::problem::{Domain, Problem, Variable};
use crate::record::Record;
use crate::reference::Sample;

/// Most runs in the picture of all runs: the failures, then the least values.
const MOST_LINES: usize = 300;
/// Most of them that are not near a failure: more would hide the others.
const MOST_OTHERS: usize = 40;
/// Largest value that the picture of values shows, tolerances: twice the median, within these bounds.
const MOST_SHOWN: (f64, f64) = (2.0, 20.0);
/// Room beyond the ends of a variable, as a share of its range: a point at an end is whole.
const ROOM: f64 = 0.02;
/// A value below this is near a failure, tolerances.
const NEAR: f64 = 2.0;
/// Kinds of runs: legend and colour.
const KINDS: [(&str, Tone); 3] =
    [("failure", Tone::Alarm), ("within 2 tolerances", Tone::Series(1)), ("others", Tone::Muted)];

/// A failing drive and the reference's in the same scene.
#[derive(Clone, Debug, Default)]
pub struct Drives {
    /// Samples of the failing drive.
    pub own: Vec<Sample>,
    /// Speed of the vehicle ahead of it, m/s, over time.
    pub lead_mps: Vec<(f64, f64)>,
    /// Samples of the reference; empty without one.
    pub reference: Vec<Sample>,
    /// Instant that decides the broken requirement, s.
    pub decided_s: Option<f64>,
}

impl Drives {
    pub fn new(steps: &[DriveStep], reference: Vec<Sample>, decided_s: Option<f64>) -> Self {
        let sample = |step: &DriveStep| Sample {
            time_s: step.time_s,
            speed_mps: step.speed_mps,
            gap_m: step.gap_m,
        };
        let lead = steps.iter().map(|step| (step.time_s, step.lead_speed_mps));
        let lead_mps = lead.filter_map(|(time_s, speed)| Some((time_s, speed?))).collect();
        Self { own: steps.iter().map(sample).collect(), lead_mps, reference, decided_s }
    }
}

/// The pictures of all runs; none without a run.
pub fn of_runs(problem: &Problem, records: &[(usize, Record)]) -> Vec<Chart> {
    if records.is_empty() {
        return Vec::new();
    }
    let both = [parallel(problem, records), best_so_far(records)];
    both.into_iter().chain(scatter(problem, records)).collect()
}

/// Kinds with what belongs to each.
fn sorted<T>(
    kinds: [(&'static str, Tone); 3],
    all: impl Iterator<Item = (usize, T)>,
) -> [(&'static str, Tone, Vec<T>); 3] {
    let mut sorted = kinds.map(|(name, tone)| (name, tone, Vec::new()));
    all.for_each(|(kind, one)| sorted[kind].2.push(one));
    sorted
}

fn kind(value: f64) -> usize {
    match value {
        value if value < 0.0 => 0,
        value if value < NEAR => 1,
        _ => 2,
    }
}

/// Each run as a line through its values, one row a variable.
fn parallel(problem: &Problem, records: &[(usize, Record)]) -> Chart {
    let mut order: Vec<&Record> = records.iter().map(|(_, record)| record).collect();
    order.sort_by(|a, b| a.value().total_cmp(&b.value()));
    let near = order.partition_point(|record| record.value() < NEAR);
    order.truncate(MOST_LINES.min(near + MOST_OTHERS));
    let lines = order.iter().map(|record| (kind(record.value()), record.driven.point.as_slice()));
    let row = |variable: &Variable| format!("{}: {}", variable.name, variable.domain);
    let rows: Vec<String> = problem.variables.iter().map(row).collect();
    let title = format!("The {} runs with the least values", order.len());
    chart::parallel(&title, &rows, &sorted(KINDS, lines))
}

/// The value of each run, and the least one so far.
fn best_so_far(records: &[(usize, Record)]) -> Chart {
    let mut values: Vec<f64> = records.iter().map(|(_, record)| record.value()).collect();
    values.sort_by(f64::total_cmp);
    let most = (2.0 * values[values.len() / 2]).clamp(MOST_SHOWN.0, MOST_SHOWN.1).ceil();
    let place = |(run, record): &(usize, Record)| ((run + 1) as f64, record.value().min(most));
    let last = records.last().map_or(1.0, |(run, _)| (run + 1) as f64);
    let worst = values[0].min(0.0);
    let x = Axis::linear("run", 0.0, last + 1.0);
    let room = 2.0 * ROOM * (most - worst.floor());
    let y = Axis::linear("value, tolerances", worst.floor() - room, most + room);
    let dots = records.iter().map(|one| {
        let kind = match &one.1 {
            record if record.is_failure() => 0,
            record if record.driven.is_even => 2,
            _ => 1,
        };
        (kind, place(one))
    });
    let mut least: Vec<[(f64, f64); 2]> = Vec::new();
    let mut from = records.first().map(place);
    for (run, value) in records.iter().map(place) {
        let Some(at) = from.filter(|(_, best)| value < *best) else { continue };
        least.extend([[at, (run, at.1)], [(run, at.1), (run, value)]]);
        from = Some((run, value));
    }
    least.extend(from.map(|at| [at, (last, at.1)]));
    let edges =
        |label: &str, tone, stroke, pieces| Edges { label: label.to_owned(), tone, stroke, pieces };
    let kinds = [
        ("failure", Tone::Alarm),
        ("point of the process", Tone::Series(2)),
        ("even point", Tone::Muted),
    ];
    let edges = [
        edges("least value so far", Tone::Series(0), Stroke::Solid, least),
        edges("limit", Tone::Stop, Stroke::Dashed, vec![[(0.0, 0.0), (last + 1.0, 0.0)]]),
    ];
    let title = format!("Value by run (a larger value than {most} is drawn there)");
    chart::scatter(&title, (&x, &y), &sorted(kinds, dots), &edges)
}

/// The runs over the two variables that matter most; none with fewer than two numbers.
fn scatter(problem: &Problem, records: &[(usize, Record)]) -> Option<Chart> {
    let effects = effects(&problem.variables, records);
    let is_number = |place: &usize| !problem.variables[*place].domain.is_of_words();
    let mut places: Vec<usize> = (0..effects.len()).filter(is_number).collect();
    places.sort_by(|a, b| effects[*b].unwrap_or(0.0).total_cmp(&effects[*a].unwrap_or(0.0)));
    let [across, up, ..] = places[..] else { return None };
    let (x, y) = (&problem.variables[across], &problem.variables[up]);
    let dots = records.iter().map(|(_, record)| {
        let point = &record.driven.point;
        (kind(record.value()), (x.domain.drawn_at(point[across]), y.domain.drawn_at(point[up])))
    });
    let title = format!("{} over {}", y.name, x.name);
    Some(chart::scatter(&title, (&axis(x), &axis(y)), &sorted(KINDS, dots), &[]))
}

fn axis(variable: &Variable) -> Axis {
    let (low, high) = (variable.domain.drawn_at(-ROOM), variable.domain.drawn_at(1.0 + ROOM));
    match &variable.domain {
        Domain::Range { is_log: true, .. } => {
            Axis { label: variable.name.clone(), ..Axis::frequencies("", low, high) }
        }
        _ => Axis::linear(&variable.name, low, high),
    }
}

/// A failing drive beside the reference's, with the instant that decides its requirement.
pub fn of_drives(file: &str, requirement: &str, drives: &Drives) -> [Chart; 2] {
    let end_s = drives.own.last().map_or(1.0, |sample| sample.time_s);
    let end_s = drives.reference.last().map_or(end_s, |sample| sample.time_s.max(end_s));
    let speed = |samples: &[Sample]| samples.iter().map(|s| (s.time_s, s.speed_mps)).collect();
    let gap = |samples: &[Sample]| {
        samples.iter().filter_map(|s| Some((s.time_s, s.gap_m?))).collect::<Vec<_>>()
    };
    let speeds = vec![
        Curve::new("ego", Tone::Series(0), speed(&drives.own)),
        Curve::new("reference", Tone::Series(2), speed(&drives.reference)),
        Curve::new("vehicle ahead of the ego", Tone::Muted, drives.lead_mps.clone())
            .stroke(Stroke::Dashed),
    ];
    let gaps = vec![
        Curve::new("ego", Tone::Series(0), gap(&drives.own)),
        Curve::new("reference", Tone::Series(2), gap(&drives.reference)),
    ];
    let title = |what: &str| match drives.decided_s {
        Some(_) => format!("{file}: {what} (A: {requirement} is broken)"),
        None => format!("{file}: {what}"),
    };
    let mark = |x| Mark { x, label: "A".to_owned(), tone: Tone::Alarm };
    let marks: Vec<Mark> = drives.decided_s.into_iter().map(mark).collect();
    let plots = [("speed", "m/s", speeds), ("gap", "m", gaps)];
    plots.map(|(what, unit, curves)| {
        Chart::from(&Plot::over_time(&title(what), end_s, unit, curves).marked(&marks))
    })
}
