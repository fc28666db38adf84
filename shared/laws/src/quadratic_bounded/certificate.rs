//! Proof, by Cholesky, that a design keeps its guarantee.
//!
//! With the closed loop of rule i, z = [x; xc],
//!
//! ```text
//! z+ = Phi_i z + G_i w,  Phi_i = [[A_i + B Fy C, B Fx], [L_i C, Ac_i]],  G_i = [[E + B Fy D], [L_i D]]
//! ```
//!
//! the ellipsoid V = z' P z <= 1 cannot be left for any |w_j| <= wbar_j, if multipliers a_j > 0 with sum a_j <= alpha
//! exist so that
//!
//! ```text
//! diag((1 - alpha) P, diag(a_j / wbar_j²)) - [Phi_i G_i]' P [Phi_i G_i] >= 0.
//! ```
//!
//! The blend of the rules is covered too. B, C and D are common, so z+ is the same blend of the rules' results, and V
//! is convex. Within the ellipsoid |c z| <= sqrt(c P^-1 c'), which bounds every index.

use super::model::{DISTURBANCES, Parameters, RULES, STATES, State, StateMatrix};
use nalgebra::{SMatrix, SVector};
use serde::{Deserialize, Deserializer};
use thiserror::Error;

/// The conditions of a certificate, in the words of its errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Condition {
    #[error("P is symmetric")]
    Symmetric,
    #[error("multipliers are positive and sum to at most alpha < 1")]
    Multipliers,
    #[error("P is positive definite")]
    PositiveDefinite,
    #[error("the ellipsoid is invariant (quadratic boundedness)")]
    Invariance,
    #[error("gap error rate within its bound")]
    GapErrorRate,
    #[error("increment within its bound")]
    Increment,
    #[error("gap error within its bound")]
    GapError,
    #[error("speed error within its bound")]
    SpeedError,
    #[error("acceleration within its bound")]
    Acceleration,
    #[error("request within its bound")]
    Request,
    #[error("start states inside the ellipsoid")]
    StartSet,
}

/// A condition that does not hold.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[error(
    "condition not met: {condition}{} (found {value:.6e}, limit {bound:.6e})",
    rule.map_or_else(String::new, |rule| format!(", rule {rule}"))
)]
pub struct Failure {
    pub condition: Condition,
    /// Number of the rule, 1 or 2, where the condition is one of a rule.
    pub rule: Option<usize>,
    /// Found value: that of the index, or the least scaled pivot.
    pub value: f64,
    pub bound: f64,
}

/// Numbers of a design, before verification.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Content {
    /// Purpose of the design.
    pub parameters: Parameters,
    /// Rate of contraction.
    pub alpha: f64,
    /// Multipliers of the disturbances, a.
    pub multipliers: [f64; DISTURBANCES],
    /// P of the ellipsoid.
    #[serde(deserialize_with = "rows")]
    pub p: ClosedMatrix,
    /// Gains of the two rules.
    pub rules: [Gains; RULES],
}

/// Gains of one rule: xc+ = Ac xc + L y, Du = Fx xc + Fy y.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gains {
    /// Ac, 4 by 4.
    #[serde(deserialize_with = "rows")]
    pub ac: StateMatrix,
    /// L, 4 by 4.
    #[serde(deserialize_with = "rows")]
    pub l: StateMatrix,
    /// Fx, as a column.
    #[serde(deserialize_with = "column")]
    pub fx: State,
    /// Fy, as a column.
    #[serde(deserialize_with = "column")]
    pub fy: State,
}

fn rows<'de, D: Deserializer<'de>, const N: usize>(text: D) -> Result<SMatrix<f64, N, N>, D::Error>
where
    [[f64; N]; N]: Deserialize<'de>,
{
    Ok(SMatrix::<f64, N, N>::from(<[[f64; N]; N]>::deserialize(text)?).transpose())
}

fn column<'de, D: Deserializer<'de>>(text: D) -> Result<State, D::Error> {
    Ok(State::from(<[f64; STATES]>::deserialize(text)?))
}

/// States of model and controller together.
pub(super) const CLOSED: usize = 2 * STATES;
const AUGMENTED: usize = CLOSED + DISTURBANCES;

/// z = [x; xc].
pub type ClosedState = SVector<f64, CLOSED>;
/// A square matrix over z, such as P.
pub type ClosedMatrix = SMatrix<f64, CLOSED, CLOSED>;

/// Smallest pivot of a matrix scaled to a unit diagonal that counts as positive. It is a hundred
/// times the rounding of a 12 by 12 matrix.
const LEAST_PIVOT: f64 = 1e-12;
/// Relative slack on the bounds of the indices, for rounding only.
const SLACK: f64 = 1.0 + 1e-9;

