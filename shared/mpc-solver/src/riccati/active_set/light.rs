//! The light in the active-set method: its curve is replaced by tangents, which the rounds renew.

use multiversion::multiversion;

use crate::problem::{LightStage, Problem, dot};
use crate::riccati::light_curve::{LightCurve, LightTangent};

/// First tangents, from the margins of a trajectory without the light.
pub(super) fn place(
    problem: &Problem,
    curve: &LightCurve,
    states: &[[f64; 3]],
    tangents: &mut [LightTangent],
) {
    let margins =
        || problem.light_stages().iter().zip(&states[1..]).map(|(stage, x)| margin(stage, x));
    let best = margins().fold(f64::NEG_INFINITY, f64::max);
    for (tangent, margin) in tangents.iter_mut().zip(margins()) {
        *tangent = curve.start(margin, best);
    }
}

/// New tangents where the last step has led, and the multipliers there; returns the largest distance from
/// the curve, relative.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn project(
    problem: &Problem,
    curve: &LightCurve,
    states: &[[f64; 3]],
    tangents: &mut [LightTangent],
    multipliers: &mut [f64],
) -> f64 {
    let mut worst: f64 = 0.0;
    let stages = problem.light_stages().iter().zip(&states[1..]);
    for ((stage, x), (tangent, alpha)) in stages.zip(tangents.iter_mut().zip(&mut multipliers[1..]))
    {
        let (next, reached, distance) = curve.project(tangent, margin(stage, x));
        *tangent = next;
        *alpha = reached;
        worst = worst.max(distance);
    }
    worst
}

/// `D_k`.
fn margin(stage: &LightStage, x: &[f64; 3]) -> f64 {
    dot(&stage.gradient, x) + stage.offset
}
