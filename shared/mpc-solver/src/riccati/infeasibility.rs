//! Proof that no input satisfies the hard constraints.
//!
//! Multipliers combine the constraints into one function. They are `μ ≥ 0` of the hard rows, `α ≥ 0` of a hard light,
//! and `y` of the terminal equality. It is affine in the inputs and not positive wherever all constraints hold:
//!
//! ```text
//! f(u) = Σ μ_{j,k}(g_j'x_k − h_{j,k}) − Σ α_k D_k + y'(x_N − x_f)
//! ```
//!
//! One backward sweep gives its gradient; its minimum over the box of the inputs follows bound by
//! bound. A positive minimum is the proof. It holds for any multipliers, from any source.

use crate::kkt::Multipliers;
use crate::problem::{Problem, Softness, Terminal, dot};

/// Fraction of the summed magnitudes that the minimum must exceed; it is far above their rounding.
const MARGIN: f64 = 1e-9;

/// Returns whether `multipliers` prove that no input satisfies the hard constraints of `problem`.
pub(super) fn is_proved(problem: &Problem, multipliers: &Multipliers) -> bool {
    let n = problem.horizon;
    let a = &problem.a;
    let mut costate = [0.0; 3];
    let mut least = 0.0;
    let mut magnitude = 0.0;
    let mut add = |value: f64| {
        least += value;
        magnitude += value.abs();
    };
    if let Terminal::Equality(x_f) = &problem.terminal {
        costate = multipliers.terminal;
        add(-dot(&costate, x_f));
    }
    let hard_light = problem.light.is_some_and(|light| light.softness == Softness::Hard);
    for k in (0..n).rev() {
        // `costate` belongs to stage k + 1, whose constraints come first.
        for (j, row) in problem.rows.iter().enumerate() {
            let (mu, h) = (multipliers.rows[j][k + 1].max(0.0), problem.limits[j][k + 1]);
            let in_force = k + 1 >= row.from && k < row.to && h < f64::INFINITY;
            if in_force && row.softness == Softness::Hard {
                add(-mu * h);
                for i in 0..3 {
                    costate[i] += mu * row.gradient[i];
                }
            }
        }
        if hard_light && k < problem.light_len {
            let (stage, alpha) = (&problem.light_stages[k], multipliers.light[k + 1].max(0.0));
            add(-alpha * stage.offset);
            for i in 0..3 {
                costate[i] -= alpha * stage.gradient[i];
            }
        }
        add(dot(&costate, &problem.d[k]));
        let slope = dot(&costate, &problem.b);
        add((slope * problem.u_min).min(slope * problem.u_max));
        costate = [
            a[0][0] * costate[0],
            a[0][1] * costate[0] + a[1][1] * costate[1],
            a[0][2] * costate[0] + a[1][2] * costate[1] + a[2][2] * costate[2],
        ];
    }
    for i in 0..3 {
        add(costate[i] * problem.x0[i]);
    }
    magnitude.is_finite() && least > MARGIN * magnitude
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LightCost, LightStage};

    /// A position that can change by some metres, and a light that has its hard margin beyond `from_m` in some stages.
    fn problem() -> Problem {
        let light = LightCost { weight: 1.0, threshold: 1.0, softness: Softness::Hard };
        Problem::builder(4)
            .dynamics([[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [0.0, 0.0, 0.5]], [0.0, 0.0, 0.5])
            .input_bounds(-1.0, 1.0)
            .input_cost(1.0)
            .light(light)
            .build()
            .expect("a convex problem")
    }

    fn beyond(from_m: f64) -> LightStage {
        LightStage { gradient: [1.0, 0.0, 0.0], offset: -from_m }
    }

    /// Multipliers of 1 at one stage of the light.
    fn of_stage(stage: usize) -> Multipliers {
        let mut multipliers = Multipliers::new(4);
        multipliers.light[stage] = 1.0;
        multipliers
    }

    #[test]
    fn a_margin_that_no_input_reaches_is_proved_infeasible() {
        let mut problem = problem();
        // The bounded input moves the position by 0.5 m until the third stage, by 1.75 m until the fourth.
        problem.set_light([beyond(-9.0), beyond(-9.0), beyond(0.6), beyond(0.6)]);
        for (stage, expected) in [(1, false), (2, false), (3, true), (4, false)] {
            assert_eq!(is_proved(&problem, &of_stage(stage)), expected, "{stage}");
        }
    }

    #[test]
    fn stages_beyond_the_lights_end_prove_nothing() {
        let mut problem = problem();
        problem.set_light([beyond(-9.0), beyond(99.0)]);
        assert!(is_proved(&problem, &of_stage(2)));
        problem.set_light([beyond(-9.0)]);
        assert!(!is_proved(&problem, &of_stage(2)));
    }
}
