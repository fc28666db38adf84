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

const CLAMPED: &str =
    "the law clamps it to this bound; the printed gains ask for 1.26 at the cut-in";

/// The rows of a drive.
pub fn rows(name: &str, driven: &Driven) -> Vec<Row> {
    let p = Parameters::reference();
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    let figure = |name: &str| largest(&mut driven.figure(name).into_iter().map(|(_, value)| value));
    let steps = || driven.drive.steps.iter();
    let follows = steps().filter(|step| step.figures.is_some()).map(|step| step.mode == Some(1));
    let gap_errors = driven.figure("gap_error_m");
    let followed = gap_errors.into_iter().zip(follows).filter(|(_, follows)| *follows);
    let gap_error = largest(&mut followed.map(|((_, error), _)| error));
    let request = largest(&mut steps().filter_map(|step| step.request_mps2));
    let acceleration = largest(&mut steps().map(|step| step.acceleration_mps2));
    let row = |index: &str, unit, bound, ours| {
        let id = format!("{name}.largest_{index}");
        let row = Row::at_most(&id, unit, reconstruction(bound), Some(ours), EXACT);
        row.with_source(SOURCE).depending_on(BOUND)
    };
    vec![
        row("gap_error_m", "m", p.gap_error_bound_m, gap_error).with_note(CAPPED),
        row("speed_error_mps", "m/s", p.speed_error_bound_mps, figure("speed_error_mps")),
        row("acceleration_mps2", "m/s²", p.acceleration_bound_mps2, acceleration),
        row("request_mps2", "m/s²", p.request_bound_mps2, request),
        row("increment_mps2", "m/s²", p.increment_bound_mps2, figure("increment_mps2"))
            .with_note(CLAMPED),
        row("gap_error_rate_mps", "m/s", p.gap_error_rate_bound_mps, figure("gap_error_rate_mps")),
    ]
}
