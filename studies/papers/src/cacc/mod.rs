//! CACC through signalised intersections (He et al. 2024): scenarios A, B, C and Table 3. Both controllers drive them,
//! in three sets.
//!
//! The paper prints no weights. One set takes weights that fit all scenarios at once, the second takes weights that
//! are fitted to each scenario. Both keep the desired distance of A, B and C at its first value, 34.5 m. This departs
//! from equation 1 and is nearer to the printed figures. The third set has equation 1 as printed, `v t_h + d_b` at
//! every cycle. Table 3 always has equation 1.

mod claims;
mod figures;
mod panels;
mod scenes;
mod trajectory;
pub mod weights;

pub use claims::CLAIMS;
pub use figures::{Calibration, PRINTED};
pub use scenes::{
    A, B, C, Recording, Scene, TABLE_3_LEAD_JOINT_MPS2, TABLE_3_LEAD_SINGLE_MPS2, run, table_3,
};
pub use trajectory::Runs;

use super::Pictures;
use super::row::Row;
use super::runner::{Driven, Part, Piece, Runner};
use controller::laws::cacc::weights::Weights;
use figures::Figure;
use group::Error;
use trajectory::Trajectory;

/// Lead acceleration of Table 3 that goes with the weights fitted to it, m/s².
const TABLE_3_LEAD: &str = "actors.0.profile.steps.0.acceleration_mps2=2.594";
/// Equation 1 at every cycle.
const EQUATION_1: &str = "controller.spacing_policy=measured-headway";

/// A variant of the scenes and weights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Set {
    Joint,
    Fitted,
    Equation1,
}

impl Set {
    const ALL: [Self; 3] = [Self::Joint, Self::Fitted, Self::Equation1];

    const fn name(self) -> &'static str {
        match self {
            Self::Joint => "one set of weights",
            Self::Fitted => "weights fitted to each scenario",
            Self::Equation1 => "equation 1 as printed, one set of weights",
        }
    }

    /// Name of its weights in results; equation 1 has them from the first set.
    const fn weights(self) -> Option<&'static str> {
        match self {
            Self::Joint => Some("joint"),
            Self::Fitted => Some("single"),
            Self::Equation1 => None,
        }
    }

    const fn calibration(self) -> Calibration {
        match self {
            Self::Joint | Self::Equation1 => Calibration::Joint,
            Self::Fitted => Calibration::Fitted,
        }
    }

    /// Inferred values behind a figure.
    fn inferred(self, figure: &Figure) -> &'static str {
        match (self, figure.is_of_table_3()) {
            (Self::Joint, false) => {
                "the desired distance is frozen at its first value, d_s = 34.5 m; weights fitted \
                 to all scenarios at once"
            }
            (Self::Fitted, false) => {
                "the desired distance is frozen at its first value, d_s = 34.5 m; weights fitted \
                 to the scenario, in B those of A"
            }
            (Self::Joint, true) => {
                "weights fitted to all scenarios at once, the lead's acceleration among them"
            }
            (Self::Fitted, true) => "weights fitted to Table 3, the lead's acceleration among them",
            (Self::Equation1, _) => {
                "weights fitted to all scenarios at once, with a frozen desired distance"
            }
        }
    }

    /// True if the set has the figure: Table 3 has equation 1 in the other sets.
    fn has(self, figure: &Figure) -> bool {
        self != Self::Equation1 || !figure.is_of_table_3()
    }
}

/// A piece for each set.
pub(super) fn pieces() -> Vec<Piece> {
    let piece = |set: Set| Piece::new(set.name(), move |runner| reproduce(runner, set));
    Set::ALL.map(piece).into()
}

