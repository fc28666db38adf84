//! Printed numbers that need no drive: table 1, and the literal law's answers to single releases.

use crate::row::{Row, paper};
use controller::law::{Ego, Input, Law as _, Output, Target};
use controller::laws::six_mode::deceleration::border_m;
use controller::laws::six_mode::{Boundaries, Parameters, SixMode};

const SET: &str = "literal, single releases";
const SET_SPEED_MPS: f64 = 70.0 / 3.6;
/// Ego speed of the releases with a target, m/s. R_w is 68 m and R_j 142 m at 0.3 m/s.
const SPEED_MPS: f64 = 15.0;
/// Gap of the steady releases, m.
const STEADY_M: f64 = 100.0;
/// Gap of the accelerate release, m.
const FAR_M: f64 = 170.0;

/// Table 1: speed in km/h and gap in m.
const TABLE_1: [(u32, f64); 4] = [(120, 200.0), (100, 150.0), (80, 100.0), (60, 70.0)];

pub fn rows() -> Vec<Row> {
    let rows = TABLE_1.into_iter().map(gap_of_table_1).chain(constants()).chain(levels());
    rows.map(|row| row.in_set(SET)).collect()
}

fn gap_of_table_1((kmh, gap_m): (u32, f64)) -> Row {
    let ours = Boundaries::literal(&Parameters::literal(), f64::from(kmh) / 3.6, 0.0).desired_m;
    let row = Row::input(&format!("table-1.at_{kmh}_kmh_m"), "m", paper(gap_m), Some(ours))
        .with_source("table 1: safe gap at equal speeds; R_x is its fit (figure 2)");
    match kmh {
        60 => row.with_note("the printed fit, 1.25 V_h, misses the printed table by 5 m"),
        _ => row,
    }
}

fn constants() -> Vec<Row> {
    let below_mps = 0.2;
    let near_set_speed = request_mps2(SET_SPEED_MPS - below_mps, None);
    let equal_mps = 0.1;
    let nearly_equal = request_mps2(SPEED_MPS, Some((STEADY_M, equal_mps)));
    let behind = |gap_m, relative_mps| request_mps2(SPEED_MPS, Some((gap_m, relative_mps)));
    let row = |id, unit, printed, ours, source| {
        Row::input(id, unit, paper(printed), Some(ours)).with_source(source)
    };
    vec![
        row("cruise.k1_per_s", "1/s", 1.0, near_set_speed / below_mps, "eq (7): k1 = 1"),
        row(
            "steady-1.request_mps2",
            "m/s²",
            -0.1,
            behind(STEADY_M, -0.3),
            "in place of eq (9): -0.1 m/s²",
        ),
        row("steady-2.request_mps2", "m/s²", 0.4, behind(STEADY_M, 0.3), "steady (2): 0.4 m/s²"),
        row("steady.k3_per_s", "1/s", 0.02, nearly_equal / equal_mps, "eq (10): k3 = 0.02"),
        row("accelerate.far_mps2", "m/s²", 1.0, behind(FAR_M, 1.0), "accelerate: 1 m/s²"),
    ]
}

/// The eight levels, each in the middle of its part where all parts are there: V_r > 0.
fn levels() -> impl Iterator<Item = Row> {
    const PRINTED: [f64; 8] = [-0.5, -0.75, -1.25, -1.75, -2.25, -2.75, -3.25, -3.75];
    PRINTED.into_iter().enumerate().map(|(part, printed)| {
        let (p, relative_mps) = (Parameters::literal(), 1.0);
        let b = Boundaries::literal(&p, SPEED_MPS, relative_mps);
        let border_m = |part| border_m(&p, relative_mps, &b, part);
        let gap_m = 0.5 * (border_m(part) + border_m(part + 1));
        let ours = request_mps2(SPEED_MPS, Some((gap_m, relative_mps)));
        let id = format!("decelerate.level-{}_mps2", part + 1);
        Row::input(&id, "m/s²", paper(printed), Some(ours))
            .with_source("the eight levels from right to left (figure 3)")
            .depending_on("borders inside figure 3")
    })
}

/// Request of a new literal law, m/s². The target is gap in m and relative speed in m/s.
fn request_mps2(speed_mps: f64, target: Option<(f64, f64)>) -> f64 {
    let mut law = SixMode::new(Parameters::literal()).expect("the built-in set is valid");
    let target = target.map(|(gap_m, relative_speed_mps)| Target {
        track_id: 1,
        gap_m,
        relative_speed_mps,
        ..Target::default()
    });
    let input = Input {
        period_s: 0.05,
        ego: Ego { speed_mps, ..Ego::default() },
        target,
        set_speed_mps: SET_SPEED_MPS,
        speed_limit_mps: f64::INFINITY,
        ..Input::default()
    };
    let mut output = Output::default();
    law.step(&input, &mut output);
    output.request_mps2()
}

#[cfg(test)]
mod tests {
    use super::*;
    use controller::laws::six_mode::deceleration::LEVELS_MPS2;

    #[test]
    fn every_printed_constant_is_the_laws_but_for_the_fit_at_60_kmh() {
        let off = |row: &Row| Some(row.ours? - row.paper?);
        let rows = rows();
        let other = rows.iter().filter(|row| off(row).is_none_or(|off| off.abs() > 1e-9));
        let other: Vec<_> = other.collect();
        assert_eq!(other.len(), 1);
        assert_eq!(other[0].id, "table-1.at_60_kmh_m");
        assert!(other[0].ours.is_some_and(|ours| (ours - 75.0).abs() < 1e-9));
    }

    #[test]
    fn the_levels_are_those_of_the_law() {
        let ours: Vec<_> = levels().map(|row| row.ours).collect();
        assert_eq!(ours, LEVELS_MPS2.map(Some));
    }
}
