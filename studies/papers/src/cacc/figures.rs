//! The paper's figures and claims, computed from recorded trajectories.
//!
//! [`PRINTED`] has the numbers on which the weights were calibrated, [`CLAIMS`](super::claims::CLAIMS) everything else
//! that a trajectory decides. The paper prints no weights, so an exact match cannot be expected. A printed number has
//! the tolerance of its [`Measure`]. A claim without a number is held to 2 % of the span of its plot.

use super::trajectory::{Runs, largest, smallest};
use crate::row::{Kind, Row, Tolerance, paper, within};

/// Distance from the ego's start to the stop line in scenarios A and B, m.
pub const LINE_A_M: f64 = 80.0;
/// The same in scenario C, m.
pub const LINE_C_M: f64 = 100.0;
/// The same in Table 3, m.
pub const LINE_T3_M: f64 = 58.0;
/// Time of the switch in scenarios A, B and C, s.
pub const SWITCH_ABC_S: f64 = 5.0;
/// Time of the switch in Table 3, s.
pub const SWITCH_T3_S: f64 = 10.0;
/// A request beyond this magnitude counts as saturated (bounds are ±4.9), m/s².
const SATURATED_MPS2: f64 = 4.7;

/// Weights that a set of runs was made with; the tolerance depends on them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Calibration {
    /// One set for all scenarios.
    Joint,
    /// The set fitted to the scenario alone.
    Fitted,
}

/// Quantity of a printed number; it decides unit and tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Time of crossing the stop line, s.
    Crossing,
    /// A distance or spacing error, m.
    Distance,
    /// A speed error, m/s.
    Speed,
    /// Time for which a request was held, or its start, s.
    Duration,
    /// 1 for yes, 0 for no.
    Boolean,
}

impl Measure {
    /// Unit of the figure.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Crossing | Self::Duration => "s",
            Self::Distance => "m",
            Self::Speed => "m/s",
            Self::Boolean => "",
        }
    }

    /// Largest difference from the paper that counts as agreement. Those of crossing times and
    /// distances were set beforehand; speeds follow distances, durations crossing times.
    #[must_use]
    pub const fn tolerance(self, calibration: Calibration) -> Tolerance {
        let joint = matches!(calibration, Calibration::Joint);
        match self {
            Self::Crossing => within(if joint { 0.25 } else { 0.1 }, CROSSING),
            Self::Distance => within(if joint { 3.0 } else { 1.0 }, DISTANCE),
            Self::Speed => within(if joint { 1.0 } else { 0.33 }, SPEED),
            Self::Duration => within(if joint { 0.5 } else { 0.2 }, DURATION),
            Self::Boolean => within(0.0, "yes or no"),
        }
    }
}

const CROSSING: &str = "the weights are not printed: 0.25 s with one set for all scenarios, 0.1 s \
    with a set fitted to the scenario";
const DISTANCE: &str = "the weights are not printed: 3 m with one set for all scenarios, 1 m with a \
    set fitted to the scenario";
const SPEED: &str = "the weights are not printed: a third of the number that holds for distances";
const DURATION: &str = "the weights are not printed: twice what holds for crossing times";

/// Comparison of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Held {
    /// To a printed number, on both sides, by the measure's tolerance.
    Printed(Measure, f64),
    /// On both sides.
    Near(f64, Tolerance),
    /// To an upper bound.
    AtMost(f64, Tolerance),
    /// To a lower bound.
    AtLeast(f64, Tolerance),
    /// To nothing: the paper draws it and prints no number.
    Shown,
}

/// A figure or claim of the paper.
pub struct Figure {
    /// `scenario.controller.figure_unit`.
    pub id: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Comparison with ours.
    pub held: Held,
    /// The paper's sentence, shortened.
    pub source: &'static str,
    /// Computes the value from the runs; `None` when a run is missing or never got there.
    pub compute: fn(&Runs<'_>) -> Option<f64>,
}

impl Figure {
    /// Ours beside the paper's.
    #[must_use]
    pub fn row(&self, runs: &Runs<'_>, calibration: Calibration) -> Row {
        let (id, unit, ours) = (self.id, self.unit, (self.compute)(runs));
        let row = match self.held {
            Held::Printed(measure, value) => {
                Row::near(id, unit, paper(value), ours, measure.tolerance(calibration))
            }
            Held::Near(value, tolerance) => Row::near(id, unit, paper(value), ours, tolerance),
            Held::AtMost(value, tolerance) => Row::at_most(id, unit, paper(value), ours, tolerance),
            Held::AtLeast(value, tolerance) => {
                Row::at_least(id, unit, paper(value), ours, tolerance)
            }
            Held::Shown => Row::shown(id, unit, Kind::Paper, ours, "the paper prints no number"),
        };
        row.with_source(self.source)
    }

