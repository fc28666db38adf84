//! Further claims of the paper on its scenarios: differences, convergence, order, shape.

use super::figures::{
    BRAKES_A, BRAKES_C, CROSSES_T3, Figure, Held, LINE_A_M, LINE_T3_M, Measure, SWITCH_ABC_S,
    SWITCH_T3, SWITCH_T3_S, printed,
};
use super::trajectory::{Runs, Trajectory, largest, smallest};
use crate::row::{Tolerance, within};

/// Largest request, and by its magnitude the smallest, m/s².
const BOUND_MPS2: f64 = 4.9;
/// Buffer `d_b`, m.
const BUFFER_M: f64 = 12.0;
/// Share of what a plot must span.
const SPAN: &str = "no number is printed: 2 % of what the plot must span";
/// Spacing error in A and B: -15 to 10 m.
const GAP_A: Tolerance = within(0.5, SPAN);
/// Spacing error in C: -65 to 0 m.
const GAP_C: Tolerance = within(1.3, SPAN);
/// Speed error: -4.5 to 9.3 m/s in A, 15 m/s in C.
const SPEED: Tolerance = within(0.3, SPAN);
/// Acceleration and request: ±4.9 m/s².
const ACCELERATION: Tolerance = within(0.2, SPAN);
/// Times of a plot over 10 s.
const TIME: Tolerance = within(0.2, SPAN);
/// No number is needed to see which is larger.
const ORDER: Tolerance = within(0.0, "an order, not a number");

/// Claims beside the printed numbers of [`super::figures::PRINTED`].
pub const CLAIMS: &[Figure] = &[
    claim("A.acc.e_max_m", "m", Held::AtMost(0.0, GAP_A), ACC_A, |r| largest(r.a_acc?.gap_error_m)),
    end("A.cacc.e_end_m", GAP_A, END_A, |r| last(r.a_cacc?.gap_error_m)),
    end("A.acc.e_end_m", GAP_A, END_A, |r| last(r.a_acc?.gap_error_m)),
    end("A.cacc.ed_end_mps", SPEED, SPEEDS_END_A, |r| last(r.a_cacc?.speed_error_mps)),
    end("A.acc.ed_end_mps", SPEED, SPEEDS_END_A, |r| last(r.a_acc?.speed_error_mps)),
    claim(
        "A.cacc.request_max_mps2",
        "m/s²",
        Held::Near(BOUND_MPS2, ACCELERATION),
        "6e and table 1: the request of CACC reaches its bound, 4.9 m/s²",
        |r| largest(r.a_cacc?.request_mps2),
    ),
    claim(
        "A.cacc.accelerates_longer_s",
        "s",
        Held::AtLeast(0.0, ORDER),
        "6e: within the first 2 s CACC requests acceleration for longer",
        |r| Some(r.a_cacc?.first_negative_s()? - r.a_acc?.first_negative_s()?),
    ),
    printed("A.cacc.brakes_from_s", Measure::Duration, 3.0, BRAKES_A, |r| {
        r.a_cacc?.first_negative_s()
    }),
    claim("B.acc.cross_s", "s", Held::Shown, BETTER_B, |r| r.b_acc?.crossing_s(LINE_A_M)),
    claim("B.cacc.cross_s", "s", Held::Shown, BETTER_B, |r| r.b_cacc?.crossing_s(LINE_A_M)),
    claim("B.cacc.earlier_s", "s", Held::AtLeast(0.0, ORDER), BETTER_B, |r| {
        Some(r.b_acc?.crossing_s(LINE_A_M)? - r.b_cacc?.crossing_s(LINE_A_M)?)
    }),
    claim("B.acc.past_switch_m", "m", Held::Shown, BETTER_B, |r| {
        Some(r.b_acc?.position_at_m(SWITCH_ABC_S)? - LINE_A_M)
    }),
    claim("B.cacc.past_switch_m", "m", Held::Shown, BETTER_B, |r| {
        Some(r.b_cacc?.position_at_m(SWITCH_ABC_S)? - LINE_A_M)
    }),
    claim("B.cacc.farther_m", "m", Held::AtLeast(0.0, ORDER), BETTER_B, |r| {
        farther_m(r.b_cacc?, r.b_acc?, SWITCH_ABC_S)
    }),
    claim("B.cacc.e_max_m", "m", Held::AtMost(BUFFER_M, ORDER), BUFFER, |r| {
        largest(r.b_cacc?.gap_error_m)
    }),
    end("B.cacc.e_end_m", GAP_A, END_B, |r| last(r.b_cacc?.gap_error_m)),
    end("B.acc.e_end_m", GAP_A, END_B, |r| last(r.b_acc?.gap_error_m)),
    end("B.cacc.ed_end_mps", SPEED, END_B, |r| last(r.b_cacc?.speed_error_mps)),
    end("B.acc.ed_end_mps", SPEED, END_B, |r| last(r.b_acc?.speed_error_mps)),
    end("C.cacc.e_end_m", GAP_C, END_C, |r| last(r.c_cacc?.gap_error_m)),
    end("C.acc.e_end_m", GAP_C, END_C, |r| last(r.c_acc?.gap_error_m)),
    end("C.cacc.ed_end_mps", SPEED, END_C, |r| last(r.c_cacc?.speed_error_mps)),
    end("C.acc.ed_end_mps", SPEED, END_C, |r| last(r.c_acc?.speed_error_mps)),
    end("C.cacc.a_end_mps2", ACCELERATION, END_C, |r| last(r.c_cacc?.acceleration_mps2)),
    end("C.acc.a_end_mps2", ACCELERATION, END_C, |r| last(r.c_acc?.acceleration_mps2)),
    printed("C.acc.brakes_from_s", Measure::Duration, 0.5, BRAKES_C, |r| {
        r.c_acc?.first_negative_s()
    }),
    claim(
        "C.acc.request_min_mps2",
        "m/s²",
        Held::Near(-BOUND_MPS2, ACCELERATION),
        BRAKES_C,
        |r| smallest(r.c_acc?.request_mps2),
    ),
    claim(
        "C.acc.answers_after_s",
        "s",
        Held::Near(0.1, within(0.05, "half a sample period")),
        "8e: from 5 s on the lead accelerates; the ego follows one sample period later",
        |r| answer_s(r.c_acc?, SWITCH_ABC_S),
    ),
    printed("T3.cacc.earlier_s", Measure::Crossing, 0.55, CROSSES_T3, |r| {
        Some(r.t3_acc?.crossing_s(LINE_T3_M)? - r.t3_cacc?.crossing_s(LINE_T3_M)?)
    }),
    printed("T3.cacc.farther_m", Measure::Distance, 3.3, SWITCH_T3, |r| {
        farther_m(r.t3_cacc?, r.t3_acc?, SWITCH_T3_S)
    }),
    printed("T3.acc.accelerates_until_s", Measure::Duration, 6.0, SHAPE_T3, |r| {
        slows_from_s(r.t3_acc?)
    }),
    printed("T3.acc.speed_at_7s_mps", Measure::Speed, 30.0 / 3.6, SHAPE_T3, |r| {
        r.t3_acc?.at(7.0, r.t3_acc?.speed_mps)
    }),
    claim("T3.cacc.accelerates_until_s", "s", Held::AtLeast(7.0, TIME), SHAPE_T3, |r| {
        slows_from_s(r.t3_cacc?)
    }),
    claim("T3.cacc.enters_buffer_m", "m", Held::AtLeast(0.0, ORDER), SHAPE_T3, |r| {
        largest(r.t3_cacc?.gap_error_m)
    }),
    claim("T3.cacc.e_max_m", "m", Held::AtMost(BUFFER_M, ORDER), BUFFER, |r| {
        largest(r.t3_cacc?.gap_error_m)
    }),
];

