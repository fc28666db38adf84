//! CACC through signalised intersections (He et al. 2024): scenarios A, B, C and Table 3. Both controllers drive them,
//! in four sets.
//!
//! The paper prints no weights. One set takes weights that fit all scenarios at once, the second takes weights that
//! are fitted to each scenario. Both keep the desired distance of A, B and C at its first value, 34.5 m. This departs
//! from equation 1 and is nearer to the printed figures. The third set has equation 1 as printed, `v t_h + d_b` at
//! every cycle. Table 3 always has equation 1. The fourth set sums the light's penalty over all stages, as equation 15
//! is printed. The others sum it before the switch, as equation 23 says.

mod figures;
mod recording;

pub use figures::{CLAIMS, Calibration, Figure, PRINTED};
pub use recording::{Recording, Runs, Seen};

use super::page::over_time;
use super::row::Row;
use super::runner::{Driven, Gallery, Part, Pictures, Piece, Runner};
use report::chart::{Strip, Tone};
use scenario::Setting;
use supervise::Error;

/// A scene of the paper: name in the figures, scenario, stop line and switch.
#[derive(Debug, PartialEq)]
pub struct Scene {
    /// First word of its figures' ids.
    pub name: &'static str,
    pub scenario: &'static str,
    /// Distance from the ego's start to the stop line, m.
    pub line_m: f64,
    pub switch_s: f64,
    /// Weights fitted to the scene alone, in B those of A.
    ///
    /// Source: calibrated against the figures that the paper prints, which has no weights.
    pub fitted: Weights,
}

/// `Q1`, `Q2`, `Q3`, `w` and `d_th` with `R` = 1, in the units of the scenario's keys.
pub type Weights = [f64; 5];

const FITTED_TO_A: Weights = [19.5, 29.5, 1.29, 1.16e5, 43.8];

pub static SCENES: [Scene; 4] = [
    Scene { name: "A", scenario: "cacc-a", line_m: 80.0, switch_s: 5.0, fitted: FITTED_TO_A },
    Scene { name: "B", scenario: "cacc-b", line_m: 80.0, switch_s: 5.0, fitted: FITTED_TO_A },
    Scene {
        name: "C",
        scenario: "cacc-c",
        line_m: 100.0,
        switch_s: 5.0,
        fitted: [1275.0, 9998.0, 0.001, 2.6e7, 306.0],
    },
    Scene {
        name: "T3",
        scenario: "cacc-table3",
        line_m: 58.0,
        switch_s: 10.0,
        fitted: [0.988, 0.516, 0.020, 1401.0, 37.5],
    },
];
/// Lead acceleration of Table 3 that goes with the weights fitted to it, m/s².
pub const TABLE_3_LEAD_MPS2: f64 = 2.594;

/// A variant of the scenes and weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Set {
    /// One set of weights.
    Joint,
    /// Weights fitted to each scene.
    Fitted,
    /// Equation 1 at every cycle.
    Equation1,
    /// Equation 15 over all stages.
    AllStages,
}

impl Set {
    const ALL: [Self; 4] = [Self::Joint, Self::Fitted, Self::Equation1, Self::AllStages];

    const fn name(self) -> &'static str {
        match self {
            Self::Joint => "one set of weights (d_s frozen in A to C, equation 1 in Table 3)",
            Self::Fitted => "weights fitted to each scenario (d_s as in the first set)",
            Self::Equation1 => "equation 1 as printed, one set of weights",
            Self::AllStages => {
                "equation 15 over all stages, one set of weights (d_s as in the first set)"
            }
        }
    }

    /// Name of its weights in results; the later sets have those of the first.
    const fn weights(self) -> Option<&'static str> {
        match self {
            Self::Joint => Some("joint"),
            Self::Fitted => Some("single"),
            Self::Equation1 | Self::AllStages => None,
        }
    }

    const fn calibration(self) -> Calibration {
        if matches!(self, Self::Fitted) { Calibration::Fitted } else { Calibration::Joint }
    }

    /// Inferred values behind a figure.
    const fn inferred(self, is_of_table_3: bool) -> &'static str {
        match (self, is_of_table_3) {
            (Self::Joint | Self::AllStages, false) => {
                "the desired distance is frozen at its first value, d_s = 34.5 m; weights fitted to all scenarios at \
                 once"
            }
            (Self::Fitted, false) => {
                "the desired distance is frozen at its first value, d_s = 34.5 m; weights fitted to the scenario, in \
                 B those of A"
            }
            (Self::Joint | Self::AllStages, true) => {
                "equation 1 at every cycle; weights fitted to all scenarios at once, the lead's acceleration among them"
            }
            (Self::Fitted, true) => {
                "equation 1 at every cycle; weights fitted to Table 3, the lead's acceleration among them"
            }
            (Self::Equation1, _) => {
                "weights fitted to all scenarios at once, with a frozen desired distance"
            }
        }
    }

    /// True if the set has the figure. Table 3 has equation 1 in the other sets, and ACC has no light.
    fn has(self, id: &str) -> bool {
        match self {
            Self::Joint | Self::Fitted => true,
            Self::Equation1 => !id.starts_with("T3."),
            Self::AllStages => id.contains(".cacc."),
        }
    }

    /// Settings that make a scene one of this set.
    pub fn settings(self, scene: &Scene) -> Vec<Setting> {
        match self {
            Self::Joint => Vec::new(),
            Self::Equation1 => {
                vec![Setting::new("controller.spacing_policy", "measured-headway")]
            }
            Self::AllStages => vec![Setting::new("controller.weights.light_stages", "all")],
            Self::Fitted => settings(scene, &scene.fitted, TABLE_3_LEAD_MPS2),
        }
    }
}

