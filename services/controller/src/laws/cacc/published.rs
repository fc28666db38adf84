//! The paper's published figures, computed from recorded trajectories.
//!
//! Each figure is a pure function of one or two trajectories. Values that the paper states only
//! as "about" or shows in a plot keep the tolerance of their kind; a row outside of it says so.

use std::fmt;

/// Distance from the ego's start to the stop line in scenarios A and B, m.
const LINE_A_M: f64 = 80.0;
/// The same in scenario C, m.
const LINE_C_M: f64 = 100.0;
/// The same in Table 3, m.
const LINE_T3_M: f64 = 58.0;
/// Time of the switch in scenarios A, B and C, s.
const SWITCH_ABC_S: f64 = 5.0;
/// Time of the switch in Table 3, s.
const SWITCH_T3_S: f64 = 10.0;
/// A request beyond this magnitude counts as saturated (bounds are ±4.9), m/s².
const SATURATED_MPS2: f64 = 4.7;

/// One recorded closed loop; all slices have the same length, in order of time.
#[derive(Clone, Copy, Debug, Default)]
pub struct Trajectory<'a> {
    /// Time, s.
    pub time_s: &'a [f64],
    /// Distance travelled by the ego, m.
    pub position_m: &'a [f64],
    /// Ego speed, m/s.
    pub speed_mps: &'a [f64],
    /// Ego acceleration, m/s².
    pub acceleration_mps2: &'a [f64],
    /// Request that acts from this time on, m/s².
    pub request_mps2: &'a [f64],
    /// Spacing error `d_s - gap`, m.
    pub gap_error_m: &'a [f64],
    /// Speed error, ego minus lead, m/s.
    pub speed_error_mps: &'a [f64],
    /// Gap, m.
    pub gap_m: &'a [f64],
}

impl Trajectory<'_> {
    /// Time at which the ego has travelled `line_m`, interpolated between samples, s.
    #[must_use]
    pub fn crossing_s(&self, line_m: f64) -> Option<f64> {
        let i = self.position_m.iter().position(|&x| x >= line_m)?;
        if i == 0 {
            return self.time_s.first().copied();
        }
        let (x0, x1) = (self.position_m[i - 1], self.position_m[i]);
        let (t0, t1) = (self.time_s[i - 1], self.time_s[i]);
        Some(t0 + (line_m - x0) / (x1 - x0) * (t1 - t0))
    }

    /// Position at `time_s`, interpolated between samples, m.
    #[must_use]
    pub fn position_at_m(&self, time_s: f64) -> Option<f64> {
        let i = self.time_s.iter().position(|&t| t >= time_s - 1e-9)?;
        let (t1, x1) = (self.time_s[i], self.position_m[i]);
        if i == 0 || t1 <= time_s + 1e-9 {
            return (t1 <= time_s + 1e-9).then_some(x1);
        }
        let (t0, x0) = (self.time_s[i - 1], self.position_m[i - 1]);
        Some(x0 + (time_s - t0) / (t1 - t0) * (x1 - x0))
    }

    /// Total time in `[from_s, to_s)` during which the request satisfies `test`, s.
    pub fn request_time_s(&self, from_s: f64, to_s: f64, test: impl Fn(f64) -> bool) -> f64 {
        let mut total = 0.0;
        for (i, pair) in self.time_s.windows(2).enumerate() {
            let inside = pair[0] >= from_s - 1e-9 && pair[0] < to_s - 1e-9;
            if inside && test(self.request_mps2[i]) {
                total += pair[1] - pair[0];
            }
        }
        total
    }

    /// Time of the first negative request, s.
    #[must_use]
    pub fn first_negative_s(&self) -> Option<f64> {
        let i = self.request_mps2.iter().position(|&u| u < 0.0)?;
        Some(self.time_s[i])
    }
}

