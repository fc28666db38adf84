//! The light in the active-set method: tangents replace its curve, and each round renews them.

use multiversion::multiversion;

use crate::problem::{LightStage, Problem, dot};
use crate::riccati::lanes::{Lanes, WIDTH};
use crate::riccati::light_curve::{LightCurve, LightTangent};

/// Places the first tangents from the margins of a trajectory without the light.
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

/// Moves the tangents to where the last step led and writes the multipliers there. Returns the
/// largest relative distance from the curve.
#[multiversion(targets("x86_64+avx2"))]
pub(super) fn project(
    problem: &Problem,
    curve: &LightCurve,
    states: &[[f64; 3]],
    tangents: &mut [LightTangent],
    multipliers: &mut [f64],
) -> f64 {
    let lights = problem.light_stages();
    let (states, tangents) = (&states[1..=lights.len()], &mut tangents[..lights.len()]);
    let alphas = &mut multipliers[1..=lights.len()];
    let whole = lights.len() - lights.len() % WIDTH;
    let mut worst = Lanes::all(0.0);
    for first in (0..whole).step_by(WIDTH) {
        let piece = first..first + WIDTH;
        let mut margins = [0.0; WIDTH];
        for (i, slot) in margins.iter_mut().enumerate() {
            *slot = margin(&lights[first + i], &states[first + i]);
        }
        let neighbours: Option<&mut [LightTangent; WIDTH]> = tangents[piece].first_chunk_mut();
        let Some(neighbours) = neighbours else { break };
        if let Some((reached, distances)) = curve.project_on_hyperbola(neighbours, Lanes(margins)) {
            for (i, alpha) in reached.0.iter().enumerate() {
                alphas[first + i] = *alpha;
            }
            worst = distances.greater(worst);
        } else {
            for (i, margin) in margins.iter().enumerate() {
                let (next, reached, distance) = curve.project(&tangents[first + i], *margin);
                tangents[first + i] = next;
                alphas[first + i] = reached;
                worst = Lanes::all(distance).greater(worst);
            }
        }
    }
    for k in whole..lights.len() {
        let (next, reached, distance) = curve.project(&tangents[k], margin(&lights[k], &states[k]));
        tangents[k] = next;
        alphas[k] = reached;
        worst = Lanes::all(distance).greater(worst);
    }
    worst.largest()
}

/// `D_k`.
fn margin(stage: &LightStage, x: &[f64; 3]) -> f64 {
    dot(&stage.gradient, x) + stage.offset
}