/// A design whose certificate has been verified: there is no other way to have one.
#[derive(Clone, Debug, PartialEq)]
pub struct Design {
    pub(super) content: Content,
    /// xc = reset x minimises V over xc (it is U' X^-1).
    pub(super) reset: StateMatrix,
    /// X^-1, the Schur complement of P: V with the best xc is x' X^-1 x.
    pub(super) x_inverse: StateMatrix,
}

/// Checks every condition; the first that fails is the error.
pub(super) fn verify(content: Content) -> Result<Design, Failure> {
    let Content { parameters, p, rules, .. } = &content;
    let fail = |condition, rule: Option<usize>, value: f64, bound: f64| {
        Err(Failure { condition, rule: rule.map(|i| i + 1), value, bound })
    };
    for i in 0..CLOSED {
        for j in 0..i {
            if p[(i, j)] != p[(j, i)] {
                return fail(Condition::Symmetric, None, (p[(i, j)] - p[(j, i)]).abs(), 0.0);
            }
        }
    }
    let alpha = content.alpha;
    if !(alpha > 0.0 && alpha < 1.0) {
        return fail(Condition::Multipliers, None, alpha, 1.0);
    }
    let least = content.multipliers.iter().copied().fold(f64::INFINITY, f64::min);
    let sum: f64 = content.multipliers.iter().sum();
    if !(least > 0.0 && sum <= alpha) {
        return fail(Condition::Multipliers, None, if least > 0.0 { sum } else { least }, alpha);
    }
    let Some(inverse) = inverse(p) else {
        return fail(Condition::PositiveDefinite, None, f64::NAN, 0.0);
    };
    let reach = |row: &ClosedState| (row.transpose() * inverse * row)[(0, 0)].max(0.0).sqrt();

    for (i, rho) in parameters.rule_derivatives_s().into_iter().enumerate() {
        let (phi, g) = closed_loop(parameters, rho, &rules[i]);
        let margin = invariance_margin(&content, &phi, &g);
        if margin.is_nan() || margin <= LEAST_PIVOT {
            return fail(Condition::Invariance, Some(i), margin, LEAST_PIVOT);
        }
        let rate = reach(&extended(&parameters.gap_error_rate_row(rho), &State::zeros()));
        let bound = parameters.gap_error_rate_bound_mps;
        if rate.is_nan() || rate > bound * SLACK {
            return fail(Condition::GapErrorRate, Some(i), rate, bound);
        }
        let increment = reach(&extended(&rules[i].fy, &rules[i].fx))
            + noise_on_increment(parameters, &rules[i].fy);
        let bound = parameters.increment_bound_mps2;
        if increment.is_nan() || increment > bound * SLACK {
            return fail(Condition::Increment, Some(i), increment, bound);
        }
    }
    let states =
        [Condition::GapError, Condition::SpeedError, Condition::Acceleration, Condition::Request];
    for (j, bound) in parameters.state_bounds().into_iter().enumerate() {
        let value = inverse[(j, j)].sqrt();
        if value > bound * SLACK {
            return fail(states[j], None, value, bound);
        }
    }
    let Some((reset, x_inverse)) = best_controller_state(p) else {
        return fail(Condition::PositiveDefinite, None, f64::NAN, 0.0);
    };
    for start in &parameters.start_set {
        let x = State::from_column_slice(start);
        let v = (x.transpose() * x_inverse * x)[(0, 0)];
        if v.is_nan() || v > SLACK {
            return fail(Condition::StartSet, None, v, 1.0);
        }
    }
    Ok(Design { content, reset, x_inverse })
}

/// Phi_i and G_i.
pub fn closed_loop(
    parameters: &Parameters,
    rho: f64,
    gains: &Gains,
) -> (ClosedMatrix, SMatrix<f64, CLOSED, DISTURBANCES>) {
    let b = parameters.input();
    let d = parameters.measurement_noise();
    let mut phi = ClosedMatrix::zeros();
    let a = parameters.transition(rho) + b * gains.fy.transpose();
    phi.fixed_view_mut::<STATES, STATES>(0, 0).copy_from(&a);
    phi.fixed_view_mut::<STATES, STATES>(0, STATES).copy_from(&(b * gains.fx.transpose()));
    phi.fixed_view_mut::<STATES, STATES>(STATES, 0).copy_from(&gains.l);
    phi.fixed_view_mut::<STATES, STATES>(STATES, STATES).copy_from(&gains.ac);
    let mut g = SMatrix::<f64, CLOSED, DISTURBANCES>::zeros();
    let upper = parameters.disturbance() + b * (gains.fy.transpose() * d);
    g.fixed_view_mut::<STATES, DISTURBANCES>(0, 0).copy_from(&upper);
    g.fixed_view_mut::<STATES, DISTURBANCES>(STATES, 0).copy_from(&(gains.l * d));
    (phi, g)
}

