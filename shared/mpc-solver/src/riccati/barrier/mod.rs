//! The inequalities of the interior point, family by family, and the compliances they make.
//!
//! Every inequality is a pair of a slack and a multiplier ([`pairs`]). Written with the new values
//! (marked ⁺), the pairs of one stage and their local variables boil down to one force on one linear
//! function `y` of the state or input, `force⁺ = W y⁺ + m`; everything else follows from `y⁺` once the sweep
//! has found it. With `C = 1/W`
//!
//! ```text
//! input   W = λ_l/s_l + λ_u/s_u            s_l = u − u_min,   s_u = u_max − u
//! row     C = s/μ                          hard:  s = h − z
//!         C = s/μ + σ/(ν + κσ)             soft:  s = h + σ − z,   ν = λ + κσ − μ
//! light   C = s/α + 1/(H + β/(d_th − p))   hard:  s = D − p,       w/p² = α + β
//!         … + σ/(λ − α)                    soft:  s = D + σ − p
//! ```
//!
//! `H = 2(α + β)/p` is the primal-dual form of the curvature `2w/p³`. Rows and light also get a small constant
//! compliance, [`PROXIMAL`]: it moves the limit by `PROXIMAL (μ⁺ − μ)`, which vanishes as the multiplier settles, and
//! keeps `W` from outgrowing the machine's precision while the slack of an active limit goes to zero.

pub(super) mod input;
pub(super) mod light;
pub(super) mod pairs;
pub(super) mod row;

/// Compliance of the proximal term, unit of the limit per unit of its multiplier.
const PROXIMAL: f64 = 1e-12;
