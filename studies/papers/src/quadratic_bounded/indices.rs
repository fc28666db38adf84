//! The indices and their bounds: one row an index and scenario.
//!
//! The paper quantifies safety by Dd and Dv, comfort by a and u, handiness by Du, and efficiency by
//! Dd' (section 2.2). Its bounds are lost; the reconstruction's bounds are compared.

use crate::row::{EXACT, Row, reconstruction};
use crate::runner::Driven;
use controller::laws::quadratic_bounded::Parameters;

const BOUND: &str = "reconstruction's bound: the paper's is lost";
const SOURCE: &str = "section 2.2: the indices stay within bounds taken from real driving";
const CAPPED: &str = "while it follows; the law takes at most 20 m of it, so a car that is first seen far \
                      away is outside the bound";
const CLAMPED: &str = "the law clamps the request to this bound, and the vehicle lags behind it";
const INCREMENT_CLAMPED: &str =
    "the law clamps it to this bound; the printed gains ask for 1.26 at the cut-in";

pub fn rows(name: &str, driven: &Driven) -> Vec<Row> {
    let p = Parameters::reference();
    let largest =
        |values: &mut dyn Iterator<Item = f64>| Some(values.map(f64::abs).fold(0.0, f64::max));
    let figure = |name: &str| largest(&mut driven.figure(name).into_iter().map(|(_, value)| value));
    let steps = || driven.drive.steps.iter();
    let follows = steps().filter(|step| step.figures.is_some()).map(|step| step.mode == Some(1));
    let gap_errors = driven.figure("gap_error_m");
    let followed = gap_errors.into_iter().zip(follows).filter(|(_, follows)| *follows);
    let gap_error = largest(&mut followed.map(|((_, error), _)| error));
    let request = largest(&mut steps().filter_map(|step| step.request_mps2));
    let acceleration = largest(&mut steps().map(|step| step.acceleration_mps2));
    let id = |index: &str| format!("{name}.largest_{index}");
    let row = |index, unit, bound, ours| {
        Row::at_most(&id(index), unit, reconstruction(bound), ours, EXACT).depending_on(BOUND)
    };
    let clamped = |index, bound, ours, note| {
        Row::input(&id(index), "m/s²", reconstruction(bound), ours).with_note(note)
    };
    let rows = [
        row("gap_error_m", "m", p.gap_error_bound_m, gap_error).with_note(CAPPED),
        row("speed_error_mps", "m/s", p.speed_error_bound_mps, figure("speed_error_mps")),
        clamped("acceleration_mps2", p.acceleration_bound_mps2, acceleration, CLAMPED),
        clamped("request_mps2", p.request_bound_mps2, request, CLAMPED),
        clamped(
            "increment_mps2",
            p.increment_bound_mps2,
            figure("increment_mps2"),
            INCREMENT_CLAMPED,
        ),
        row("gap_error_rate_mps", "m/s", p.gap_error_rate_bound_mps, figure("gap_error_rate_mps")),
    ];
    rows.map(|row| row.with_source(SOURCE)).into()
}
