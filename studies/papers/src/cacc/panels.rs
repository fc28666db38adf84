//! One panel a scenario, as in the paper: ACC and CACC over each other, printed values marked.

use super::figures::{LINE_A_M, LINE_C_M, LINE_T3_M, SWITCH_ABC_S, SWITCH_T3_S};
use super::trajectory::{Runs, Trajectory};
use crate::Gallery;
use report::chart::{Curve, Plot, Point, Strip, Stroke, Tone};

/// Length of the plots of A, B and C, s.
const UNTIL_ABC_S: f64 = 10.0;
/// Length of the plots of Table 3, s.
const UNTIL_T3_S: f64 = 15.0;
const CACC: Tone = Tone::Series(0);
const ACC: Tone = Tone::Series(1);

/// Both laws in one scenario.
#[derive(Clone, Copy)]
struct Pair<'a> {
    acc: Trajectory<'a>,
    cacc: Trajectory<'a>,
    until_s: f64,
}

/// The panels of the scenarios that were run.
pub fn panels(runs: &Runs<'_>) -> Vec<Gallery> {
    let pair = |acc: Option<_>, cacc: Option<_>, until_s| {
        acc.zip(cacc).map(|(acc, cacc)| Pair { acc, cacc, until_s })
    };
    [
        pair(runs.a_acc, runs.a_cacc, UNTIL_ABC_S).map(scenario_a),
        pair(runs.b_acc, runs.b_cacc, UNTIL_ABC_S).map(scenario_b),
        pair(runs.c_acc, runs.c_cacc, UNTIL_ABC_S).map(scenario_c),
        pair(runs.t3_acc, runs.t3_cacc, UNTIL_T3_S).map(table_3),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn scenario_a(pair: Pair<'_>) -> Gallery {
    let (most, least) = extremes(&pair.cacc, pair.cacc.speed_error_mps);
    let (deepest, _) = extremes(&pair.cacc, pair.cacc.gap_error_m);
    let [position, gap, speed, acceleration, request] = pair.of_figures_6_to_8(
        (LINE_A_M, Tone::Go),
        [
            point(4.0, LINE_A_M, "CACC crosses at 4.0 s"),
            point(4.5, LINE_A_M, "ACC crosses at 4.5 s"),
            point(SWITCH_ABC_S, LINE_A_M + 19.3, "CACC 19.3 m beyond"),
            point(SWITCH_ABC_S, LINE_A_M + 9.4, "ACC 9.4 m beyond"),
        ],
    );
    gallery(
        "Scenario A (figure 6)",
        vec![
            position,
            gap.with_points(vec![point(deepest, 10.0, "CACC 10 m")]),
            speed.with_points(vec![
                point(most, 9.3, "CACC 9.3 m/s"),
                point(least, -4.5, "CACC −4.5 m/s"),
            ]),
            acceleration,
            request.with_points(vec![
                point(2.0, 4.9, "CACC saturated to 2 s"),
                point(3.0, 0.0, "brakes from 3 s"),
                point(6.0, 0.0, "to 6 s"),
            ]),
        ],
    )
}

fn scenario_b(pair: Pair<'_>) -> Gallery {
    gallery(
        "Scenario B (figure 7; no value of it is printed but 0.7 s between two runs)",
        pair.of_figures_6_to_8((LINE_A_M, Tone::Go), []).into(),
    )
}

fn scenario_c(pair: Pair<'_>) -> Gallery {
    let [position, gap, speed, acceleration, request] = pair.of_figures_6_to_8(
        (LINE_C_M, Tone::Stop),
        [
            point(SWITCH_ABC_S, LINE_C_M - 53.0, "CACC 53 m before"),
            point(SWITCH_ABC_S, LINE_C_M - 47.0, "ACC 47 m before"),
        ],
    );
    let request = request.with_points(vec![
        point(0.4, 4.9, "ACC saturated to 0.4 s"),
        point(2.0, -4.9, "ACC saturated to 2 s"),
    ]);
    gallery("Scenario C (figure 8)", vec![position, gap, speed, acceleration, request])
}

fn table_3(pair: Pair<'_>) -> Gallery {
    let lead_mps = pair.acc.speed_mps.iter().zip(pair.acc.speed_error_mps).map(|(v, ed)| v - ed);
    let lead = pair.acc.time_s.iter().copied().zip(lead_mps).collect();
    let mut speed = pair.plot("Speed", "m/s", |run| run.speed_mps);
    speed.curves.push(Curve::new("lead", Tone::Muted, lead));
    let to_line = |run: &Trajectory<'_>| {
        let left = run.position_m.iter().map(|position| LINE_T3_M - position);
        run.time_s.iter().copied().zip(left).collect::<Vec<_>>()
    };
    let curves = pair.curves(to_line);
    let mut to_line = Plot::over_time("Distance to the stop line", pair.until_s, "m", curves);
    to_line.strips.push(strip(0.0, SWITCH_T3_S, pair.until_s, Tone::Go));
    gallery(
        "Table 3 (figure 10)",
        vec![
            speed.with_points(vec![point(7.0, 30.0 / 3.6, "ACC 30 km/h by 7 s")]),
            pair.plot("Acceleration", "m/s²", |run| run.acceleration_mps2),
            pair.plot("Gap", "m", |run| run.gap_m),
            to_line.with_points(vec![
                point(7.9, 0.0, "CACC crosses at 7.9 s"),
                point(8.45, 0.0, "ACC crosses at 8.45 s"),
                point(SWITCH_T3_S, -16.2, "CACC 16.2 m beyond"),
                point(SWITCH_T3_S, -12.9, "ACC 12.9 m beyond"),
            ]),
        ],
    )
}

impl Pair<'_> {
    /// The five plots of figures 6 to 8; the signal has `line` as its stop line and first phase.
    fn of_figures_6_to_8<const N: usize>(
        &self,
        line: (f64, Tone),
        points: [Point; N],
    ) -> [Plot; 5] {
        let mut position = self.plot("Position", "m", |run| run.position_m);
        position.strips.push(strip(line.0, SWITCH_ABC_S, self.until_s, line.1));
        [
            position.with_points(points.into()),
            self.plot("Spacing error", "m", |run| run.gap_error_m),
            self.plot("Speed error", "m/s", |run| run.speed_error_mps),
            self.plot("Acceleration", "m/s²", |run| run.acceleration_mps2),
            self.plot("Requested acceleration", "m/s²", |run| run.request_mps2),
        ]
    }

    fn plot(
        &self,
        title: &str,
        unit: &str,
        values: for<'a> fn(&Trajectory<'a>) -> &'a [f64],
    ) -> Plot {
        let curves = self
            .curves(|run| run.time_s.iter().copied().zip(values(run).iter().copied()).collect());
        Plot::over_time(title, self.until_s, unit, curves)
    }

    fn curves(&self, points: impl Fn(&Trajectory<'_>) -> Vec<(f64, f64)>) -> Vec<Curve> {
        vec![
            Curve::new("CACC", CACC, points(&self.cacc)),
            Curve::new("ACC", ACC, points(&self.acc)).stroke(Stroke::Dashed),
        ]
    }
}

fn gallery(scenario: &str, plots: Vec<Plot>) -> Gallery {
    let heading = format!("{scenario}: rings are printed values; one set of weights");
    Gallery { heading, plots }
}

fn point(x: f64, y: f64, label: &str) -> Point {
    Point { x, y, label: label.into() }
}

/// A signal at its stop line that switches once.
fn strip(y: f64, switch_s: f64, until_s: f64, first: Tone) -> Strip {
    let then = if first == Tone::Go { Tone::Stop } else { Tone::Go };
    let spans = vec![(0.0, switch_s, first), (switch_s, until_s, then)];
    Strip { y, label: "stop line".into(), spans }
}

/// Times of the largest and the smallest value, s.
fn extremes(run: &Trajectory<'_>, values: &[f64]) -> (f64, f64) {
    let cycles = || run.time_s.iter().copied().zip(values.iter().copied());
    let most = cycles().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |cycle| cycle.0);
    let least = cycles().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |cycle| cycle.0);
    (most, least)
}