/// The closed loops behind the published figures; leave out what was not run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Runs<'a> {
    /// Scenario A under `acc-mpc`.
    pub a_acc: Option<Trajectory<'a>>,
    /// Scenario A under `cacc-mpc`.
    pub a_cacc: Option<Trajectory<'a>>,
    /// Scenario B under `cacc-mpc`.
    pub b_cacc: Option<Trajectory<'a>>,
    /// Scenario C under `acc-mpc`.
    pub c_acc: Option<Trajectory<'a>>,
    /// Scenario C under `cacc-mpc`.
    pub c_cacc: Option<Trajectory<'a>>,
    /// Table 3 under `acc-mpc`.
    pub t3_acc: Option<Trajectory<'a>>,
    /// Table 3 under `cacc-mpc`.
    pub t3_cacc: Option<Trajectory<'a>>,
}

/// Which weights a set of runs was made with; the tolerance depends on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Calibration {
    /// One set for all scenarios.
    Joint,
    /// The set fitted to the scenario alone.
    Single,
}

impl fmt::Display for Calibration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Joint => "joint",
            Self::Single => "single",
        })
    }
}

/// What a figure measures; it decides unit and tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Time of crossing the stop line, s.
    Crossing,
    /// A distance or spacing error, m.
    Distance,
    /// A speed error, m/s.
    Speed,
    /// How long a request was held, s.
    Duration,
    /// 1 for yes, 0 for no.
    Boolean,
}

impl Kind {
    /// Unit of the figure.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Crossing | Self::Duration => "s",
            Self::Distance => "m",
            Self::Speed => "m/s",
            Self::Boolean => "1",
        }
    }

    /// Largest difference from the paper that counts as agreement, in the figure's unit.
    ///
    /// Crossing times and distances are given by the task. Speeds and durations, which the paper
    /// shows only as plots, are held to a third of the distance's number and to twice the
    /// crossing's.
    #[must_use]
    pub fn tolerance(self, calibration: Calibration) -> f64 {
        let (joint, single) = match self {
            Self::Crossing => (0.25, 0.1),
            Self::Distance => (3.0, 1.0),
            Self::Speed => (1.0, 0.33),
            Self::Duration => (0.5, 0.2),
            Self::Boolean => (0.0, 0.0),
        };
        match calibration {
            Calibration::Joint => joint,
            Calibration::Single => single,
        }
    }
}

/// One published figure.
pub struct Figure {
    /// `scenario.controller.figure_unit`.
    pub id: &'static str,
    /// What it measures.
    pub kind: Kind,
    /// The paper's value.
    pub paper: f64,
    /// Computes the value from the runs; `None` when a run is missing or never got there.
    pub compute: fn(&Runs<'_>) -> Option<f64>,
}

/// A published figure and ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// `scenario.controller.figure_unit`.
    pub id: &'static str,
    /// Weights of the run.
    pub weights: Calibration,
    /// Unit of `paper`, `ours` and `tolerance`.
    pub unit: &'static str,
    /// The paper's value.
    pub paper: f64,
    /// Our value; `None` when the run did not produce it.
    pub ours: Option<f64>,
    /// Largest accepted difference.
    pub tolerance: f64,
    /// Whether ours exists and is within the tolerance.
    pub ok: bool,
}

/// All published figures with the values computed from `runs`, in the order of [`FIGURES`].
#[must_use]
pub fn rows(runs: &Runs<'_>, weights: Calibration) -> Vec<Row> {
    FIGURES
        .iter()
        .map(|figure| {
            let ours = (figure.compute)(runs);
            let tolerance = figure.kind.tolerance(weights);
            let within = |value: f64| (value - figure.paper).abs() <= tolerance + 1e-9;
            Row {
                id: figure.id,
                weights,
                unit: figure.kind.unit(),
                paper: figure.paper,
                ours,
                tolerance,
                ok: ours.is_some_and(within),
            }
        })
        .collect()
}