const ACC_A: &str = "6b: ACC approaches step by step until it has converged";
const END_A: &str = "6b: at the end of the simulation CACC and ACC follow the safe distance stably";
const SPEEDS_END_A: &str = "6c: the speeds converge stably";
const BETTER_B: &str = "7a: CACC still passes with higher efficiency and safety";
const END_B: &str = "7b, 7c: behind the crossing the ego still converges smoothly to its target";
const END_C: &str = "8b, 8c, 8d: at the end CACC and ACC have both converged to their target";
const SHAPE_T3: &str = "10a, 10b: both accelerate in the first 6 s; from 6 to 7 s ACC slows to \
    30 km/h, CACC goes on accelerating into the buffer";
const BUFFER: &str = "equation 19: the ego may enter the buffer, 12 m, and not pass it";

const fn claim(
    id: &'static str,
    unit: &'static str,
    held: Held,
    source: &'static str,
    compute: fn(&Runs<'_>) -> Option<f64>,
) -> Figure {
    Figure { id, unit, held, source, compute }
}

/// A value that is zero at the end.
const fn end(
    id: &'static str,
    tolerance: Tolerance,
    source: &'static str,
    compute: fn(&Runs<'_>) -> Option<f64>,
) -> Figure {
    let unit = match id.as_bytes() {
        [.., b'_', b'm'] => "m",
        [.., b'p', b's'] => "m/s",
        _ => "m/s²",
    };
    Figure { id, unit, held: Held::Near(0.0, tolerance), source, compute }
}

fn last(values: &[f64]) -> Option<f64> {
    values.last().copied()
}

/// Distance of `ours` beyond `other`, m.
fn farther_m(ours: Trajectory<'_>, other: Trajectory<'_>, time_s: f64) -> Option<f64> {
    Some(ours.position_at_m(time_s)? - other.position_at_m(time_s)?)
}

/// Time at which it first slows down after its start, s.
fn slows_from_s(run: Trajectory<'_>) -> Option<f64> {
    run.first_s(0.0, run.acceleration_mps2, |a| a < 0.0)
}

/// Time from `from_s` on after which the request first rises more than it did before, s.
fn answer_s(run: Trajectory<'_>, from_s: f64) -> Option<f64> {
    let start = run.time_s.iter().position(|t| *t >= from_s - 1e-9)?;
    let rise = |i: usize| run.request_mps2[i] - run.request_mps2[i - 1];
    let before = rise(start.checked_sub(1).filter(|i| *i > 0)?);
    let answer = (start..run.time_s.len()).find(|i| rise(*i) > before.max(0.0) + ANSWER_MPS2)?;
    Some(run.time_s[answer] - from_s)
}

/// A request that rises by more than this beyond its course answers the lead, m/s².
const ANSWER_MPS2: f64 = 0.1;