/// Least pivot of the invariance condition, scaled; positive where it holds, NaN or not positive
/// where it does not.
fn invariance_margin(
    content: &Content,
    phi: &ClosedMatrix,
    g: &SMatrix<f64, CLOSED, DISTURBANCES>,
) -> f64 {
    let mut f = SMatrix::<f64, CLOSED, AUGMENTED>::zeros();
    f.fixed_view_mut::<CLOSED, CLOSED>(0, 0).copy_from(phi);
    f.fixed_view_mut::<CLOSED, DISTURBANCES>(0, CLOSED).copy_from(g);
    let mut w = SMatrix::<f64, AUGMENTED, AUGMENTED>::zeros();
    w.fixed_view_mut::<CLOSED, CLOSED>(0, 0).copy_from(&((1.0 - content.alpha) * content.p));
    let bounds = content.parameters.disturbance_bounds();
    for (j, (a, bound)) in content.multipliers.iter().zip(bounds).enumerate() {
        w[(CLOSED + j, CLOSED + j)] = a / (bound * bound);
    }
    let scale = w.diagonal().map(|v| 1.0 / v.sqrt());
    let m = w - f.transpose() * (content.p * f);
    factor(&scaled(&m, &scale)).1
}

/// Effect of the worst noise on one increment.
fn noise_on_increment(parameters: &Parameters, fy: &State) -> f64 {
    let row = fy.transpose() * parameters.measurement_noise();
    row.iter().zip(parameters.disturbance_bounds()).map(|(r, w)| r.abs() * w).sum()
}

/// [upper; lower].
pub(super) fn extended(upper: &State, lower: &State) -> ClosedState {
    ClosedState::from_fn(|i, _| if i < STATES { upper[i] } else { lower[i - STATES] })
}

/// reset = -P22^-1 P21 and X^-1 = P11 - P12 P22^-1 P21.
fn best_controller_state(p: &ClosedMatrix) -> Option<(StateMatrix, StateMatrix)> {
    let block = |i: usize, j: usize| p.fixed_view::<STATES, STATES>(i * STATES, j * STATES);
    let inverse: StateMatrix = inverse(&block(1, 1).into_owned())?;
    let reset = -(inverse * block(1, 0));
    Some((reset, block(0, 0) + block(0, 1) * reset))
}

/// Inverse of a positive definite matrix, after scaling to a unit diagonal; `None` if it is not.
fn inverse<const N: usize>(m: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    let scale = m.diagonal().map(|v| 1.0 / v.sqrt());
    let (l, least) = factor(&scaled(m, &scale));
    if least.is_nan() || least <= LEAST_PIVOT {
        return None;
    }
    // Columns of L^-1 by forward substitution; M^-1 = L^-T L^-1.
    let mut k = SMatrix::<f64, N, N>::zeros();
    for column in 0..N {
        for i in column..N {
            let known: f64 = (column..i).map(|j| l[(i, j)] * k[(j, column)]).sum();
            k[(i, column)] = (f64::from(u8::from(i == column)) - known) / l[(i, i)];
        }
    }
    Some(scaled(&(k.transpose() * k), &scale))
}

/// diag(scale) m diag(scale).
fn scaled<const N: usize>(m: &SMatrix<f64, N, N>, scale: &SVector<f64, N>) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| scale[i] * m[(i, j)] * scale[j])
}

/// Cholesky factor and its least pivot (squared diagonal). Stops at the first pivot that is not
/// positive, which is then returned, as is NaN.
fn factor<const N: usize>(m: &SMatrix<f64, N, N>) -> (SMatrix<f64, N, N>, f64) {
    let mut l = SMatrix::<f64, N, N>::zeros();
    let mut least = f64::INFINITY;
    for j in 0..N {
        let known: f64 = (0..j).map(|k| l[(j, k)] * l[(j, k)]).sum();
        let pivot = m[(j, j)] - known;
        if pivot.is_nan() || pivot <= 0.0 {
            return (l, pivot);
        }
        least = least.min(pivot);
        l[(j, j)] = pivot.sqrt();
        for i in j + 1..N {
            let known: f64 = (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum();
            l[(i, j)] = (m[(i, j)] - known) / l[(j, j)];
        }
    }
    (l, least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    #[test]
    fn cholesky_by_hand() {
        let m = Matrix3::new(4.0, 2.0, 0.0, 2.0, 5.0, 4.0, 0.0, 4.0, 6.0);
        let (l, least) = factor(&m);
        assert_eq!(l, Matrix3::new(2.0, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 2.0, 2f64.sqrt()));
        assert_eq!(least, 2.0);
        let product = inverse(&m).expect("positive definite") * m;
        assert!((product - Matrix3::identity()).norm() < 1e-14);
    }

    #[test]
    fn an_indefinite_matrix_has_no_inverse() {
        assert!(inverse(&Matrix3::new(1.0, 2.0, 0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 1.0)).is_none());
        assert!(inverse(&Matrix3::from_diagonal_element(-1.0)).is_none());
        assert!(inverse(&Matrix3::from_diagonal_element(f64::NAN)).is_none());
        assert!(inverse(&Matrix3::<f64>::zeros()).is_none());
    }
}
