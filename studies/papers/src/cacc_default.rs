//! The paper's four scenes under the laws as they come: `cacc-mpc` for the road beside its blind baseline.
//!
//! The paper's figures belong to its own formulation. These rows hold the road's formulation to the paper's purpose. It
//! passes the light sooner than the blind law, and farther from the switch.

use super::row::{Kind, Row, requirement, within};
use super::runner::{Driven, Part, Piece, Runner};
use group::{DriveStep, Error};

/// Set of all rows.
const SET: &str = "default law";
/// Takes the scenes' own spacing, which is the paper's, back to the default.
const SPACING: [&str; 2] =
    ["controller.spacing_policy=constant-time-headway", "controller.standstill_distance_m=5"];
/// Long enough that every drive passes the line.
const DURATION: &str = "duration_s=20";

/// A scene: name in the rows, scenario, stop line, m, time of the switch, s, and whether it turns green then.
type Scene = (&'static str, &'static str, f64, f64, bool);

const SCENES: [Scene; 4] = [
    ("A", "cacc-a", 80.0, 5.0, false),
    ("B", "cacc-b", 80.0, 5.0, false),
    ("C", "cacc-c", 100.0, 5.0, true),
    ("T3", "cacc-table3", 58.0, 10.0, false),
];

/// A piece for each scene.
pub fn pieces() -> Vec<Piece> {
    let piece = |scene: Scene| {
        Piece::new(format!("{SET}, {}", scene.0), move |runner| {
            let rows = of_scene(runner, scene)?;
            Ok(Part::of_rows(rows.map(|row| row.in_set(SET)).into()))
        })
    };
    SCENES.map(piece).into()
}

/// Drives a scene with both laws and compares.
fn of_scene(runner: &Runner<'_>, scene: Scene) -> Result<[Row; 6], Error> {
    let (name, scenario, line_m, switch_s, opens) = scene;
    let drive = |law: &str| {
        let law = format!("controller.name={law}");
        let keys = [law.as_str(), DURATION].into_iter().chain(SPACING).collect::<Vec<_>>();
        runner.drive(scenario, &keys)
    };
    let (acc, cacc) = (drive("acc-mpc")?, drive("cacc-mpc")?);
    let crossings = [&acc, &cacc].map(|driven| crossing_s(driven, line_m));
    let margins = [&acc, &cacc].map(|driven| {
        let past_m = position_m(driven, switch_s)? - line_m;
        Some(if opens { -past_m } else { past_m })
    });
    let id = |figure: &str| format!("{name}.default.{figure}");
    let shown = |figure: &str, unit, ours, note| {
        Row::shown(&id(figure), unit, Kind::Requirement, ours, note)
    };
    let away = "distance from the line at the switch, on the right side of it";
    let later = crossings[1].zip(crossings[0]).map(|(cacc, acc)| cacc - acc);
    let nearer = margins[0].zip(margins[1]).map(|(acc, cacc)| acc - cacc);
    Ok([
        shown("acc_cross_s", "s", crossings[0], "the blind baseline"),
        shown("cacc_cross_s", "s", crossings[1], "the law for the road"),
        Row::at_most(
            &id("cacc_cross_minus_acc_s"),
            "s",
            requirement(0.0),
            later,
            within(0.05, "half a control period"),
        )
        .with_note(
            "the light makes the law no slower; the paper prints -0.5 s in A, -0.55 s in Table 3",
        ),
        shown("acc_margin_m", "m", margins[0], away),
        shown("cacc_margin_m", "m", margins[1], away),
        Row::at_most(
            &id("acc_margin_minus_cacc_m"),
            "m",
            requirement(0.0),
            nearer,
            within(0.5, "half a control period of motion"),
        )
        .with_note(
            "the switch is kept away from; the paper prints 9.9 m in A, 6 m in C, 3.3 m in Table 3",
        ),
    ])
}

fn between(pair: &[DriveStep], share: f64, of: impl Fn(&DriveStep) -> f64) -> f64 {
    of(&pair[0]) + share * (of(&pair[1]) - of(&pair[0]))
}

/// Time when the line is crossed, s.
fn crossing_s(driven: &Driven, line_m: f64) -> Option<f64> {
    let pair = driven.drive.steps.windows(2).find(|pair| pair[1].position_m >= line_m)?;
    let share = (line_m - pair[0].position_m) / (pair[1].position_m - pair[0].position_m);
    Some(between(pair, share, |step| step.time_s))
}

/// Position at a time, m.
fn position_m(driven: &Driven, time_s: f64) -> Option<f64> {
    let pair = driven.drive.steps.windows(2).find(|pair| pair[1].time_s >= time_s)?;
    let share = (time_s - pair[0].time_s) / (pair[1].time_s - pair[0].time_s);
    Some(between(pair, share, |step| step.position_m))
}