    /// True if the figure belongs to Table 3.
    #[must_use]
    pub fn is_of_table_3(&self) -> bool {
        self.id.starts_with("T3.")
    }
}

/// The numbers on which the weights were calibrated.
pub const PRINTED: &[Figure] = &[
    printed("A.cacc.cross_s", Measure::Crossing, 4.0, CROSSES_A, |r| {
        r.a_cacc?.crossing_s(LINE_A_M)
    }),
    printed("A.cacc.past_switch_m", Measure::Distance, 19.3, CROSSES_A, |r| {
        Some(r.a_cacc?.position_at_m(SWITCH_ABC_S)? - LINE_A_M)
    }),
    printed("A.acc.cross_s", Measure::Crossing, 4.5, CROSSES_A, |r| r.a_acc?.crossing_s(LINE_A_M)),
    printed("A.acc.past_switch_m", Measure::Distance, 9.4, CROSSES_A, |r| {
        Some(r.a_acc?.position_at_m(SWITCH_ABC_S)? - LINE_A_M)
    }),
    printed(
        "A.cacc.e_max_m",
        Measure::Distance,
        10.0,
        "6b: CACC overshoots by 10 m, into the buffer",
        |r| largest(r.a_cacc?.gap_error_m),
    ),
    printed("A.cacc.ed_max_mps", Measure::Speed, 9.3, SPEEDS_A, |r| {
        largest(r.a_cacc?.speed_error_mps)
    }),
    printed("A.cacc.ed_min_mps", Measure::Speed, -4.5, SPEEDS_A, |r| {
        smallest(r.a_cacc?.speed_error_mps)
    }),
    printed(
        "A.cacc.saturated_s",
        Measure::Duration,
        2.0,
        "6e: within the first 2 s CACC requests acceleration for longer, up to saturation",
        |r| Some(r.a_cacc?.request_time_s(0.0, 3.0, |u| u > SATURATED_MPS2)),
    ),
    printed("A.cacc.negative_s", Measure::Duration, 3.0, BRAKES_A, |r| {
        Some(r.a_cacc?.request_time_s(2.0, 7.0, |u| u < 0.0))
    }),
    printed(
        "B.cacc.positive_longer_s",
        Measure::Duration,
        0.7,
        "7e: within the first 3 s the request is positive for 0.7 s longer than in A",
        |r| Some(r.b_cacc?.first_negative_s()? - r.a_cacc?.first_negative_s()?),
    ),
    printed("C.cacc.to_line_m", Measure::Distance, 53.0, SWITCH_C, |r| {
        Some(LINE_C_M - r.c_cacc?.position_at_m(SWITCH_ABC_S)?)
    }),
    printed("C.acc.to_line_m", Measure::Distance, 47.0, SWITCH_C, |r| {
        Some(LINE_C_M - r.c_acc?.position_at_m(SWITCH_ABC_S)?)
    }),
    printed(
        "C.acc.saturated_up_s",
        Measure::Duration,
        0.4,
        "8e: in the first 0.4 s ACC requests saturated acceleration",
        |r| Some(r.c_acc?.request_time_s(0.0, 1.0, |u| u > SATURATED_MPS2)),
    ),
    printed("C.acc.saturated_down_s", Measure::Duration, 1.5, BRAKES_C, |r| {
        Some(r.c_acc?.request_time_s(0.3, 3.0, |u| u < -SATURATED_MPS2))
    }),
    printed(
        "C.cacc.brakes_first",
        Measure::Boolean,
        1.0,
        "8e: in the first 5 s CACC requests deceleration of its own accord, far from the lead",
        |r| Some(f64::from(u8::from(*r.c_cacc?.request_mps2.first()? < 0.0))),
    ),
    printed("T3.acc.cross_s", Measure::Crossing, 8.45, CROSSES_T3, |r| {
        r.t3_acc?.crossing_s(LINE_T3_M)
    }),
    printed("T3.acc.past_switch_m", Measure::Distance, 12.9, SWITCH_T3, |r| {
        Some(r.t3_acc?.position_at_m(SWITCH_T3_S)? - LINE_T3_M)
    }),
    printed("T3.cacc.cross_s", Measure::Crossing, 7.9, CROSSES_T3, |r| {
        r.t3_cacc?.crossing_s(LINE_T3_M)
    }),
    printed("T3.cacc.past_switch_m", Measure::Distance, 16.2, SWITCH_T3, |r| {
        Some(r.t3_cacc?.position_at_m(SWITCH_T3_S)? - LINE_T3_M)
    }),
];

const CROSSES_A: &str = "6a: CACC passes the stop line at 4.0 s and is 19.3 m beyond it at the \
    switch, ACC at 4.5 s and 9.4 m";
const SPEEDS_A: &str = "6c: at most 9.3 m/s faster than the lead, then down to 4.5 m/s slower";
pub(super) const BRAKES_A: &str = "6e: from 3 s to 6 s it requests deceleration";
const SWITCH_C: &str = "8a: at the switch, 5 s, CACC is 53 m before the stop line, ACC 47 m";
pub(super) const BRAKES_C: &str = "8e: from 0.5 to 2 s ACC slows down towards the lead; its request reaches \
    saturation too";
pub(super) const CROSSES_T3: &str =
    "10f: ACC passes the stop line at 8.45 s, CACC at 7.9 s, 0.55 s earlier";
pub(super) const SWITCH_T3: &str =
    "10f: at 10 s ACC is 12.9 m beyond the stop line, CACC 16.2 m, 3.3 m more";

pub(super) const fn printed(
    id: &'static str,
    measure: Measure,
    value: f64,
    source: &'static str,
    compute: fn(&Runs<'_>) -> Option<f64>,
) -> Figure {
    Figure { id, unit: measure.unit(), held: Held::Printed(measure, value), source, compute }
}

#[cfg(test)]
mod tests {
    use super::super::claims::CLAIMS;
    use super::*;
    use crate::row::Check;

    #[test]
    fn a_missing_run_is_a_row_that_fails() {
        let row = |figure: &Figure| figure.row(&Runs::default(), Calibration::Joint);
        let rows: Vec<_> = PRINTED.iter().chain(CLAIMS).map(row).collect();
        assert!(rows.iter().all(|row| row.ours.is_none()));
        let compared = rows.iter().filter(|row| row.check != Check::Shown);
        assert!(compared.clone().count() > 40 && compared.clone().all(|row| !row.ok));
    }
}