/// The paper's figures that a trajectory decides.
pub const FIGURES: &[Figure] = &[
    figure("A.cacc.cross_s", Kind::Crossing, 4.0, |r| r.a_cacc?.crossing_s(LINE_A_M)),
    figure("A.cacc.past_switch_m", Kind::Distance, 19.3, |r| {
        Some(r.a_cacc?.position_at_m(SWITCH_ABC_S)? - LINE_A_M)
    }),
    figure("A.acc.cross_s", Kind::Crossing, 4.5, |r| r.a_acc?.crossing_s(LINE_A_M)),
    figure("A.acc.past_switch_m", Kind::Distance, 9.4, |r| {
        Some(r.a_acc?.position_at_m(SWITCH_ABC_S)? - LINE_A_M)
    }),
    figure("A.cacc.e_max_m", Kind::Distance, 10.0, |r| largest(r.a_cacc?.gap_error_m)),
    figure("A.cacc.ed_max_mps", Kind::Speed, 9.3, |r| largest(r.a_cacc?.speed_error_mps)),
    figure("A.cacc.ed_min_mps", Kind::Speed, -4.5, |r| smallest(r.a_cacc?.speed_error_mps)),
    figure("A.cacc.saturated_s", Kind::Duration, 2.0, |r| {
        Some(r.a_cacc?.request_time_s(0.0, 3.0, |u| u > SATURATED_MPS2))
    }),
    figure("A.cacc.negative_s", Kind::Duration, 3.0, |r| {
        Some(r.a_cacc?.request_time_s(2.0, 7.0, |u| u < 0.0))
    }),
    figure("B.cacc.positive_longer_s", Kind::Duration, 0.7, |r| {
        Some(r.b_cacc?.first_negative_s()? - r.a_cacc?.first_negative_s()?)
    }),
    figure("C.cacc.to_line_m", Kind::Distance, 53.0, |r| {
        Some(LINE_C_M - r.c_cacc?.position_at_m(SWITCH_ABC_S)?)
    }),
    figure("C.acc.to_line_m", Kind::Distance, 47.0, |r| {
        Some(LINE_C_M - r.c_acc?.position_at_m(SWITCH_ABC_S)?)
    }),
    figure("C.acc.saturated_up_s", Kind::Duration, 0.4, |r| {
        Some(r.c_acc?.request_time_s(0.0, 1.0, |u| u > SATURATED_MPS2))
    }),
    figure("C.acc.saturated_down_s", Kind::Duration, 1.5, |r| {
        Some(r.c_acc?.request_time_s(0.3, 3.0, |u| u < -SATURATED_MPS2))
    }),
    figure("C.cacc.brakes_first", Kind::Boolean, 1.0, |r| {
        Some(f64::from(u8::from(*r.c_cacc?.request_mps2.first()? < 0.0)))
    }),
    figure("T3.acc.cross_s", Kind::Crossing, 8.45, |r| r.t3_acc?.crossing_s(LINE_T3_M)),
    figure("T3.acc.past_switch_m", Kind::Distance, 12.9, |r| {
        Some(r.t3_acc?.position_at_m(SWITCH_T3_S)? - LINE_T3_M)
    }),
    figure("T3.cacc.cross_s", Kind::Crossing, 7.9, |r| r.t3_cacc?.crossing_s(LINE_T3_M)),
    figure("T3.cacc.past_switch_m", Kind::Distance, 16.2, |r| {
        Some(r.t3_cacc?.position_at_m(SWITCH_T3_S)? - LINE_T3_M)
    }),
];

const fn figure(
    id: &'static str,
    kind: Kind,
    paper: f64,
    compute: fn(&Runs<'_>) -> Option<f64>,
) -> Figure {
    Figure { id, kind, paper, compute }
}

fn largest(values: &[f64]) -> Option<f64> {
    values.iter().copied().reduce(f64::max)
}

fn smallest(values: &[f64]) -> Option<f64> {
    values.iter().copied().reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossing_and_position_interpolate() {
        let t = Trajectory {
            time_s: &[0.0, 1.0, 2.0],
            position_m: &[0.0, 10.0, 30.0],
            ..Trajectory::default()
        };
        assert_eq!(t.crossing_s(20.0), Some(1.5));
        assert_eq!(t.crossing_s(31.0), None);
        assert_eq!(t.position_at_m(1.5), Some(20.0));
        assert_eq!(t.position_at_m(2.5), None);
    }

    #[test]
    fn a_missing_run_is_a_row_that_fails() {
        let rows = rows(&Runs::default(), Calibration::Joint);
        assert_eq!(rows.len(), FIGURES.len());
        assert!(rows.iter().all(|row| !row.ok && row.ours.is_none()));
    }
}