/// Settings for weights, and for the lead's acceleration in Table 3.
pub fn settings(scene: &Scene, weights: &Weights, table_3_lead_mps2: f64) -> Vec<Setting> {
    let [q1, q2, q3, w, d_th] = *weights;
    let weights = [
        ("q1", q1),
        ("q2", q2),
        ("q3", q3),
        ("r", 1.0),
        ("light_weight", w),
        ("light_threshold_m", d_th),
    ];
    let lead = Setting::new("actors.0.profile.steps.0.acceleration_mps2", table_3_lead_mps2);
    let setting = |(key, value)| Setting::new(&format!("controller.weights.{key}"), value);
    let weights = weights.into_iter().map(setting);
    weights.chain((scene.name == "T3").then_some(lead)).collect()
}

/// Drives a scenario with these settings.
pub type DriveWith<'a> = dyn Fn(&str, &[Setting]) -> Result<Driven, Error> + 'a;

/// Drives both laws through a scene: ACC, then CACC.
pub fn both_laws(
    scene: &Scene,
    set: &[Setting],
    drive: &DriveWith<'_>,
) -> Result<[Driven; 2], Error> {
    let of = |law: &str| {
        // `acc-mpc` has no light, and refuses its keys.
        let is_read = |one: &&Setting| law == "cacc-mpc" || !one.key().contains(".light_");
        let set = set.iter().filter(is_read).cloned();
        let law = Setting::new("controller.name", law);
        drive(scene.scenario, &set.chain([law]).collect::<Vec<_>>())
    };
    Ok([of("acc-mpc")?, of("cacc-mpc")?])
}

pub(super) fn pieces() -> Vec<Piece> {
    let piece = |set: Set| Piece::new(set.name(), move |runner| reproduce(runner, set));
    Set::ALL.map(piece).into()
}

/// Drives the scenarios of a set and compares.
fn reproduce(runner: &Runner<'_>, set: Set) -> Result<Part, Error> {
    let (mut runs, mut pictures) = (Runs::default(), Pictures::default());
    for scene in SCENES.iter().filter(|scene| set.has(&format!("{}.cacc.", scene.name))) {
        let driven = both_laws(scene, &set.settings(scene), &|name, set| runner.drive(name, set))?;
        if set == Set::Joint {
            pictures.galleries.push(panels(scene, &driven));
        }
        runs.0.push((scene, driven.each_ref().map(Recording::of)));
    }
    let rows = PRINTED.iter().chain(CLAIMS).filter(|figure| set.has(figure.id)).map(|figure| {
        let row = figure.row(&runs, set.calibration()).in_set(set.name());
        let row = Row { weights: set.weights().map(Into::into), ..row };
        row.depending_on(set.inferred(figure.id.starts_with("T3.")))
    });
    Ok(Part { rows: rows.collect(), pictures })
}

/// The panels of the paper's figures 6, 7, 8 and 10, both laws in each.
fn panels(scene: &Scene, [acc, cacc]: &[Driven; 2]) -> Gallery {
    let drives = [("CACC", cacc), ("ACC", acc)];
    let figure = |title, unit, name| over_time(title, unit, &drives, &|driven| driven.figure(name));
    let mut position =
        over_time("Position", "m", &drives, &|driven| driven.points(|step| Some(step.position_m)));
    let (first, then) =
        if scene.name == "C" { (Tone::Stop, Tone::Go) } else { (Tone::Go, Tone::Stop) };
    let end_s = cacc.scenario.duration_s.value();
    let spans = vec![(0.0, scene.switch_s, first), (scene.switch_s, end_s, then)];
    position.strips.push(Strip { y: scene.line_m, label: "stop line".into(), spans });
    Gallery {
        heading: format!("Scene {}: one set of weights", scene.name),
        plots: vec![
            position,
            figure("Spacing error", "m", "gap_error_m"),
            figure("Speed error", "m/s", "speed_error_mps"),
            over_time("Acceleration", "m/s²", &drives, &|driven| {
                driven.points(|step| Some(step.acceleration_mps2))
            }),
            over_time("Requested acceleration", "m/s²", &drives, &|driven| {
                driven.points(|step| step.request_mps2)
            }),
        ],
    }
}