/// Drives the scenarios of a set and compares.
fn reproduce(runner: &Runner<'_>, set: Set) -> Result<Part, Error> {
    let recorded = record(runner, set)?;
    let run = |index: usize| recorded.get(index).map(Recorded::trajectory);
    let runs = Runs {
        a_acc: run(0),
        a_cacc: run(1),
        b_acc: run(2),
        b_cacc: run(3),
        c_acc: run(4),
        c_cacc: run(5),
        t3_acc: run(6),
        t3_cacc: run(7),
    };
    let figures = PRINTED.iter().chain(CLAIMS).filter(|figure| set.has(figure));
    let rows = figures.map(|figure| {
        let row = figure.row(&runs, set.calibration());
        let row = Row { weights: set.weights().map(Into::into), ..row };
        row.in_set(set.name()).depending_on(set.inferred(figure))
    });
    let rows = rows.collect();
    let galleries = if set == Set::Joint { panels::panels(&runs) } else { Vec::new() };
    Ok(Part { rows, pictures: Pictures { galleries, drives: Vec::new() } })
}

/// Drives the set's scenarios in the order of [`Runs`].
fn record(runner: &Runner<'_>, set: Set) -> Result<Vec<Recorded>, Error> {
    let fitted = |weights: Weights| match set {
        Set::Fitted => weight_keys(&weights),
        Set::Joint => Vec::new(),
        Set::Equation1 => vec![EQUATION_1.to_owned()],
    };
    let a = fitted(weights::SCENARIO_A);
    let c = fitted(weights::SCENARIO_C);
    let mut t3 = fitted(weights::TABLE_3);
    if set == Set::Fitted {
        t3.push(TABLE_3_LEAD.into());
    }
    let mut scenarios = vec![("cacc-a", &a), ("cacc-b", &a), ("cacc-c", &c)];
    if set != Set::Equation1 {
        scenarios.push(("cacc-table3", &t3));
    }
    let drives = scenarios
        .into_iter()
        .flat_map(|(scenario, keys)| ["acc-mpc", "cacc-mpc"].map(|law| (scenario, law, keys)));
    let driven = drives.map(|(scenario, law, keys)| {
        let name = format!("controller.name={law}");
        // `acc-mpc` has no light, and refuses its keys.
        let is_read = |key: &&str| law == "cacc-mpc" || !key.contains(".light_");
        let keys = keys.iter().map(String::as_str).filter(is_read);
        let keys: Vec<_> = keys.chain([name.as_str()]).collect();
        Ok(Recorded::new(&runner.drive(scenario, &keys)?))
    });
    driven.collect()
}

fn weight_keys(weights: &Weights) -> Vec<String> {
    [
        ("q1", weights.gap_error_per_m2),
        ("q2", weights.speed_error_s2_per_m2),
        ("q3", weights.acceleration_s4_per_m2),
        ("r", weights.request_s4_per_m2),
        ("light_weight", weights.light_m),
        ("light_threshold_m", weights.light_threshold_m),
    ]
    .iter()
    .map(|(key, value)| format!("controller.weights.{key}={value:?}"))
    .collect()
}

/// A drive at its control cycles, column by column.
struct Recorded {
    columns: [Vec<f64>; 8],
}

impl Recorded {
    fn new(driven: &Driven) -> Self {
        let errors = driven.figure("gap_error_m").into_iter().zip(driven.figure("speed_error_mps"));
        let cycles = driven.drive.steps.iter().filter(|step| step.figures.is_some());
        let mut columns: [Vec<f64>; 8] = Default::default();
        for (step, ((_, gap_error), (_, speed_error))) in cycles.zip(errors) {
            let row = [
                step.time_s,
                step.position_m,
                step.speed_mps,
                step.acceleration_mps2,
                step.request_mps2.unwrap_or(f64::NAN),
                gap_error,
                speed_error,
                step.gap_m.unwrap_or(f64::NAN),
            ];
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(value);
            }
        }
        Self { columns }
    }

    fn trajectory(&self) -> Trajectory<'_> {
        let [
            time_s,
            position_m,
            speed_mps,
            acceleration_mps2,
            request_mps2,
            gap_error_m,
            speed_error_mps,
            gap_m,
        ] = &self.columns;
        Trajectory {
            time_s,
            position_m,
            speed_mps,
            acceleration_mps2,
            request_mps2,
            gap_error_m,
            speed_error_mps,
            gap_m,
        }
    }
}
